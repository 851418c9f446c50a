//! Where the light goes, in sum.

use std::path::Path;

use glam::Vec3;
use nephroid::render::Picture;
use nephroid::scene::{self, Bounds, DensityGrid, Scene};

use crate::common::text::pane;
use crate::common::{Request, layer};
use crate::{assert_sound, load, render, watts};

/// What the entries of the ledger may be off in sum: each amount is rounded to a unit, and f32.
const BALANCE: f64 = 1e-3;

/// What outlines may take: rays round which no beam at all is whole, of a coarse lattice. Light that neighbours do not take
/// up is three times as much, in waves at a wall.
const ISOLATED: f64 = 5e-3;

fn turbid(name: &str, index: &str, coefficients: &str) -> Scene {
    let path = Path::new("scenes").join(name);
    let text = std::fs::read_to_string(&path).unwrap();
    let changed = text.replacen(index, &format!("{index}\n{coefficients}"), 1).replace("[256, 256]", "[64, 64]");
    assert_ne!(text, changed);
    scene::parse(&changed, &path).unwrap()
}

/// All that is booked, over what was emitted.
fn assert_balance(what: &str, picture: &Picture) {
    let emitted = watts(picture, "emitted");
    let booked: f64 = picture.stats.ledger.iter().skip(1).map(|entry| entry.watts).sum();
    println!("{what}: {:.2e} off, {:?}", booked / emitted - 1.0, picture.stats.ledger);
    assert!(emitted > 0.0 && (booked / emitted - 1.0).abs() < BALANCE, "{what}: {booked} of {emitted} W");
    assert_sound(picture);
}

pub fn adds_up(request: &Request) {
    let clear = "index = 1.33";
    let scenes: [(&str, Scene, &[&str]); 7] = [
        ("waves", crate::pool(), &["landed", "escaped"]),
        ("absorbing water", turbid("pool.toml", clear, "absorption = [0.3, 0.1, 0]"), &["landed", "absorbed"]),
        (
            "turbid water",
            turbid("pool.toml", clear, "absorption = 0.1\nscattering = [0.1, 0.2, 0.3]"),
            &["landed", "absorbed", "scattered"],
        ),
        ("brass", load("cup.toml"), &["landed", "absorbed", "missed"]),
        ("glass", load("glass_sphere.toml"), &["landed", "missed"]),
        ("flooded", load("cornell_flooded.toml"), &["landed"]),
        ("lagoon", load("lagoon.toml"), &["landed"]),
    ];
    for (what, scene, there) in scenes {
        let set = ["beams.grid=6", "beams.levels=3", "beams.reuse=1", "beams.vertices=65536"];
        let picture = render(request, scene, &set, |s| {
            s.size = Some((8, 6));
            s.samples = Some(3);
        });
        assert_balance(what, &picture);
        let lost = watts(&picture, "silhouette") / watts(&picture, "emitted");
        assert!(lost < ISOLATED, "{what}: {lost} lost at outlines");
        for entry in there {
            assert!(watts(&picture, entry) > 0.0, "{what}: nothing {entry}");
        }
    }
}

/// Half of the full density 3 m to 43 m above the floor, where nothing of the scene is.
fn haze() -> DensityGrid {
    let bounds = Bounds { min: Vec3::new(-40.0, 3.0, -40.0), max: Vec3::new(40.0, 43.0, 40.0) };
    DensityGrid { bounds, points: [2; 3], values: vec![0.5; 8] }
}

/// What lands on the floor below a pane in a medium to which `haze` gives density far above, of each channel.
fn landed(request: &Request, coefficients: &str) -> [f64; 3] {
    let camera = "position = [0, 0.6, 0]\ntarget = [0, 0, 0]\nup = [0, 0, -1]\nfov_y = 30";
    let medium = format!("[[medium]]\nname = \"haze\"\nindex = 1\n{coefficients}");
    let mut scene = scene::parse(&pane(camera, "haze", &medium), Path::new("test.toml")).unwrap();
    scene.densities.push(haze());
    scene.media.iter_mut().find(|m| m.name == "haze").unwrap().density = Some(0);
    let set = ["beams.grid=4", "beams.levels=1", "beams.bounces=3", "beams.vertices=4096"];
    let picture = render(request, scene, &set, |s| s.size = Some((8, 6)));
    assert_balance(coefficients, &picture);
    let pixels = layer(&picture.image, "caustic");
    [0, 1, 2].map(|c| pixels.iter().map(|p| f64::from(p[c])).sum::<f64>() / pixels.len() as f64)
}

pub fn sun(request: &Request) {
    let clear = landed(request, "absorption = 0");
    // Two faces and two reflections between them, which is as far as light is followed.
    let expected = 0.96 * 0.96;
    for (channel, irradiance) in [1.0, 2.0, 3.0].into_iter().enumerate() {
        let error = clear[channel] / (irradiance * expected) - 1.0;
        assert!(error.abs() < 2e-3, "channel {channel}: {clear:?}");
    }
    // 40 m of half the density, before anything of the scene.
    let lost = [0.02, 0.06, 0.1];
    for coefficients in ["absorption = [0.02, 0.06, 0.1]", "scattering = [0.02, 0.06, 0.1]"] {
        let found = landed(request, coefficients);
        for channel in 0..3 {
            let ratio = found[channel] / clear[channel];
            let expected = f64::exp(-lost[channel] * 20.0);
            println!("{coefficients}, channel {channel}: {ratio}, {expected} expected");
            assert!((ratio / expected - 1.0).abs() < 1e-3, "channel {channel}: {ratio}, not {expected}");
        }
    }
}
