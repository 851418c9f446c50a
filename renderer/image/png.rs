//! PNG and JPEG in, PNG out: sRGB in the file, linear light in memory.

use std::path::Path;

use ::image::{DynamicImage, ExtendedColorType, ImageEncoder, ImageReader};

use super::tone::srgb_to_linear;
use super::{ImageError, Mask, RgbImage, atomic};

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
    atomic::write(path, |output| {
        let size = (u32::try_from(width), u32::try_from(height));
        let ((Ok(columns), Ok(rows)), true) = (size, pixels.len() == width * height) else {
            return Err(format!("{} pixels do not make {width}x{height}", pixels.len()));
        };
        ::image::codecs::png::PngEncoder::new(output)
            .write_image(pixels.as_flattened(), columns, rows, ExtendedColorType::Rgb8)
            .map_err(|error| error.to_string())
    })
}

fn decode(path: &Path) -> Result<DynamicImage, ImageError> {
    let failed = |reason: String| ImageError::Read { path: path.to_owned(), reason };
    ImageReader::open(path)
        .and_then(ImageReader::with_guessed_format)
        .map_err(|error| failed(error.to_string()))?
        .decode()
        .map_err(|error| failed(error.to_string()))
}
