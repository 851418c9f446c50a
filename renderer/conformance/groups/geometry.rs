//! The geometry stage: how much it may emit, and in which order it arrives.

use super::{Bench, Case, CaseError};
use crate::conformance::DrawnPush;
use crate::conformance::ulps::from_half;
use crate::gpu::{Bindings, Buffer, Capability, Plain, Raster, RasterStages, RasterTargets, Recorder};

const fn case(name: &'static str, about: &'static str, run: fn(&mut Bench<'_>) -> Result<(), CaseError>) -> Case {
    Case { group: "geometry", name, about, needs: &[Capability::GeometryShader], minds: &[], catches: &[], run }
}

pub(super) const CASES: &[Case] = &[
    case("limits", "points that become 36 quads each, near all of 1024 output components: none is lost", limits),
    case("order", "primitives arrive in the order of points, and in that of their emission within one", order),
];

const POINTS: u32 = 8;
/// Quads of a point: 144 vertices of 7 components are 1008, of the 1024 that every device with this stage offers.
const QUADS: u32 = 36;
const COLUMNS: u32 = POINTS * QUADS;
const ROWS: u32 = 4;

/// Draws all quads, of which number k covers the pixels 0 to k of each row.
fn draw(bench: &Bench<'_>, targets: &RasterTargets, fragment: &str) -> Result<(), CaseError> {
    let stages =
        RasterStages { vertex: "conformance/points", geometry: Some("conformance/quads"), fragment, variant: "" };
    let raster = Raster::of_stages(bench.device, &stages, targets)?;
    let values = Buffer::from_slice(bench.device, "values", &vec![[1.0f32, 0.0, 0.0, 0.0]; COLUMNS as usize])?;
    let bindings = Bindings::new().buffer("Values", &values);
    let push = DrawnPush { mode: 0, first: 0, columns: COLUMNS, per_point: QUADS };
    let mut recorder = Recorder::new(bench.device)?;
    recorder.pass("conformance/quads")?.draw(&raster, targets, &[&bindings], &[(push, POINTS)])?;
    recorder.submit()?;
    Ok(())
}

fn limits(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let limits = bench.device.info.limits;
    bench.note("vertices of one point at most", limits.geometry_vertices);
    bench.note("components of one point at most", limits.geometry_components);
    let targets = RasterTargets::half_sums(bench.device, "quads", COLUMNS, ROWS)?;
    draw(bench, &targets, "conformance/values")?;
    let found: Vec<[u16; 4]> = targets.color.read((COLUMNS * ROWS) as usize)?;
    let found: Vec<f32> = found.iter().map(|pixel| from_half(pixel[0])).collect();
    let expected: Vec<f32> = (0..COLUMNS * ROWS).map(|at| (COLUMNS - at % COLUMNS) as f32).collect();
    bench.equal("quads on each pixel", &found, &expected);
    Ok(())
}

fn order(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    // At equal depth the first wins.
    let nearest = RasterTargets::ids(bench.device, "quads", COLUMNS, ROWS)?;
    draw(bench, &nearest, "conformance/ids")?;
    let found: Vec<[u32; 2]> = nearest.color.read((COLUMNS * ROWS) as usize)?;
    let expected: Vec<[u32; 2]> = (0..COLUMNS * ROWS).map(|at| [at % COLUMNS + 1, 0]).collect();
    bench.equal("the first quad on each pixel", &found, &expected);
    let last = RasterTargets::plain(bench.device, "quads", Plain::Ids, COLUMNS, ROWS)?;
    draw(bench, &last, "conformance/ids")?;
    let found: Vec<[u32; 2]> = last.color.read((COLUMNS * ROWS) as usize)?;
    bench.equal("the last quad on each pixel", &found, &vec![[COLUMNS, 0]; (COLUMNS * ROWS) as usize]);
    Ok(())
}
