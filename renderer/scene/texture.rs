//! Image files: textures, and the grey images of height fields.

use std::path::{Path, PathBuf};

use image::{DynamicImage, ImageError, ImageReader, Limits};

use super::error::{SceneError, io_reason};
use super::value::Node;
use super::{Texture, TextureId};

/// Pixels a side.
const LARGEST_IMAGE: u32 = 16_384;
/// Bytes a decoder may take, so that a small file cannot claim all memory.
const MOST_BYTES: u64 = 1 << 30;

/// The texture of the file that `node` names; a file is read once.
pub(super) fn read(node: &Node, textures: &mut Vec<Texture>) -> Result<TextureId, SceneError> {
    let file = referred(node)?;
    open(&file, textures).map_err(|problem| refuse(node, file, problem))
}

/// As [`read`], with the problem as half a sentence.
pub(super) fn open(file: &Path, textures: &mut Vec<Texture>) -> Result<TextureId, String> {
    let name = file.display().to_string();
    if let Some(known) = textures.iter().position(|texture| texture.name == name) {
        return Ok(known);
    }
    let rgb = decode(file)?.into_rgb32f();
    let (width, height) = rgb.dimensions();
    let texels = rgb.pixels().map(|pixel| pixel.0.map(linear_from_srgb)).collect();
    textures.push(Texture { name, width, height, texels });
    Ok(textures.len() - 1)
}

/// A grey image: width, height, and values in [0, 1] as stored, row 0 on top.
pub(super) fn read_grey(node: &Node) -> Result<(usize, usize, Vec<f64>), SceneError> {
    let file = referred(node)?;
    let grey = decode(&file).map_err(|problem| refuse(node, file, problem))?.into_luma16();
    let values = grey.pixels().map(|pixel| f64::from(pixel.0[0]) / 65_535.0).collect();
    Ok((grey.width() as usize, grey.height() as usize, values))
}

/// The file a key names, relative to the scene file's folder.
pub(super) fn referred(node: &Node) -> Result<PathBuf, SceneError> {
    let name = node.text()?;
    Ok(node.source.path.parent().unwrap_or(Path::new("")).join(name))
}

pub(super) fn refuse(node: &Node, file: PathBuf, problem: String) -> SceneError {
    SceneError::File { at: node.at(), key: node.key.clone(), file, problem }
}

fn decode(file: &Path) -> Result<DynamicImage, String> {
    let unreadable = |error| format!("cannot be read: {}", io_reason(&error));
    let mut reader = ImageReader::open(file).and_then(|reader| reader.with_guessed_format()).map_err(unreadable)?;
    let mut limits = Limits::default();
    limits.max_image_width = Some(LARGEST_IMAGE);
    limits.max_image_height = Some(LARGEST_IMAGE);
    limits.max_alloc = Some(MOST_BYTES);
    reader.limits(limits);
    reader.decode().map_err(|error| match error {
        ImageError::Limits(_) => {
            format!("is too large; allowed: at most {LARGEST_IMAGE} pixels a side and {MOST_BYTES} bytes")
        }
        ImageError::Unsupported(_) => "is not an image of a known format; allowed: PNG, JPEG".to_owned(),
        ImageError::IoError(error) => format!("cannot be read: {}", io_reason(&error)),
        other => format!("is not a sound image: {}", other.to_string().trim_end_matches('.')),
    })
}

/// IEC 61966-2-1.
fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}
