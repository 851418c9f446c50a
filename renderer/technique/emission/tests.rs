use std::f64::consts::PI;

use glam::Quat;

use super::*;
use crate::scene::shapes::{Face, cuboid, cylinder, plane, sphere};
use crate::scene::{FilmSettings, Instance, Light, Material, Mesh, Surface, ToneCurve};

const TARGET: usize = 4096;
const RAYS: usize = 100_000;
/// Sums of thousands of cells with f32 edges, added up in f64 and rounded to f32.
const ROUNDED: f64 = 1e-5;

const MIRROR: usize = 0;
const DIFFUSE: usize = 1;

fn scene(objects: Vec<(Mesh, Affine3A, usize)>, emitters: &[Emitter]) -> Scene {
    let material = |name: &str, surface| Material { name: name.into(), surface };
    let instance = |mesh: usize, transform, material| Instance { name: mesh.to_string(), mesh, material, transform };
    let light = |emitter: &Emitter| Light { name: "light".into(), emitter: emitter.clone(), medium: 0 };
    let white = Vec3::ONE;
    Scene {
        path: "test.toml".into(),
        film: FilmSettings {
            width: 1,
            height: 1,
            samples: 1,
            exposure: 0.0,
            tone_curve: ToneCurve::Linear,
            background: Vec3::ZERO,
            volume_samples: 1,
        },
        cameras: Vec::new(),
        instances: objects.iter().enumerate().map(|(i, object)| instance(i, object.1, object.2)).collect(),
        meshes: objects.into_iter().map(|object| object.0).collect(),
        materials: vec![
            material("mirror", Surface::Mirror { reflectance: white }),
            material("white", Surface::Diffuse { albedo: white, texture: None }),
        ],
        textures: Vec::new(),
        densities: Vec::new(),
        media: Vec::new(),
        lights: emitters.iter().map(light).collect(),
        animation: Default::default(),
        settings: Vec::new(),
        warnings: Vec::new(),
    }
}

fn still(mesh: Mesh) -> (Mesh, Affine3A, usize) {
    (mesh, Affine3A::IDENTITY, MIRROR)
}

fn water(height: f64) -> Mesh {
    plane("water", DVec3::new(0.0, height, 0.0), DVec2::new(4.0, 3.0), [1, 1])
}

fn ball(x: f64, y: f64, z: f64, radius: f64) -> Mesh {
    sphere("ball", DVec3::new(x, y, z), radius, 64)
}

fn one_triangle(corners: [Vec3; 3]) -> Mesh {
    Mesh { positions: corners.to_vec(), triangles: vec![[0, 1, 2]], ..Mesh::default() }
}

fn point(x: f32, y: f32, z: f32) -> Emitter {
    Emitter::Point { position: Vec3::new(x, y, z), intensity: Vec3::ONE }
}

fn spot(position: Vec3, direction: Vec3, inner: f32, outer: f32) -> Emitter {
    Emitter::Spot { position, direction: direction.normalize(), intensity: Vec3::ONE, inner, outer, image: None }
}

fn sun(direction: Vec3) -> Emitter {
    Emitter::Directional { direction: direction.normalize(), irradiance: Vec3::ONE }
}

fn flux_of(scene: &Scene) -> f64 {
    f64::from(emission(scene, TARGET).flux[0].x)
}

/// Uniform in [0, 1): the 53 high bits of a 64-bit linear congruential sequence, scrambled.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mixed = (self.0 ^ (self.0 >> 29)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        ((mixed ^ (mixed >> 32)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// The documented table, spelled out.
const FACES: [[DVec3; 3]; 6] = [
    [DVec3::X, DVec3::Y, DVec3::Z],
    [DVec3::NEG_X, DVec3::Z, DVec3::Y],
    [DVec3::Y, DVec3::Z, DVec3::X],
    [DVec3::NEG_Y, DVec3::X, DVec3::Z],
    [DVec3::Z, DVec3::X, DVec3::Y],
    [DVec3::NEG_Z, DVec3::Y, DVec3::X],
];

