//! Moving scenes: what a frame shows depends on its number and the seed, not on the frames before it.

mod common;

use std::path::Path;
use std::process::ExitCode;

use common::pool::coarse;
use common::{Case, Request, assert_valid, layer};
use glam::Vec3;
use nephroid::render::{Picture, RenderSettings, Renderer};
use nephroid::scene::{self, Camera, Emitter, Scene};
use nephroid::technique::TechniqueKind;

/// A frame whose neighbours differ from it and from the first.
const FRAME: u32 = 5;
/// Of light in the picture, what six frames of waves move at least: far above rounding.
const MOVED: f64 = 0.01;

fn main() -> ExitCode {
    common::run(&[
        Case { name: "a_frame_alone_is_the_frame_in_its_row", needs: &[], disable: "", run: frame_alone },
        Case { name: "keys_move_camera_objects_and_lights", needs: &[], disable: "", run: keyed },
    ])
}

fn settings(request: &Request, technique: TechniqueKind, set: &[&str]) -> RenderSettings {
    RenderSettings {
        device: request.device.clone(),
        trace: "bvh".parse().unwrap(),
        technique,
        camera: Some("under".to_string()),
        size: Some((48, 36)),
        samples: Some(2),
        set: set.iter().map(|item| item.to_string()).collect(),
        ..Default::default()
    }
}

fn picture(renderer: &mut Renderer) -> Picture {
    for _ in 0..renderer.samples() {
        renderer.sample().unwrap();
    }
    renderer.finish().unwrap()
}

fn frame_alone(request: &Request) {
    for (technique, set) in [
        (TechniqueKind::Mnee, &[][..]),
        (TechniqueKind::Reference, &["reference.photons=20000"]),
        (TechniqueKind::Eikonal, &["eikonal.resolution=48"]),
    ] {
        let settings = settings(request, technique, set);
        let mut row = request.renderer(coarse("pool.toml"), &settings);
        let first = picture(&mut row);
        for frame in [1, FRAME] {
            row.go_to(frame).unwrap();
        }
        let after_others = picture(&mut row);
        assert_valid(row.device());
        let mut alone = request.renderer(coarse("pool.toml"), &RenderSettings { frame: FRAME, ..settings });
        let alone = picture(&mut alone);
        for name in ["final", "caustic"] {
            assert_eq!(layer(&after_others.image, name), layer(&alone.image, name), "{} {name}", technique.name());
        }
        let (before, now) = (layer(&first.image, "caustic"), layer(&alone.image, "caustic"));
        let light: f64 = before.iter().map(|p| f64::from(p[0])).sum();
        let change: f64 = before.iter().zip(&now).map(|(a, b)| f64::from((a[0] - b[0]).abs())).sum();
        assert!(change > MOVED * light, "{} moved {change} of {light}", technique.name());
    }
}

/// A glass ball on a table; camera, ball and lamp each have two keys of their own, a second apart.
const KEYED: &str = r#"
film = { width = 24, height = 18, samples = 2 }
animation = { fps = 4 }
[[camera]]
name = "eye"
position = [0, 2, 2]
target = [0, 0, 0]
keys = [{ time = 0 }, { time = 1, position = [1, 2, 1.5], fov_y = 40 }]
[[medium]]
name = "glass"
index = 1.5
[[material]]
name = "table"
kind = "diffuse"
albedo = 0.7
[[material]]
name = "ball"
kind = "dielectric"
back = "glass"
[[object]]
name = "table"
shape = "plane"
size = [4, 4]
material = "table"
[[object]]
name = "ball"
shape = "sphere"
radius = 0.4
segments = 24
material = "ball"
transform = { translate = [0, 0.6, 0] }
keys = [{ time = 0 }, { time = 1, translate = [0.4, 0.7, 0], scale = [1, 0.7, 1] }]
[[light]]
name = "lamp"
kind = "point"
position = [0.5, 3, 0]
intensity = 10
keys = [{ time = 0 }, { time = 1, position = [-0.5, 3, 0.4], intensity = [5, 10, 20] }]
"#;

/// As a scene that stands where the keys of one second say.
fn stands(keyed: &str) -> Scene {
    let still: String =
        keyed.lines().filter(|line| !line.starts_with("keys")).map(|line| format!("{line}\n")).collect();
    let still = still
        .replace("position = [0, 2, 2]", "position = [1, 2, 1.5]\nfov_y = 40")
        .replace("translate = [0, 0.6, 0]", "translate = [0.4, 0.7, 0], scale = [1, 0.7, 1]")
        .replace("position = [0.5, 3, 0]\nintensity = 10", "position = [-0.5, 3, 0.4]\nintensity = [5, 10, 20]");
    scene::parse(&still, Path::new("still.toml")).unwrap()
}

/// With `reference`, which asks where lamp and ball are when it sends photons; the kernels of `mnee` take
/// SwiftShader much longer to compile.
fn keyed(request: &Request) {
    let set = &["reference.photons=20000"];
    let settings = RenderSettings { camera: None, size: None, ..settings(request, TechniqueKind::Reference, set) };
    let mut row = Renderer::new(scene::parse(KEYED, Path::new("keyed.toml")).unwrap(), &settings).unwrap();
    for frame in [2, 4] {
        row.go_to(frame).unwrap();
    }
    let moved = picture(&mut row);
    // Another camera and another light, and back.
    let camera = row.camera().clone();
    let mut dark = row.scene().lights.clone();
    row.set_camera(Camera { fov_y: 20.0, ..camera.clone() }).unwrap();
    dark[0].emitter = Emitter::Point { position: Vec3::Y, intensity: Vec3::X };
    row.set_lights(Some(dark)).unwrap();
    let elsewhere = picture(&mut row);
    assert_ne!(layer(&elsewhere.image, "final"), layer(&moved.image, "final"));
    row.set_lights(None).unwrap();
    row.set_camera(camera).unwrap();
    let back = picture(&mut row);
    assert_valid(row.device());
    let still = picture(&mut Renderer::new(stands(KEYED), &settings).unwrap());
    for name in ["final", "caustic"] {
        assert_eq!(layer(&moved.image, name), layer(&still.image, name), "{name}");
        assert_eq!(layer(&back.image, name), layer(&still.image, name), "{name} after another camera and light");
    }
}
