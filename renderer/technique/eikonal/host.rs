//! The paper's own method in place of the device's solver: fast marching on the host, for pictures to compare with.

use glam::DVec3;

use super::Grid;
use super::marching::{close_boundaries, march, snap_by};
use super::plan::Plan;
use super::solver::Marching;
use crate::scene::Scene;

/// Optical paths in all cells from those that the device gave next to the surface, and which they are; NaN outside of the
/// medium.
pub(super) fn march_from(plan: &Plan, scene: &Scene, values: &[f64], given: &[bool], how: Marching) -> Vec<f64> {
    let grid = &plan.grid;
    let index = f64::from(plan.shared.grid.index);
    let known = |(&value, &given): (&f64, &bool)| if value.is_nan() || given { value } else { f64::INFINITY };
    let exact: Vec<f64> = values.iter().zip(given).map(known).collect();
    let mut start = if how.snapped { snapped(plan, scene, &exact, index) } else { exact.clone() };
    if how.sides {
        // Marching along sides counts in cells' ways.
        start.iter_mut().for_each(|value| *value /= index);
        let mut main = DVec3::ZERO;
        main[plan.shared.grid.axes[2] as usize] = if plan.shared.grid.backward != 0 { -1.0 } else { 1.0 };
        // The middle of a cell that vertices fell into may be outside of the medium, where there is no wave to ask.
        let inside = |at: &usize| exact[*at].is_finite();
        let nearest = |at: usize| std::iter::once(at).chain(grid.neighbours(at)).find(inside);
        let way = |at: usize| nearest(at).map_or(main, |at| way_at(grid, &exact, at));
        close_boundaries(grid, &mut start, way);
        start.iter_mut().for_each(|value| *value *= index);
    }
    let mut found = march(grid, |_| index, &start, how.order);
    // Vertices may have fallen into cells whose middles are outside.
    found.iter_mut().zip(values).filter(|(_, value)| value.is_nan()).for_each(|(found, _)| *found = f64::NAN);
    found
}

fn snapped(plan: &Plan, scene: &Scene, exact: &[f64], index: f64) -> Vec<f64> {
    let vertices = plan.facets.iter().flat_map(|facets| {
        let instance = &scene.instances[facets.instance as usize];
        let mesh = &scene.meshes[instance.mesh];
        let corner = |&at: &u32| instance.transform.transform_point3(mesh.positions[at as usize]).as_dvec3();
        mesh.triangles.iter().flat_map(move |corners| points(corners.each_ref().map(corner), plan.grid.cell))
    });
    let path = |vertex: DVec3, centre: DVec3| plan.source.path_to(vertex) + index * vertex.distance(centre);
    let mut start: Vec<f64> = exact.iter().map(|v| if v.is_nan() { f64::NAN } else { f64::INFINITY }).collect();
    for (cell, value) in snap_by(&plan.grid, vertices, path) {
        start[cell] = value;
    }
    start
}

/// A triangle's corners, and where they are more than a cell apart, points between them: the paper takes meshes to be as fine
/// as cells.
fn points([a, b, c]: [DVec3; 3], cell: f64) -> impl Iterator<Item = DVec3> {
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    let parts = (longest / cell).ceil().clamp(1.0, 4096.0) as u32;
    let place = move |i: u32, j: u32| a + ((b - a) * f64::from(i) + (c - a) * f64::from(j)) / f64::from(parts);
    (0..=parts).flat_map(move |i| (0..=parts - i).map(move |j| place(i, j)))
}

/// Unit; where light goes at a cell, from values around it.
fn way_at(grid: &Grid, values: &[f64], at: usize) -> DVec3 {
    let (place, strides) = (grid.place(at), grid.strides());
    let rise = [0, 1, 2].map(|axis| {
        let below = (place[axis] > 0).then(|| values[at - strides[axis]]).filter(|v| v.is_finite());
        let above = (place[axis] + 1 < grid.cells[axis]).then(|| values[at + strides[axis]]).filter(|v| v.is_finite());
        match (below, above) {
            (Some(below), Some(above)) => 0.5 * (above - below),
            (Some(below), None) => values[at] - below,
            (None, Some(above)) => above - values[at],
            (None, None) => 0.0,
        }
    });
    DVec3::from(rise).normalize_or_zero()
}
