//! The rasteriser against exact edges in integers and planes in f64.

use super::{Bench, Case, CaseError, GRAPHICS};
use crate::conformance::DrawnPush;
use crate::conformance::case::Worst;
use crate::conformance::rays::Random;
use crate::conformance::ulps::from_half;
use crate::gpu::{Bindings, Buffer, Plain, Raster, RasterStages, RasterTargets, Recorder};

const fn case(name: &'static str, about: &'static str, run: fn(&mut Bench<'_>) -> Result<(), CaseError>) -> Case {
    Case { group: "raster", name, about, needs: GRAPHICS, minds: &[], catches: &[], run }
}

pub(super) const CASES: &[Case] = &[
    case("coverage", "pixels inside of triangles are covered, those outside are not, by exact edges", coverage),
    case("shared_edges", "of triangles that tile the plane exactly one covers each pixel", shared_edges),
    case("order", "triangles of one draw arrive in their order", order),
    case("depth", "the nearest triangle wins, by planes in f64", depth),
    case("flat", "a triangle's number comes from its first corner, and is whole everywhere", flat),
    case("interpolation", "perspective-correct weights of corners against f64", interpolation),
    case("derivatives", "dFdx and dFdy of what varies evenly against f64", derivatives),
    case("blend_half", "sums in R16G16B16A16_SFLOAT: whole numbers are exact", blend_half),
    case(
        "blend_float",
        "sums in R32G32B32A32_SFLOAT: whole numbers are exact, others rounded once an addition",
        blend_float,
    ),
];

/// Pixels along a side, a power of two: places in clip space are exact then.
const SIDE: u32 = 64;
const PIXELS: usize = (SIDE * SIDE) as usize;
/// Corners lie on a grid of so many points a pixel, which four bits of sub-pixel position hold.
const GRID: i64 = 16;

/// A corner, in units of the grid.
type Point = [i64; 2];
type Triangle = [Point; 3];

/// Twice the signed area; positive for triangles that sums are made of, which are those seen from behind.
fn area([a, b, c]: Triangle) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The triangle with its corners in the order that is drawn in sums.
fn wound(triangle: Triangle) -> Triangle {
    let [a, b, c] = triangle;
    if area(triangle) < 0 { [a, c, b] } else { triangle }
}

fn random_triangle(random: &mut Random) -> Triangle {
    let mut point = || [0, 1].map(|_| random.below((SIDE as i64 * GRID) as usize) as i64);
    loop {
        let triangle = wound([point(), point(), point()]);
        if area(triangle) > 0 {
            return triangle;
        }
    }
}

/// Where a pixel's centre lies.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Place {
    Inside,
    Outside,
    /// On an edge; whether the top-left rule gives it to this triangle.
    Edge {
        top_left: bool,
    },
}

fn place(triangle: Triangle, pixel: usize) -> Place {
    let at = [pixel as i64 % SIDE as i64, pixel as i64 / SIDE as i64].map(|p| p * GRID + GRID / 2);
    let [a, b, c] = triangle;
    let edges = [[a, b], [b, c], [c, a]].map(|[from, to]| {
        // To the right of its direction, which is the inside, with y downward.
        let side = area([from, to, at]);
        let (x, y) = (to[0] - from[0], to[1] - from[1]);
        (side, y < 0 || (y == 0 && x > 0))
    });
    if edges.iter().any(|(side, _)| *side < 0) {
        Place::Outside
    } else if edges.iter().all(|(side, _)| *side > 0) {
        Place::Inside
    } else {
        Place::Edge { top_left: edges.iter().all(|(side, top_left)| *side > 0 || *top_left) }
    }
}

/// In clip space, at a depth and with w, of which places are multiplied.
fn corner(point: Point, depth: f32, w: f32) -> [f32; 4] {
    let clip = point.map(|p| (2.0 * p as f32 / (GRID * SIDE as i64) as f32 - 1.0) * w);
    [clip[0], clip[1], depth * w, w]
}

fn flat_corners(triangles: &[Triangle]) -> Vec<[f32; 4]> {
    triangles.iter().flatten().map(|point| corner(*point, 0.5, 1.0)).collect()
}

