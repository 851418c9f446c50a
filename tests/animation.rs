//! Moving scenes: what a frame shows depends on its number and the seed, not on the frames before it.

mod common;

use std::path::Path;
use std::process::ExitCode;

use common::{Case, Request, assert_valid, layer};
use nephroid::render::{Picture, RenderSettings, Renderer};
use nephroid::scene::{self, Scene};
use nephroid::technique::TechniqueKind;

/// A frame whose neighbours differ from it and from the first.
const FRAME: u32 = 5;
/// Of light in the picture, what six frames of waves move at least: far above rounding.
const MOVED: f64 = 0.01;

fn main() -> ExitCode {
    common::run(&[Case { name: "a_frame_alone_is_the_frame_in_its_row", needs: &[], disable: "", run: frame_alone }])
}

/// The pool with less water, so that it is quick.
fn pool() -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/pool.toml");
    let text = std::fs::read_to_string(&path).unwrap().replace("quads = [256, 256]", "quads = [64, 64]");
    scene::parse(&text, &path).unwrap()
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
    for (technique, set) in
        [(TechniqueKind::Mnee, &[][..]), (TechniqueKind::Reference, &["reference.photons=20000"][..])]
    {
        let settings = settings(request, technique, set);
        let mut row = request.renderer(pool(), &settings);
        let first = picture(&mut row);
        for frame in [1, FRAME] {
            row.go_to(frame).unwrap();
        }
        let after_others = picture(&mut row);
        assert_valid(row.device());
        let mut alone = request.renderer(pool(), &RenderSettings { frame: FRAME, ..settings });
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
