//! What the wavelet does to one set.

use glam::DVec3;
use nephroid::technique::photons::CameraTexel;

use super::bed::{Bed, OPTIONS, SIDE, TEXELS, error, grains, nothing, texel, wall, way};
use crate::common::{Request, assert_valid};

/// Rounding of sums of 25 floats over five levels.
const ROUNDING: f64 = 2e-6;
/// Of the light beside an edge, what may come over a step of ten texels' widths: e^-10, five times.
const OVER_STEP: f64 = 1e-3;
/// Of the noise, what is left: a five-level wavelet averages over hundreds of texels, but for what its stops hold back.
const LEFT: f64 = 0.35;

/// A floor that slants away from the camera under a wall.
fn corner() -> Vec<CameraTexel> {
    // The plane y = -0.5 is at depth 0.5 / -way.y, the wall at 2.
    let seen = |i: usize| {
        let depth = -0.5 / way(i).y;
        if depth > 0.0 && depth < 2.0 { texel(depth, DVec3::Y, 0) } else { wall(2.0, 1) }
    };
    (0..TEXELS).map(seen).collect()
}

pub fn flat(request: &Request) {
    let device = request.open();
    let mut texels = corner();
    texels[..40].fill(nothing());
    for temporal in [false, true] {
        let mut bed =
            Bed::new(&device, nephroid::technique::photons::denoise::DenoiseOptions { temporal, ..OPTIONS }, &texels);
        for _ in 0..3 {
            for (i, light) in bed.filter(&[3.7; TEXELS]).into_iter().enumerate() {
                let expected = if i < 40 && temporal { 0.0 } else { 3.7 };
                assert!(i < 40 || (light / expected - 1.0).abs() < ROUNDING, "texel {i}: {light}");
            }
        }
    }
    assert_valid(&device);
}

pub fn edges(request: &Request) {
    let device = request.open();
    let is_left = |i: usize| i % (SIDE as usize) < 16;
    // What meets it at a right angle, and what is parallel ten texels' widths behind.
    let behind = 1.0 + 10.0 * 2.0 / f64::from(SIDE);
    let beside: [(CameraTexel, f64); 2] = [(texel(1.0, DVec3::X, 0), 0.0), (wall(behind, 0), OVER_STEP)];
    for (other, most) in beside {
        let texels: Vec<CameraTexel> = (0..TEXELS).map(|i| if is_left(i) { wall(1.0, 0) } else { other }).collect();
        let light = grains(1, |i| if is_left(i) { 1.0 } else { 0.0 }, 1.0);
        let found = Bed::new(&device, OPTIONS, &texels).filter(&light);
        let leaked = (0..TEXELS).filter(|i| !is_left(*i)).map(|i| found[i]).fold(0.0, f64::max);
        assert!(leaked <= most, "{leaked} of 1 leaked where {most} may");
        let own: f64 = (0..TEXELS).filter(|i| is_left(*i)).map(|i| (found[i] - light[i]).abs()).sum();
        assert!(own > 0.1 * TEXELS as f64, "nothing was filtered: {own}");
    }
    assert_valid(&device);
}

pub fn flux(request: &Request) {
    let device = request.open();
    let texels = corner();
    let light = grains(2, |i| 1.0 + (i % 7) as f64, 0.5);
    let found = Bed::new(&device, OPTIONS, &texels).filter(&light);
    // Area of a surface over a texel: depth squared over the cosine to it.
    let area = |i: usize| {
        let normal = if texels[i].instance == 0 { DVec3::Y } else { DVec3::Z };
        f64::from(texels[i].depth).powi(2) / normal.dot(way(i)).abs()
    };
    let sum = |light: &[f64]| light.iter().enumerate().map(|(i, v)| v * area(i)).sum::<f64>();
    let ratio = sum(&found) / sum(&light);
    assert!((ratio - 1.0).abs() < 1e-5, "flux is {ratio} of what it was");
    assert!(error(&found, &light) > 0.3, "nothing was filtered");
    assert_valid(&device);
}

pub fn noise(request: &Request) {
    let device = request.open();
    let texels = [wall(2.0, 0); TEXELS];
    let light = grains(3, |_| 1.0, 1.0);
    let found = Bed::new(&device, OPTIONS, &texels).filter(&light);
    assert_eq!(found, Bed::new(&device, OPTIONS, &texels).filter(&light), "equal inputs give equal bits");
    let mean = light.iter().sum::<f64>() / TEXELS as f64;
    let [raw, filtered] = [&light, &found].map(|light| error(light, &[mean; TEXELS]));
    assert!(filtered < LEFT * raw, "{filtered} of {raw} are left");
    assert_valid(&device);
}
