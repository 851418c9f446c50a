//! The reference's light in volumes, L S+ V, against quadrature, and itself.

mod common;

use std::path::Path;
use std::process::ExitCode;

use common::pool::{first_water_stretch, flat_water_inscatter};
use common::{Case, Request, layer};
use glam::Vec3;
use nephroid::render::Picture;
use nephroid::scene::{self, Scene};

fn main() -> ExitCode {
    common::run(&[
        Case { name: "flat_water_scatters_as_quadrature_says", needs: &[], disable: "", run: flat_water },
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
    let e = |n: &str, d: &str| std::env::var(n).unwrap_or(d.to_string());
    for asymmetry in [0.0, 0.7] {
        let size: u32 = e("W", "48").parse().unwrap();
        let size = (size, size * 3 / 4);
        let n: u32 = e("N", "8").parse().unwrap();
        let p = format!("reference.photons={}", e("P", "100000"));
        let m = format!("reference.volume_neighbours={}", e("M", "64"));
        let k = format!("reference.volume_points={}", e("K", "1"));
        let picture = picture(
            request,
            turbid(asymmetry as f32),
            (size, n),
            &[&p, &m, &k, "reference.reuse=1", "reference.paths=refracted-once"],
        );
        let found = layer(&picture.image, "caustic_volume");
        let (energy, rel_rmse) = against_quadrature(&found, (size.0 as usize, size.1 as usize), asymmetry);
        println!("g {asymmetry}: energy {energy:.5}, relRMSE {rel_rmse:.4} cpu {}", picture.stats.cpu_seconds);
        for p in &picture.stats.passes { if p.milliseconds > Some(100.0) { println!("{} {:?}", p.name, p.milliseconds); } }
    }
}
