//! `nephroid compare`: how far a picture is from the truth.

use std::fmt;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use thiserror::Error;

use crate::image::metrics::{self, Metrics, MetricsError};
use crate::image::{self, ImageError, Mask, heatmap, png};

/// Compare a picture with the truth: relative RMSE, energy ratio, bias, PSNR and FLIP
#[derive(Debug, Clone, Args)]
pub struct CompareArgs {
    /// The picture to judge (.exr, or .png, which is taken as sRGB)
    pub test: PathBuf,
    /// The picture to judge it by
    pub truth: PathBuf,
    /// The layer of TEST to compare, with the same layer of TRUTH or, where it has none, its RGB
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
    /// Compare white pixels only
    #[arg(long, value_name = "PNG")]
    pub mask: Option<PathBuf>,
    /// Print one JSON object instead of a table
    #[arg(long)]
    pub json: bool,
    /// Write a map of the signed error: blue too dark, red too bright, grey masked out
    #[arg(long, value_name = "PNG")]
    pub heatmap: Option<PathBuf>,
}

/// Why a comparison failed.
#[derive(Debug, Error)]
pub enum CompareError {
    #[error(transparent)]
    Image(#[from] ImageError),
    #[error("{test} cannot be compared with {truth}: {reason}")]
    Metrics { test: PathBuf, truth: PathBuf, reason: MetricsError },
    #[error("{path}: a heat map is a PNG; give it a name that ends in .png")]
    HeatMapExtension { path: PathBuf },
    #[error("the result cannot be printed: {0}")]
    Print(#[from] io::Error),
}

/// What `compare` found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    pub test: PathBuf,
    pub truth: PathBuf,
    /// The layer of the test.
    pub layer: String,
    #[serde(flatten)]
    pub metrics: Metrics,
    /// Luminance difference of the heat map's full colours, where one was written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heatmap_scale: Option<f32>,
}

/// Compares and prints to standard output.
///
/// # Errors
/// Files that cannot be read or written, or pictures that do not go together.
pub fn run(args: &CompareArgs) -> Result<(), CompareError> {
    let report = compare(args)?;
    let mut output = io::stdout().lock();
    if args.json {
        serde_json::to_writer(&mut output, &report).map_err(io::Error::from)?;
        writeln!(output)?;
    } else {
        write!(output, "{report}")?;
    }
    Ok(output.flush()?)
}

/// Compares and writes the heat map, and prints nothing.
///
/// # Errors
/// As [`run`].
pub fn compare(args: &CompareArgs) -> Result<Report, CompareError> {
    if let Some(path) = &args.heatmap
        && image::atomic::check(path)? != image::Format::Png
    {
        return Err(CompareError::HeatMapExtension { path: path.clone() });
    }
    let layer = args.layer.as_deref();
    let test_file = image::read(&args.test)?;
    let layer_name = test_file.find(&args.test, layer)?.name.clone();
    let test = test_file.select(&args.test, layer)?;
    let truth = truth(&args.truth, layer)?;
    let mask = match &args.mask {
        Some(path) => png::read_mask(path)?,
        None => Mask::full(truth.width, truth.height),
    };
    let unlike = |reason| CompareError::Metrics { test: args.test.clone(), truth: args.truth.clone(), reason };
    let metrics = metrics::compare(&test, &truth, &mask).map_err(unlike)?;
    let mut heatmap_scale = None;
    if let Some(path) = &args.heatmap {
        let map = heatmap::signed(&test, &truth, &mask).map_err(unlike)?;
        png::write(path, map.width, map.height, &map.pixels)?;
        heatmap_scale = Some(map.scale);
    }
    Ok(Report { test: args.test.clone(), truth: args.truth.clone(), layer: layer_name, metrics, heatmap_scale })
}

fn truth(path: &Path, layer: Option<&str>) -> Result<image::RgbImage, ImageError> {
    let file = image::read(path)?;
    let shared = layer.filter(|name| file.layer(name).is_some());
    file.select(path, shared)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let m = &self.metrics;
        let psnr = m.psnr.map_or("equal".to_owned(), |psnr| format!("{psnr:.2} dB"));
        let flip = format!("{:.5} (at {:+.2} stops)", m.flip, m.flip_exposure);
        let non_finite = format!("{} in test, {} in truth", m.non_finite_test, m.non_finite_truth);
        let mut rows = vec![
            ("test", self.test.display().to_string()),
            ("truth", self.truth.display().to_string()),
            ("layer", self.layer.clone()),
            ("pixels", m.pixels.to_string()),
            ("relative RMSE", format!("{:.4} %", 100.0 * m.rel_rmse)),
            ("energy ratio", format!("{:.6}", m.energy_ratio)),
            ("bias", format!("{:+.4} %", 100.0 * m.bias)),
            ("PSNR", psnr),
            ("FLIP", flip),
            ("non-finite", non_finite),
        ];
        if let Some(scale) = self.heatmap_scale {
            rows.push(("heat map", format!("blue {:.5}, red {scale:+.5}", -scale)));
        }
        rows.iter().try_for_each(|(name, value)| writeln!(f, "{name:<14} {value}"))
    }
}
