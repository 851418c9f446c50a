//! The shipped scenes load, and the pool is the one whose light was computed elsewhere.

use std::path::{Path, PathBuf};

use nephroid::scene::adjacency::Adjacency;
use nephroid::scene::animation::WaterMotion;
use nephroid::scene::{Emitter, Instance, Scene, Surface, load, parse};

const SHIPPED: [&str; 14] = [
    "flat_water",
    "pool",
    "turbid_pool",
    "ripples",
    "lagoon",
    "glass_sphere",
    "water_sphere",
    "smoke",
    "skull",
    "cornell_flooded",
    "cup",
    "hall",
    "bump_pool",
    "buried_in_sand",
];

/// Half a unit in the last of the eight digits that the pool's reference mesh was written with, and one of f32.
const TOLERANCE: f32 = 2e-7;

fn shipped(name: &str) -> Scene {
    let path: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(format!("{name}.toml"));
    load(&path).unwrap_or_else(|error| panic!("{error}"))
}

fn instance<'a>(scene: &'a Scene, name: &str) -> &'a Instance {
    scene.instances.iter().find(|instance| instance.name == name).unwrap()
}

#[test]
fn every_shipped_scene_loads_without_a_warning_and_has_a_caustic() {
    for name in SHIPPED {
        let scene = shipped(name);
        assert!(scene.warnings.is_empty(), "{name}: {:?}", scene.warnings);
        assert!(!scene.lights.is_empty(), "{name}");
        let surfaces = scene.instances.iter().map(|instance| &scene.materials[instance.material].surface);
        let (specular, diffuse): (Vec<&Surface>, Vec<&Surface>) = surfaces.partition(|surface| surface.is_specular());
        assert!(!specular.is_empty() && !diffuse.is_empty(), "{name}");
        for mesh in &scene.meshes {
            let adjacency = Adjacency::of(mesh);
            assert!(adjacency.non_manifold.is_empty() && adjacency.flipped_edges == 0, "{name}: {}", mesh.name);
            assert!(mesh.normals.iter().all(|normal| normal.is_normalized()), "{name}: {}", mesh.name);
        }
    }
}

#[test]
fn every_shipped_scene_has_its_row_in_the_readme() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let readme = std::fs::read_to_string(folder.join("README.md")).unwrap();
    let mut files = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let file = entry.unwrap().file_name().into_string().unwrap();
        let Some(name) = file.strip_suffix(".toml") else { continue };
        files += 1;
        assert!(SHIPPED.contains(&name), "{file} is in no test");
        assert!(readme.contains(&format!("| [{name}]({file}) |")), "{file} has no row");
        assert!(readme.contains(&format!("(pictures/{name}.png)")), "{file} has no picture");
    }
    assert_eq!(files, SHIPPED.len());
}

/// Rows of the reference mesh: place in the file, vertex, normal.
const WATER: [(usize, [f32; 3], [f32; 3]); 5] = [
    (0, [-6.0, 0.07855766, -6.0], [0.01204808, 0.9989276, 0.04470503]),
    (1, [-5.953125, 0.077128105, -6.0], [0.04667799, 0.9962491, 0.07286254]),
    (257, [-6.0, 0.0757529, -5.953125], [0.03796044, 0.996569, 0.07354808]),
    (33_024, [0.0, 0.0032443906, 0.0], [-0.1803288, 0.9601875, 0.2133577]),
    (66_048, [6.0, -0.019041459, 6.0], [0.04729104, 0.992113, 0.1160838]),
];

#[test]
fn the_pools_water_is_the_reference_mesh() {
    let scene = shipped("pool");
    let mesh = &scene.meshes[instance(&scene, "water").mesh];
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (66_049, 131_072));
    for (vertex, position, normal) in WATER {
        let off = (mesh.positions[vertex] - glam::Vec3::from_array(position)).abs().max_element();
        assert!(off < TOLERANCE, "vertex {vertex} is off by {off}");
        let off = (mesh.normals[vertex] - glam::Vec3::from_array(normal)).abs().max_element();
        assert!(off < TOLERANCE, "normal {vertex} is off by {off}");
    }
    // The reference counts vertices from 1: its first quad is 1 258 259 and 1 259 2, its last 65791 66048 66049.
    assert_eq!(mesh.triangles[..2], [[0, 257, 258], [0, 258, 1]]);
    assert_eq!(mesh.triangles[131_070], [65_790, 66_047, 66_048]);
}

