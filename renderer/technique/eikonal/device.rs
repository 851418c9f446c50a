//! What host and kernels share.

use glam::Vec3;

use super::Grid;
use super::path::Source;
use crate::gpu::{GpuStruct, Layout};

crate::gpu_struct! {
    /// See `kernels/technique/eikonal/grid.glsl`.
    pub struct EikonalGrid {
        pub lower: [f32; 3],
        pub cell: f32,
        pub cells: [u32; 3],
        pub index: f32,
        pub strides: [i32; 3],
        pub first: i32,
        pub axes: [u32; 3],
        pub backward: u32,
    }
}

crate::gpu_struct! {
    /// See `kernels/technique/eikonal/path.glsl`.
    pub struct EikonalSource {
        pub place: [f32; 3],
        pub kind: u32,
        pub reference: [f32; 3],
        pub index: f32,
    }
}

crate::gpu_struct! {
    /// See `kernels/technique/eikonal/volume.glsl`.
    pub struct EikonalVolume {
        pub grid: EikonalGrid,
        pub source: EikonalSource,
        pub light_medium: u32,
        pub wave_medium: u32,
        pub band: u32,
        pub padding0: u32,
    }
}

crate::gpu_struct! {
    pub struct FacetPush {
        pub volume: u32,
        pub instance: u32,
        pub triangles: u32,
        pub parts: u32,
    }
}

crate::gpu_struct! {
    pub struct EikonalPush {
        pub volume: u32,
    }
}

crate::gpu_struct! {
    /// See `kernels/technique/eikonal/update.glsl`.
    pub struct EikonalSweep {
        pub cells: [u32; 3],
        pub first: i32,
        pub strides: [i32; 3],
        pub step: f32,
        pub foot: [i32; 2],
        pub turn: u32,
        pub options: u32,
    }
}

crate::gpu_struct! {
    pub struct SweepPush {
        pub sweep: EikonalSweep,
    }
}

crate::gpu_struct! {
    pub struct SettlePush {
        pub sweep: EikonalSweep,
        pub least: f32,
        pub padding0: u32,
    }
}

crate::gpu_struct! {
    /// See `kernels/technique/eikonal/light.comp.glsl`.
    pub struct LitPush {
        pub volume: u32,
        pub runs: u32,
    }
}

crate::gpu_struct! {
    /// See `kernels/technique/eikonal/curve.comp.glsl`.
    pub struct CurvePush {
        pub volume: u32,
        pub base: f32,
        pub gain: f32,
        pub power: f32,
    }
}

crate::gpu_struct! {
    /// See `kernels/technique/eikonal/spread.comp.glsl`.
    pub struct SpreadPush {
        pub volume: u32,
        pub step: u32,
        pub first: f32,
        pub slope: f32,
        pub last: u32,
    }
}

crate::gpu_struct! {
    pub struct CheckPush {
        pub sweep: EikonalSweep,
        pub tolerance: f32,
        pub asks: f32,
    }
}

crate::gpu_struct! {
    /// See `kernels/technique/eikonal/checks.glsl`.
    pub struct EikonalChecks {
        pub worst: u32,
        pub unsettled: u32,
        pub unreached: u32,
        pub groups_x: u32,
        pub groups_y: u32,
        pub groups_z: u32,
        pub asked: u32,
        pub padding0: u32,
    }
}

crate::gpu_struct! {
    pub struct DecidePush {
        pub groups_x: u32,
        pub groups_y: u32,
    }
}

crate::gpu_struct! {
    /// See `kernels/technique/eikonal/gather.comp.glsl`.
    pub struct LookUpPush {
        pub light: u32,
        pub first: u32,
        pub shadows: u32,
        pub factor: u32,
        pub between: u32,
    }
}

pub const LAYOUTS: &[Layout] = &[
    LookUpPush::LAYOUT,
    EikonalGrid::LAYOUT,
    EikonalSource::LAYOUT,
    EikonalVolume::LAYOUT,
    FacetPush::LAYOUT,
    EikonalPush::LAYOUT,
    EikonalSweep::LAYOUT,
    SweepPush::LAYOUT,
    SettlePush::LAYOUT,
    LitPush::LAYOUT,
    CurvePush::LAYOUT,
    SpreadPush::LAYOUT,
    CheckPush::LAYOUT,
    EikonalChecks::LAYOUT,
    DecidePush::LAYOUT,
];

/// In place of a value: not part of the wave's medium.
pub const OUTSIDE: f32 = 3e38;
/// In place of a value: none yet.
pub const UNKNOWN: f32 = 1e30;
/// In place of light: not known.
pub const UNLIT: f32 = -1e30;

impl EikonalGrid {
    /// `grid` in planes that a wave along `way` goes through one after the other, in a medium of that index.
    pub fn new(grid: &Grid, way: Vec3, index: f64) -> Self {
        let along = way.abs().max_position();
        let across = [[1, 2], [0, 2], [0, 1]][along];
        let axes = [across[0], across[1], along];
        let backward = way[along] < 0.0;
        let stride = |axis: usize| grid.strides()[axis] as i32;
        let last = grid.cells[along] as i32 - 1;
        EikonalGrid {
            lower: grid.lower.as_vec3().to_array(),
            cell: grid.cell as f32,
            cells: axes.map(|axis| grid.cells[axis]),
            index: index as f32,
            strides: [stride(across[0]), stride(across[1]), if backward { -stride(along) } else { stride(along) }],
            first: if backward { last * stride(along) } else { 0 },
            axes: axes.map(|axis| axis as u32),
            backward: u32::from(backward),
        }
    }

    /// The column under a place, clamped to those there are.
    pub fn column(&self, grid: &Grid, place: glam::DVec3) -> [i32; 2] {
        [0, 1].map(|i| {
            let axis = self.axes[i] as usize;
            let at = (place[axis] - grid.lower[axis]) / grid.cell - 0.5;
            at.round().clamp(0.0, f64::from(self.cells[i]) - 1.0) as i32
        })
    }
}

/// Cells that the reference lies before the grid: the surface may reach beyond it by fewer.
const AHEAD: f64 = 8.0;

impl EikonalSource {
    /// The source as kernels see it, and the optical path to its reference, which they leave out.
    pub fn new(source: &Source, grid: &Grid) -> (Self, f64) {
        let size = grid.cell * glam::UVec3::from(grid.cells).as_dvec3();
        let (place, kind, reference, index) = match *source {
            Source::Point { position, index } => {
                let nearest = position.clamp(grid.lower, grid.lower + size);
                let towards = (grid.lower + 0.5 * size - position).normalize_or(glam::DVec3::NEG_Y);
                let distance = (position.distance(nearest) - AHEAD * grid.cell).max(0.0);
                (position, 0, position + distance * towards, index)
            }
            Source::Directional { direction, index } => {
                let first = glam::BVec3::new(direction.x < 0.0, direction.y < 0.0, direction.z < 0.0);
                let corner = glam::DVec3::select(first, grid.lower + size, grid.lower);
                (direction, 1, corner - AHEAD * grid.cell * direction, index)
            }
            Source::Surface => (glam::DVec3::ZERO, 2, glam::DVec3::ZERO, 0.0),
        };
        let reference = reference.as_vec3();
        let shared = EikonalSource {
            place: place.as_vec3().to_array(),
            kind,
            reference: reference.to_array(),
            index: index as f32,
        };
        (shared, source.path_to(reference.as_dvec3()))
    }
}
