//! What a scene file says of motion, and where things are at a time.

mod scene_text;

use std::path::Path;

use glam::{DVec2, Vec3};
use nephroid::scene::animation::{Drop, Interpolation, Rain, Simulation, WaterMotion};
use nephroid::scene::{Emitter, Scene, parse};
use nephroid::view::{Band, View};
use scene_text::{check_sentence, read};

/// Line numbers in the sentences below count from the first line here.
const MOVING: &str = r#"[animation]
fps = 30
frames = 48
[[camera]]
name = "eye"
position = [0, 1, 4]
target = [0, 0, 0]
keys = [
    { time = -1, position = [0, 2, 4], fov_y = 30 },
    { time = 1, position = [2, 2, 4], target = [1, 0, 0], up = [0, 1, 1] },
    { time = 2.5 },
]
[[medium]]
name = "water"
index = 1.33
[[material]]
name = "sand"
kind = "diffuse"
albedo = 0.5
[[material]]
name = "surface"
kind = "dielectric"
back = "water"
[[object]]
name = "ball"
shape = "sphere"
radius = 0.5
segments = 8
transform = { translate = [0, 0.25, 0], scale = 2 }
material = "sand"
interpolation = "linear"
repeat = true
keys = [
    { time = 0 },
    { time = 2, translate = [0, 0.75, 0], rotate = [0, 90, 0] },
    { time = 4 },
]
[[object]]
name = "tank"
shape = "heightfield"
x = [0, 4]
z = [0, 2]
quads = [8, 8]
base = 0.1
motion = { kind = "simulated", speed = 2, damping = 0.3, drops = [
    { time = 1.5, centre = [1, 1], height = 0.02, radius = 0.1 },
    { time = 0.5, centre = [3, 1], height = -0.02, radius = 0.1 },
], rain = { rate = 4, height = 0.01, radius = 0.05, seed = 9 } }
material = "surface"
[[object]]
name = "sea"
shape = "heightfield"
x = [10, 14]
z = [0, 2]
quads = 8
motion = { kind = "waves", depth = 3 }
waves = [{ wavelength = 1, amplitude = 0.1 }]
material = "surface"
[[light]]
name = "lamp"
kind = "point"
position = [0, 3, 0]
intensity = 10
keys = [
    { time = 1, intensity = 10 },
    { time = 2, intensity = [0, 20, 40], position = [1, 3, 0] },
]
[[light]]
name = "torch"
kind = "spot"
position = [0, 3, 0]
target = [0, 0, 0]
intensity = 5
outer = 20
interpolation = "step"
keys = [{ time = 1, target = [0, 3, 5] }, { time = 2, intensity = 6 }]
[[light]]
name = "sun"
kind = "directional"
direction = [0, -1, 0]
irradiance = 3
keys = [{ time = 0, direction = [1, 0, 0] }, { time = 2, direction = [0, -2, 0], irradiance = 4 }]
"#;

/// f32 rounding of numbers near 1.
const ROUNDING: f32 = 1e-6;

fn at(time: f64) -> Scene {
    let mut scene = read(MOVING).unwrap();
    scene.animation.clone().pose(&mut scene, time);
    scene
}

/// Where a point of an instance stands.
fn placed(scene: &Scene, instance: usize, point: Vec3) -> Vec3 {
    scene.instances[instance].transform.transform_point3(point)
}