/// Whether `cells` hold the line from the light to `target`.
fn is_covered(cells: &[EmissionCell], emitter: &Emitter, target: DVec3) -> bool {
    let holds = |cell: &EmissionCell, u: f64, v: f64| {
        let within = |at: f64, axis: usize| {
            let lower = f64::from(cell.lower[axis]);
            (lower..=lower + f64::from(cell.size[axis])).contains(&at)
        };
        within(u, 0) && within(v, 1)
    };
    match *emitter {
        Emitter::Directional { direction, .. } => {
            let [u, v] = chart::plane_basis(direction.as_dvec3());
            cells.iter().any(|cell| cell.face == 6 && holds(cell, target.dot(u), target.dot(v)))
        }
        Emitter::Point { position, .. } | Emitter::Spot { position, .. } => {
            let direction = target - position.as_dvec3();
            let through = |face: usize| {
                let [axis, u, v] = FACES[face];
                let depth = direction.dot(axis);
                (depth > 0.0).then(|| (face as u32, direction.dot(u) / depth, direction.dot(v) / depth))
            };
            let seen: Vec<_> =
                (0..6).filter_map(through).filter(|(_, u, v)| u.abs() <= 1.0 && v.abs() <= 1.0).collect();
            cells.iter().any(|cell| seen.iter().any(|&(face, u, v)| cell.face == face && holds(cell, u, v)))
        }
    }
}

fn is_lit(emitter: &Emitter, target: DVec3) -> bool {
    match *emitter {
        Emitter::Spot { position, direction, outer, .. } => {
            (target - position.as_dvec3()).angle_between(direction.as_dvec3()) < f64::from(outer)
        }
        _ => true,
    }
}

/// Every line from a light to a random point of a specular triangle passes through a cell of that light.
fn assert_covers(name: &str, scene: &Scene, target_cells: usize) {
    let emission = emission(scene, target_cells);
    // In f32, as the device places them.
    let corners = |instance: &Instance| {
        let (mesh, to_world) = (&scene.meshes[instance.mesh], instance.transform);
        let place = move |vertex: u32| to_world.transform_point3(mesh.positions[vertex as usize]).as_dvec3();
        mesh.triangles.iter().map(move |triangle| triangle.map(place)).collect::<Vec<_>>()
    };
    let all: Vec<_> = scene.instances.iter().filter(|i| i.material == MIRROR).flat_map(corners).collect();
    let mut random = Random(7);
    for (index, light) in scene.lights.iter().enumerate() {
        let cells: Vec<_> = emission.cells.iter().copied().filter(|cell| cell.light == index as u32).collect();
        let mut lit = 0;
        for _ in 0..RAYS / scene.lights.len() {
            let [a, b, c] = all[(random.next() * all.len() as f64) as usize];
            let (s, t) = (random.next(), random.next());
            let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
            let target = a + s * (b - a) + t * (c - a);
            if is_lit(&light.emitter, target) {
                lit += 1;
                assert!(is_covered(&cells, &light.emitter, target), "{name}: light {index} misses {target}");
            }
        }
        assert!(lit > 0, "{name}: nothing was checked");
    }
}

#[test]
fn faces_are_the_documented_ones_and_right_handed() {
    for (face, expected) in FACES.into_iter().enumerate() {
        let [axis, u, v] = chart::axes(face);
        assert_eq!([axis, u, v], expected);
        assert_eq!(u.cross(v), axis);
    }
    for direction in [DVec3::Y, DVec3::NEG_Z, DVec3::Z, DVec3::new(0.6, -0.48, -0.64), DVec3::new(0.0, -0.8, 0.6)] {
        let [u, v] = chart::plane_basis(direction);
        assert!(u.cross(v).distance(direction) < 1e-12 && u.dot(v).abs() < 1e-12, "{direction}");
    }
}

#[test]
fn solid_angles_are_exact_at_every_size() {
    let face = solid_angle(DVec2::NEG_ONE, DVec2::splat(2.0));
    assert!((6.0 * face - 4.0 * PI).abs() < 1e-12);
    // du dv / (1 + u^2 + v^2)^1.5 in the middle, off by the square of the size.
    for size in [1e-2, 1e-4, 1e-7] {
        let (lower, size) = (DVec2::new(0.3, -0.9), DVec2::new(size, 0.5 * size));
        let expected = size.element_product() * (1.0 + (lower + 0.5 * size).length_squared()).powf(-1.5);
        let ratio = solid_angle(lower, size) / expected;
        assert!((ratio - 1.0).abs() < size.x * size.x + 1e-7, "{size}: {ratio}");
    }
}

