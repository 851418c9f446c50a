//! OpenEXR: one part with all layers as prefixed channels, so that any viewer opens the picture.
//!
//! The final layer's channels are plain `R`, `G`, `B`; the others are `caustic.R`, `normal.X`,
//! `depth.Z` and so on. 32-bit float, ZIP over 16 lines, lossless.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::io::Cursor;
use std::path::Path;

use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image};
use exr::meta::attribute::{AttributeValue, Text};
use exr::meta::header::LayerAttributes;
use exr::prelude::{ReadChannels, ReadLayers, SmallVec, Vec2, WritableImage};

use super::{Channel, FINAL_LAYER, ImageError, Layer, LayeredImage, atomic};

/// The name and version that pictures carry in their standard `software` attribute.
pub const SOFTWARE: &str = concat!("nephroid ", env!("CARGO_PKG_VERSION"));

/// Reads all layers of an EXR file: scan lines or tiles, half, float or integer, one part or
/// several. In a file of several parts the part's name comes before the channel's.
///
/// # Errors
/// [`ImageError::Read`]: missing, damaged, of a kind that is not supported (deep data,
/// channels of lower resolution).
pub fn read(path: &Path) -> Result<LayeredImage, ImageError> {
    let failed = |reason: String| ImageError::Read { path: path.to_owned(), reason };
    let file = exr::image::read::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_file(path)
        .map_err(|error| failed(error.to_string()))?;

    let several = file.layer_data.len() > 1;
    let mut layers: Vec<Layer> = Vec::new();
    let mut attributes = texts(&file.attributes.other);
    for part in &file.layer_data {
        attributes.extend(texts(&part.attributes.other));
        if let Some(software) = &part.attributes.software_name {
            attributes.insert("software".to_owned(), utf8(software));
        }
        let part_name = part.attributes.layer_name.as_ref().filter(|_| several).map(utf8);
        for channel in &part.channel_data.list {
            let full_name = utf8(&channel.name);
            if channel.sampling != Vec2(1, 1) {
                return Err(failed(format!(
                    "channel '{full_name}' is stored at a lower resolution than the picture, \
                     which is not supported"
                )));
            }
            let (layer, channel_name) = split(part_name.as_deref(), &full_name);
            let samples: Vec<f32> = channel.sample_data.values_as_f32().collect();
            let channel = Channel { name: channel_name.to_owned(), samples };
            let (width, height) = (part.size.width(), part.size.height());
            match layers.iter_mut().find(|known| known.name == layer) {
                Some(known) if (known.width, known.height) == (width, height) => {
                    known.channels.push(channel);
                }
                Some(known) => {
                    return Err(failed(format!(
                        "layer '{layer}' is {}x{} pixels in one part and {width}x{height} in \
                         another",
                        known.width, known.height
                    )));
                }
                None => {
                    layers.push(Layer { name: layer, width, height, channels: vec![channel] });
                }
            }
        }
    }
    Ok(LayeredImage { layers, attributes })
}

/// Writes all layers and attributes, and [`SOFTWARE`]. The file appears whole or not at all.
///
/// # Errors
/// [`ImageError::Write`]: layers that are empty or of different sizes, channels of the wrong
/// length or named twice, and what the file system refuses.
pub fn write(path: &Path, image: &LayeredImage) -> Result<(), ImageError> {
    atomic::write(path, |output| {
        let (width, height) = common_size(image)?;
        let mut channels = SmallVec::new();
        for layer in &image.layers {
            for channel in &layer.channels {
                let name = match layer.name.as_str() {
                    FINAL_LAYER => channel.name.clone(),
                    prefix => format!("{prefix}.{}", channel.name),
                };
                let samples = FlatSamples::F32(channel.samples.clone());
                channels.push(AnyChannel::new(text(&name), samples));
            }
        }

        let software_name = Some(text(SOFTWARE));
        let header = LayerAttributes { software_name, ..LayerAttributes::default() };
        let encoding = Encoding::SMALL_LOSSLESS;
        let part = exr::image::Layer::new((width, height), header, encoding, AnyChannels::sort(channels));
        let mut file = Image::from_layer(part);
        for (name, value) in image.attributes.iter().filter(|(name, _)| *name != "software") {
            file.attributes.other.insert(text(name), AttributeValue::Text(text(value)));
        }
        let mut bytes = Cursor::new(Vec::new());
        file.write().non_parallel().to_buffered(&mut bytes).map_err(|error| error.to_string())?;
        let mut bytes = bytes.into_inner();
        sort_attributes(&mut bytes);
        output.write_all(&bytes).map_err(|error| error.to_string())
    })
}