#[test]
fn motion_is_read_to_the_last_number() {
    let animation = read(MOVING).unwrap().animation;
    assert_eq!((animation.fps, animation.frames, animation.moves()), (30.0, Some(48), true));
    assert_eq!(animation.time(45), 1.5);
    let [tank, sea] = animation.waters.as_slice() else { panic!() };
    let drop = |time, x, height| Drop { time, centre: DVec2::new(x, 1.0), height, radius: 0.1 };
    let rain = Some(Rain { rate: 4.0, height: 0.01, radius: 0.05, seed: 9 });
    let drops = vec![drop(0.5, 3.0, -0.02), drop(1.5, 1.0, 0.02)];
    assert_eq!(tank.motion, WaterMotion::Simulated(Simulation { speed: 2.0, damping: 0.3, drops, rain }));
    assert_eq!((sea.motion.clone(), sea.field.quads), (WaterMotion::Waves { depth: Some(3.0) }, [8, 8]));
    assert_eq!((tank.mesh, sea.mesh), (1, 2));
    assert_eq!(animation.cameras[0].timeline.times, [-1.0, 1.0, 2.5]);
    assert_eq!((animation.objects[0].of.clone(), animation.objects[0].timeline.repeat), (0..1, true));
    let interpolations = [&animation.lights[0].timeline, &animation.lights[1].timeline].map(|t| t.interpolation);
    assert_eq!(interpolations, [Interpolation::Smooth, Interpolation::Step]);

    let still = read(&MOVING.replace("fps = 30\nframes = 48\n", "")).unwrap().animation;
    assert_eq!((still.fps, still.frames), (24.0, None));
    assert!(!parse(include_str!("../scenes/cup.toml"), Path::new("cup.toml")).unwrap().animation.moves());
}

#[test]
fn a_scene_is_loaded_as_it_is_at_time_0() {
    let loaded = read(MOVING).unwrap();
    let posed = at(0.0);
    assert_eq!((&loaded.cameras, &loaded.lights), (&posed.cameras, &posed.lights));
    assert_eq!(loaded.instances[0].transform, posed.instances[0].transform);
    // Half-way between the first two keys of the camera, and at the first of the sun.
    assert!((loaded.cameras[0].position - Vec3::new(1.0, 2.0, 4.0)).length() < ROUNDING);
    let Emitter::Directional { direction, irradiance } = loaded.lights[2].emitter else { panic!() };
    assert_eq!((direction, irradiance), (Vec3::X, Vec3::splat(3.0)));
}

#[test]
fn a_pose_at_a_key_is_the_keys_and_what_it_leaves_out_is_the_things_own() {
    let scene = at(1.0);
    let eye = &scene.cameras[0];
    assert_eq!((eye.position, eye.target, eye.fov_y), (Vec3::new(2.0, 2.0, 4.0), Vec3::X, 45.0));
    assert_eq!(eye.up, glam::DVec3::new(0.0, 1.0, 1.0).normalize().as_vec3());
    let scene = at(2.0);
    assert!((placed(&scene, 0, Vec3::X) - Vec3::new(0.0, 0.75, -2.0)).length() < ROUNDING);
    let Emitter::Point { position, intensity } = scene.lights[0].emitter else { panic!() };
    assert_eq!((position, intensity), (Vec3::new(1.0, 3.0, 0.0), Vec3::new(0.0, 20.0, 40.0)));
    let Emitter::Spot { position, direction, intensity, .. } = scene.lights[1].emitter else { panic!() };
    assert_eq!((position, direction, intensity), (Vec3::new(0.0, 3.0, 0.0), Vec3::NEG_Y, Vec3::splat(6.0)));
    let Emitter::Directional { direction, irradiance } = scene.lights[2].emitter else { panic!() };
    assert_eq!((direction, irradiance), (Vec3::NEG_Y, Vec3::splat(4.0)));
    // The last key of the camera says nothing.
    let own = &at(9.0).cameras[0];
    assert_eq!((own.position, own.target, own.up, own.fov_y), (Vec3::new(0.0, 1.0, 4.0), Vec3::ZERO, Vec3::Y, 45.0));
}

#[test]
fn between_keys_things_are_between() {
    let scene = at(1.5);
    let Emitter::Spot { direction, .. } = scene.lights[1].emitter else { panic!() };
    assert_eq!(direction, Vec3::Z, "a step waits");
    let Emitter::Point { intensity, .. } = scene.lights[0].emitter else { panic!() };
    assert!((intensity - Vec3::new(5.0, 15.0, 25.0)).length() < 1e-5, "{intensity}");
    let half = Vec3::new(0.5f32.sqrt(), -0.5f32.sqrt(), 0.0);
    let Emitter::Directional { direction, .. } = at(1.0).lights[2].emitter else { panic!() };
    assert!((direction - half).length() < ROUNDING, "{direction}");
    // The ball repeats: 45 degrees round at times 1, 5 and -7 (there on its way back).
    for time in [1.0, 5.0, -7.0] {
        let front = placed(&at(time), 0, Vec3::X);
        assert!((front - Vec3::new(2f32.sqrt(), 0.5, -(2f32.sqrt()))).length() < 1e-5, "{time} {front}");
    }
}