#[test]
fn every_line_to_a_specular_triangle_passes_through_a_cell() {
    let down = Vec3::new(0.2, -1.0, 0.1);
    let turned =
        Affine3A::from_scale_rotation_translation(Vec3::new(-1.0, 0.5, 2.0), Quat::from_rotation_z(0.7), Vec3::ONE);
    let two_balls = vec![still(ball(1.0, 0.0, 0.0, 0.3)), still(ball(-2.0, 1.0, 2.0, 0.8))];
    let room = cuboid("room", DVec3::ZERO, DVec3::new(3.0, 2.0, 5.0), &Face::ALL.map(|(_, face)| face), true);
    let cup = (cylinder("cup", DVec3::ZERO, 0.5, 1.0, 90, 3), turned, MIRROR);
    let scenes = [
        ("pool", scene(vec![still(water(0.0))], &[point(0.3, 2.0, -0.1)])),
        ("light just above the water", scene(vec![still(water(0.0))], &[point(0.3, 0.01, -0.1)])),
        ("border of a face", scene(vec![still(water(0.0))], &[point(0.0, 1.5, 0.0)])),
        ("far ball", scene(vec![still(ball(300.0, 120.0, -40.0, 0.5))], &[point(0.0, 0.0, 0.0)])),
        ("ball in the corner of a face", scene(vec![still(ball(2.0, 2.0, 2.0, 0.5))], &[point(0.0, 0.0, 0.0)])),
        ("inside a ball", scene(vec![still(ball(0.0, 0.0, 0.0, 2.0))], &[point(0.5, 0.1, 0.0)])),
        ("inside a room", scene(vec![still(room)], &[point(0.0, 0.5, 1.0)])),
        ("two balls and two lights", scene(two_balls.clone(), &[point(0.0, 3.0, 0.0), point(5.0, 0.0, 1.0)])),
        ("mirrored and turned cup", scene(vec![cup.clone()], &[point(0.0, 4.0, 0.5), sun(down)])),
        ("spot", scene(vec![still(water(0.0))], &[spot(Vec3::new(0.0, 2.0, 0.0), down, 0.2, 0.5)])),
        (
            "wide spot",
            scene(two_balls.clone(), &[spot(Vec3::new(0.0, 3.0, 0.0), down, 0.3, std::f32::consts::FRAC_PI_2)]),
        ),
        ("sun", scene(two_balls, &[sun(down), sun(Vec3::NEG_Z), sun(Vec3::new(-1.0, 0.0, 0.0))])),
        ("grazing sun", scene(vec![still(water(0.0))], &[sun(Vec3::new(1.0, -1e-4, 0.3))])),
    ];
    for (name, scene) in &scenes {
        assert_covers(name, scene, 512);
    }
}

#[test]
fn a_light_in_the_plane_of_a_triangle_or_on_it_is_covered() {
    let corners = [Vec3::new(1.0, 0.0, 0.0), Vec3::new(3.0, 0.0, 1.0), Vec3::new(1.0, 0.0, 2.0)];
    let upright = [Vec3::new(1.0, 0.0, 1.0), Vec3::new(1.0, 3.0, 1.0), Vec3::new(2.0, 0.0, 2.0)];
    let edge_on = scene(vec![still(one_triangle(corners))], &[point(0.0, 0.0, 0.0)]);
    assert_covers("in the plane", &edge_on, 512);
    assert_covers(
        "on the border of two faces",
        &scene(vec![still(one_triangle(upright))], &[point(0.0, 0.0, 0.0)]),
        512,
    );
    let edge_on_sun = scene(vec![still(one_triangle(corners))], &[sun(Vec3::X)]);
    assert_covers("along the plane", &edge_on_sun, 512);

    // Photons may then leave in any direction.
    for on_it in [point(2.0, 0.0, 1.0), point(1.0, 0.0, 0.0), point(1.0, 0.0, 1.0)] {
        let flux = flux_of(&scene(vec![still(one_triangle(corners))], &[on_it]));
        assert!((flux / (4.0 * PI) - 1.0).abs() < ROUNDED, "{flux}");
    }
}

