//! Colour targets: what fragments write is what is read back.

use super::{Bench, Case, CaseError, GRAPHICS};
use crate::conformance::DrawnPush;
use crate::conformance::case::Worst;
use crate::conformance::rays::Random;
use crate::conformance::ulps::from_half;
use crate::gpu::{Bindings, Buffer, Plain, Raster, RasterStages, RasterTargets, Recorder};

const fn case(name: &'static str, about: &'static str, run: fn(&mut Bench<'_>) -> Result<(), CaseError>) -> Case {
    Case { group: "image_formats", name, about, needs: GRAPHICS, minds: &[], catches: &[], run }
}

pub(super) const CASES: &[Case] = &[
    case("ids", "R32G32_UINT keeps every bit", ids),
    case("floats", "R32G32B32A32_SFLOAT keeps every normal number, zeros and infinities", floats),
    case("halves", "R16G16B16A16_SFLOAT keeps what it can hold, and rounds the rest to a neighbour", halves),
    case("half_infinities", "R16G16B16A16_SFLOAT keeps infinities", half_infinities),
    case("display", "R8G8B8A8_UNORM rounds to a neighbour, and keeps bytes", display),
];

const SIDE: u32 = 64;
const PIXELS: usize = (SIDE * SIDE) as usize;
/// Of `ids.frag.glsl`.
const MODE_BITS: u32 = 3;

/// A triangle over all of the target.
const ALL: [[f32; 4]; 3] = [[-1.0, -1.0, 0.5, 1.0], [-1.0, 3.0, 0.5, 1.0], [3.0, -1.0, 0.5, 1.0]];

/// Draws a target of which each pixel has its own value, and reads it back as pixels of `T`.
fn round_trip<T: bytemuck::Pod>(
    bench: &Bench<'_>,
    format: Plain,
    fragment: &str,
    values: &[[u32; 4]],
) -> Result<Vec<T>, CaseError> {
    let targets = RasterTargets::plain(bench.device, "round trip", format, SIDE, SIDE)?;
    let stages = RasterStages { vertex: "conformance/triangles", geometry: None, fragment, variant: "" };
    let raster = Raster::of_stages(bench.device, &stages, &targets)?;
    let corners = Buffer::from_slice(bench.device, "corners", &ALL)?;
    let values = Buffer::from_slice(bench.device, "values", values)?;
    let bindings = Bindings::new().buffer("Corners", &corners).buffer("Values", &values);
    let push = DrawnPush { mode: MODE_BITS, first: 0, columns: SIDE, per_point: 0 };
    let mut recorder = Recorder::new(bench.device)?;
    recorder.pass("conformance/round trip")?.draw(&raster, &targets, &[&bindings], &[(push, 3)])?;
    recorder.submit()?;
    Ok(targets.color.read(PIXELS)?)
}

fn ids(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let mut random = Random(1);
    let mut values: Vec<[u32; 4]> = (0..PIXELS).map(|_| [random.bits() as u32, random.bits() as u32, 0, 0]).collect();
    values[0] = [0, u32::MAX, 0, 0];
    values[1] = [f32::NAN.to_bits(), 1, 0, 0];
    let found: Vec<[u32; 2]> = round_trip(bench, Plain::Ids, "conformance/ids", &values)?;
    let expected: Vec<[u32; 2]> = values.iter().map(|v| [v[0], v[1]]).collect();
    bench.equal("pixels", &found, &expected);
    Ok(())
}

/// Any sign and exponent of normal numbers within the given ones.
fn numbers(random: &mut Random, low: i32, high: i32) -> Vec<[f32; 4]> {
    let mut number = || {
        let exponent = low + random.below((high - low) as usize) as i32;
        let sign = if random.bits() & 1 == 0 { 1.0 } else { -1.0 };
        sign * (1.0 + random.unit()) * 2f32.powi(exponent)
    };
    (0..PIXELS).map(|_| [number(), number(), number(), number()]).collect()
}

fn bits(values: &[[f32; 4]]) -> Vec<[u32; 4]> {
    values.iter().map(|v| v.map(f32::to_bits)).collect()
}

fn floats(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let mut values = numbers(&mut Random(2), -126, 127);
    values[0] = [0.0, -0.0, f32::INFINITY, f32::NEG_INFINITY];
    values[1] = [f32::MAX, f32::MIN, f32::MIN_POSITIVE, 1.0];
    let found: Vec<[u32; 4]> = round_trip(bench, Plain::Floats, "conformance/texels", &bits(&values))?;
    bench.equal("pixels", &found, &bits(&values));
    Ok(())
}

fn halves(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let mut values = numbers(&mut Random(3), -14, 15);
    // Every second pixel holds numbers that are halves.
    for pixel in values.iter_mut().step_by(2) {
        *pixel = pixel.map(|v| f32::from_bits(v.to_bits() & 0xffff_e000));
    }
    values[0] = [0.0, 65504.0, -65504.0, 1.0];
    let found: Vec<[u16; 4]> = round_trip(bench, Plain::Halves, "conformance/texels", &bits(&values))?;
    let (mut exact, mut rounded) = (Worst::default(), Worst::default());
    for (index, (found, value)) in found.iter().zip(&values).enumerate() {
        for (found, &value) in found.iter().map(|bits| from_half(*bits)).zip(value) {
            let step = f32::from_bits(value.abs().to_bits() & 0x7f80_0000) / 1024.0;
            let error = if found == value { 0.0 } else { f64::from((found - value).abs() / step) };
            let worst = if index % 2 == 0 { &mut exact } else { &mut rounded };
            worst.see(error, || format!("pixel {index}: {found:e}, not {value:e}"));
        }
    }
    bench.note("largest rounding, steps of a half", format!("{:.3}", rounded.measured));
    bench.at_most("numbers that are halves", exact, 0.0, "steps of a half");
    bench.at_most("other numbers", rounded, 1.0, "steps of a half");
    Ok(())
}

fn half_infinities(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let values = vec![[f32::INFINITY, f32::NEG_INFINITY, 1.0, -0.0]; PIXELS];
    let found: Vec<[u16; 4]> = round_trip(bench, Plain::Halves, "conformance/texels", &bits(&values))?;
    bench.equal("pixels, as bits", &found, &[[0x7c00, 0xfc00, 0x3c00, 0x8000]; PIXELS]);
    Ok(())
}

fn display(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let mut random = Random(4);
    let mut values: Vec<[f32; 4]> =
        (0..PIXELS).map(|_| [random.unit(), random.unit(), random.unit(), random.unit()]).collect();
    for (index, pixel) in values.iter_mut().enumerate().step_by(2) {
        *pixel = [0, 1, 2, 3].map(|channel| ((index / 2 * 4 + channel) % 256) as f32 / 255.0);
    }
    let found: Vec<[u8; 4]> = round_trip(bench, Plain::Display, "conformance/texels", &bits(&values))?;
    let (mut bytes, mut rounded) = (Worst::default(), Worst::default());
    for (index, (found, value)) in found.iter().zip(&values).enumerate() {
        for (&found, &value) in found.iter().zip(value) {
            let exact = f64::from(value) * 255.0;
            let worst = if index % 2 == 0 { &mut bytes } else { &mut rounded };
            // Both sides of the byte are a float's rounding away from it.
            let error = ((f64::from(found) - exact).abs() - 1e-4).max(0.0);
            worst.see(error, || format!("pixel {index}: {found}, not {exact}"));
        }
    }
    bench.note("largest rounding, bytes", format!("{:.3}", rounded.measured));
    bench.at_most("multiples of 1/255", bytes, 0.0, "bytes");
    bench.at_most("other numbers", rounded, 1.0, "bytes");
    Ok(())
}