#[test]
fn the_pool_has_the_references_room_lamp_and_cameras() {
    for name in ["pool", "flat_water"] {
        let scene = shipped(name);
        assert_eq!((scene.film.width, scene.film.height), (480, 360));
        let light = &scene.lights[0];
        let Emitter::Point { position, intensity } = &light.emitter else { panic!("{:?}", light.emitter) };
        assert_eq!((position.to_array(), intensity.to_array(), light.medium), ([1.5, 6.0, -1.0], [100.0; 3], 0));

        for (object, albedo, normal_y, low, high, area) in
            [("floor", 0.8, 1.0, -2.0, -2.0, 100.0), ("walls", 0.6, 0.0, -2.0, 0.5, 100.0)]
        {
            let instance = instance(&scene, object);
            let Surface::Diffuse { albedo: found, texture: None } = &scene.materials[instance.material].surface else {
                panic!("{object} is not plainly diffuse")
            };
            assert_eq!(found.to_array(), [albedo; 3]);
            let mesh = &scene.meshes[instance.mesh];
            assert!(mesh.positions.iter().all(|p| p.x.abs() == 5.0 && p.z.abs() == 5.0 && (p.y == low || p.y == high)));
            let mut sum = 0.0;
            for triangle in &mesh.triangles {
                let [a, b, c] = triangle.map(|vertex| mesh.positions[vertex as usize]);
                let front = (b - a).cross(c - a);
                sum += front.length() / 2.0;
                assert_eq!(front.normalize().y, normal_y, "{object}");
                // Into the room.
                assert!(front.dot(glam::Vec3::new(0.0, 0.0, 0.0) - (a + b + c) / 3.0) > 0.0, "{object}");
            }
            assert_eq!(sum, area, "{object}");
        }

        let water = instance(&scene, "water");
        let Surface::Dielectric { front, back } = scene.materials[water.material].surface else { panic!() };
        assert_eq!((scene.media[front].index, scene.media[back].index), (1.0, 1.33));
        let cameras: Vec<_> = scene
            .cameras
            .iter()
            .map(|c| (c.name.as_str(), c.position.to_array(), c.target.to_array(), c.fov_y, c.medium))
            .collect();
        let target = [0.0, -2.0, 0.0];
        assert_eq!(
            cameras,
            [("under", [0.0, -0.6, 3.5], target, 60.0, back), ("above", [0.0, 5.0, 5.0], target, 50.0, front)]
        );
    }
}

#[test]
fn flat_water_is_one_square_at_height_zero() {
    let scene = shipped("flat_water");
    let mesh = &scene.meshes[instance(&scene, "water").mesh];
    assert_eq!(mesh.triangles, [[0, 2, 3], [0, 3, 1]]);
    assert!(mesh.positions.iter().all(|p| p.y == 0.0 && p.x.abs() == 6.0 && p.z.abs() == 6.0));
    assert!(mesh.normals.iter().all(|normal| *normal == glam::Vec3::Y));
}

#[test]
fn what_has_moving_water_moves_and_begins_as_it_is_loaded() {
    for name in SHIPPED {
        let mut scene = shipped(name);
        let animation = scene.animation.clone();
        let moving = ["pool", "turbid_pool", "lagoon", "ripples", "hall", "bump_pool", "buried_in_sand"];
        assert_eq!(animation.moves(), moving.contains(&name), "{name}");
        let loaded = scene.clone();
        animation.pose(&mut scene, 3.7);
        animation.pose(&mut scene, animation.time(0));
        assert_eq!((&scene.cameras, &scene.lights), (&loaded.cameras, &loaded.lights), "{name}");
        let transforms = |scene: &Scene| scene.instances.iter().map(|i| i.transform).collect::<Vec<_>>();
        assert_eq!(transforms(&scene), transforms(&loaded), "{name}");
        for water in &animation.waters {
            let positions = &loaded.meshes[water.mesh].positions;
            assert_eq!(water.field.at(Some(2.0), 0.0).mesh("water").positions, *positions, "{name}");
        }
    }
}