#[test]
fn a_far_ball_is_fitted_closely() {
    // A circle of N cells has about 2 sqrt(16 N / pi) / pi of its border's cells outside: 3.6 % for 4096.
    const EXCESS: f64 = 0.06;
    for (distance, radius) in [(3.0, 1.0), (100.0, 0.5), (2000.0, 0.2)] {
        let position = distance * DVec3::new(0.48, 0.6, -0.64);
        let emission = emission(
            &scene(vec![still(ball(position.x, position.y, position.z, radius))], &[point(0.0, 0.0, 0.0)]),
            TARGET,
        );
        let cone = 2.0 * PI * (1.0 - (1.0 - (radius / distance).powi(2)).sqrt());
        let ratio = f64::from(emission.flux[0].x) / cone;
        // The mesh of 64 segments lies inside the sphere.
        assert!((0.99..1.0 + EXCESS).contains(&ratio), "at {distance} m: {ratio}");
    }
    let sphere = scene(vec![still(ball(3.0, 1.0, 2.0, 0.5))], &[sun(Vec3::new(0.3, -0.8, 0.5))]);
    let ratio = flux_of(&sphere) / (PI * 0.25);
    assert!((0.99..1.0 + EXCESS).contains(&ratio), "directional: {ratio}");
}

#[test]
fn a_large_triangle_does_not_fill_its_box() {
    // Its long side crosses about 2 sqrt(2 * 4096) = 180 of 4096 cells, half of each outside.
    const EXCESS: f64 = 0.03;
    let corners = [Vec3::new(-2.0, 0.0, -2.0), Vec3::new(2.0, 0.0, 1.0), Vec3::new(2.0, 0.0, -2.0)];
    let ratio = flux_of(&scene(vec![still(one_triangle(corners))], &[sun(Vec3::NEG_Y)])) / 6.0;
    assert!((1.0..1.0 + EXCESS).contains(&ratio), "{ratio}");
}

#[test]
fn cells_come_near_the_number_asked_for_and_are_shared_by_flux() {
    const NEAR: f64 = 0.15;
    let near = |count: usize, target: f64| (count as f64 / target - 1.0).abs() < NEAR;
    for objects in [vec![still(water(0.0))], vec![still(ball(0.0, 0.0, 0.0, 1.0)), still(ball(3.0, 1.0, 0.0, 0.2))]] {
        for target in [64, 1024, 16_384] {
            let cells = emission(&scene(objects.clone(), &[point(0.1, 2.0, 0.2)]), target).cells.len();
            assert!(near(cells, target as f64), "{cells} of {target}");
        }
    }
    let dim = Emitter::Directional { direction: Vec3::NEG_Y, irradiance: Vec3::splat(0.25) };
    let lights =
        [sun(Vec3::NEG_Y), dim, Emitter::Directional { direction: Vec3::NEG_Y, irradiance: Vec3::splat(1e-9) }];
    let emission = emission(&scene(vec![still(water(0.0))], &lights), TARGET);
    let count = |light: u32| emission.cells.iter().filter(|cell| cell.light == light).count();
    assert!(near(count(0), 0.8 * TARGET as f64) && near(count(1), 0.2 * TARGET as f64), "{} {}", count(0), count(1));
    assert!((9..32).contains(&count(2)), "{}", count(2));
}

#[test]
fn flux_has_its_closed_form() {
    // All around.
    let bright = Emitter::Point { position: Vec3::ZERO, intensity: Vec3::new(1.0, 2.0, 0.5) };
    let flux = emission(&scene(vec![still(ball(0.0, 0.0, 0.0, 1.0))], &[bright]), TARGET).flux[0];
    assert!(flux.abs_diff_eq(4.0 * PI as f32 * Vec3::new(1.0, 2.0, 0.5), 1e-4), "{flux}");
    // A smoothstep from 0 to 1 integrates to half of its length. Midpoints of a hard edge leave a few parts in 1e4.
    const QUADRATURE: f64 = 1e-3;
    for (inner, outer) in [(0.4_f32, 0.4_f32), (0.2, 0.5), (0.0, 1.2), (1.0, std::f32::consts::FRAC_PI_2)] {
        let light = spot(Vec3::new(0.1, 0.0, 0.2), Vec3::new(0.3, -1.0, 0.5), inner, outer);
        let flux = flux_of(&scene(vec![still(ball(0.0, 0.0, 0.0, 1.0))], &[light]));
        let expected = PI * (2.0 - f64::from(inner).cos() - f64::from(outer).cos());
        assert!((flux / expected - 1.0).abs() < QUADRATURE, "{inner} {outer}: {flux} {expected}");
    }
    // 1 W/m2 on 4 m by 3 m, seen under 60 degrees.
    let slanted = sun(Vec3::new(0.75_f32.sqrt(), -0.5, 0.0));
    let flux = flux_of(&scene(vec![still(water(0.0))], &[slanted]));
    assert!((flux / 6.0 - 1.0).abs() < 0.05, "{flux}");
    let flux = flux_of(&scene(vec![still(water(0.0))], &[sun(Vec3::NEG_Y)]));
    assert!((flux / 12.0 - 1.0).abs() < ROUNDED, "{flux}");
}

