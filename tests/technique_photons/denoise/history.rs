//! What is kept from set to set.

use glam::{Affine3A, DVec3, Vec3};
use nephroid::technique::photons::CameraTexel;
use nephroid::technique::photons::denoise::DenoiseOptions;

use super::bed::{Bed, HISTORY, OPTIONS, SIDE, TEXELS, error, grains, wall, way};
use crate::common::{Request, assert_valid};

/// Of a mean of few floats.
const ROUNDING: f64 = 1e-5;

pub fn means(request: &Request) {
    let device = request.open();
    let texels = [wall(2.0, 0); TEXELS];
    let sets: Vec<Vec<f64>> = (0..6).map(|seed| grains(seed, |_| 1.0, 1.0)).collect();
    for alpha in [0.0, 0.5] {
        let mut bed = Bed::new(&device, DenoiseOptions { alpha: alpha as f32, ..HISTORY }, &texels);
        let mut expected = vec![0.0; TEXELS];
        for (number, set) in sets.iter().enumerate() {
            let share = f64::max(1.0 / (number + 1) as f64, alpha);
            expected.iter_mut().zip(set).for_each(|(mean, v)| *mean += share * (v - *mean));
            // A restart after which the camera sees the same is no other than a sample after a sample.
            if number % 2 == 1 {
                bed.go_on(Vec3::ZERO, &texels, &[Affine3A::IDENTITY; 2]);
            }
            let found = bed.filter(set);
            assert!(error(&found, &expected) < ROUNDING, "set {number}: {}", error(&found, &expected));
        }
    }
    assert_valid(&device);
}

/// A square, instance 1, at depth 1 before a wall, instance 0, at depth 2: where it is from `eye` when moved by `moved`.
fn scene(eye: DVec3, moved: DVec3) -> Vec<CameraTexel> {
    let seen = |i: usize| if on_square(eye + way(i), moved) { wall(1.0, 1) } else { wall(2.0, 0) };
    (0..TEXELS).map(seen).collect()
}

fn on_square(point: DVec3, moved: DVec3) -> bool {
    let from = (point - moved).abs();
    from.x < 0.26 && from.y < 0.26
}

/// Whether a camera at the origin saw a point within its picture, by half a texel's room; `None` at the borders.
fn saw(point: DVec3, moved: DVec3) -> Option<bool> {
    let at = point.truncate() / -point.z;
    let edge = 1.5 * 2.0 / f64::from(SIDE);
    let inside = at.abs().max_element() - 1.0;
    let square = (at - moved.truncate()).abs().max_element() - 0.26;
    let hidden = point.z < -1.5 && square < 0.0;
    let clear = inside.abs() > edge && (point.z > -1.5 || square.abs() > edge);
    clear.then_some(inside < 0.0 && !hidden)
}

/// A set of 4 everywhere, then one of 0 from elsewhere: 2 where the history was kept, and 0 where it was not.
fn check(found: &[f64], expected: impl Fn(usize) -> Option<bool>) {
    let mut seen = [0, 0];
    for (i, light) in found.iter().enumerate() {
        let Some(kept) = expected(i) else { continue };
        assert!((light - if kept { 2.0 } else { 0.0 }).abs() < ROUNDING, "texel {i}: {light}, kept: {kept}");
        seen[usize::from(kept)] += 1;
    }
    assert!(seen[0] > 10 && seen[1] > 100, "dropped and kept: {seen:?}");
}

pub fn camera(request: &Request) {
    let device = request.open();
    let mut bed = Bed::new(&device, HISTORY, &scene(DVec3::ZERO, DVec3::ZERO));
    bed.filter(&[4.0; TEXELS]);
    let eye = DVec3::new(0.45, 0.21, 0.0);
    let texels = scene(eye, DVec3::ZERO);
    bed.go_on(eye.as_vec3(), &texels, &[Affine3A::IDENTITY; 2]);
    check(&bed.filter(&[0.0; TEXELS]), |i| {
        let point = eye + way(i) * f64::from(texels[i].depth);
        // At the square's own border its history is that of a part of the texels around.
        if texels[i].instance == 1 && (point.truncate().abs().max_element() - 0.26).abs() < 0.1 {
            return None;
        }
        saw(point, DVec3::ZERO)
    });
    assert_valid(&device);
}

