//! The reference's light in volumes, L S+ V, against quadrature, and itself.

mod common;

use std::f64::consts::PI;
use std::path::Path;
use std::process::ExitCode;

use common::pool::{first_water_stretch, flat_water_inscatter};
use common::{Case, Request, layer};
use glam::{DVec3, Vec3};
use nephroid::render::Picture;
use nephroid::scene::{self, Bounds, DensityGrid, Scene};

fn main() -> ExitCode {
    common::run(&[
        Case { name: "flat_water_scatters_as_quadrature_says", needs: &[], disable: "", run: flat_water },
        Case { name: "smoke_scatters_as_quadrature_says", needs: &[], disable: "", run: smoke },
        Case { name: "path_classes_part_the_light_in_volumes", needs: &[], disable: "", run: path_classes },
        Case { name: "what_media_take_is_accounted_for", needs: &[], disable: "", run: ledger },
        Case { name: "equal_seeds_give_equal_bits_in_volumes", needs: &[], disable: "", run: equal_bits },
    ])
}

/// The flat pool with water that absorbs 0.02 and scatters 0.08 of light a metre.
fn turbid(asymmetry: f32) -> Scene {
    let mut scene = scene::load(Path::new("scenes/flat_water.toml")).unwrap();
    let water = scene.media.iter_mut().find(|m| m.name == "water").unwrap();
    water.absorption = Vec3::splat(0.02);
    water.scattering = Vec3::splat(0.08);
    water.asymmetry = asymmetry;
    scene
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

/// Energy ratio and relative RMSE over the pixels that see floor or walls.
fn against_quadrature(found: &[[f32; 3]], (width, height): (usize, usize), asymmetry: f64) -> (f64, f64) {
    let (mut sum, mut expected_sum, mut squares, mut count) = (0.0, 0.0, 0.0, 0);
    for (row, column) in (0..height).flat_map(|row| (0..width).map(move |column| (row, column))) {
        let Some((origin, direction, length)) =
            first_water_stretch(column as f64, row as f64, width as f64, height as f64)
        else {
            continue;
        };
        let expected = flat_water_inscatter(origin, direction, length, (0.02, 0.08, asymmetry));
        let value = f64::from(found[row * width + column][1]);
        sum += value;
        expected_sum += expected;
        squares += (value - expected).powi(2);
        count += 1;
    }
    let mean = expected_sum / f64::from(count);
    (sum / expected_sum, (squares / f64::from(count)).sqrt() / mean)
}

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
    let size = (48, 36);
    let set = ["reference.photons=10000", "reference.volume_photons=100000", "reference.reuse=1"];
    for asymmetry in [0.0, 0.7] {
        let errors = [2, 16].map(|samples| {
            let set = [&set[..], &["reference.paths=refracted-once"]].concat();
            let picture = picture(request, turbid(asymmetry as f32), (size, samples), &set);
            let found = layer(&picture.image, "caustic_volume");
            let (energy, rel_rmse) = against_quadrature(&found, (48, 36), asymmetry);
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

/// Sun straight down through a flat pane into a box of smoke; the smoke's medium is all around, but has density there only.
const PANE: &str = r#"
[[camera]]
name = "c"
position = [0, 0.4, 4]
target = [0, 0.45, 0]
fov_y = 16
medium = "smoke"
[[medium]]
name = "glass"
index = 1.5
[[medium]]
name = "smoke"
index = 1
absorption = [0.5, 0.1, 0]
scattering = [0.5, 1, 2]
asymmetry = 0.5
[[material]]
name = "floor"
kind = "diffuse"
albedo = 1
[[material]]
name = "pane"
kind = "dielectric"
front = "smoke"
back = "glass"
[[object]]
name = "floor"
shape = "plane"
centre = [0, 0, 0]
size = [10, 10]
material = "floor"
[[object]]
name = "pane"
shape = "box"
centre = [0, 1, 0]
size = [3, 0.1, 2]
material = "pane"
[[light]]
name = "sun"
kind = "directional"
direction = [0, -1, 0]
irradiance = [1, 2, 3]
medium = "smoke"
"#;

/// Of 24 rows, those in whose pixels the pane is seen: it begins 0.95 m up, 3 m away and more.
const PANE_ROWS: usize = 4;

/// Where the smoke is, and its density at 5 x 5 x 5 points: none on the box's faces, so that it begins without a step.
const SMOKE_LOWER: DVec3 = DVec3::new(-0.8, 0.1, -0.6);
const SMOKE_UPPER: DVec3 = DVec3::new(0.8, 0.9, 0.6);

fn smoke_value(x: usize, y: usize, z: usize) -> f64 {
    let inside = [x, y, z].iter().all(|&i| (1..4).contains(&i));
    if inside { [3.0, 0.5, 1.0, 2.0, 0.0][(x + 2 * y + 3 * z) % 5] } else { 0.0 }
}

fn smoke_density(at: DVec3) -> f64 {
    let place = (at - SMOKE_LOWER) / (SMOKE_UPPER - SMOKE_LOWER) * 4.0;
    if place.min_element() < 0.0 || place.max_element() > 4.0 {
        return 0.0;
    }
    let low = place.floor().min(DVec3::splat(3.0));
    let part = place - low;
    let corner = |dx: usize, dy: usize, dz: usize| {
        let weight = |d: usize, p: f64| if d == 1 { p } else { 1.0 - p };
        weight(dx, part.x)
            * weight(dy, part.y)
            * weight(dz, part.z)
            * smoke_value(low.x as usize + dx, low.y as usize + dy, low.z as usize + dz)
    };
    (0..8).map(|i| corner(i & 1, (i >> 1) & 1, i >> 2)).sum()
}

/// Radiance of the smoke along a ray, by the midpoint rule: what comes straight down is scattered once.
fn smoke_radiance(origin: DVec3, direction: DVec3, sun: f64, (absorption, scattering, g): (f64, f64, f64)) -> f64 {
    let extinction = absorption + scattering;
    let cosine = -DVec3::NEG_Y.dot(direction);
    let phase = (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cosine).powf(1.5));
    // The smoke is 3.4 to 4.6 m ahead; steps of 1 cm are exact to some 1e-4.
    let (first, step, steps) = (3.2, 0.01, 160);
    let (mut sum, mut depth) = (0.0, 0.0);
    for i in 0..steps {
        let at = origin + (first + (f64::from(i) + 0.5) * step) * direction;
        let density = smoke_density(at);
        if density == 0.0 {
            continue;
        }
        let above = (SMOKE_UPPER.y - at.y) / 60.0;
        let column = |j: i32| smoke_density(at + DVec3::Y * above * (f64::from(j) + 0.5));
        let over: f64 = (0..60).map(column).sum::<f64>() * above;
        let seen = depth + 0.5 * density * step;
        sum += scattering * density * phase * sun * (-extinction * (over + seen)).exp() * step;
        depth += density * step;
    }
    sum
}

fn smoke(request: &Request) {
    let mut scene = scene::parse(PANE, Path::new("test.toml")).unwrap();
    let indices = || (0..125).map(|i| (i % 5, i / 5 % 5, i / 25));
    scene.densities.push(DensityGrid {
        bounds: Bounds { min: SMOKE_LOWER.as_vec3(), max: SMOKE_UPPER.as_vec3() },
        points: [5; 3],
        values: indices().map(|(x, y, z)| smoke_value(x, y, z) as f32).collect(),
    });
    scene.media.iter_mut().find(|m| m.name == "smoke").unwrap().density = Some(0);
    let (width, height) = (32usize, 24usize);
    let picture = request.render(scene, |s| {
        s.size = Some((width as u32, height as u32));
        s.samples = Some(16);
        s.set = ["reference.photons=20000", "reference.volume_photons=400000", "reference.reuse=2"]
            .map(String::from)
            .to_vec();
    });
    let found = layer(&picture.image, "caustic_volume");
    let (origin, target) = (DVec3::new(0.0, 0.4, 4.0), DVec3::new(0.0, 0.45, 0.0));
    let forward = (target - origin).normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let up = right.cross(forward);
    let half = 8f64.to_radians().tan();
    // All orders of reflections within the pane: (1 - R) / (1 + R) with R = 0.04.
    let through = 0.96 / 1.04;
    for (channel, (sun, medium)) in
        [(1.0, (0.5, 0.5, 0.5)), (2.0, (0.1, 1.0, 0.5)), (3.0, (0.0, 2.0, 0.5))].into_iter().enumerate()
    {
        let (mut sum, mut expected_sum, mut squares) = (0.0, 0.0, 0.0);
        // Rows above see the smoke in the pane too.
        let below = PANE_ROWS * width..found.len();
        for index in below.clone() {
            let value = found[index];
            let (row, column) = ((index / width) as f64, (index % width) as f64);
            // A pixel is 3.5 cm where a cell of the grid is 20 cm: four places stand for it.
            let places = [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)].map(|(x, y)| {
                let across = 2.0 * (column + x) / width as f64 - 1.0;
                let along = 1.0 - 2.0 * (row + y) / height as f64;
                let way = forward + right * half * across * (width as f64 / height as f64) + up * half * along;
                smoke_radiance(origin, way.normalize(), sun * through, medium)
            });
            let expected = places.iter().sum::<f64>() / 4.0;
            sum += f64::from(value[channel]);
            expected_sum += expected;
            squares += (f64::from(value[channel]) - expected).powi(2);
        }
        let count = below.len() as f64;
        let (energy, rel_rmse) = (sum / expected_sum, (squares / count).sqrt() / (expected_sum / count));
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

fn watts(picture: &Picture, name: &str) -> f64 {
    picture.stats.ledger.iter().find(|e| e.name == name).unwrap().watts
}

fn ledger(request: &Request) {
    let set = ["reference.photons=20000"];
    for (name, scene) in [("pool", turbid(0.0)), ("ball", foggy_ball())] {
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
    let mut scene = turbid(0.9);
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
        layer(&picture.image, "caustic_volume").into_iter().flatten().map(f32::to_bits).collect::<Vec<u32>>()
    };
    let first = render(7);
    assert_eq!(first, render(7));
    assert_ne!(first, render(8));
}