/// Draws all triangles and waits; `arguments` are those of an indirect draw instead.
fn draw(
    bench: &Bench<'_>,
    targets: &RasterTargets,
    fragment: &str,
    (mode, corners, values): (u32, &[[f32; 4]], &[[f32; 4]]),
    arguments: Option<&Buffer>,
) -> Result<(), CaseError> {
    let stages = RasterStages { vertex: "conformance/triangles", geometry: None, fragment, variant: "" };
    let raster = Raster::of_stages(bench.device, &stages, targets)?;
    let count = corners.len() as u32;
    let corners = Buffer::from_slice(bench.device, "corners", corners)?;
    let values = Buffer::from_slice(bench.device, "values", values)?;
    let bindings = Bindings::new().buffer("Corners", &corners).buffer("Values", &values);
    let push = DrawnPush { mode, first: 0, columns: SIDE, per_point: 0 };
    let mut recorder = Recorder::new(bench.device)?;
    let mut pass = recorder.pass(fragment)?;
    match arguments {
        Some(arguments) => drop(pass.draw_indirect(&raster, targets, &[&bindings], &push, arguments)?),
        None => drop(pass.draw(&raster, targets, &[&bindings], &[(push, count)])?),
    };
    drop(pass);
    recorder.submit()?;
    Ok(())
}

fn half_targets(bench: &Bench<'_>) -> Result<RasterTargets, CaseError> {
    Ok(RasterTargets::half_sums(bench.device, "sums", SIDE, SIDE)?)
}

fn read_halves(targets: &RasterTargets) -> Result<Vec<[f32; 4]>, CaseError> {
    let pixels: Vec<[u16; 4]> = targets.color.read(PIXELS)?;
    Ok(pixels.iter().map(|pixel| pixel.map(from_half)).collect())
}

/// Triangles that one draw can tell apart: a bit of whole numbers below 2048 in each of four halves.
const TOLD_APART: usize = 44;

/// Of each triangle the pixels that it covers. Each adds a power of two of its own.
fn covered(bench: &Bench<'_>, triangles: &[Triangle]) -> Result<Vec<Vec<bool>>, CaseError> {
    let value = |index: usize| {
        let mut value = [0.0f32; 4];
        value[index / 11] = 2f32.powi((index % 11) as i32);
        value
    };
    let targets = half_targets(bench)?;
    let values: Vec<_> = (0..triangles.len()).map(value).collect();
    draw(bench, &targets, "conformance/values", (0, &flat_corners(triangles), &values), None)?;
    let pixels = read_halves(&targets)?;
    let bit = |pixel: &[f32; 4], index: usize| pixel[index / 11] as u32 >> (index % 11) & 1 == 1;
    Ok((0..triangles.len()).map(|index| pixels.iter().map(|pixel| bit(pixel, index)).collect()).collect())
}

fn coverage(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let mut random = Random(21);
    let (mut lost, mut extra) = (Worst::default(), Worst::default());
    let (mut counts, mut edges, mut other_rule) = ([0u32; 2], 0u32, 0u32);
    for turn in 0..8 {
        let mut triangles: Vec<Triangle> = (0..TOLD_APART).map(|_| random_triangle(&mut random)).collect();
        // Every second draw has its corners on centres of pixels, so that edges run through many others.
        let centre = |place: i64| place / GRID * GRID + GRID / 2;
        if turn % 2 == 1 {
            triangles.iter_mut().for_each(|triangle| *triangle = wound(triangle.map(|corner| corner.map(centre))));
            triangles.retain(|triangle| area(*triangle) > 0);
        }
        for (triangle, covered) in triangles.iter().zip(covered(bench, &triangles)?) {
            for (pixel, covered) in covered.into_iter().enumerate() {
                let at = || {
                    format!("first at pixel {}, {} of {triangle:?} / {GRID}", pixel as u32 % SIDE, pixel as u32 / SIDE)
                };
                match place(*triangle, pixel) {
                    Place::Inside if !covered => {
                        counts[0] += 1;
                        lost.see(1.0, at);
                    }
                    Place::Outside if covered => {
                        counts[1] += 1;
                        extra.see(1.0, at);
                    }
                    Place::Edge { top_left } => {
                        edges += 1;
                        other_rule += u32::from(top_left != covered);
                    }
                    _ => {}
                }
            }
        }
    }
    (lost.measured, extra.measured) = (counts[0].into(), counts[1].into());
    bench.note("centres on edges that do not follow the top-left rule", format!("{other_rule} of {edges}"));
    bench.at_most("pixels inside that are not covered", lost, 0.0, "");
    bench.at_most("pixels outside that are covered", extra, 0.0, "");
    Ok(())
}

