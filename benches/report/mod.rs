//! What benchmarks share: what they are asked for, the truth that they hold pictures against, and what they write beside
//! their tables, JSON with the commit; devices and drivers are in the results.
#![allow(dead_code, reason = "each benchmark uses its part")]

pub mod options;
pub mod parts;
pub mod run;

use std::error::Error;
use std::path::Path;

use nephroid::image::metrics::{Metrics, compare};
use nephroid::image::{self, Mask, RgbImage, png};
use nephroid::render::Renderer;

/// What pictures are held against.
pub struct Truth {
    picture: RgbImage,
    mask: Mask,
}

impl Truth {
    /// The layer of that name where the file has one, else its final or only one. Holds where `mask` says or else the picture's
    /// own layer `mask`, or everywhere.
    pub fn read(path: &Path, layer: &str, mask: Option<&Path>) -> Result<Self, Box<dyn Error>> {
        let image = image::read(path)?;
        let picture = image.select(path, image.layer(layer).map(|found| found.name.as_str()))?;
        let mask = match mask {
            Some(mask) => png::read_mask(mask)?,
            None => mask_layer(&image, &picture),
        };
        Ok(Truth { picture, mask })
    }

    /// A picture that holds everywhere.
    pub fn of(picture: RgbImage) -> Self {
        Truth { mask: Mask::full(picture.width, picture.height), picture }
    }

    /// Those where it holds; `None` for others.
    pub fn pixels(&self) -> impl Iterator<Item = Option<&[f32; 3]>> {
        self.picture.pixels.iter().zip(&self.mask.inside).map(|(pixel, inside)| inside.then_some(pixel))
    }

    /// Pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.picture.width as u32, self.picture.height as u32)
    }

    /// Of a layer of the samples so far.
    pub fn error(&self, renderer: &Renderer, layer: &str) -> Result<Metrics, Box<dyn Error>> {
        let picture = renderer.finish()?.image.select(Path::new("the picture"), Some(layer))?;
        Ok(compare(&picture, &self.picture, &self.mask)?)
    }
}

/// Writes `target/bench/<name>.json`.
pub fn write(name: &str, results: serde_json::Value) -> Result<(), Box<dyn Error>> {
    let report = serde_json::json!({
        "commit": commit(),
        "results": results,
    });
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/bench");
    std::fs::create_dir_all(&folder)?;
    let temporary = folder.join(format!("{name}.json.tmp"));
    std::fs::write(&temporary, serde_json::to_string_pretty(&report)?)?;
    std::fs::rename(temporary, folder.join(format!("{name}.json")))?;
    Ok(())
}

/// The checkout's commit; empty outside of one.
fn commit() -> String {
    let git = std::process::Command::new("git").args(["rev-parse", "HEAD"]).output();
    git.map(|o| String::from_utf8_lossy(&o.stdout).trim().to_string()).unwrap_or_default()
}

/// The mask that a truth carries with it, or every pixel.
fn mask_layer(truth: &image::LayeredImage, like: &RgbImage) -> Mask {
    let samples = truth.layer("mask").and_then(|layer| layer.channels.first()).map(|c| c.samples.as_slice());
    match samples {
        Some(samples) => {
            Mask { width: like.width, height: like.height, inside: samples.iter().map(|&s| s > 0.5).collect() }
        }
        None => Mask::full(like.width, like.height),
    }
}
