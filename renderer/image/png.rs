//! PNG and JPEG in, PNG out: sRGB in the file, linear light in memory.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Write};
use std::path::Path;

use ::image::{DynamicImage, ImageReader};
use ::png::{BitDepth, ColorType, Compression, DecodeOptions, Decoder, Encoder, Filter};

use super::openexr::SOFTWARE;
use super::tone::srgb_to_linear;
use super::{ImageError, Mask, RgbImage, atomic};

/// Pixels, as [`crate::render::MAX_SIDE`]: a damaged header must not ask for all memory.
const LARGEST_SIDE: usize = crate::render::MAX_SIDE as usize;

/// A picture as a screen shows it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DisplayImage {
    /// Pixels.
    pub width: usize,
    /// Pixels.
    pub height: usize,
    /// sRGB, row 0 on top, `width * height` of them.
    pub pixels: Vec<[u8; 3]>,
    /// Texts by keyword, as those of a [`super::LayeredImage`].
    pub attributes: BTreeMap<String, String>,
}

/// Reads a picture and undoes the sRGB curve; 8 or 16 bits, grey or colour, alpha left out.
///
/// # Errors
/// [`ImageError::Read`].
pub fn read_linear(path: &Path) -> Result<RgbImage, ImageError> {
    let image = decode(path)?.into_rgb16();
    let (width, height) = (image.width() as usize, image.height() as usize);
    let linear = |encoded: u16| srgb_to_linear(f32::from(encoded) / f32::from(u16::MAX));
    let pixels = image.pixels().map(|pixel| pixel.0.map(linear)).collect();
    Ok(RgbImage { width, height, pixels })
}

/// Reads a mask: pixels of at least half the file's full value are inside.
///
/// # Errors
/// [`ImageError::Read`].
pub fn read_mask(path: &Path) -> Result<Mask, ImageError> {
    let image = decode(path)?.into_luma16();
    let (width, height) = (image.width() as usize, image.height() as usize);
    let inside = image.pixels().map(|pixel| pixel.0[0] > u16::MAX / 2).collect();
    Ok(Mask { width, height, inside })
}

/// Writes 8-bit sRGB display values, row 0 on top. The file appears whole or not at all.
///
/// # Errors
/// [`ImageError::Write`], also where `pixels` are not `width * height`.
pub fn write(path: &Path, width: usize, height: usize, pixels: &[[u8; 3]]) -> Result<(), ImageError> {
    write_with(path, width, height, pixels, &BTreeMap::new())
}

/// As [`write`]; the attributes go into iTXt chunks, and [`SOFTWARE`] with them.
///
/// # Errors
/// As [`write`], or keywords that are empty or longer than 79 bytes.
pub fn write_with(
    path: &Path,
    width: usize,
    height: usize,
    pixels: &[[u8; 3]],
    attributes: &BTreeMap<String, String>,
) -> Result<(), ImageError> {
    atomic::write(path, |output| encode_to(output, width, height, pixels, attributes))
}

/// The bytes of such a file without attributes. The error is a reason.
pub fn encode(width: usize, height: usize, pixels: &[[u8; 3]]) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    encode_to(&mut bytes, width, height, pixels, &BTreeMap::new())?;
    Ok(bytes)
}

fn encode_to(
    output: impl Write,
    width: usize,
    height: usize,
    pixels: &[[u8; 3]],
    attributes: &BTreeMap<String, String>,
) -> Result<(), String> {
    let size = (u32::try_from(width), u32::try_from(height));
    let ((Ok(columns), Ok(rows)), true) = (size, pixels.len() == width * height) else {
        return Err(format!("{} pixels do not make {width}x{height}", pixels.len()));
    };
    let mut encoder = Encoder::new(output, columns, rows);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Fast);
    encoder.set_filter(Filter::Adaptive);
    let software = ("Software".to_owned(), SOFTWARE.to_owned());
    for (keyword, text) in attributes.clone().into_iter().chain([software]) {
        encoder.add_itxt_chunk(keyword, text).map_err(|error| error.to_string())?;
    }
    let mut writer = encoder.write_header().map_err(|error| error.to_string())?;
    writer.write_image_data(pixels.as_flattened()).map_err(|error| error.to_string())?;
    writer.finish().map_err(|error| error.to_string())
}

/// Reads a PNG of 8-bit RGB, as [`write_with`] makes them, to its last chunk.
///
/// # Errors
/// [`ImageError::Read`]: missing, damaged, cut short, or of another kind.
pub fn read_display(path: &Path) -> Result<DisplayImage, ImageError> {
    let failed = |reason: String| ImageError::Read { path: path.to_owned(), reason };
    let broken = |error: ::png::DecodingError| failed(error.to_string());
    let file = File::open(path).map_err(|error| failed(error.to_string()))?;
    let mut options = DecodeOptions::default();
    // A damaged text is no text of another request.
    options.set_skip_ancillary_crc_failures(false);
    let mut reader = Decoder::new_with_options(BufReader::new(file), options).read_info().map_err(broken)?;
    if reader.output_color_type() != (ColorType::Rgb, BitDepth::Eight) {
        return Err(failed("it is no picture of 8-bit RGB".to_owned()));
    }
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    if width.max(height) > LARGEST_SIDE {
        return Err(failed(format!("it is {width}x{height} pixels; allowed are {LARGEST_SIDE} each way")));
    }
    let mut pixels = vec![[0; 3]; width * height];
    reader.next_frame(pixels.as_flattened_mut()).map_err(broken)?;
    reader.finish().map_err(broken)?;
    let texts = reader.info().utf8_text.iter();
    let attributes = texts.filter_map(|chunk| Some((chunk.keyword.clone(), chunk.get_text().ok()?))).collect();
    Ok(DisplayImage { width, height, pixels, attributes })
}

fn decode(path: &Path) -> Result<DynamicImage, ImageError> {
    let failed = |reason: String| ImageError::Read { path: path.to_owned(), reason };
    ImageReader::open(path)
        .and_then(ImageReader::with_guessed_format)
        .map_err(|error| failed(error.to_string()))?
        .decode()
        .map_err(|error| failed(error.to_string()))
}