/// A tiling of the target: a grid of points of which those within are moved, and two triangles in each of its cells.
fn tiling(random: &mut Random, cells: i64) -> Vec<Triangle> {
    let step = SIDE as i64 * GRID / cells;
    let mut moved =
        |i: i64| if i == 0 || i == cells { 0 } else { random.below(step as usize * 2 / 3) as i64 - step / 3 };
    let points: Vec<Point> = (0..=cells)
        .flat_map(|j| (0..=cells).map(move |i| (i, j)))
        .map(|(i, j)| [i * step + moved(i), j * step + moved(j)])
        .collect();
    let at = |i: i64, j: i64| points[(j * (cells + 1) + i) as usize];
    let cell = |i: i64, j: i64| {
        let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        // Along the diagonal that lies inside, so that neither triangle is turned over.
        let [a, b, c, d] = corners;
        let (first, second) =
            if area([a, b, c]) > 0 && area([a, c, d]) > 0 { ([a, b, c], [a, c, d]) } else { ([a, b, d], [b, c, d]) };
        [first, second]
    };
    (0..cells).flat_map(|j| (0..cells).flat_map(move |i| cell(i, j)).collect::<Vec<_>>()).collect()
}

fn shared_edges(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let mut random = Random(22);
    for cells in [4, 16, 64] {
        let triangles = tiling(&mut random, cells);
        let targets = half_targets(bench)?;
        let values = vec![[1.0f32, 0.0, 0.0, 0.0]; triangles.len()];
        draw(bench, &targets, "conformance/values", (0, &flat_corners(&triangles), &values), None)?;
        let found: Vec<f32> = read_halves(&targets)?.iter().map(|pixel| pixel[0]).collect();
        bench.equal(&format!("triangles on each pixel of a tiling by {}", triangles.len()), &found, &vec![1.0; PIXELS]);
    }
    Ok(())
}

fn order(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    // Triangle k covers the columns 0 to k, and far more above and below.
    let far = 4 * SIDE as i64 * GRID;
    let triangle = |k: i64| wound([[(k + 1) * GRID, -far], [(k + 1) * GRID, far], [-far, 0]]);
    let triangles: Vec<Triangle> = (0..SIDE as i64).map(triangle).collect();
    let corners = flat_corners(&triangles);
    let pixels = 0..PIXELS as u32;
    let first = RasterTargets::ids(bench.device, "first", SIDE, SIDE)?;
    draw(bench, &first, "conformance/ids", (0, &corners, &[[0.0; 4]]), None)?;
    let expected: Vec<[u32; 2]> = pixels.clone().map(|at| [at % SIDE + 1, 0]).collect();
    bench.equal("the first triangle on each pixel", &first.color.read::<[u32; 2]>(PIXELS)?, &expected);
    let last = RasterTargets::plain(bench.device, "last", Plain::Ids, SIDE, SIDE)?;
    draw(bench, &last, "conformance/ids", (0, &corners, &[[0.0; 4]]), None)?;
    bench.equal("the last triangle on each pixel", &last.color.read::<[u32; 2]>(PIXELS)?, &vec![[SIDE, 0]; PIXELS]);
    Ok(())
}

/// Weights of the second and third corner at a pixel's centre, on the screen.
fn screen_weights(triangle: Triangle, pixel: usize) -> [f64; 2] {
    let at = [pixel as i64 % SIDE as i64, pixel as i64 / SIDE as i64].map(|p| p * GRID + GRID / 2);
    let [a, b, c] = triangle;
    let whole = area(triangle) as f64;
    [area([a, at, c]) as f64 / whole, area([a, b, at]) as f64 / whole]
}

/// Depths nearer to each other than this may go either way: roundings of planes over 64 pixels.
const EQUAL_DEPTH: f64 = 1e-5;

