//! How far a picture is from the truth, in linear light and to the eye.
//!
//! A display-space picture can hide an estimator that is dark everywhere; the energy ratio cannot.

use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8};
use serde::Serialize;
use thiserror::Error;

use super::tone::to_srgb8;
use super::{Mask, RgbImage};

/// Linear value that the truth's mean is exposed to before FLIP looks: photographic mid grey.
pub const MID_GREY: f64 = 0.18;

/// The figures of one comparison, over the pixels inside the mask and all three channels.
///
/// Pixels of the test that are not finite count as black: they neither poison the figures nor
/// drop out of them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Metrics {
    /// Pixels inside the mask.
    pub pixels: usize,
    /// Root of the mean squared difference, over the truth's mean.
    pub rel_rmse: f64,
    /// Sum of the test over sum of the truth.
    pub energy_ratio: f64,
    /// Mean of test minus truth, over the truth's mean.
    pub bias: f64,
    /// dB, against the truth's largest value; `None` where the pictures are equal.
    pub psnr: Option<f64>,
    /// Mean LDR-FLIP over the mask, 0 (equal) to 1, at 67 pixels per degree. Both pictures are
    /// exposed by [`Metrics::flip_exposure`], clamped to 1 and sRGB encoded; outside the mask
    /// both are mid grey, so that nothing out there is seen.
    pub flip: f64,
    /// Stops that take the truth's mean over the mask to [`MID_GREY`].
    pub flip_exposure: f64,
    /// Pixels of the test inside the mask with a NaN or an infinity.
    pub non_finite_test: usize,
    /// Pixels of the truth with a NaN or an infinity; all of them are outside the mask.
    pub non_finite_truth: usize,
}

/// Why two pictures cannot be compared.
#[derive(Debug, Clone, Error, PartialEq)]
pub enum MetricsError {
    #[error("the {what} is {}x{} pixels and the truth {}x{}; they must be the same",
        found.0, found.1, truth.0, truth.1)]
    Size { what: &'static str, found: (usize, usize), truth: (usize, usize) },
    #[error("the mask has no pixel inside; a pixel is inside where it is at least half white")]
    EmptyMask,
    #[error(
        "the truth has {count} pixels inside the mask that are not finite, the first in column \
         {column}, row {row}; mask them out"
    )]
    NonFiniteTruth { count: usize, column: usize, row: usize },
    #[error("the truth's mean inside the mask is {mean}; relative errors need one above 0")]
    DarkTruth { mean: f64 },
}

/// Compares a picture with the truth inside a mask.
///
/// # Errors
/// Sizes that differ, an empty mask, a truth that is not finite or not positive on average inside
/// the mask.
pub fn compare(test: &RgbImage, truth: &RgbImage, mask: &Mask) -> Result<Metrics, MetricsError> {
    let Sums { pixels, sum_test, sum_truth, mean, rmse, peak } = sums(test, truth, mask)?;
    let gain = MID_GREY / mean;
    Ok(Metrics {
        pixels,
        rel_rmse: rmse / mean,
        energy_ratio: sum_test / sum_truth,
        bias: (sum_test - sum_truth) / sum_truth,
        psnr: (rmse > 0.0).then(|| 20.0 * (peak / rmse).log10()),
        flip: mean_flip(test, truth, mask, gain as f32),
        flip_exposure: gain.log2(),
        non_finite_test: masked(test, mask).filter(|pixel| !finite(pixel)).count(),
        non_finite_truth: truth.pixels.iter().filter(|pixel| !finite(pixel)).count(),
    })
}

/// [`Metrics::rel_rmse`] alone, which takes a fraction of the time.
///
/// # Errors
/// As [`compare`].
pub fn rel_rmse(test: &RgbImage, truth: &RgbImage, mask: &Mask) -> Result<f64, MetricsError> {
    let Sums { mean, rmse, .. } = sums(test, truth, mask)?;
    Ok(rmse / mean)
}

