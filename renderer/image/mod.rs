//! Pictures in files: layered EXR, PNG and masks in and out, and how far one picture is from another.
//!
//! Everything in memory is linear and row-major with row 0 on top; only PNG bytes are sRGB.

pub mod atomic;
pub mod heatmap;
pub mod metrics;
pub mod openexr;
pub mod png;
pub mod tone;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::display::Look;

/// The layer that holds the finished picture. In an EXR file its channels carry no prefix.
pub const FINAL_LAYER: &str = "final";

/// An RGB picture in linear light.
#[derive(Debug, Clone, PartialEq)]
pub struct RgbImage {
    /// Pixels.
    pub width: usize,
    /// Pixels.
    pub height: usize,
    /// Linear Rec.709, `width * height` of them.
    pub pixels: Vec<[f32; 3]>,
}

/// Which pixels a comparison looks at.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mask {
    /// Pixels.
    pub width: usize,
    /// Pixels.
    pub height: usize,
    /// One flag a pixel, `width * height` of them.
    pub inside: Vec<bool>,
}

impl Mask {
    /// The mask that leaves nothing out.
    pub fn full(width: usize, height: usize) -> Self {
        Mask { width, height, inside: vec![true; width * height] }
    }
}

/// One plane of samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Without the layer's prefix: `R`, `X`, `Z`.
    pub name: String,
    /// As many as the layer has pixels.
    pub samples: Vec<f32>,
}

/// Channels that belong together, such as the R, G and B of `caustic`.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    pub name: String,
    /// Pixels.
    pub width: usize,
    /// Pixels.
    pub height: usize,
    pub channels: Vec<Channel>,
}

impl Layer {
    /// A layer with channels R, G and B.
    pub fn from_rgb(name: &str, image: &RgbImage) -> Self {
        let plane = |name: &str, component: usize| Channel {
            name: name.to_owned(),
            samples: image.pixels.iter().map(|pixel| pixel[component]).collect(),
        };
        Layer {
            name: name.to_owned(),
            width: image.width,
            height: image.height,
            channels: vec![plane("R", 0), plane("G", 1), plane("B", 2)],
        }
    }

    /// The samples of a channel.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|channel| channel.name == name).map(|c| c.samples.as_slice())
    }

    /// The layer as RGB: from R, G, B, else from X, Y, Z (normals), else its only channel (beside
    /// alpha) as grey. `None` where it has other channels.
    pub fn to_rgb(&self) -> Option<RgbImage> {
        let three =
            |names: [&str; 3]| Some([self.channel(names[0])?, self.channel(names[1])?, self.channel(names[2])?]);
        let grey = || {
            let mut colours = self.channels.iter().filter(|channel| channel.name != "A");
            match (colours.next(), colours.next()) {
                (Some(only), None) => Some([only.samples.as_slice(); 3]),
                _ => None,
            }
        };
        let [r, g, b] = three(["R", "G", "B"]).or_else(|| three(["X", "Y", "Z"])).or_else(grey)?;
        let pixels = r.iter().zip(g).zip(b).map(|((&r, &g), &b)| [r, g, b]).collect();
        Some(RgbImage { width: self.width, height: self.height, pixels })
    }
}

/// Everything one picture file holds.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LayeredImage {
    pub layers: Vec<Layer>,
    /// Text attributes by name; see [`RenderInfo::attributes`].
    pub attributes: BTreeMap<String, String>,
}

impl LayeredImage {
    /// The layer of that name.
    pub fn layer(&self, name: &str) -> Option<&Layer> {
        self.layers.iter().find(|layer| layer.name == name)
    }

    /// The layer of that name. With no name, the final layer, or the only layer where there is
    /// just one. `path` is where the picture came from, for the error's sentence.
    ///
    /// # Errors
    /// [`ImageError::NoLayer`] with the layers found.
    pub fn find(&self, path: &Path, name: Option<&str>) -> Result<&Layer, ImageError> {
        let only = || match (name, self.layers.as_slice()) {
            (None, [only]) => Some(only),
            _ => None,
        };
        let wanted = name.unwrap_or(FINAL_LAYER);
        self.layer(wanted).or_else(only).ok_or_else(|| ImageError::NoLayer {
            path: path.to_owned(),
            layer: wanted.to_owned(),
            found: joined(self.layers.iter().map(|layer| &layer.name)),
        })
    }