#[test]
fn a_pose_does_not_depend_on_the_poses_before() {
    let mut scene = read(MOVING).unwrap();
    let animation = scene.animation.clone();
    for time in [7.0, 0.4, -3.0, 1.7] {
        animation.pose(&mut scene, time);
    }
    let alone = at(1.7);
    assert_eq!((&scene.cameras, &scene.lights), (&alone.cameras, &alone.lights));
    assert_eq!(scene.instances[0].transform, alone.instances[0].transform);
}

#[test]
fn an_obj_object_of_several_materials_moves_as_one() {
    let folder = tempfile::tempdir().unwrap();
    let triangle = |x: i32| format!("v {x} 0 0\nv {x} 0 1\nv {} 0 0\n", x + 1);
    let text = format!("mtllib m.mtl\n{}usemtl a\nf 1 2 3\n{}usemtl b\nf 4 5 6\n", triangle(0), triangle(3));
    std::fs::write(folder.path().join("o.obj"), text).unwrap();
    std::fs::write(folder.path().join("m.mtl"), "newmtl a\nKd 1 0 0\nnewmtl b\nKd 0 1 0\n").unwrap();
    let object = "[[object]]\nname = \"two\"\nshape = \"obj\"\nfile = \"o.obj\"\n\
                  keys = [{ time = 0 }, { time = 1, translate = [0, 5, 0], rotate = [0, 90, 0] }]\n[[object]]";
    let mut scene = parse(&MOVING.replacen("[[object]]", object, 1), &folder.path().join("s.toml")).unwrap();
    scene.animation.clone().pose(&mut scene, 1.0);
    assert_eq!(scene.animation.objects[0].of, 0..2);
    assert_eq!(scene.instances[0].transform, scene.instances[1].transform);
    assert!((placed(&scene, 1, Vec3::X) - Vec3::new(0.0, 5.0, -1.0)).length() < ROUNDING);
    assert_eq!(scene.animation.objects[1].of, 2..3);
}

#[test]
fn a_camera_that_passes_through_its_target_still_looks_somewhere() {
    let keys = "interpolation = \"linear\"\nkeys = [{ time = 0, position = [0, 0, 2], up = [0, 1, 1] },\n\
                { time = 2, position = [0, 0, -2], up = [0, -1, -1] }]\n";
    let text =
        format!("{}{keys}{}", &MOVING[..MOVING.find("keys").unwrap()], &MOVING[MOVING.find("[[medium]]").unwrap()..]);
    let mut scene = read(&text).unwrap();
    let animation = scene.animation.clone();
    for time in [0.999_999_9, 1.0, 1.000_000_1] {
        animation.pose(&mut scene, time);
        let view = View::new(&scene.cameras[0], &scene.film, (4, 3), Band { first: 0, count: 3 });
        let axes = [view.forward, view.right, view.up].map(Vec3::from_array);
        assert!(axes.iter().all(|axis| axis.is_finite() && axis.length() > 0.1), "{time} {axes:?}");
    }
    animation.pose(&mut scene, 1.0);
    assert_eq!(scene.cameras[0].target, Vec3::NEG_Z);
}

/// The sentence for the moving scene with `from` replaced.
fn sentence(from: &str, to: &str) -> String {
    scene_text::sentence(MOVING, from, to)
}

#[test]
fn strong_damping_of_few_frames_is_refused() {
    let text = MOVING.replace("fps = 30", "fps = 1").replace("damping = 0.3", "damping = 1000");
    assert_eq!(
        read(&text).expect_err("2000 steps").to_string(),
        "bad.toml:45: `object.motion.damping` is 1000; allowed: at most 500 at 1 frames per second: damping times the \
         length of a step may be 0.5, and 1000 steps are the most between two frames"
    );
}

