use super::super::path::Source;
use super::*;

const WATER: f64 = 1.33;
const DEPTH: f64 = 1.0;

/// A unit cube of cells under a surface that crosses it near the top.
fn cube(cells: u32) -> Grid {
    Grid { lower: DVec3::ZERO, cell: DEPTH / f64::from(cells), cells: [cells; 3] }
}

/// Gives the exact values in cells less than `band` cells below the surface; `height` is how far a place is under it, about.
fn start(grid: &Grid, exact: impl Fn(DVec3) -> f64, depth: impl Fn(DVec3) -> f64, band: f64) -> Vec<f64> {
    let value = |at: DVec3| match depth(at) / grid.cell {
        d if d < 0.0 => f64::NAN,
        d if d < band => exact(at),
        _ => UNKNOWN,
    };
    grid.centres().map(value).collect()
}

/// As `start`, with the exact values on all cells at the grid's sides too, so that nothing enters from beyond them.
fn start_closed(grid: &Grid, exact: impl Fn(DVec3) -> f64, depth: impl Fn(DVec3) -> f64, band: f64) -> Vec<f64> {
    let mut values = start(grid, &exact, depth, band);
    for (index, value) in values.iter_mut().enumerate() {
        let place = grid.place(index);
        let margin = (0..3).map(|a| place[a].min(grid.cells[a] - 1 - place[a])).min().unwrap_or(0);
        if !value.is_nan() && f64::from(margin) < band {
            *value = exact(grid.centre(place));
        }
    }
    values
}

/// Largest and mean error, in cells times index.
fn errors(grid: &Grid, found: &[f64], exact: impl Fn(DVec3) -> f64) -> (f64, f64) {
    let pairs = found.iter().zip(grid.centres()).filter(|(value, _)| !value.is_nan());
    let wrong: Vec<f64> = pairs.map(|(value, at)| (value - exact(at)).abs() / grid.cell / WATER).collect();
    (wrong.iter().copied().fold(0.0, f64::max), wrong.iter().sum::<f64>() / wrong.len() as f64)
}

#[test]
fn planes_are_exact() {
    // A linear phi has differences without error, whatever its direction: only rounding is left.
    for direction in [DVec3::NEG_Y, DVec3::new(0.5, -1.0, 0.3).normalize(), DVec3::new(-0.9, -0.4, 0.2).normalize()] {
        let exact = |at: DVec3| WATER * (direction.dot(at) + 2.0);
        let grid = cube(24);
        for order in [Order::First, Order::Second] {
            let start = start_closed(&grid, exact, |at| 0.9 - at.y, 2.0);
            let (most, _) = errors(&grid, &march(&grid, |_| WATER, &start, order), exact);
            assert!(most < 1e-10, "{direction} {order:?}: {most} cells");
        }
    }
}

/// Rays from a point above flat water.
fn lamp(at: DVec3) -> f64 {
    let source = Source::Point { position: DVec3::new(0.3, 2.5, 0.6), index: 1.0 };
    source.through_plane(DVec3::new(0.0, 0.9, 0.0), DVec3::Y, at, WATER).0
}

/// Parallel light from above through a cap whose middle lies at the top: distance to the sphere, from inside.
fn cap(at: DVec3) -> f64 {
    WATER * (1.5 - at.distance(DVec3::new(0.5, -0.6, 0.5)))
}

/// The order of convergence in the mean between two grids.
fn order_of(exact: fn(DVec3) -> f64, depth: fn(DVec3) -> f64, order: Order) -> f64 {
    let run = |cells: u32| {
        let grid = cube(cells);
        // What is given is as thick in metres on both.
        let start = start_closed(&grid, exact, depth, 2.0 * f64::from(cells) / 24.0);
        let (most, mean) = errors(&grid, &march(&grid, |_| WATER, &start, order), exact);
        (mean * grid.cell, most)
    };
    let [coarse, fine] = [run(24), run(48)];
    (coarse.0 / fine.0).log2()
}

#[test]
fn errors_fall_with_the_order() {
    for (name, exact, depth) in [
        ("lamp", lamp as fn(DVec3) -> f64, (|at| 0.9 - at.y) as fn(DVec3) -> f64),
        ("cap", cap, |at| 1.5 - at.distance(DVec3::new(0.5, -0.6, 0.5))),
    ] {
        let [first, second] = [Order::First, Order::Second].map(|order| order_of(exact, depth, order));
        assert!(first > 0.8, "{name}: first order is {first}");
        assert!(second > 1.7, "{name}: second order is {second}");
    }
}

#[test]
fn two_passes_continue_a_tilted_plane() {
    // Parallel light at right angles to a tilted surface: without the boundary's own waves, rounds enter from the sides.
    let normal = DVec3::new(0.35, -0.9, -0.2).normalize();
    let middle = DVec3::new(0.5, 0.8, 0.5);
    let exact = |at: DVec3| normal.dot(at - middle);
    let grid = cube(24);
    let mut open = start(&grid, exact, exact, 1.8);
    let (before, _) = errors(&grid, &march(&grid, |_| 1.0, &open, Order::First), exact);
    close_boundaries(&grid, &mut open, |_| normal);
    let (after, _) = errors(&grid, &march(&grid, |_| 1.0, &open, Order::First), exact);
    assert!(before > 0.5, "the boundary did no harm: {before} cells");
    assert!(after < 1e-10, "{after} cells");
}

#[test]
fn snapping_is_off_by_a_part_of_a_cell() {
    // The printed initial values of flat water half-way between cells' middles: distances to vertices, not to the plane.
    let grid = cube(16);
    let vertices = (0..64 * 64).map(|i| DVec3::new(f64::from(i % 64) + 0.5, 57.0, f64::from(i / 64) + 0.5) / 64.0);
    let snapped = snap(&grid, vertices);
    assert_eq!(snapped.len(), 16 * 16);
    let noise = snapped.values().map(|d| d / grid.cell).fold((1.0f64, 0.0f64), |(l, h), d| (l.min(d), h.max(d)));
    assert!(noise.0 > 0.2 && noise.1 < 0.5, "{noise:?}");
}
