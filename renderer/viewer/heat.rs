//! Where the picture is too dark or too bright, against a truth from a file.

use std::path::Path;
use std::time::{Duration, Instant};

use super::pane::Pane;
use super::state::Wish;
use crate::image::{self, FINAL_LAYER, ImageError, LayeredImage, Mask, RgbImage, heatmap, metrics};

/// Of the time, what making heat maps may take.
const SHARE: u32 = 8;

/// A truth, and how far the picture is from it.
pub struct Heat {
    truth: LayeredImage,
    path: std::path::PathBuf,
    /// Layers that can be compared.
    pub layers: Vec<String>,
    pub layer: String,
    /// Whether the map is shown in the picture's place.
    pub shown: bool,
    pub map: Option<Map>,
    made: Option<(Instant, Duration)>,
    /// Of the latest map.
    version: u64,
}

/// A heat map of the picture after some samples.
pub struct Map {
    pub samples: u32,
    restarts: u64,
    pub layer: String,
    /// Pixels.
    pub size: (u32, u32),
    /// 8-bit sRGB.
    pub pixels: Vec<[u8; 3]>,
    /// What is wrong, or relative RMSE and the luminance difference of the full colours.
    pub result: Result<(f64, f32), String>,
    pub version: u64,
}

impl Heat {
    /// Reads the truth.
    ///
    /// # Errors
    /// Those of the file, or that no layer of it is a picture.
    pub fn new(path: &Path) -> Result<Self, ImageError> {
        let truth = image::read(path)?;
        let colours = truth.layers.iter().filter(|layer| layer.to_rgb().is_some());
        let layers: Vec<String> = colours.map(|layer| layer.name.clone()).collect();
        let wanted = [FINAL_LAYER, "caustic"].into_iter().find(|name| layers.iter().any(|layer| layer == name));
        let Some(layer) = wanted.map(str::to_string).or_else(|| layers.first().cloned()) else {
            truth.select(path, None)?;
            return Err(ImageError::Read { path: path.to_owned(), reason: "it holds no picture".to_string() });
        };
        Ok(Heat { truth, path: path.to_owned(), layers, layer, shown: false, map: None, made: None, version: 0 })
    }

    /// The truth's pixels.
    pub fn size(&self) -> (u32, u32) {
        self.truth.layer(&self.layer).map_or((1, 1), |layer| (layer.width as u32, layer.height as u32))
    }

    pub fn name(&self) -> String {
        self.path.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// Makes the map anew where the picture has changed and the last one is long enough ago, or where `now` asks for it. A
    /// map of another picture than the wish's goes at once.
    pub fn update(&mut self, pane: &Pane, wish: &Wish, now: bool) {
        if self.map.as_ref().is_some_and(|map| map.restarts != pane.restarts) || !pane.follows(wish) {
            self.map = None;
        }
        if !pane.follows(wish) {
            return;
        }
        let samples = pane.done();
        let current = self.map.as_ref().is_some_and(|map| map.samples == samples && map.layer == self.layer);
        let early = self.made.is_some_and(|(at, cost)| at.elapsed() < cost * SHARE);
        if !self.shown || current || samples == 0 || (early && !now) {
            return;
        }
        let started = Instant::now();
        self.version += 1;
        let empty = Map {
            samples,
            restarts: pane.restarts,
            layer: self.layer.clone(),
            size: (1, 1),
            pixels: vec![heatmap::OUTSIDE],
            result: Err(String::new()),
            version: self.version,
        };
        self.map = Some(match self.compare(pane) {
            Ok((heat, error)) => Map {
                size: (heat.width as u32, heat.height as u32),
                pixels: heat.pixels,
                result: Ok((error, heat.scale)),
                ..empty
            },
            Err(reason) => Map { result: Err(reason), ..empty },
        });
        self.made = Some((Instant::now(), started.elapsed()));
    }

    fn compare(&self, pane: &Pane) -> Result<(heatmap::HeatMap, f64), String> {
        let rgb = |image: &LayeredImage, path: &Path| -> Result<RgbImage, String> {
            image.select(path, Some(&self.layer)).map_err(|error| error.to_string())
        };
        let test = rgb(&pane.image().map_err(|error| error.to_string())?, Path::new("the picture"))?;
        let truth = rgb(&self.truth, &self.path)?;
        let mask = Mask::full(truth.width, truth.height);
        let heat = heatmap::signed(&test, &truth, &mask).map_err(|error| error.to_string())?;
        let error = metrics::rel_rmse(&test, &truth, &mask).map_err(|error| error.to_string())?;
        Ok((heat, error))
    }
}
