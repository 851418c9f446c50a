//! Regular grids of cubic cells.

use glam::DVec3;

/// Cubic cells in a box; values belong to their middles. x counts up first, then y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// World space, metres: the box's lower corner, which the first cell's middle is half a cell off.
    pub lower: DVec3,
    /// Metres along a cell's side.
    pub cell: f64,
    /// Along each axis, at least 1.
    pub cells: [u32; 3],
}

impl Grid {
    /// Cells in all.
    pub fn len(&self) -> usize {
        self.cells.iter().map(|&n| n as usize).product()
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub fn index(&self, at: [u32; 3]) -> usize {
        let [x, y, z] = at.map(|i| i as usize);
        (z * self.cells[1] as usize + y) * self.cells[0] as usize + x
    }

    /// The other way round from [`index`](Self::index).
    pub fn place(&self, index: usize) -> [u32; 3] {
        let [x, y] = [self.cells[0] as usize, self.cells[1] as usize];
        [(index % x) as u32, (index / x % y) as u32, (index / (x * y)) as u32]
    }

    /// A cell's middle, world space.
    pub fn centre(&self, at: [u32; 3]) -> DVec3 {
        self.lower + self.cell * (glam::UVec3::from(at).as_dvec3() + 0.5)
    }

    /// Middles of all cells, in order.
    pub fn centres(&self) -> impl Iterator<Item = DVec3> + '_ {
        (0..self.len()).map(|index| self.centre(self.place(index)))
    }

    /// From one cell to the next along each axis, in indices.
    pub fn strides(&self) -> [usize; 3] {
        [1, self.cells[0] as usize, self.cells[0] as usize * self.cells[1] as usize]
    }

    /// Those that share a face with a cell, up to six.
    pub fn neighbours(&self, index: usize) -> impl Iterator<Item = usize> + use<> {
        let (place, strides, cells) = (self.place(index), self.strides(), self.cells);
        (0..3).flat_map(move |axis| {
            let below = (place[axis] > 0).then(|| index - strides[axis]);
            let above = (place[axis] + 1 < cells[axis]).then(|| index + strides[axis]);
            [below, above].into_iter().flatten()
        })
    }
}
