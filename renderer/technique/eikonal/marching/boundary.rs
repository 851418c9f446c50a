//! The paper's Algorithm 2: the wave in the grid's faces and edges is found first, as if the surface went on linearly beyond
//! them. In a face the wave that comes along a plane with unit normal n advances by the part of n in the face, so its cost
//! there is the root of 1 - n_a^2. (The text has one over that part; a wave that arrives earlier needs less, not more.)

use glam::DVec3;

use super::super::Grid;
use super::{Order, Start, UNKNOWN, march, march_labels};

/// Gives `start` values on all faces that cells given in it touch; `normal` is the wave's unit direction at a given cell.
pub fn close_boundaries(grid: &Grid, start: &mut Start, normal: impl Fn(usize) -> DVec3) {
    let given: Vec<bool> = start.iter().map(|value| value.is_finite()).collect();
    for across in 0..3 {
        for side in [0, grid.cells[across] - 1] {
            let face = Part::face(grid, across, side);
            for edge in face.edges(grid) {
                edge.find(grid, start, &given, &normal);
            }
            face.find(grid, start, &given, &normal);
        }
    }
}

/// The cells of a face or an edge, as a grid of their own.
struct Part {
    grid: Grid,
    /// First cell, in the whole grid.
    first: [u32; 3],
    /// Which of the whole grid's axes have one cell here.
    fixed: [bool; 3],
}

impl Part {
    fn face(grid: &Grid, across: usize, side: u32) -> Part {
        let (mut first, mut cells, mut fixed) = ([0; 3], grid.cells, [false; 3]);
        (first[across], cells[across], fixed[across]) = (side, 1, true);
        Part { grid: Grid { cells, ..*grid }, first, fixed }
    }

    fn edges(&self, grid: &Grid) -> Vec<Part> {
        let along = (0..3).filter(|&axis| !self.fixed[axis]);
        let sides = along.flat_map(|axis| [(axis, 0), (axis, grid.cells[axis] - 1)]);
        let edge = |(axis, side): (usize, u32)| {
            let mut part = Part { grid: self.grid, first: self.first, fixed: self.fixed };
            (part.first[axis], part.grid.cells[axis], part.fixed[axis]) = (side, 1, true);
            part
        };
        sides.map(edge).collect()
    }

    /// Where a cell of this part is in the whole grid.
    fn whole(&self, grid: &Grid, index: usize) -> usize {
        let place = self.grid.place(index);
        grid.index([0, 1, 2].map(|axis| self.first[axis] + place[axis]))
    }

    /// Two passes: costs go out from given cells as the wave would at cost 1, then the wave goes by those costs.
    fn find(&self, grid: &Grid, start: &mut Start, given: &[bool], normal: &impl Fn(usize) -> DVec3) {
        let places: Vec<usize> = (0..self.grid.len()).map(|index| self.whole(grid, index)).collect();
        if !places.iter().any(|&place| given[place]) {
            return;
        }
        let mut costs: Vec<f64> = places.iter().map(|&p| if given[p] { self.cost(normal(p)) } else { 1.0 }).collect();
        let interface = |&p: &usize| if given[p] || start[p].is_nan() { start[p] } else { UNKNOWN };
        let first: Vec<f64> = places.iter().map(interface).collect();
        march_labels(&self.grid, |_| 1.0, &first, &mut costs);
        // What the edges found is given to the face.
        let second: Vec<f64> = places.iter().map(|&p| start[p]).collect();
        let phi = march(&self.grid, |index| costs[index], &second, Order::First);
        for (&place, value) in places.iter().zip(phi) {
            start[place] = value;
        }
    }

    fn cost(&self, normal: DVec3) -> f64 {
        let inside = (0..3).filter(|&axis| !self.fixed[axis]);
        inside.map(|axis| normal[axis] * normal[axis]).sum::<f64>().sqrt()
    }
}