#[test]
fn the_lagoons_raft_bobs_as_one_body() {
    /// Keys give heights to 1e-4 m and leave out the cosine of the tilt: 0.14 (1 - cos 1.2 degrees) is less.
    const AT_KEYS: f32 = 3e-4;
    /// Planks' heights are interpolated each by itself, 1 mm apart at most: joints that nobody sees.
    const BETWEEN_KEYS: f32 = 1e-3;
    let mut scene = shipped("lagoon");
    let animation = scene.animation.clone();
    let planks = |scene: &Scene| [1, 2, 3].map(|k| instance(scene, &format!("plank {k}")).transform);
    let loaded = planks(&scene);
    let ends = [-0.8, 0.8].map(|x| loaded[1].transform_point3(glam::Vec3::new(x, 0.0, 0.0)));
    let mut risen = 0.0f32;
    for k in 0..40 {
        animation.pose(&mut scene, 0.1 * f64::from(k));
        let moved = planks(&scene);
        let tolerance = if k % 10 == 0 { AT_KEYS } else { BETWEEN_KEYS };
        for end in ends {
            // Where each plank's motion would take the end of the middle one.
            let [a, b, c] = [0, 1, 2].map(|k| (moved[k] * loaded[k].inverse()).transform_point3(end));
            let apart = (a - b).length().max((c - b).length());
            assert!(apart < tolerance, "{k}: {apart}");
            risen = risen.max((b - end).length());
        }
    }
    // Bobbing is of the waves' size.
    assert!((0.02..0.06).contains(&risen), "{risen}");
}

#[test]
fn the_ripples_are_simulated_in_few_steps() {
    let Scene { animation, .. } = shipped("ripples");
    let [water] = animation.waters.as_slice() else { panic!() };
    let WaterMotion::Simulated(simulation) = &water.motion else { panic!() };
    assert_eq!(simulation.steps_per_frame(&water.field, animation.fps), 7);
    let seconds = animation.time(animation.frames.unwrap());
    // Three drops by name, and three of rain a second.
    assert_eq!((seconds, simulation.drops_between(&water.field, 0.0, seconds).len()), (8.0, 27));
}

#[test]
fn the_bump_focuses_its_lamp_on_the_floor() {
    let scene = shipped("bump_pool");
    let water = &scene.animation.waters[0].field;
    let [bump] = water.bumps.as_slice() else { panic!() };
    let Emitter::Point { position, .. } = scene.lights[0].emitter else { panic!() };
    let index = f64::from(scene.media[1].index);
    // A surface of that curvature images the lamp by n / image = (n - 1) curvature - 1 / distance.
    let curvature = bump.height / (bump.radius * bump.radius);
    let top = water.base + bump.height;
    let image = index / ((index - 1.0) * curvature - 1.0 / (f64::from(position.y) - top));
    let floor = scene.meshes[instance(&scene, "floor").mesh].positions[0].y;
    let depth = top - f64::from(floor);
    assert!((image / depth - 1.0).abs() < 0.1, "{image} m for {depth} m");
}

#[test]
fn what_is_buried_in_sand_is_half_under_it() {
    let scene = shipped("buried_in_sand");
    let sand = instance(&scene, "sand");
    let ground: Vec<glam::Vec3> =
        (scene.meshes[sand.mesh].positions.iter()).map(|&p| sand.transform.transform_point3(p)).collect();
    // Of the sand's vertices the one nearest to a place is some millimetres off it.
    let height = |at: glam::Vec3| {
        let off = |p: &glam::Vec3| (p.x - at.x).powi(2) + (p.z - at.z).powi(2);
        ground.iter().min_by(|a, b| off(a).total_cmp(&off(b))).map_or(f32::NAN, |p| p.y)
    };
    for name in ["skull", "statue", "chest"] {
        let thing = instance(&scene, name);
        let positions = &scene.meshes[thing.mesh].positions;
        let places: Vec<glam::Vec3> = positions
            .iter()
            .step_by(positions.len().div_ceil(200))
            .map(|&p| thing.transform.transform_point3(p))
            .collect();
        let under = places.iter().filter(|&&at| at.y < height(at)).count() as f32 / places.len() as f32;
        assert!((0.2..0.75).contains(&under), "{name}: {under}");
        assert!(places.iter().all(|at| at.y < -0.05), "{name} looks out of the water");
    }
}

