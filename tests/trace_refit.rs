//! Structures that have followed moving vertices and instances: what they answer, and that it depends on the scene as it
//! is, not on what was before.

mod common;
mod tracing;

use std::process::ExitCode;

use common::{Case, Request, assert_valid};
use glam::{Affine3A, DVec3, Quat, Vec3};
use nephroid::gpu::{Binding, Device};
use nephroid::gpu_scene::{GpuScene, Vertex};
use nephroid::scene::animation::{Water, WaterMotion};
use nephroid::scene::height_field::HeightField;
use nephroid::scene::{Mesh, Scene, shapes};
use nephroid::trace::{Backend, Following, Probe, ProbeHit, Ray, Tracer};
use tracing::{ANY_MASK, Random, hits, is_hit, mesh, random_rays, ray, scene, soup, water};

/// Per move of a scene.
const RAYS: usize = 8000;

/// At closed surfaces' edges.
const EDGE_RAYS: usize = 40_000;

/// Share of rays whose closest hit may be any of several triangles at the very same t: at edges, and where triangles
/// coincide.
const MOST_TIES: f64 = 0.01;

/// Share of rays that hit something, at least, for a comparison to say much.
const LEAST_HITS: f64 = 0.2;

/// Share of rays at edges that a driver's own ray queries may lose, as in `trace_watertight.rs`.
const RAY_QUERY_LEAKS: f64 = 0.05;

fn main() -> ExitCode {
    common::run(&[
        Case { name: "moved_structures_answer_as_new_ones", needs: &[], disable: "", run: moves },
        Case { name: "refitted_trees_are_what_the_host_packs", needs: &[], disable: "", run: packing },
        Case { name: "what_was_before_makes_no_difference", needs: &[], disable: "", run: history },
        Case { name: "refitted_surfaces_do_not_leak", needs: &[], disable: "", run: leaks },
        Case { name: "vertices_that_are_no_numbers_hurt_no_others", needs: &[], disable: "", run: not_finite },
    ])
}

/// Every back-end, and both ways of ray queries, built over the scene.
fn all_tracers(device: &Device, scene: &Scene, gpu_scene: &GpuScene) -> Vec<(Tracer, Following)> {
    let ways = [
        (Backend::RayQuery, Following::Rebuild),
        (Backend::RayQuery, Following::Update),
        (Backend::Cwbvh, Following::Rebuild),
        (Backend::Bvh2, Following::Rebuild),
    ];
    let ways = ways.into_iter().filter(|(backend, _)| backend.available(device));
    let build =
        |(backend, following)| (Tracer::following(device, scene, gpu_scene, backend, following).unwrap(), following);
    ways.map(build).collect()
}

/// A scene of which the meshes `moving` are known to move.
fn moving(mut scene: Scene, moving: &[usize]) -> Scene {
    scene.animation.waters = moving
        .iter()
        .map(|&mesh| Water {
            mesh,
            field: HeightField {
                x: [0.0, 1.0],
                z: [0.0, 1.0],
                quads: [1, 1],
                base: 0.0,
                waves: Vec::new(),
                bumps: Vec::new(),
                relief: None,
            },
            motion: WaterMotion::Waves { depth: None },
        })
        .collect();
    scene
}

/// Puts what has moved into the scene's copy on the device.
fn upload(scene: &Scene, gpu_scene: &mut GpuScene) {
    for (mesh, range) in scene.meshes.iter().zip(&gpu_scene.meshes) {
        let vertex = |position: &Vec3| Vertex { position: position.to_array(), ..Vertex::default() };
        let vertices: Vec<Vertex> = mesh.positions.iter().map(vertex).collect();
        let at = u64::from(range.first_vertex) * size_of::<Vertex>() as u64;
        gpu_scene.vertices.upload_at(at, bytemuck::cast_slice(&vertices)).unwrap();
    }
    gpu_scene.follow(scene).unwrap();
}

/// Waves, a ball and a soup with a triangle that is a point and one that is a line.
fn start() -> Scene {
    let mut random = Random(21);
    let mut soup = soup(&mut random, 300);
    soup.positions[1] = soup.positions[0];
    soup.positions[2] = soup.positions[0];
    soup.positions[4] = soup.positions[3];
    let ball = shapes::sphere("ball", DVec3::ZERO, 1.0, 24);
    let place = |at: Vec3| Affine3A::from_rotation_translation(Quat::from_rotation_x(0.7), at);
    let instances = [
        (0, Affine3A::IDENTITY),
        (1, place(Vec3::new(2.0, 1.5, 0.0))),
        (1, place(Vec3::new(-2.0, 1.5, 1.0))),
        (2, place(Vec3::new(0.0, 2.0, -2.0))),
        (2, place(Vec3::new(0.0, 2.0, 3.0))),
        (3, place(Vec3::new(4.0, 1.0, 4.0))),
    ];
    let still = shapes::sphere("still", DVec3::ZERO, 0.5, 12);
    moving(scene(vec![water(48, 0.0), ball, soup, still], &instances), &[0, 1, 2])
}