#[test]
fn each_wrong_value_has_its_sentence() {
    let cases = [
        ("fps = 30", "fps = 0", "bad.toml:2: `animation.fps` is 0; allowed: a number from 0.01 to 1000"),
        ("frames = 48", "frames = 0", "bad.toml:3: `animation.frames` is 0; allowed: a whole number from 1 to 1000000"),
        ("fps = 30", "pfs = 30", "bad.toml:2: unknown key `pfs` in [animation]; allowed: fps, frames"),
        (
            "time = 1, position = [2, 2, 4]",
            "time = -1, position = [2, 2, 4]",
            "bad.toml:10: `camera.keys.time` is -1; allowed: a time at least 1e-6 after the key's before, -1",
        ),
        ("{ time = 2.5 }", "{ }", "bad.toml:11: a key of a [[camera]] lacks `time`; allowed: a number of seconds"),
        (
            "{ time = 2.5 }",
            "{ time = inf }",
            "bad.toml:11: `camera.keys.time` is inf; allowed: a number from -1e6 to 1e6",
        ),
        ("{ time = 2.5 }", "2.5", "bad.toml:11: `camera.keys` is 2.5; allowed: a table"),
        (
            "{ time = 2.5 }",
            "{ time = 2.5, translate = [0, 0, 0] }",
            "bad.toml:11: unknown key `translate` in a key of a [[camera]]; allowed: time, position, target, up, fov_y",
        ),
        (
            "target = [1, 0, 0]",
            "target = [2, 2, 4]",
            "bad.toml:10: `camera.keys.target` is the list [2, 2, 4]; allowed: a point at least 1e-6 from the camera's position",
        ),
        (
            "position = [0, 2, 4]",
            "position = [0, 0, 0]",
            "bad.toml:9: `camera.keys.position` is the list [0, 0, 0]; allowed: a point at least 1e-6 from the camera's position",
        ),
        (
            "up = [0, 1, 1]",
            "up = [1, 2, 4]",
            "bad.toml:10: `camera.keys.up` is the list [1, 2, 4]; allowed: a camera whose `up` (0, 1, 0 if left out) is not along its view",
        ),
        (
            "interpolation = \"linear\"",
            "interpolation = \"bezier\"",
            "bad.toml:31: `object.interpolation` is the text \"bezier\"; allowed: \"smooth\", \"linear\", \"step\"",
        ),
        (
            "    { time = 4 },\n",
            "    { time = 4, translate = [0, 0, 0] },\n",
            "bad.toml:32: `object.repeat` is true; allowed: false, or true where the last of several keys is as the first",
        ),
        (
            "quads = 8\n",
            "quads = 8\nrepeat = true\n",
            "bad.toml:56: `object.repeat` is true; allowed: this key beside `keys` only",
        ),
        (
            "translate = [0, 0.75, 0]",
            "translate = [0, 1e6, 0]",
            "bad.toml:35: `object.keys` is a table; allowed: a placement with all points within 1e6 of the origin",
        ),
        (
            "rotate = [0, 90, 0]",
            "rotate = [0, 180, 0]",
            "bad.toml:35: `object.keys` is a table; allowed: a rotation less than half a turn from the key before",
        ),
        (
            // At time 0 no vertex is off the nodes of this wave.
            "waves = [{ wavelength = 1, amplitude = 0.1 }]",
            "base = 1\nwaves = [{ wavelength = 1, amplitude = 1e6 }]",
            "bad.toml:51: `object.name` is the text \"sea\"; allowed: a placement with all points within 1e6 of the origin",
        ),
        (
            "rotate = [0, 90, 0]",
            "scale = 0",
            "bad.toml:35: `object.keys.scale` is 0; allowed: a number from 1e-6 to 1e6, or a list of three",
        ),
        (
            "rotate = [0, 90, 0]",
            "material = \"sand\"",
            "bad.toml:35: unknown key `material` in a key of an [[object]]; allowed: time, translate, rotate, scale",
        ),
        (
            "kind = \"simulated\"",
            "kind = \"waves\"",
            "bad.toml:45: unknown key `speed` in `motion` by waves; allowed: kind, depth",
        ),
        (
            "kind = \"waves\"",
            "kind = \"simulated\", speed = 1",
            "bad.toml:56: unknown key `depth` in simulated `motion`; allowed: kind, speed, damping, drops, rain",
        ),
        (
            "kind = \"waves\"",
            "kind = \"boiling\"",
            "bad.toml:56: `object.motion.kind` is the text \"boiling\"; allowed: \"waves\", \"simulated\"",
        ),
        ("depth = 3", "depth = 0", "bad.toml:56: `object.motion.depth` is 0; allowed: a number from 1e-6 to 1e6"),
        ("speed = 2, ", "", "bad.toml:45: simulated `motion` lacks `speed`; allowed: metres per second"),
        ("speed = 2", "speed = 0", "bad.toml:45: `object.motion.speed` is 0; allowed: a number from 1e-3 to 1e3"),
        (
            "damping = 0.3",
            "damping = -1",
            "bad.toml:45: `object.motion.damping` is -1; allowed: a number from 0 to 1e3",
        ),
        (
            "fps = 30",
            "fps = 0.01",
            "bad.toml:45: `object.motion.speed` is 2; allowed: at most 1.25 with quads of this size at 0.01 frames per second: a wave may cross half a quad in a step, and 1000 steps are the most between two frames",
        ),
        (
            "time = 0.5",
            "time = -0.5",
            "bad.toml:47: `object.motion.drops.time` is -0.5; allowed: a number from 0 to 1e6",
        ),
        (
            "height = 0.02, radius = 0.1",
            "height = 0.02",
            "bad.toml:46: a drop lacks `radius`; allowed: a number of metres",
        ),
        ("rate = 4", "rate = 0", "bad.toml:48: `object.motion.rain.rate` is 0; allowed: a number from 1e-3 to 1e3"),
        (
            "seed = 9",
            "seed = -9",
            "bad.toml:48: `object.motion.rain.seed` is -9; allowed: a whole number from 0 to 4294967295",
        ),
        (
            "{ time = 1, intensity = 10 }",
            "{ time = 1, irradiance = 10 }",
            "bad.toml:65: unknown key `irradiance` in a key of a point [[light]]; allowed: time, position, intensity",
        ),
        (
            "intensity = [0, 20, 40]",
            "intensity = -1",
            "bad.toml:66: `light.keys.intensity` is -1; allowed: a number from 0 to 1e9, or a list of three",
        ),
        (
            "target = [0, 3, 5]",
            "target = [0, 3, 0]",
            "bad.toml:76: `light.keys.target` is the list [0, 3, 0]; allowed: a point other than the light's position",
        ),
        (
            "direction = [0, -2, 0]",
            "direction = [0, 0, 0]",
            "bad.toml:82: `light.keys.direction` is the list [0, 0, 0]; allowed: a list of three numbers that are not all 0",
        ),
        (
            "keys = [{ time = 1, target = [0, 3, 5] }, { time = 2, intensity = 6 }]",
            "keys = []",
            "bad.toml:76: `light.keys` is the list []; allowed: at least one key, or no `keys`",
        ),
        (
            "keys = [{ time = 1, target = [0, 3, 5] }, { time = 2, intensity = 6 }]",
            "keys = 1",
            "bad.toml:76: `light.keys` is 1; allowed: a list of tables, each with a `time`",
        ),
        (
            "keys = [{ time = 1, target = [0, 3, 5] }, { time = 2, intensity = 6 }]",
            "",
            "bad.toml:75: `light.interpolation` is the text \"step\"; allowed: this key beside `keys` only",
        ),
        (
            "shape = \"sphere\"\n",
            "shape = \"sphere\"\nmotion = { kind = \"waves\" }\n",
            "bad.toml:27: unknown key `motion` in a sphere [[object]]; allowed: name, shape, material, transform, keys, interpolation, repeat, centre, radius, segments",
        ),
    ];
    for (from, to, expected) in cases {
        assert_eq!(sentence(from, to), expected, "{to}");
    }
}

#[test]
fn no_damage_to_a_moving_scene_makes_the_reader_panic() {
    for (start, character) in MOVING.char_indices().step_by(2) {
        for with in ["", "-", "9e99", "nan", "{"] {
            let mut damaged = MOVING.to_owned();
            damaged.replace_range(start..start + character.len_utf8(), with);
            match read(&damaged) {
                Err(error) => check_sentence(&error),
                Ok(mut scene) => scene.animation.clone().pose(&mut scene, 1.3),
            }
        }
    }
}