#[test]
fn the_turbid_pool_is_the_pool_with_other_water() {
    let [clear, turbid] = ["pool", "turbid_pool"].map(shipped);
    assert_eq!(clear.lights, turbid.lights);
    assert_eq!(clear.animation.waters, turbid.animation.waters);
    let water = |scene: &Scene| scene.meshes[instance(scene, "water").mesh].positions.clone();
    assert_eq!(water(&clear), water(&turbid));
}

#[test]
fn scenes_with_shafts_have_a_medium_that_scatters_where_light_is_gathered() {
    for (name, medium) in [("water_sphere", "water"), ("turbid_pool", "water"), ("smoke", "smoke")] {
        let scene = shipped(name);
        let scatters = |at: usize| scene.media[at].name == medium && scene.media[at].scattering.min_element() > 0.0;
        assert!(scatters(scene.cameras[0].medium), "{name}: the first camera looks through it");
    }
}

#[test]
fn the_skull_is_closed_and_as_large_as_told() {
    let scene = shipped("skull");
    let mesh = &scene.meshes[instance(&scene, "skull").mesh];
    assert_eq!(Adjacency::of(mesh).boundary_edges, 0);
    let (mut low, mut high) = (glam::Vec3::INFINITY, glam::Vec3::NEG_INFINITY);
    mesh.positions.iter().for_each(|&p| (low, high) = (low.min(p), high.max(p)));
    assert!((high.y - low.y - 1.9).abs() < 0.1 && (high.x + low.x).abs() < 0.02, "{low} {high}");
    // Six times the volume that the faces enclose, positive where they face outward.
    let corner = |triangle: &[u32; 3]| triangle.map(|vertex| mesh.positions[vertex as usize]);
    let volume: f32 = mesh.triangles.iter().map(corner).map(|[a, b, c]| a.dot(b.cross(c))).sum::<f32>() / 6.0;
    assert!((1.5..1.9).contains(&volume), "{volume} m3");
}

#[test]
fn the_halls_statue_is_closed_and_its_curtains_end_where_the_water_begins() {
    /// Files give tenths of a millimetre.
    const WRITTEN: f64 = 1e-4;
    let scene = shipped("hall");
    let statue = instance(&scene, "statue");
    assert_eq!(Adjacency::of(&scene.meshes[statue.mesh]).boundary_edges, 0);
    let lowest = |instance: &Instance| {
        let heights = scene.meshes[instance.mesh].positions.iter().map(|&p| instance.transform.transform_point3(p).y);
        f64::from(heights.fold(f32::INFINITY, f32::min))
    };
    assert_eq!(lowest(statue), 0.0);
    let hems = scene.instances.iter().filter(|instance| scene.meshes[instance.mesh].name.ends_with("curtain.obj:gold"));
    let heights: Vec<f64> = hems.map(lowest).collect();
    let water = scene.animation.waters[0].field.base;
    assert!(heights.len() == 2 && heights.iter().all(|height| (height - water).abs() < WRITTEN), "{heights:?}");
}

#[test]
fn the_readmes_example_of_a_flooded_model_is_a_scene() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let readme = std::fs::read_to_string(folder.join("README.md")).unwrap();
    let (_, rest) = readme.split_once("```toml\n").unwrap();
    let (example, _) = rest.split_once("```").unwrap();
    assert!(example.contains("\"sponza/sponza.obj\""));
    // The hall stands in for the model, which is not shipped.
    let example = example.replace("sponza/sponza.obj", "hall/room.obj");
    let scene = parse(&example, &folder.join("example.toml")).unwrap_or_else(|error| panic!("{error}"));
    assert!(scene.warnings.is_empty() && scene.animation.moves(), "{:?}", scene.warnings);
}
