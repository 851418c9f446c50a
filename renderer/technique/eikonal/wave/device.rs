//! What host and kernels share of the scalar wave.

use crate::gpu::{GpuStruct, Layout};

crate::gpu_struct! {
    /// See `kernels/technique/eikonal/wave.glsl`.
    pub struct WaveGrid {
        pub cells: [u32; 3],
        pub first: i32,
        pub strides: [i32; 3],
        pub border: u32,
        pub blocks: [u32; 3],
        pub top: u32,
    }
}

crate::gpu_struct! {
    /// See `kernels/technique/eikonal/wave.glsl`.
    pub struct WaveBlock {
        pub even: u32,
        pub odd: u32,
        pub driven: u32,
        pub first: u32,
        pub last: u32,
        pub padding0: u32,
    }
}

crate::gpu_struct! {
    pub struct WaveStartPush {
        pub grid: WaveGrid,
        pub step: f32,
        pub lead: f32,
        pub scale: f32,
        pub at_once: f32,
    }
}

crate::gpu_struct! {
    pub struct WaveStepPush {
        pub grid: WaveGrid,
        pub turn: u32,
        pub sum: u32,
        pub quiet: f32,
        pub width: f32,
        pub damping: f32,
        pub strands: u32,
    }
}

crate::gpu_struct! {
    pub struct WaveResultPush {
        pub grid: WaveGrid,
        pub scale: f32,
        pub flat_sum: f32,
        pub root: f32,
        pub gain: f32,
        pub power: f32,
    }
}

pub const LAYOUTS: &[Layout] =
    &[WaveGrid::LAYOUT, WaveBlock::LAYOUT, WaveStartPush::LAYOUT, WaveStepPush::LAYOUT, WaveResultPush::LAYOUT];

/// Cells of a block along u, v and planes, as in the kernels.
pub const BLOCK: [u32; 3] = [16, 16, 4];

/// Zeros around all of them; fours along u stay together.
const RIM: [u32; 3] = [4, 1, 1];

impl WaveGrid {
    /// Cells of the wave's buffers, their rim of zeros included.
    pub fn padded(&self) -> [u64; 3] {
        [0, 1, 2].map(|i| u64::from(self.blocks[i] * BLOCK[i] + 2 * RIM[i]))
    }

    /// Index in the wave's buffers of a cell of the volume, in columns and planes.
    pub fn index(&self, at: [u32; 3]) -> usize {
        let [u, v, _] = self.padded();
        let before = [self.border, self.border, self.top];
        let [x, y, z] = [0, 1, 2].map(|i| u64::from(at[i] + before[i] + RIM[i]));
        ((z * v + y) * u + x) as usize
    }
}