#[test]
fn a_spot_light_keeps_to_its_cone() {
    let (inner, outer) = (0.1, 0.15);
    let light = spot(Vec3::new(0.0, 2.0, 0.0), Vec3::new(0.1, -1.0, 0.05), inner, outer);
    let cone = 2.0 * PI * (1.0 - f64::from(outer).cos());
    for quads in [1, 100] {
        let water = plane("water", DVec3::ZERO, DVec2::new(4.0, 3.0), [quads, quads]);
        let emission = emission(&scene(vec![still(water)], std::slice::from_ref(&light)), TARGET);
        let solid: f64 = emission.cells.iter().map(|c| solid_angle(as_f64(c.lower), as_f64(c.size))).sum();
        assert!((1.0..1.06).contains(&(solid / cone)), "{quads}: {}", solid / cone);
    }
}

fn as_f64(pair: [f32; 2]) -> DVec2 {
    DVec2::from(pair.map(f64::from))
}

#[test]
fn photons_of_a_directional_light_start_upstream_of_everything() {
    let tower = (ball(0.0, 40.0, 0.0, 1.0), Affine3A::IDENTITY, DIFFUSE);
    let direction = Vec3::new(0.1, -1.0, 0.2).normalize();
    let scene = scene(vec![still(water(0.0)), tower], &[sun(direction)]);
    let highest = scene.meshes.iter().flat_map(|mesh| &mesh.positions).map(|p| p.dot(direction)).fold(0.0, f32::min);
    let cells = emission(&scene, 64).cells;
    assert!(!cells.is_empty() && cells.iter().all(|cell| cell.face == 6 && cell.offset < highest));
}

#[test]
fn without_specular_objects_or_light_there_are_no_cells() {
    let diffuse = vec![(water(0.0), Affine3A::IDENTITY, DIFFUSE)];
    let empty = emission(&scene(diffuse, &[point(0.0, 1.0, 0.0)]), TARGET);
    assert_eq!(empty, Emission { cells: Vec::new(), flux: vec![Vec3::ZERO] });

    let dark = Emitter::Point { position: Vec3::Y, intensity: Vec3::ZERO };
    let away = spot(Vec3::Y, Vec3::Y, 0.3, 0.6);
    let empty = emission(&scene(vec![still(water(0.0))], &[dark, away]), TARGET);
    assert_eq!(empty, Emission { cells: Vec::new(), flux: vec![Vec3::ZERO; 2] });
    assert!(emission(&scene(vec![still(water(0.0))], &[]), TARGET).cells.is_empty());
}

#[test]
fn neighbours_in_memory_are_neighbours_in_direction() {
    // A run of 64 cells would be 64 cells long in rows, 8 where a curve fills squares.
    const LONGEST: f64 = 16.0;
    let cells = emission(&scene(vec![still(water(0.0))], &[sun(Vec3::NEG_Y)]), TARGET).cells;
    let runs = cells.chunks_exact(64);
    let count = runs.len() as f64;
    let mut mean = 0.0;
    for run in runs {
        let mut around = Rectangle::EMPTY;
        run.iter().for_each(|cell| around.include(as_f64(cell.lower)));
        mean += (around.extent() / as_f64(run[0].size)).max_element() / count;
    }
    assert!(mean < LONGEST, "{mean}");
}
