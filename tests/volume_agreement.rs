//! Media that scatter, by different ways that have to agree: grids and none, tiers, back-ends, adaptive sampling.

mod air;
mod common;

use std::path::Path;
use std::process::ExitCode;

use air::{LAMPS, ROOM, SIZE, fog, parse, render};
use common::{Case, Request, layer};
use glam::Vec3;
use nephroid::gpu::Capability;
use nephroid::scene::{self, Bounds, DensityGrid, Emitter, Scene};
use nephroid::technique::TechniqueKind;

/// Of fog with few places a stretch, which two sets of places see otherwise.
const PLACES: f64 = 2e-2;
/// Of the mean of an adaptive picture of one place a stretch; merging each round's fog twice, or not, is far above it.
const ADAPTIVE: f64 = 1e-2;
/// Rounding of f32.
const CLOSED_FORM: f64 = 1e-4;
/// Tiers see the same surfaces but for single pixels.
const TIERS: f64 = 1e-3;

fn main() -> ExitCode {
    common::run(&[
        Case { name: "a_density_of_one_half_is_half_the_coefficients", needs: &[], disable: "", run: even_density },
        Case { name: "the_sun_comes_through_smoke_to_the_water", needs: &[], disable: "", run: sun_on_water },
        Case {
            name: "fog_is_the_same_by_raster_and_rays",
            needs: &[Capability::PreciseRaster],
            disable: "",
            run: raster_and_rays,
        },
        Case { name: "fog_is_the_same_by_all_back_ends", needs: &[], disable: "", run: back_ends },
        Case { name: "adaptive_fog_is_not_biased", needs: &[], disable: "", run: adaptive },
    ])
}

/// Fog and lamps over and in shallow water; with `density`, the fog's and the water's coefficients are twice as large.
fn shallow(density: bool) -> Scene {
    let text = include_str!("../scenes/flat_water.toml");
    let factor = if density { 2.0 } else { 1.0 };
    let mut scene = scene::parse(text, Path::new("scenes/flat_water.toml")).unwrap();
    for medium in &mut scene.media {
        medium.absorption = Vec3::new(0.02, 0.05, 0.1) * factor;
        medium.scattering = Vec3::new(0.1, 0.05, 0.02) * factor;
        medium.asymmetry = 0.6;
        medium.density = density.then_some(0);
    }
    let bounds = Bounds { min: Vec3::splat(-20.0), max: Vec3::splat(20.0) };
    if density {
        scene.densities.push(DensityGrid { bounds, points: [5, 6, 7], values: vec![0.5; 210] });
    }
    scene
}

/// Every caller of a medium's coefficients: walk, direct light, fog, photons, paths of mnee.
fn even_density(request: &Request) {
    for (technique, setting) in [
        (TechniqueKind::Mnee, "mnee.search=footprints"),
        (TechniqueKind::Reference, "reference.photons=20000 reference.volume_photons=20000"),
    ] {
        let picture = |density| {
            let picture = request.render(shallow(density), |s| {
                (s.technique, s.size, s.samples) = (technique, Some((24, 18)), Some(1));
                s.set = setting.split(' ').map(String::from).collect();
            });
            picture.image
        };
        let (even, grid) = (picture(false), picture(true));
        for name in ["direct", "caustic"] {
            let (a, b) = (layer(&even, name), layer(&grid, name));
            let difference = relative(&b, &a);
            println!("{technique:?} {name}: {difference:.1e}");
            assert!(difference < CLOSED_FORM, "{technique:?} {name}: {difference}");
        }
        for name in ["volume", "final"] {
            let difference = relative(&layer(&grid, name), &layer(&even, name));
            assert!(difference < PLACES, "{technique:?} {name}: {difference}");
        }
        assert!(layer(&even, "caustic").iter().any(|p| p[0] > 0.0));
    }
}