fn depth(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let mut random = Random(23);
    let (mut wrong, mut worst, mut told) = (0u32, Worst::default(), 0u32);
    for _ in 0..4 {
        let triangles: Vec<Triangle> = (0..32).map(|_| random_triangle(&mut random)).collect();
        let depths: Vec<[f32; 3]> = triangles.iter().map(|_| [0; 3].map(|_| 0.05 + 0.9 * random.unit())).collect();
        let corners: Vec<[f32; 4]> = (triangles.iter().zip(&depths))
            .flat_map(|(triangle, depths)| [0, 1, 2].map(|i| corner(triangle[i], depths[i], 1.0)))
            .collect();
        let targets = RasterTargets::ids(bench.device, "nearest", SIDE, SIDE)?;
        draw(bench, &targets, "conformance/ids", (0, &corners, &[[0.0; 4]]), None)?;
        let found: Vec<[u32; 2]> = targets.color.read(PIXELS)?;
        for (pixel, found) in found.iter().enumerate() {
            let mut there: Vec<(f64, u32)> = vec![(0.0, 0)];
            let mut on_edge = false;
            for (index, (triangle, depths)) in triangles.iter().zip(&depths).enumerate() {
                let place = place(*triangle, pixel);
                on_edge |= matches!(place, Place::Edge { .. });
                if place == Place::Inside {
                    let [beta, gamma] = screen_weights(*triangle, pixel);
                    let [a, b, c] = depths.map(f64::from);
                    there.push((a + beta * (b - a) + gamma * (c - a), index as u32 + 1));
                }
            }
            there.sort_by(|a, b| b.0.total_cmp(&a.0));
            let close = there.len() > 1 && there[0].0 - there[1].0 < EQUAL_DEPTH;
            if on_edge || close {
                continue;
            }
            told += 1;
            if found[0] != there[0].1 {
                wrong += 1;
                worst.see(1.0, || format!("first at pixel {pixel}: triangle {}, not {}", found[0], there[0].1));
            }
        }
    }
    worst.measured = wrong.into();
    bench.at_most("pixels that show another triangle than the nearest", worst, 0.0, &format!("of {told}"));
    Ok(())
}

fn flat(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let triangles = tiling(&mut Random(24), 8);
    let targets = RasterTargets::plain(bench.device, "numbers", Plain::Ids, SIDE, SIDE)?;
    // Each corner says the triangle's number; w differs, which must not matter.
    let corners: Vec<[f32; 4]> =
        triangles.iter().flatten().enumerate().map(|(i, point)| corner(*point, 0.5, 1.0 + (i % 3) as f32)).collect();
    draw(bench, &targets, "conformance/ids", (0, &corners, &[[0.0; 4]]), None)?;
    let found: Vec<[u32; 2]> = targets.color.read(PIXELS)?;
    let mut worst = Worst::default();
    let mut wrong = 0u32;
    for (pixel, found) in found.iter().enumerate() {
        let triangle = triangles.get((found[0] as usize).wrapping_sub(1));
        if triangle.is_none_or(|triangle| place(*triangle, pixel) == Place::Outside) {
            wrong += 1;
            worst.see(1.0, || format!("first at pixel {pixel}: number {}", found[0]));
        }
    }
    worst.measured = wrong.into();
    bench.at_most("pixels with the number of a triangle that is not there", worst, 0.0, &format!("of {PIXELS}"));
    Ok(())
}

/// Weights may be off by this: a corner's place is known to 1/16 of a pixel at least, and triangles are 30 pixels wide.
const WEIGHTS: f64 = 2e-3;

/// One triangle over most of the target, with w of its corners.
fn large() -> (Triangle, [f32; 3]) {
    ([[8, 24], [984, 136], [312, 1000]], [1.0, 2.5, 7.0])
}

fn interpolation(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let (triangle, w) = large();
    let corners: Vec<[f32; 4]> = (0..3).map(|i| corner(triangle[i], 0.5, w[i])).collect();
    let targets = RasterTargets::plain(bench.device, "weights", Plain::Ids, SIDE, SIDE)?;
    draw(bench, &targets, "conformance/ids", (1, &corners, &[[0.0; 4]]), None)?;
    let found: Vec<[f32; 2]> = targets.color.read(PIXELS)?;
    let mut worst = Worst::default();
    for (pixel, found) in found.iter().enumerate().filter(|(pixel, _)| place(triangle, *pixel) == Place::Inside) {
        let [beta, gamma] = screen_weights(triangle, pixel);
        let [a, b, c] = w.map(f64::from);
        let parts = [(1.0 - beta - gamma) / a, beta / b, gamma / c];
        let whole: f64 = parts.iter().sum();
        for (found, expected) in found.iter().zip([parts[1] / whole, parts[2] / whole]) {
            worst.see((f64::from(*found) - expected).abs(), || format!("pixel {pixel}: {found}, not {expected}"));
        }
    }
    bench.at_most("weights of corners", worst, WEIGHTS, "");
    Ok(())
}

