//! A map of signed error: where a picture is too dark, where too bright, and by how much.
//!
//! Blue is too dark, red too bright, near white agrees. The ramp runs straight in Oklab between
//! ends of equal lightness, so that equal steps of error look equal on either side.

use super::metrics::{self, MetricsError, finite};
use super::tone::{luminance, to_srgb8};
use super::{Mask, RgbImage};

/// Oklab lightness, a, b of the ramp where the test is too dark, equal and too bright.
const TOO_DARK: [f32; 3] = [0.45, -0.03, -0.20];
const EQUAL: [f32; 3] = [0.97, 0.0, 0.0];
const TOO_BRIGHT: [f32; 3] = [0.45, 0.16, 0.09];

/// Encoded sRGB of pixels outside the mask; darker than the white that means agreement.
pub const OUTSIDE: [u8; 3] = [96; 3];
/// Encoded sRGB of pixels where the test is not finite.
pub const NON_FINITE: [u8; 3] = [255, 220, 0];

/// Share of the mask's pixels whose error is within the scale; the rest saturate, so that a few
/// fireflies do not turn everything else white.
const WITHIN_SCALE: f64 = 0.99;

/// A heat map ready to be written.
#[derive(Debug, Clone, PartialEq)]
pub struct HeatMap {
    /// Pixels.
    pub width: usize,
    /// Pixels.
    pub height: usize,
    /// 8-bit sRGB.
    pub pixels: Vec<[u8; 3]>,
    /// The luminance difference shown in the full colours, in the pictures' unit: blue is
    /// -`scale`, red is +`scale`. 1 where the pictures agree everywhere.
    pub scale: f32,
}

/// Maps the luminance of test minus truth inside the mask.
///
/// # Errors
/// As [`metrics::compare`], except that a black truth is fine.
pub fn signed(test: &RgbImage, truth: &RgbImage, mask: &Mask) -> Result<HeatMap, MetricsError> {
    metrics::check(test, truth, mask)?;
    let scale = scale(test, truth, mask);
    let colour = |((test, truth), &inside): ((&[f32; 3], &[f32; 3]), &bool)| {
        if !inside {
            OUTSIDE
        } else if !finite(test) {
            NON_FINITE
        } else {
            ramp((luminance(*test) - luminance(*truth)) / scale)
        }
    };
    let pixels = test.pixels.iter().zip(&truth.pixels).zip(&mask.inside).map(colour).collect();
    Ok(HeatMap { width: truth.width, height: truth.height, pixels, scale })
}

/// The [`WITHIN_SCALE`] quantile of the absolute error, or its maximum where that is 0.
fn scale(test: &RgbImage, truth: &RgbImage, mask: &Mask) -> f32 {
    let mut errors: Vec<f32> =
        metrics::pairs(test, truth, mask).map(|(test, truth)| (luminance(test) - luminance(truth)).abs()).collect();
    errors.sort_by(f32::total_cmp);
    let rank = (errors.len() as f64 * WITHIN_SCALE) as usize;
    let quantile = errors.get(rank).copied().unwrap_or(0.0);
    let largest = errors.last().copied().unwrap_or(0.0);
    [quantile, largest].into_iter().find(|&error| error > 0.0).unwrap_or(1.0)
}

/// The colour of an error in [-1, 1]; what is outside saturates.
fn ramp(error: f32) -> [u8; 3] {
    let end = if error < 0.0 { TOO_DARK } else { TOO_BRIGHT };
    let share = error.abs().min(1.0);
    let mix = |component: usize| EQUAL[component] + (end[component] - EQUAL[component]) * share;
    to_srgb8(oklab_to_linear([mix(0), mix(1), mix(2)]))
}

/// Ottosson's Oklab to linear Rec.709.
fn oklab_to_linear([lightness, a, b]: [f32; 3]) -> [f32; 3] {
    let l = (lightness + 0.396_337_78 * a + 0.215_803_76 * b).powi(3);
    let m = (lightness - 0.105_561_346 * a - 0.063_854_17 * b).powi(3);
    let s = (lightness - 0.089_484_18 * a - 1.291_485_5 * b).powi(3);
    [
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_94 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_38 * s,
        -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s,
    ]
}