/// Smoke between the sun and flat water takes the same part of light by every technique, wherever its rays start.
fn sun_on_water(request: &Request) {
    let text = include_str!("../scenes/flat_water.toml");
    let mut clear = scene::parse(text, Path::new("scenes/flat_water.toml")).unwrap();
    clear.lights[0].emitter = Emitter::Directional { direction: Vec3::NEG_Y, irradiance: Vec3::splat(3.0) };
    let mut smoky = clear.clone();
    smoky.media[0].absorption = Vec3::new(0.1, 0.2, 0.5);
    smoky.media[0].density = Some(0);
    let bounds = Bounds { min: Vec3::new(-50.0, 0.5, -50.0), max: Vec3::new(50.0, 3.5, 50.0) };
    smoky.densities.push(DensityGrid { bounds, points: [2, 4, 3], values: vec![0.7; 24] });
    for (technique, setting) in
        [(TechniqueKind::Mnee, "mnee.search=footprints"), (TechniqueKind::Reference, "reference.photons=20000")]
    {
        let caustic = |scene: &Scene| {
            let picture = request.render(scene.clone(), |s| {
                (s.technique, s.size, s.samples) = (technique, Some((24, 18)), Some(1));
                s.set = vec![setting.to_string()];
            });
            let pixels = layer(&picture.image, "caustic");
            [0, 1, 2].map(|c: usize| pixels.iter().map(|p| f64::from(p[c])).sum::<f64>())
        };
        let (with, without) = (caustic(&smoky), caustic(&clear));
        for (c, absorption) in [0.1, 0.2, 0.5].into_iter().enumerate() {
            let expected = (-absorption * 0.7 * 3.0f64).exp();
            let found = with[c] / without[c];
            println!("{technique:?} {c}: {found:.6} of {expected:.6}");
            assert!((found / expected - 1.0).abs() < CLOSED_FORM, "{technique:?} {c}: {found} of {expected}");
        }
    }
}

fn relative(test: &[[f32; 3]], truth: &[[f32; 3]]) -> f64 {
    let square = |a: f32, b: f32| f64::from(a - b).powi(2);
    let error: f64 = test.iter().zip(truth).flat_map(|(a, b)| (0..3).map(move |c| square(a[c], b[c]))).sum();
    let size: f64 = truth.iter().flatten().map(|&b| square(b, 0.0)).sum();
    (error / size.max(1e-300)).sqrt()
}

/// The pool with fog over murky water, by 4 samples.
fn pool(request: &Request, disable: &str, trace: &str) -> Vec<[f32; 3]> {
    let mut scene = scene::load(Path::new("scenes/pool.toml")).unwrap();
    for medium in &mut scene.media {
        medium.scattering = Vec3::splat(0.1);
    }
    let picture = render(request, scene, |s| {
        s.device = request.without(disable);
        s.trace = trace.parse().unwrap();
        s.camera = Some("above".to_string());
        s.size = Some((48, 36));
        s.samples = Some(4);
    });
    layer(&picture.image, "volume")
}

fn raster_and_rays(request: &Request) {
    let (raster, rays) = (pool(request, "", "bvh"), pool(request, "graphics", "bvh"));
    let difference = relative(&raster, &rays);
    println!("{difference:.1e}");
    assert!(difference < TIERS && rays.iter().any(|p| p[0] > 0.0), "{difference}");
}

fn back_ends(request: &Request) {
    let truth = pool(request, "graphics", "cwbvh");
    let difference = relative(&pool(request, "graphics", "bvh2"), &truth);
    assert!(difference < TIERS && truth.iter().any(|p| p[0] > 0.0), "{difference}");
    if request.info.capabilities.has(Capability::RayQuery) {
        let difference = relative(&pool(request, "graphics", "ray-query"), &truth);
        assert!(difference < TIERS, "{difference}");
    }
}

fn adaptive(request: &Request) {
    // What varies is where in the fog a lamp is looked for: one place a stretch.
    let scene = |samples: u32| {
        // Out of sight: next to a lamp in the picture radiance has no bound.
        let lamps = LAMPS.replace("[0.8, 0.5, 1]", "[3, 3, 1]");
        let mut scene = parse(&format!("{ROOM}{}{lamps}", fog("[0.02, 0.1, 0.3]", "[0.1, 0.05, 0.2]", 0.7)));
        scene.film.volume_samples = samples;
        scene
    };
    let mean = |pixels: Vec<[f32; 3]>, c: usize| pixels.iter().map(|p| f64::from(p[c])).sum::<f64>();
    let truth = render(request, scene(16), |s| s.samples = Some(64));
    let picture = request.render(scene(1), |s| {
        (s.technique, s.size, s.samples, s.adaptive) = (TechniqueKind::Mnee, Some(SIZE), Some(64), true);
    });
    let adaptive = picture.stats.adaptive.unwrap();
    assert!(adaptive.most > adaptive.least, "{adaptive:?}");
    for name in ["volume", "final"] {
        for c in 0..3 {
            let (found, expected) = (layer(&picture.image, name), layer(&truth.image, name));
            let ratio = mean(found, c) / mean(expected, c);
            println!("{name} {c}: {ratio:.5}");
            assert!((ratio - 1.0).abs() < ADAPTIVE, "{name} {c}: {ratio}");
        }
    }
}
