//! What beams were cut from, read back: for checks.

use super::generate::{BeamLeaf, BeamState, Generator, LatticePlace};
use crate::gpu::{Binding, GpuError};

/// A triangle of a light's lattice that was not split.
#[derive(Debug, Clone, Copy)]
pub struct Leaf {
    /// Index into the [views](crate::light_view::LightViews::views) of all lights.
    pub view: u32,
    /// Column and row of each on the view's finest grid, counter-clockwise in the chart.
    pub corners: [[u32; 2]; 3],
    /// Of the coarse grids over all views: (view * grid + row) * grid + column.
    pub cell: u32,
    /// W that the light sends through it, rgb.
    pub flux: [f64; 3],
}

impl Generator {
    /// The leaves of the last set, as far as there was room for them.
    ///
    /// # Errors
    /// Those of reading memory of the device.
    pub fn leaves(&self) -> Result<Vec<Leaf>, GpuError> {
        let state = self.read::<BeamState>("BeamStates", 1)?[0];
        let leaves: Vec<BeamLeaf> = self.read("BeamLeaves", state.leaves as usize)?;
        let vertices = leaves.iter().flat_map(|leaf| leaf.vertices).max().map_or(0, |last| last as usize + 1);
        let places: Vec<LatticePlace> = self.read("LatticePlaces", vertices)?;
        let cells = leaves.iter().map(|leaf| leaf.cell as usize + 1).max().unwrap_or(0);
        let scales: Vec<[f32; 4]> = self.read("CellScales", cells)?;
        let place = |vertex: u32| [places[vertex as usize].column, places[vertex as usize].row];
        let flux = |leaf: &BeamLeaf, c: usize| f64::from(leaf.power[c]) * f64::from(scales[leaf.cell as usize][c]);
        Ok(leaves
            .iter()
            .map(|leaf| Leaf {
                view: places[leaf.vertices[0] as usize].view,
                corners: leaf.vertices.map(place),
                cell: leaf.cell,
                flux: [0, 1, 2].map(|c| flux(leaf, c)),
            })
            .collect())
    }

    fn read<T: bytemuck::Pod>(&self, block: &str, count: usize) -> Result<Vec<T>, GpuError> {
        match self.bindings.get(block) {
            Some(Binding::Buffer(buffer)) => buffer.read(count),
            _ => Ok(Vec::new()),
        }
    }
}
