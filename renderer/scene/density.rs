//! `density` of a `[[medium]]`: a grid from a file, or noise.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use glam::{DVec3, UVec3, Vec3};

use super::error::{SceneError, io_reason};
use super::noise::Noise;
use super::texture::{referred, refuse};
use super::value::{COORDINATE, LENGTH, Limit, Node, Table};
use super::{Bounds, DensityGrid};

const BOX: &[&str] = &["lower", "upper"];
/// Points of a grid; their values fill the storage range of 128 MiB that every device offers.
const MOST_POINTS: u64 = 1 << 25;
/// Points along one axis.
const MOST_ALONG: u32 = 4096;
/// Of a density: with coefficients up to 1e9, products stay inside the range of f32.
const DENSEST: f32 = 1e9;
const SHORTEST: f64 = 1e-6;
const THRESHOLD: Limit = Limit { holds: |t| (0.0..=0.95).contains(&t), words: "from 0 to 0.95" };
const FADE: Limit = Limit { holds: |m| (0.0..=1e6).contains(&m), words: "from 0 to 1e6" };

/// Reads the grid that the table at `node` describes.
pub(super) fn read(node: &Node) -> Result<DensityGrid, SceneError> {
    let any = node.any_table("`density`")?;
    if any.get("file").is_some() {
        let table = node.table("the `density` of a file", &[&["file"], BOX].concat())?;
        return read_file(&table, &table.need("file", "the name of a VOL file")?);
    }
    any.need("kind", "\"noise\", or `file`, the name of a VOL file")?.choice(&[("noise", ())])?;
    let keys = ["kind", "cell", "octaves", "threshold", "fade", "seed", "resolution"];
    read_noise(&node.table("a noise `density`", &[&keys, BOX].concat())?)
}

/// The corners, where `own` are those that a file names.
fn read_box(table: &Table, own: Option<Bounds>) -> Result<Bounds, SceneError> {
    let corner = "a list of three numbers";
    let own = own.map(|own| (own.min.as_dvec3(), own.max.as_dvec3())).unzip();
    let lower: DVec3 = table.or_need("lower", corner, own.0, |node| node.vec3(COORDINATE))?;
    let upper = table.or_need("upper", corner, own.1, |node| node.vec3(COORDINATE))?;
    let bounds = Bounds { min: lower.as_vec3(), max: upper.as_vec3() };
    if !is_box(bounds) {
        let node = table.get("upper").or(table.get("lower")).map_or_else(|| table.need("file", ""), Ok)?;
        return Err(node.refuse("a corner at least 1e-6 above the lower one along each axis"));
    }
    Ok(bounds)
}

/// Whether it has a size that f32 coordinates can tell.
fn is_box(bounds: Bounds) -> bool {
    (bounds.max.as_dvec3() - bounds.min.as_dvec3()).min_element() >= SHORTEST
}

fn read_file(table: &Table, node: &Node) -> Result<DensityGrid, SceneError> {
    let path = referred(node)?;
    let read = read_vol(&path);
    let (own, points, values) = read.map_err(|problem| refuse(node, path.clone(), problem))?;
    let given = BOX.iter().all(|key| table.get(key).is_some());
    let near = own.min.abs().max(own.max.abs()).max_element() <= 1e6;
    let own_serves = near && is_box(own);
    if !(given || own_serves) {
        let problem = format!(
            "has a box from {:?} to {:?}; allowed: coordinates from -1e6 to 1e6, the last at least 1e-6 above the \
             first, or `lower` and `upper` beside it",
            own.min.to_array(),
            own.max.to_array()
        );
        return Err(refuse(node, path, problem));
    }
    Ok(DensityGrid { bounds: read_box(table, Some(own))?, points, values })
}