    /// What [`LayeredImage::find`] finds, as RGB.
    ///
    /// # Errors
    /// [`ImageError::NoLayer`], or [`ImageError::NotColour`] with the layer's channels.
    pub fn select(&self, path: &Path, name: Option<&str>) -> Result<RgbImage, ImageError> {
        let layer = self.find(path, name)?;
        layer.to_rgb().ok_or_else(|| ImageError::NotColour {
            path: path.to_owned(),
            layer: layer.name.clone(),
            found: joined(layer.channels.iter().map(|channel| &channel.name)),
        })
    }
}

fn joined<'a>(names: impl Iterator<Item = &'a String>) -> String {
    names.map(String::as_str).collect::<Vec<_>>().join(", ")
}

/// How a picture was made, kept with it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RenderInfo {
    pub scene: String,
    pub technique: String,
    pub camera: String,
    /// Samples a pixel.
    pub samples: u32,
    pub seed: u64,
    /// Of the scene's animation.
    pub frame: u32,
    /// The Vulkan device's name.
    pub device: String,
    /// What its capabilities led to, in words.
    pub tier: String,
}

impl RenderInfo {
    /// The text attributes for [`LayeredImage::attributes`]: `nephroid.scene` and its like.
    pub fn attributes(&self) -> BTreeMap<String, String> {
        [
            ("nephroid.scene", self.scene.clone()),
            ("nephroid.technique", self.technique.clone()),
            ("nephroid.camera", self.camera.clone()),
            ("nephroid.samples", self.samples.to_string()),
            ("nephroid.seed", self.seed.to_string()),
            ("nephroid.frame", self.frame.to_string()),
            ("nephroid.device", self.device.clone()),
            ("nephroid.tier", self.tier.clone()),
        ]
        .map(|(name, value)| (name.to_owned(), value))
        .into()
    }
}

/// A picture file format, told by the extension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Linear, 32-bit float, all layers.
    Exr,
    /// Display values, 8-bit sRGB.
    Png,
}

impl Format {
    /// The format that a path's extension names, in either case.
    ///
    /// # Errors
    /// [`ImageError::UnknownExtension`].
    pub fn of(path: &Path) -> Result<Self, ImageError> {
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        match extension.to_ascii_lowercase().as_str() {
            "exr" => Ok(Format::Exr),
            "png" => Ok(Format::Png),
            _ => Err(ImageError::UnknownExtension { path: path.to_owned() }),
        }
    }
}

/// Reads a picture: every layer of an EXR file, or a PNG file as a final layer in linear light.
///
/// # Errors
/// An unknown extension, or a file that is missing, unreadable or damaged.
pub fn read(path: &Path) -> Result<LayeredImage, ImageError> {
    match Format::of(path)? {
        Format::Exr => openexr::read(path),
        Format::Png => Ok(LayeredImage {
            layers: vec![Layer::from_rgb(FINAL_LAYER, &png::read_linear(path)?)],
            attributes: BTreeMap::new(),
        }),
    }
}

/// Writes a picture: all layers as they are, or the final layer as `look` shows it. The file appears whole or not at all.
///
/// # Errors
/// [`ImageError::Write`], and for a PNG those of [`LayeredImage::select`].
pub fn write(path: &Path, format: Format, image: &LayeredImage, look: Look) -> Result<(), ImageError> {
    match format {
        Format::Exr => openexr::write(path, image),
        Format::Png => {
            let picture = image.select(path, None)?;
            let bytes = tone::display(&picture.pixels, look.exposure, tone::curve(look.tone_curve));
            png::write_with(path, picture.width, picture.height, &bytes, &image.attributes)
        }
    }
}

/// What can go wrong with a picture file.
#[derive(Debug, Error)]
pub enum ImageError {
    #[error("{path}: the file name ends in neither .exr nor .png, the formats known here")]
    UnknownExtension { path: PathBuf },
    #[error("{path}: cannot be read: {reason}")]
    Read { path: PathBuf, reason: String },
    #[error("{path}: cannot be written: {reason}")]
    Write { path: PathBuf, reason: String },
    #[error("{path}: has no layer '{layer}'; its layers are: {found}")]
    NoLayer { path: PathBuf, layer: String, found: String },
    #[error(
        "{path}: layer '{layer}' has the channels {found}; a picture needs R, G, B, or X, Y, Z, \
         or a single channel"
    )]
    NotColour { path: PathBuf, layer: String, found: String },
}