pub fn object(request: &Request) {
    let device = request.open();
    let mut bed = Bed::new(&device, HISTORY, &scene(DVec3::ZERO, DVec3::ZERO));
    bed.filter(&[4.0; TEXELS]);
    let moved = DVec3::new(0.31, 0.0, 0.0);
    let texels = scene(DVec3::ZERO, moved);
    let transforms = [Affine3A::IDENTITY, Affine3A::from_translation(moved.as_vec3())];
    // Twice, with no set between: the history still lies on what was seen when it was made.
    bed.go_on(Vec3::X, &texels, &[Affine3A::IDENTITY; 2]);
    bed.go_on(Vec3::ZERO, &texels, &transforms);
    check(&bed.filter(&[0.0; TEXELS]), |i| {
        let point = way(i) * f64::from(texels[i].depth);
        let border = ((point - moved).truncate().abs().max_element() - 0.26).abs() < 0.1;
        match texels[i].instance {
            1 => (!border).then_some(true),
            _ => saw(point, DVec3::ZERO),
        }
    });
    assert_valid(&device);
}

/// A bright band, of columns `from` to `from + 6`.
fn band(from: usize) -> impl Fn(usize) -> f64 {
    move |i| if (from..from + 6).contains(&(i % SIDE as usize)) { 4.0 } else { 0.2 }
}

/// Error against a band at `from`, after sets of which the last three have it there and those before elsewhere.
fn lag(request: &Request, adaptive: bool) -> f64 {
    let options = DenoiseOptions { temporal: true, adaptive, alpha: 0.05, ..OPTIONS };
    let mut bed = Bed::new(&request.open(), options, &[wall(2.0, 0); TEXELS]);
    let mut found = Vec::new();
    for seed in 0..23 {
        found = bed.filter(&grains(seed, band(if seed < 20 { 6 } else { 18 }), 1.0));
    }
    error(&found, &(0..TEXELS).map(band(18)).collect::<Vec<_>>())
}

/// Of a fixed history's lag, what an adaptive one has.
const LAG: f64 = 0.5;

pub fn change(request: &Request) {
    let [fixed, adaptive] = [false, true].map(|adaptive| lag(request, adaptive));
    assert!(adaptive < LAG * fixed, "off by {adaptive}, a fixed history by {fixed}");
    assert_valid(&request.open());
}

/// Of the light, what adapting to noise may add or take; and how much more noise it may leave.
const ENERGY: f64 = 0.01;
const MORE_NOISE: f64 = 1.15;

pub fn steady(request: &Request) {
    let device = request.open();
    let truth: Vec<f64> = (0..TEXELS).map(band(10)).collect();
    let [fixed, adaptive] = [false, true].map(|adaptive| {
        let options = DenoiseOptions { adaptive, alpha: 0.0, ..HISTORY };
        let mut bed = Bed::new(&device, options, &[wall(2.0, 0); TEXELS]);
        let mut found = Vec::new();
        for seed in 0..40 {
            found = bed.filter(&grains(seed, band(10), 0.5));
        }
        found
    });
    let ratio = adaptive.iter().sum::<f64>() / fixed.iter().sum::<f64>();
    assert!((ratio - 1.0).abs() < ENERGY, "energy {ratio}");
    let [fixed, adaptive] = [error(&fixed, &truth), error(&adaptive, &truth)];
    assert!(adaptive < MORE_NOISE * fixed, "off by {adaptive}, a fixed history by {fixed}");
    assert_valid(&device);
}
