//! The metrics against closed forms, and what they refuse.

use nephroid::image::heatmap::{self, NON_FINITE, OUTSIDE};
use nephroid::image::metrics::{self, Metrics, MetricsError};
use nephroid::image::{Mask, RgbImage};

const SIZE: usize = 64;
/// Relative: inputs are rounded to f32, sums are in f64.
const ROUNDING: f64 = 1e-6;

fn image(pixel: impl Fn(usize, usize) -> [f32; 3]) -> RgbImage {
    let pixels = (0..SIZE * SIZE).map(|i| pixel(i % SIZE, i / SIZE)).collect();
    RgbImage { width: SIZE, height: SIZE, pixels }
}

/// Bands four pixels wide, so that a shift by one pixel is seen.
fn bands() -> RgbImage {
    image(|column, row| {
        let value = if column / 4 % 2 == 0 { 0.3 } else { 0.7 };
        [value, value * 0.5, 0.1 + row as f32 / 100.0]
    })
}

fn all() -> Mask {
    Mask::full(SIZE, SIZE)
}

fn compared(test: &RgbImage, truth: &RgbImage) -> Metrics {
    metrics::compare(test, truth, &all()).unwrap()
}

fn assert_near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} is not {expected} +- {tolerance}");
}

/// Uniform in [0, 1), from a counter (SplitMix64).
fn uniform(counter: u64) -> f64 {
    let mut bits = counter.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((bits ^ (bits >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

#[test]
fn equal_pictures_have_no_error() {
    let found = compared(&bands(), &bands());
    assert_eq!(found.pixels, SIZE * SIZE);
    assert_eq!((found.rel_rmse, found.energy_ratio, found.bias), (0.0, 1.0, 0.0));
    assert_eq!((found.psnr, found.flip), (None, 0.0));
    assert_eq!((found.non_finite_test, found.non_finite_truth), (0, 0));
}

#[test]
fn a_scaled_flat_picture_has_closed_forms() {
    let truth = image(|_, _| [0.5; 3]);
    let found = compared(&image(|_, _| [0.55; 3]), &truth);
    assert_near(found.rel_rmse, 0.1, ROUNDING);
    assert_near(found.energy_ratio, 1.1, ROUNDING);
    assert_near(found.bias, 0.1, ROUNDING);
    // The peak is 0.5 and the RMSE a tenth of it: 20 dB.
    assert_near(found.psnr.unwrap(), 20.0, 1e-4);
    assert_near(found.flip_exposure, (0.18_f64 / 0.5).log2(), ROUNDING);
}

#[test]
fn a_scaled_picture_errs_by_its_root_mean_square() {
    let truth = bands();
    let dark = image(|column, row| truth.pixels[row * SIZE + column].map(|value| 0.75 * value));
    let values: Vec<f64> = truth.pixels.iter().flatten().map(|&value| f64::from(value)).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let root = (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
    let found = compared(&dark, &truth);
    assert_near(found.rel_rmse, 0.25 * root / mean, ROUNDING);
    assert_near(found.energy_ratio, 0.75, ROUNDING);
    assert_near(found.bias, -0.25, ROUNDING);
}

#[test]
fn noise_of_known_deviation_is_measured() {
    const SIGMA: f64 = 0.05;
    // Standard errors over 12288 samples: 0.64 % of sigma, and sigma / 110 of the mean; five of each.
    const DEVIATION_TOLERANCE: f64 = 0.032;
    const BIAS_TOLERANCE: f64 = 5.0 * SIGMA / 110.0;
    let truth = image(|_, _| [1.0; 3]);
    let noisy = image(|column, row| {
        // Twelve uniforms make a variance of one.
        let normal = |sample: usize| (0..12).map(|i| uniform((sample * 12 + i) as u64)).sum::<f64>() - 6.0;
        let first = 3 * (row * SIZE + column);
        [0, 1, 2].map(|component| (1.0 + SIGMA * normal(first + component)) as f32)
    });
    let found = compared(&noisy, &truth);
    assert_near(found.rel_rmse / SIGMA, 1.0, DEVIATION_TOLERANCE);
    assert_near(found.bias, 0.0, BIAS_TOLERANCE);
    assert_near(found.energy_ratio - 1.0, found.bias, ROUNDING);
}

#[test]
fn flip_sees_a_shift_by_one_pixel() {
    let truth = bands();
    let shifted = image(|column, row| truth.pixels[row * SIZE + (column + 1) % SIZE]);
    let found = compared(&shifted, &truth);
    // 0.05 of 1 is plain to the eye in FLIP's terms; a shift moves a quarter of these edges' pixels.
    assert!(found.flip > 0.05, "FLIP {}", found.flip);
    assert!(found.flip < 1.0);
    assert_near(found.energy_ratio, 1.0, ROUNDING);
}

#[test]
fn flip_does_not_depend_on_the_unit() {
    let (truth, other) = (bands(), image(|column, _| [column as f32 / 64.0; 3]));
    let scaled = |image: &RgbImage| RgbImage {
        pixels: image.pixels.iter().map(|pixel| pixel.map(|value| value * 1024.0)).collect(),
        ..*image
    };
    let (plain, large) = (compared(&other, &truth), compared(&scaled(&other), &scaled(&truth)));
    assert_near(plain.flip, large.flip, ROUNDING);
    assert_near(plain.flip_exposure, large.flip_exposure + 10.0, ROUNDING);
}

#[test]
fn nothing_outside_the_mask_counts() {
    let mut mask = all();
    let left = |i: usize| i % SIZE < SIZE / 2;
    mask.inside = (0..SIZE * SIZE).map(left).collect();
    let truth = bands();
    let test = image(|column, row| truth.pixels[row * SIZE + column].map(|value| 0.9 * value));
    let clean = metrics::compare(&test, &truth, &mask).unwrap();
    let spoil = |image: &RgbImage, value: f32| {
        let mut image = image.clone();
        for (i, pixel) in image.pixels.iter_mut().enumerate().filter(|(i, _)| !left(*i)) {
            *pixel = if i % 2 == 0 { [value; 3] } else { [f32::NAN; 3] };
        }
        image
    };
    let spoilt = metrics::compare(&spoil(&test, 9.0), &spoil(&truth, -3.0), &mask).unwrap();
    assert_eq!(spoilt, Metrics { non_finite_truth: SIZE * SIZE / 4, ..clean });
    assert_eq!(clean.pixels, SIZE * SIZE / 2);
    assert_near(clean.energy_ratio, 0.9, ROUNDING);
}

#[test]
fn broken_pixels_of_the_test_count_as_black() {
    let truth = image(|_, _| [0.5; 3]);
    let mut broken = truth.clone();
    broken.pixels[5] = [f32::NAN, 0.5, 0.5];
    broken.pixels[9] = [0.5, f32::NEG_INFINITY, 0.5];
    let found = compared(&broken, &truth);
    assert_eq!(found.non_finite_test, 2);
    let count = (SIZE * SIZE) as f64;
    assert_near(found.energy_ratio, 1.0 - 2.0 / count, ROUNDING);
    assert_near(found.rel_rmse, (2.0 / count).sqrt(), ROUNDING);
}

#[test]
fn what_cannot_be_compared_is_told() {
    let truth = bands();
    let small = RgbImage { width: 2, height: 3, pixels: vec![[1.0; 3]; 6] };
    let told = |test: &RgbImage, truth: &RgbImage, mask: &Mask| {
        let error = metrics::compare(test, truth, mask).unwrap_err();
        assert_eq!(heatmap::signed(test, truth, mask).err().unwrap_or(error.clone()), error);
        error.to_string()
    };
    assert_eq!(told(&small, &truth, &all()), "the test is 2x3 pixels and the truth 64x64; they must be the same");
    assert_eq!(
        told(&truth, &truth, &Mask::full(64, 63)),
        "the mask is 64x63 pixels and the truth 64x64; they must be the same"
    );
    let nothing = Mask { inside: vec![false; SIZE * SIZE], ..all() };
    assert!(told(&truth, &truth, &nothing).starts_with("the mask has no pixel inside"));
    let mut broken = truth.clone();
    broken.pixels[SIZE + 2][1] = f32::NAN;
    broken.pixels[SIZE + 9][0] = f32::INFINITY;
    assert_eq!(
        told(&truth, &broken, &all()),
        "the truth has 2 pixels inside the mask that are not finite, the first in column 2, row \
         1; mask them out"
    );
    let black = image(|_, _| [0.0; 3]);
    let error = metrics::compare(&truth, &black, &all()).unwrap_err();
    assert_eq!(error, MetricsError::DarkTruth { mean: 0.0 });
}

#[test]
fn the_heat_map_tells_sign_size_and_mask() {
    let truth = image(|_, _| [0.5; 3]);
    // A tenth of a unit too dark on top, too bright below, one firefly that must not set the scale.
    let mut test = image(|_, row| [if row < SIZE / 2 { 0.4 } else { 0.6 }; 3]);
    test.pixels[0] = [1000.0; 3];
    test.pixels[1] = [f32::NAN; 3];
    test.pixels[3] = [0.5; 3];
    let mut mask = all();
    mask.inside[2] = false;
    let map = heatmap::signed(&test, &truth, &mask).unwrap();
    // The broken pixel counts as black, 0.5 off; one such pixel is within the share left out.
    assert_near(f64::from(map.scale), 0.1, ROUNDING);
    assert_eq!((map.pixels[1], map.pixels[2]), (NON_FINITE, OUTSIDE));
    let [[r, _, b], [too_bright_r, _, too_bright_b]] = [map.pixels[4], map.pixels[SIZE * SIZE - 1]];
    assert!(b > 2 * r.max(1), "too dark is blue, not {:?}", map.pixels[4]);
    assert!(too_bright_r > 2 * too_bright_b, "too bright is red");
    let equal = map.pixels[3];
    assert!(equal.iter().all(|&level| level > 235), "agreement is near white, not {equal:?}");
    assert_eq!(map.pixels[0], map.pixels[SIZE * SIZE - 1], "a firefly saturates");
    assert_eq!(heatmap::signed(&truth, &truth, &all()).unwrap().scale, 1.0);
}