/// What is summed over pixels and channels.
struct Sums {
    pixels: usize,
    sum_test: f64,
    sum_truth: f64,
    /// Of the truth.
    mean: f64,
    rmse: f64,
    /// Of the truth.
    peak: f64,
}

fn sums(test: &RgbImage, truth: &RgbImage, mask: &Mask) -> Result<Sums, MetricsError> {
    let pixels = check(test, truth, mask)?;
    let samples = (3 * pixels) as f64;
    let (mut sum_test, mut sum_truth, mut squares, mut peak) = (0.0, 0.0, 0.0, 0.0_f64);
    for (test, truth) in pairs(test, truth, mask) {
        for (test, truth) in test.into_iter().zip(truth) {
            let (test, truth) = (f64::from(test), f64::from(truth));
            sum_test += test;
            sum_truth += truth;
            squares += (test - truth) * (test - truth);
            peak = peak.max(truth);
        }
    }
    let mean = sum_truth / samples;
    if mean <= 0.0 {
        return Err(MetricsError::DarkTruth { mean });
    }
    Ok(Sums { pixels, sum_test, sum_truth, mean, rmse: (squares / samples).sqrt(), peak })
}

/// The number of pixels inside the mask, where the three go together.
pub(super) fn check(test: &RgbImage, truth: &RgbImage, mask: &Mask) -> Result<usize, MetricsError> {
    let size = (truth.width, truth.height);
    for (what, found) in [("test", (test.width, test.height)), ("mask", (mask.width, mask.height))] {
        if found != size {
            return Err(MetricsError::Size { what, found, truth: size });
        }
    }
    let count = mask.inside.iter().filter(|&&inside| inside).count();
    if count == 0 {
        return Err(MetricsError::EmptyMask);
    }
    let broken = |(pixel, &inside): (&[f32; 3], &bool)| inside && !finite(pixel);
    let at = |start: usize| truth.pixels.iter().zip(&mask.inside).skip(start);
    if let Some(first) = at(0).position(broken) {
        let count = at(first).filter(|&(pixel, inside)| broken((pixel, inside))).count();
        let (column, row) = (first % truth.width, first / truth.width);
        return Err(MetricsError::NonFiniteTruth { count, column, row });
    }
    Ok(count)
}

/// (test, truth) of the pixels inside the mask, in order; broken test pixels are black.
pub(super) fn pairs<'a>(
    test: &'a RgbImage,
    truth: &'a RgbImage,
    mask: &'a Mask,
) -> impl Iterator<Item = ([f32; 3], [f32; 3])> + 'a {
    masked(test, mask).map(mended).zip(masked(truth, mask).copied())
}

fn masked<'a>(image: &'a RgbImage, mask: &'a Mask) -> impl Iterator<Item = &'a [f32; 3]> + 'a {
    image.pixels.iter().zip(&mask.inside).filter_map(|(pixel, &inside)| inside.then_some(pixel))
}

pub(super) fn finite(pixel: &[f32; 3]) -> bool {
    pixel.iter().all(|component| component.is_finite())
}

fn mended(pixel: &[f32; 3]) -> [f32; 3] {
    if finite(pixel) { *pixel } else { [0.0; 3] }
}

fn mean_flip(test: &RgbImage, truth: &RgbImage, mask: &Mask, gain: f32) -> f64 {
    let encode = |image: &RgbImage| {
        let bytes: Vec<[u8; 3]> = (image.pixels.iter().zip(&mask.inside))
            .map(|(pixel, &inside)| {
                let shown = mended(pixel).map(|component| component * gain);
                to_srgb8(if inside { shown } else { [MID_GREY as f32; 3] })
            })
            .collect();
        FlipImageRgb8::with_data(image.width as u32, image.height as u32, bytes.as_flattened())
    };
    let errors = nv_flip::flip(encode(truth), encode(test), DEFAULT_PIXELS_PER_DEGREE).to_vec();
    let inside = || errors.iter().zip(&mask.inside).filter_map(|(&e, &inside)| inside.then_some(e));
    inside().map(f64::from).sum::<f64>() / inside().count() as f64
}
