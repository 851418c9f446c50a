//! The reference's light in volumes, L S+ V, against quadrature, and itself.

mod common;

use std::path::Path;
use std::process::ExitCode;

use common::measure::watts;
use common::pool::{FlatPart, against_flat_water, first_water_stretch, flat_water_inscatter, turbid_flat_pool};
use common::smoke::{against_pane, pane};
use common::{Case, Request, layer};
use glam::Vec3;
use nephroid::render::Picture;
use nephroid::scene::{self, Scene};

fn main() -> ExitCode {
    common::run(&[
        Case { name: "flat_water_scatters_as_quadrature_says", needs: &[], disable: "", run: flat_water },
        Case { name: "smoke_scatters_as_quadrature_says", needs: &[], disable: "", run: smoke },
        Case { name: "path_classes_part_the_light_in_volumes", needs: &[], disable: "", run: path_classes },
        Case { name: "what_media_take_is_accounted_for", needs: &[], disable: "", run: ledger },
        Case { name: "equal_seeds_give_equal_bits_in_volumes", needs: &[], disable: "", run: equal_bits },
    ])
}

fn picture(request: &Request, scene: Scene, (size, samples): ((u32, u32), u32), set: &[&str]) -> Picture {
    request.render(scene, |s| {
        s.camera = Some("under".to_string());
        s.size = Some(size);
        s.samples = Some(samples);
        s.set = set.iter().map(|s| s.to_string()).collect();
    })
}

/// Row, column, and radiance for g = 0 and g = 0.7, W/(m2 sr).
const REFERENCE_PIXELS: [(f64, f64, f64, f64); 4] = [
    (200.0, 240.0, 0.023_932_396, 0.005_668_692_3),
    (300.0, 400.0, 0.016_617_138, 0.003_252_139_8),
    (150.0, 100.0, 0.035_617_8, 0.008_563_591),
    (100.0, 300.0, 0.059_668_057, 0.017_739_046),
];

fn flat_water(request: &Request) {
    // Radiance worked out elsewhere, at pixel centres of a film of 480x360: on the floor and on a wall.
    for (row, column, isotropic, forward) in REFERENCE_PIXELS {
        let (origin, direction, length) = first_water_stretch(column, row, 480.0, 360.0).unwrap();
        for (asymmetry, expected) in [(0.0, isotropic), (0.7, forward)] {
            let found = flat_water_inscatter(origin, direction, length, (0.02, 0.08, asymmetry));
            // Box-filtered over a pixel there, at its centre here.
            assert!((found / expected - 1.0).abs() < 1e-3, "row {row}, column {column}: {found}, not {expected}");
        }
    }
    let size = (32, 24);
    let set = ["reference.photons=10000", "reference.volume_photons=100000", "reference.reuse=1"];
    for asymmetry in [0.0, 0.7] {
        let errors = [2, 16].map(|samples| {
            let set = [&set[..], &["reference.paths=refracted-once"]].concat();
            let picture = picture(request, turbid_flat_pool(asymmetry as f32), (size, samples), &set);
            let found = layer(&picture.image, "caustic_volume");
            let (energy, rel_rmse) = against_flat_water(&found, size, asymmetry, FlatPart::Walls);
            println!("g {asymmetry}, {samples} samples: energy {energy:.5}, relRMSE {rel_rmse:.4}");
            // 16 sets of 64 photons round each stretch: 3 % in a pixel, and a hundredth in all as neighbours share many.
            assert!(samples < 16 || (energy - 1.0).abs() < 0.01, "g {asymmetry}: energy {energy}");
            rel_rmse
        });
        assert!(errors[1] < 0.03, "g {asymmetry}: relRMSE {}", errors[1]);
        // Eight times the photons, while the radius shrinks: a third of the variance is left at least.
        assert!(errors[1] < 0.6 * errors[0], "g {asymmetry}: relRMSE {errors:?}");
    }
}

fn smoke(request: &Request) {
    let size = (32, 24);
    let picture = request.render(pane(), |s| {
        s.size = Some(size);
        s.samples = Some(16);
        s.set = ["reference.photons=20000", "reference.volume_photons=400000", "reference.reuse=2"]
            .map(String::from)
            .to_vec();
    });
    // All orders of reflections within the pane: (1 - R) / (1 + R) with R = 0.04.
    let found = against_pane(&layer(&picture.image, "caustic_volume"), size, 0.96 / 1.04);
    for (channel, (energy, rel_rmse)) in found.into_iter().enumerate() {
        println!("channel {channel}: energy {energy:.5}, relRMSE {rel_rmse:.4}");
        // Six million photons.
        assert!((energy - 1.0).abs() < 0.01, "channel {channel}: energy {energy}");
        // What 64 photons round a stretch leave in 8 sets, and a blur of some centimetres.
        assert!(rel_rmse < 0.05, "channel {channel}: relRMSE {rel_rmse}");
    }
}

