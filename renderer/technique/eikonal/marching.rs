//! Fast marching (Sethian 1996), the paper's Algorithm 1: cells are accepted in the order of their values, from a heap. In f64,
//! so that it serves as the truth that the device's solver is held to.

mod boundary;
#[cfg(test)]
mod tests;

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use glam::DVec3;

pub use boundary::close_boundaries;

use super::Grid;

/// How differences are taken against the wave.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// Godunov's: the smaller neighbour along each axis.
    First,
    /// Two cells upwind where both are known and fall (Rickett and Fomel 2000), else as [`First`](Self::First).
    Second,
}

/// Values to start from, one a cell: finite where given, [`UNKNOWN`] where to be found, NaN where the wave does not go.
pub type Start = [f64];
/// The value of a cell that has none yet, or that no wave reaches.
pub const UNKNOWN: f64 = f64::INFINITY;

/// Solves |grad phi| = `cost` (the refractive index, or the paper's F) from the cells given in `start`; the result is in its
/// units, NaN where `start` is.
pub fn march(grid: &Grid, cost: impl Fn(usize) -> f64, start: &Start, order: Order) -> Vec<f64> {
    March::new(grid, start, order).run(cost, None)
}

/// As [`march`], first order, and each cell takes over the label of the neighbour that reached it first.
fn march_labels(grid: &Grid, cost: impl Fn(usize) -> f64, start: &Start, labels: &mut [f64]) -> Vec<f64> {
    March::new(grid, start, Order::First).run(cost, Some(labels))
}

/// The paper's initial values: each cell that vertices fall into has the distance of the nearest of them to its middle, in
/// metres (erratum 17: this is where its noise comes from).
pub fn snap(grid: &Grid, vertices: impl IntoIterator<Item = DVec3>) -> BTreeMap<usize, f64> {
    snap_by(grid, vertices, |vertex, centre| vertex.distance(centre))
}

/// As [`snap`], with the least of what `value` says of vertices and the middle of their cell.
pub fn snap_by(
    grid: &Grid,
    vertices: impl IntoIterator<Item = DVec3>,
    value: impl Fn(DVec3, DVec3) -> f64,
) -> BTreeMap<usize, f64> {
    let mut found = BTreeMap::new();
    for vertex in vertices {
        let at = ((vertex - grid.lower) / grid.cell).floor();
        if at.cmplt(DVec3::ZERO).any() || at.cmpge(glam::UVec3::from(grid.cells).as_dvec3()).any() {
            continue;
        }
        let place = at.as_uvec3().to_array();
        let value = value(vertex, grid.centre(place));
        found.entry(grid.index(place)).and_modify(|d: &mut f64| *d = d.min(value)).or_insert(value);
    }
    found
}

/// A value that sorts; no NaN gets into the heap.
#[derive(PartialEq)]
struct Key(f64);

impl Eq for Key {}

impl PartialOrd for Key {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Key {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

struct March<'a> {
    grid: &'a Grid,
    order: Order,
    phi: Vec<f64>,
    accepted: Vec<bool>,
    /// Cells by value; one that has got a smaller value since has another entry before this one.
    trial: BinaryHeap<Reverse<(Key, usize)>>,
}

impl<'a> March<'a> {
    fn new(grid: &'a Grid, start: &Start, order: Order) -> Self {
        let accepted = start.iter().map(|value| value.is_finite()).collect();
        March { grid, order, phi: start.to_vec(), accepted, trial: BinaryHeap::new() }
    }

    fn run(mut self, cost: impl Fn(usize) -> f64, mut labels: Option<&mut [f64]>) -> Vec<f64> {
        for index in (0..self.phi.len()).filter(|&i| self.phi[i].is_finite()).collect::<Vec<_>>() {
            self.update_neighbours(index, &cost);
        }
        while let Some(Reverse((Key(value), index))) = self.trial.pop() {
            if self.accepted[index] || value > self.phi[index] {
                continue;
            }
            self.accepted[index] = true;
            if let Some(labels) = labels.as_deref_mut()
                && let Some(from) = self.first_neighbour(index)
            {
                labels[index] = labels[from];
            }
            self.update_neighbours(index, &cost);
        }
        self.phi
    }

    fn first_neighbour(&self, index: usize) -> Option<usize> {
        let known = self.grid.neighbours(index).filter(|&n| self.accepted[n]);
        known.min_by(|&a, &b| self.phi[a].total_cmp(&self.phi[b]))
    }

    fn update_neighbours(&mut self, index: usize, cost: &impl Fn(usize) -> f64) {
        for neighbour in self.grid.neighbours(index) {
            if self.accepted[neighbour] || self.phi[neighbour].is_nan() {
                continue;
            }
            let value = self.value(neighbour, cost(neighbour));
            if value < self.phi[neighbour] {
                self.phi[neighbour] = value;
                self.trial.push(Reverse((Key(value), neighbour)));
            }
        }
    }

    /// What the accepted neighbours say of a cell.
    fn value(&self, index: usize, cost: f64) -> f64 {
        let (place, strides) = (self.grid.place(index), self.grid.strides());
        let known = |index: usize| if self.accepted[index] { self.phi[index] } else { UNKNOWN };
        let terms = [0, 1, 2].map(|axis| {
            let (at, stride, last) = (place[axis], strides[axis], self.grid.cells[axis] - 1);
            let below = if at > 0 { known(index - stride) } else { UNKNOWN };
            let above = if at < last { known(index + stride) } else { UNKNOWN };
            let (near, far) = if below <= above {
                (below, if at > 1 { known(index - 2 * stride) } else { UNKNOWN })
            } else {
                (above, if at + 1 < last { known(index + 2 * stride) } else { UNKNOWN })
            };
            if self.order == Order::Second && far <= near && near.is_finite() {
                Term { value: (4.0 * near - far) / 3.0, weight: 2.25 }
            } else {
                Term { value: near, weight: 1.0 }
            }
        });
        solve(terms, cost * self.grid.cell)
    }
}

/// An axis's part in the difference: weight (phi - value)^2, cells.
#[derive(Debug, Clone, Copy)]
struct Term {
    value: f64,
    weight: f64,
}

/// The phi for which the terms below it add up to `step` squared.
fn solve(mut terms: [Term; 3], step: f64) -> f64 {
    terms.sort_by(|a, b| a.value.total_cmp(&b.value));
    let mut phi = UNKNOWN;
    // With the moments about the first value nothing large is subtracted.
    let origin = terms[0].value;
    let (mut weight, mut first, mut second) = (0.0, 0.0, 0.0);
    for term in terms {
        if term.value >= phi || !term.value.is_finite() {
            break;
        }
        let value = term.value - origin;
        weight += term.weight;
        first += term.weight * value;
        second += term.weight * value * value;
        let root = first * first - weight * (second - step * step);
        if root < 0.0 {
            break;
        }
        phi = origin + (first + root.sqrt()) / weight;
    }
    phi
}
