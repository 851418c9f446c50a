//! From linear radiance to display values.

use crate::scene::ToneCurve;

/// The luminance that a scene's Reinhard curve sends to 1.
pub const REINHARD_WHITE: f32 = 4.0;

/// Rec.709 luminance of a linear colour.
pub fn luminance([r, g, b]: [f32; 3]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// The sRGB transfer curve (IEC 61966-2-1): linear light in [0, 1] to an encoded value in [0, 1].
pub fn linear_to_srgb(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The inverse of [`linear_to_srgb`].
pub fn srgb_to_linear(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Reinhard's extended curve on luminance: L (1 + L / white^2) / (1 + L), hue kept; a luminance of
/// `white` becomes 1. Colours of no positive luminance are returned as they are.
pub fn reinhard_extended(colour: [f32; 3], white: f32) -> [f32; 3] {
    let bright = luminance(colour);
    if bright <= 0.0 {
        return colour;
    }
    let scale = (1.0 + bright / (white * white)) / (1.0 + bright);
    colour.map(|component| component * scale)
}

/// What a scene's tone curve does to a linear colour.
pub fn curve(curve: ToneCurve) -> impl Fn([f32; 3]) -> [f32; 3] {
    move |colour| match curve {
        ToneCurve::Linear => colour,
        ToneCurve::Reinhard => reinhard_extended(colour, REINHARD_WHITE),
    }
}

/// The 8-bit sRGB value of a linear colour, each component clamped to [0, 1]; NaN becomes 0.
pub fn to_srgb8(linear: [f32; 3]) -> [u8; 3] {
    // The cast saturates and sends NaN to 0.
    linear.map(|component| (linear_to_srgb(component.clamp(0.0, 1.0)) * 255.0).round() as u8)
}

/// Display bytes of a picture: times 2^`exposure` (stops), through `curve`, then [`to_srgb8`].
pub fn display(pixels: &[[f32; 3]], exposure: f32, curve: impl Fn([f32; 3]) -> [f32; 3]) -> Vec<[u8; 3]> {
    let gain = exposure.exp2();
    pixels.iter().map(|pixel| to_srgb8(curve(pixel.map(|component| component * gain)))).collect()
}