/// A ball of glass in fog; glass scatters too.
fn foggy_ball() -> Scene {
    let mut scene = scene::load(Path::new("scenes/glass_sphere.toml")).unwrap();
    for medium in &mut scene.media {
        medium.scattering = Vec3::new(0.05, 0.1, 0.2);
    }
    scene
}

fn path_classes(request: &Request) {
    let energy = |paths: &str| {
        let set = [
            &format!("reference.paths={paths}"),
            "reference.photons=5000",
            "reference.volume_photons=50000",
            "reference.reuse=1",
        ];
        let picture = request.render(foggy_ball(), |s| {
            s.size = Some((16, 12));
            s.samples = Some(4);
            s.set = set.iter().map(|s| s.to_string()).collect();
        });
        layer(&picture.image, "caustic_volume").iter().map(|p| f64::from(p[1])).sum::<f64>()
    };
    let [all, refracted, reflected, mixed] = ["all", "refracted", "reflected", "mixed"].map(energy);
    let (once, rest) = (energy("refracted-once"), energy("not-refracted-once"));
    println!("{all}: refracted {refracted}, reflected {reflected}, mixed {mixed}; once {once}, rest {rest}");
    assert!(refracted > 0.0 && reflected > 0.0 && mixed > 0.0 && once > 0.0);
    // The same paths each time, but a path keeps another of its stretches where fewer are allowed.
    assert!(((refracted + reflected + mixed) / all - 1.0).abs() < 0.02);
    assert!(((once + rest) / all - 1.0).abs() < 0.02);
    assert!(once < refracted);
}

fn ledger(request: &Request) {
    let set = ["reference.photons=20000"];
    for (name, scene) in [("pool", turbid_flat_pool(0.0)), ("ball", foggy_ball())] {
        let picture = request.render(scene, |s| {
            s.size = Some((8, 6));
            s.samples = Some(1);
            s.set = set.iter().map(|s| s.to_string()).collect();
        });
        let emitted = watts(&picture, "emitted");
        let booked: f64 = picture.stats.ledger.iter().skip(1).map(|e| e.watts).sum();
        println!("{name}: {:?}", picture.stats.ledger);
        assert!((booked / emitted - 1.0).abs() < 1e-3, "{name}: {booked} of {emitted} W");
        assert!(watts(&picture, "scattered") > 0.0 && watts(&picture, "landed") > 0.0);
        if name == "pool" {
            // 0.08 to 0.02 a metre, whatever the path.
            let ratio = watts(&picture, "scattered") / watts(&picture, "absorbed");
            assert!((ratio / 4.0 - 1.0).abs() < 1e-3, "scattered {ratio} times as much as absorbed");
        } else {
            assert!(watts(&picture, "absorbed") < 1e-4 * emitted);
        }
    }
    // A medium through which no light comes.
    let mut scene = turbid_flat_pool(0.9);
    scene.media.iter_mut().for_each(|m| m.scattering *= 1e8);
    let picture = picture(request, scene, ((8, 6), 1), &[&set[..], &["reference.paths=refracted"]].concat());
    assert_eq!(watts(&picture, "landed"), 0.0);
    assert_eq!(watts(&picture, "non_finite"), 0.0);
    assert!(layer(&picture.image, "caustic_volume").iter().flatten().all(|v| v.is_finite()));
}

fn equal_bits(request: &Request) {
    let render = |seed: u32| {
        let picture = request.render(foggy_ball(), |s| {
            s.size = Some((16, 12));
            s.samples = Some(2);
            s.seed = seed;
            s.set = vec!["reference.photons=10000".to_string(), "reference.volume_photons=100000".to_string()];
        });
        let bits = layer(&picture.image, "caustic_volume").into_iter().flatten().map(f32::to_bits).collect();
        (bits, watts(&picture, "scattered"))
    };
    let first: (Vec<u32>, f64) = render(7);
    assert_eq!(first, render(7));
    let other = render(8);
    assert_ne!(first.0, other.0);
    // The camera's paths go by the seed, too; the ledger knows of photons alone.
    assert_ne!(first.1, other.1);
}