/// Puts the attributes of a file's only header in the order of their names: the encoder's own differs from run to run, and
/// equal pictures should be equal files. Nothing else moves.
fn sort_attributes(file: &mut [u8]) {
    /// Magic number and version.
    const START: usize = 8;
    let text_end = |from: usize| Some(from + file.get(from..)?.iter().position(|byte| *byte == 0)? + 1);
    let mut attributes = Vec::new();
    let mut at = START;
    while file.get(at).is_some_and(|byte| *byte != 0) {
        // Name and type, each with a zero after it, the value's length, the value.
        let Some(size_at) = text_end(at).and_then(text_end) else { return };
        let Some(size) = file.get(size_at..).and_then(|bytes| bytes.first_chunk()) else { return };
        let end = size_at + 4 + u32::from_le_bytes(*size) as usize;
        let Some(attribute) = file.get(at..end) else { return };
        attributes.push(attribute.to_vec());
        at = end;
    }
    attributes.sort();
    if let Some(header) = file.get_mut(START..at) {
        header.copy_from_slice(&attributes.concat());
    }
}

/// Checks what the encoder would otherwise panic at.
fn common_size(image: &LayeredImage) -> Result<(usize, usize), String> {
    let first = image.layers.first().ok_or("the picture has no layers")?;
    let size = (first.width, first.height);
    let mut names = BTreeSet::new();
    for layer in &image.layers {
        if (layer.width, layer.height) != size || layer.width * layer.height == 0 {
            return Err(format!(
                "layer '{}' is {}x{} pixels, where '{}' is {}x{}; all must be the same and not \
                 empty",
                layer.name, layer.width, layer.height, first.name, size.0, size.1
            ));
        }
        if layer.channels.is_empty() {
            return Err(format!("layer '{}' has no channels", layer.name));
        }
        for channel in &layer.channels {
            if channel.samples.len() != size.0 * size.1 {
                return Err(format!(
                    "channel '{}' of layer '{}' has {} samples for {}x{} pixels",
                    channel.name,
                    layer.name,
                    channel.samples.len(),
                    size.0,
                    size.1
                ));
            }
            if !names.insert((&layer.name, &channel.name)) {
                return Err(format!("layer '{}' has two channels '{}'", layer.name, channel.name));
            }
        }
    }
    Ok(size)
}

/// Splits `caustic.R` into layer and channel. A part's name leads, unless the channel repeats it.
fn split<'a>(part: Option<&str>, full_name: &'a str) -> (String, &'a str) {
    let (prefix, channel) = full_name.rsplit_once('.').unwrap_or(("", full_name));
    let layer = match part {
        Some(part) if prefix.is_empty() => part.to_owned(),
        Some(part) if prefix != part && !prefix.starts_with(&format!("{part}.")) => {
            format!("{part}.{prefix}")
        }
        _ => prefix.to_owned(),
    };
    if layer.is_empty() { (FINAL_LAYER.to_owned(), channel) } else { (layer, channel) }
}

fn texts(attributes: &HashMap<Text, AttributeValue>) -> BTreeMap<String, String> {
    attributes
        .iter()
        .filter_map(|(name, value)| match value {
            AttributeValue::Text(value) => Some((utf8(name), utf8(value))),
            _ => None,
        })
        .collect()
}

/// EXR text is UTF-8 bytes; the crate's own conversion allows only one byte a character.
fn text(string: &str) -> Text {
    Text::from_slice_unchecked(string.as_bytes())
}

fn utf8(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}