fn derivatives(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let (triangle, _) = large();
    let targets = RasterTargets::plain(bench.device, "derivatives", Plain::Ids, SIDE, SIDE)?;
    draw(bench, &targets, "conformance/ids", (2, &flat_corners(&[triangle]), &[[0.0; 4]]), None)?;
    let found: Vec<[f32; 2]> = targets.color.read(PIXELS)?;
    let (start, right, down) =
        (screen_weights(triangle, 0), screen_weights(triangle, 1), screen_weights(triangle, SIDE as usize));
    let expected = [right[0] - start[0], down[1] - start[1]];
    let mut worst = Worst::default();
    for (pixel, found) in found.iter().enumerate().filter(|(pixel, _)| place(triangle, *pixel) == Place::Inside) {
        for (found, expected) in found.iter().zip(expected) {
            worst.see((f64::from(*found) - expected).abs(), || format!("pixel {pixel}: {found}, not {expected}"));
        }
    }
    bench.at_most("derivatives of weights, a pixel", worst, WEIGHTS, "");
    Ok(())
}

/// Layers over the whole target, of a colour each.
fn layers(bench: &Bench<'_>, targets: &RasterTargets, values: &[[f32; 4]]) -> Result<(), CaseError> {
    let side = SIDE as i64 * GRID;
    let whole = wound([[0, 0], [2 * side, 0], [0, 2 * side]]);
    draw(bench, targets, "conformance/values", (0, &flat_corners(&vec![whole; values.len()]), values), None)
}

fn whole_numbers(count: usize) -> Vec<[f32; 4]> {
    (0..count).map(|i| [1.0, (i % 7) as f32, -((i % 3) as f32), 0.25]).collect()
}

fn sum_of(values: &[[f32; 4]]) -> [f64; 4] {
    let mut sum = [0.0f64; 4];
    values.iter().for_each(|value| (0..4).for_each(|c| sum[c] += f64::from(value[c])));
    sum
}

fn blend_half(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let targets = half_targets(bench)?;
    let values = whole_numbers(300);
    layers(bench, &targets, &values)?;
    bench.equal("sums of 300", &read_halves(&targets)?, &vec![sum_of(&values).map(|v| v as f32); PIXELS]);
    Ok(())
}

fn blend_float(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    if !bench.device.info.limits.float_sums {
        return Err(CaseError::Skip("the driver does not blend 32-bit floats".to_string()));
    }
    let targets = RasterTargets::sums(bench.device, "sums", SIDE, SIDE)?;
    let values = whole_numbers(300);
    layers(bench, &targets, &values)?;
    let found: Vec<[f32; 4]> = targets.color.read(PIXELS)?;
    bench.equal("sums of 300 whole numbers", &found, &vec![sum_of(&values).map(|v| v as f32); PIXELS]);
    let mut random = Random(25);
    let values: Vec<[f32; 4]> = (0..300).map(|_| [0; 4].map(|_| random.unit())).collect();
    layers(bench, &targets, &values)?;
    let expected = sum_of(&values);
    let mut worst = Worst::default();
    for (pixel, found) in targets.color.read::<[f32; 4]>(PIXELS)?.iter().enumerate() {
        for (found, expected) in found.iter().zip(expected) {
            worst.see((f64::from(*found) / expected - 1.0).abs(), || format!("pixel {pixel}: {found}, not {expected}"));
        }
    }
    // Each of 300 additions rounds by half a unit of at most the sum.
    bench.at_most("sums of 300 fractions, relative", worst, 300.0 * 2f64.powi(-24), "");
    Ok(())
}

/// The group `indirect`'s: draws whose number of corners is in a buffer.
pub(super) fn indirect(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let (values, side) = (vec![[1.0f32, 0.0, 0.0, 0.0]; 16], SIDE as i64 * GRID);
    let corners = flat_corners(&vec![wound([[0, 0], [2 * side, 0], [0, 2 * side]]); 16]);
    for triangles in [0u32, 1, 5, 16] {
        let targets = half_targets(bench)?;
        let arguments = Buffer::from_slice(bench.device, "arguments", &[3 * triangles, 1, 0, 0])?;
        draw(bench, &targets, "conformance/values", (0, &corners, &values), Some(&arguments))?;
        let found: Vec<f32> = read_halves(&targets)?.iter().map(|pixel| pixel[0]).collect();
        bench.equal(&format!("triangles on each pixel of {triangles}"), &found, &vec![triangles as f32; PIXELS]);
    }
    Ok(())
}