type Move = (&'static str, fn(&mut Scene));

const MOVES: [Move; 8] = [
    ("waves", |scene| scene.meshes[0].positions = water(48, 2.5).positions),
    ("steep waves", |scene| each(&mut scene.meshes[0], |p| Vec3::new(p.x, 12.0 * p.y, p.z))),
    ("all 3 m along", |scene| (0..3).for_each(|m| each(&mut scene.meshes[m], |p| p + Vec3::new(3.0, -3.0, 3.0)))),
    ("larger", |scene| (1..3).for_each(|m| each(&mut scene.meshes[m], |p| 1.7 * p))),
    ("smaller", |scene| (0..3).for_each(|m| each(&mut scene.meshes[m], |p| 0.3 * p))),
    ("flat", |scene| each(&mut scene.meshes[0], |p| Vec3::new(p.x, 0.125, p.z))),
    ("turned inside out and mixed up", |scene| scene.meshes[2].positions.reverse()),
    ("instances alone", |scene| {
        for (i, instance) in (0u8..).zip(&mut scene.instances) {
            let turn = Quat::from_rotation_z(0.4 + f32::from(i));
            instance.transform = Affine3A::from_rotation_translation(turn, Vec3::Y * 0.5) * instance.transform;
        }
    }),
];

fn each(mesh: &mut Mesh, place: impl Fn(Vec3) -> Vec3) {
    mesh.positions.iter_mut().for_each(|p| *p = place(*p));
}

fn moved_meshes(a: &Scene, b: &Scene) -> Vec<usize> {
    (0..a.meshes.len()).filter(|&m| a.meshes[m].positions != b.meshes[m].positions).collect()
}

/// Closest hits have equal bits, but for the choice between triangles at the very same t; and as many rays are stopped.
fn moves(request: &Request) {
    let device = request.open();
    let first = start();
    let mut gpu_scene = GpuScene::new(&device, &first).unwrap();
    let followers = all_tracers(&device, &first, &gpu_scene).into_iter();
    // One probe for all moves: SwiftShader takes long to make a kernel.
    let nothing = vec![ray(Vec3::ZERO, Vec3::Y); RAYS];
    let mut followers: Vec<_> =
        followers.map(|(tracer, way)| (Probe::new(&device, &tracer, &nothing).unwrap(), tracer, way)).collect();
    let mut last = first.clone();
    for (name, change) in MOVES {
        let mut scene = first.clone();
        change(&mut scene);
        let moved = moved_meshes(&last, &scene);
        upload(&scene, &mut gpu_scene);
        let middle = 0.5 * (gpu_scene.bounds.min + gpu_scene.bounds.max);
        let rays = random_rays(&mut Random(5), RAYS, middle, 0.4 * gpu_scene.bounds.diagonal());
        for (probe, follower, following) in &mut followers {
            let who = format!("{name} on {} by {} ({following:?})", device.info.name, follower.backend.name());
            let times = follower.update(&device, &scene, &gpu_scene, &moved).unwrap();
            assert!(times.iter().all(|time| time.name.starts_with("trace/")), "{who}: {times:?}");
            let fresh = Tracer::new(&device, &scene, &gpu_scene, follower.backend).unwrap();
            probe.set_rays(&rays).unwrap();
            for any_hit in [false, true] {
                let [found, expected] = [&*follower, &fresh].map(|tracer| {
                    probe.run(tracer, &gpu_scene, ANY_MASK, any_hit).unwrap();
                    probe.hits().unwrap()
                });
                assert_same(&who, &rays, &found, &expected, any_hit);
            }
        }
        last = scene;
    }
    assert_valid(&device);
}

fn assert_same(who: &str, rays: &[Ray], found: &[ProbeHit], expected: &[ProbeHit], any_hit: bool) {
    let (mut ties, mut met) = (0, 0);
    for ((ray, a), b) in rays.iter().zip(found).zip(expected) {
        assert_eq!(is_hit(a), is_hit(b), "{who}: {ray:?}: {a:?} and {b:?}");
        met += usize::from(is_hit(a));
        if !any_hit && bytemuck::bytes_of(a) != bytemuck::bytes_of(b) {
            assert_eq!(a.t, b.t, "{who}: {ray:?}: {a:?} and {b:?}");
            ties += 1;
        }
    }
    assert!(f64::from(ties) <= MOST_TIES * rays.len() as f64, "{who}: {ties} ties");
    assert!(met as f64 >= LEAST_HITS * rays.len() as f64, "{who}: {met} of {} rays hit anything", rays.len());
}

/// Vertices that come back to where the tree was built leave the bits that the host packed, and so do those of a mesh
/// scaled by a power of two, of which the host builds the same tree.
fn packing(request: &Request) {
    let device = request.open();
    let first = start();
    for backend in [Backend::Cwbvh, Backend::Bvh2] {
        let mut gpu_scene = GpuScene::new(&device, &first).unwrap();
        let mut tracer = Tracer::new(&device, &first, &gpu_scene, backend).unwrap();
        let packed = buffers(&tracer);
        for scale in [0.25, 1024.0, 1.0] {
            let mut scene = first.clone();
            (0..scene.meshes.len()).for_each(|m| each(&mut scene.meshes[m], |p| scale * p));
            upload(&scene, &mut gpu_scene);
            let meshes: Vec<usize> = (0..scene.meshes.len()).collect();
            tracer.update(&device, &scene, &gpu_scene, &meshes).unwrap();
            let fresh = buffers(&Tracer::new(&device, &scene, &gpu_scene, backend).unwrap());
            let who = format!("{} scaled by {scale}", backend.name());
            for (name, (found, expected)) in BUFFERS.into_iter().zip(buffers(&tracer).iter().zip(&fresh)) {
                let differ = found.iter().zip(expected).filter(|(a, b)| a != b).count();
                assert!(found == expected, "{who}: {differ} of {} words of {name}", found.len());
            }
            assert!((scale == 1.0) == (fresh == packed), "{who}: nothing moved");
        }
    }
    assert_valid(&device);
}

const BUFFERS: [&str; 3] = ["TraceNodes", "TraceTriangles", "TraceTop"];

/// The words of nodes, triangles and the level over the instances; -0 as 0, since which of them is the lesser is open.
fn buffers(tracer: &Tracer) -> Vec<Vec<u32>> {
    let words = |name: &str| -> Vec<u32> {
        let Some(Binding::Buffer(buffer)) = tracer.bindings.get(name) else { panic!("{name} is not there") };
        let words = buffer.read::<u32>(buffer.size() as usize / 4).unwrap();
        words.into_iter().map(|word| if word == 0x8000_0000 { 0 } else { word }).collect()
    };
    BUFFERS.map(words).to_vec()
}

/// A state reached through others, in two orders and at once, has the same trees and the same hits, bit for bit; and
/// kernels go on being bound to the same buffers.
fn history(request: &Request) {
    let device = request.open();
    let first = start();
    let state = |moves: &[usize]| {
        let mut scene = first.clone();
        moves.iter().for_each(|&m| MOVES[m].1(&mut scene));
        scene
    };
    let (a, b, end) = (state(&[2, 7]), state(&[4, 5]), state(&[0, 3, 7]));
    let rays = random_rays(&mut Random(6), RAYS, Vec3::Y, 5.0);
    let mut gpu_scene = GpuScene::new(&device, &first).unwrap();
    for which in 0..all_tracers(&device, &first, &gpu_scene).len() {
        let mut seen = Vec::new();
        let mut probe = None;
        for row in [vec![&end], vec![&a, &b, &end], vec![&b, &first, &a, &end]] {
            upload(&first, &mut gpu_scene);
            let (mut tracer, following) = all_tracers(&device, &first, &gpu_scene).swap_remove(which);
            let who = format!("{} ({following:?})", tracer.backend.name());
            let memory = tracer.memory;
            for scene in row {
                upload(scene, &mut gpu_scene);
                tracer.update(&device, scene, &gpu_scene, &[0, 1, 2]).unwrap();
            }
            assert!(tracer.memory <= 2 * memory, "{who}: {} bytes after {memory}", tracer.memory);
            let probe = probe.get_or_insert_with(|| Probe::new(&device, &tracer, &rays).unwrap());
            probe.run(&tracer, &gpu_scene, ANY_MASK, false).unwrap();
            let hits = probe.hits().unwrap();
            let buffers = if tracer.backend == Backend::RayQuery { Vec::new() } else { buffers(&tracer) };
            seen.push((who, bytemuck::cast_slice::<_, u32>(&hits).to_vec(), buffers));
        }
        assert!(seen.windows(2).all(|pair| pair[0].1 == pair[1].1), "{}: other hits", seen[0].0);
        assert!(seen.windows(2).all(|pair| pair[0].2 == pair[1].2), "{}: other trees", seen[0].0);
    }
    assert_valid(&device);
}

/// Rays from inside of a ball that was beaten out of shape, at its edges and vertices.
fn leaks(request: &Request) {
    let device = request.open();
    let first = moving(scene(vec![shapes::sphere("ball", DVec3::ZERO, 1.0, 48)], &[(0, Affine3A::IDENTITY)]), &[0]);
    let mut beaten = first.clone();
    each(&mut beaten.meshes[0], |p| {
        let stretched = p * Vec3::new(0.2, 3.0, 1.3) + 0.1 * Vec3::new((3.0 * p.y).sin(), 0.0, (5.0 * p.y).sin());
        stretched + Vec3::new(40.0, -7.0, 20.0)
    });
    let mut gpu_scene = GpuScene::new(&device, &first).unwrap();
    let tracers = all_tracers(&device, &first, &gpu_scene);
    upload(&beaten, &mut gpu_scene);
    let rays = edge_rays(&beaten.meshes[0], Vec3::new(40.0, -7.0, 20.0));
    for (mut tracer, following) in tracers {
        tracer.update(&device, &beaten, &gpu_scene, &[0]).unwrap();
        let found = hits(&device, &gpu_scene, &tracer, &rays, ANY_MASK, false);
        let lost = found.iter().filter(|hit| !is_hit(hit)).count();
        let allowed = if tracer.backend == Backend::RayQuery { RAY_QUERY_LEAKS * rays.len() as f64 } else { 0.0 };
        println!("{} ({following:?}): {lost} of {} rays leak", tracer.backend.name(), rays.len());
        assert!(lost as f64 <= allowed, "{}: {lost} of {}", tracer.backend.name(), rays.len());
    }
    assert_valid(&device);
}

fn edge_rays(mesh: &Mesh, inside: Vec3) -> Vec<Ray> {
    let mut random = Random(9);
    (0..EDGE_RAYS)
        .map(|i| {
            let corners = mesh.triangles[random.below(mesh.triangles.len())].map(|v| mesh.positions[v as usize]);
            let side = random.below(3);
            let share = [0.0, 0.5, random.unit()][i % 3];
            let origin = inside + 0.02 * random.cube();
            ray(origin, corners[side].lerp(corners[(side + 1) % 3], share) - origin)
        })
        .collect()
}

/// A vertex that is no number makes its triangles vanish, and only those.
fn not_finite(request: &Request) {
    let device = request.open();
    let grid = |at: Vec3| [at, at + Vec3::X, at + Vec3::Z];
    let positions: Vec<Vec3> = (0..40).flat_map(|i| grid(Vec3::new((i % 8) as f32, 0.0, (i / 8) as f32))).collect();
    let mut first = mesh("grid", positions, (0..40).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect());
    let before = scene(vec![first.clone()], &[(0, Affine3A::IDENTITY)]);
    let mut gpu_scene = GpuScene::new(&device, &before).unwrap();
    for backend in [Backend::Cwbvh, Backend::Bvh2] {
        upload(&before, &mut gpu_scene);
        let mut tracer = Tracer::new(&device, &before, &gpu_scene, backend).unwrap();
        let down = |i: u32| ray(Vec3::new((i % 8) as f32 + 0.25, 5.0, (i / 8) as f32 + 0.25), -Vec3::Y);
        let rays: Vec<Ray> = (0..40).map(down).collect();
        let probe = Probe::new(&device, &tracer, &rays).unwrap();
        for bad in [f32::NAN, f32::INFINITY] {
            first.positions[3 * 13 + 1].y = bad;
            let after = scene(vec![first.clone()], &[(0, Affine3A::IDENTITY)]);
            upload(&after, &mut gpu_scene);
            tracer.update(&device, &after, &gpu_scene, &[0]).unwrap();
            probe.run(&tracer, &gpu_scene, ANY_MASK, false).unwrap();
            let found = probe.hits().unwrap();
            let triangles = buffers(&tracer).swap_remove(1);
            assert!(triangles.iter().all(|&word| f32::from_bits(word).is_finite()), "{}", backend.name());
            let missed: Vec<usize> = (0..40).filter(|&i| !is_hit(&found[i])).collect();
            assert_eq!(missed, [13], "{}", backend.name());
        }
    }
    assert_valid(&device);
}