/// A grid volume in Mitsuba's format, version 3: box, points along each axis, values with x counting up first. The error is
/// half a sentence.
fn read_vol(path: &Path) -> Result<(Bounds, [u32; 3], Vec<f32>), String> {
    let unreadable = |error: io::Error| format!("cannot be read: {}", io_reason(&error));
    let mut file = File::open(path).map_err(unreadable)?;
    let length = file.metadata().map_err(unreadable)?.len();
    const HEADER: usize = 48;
    let mut header = [0; HEADER];
    if length < HEADER as u64 || file.read_exact(&mut header).is_err() || &header[..4] != b"VOL\x03" {
        return Err("is not a grid volume; allowed: Mitsuba's format VOL, version 3".to_owned());
    }
    let word = |index: usize| -> [u8; 4] { std::array::from_fn(|byte| header[4 * index + byte]) };
    let whole = |index: usize| i32::from_le_bytes(word(index));
    let (encoding, channels) = (whole(1), whole(5));
    if encoding != 1 || channels != 1 {
        return Err(format!(
            "has encoding {encoding} and {channels} channels; allowed: encoding 1, which is 32-bit floats, and 1 channel"
        ));
    }
    let points = [2, 3, 4].map(whole);
    let allowed = format!("2 to {MOST_ALONG} along each axis and {MOST_POINTS} in all");
    let [x, y, z] = points;
    let sides = points.map(|points| u32::try_from(points).unwrap_or(0));
    let count: u64 = sides.iter().map(|&side| u64::from(side)).product();
    if sides.iter().any(|side| !(2..=MOST_ALONG).contains(side)) || count > MOST_POINTS {
        return Err(format!("has {x} x {y} x {z} points; allowed: {allowed}"));
    }
    let wanted = HEADER as u64 + 4 * count;
    if length != wanted {
        return Err(format!("is {length} bytes long; its {x} x {y} x {z} points need {wanted}"));
    }
    let corner = |first: usize| Vec3::from([first, first + 1, first + 2].map(|i| f32::from_le_bytes(word(i))));
    let mut values = vec![0f32; count as usize];
    file.read_exact(bytemuck::cast_slice_mut(&mut values)).map_err(unreadable)?;
    values.iter_mut().for_each(|value| *value = f32::from_bits(u32::from_le(value.to_bits())));
    if let Some((index, value)) = values.iter().enumerate().find(|(_, value)| !(0.0..=DENSEST).contains(*value)) {
        return Err(format!("holds {value} as value {index}; allowed: numbers from 0 to 1e9"));
    }
    Ok((Bounds { min: corner(6), max: corner(9) }, sides, values))
}

fn read_noise(table: &Table) -> Result<DensityGrid, SceneError> {
    let bounds = read_box(table, None)?;
    let noise = Noise {
        cell: table.need("cell", "a number of metres")?.number(LENGTH)?,
        octaves: table.or("octaves", 4, |node| node.whole(1, 8))?,
        threshold: table.or("threshold", 0.0, |node| node.number(THRESHOLD))?,
        seed: table.or("seed", 0, |node| node.whole(0, i32::MAX as u32))?,
    };
    let fade = table.or("fade", 0.0, |node| node.number(FADE))?;
    let resolution = table.or("resolution", 64, |node| node.whole(2, 256))?;
    let (lower, upper) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    let size = upper - lower;
    let along = (size / size.max_element() * f64::from(resolution)).round().as_uvec3();
    let points = along.clamp(UVec3::splat(2), UVec3::splat(resolution));
    let step = size / (points - 1).as_dvec3();
    let value = |x: u32, y: u32, z: u32| {
        let at = lower + UVec3::new(x, y, z).as_dvec3() * step;
        let inside = (at - lower).min(upper - at).min_element();
        (noise.density(at) * faded(inside, fade)) as f32
    };
    let mut values = Vec::with_capacity(points.element_product() as usize);
    for z in 0..points.z {
        for y in 0..points.y {
            values.extend((0..points.x).map(|x| value(x, y, z)));
        }
    }
    Ok(DensityGrid { bounds, points: points.to_array(), values })
}

/// Of density, what is left `inside` metres from the box's nearest face.
fn faded(inside: f64, fade: f64) -> f64 {
    let x = if fade > 0.0 { (inside / fade).clamp(0.0, 1.0) } else { 1.0 };
    x * x * (3.0 - 2.0 * x)
}
