//! The record of one beam, as generation writes it and accumulation reads it.

use crate::gpu::{GpuStruct, Layout};

crate::gpu_struct! {
    /// One edge of a beam; see `kernels/technique/beams/beam.glsl`.
    pub struct BeamCorner {
        pub origin: [f32; 3],
        pub start: f32,
        pub way: [f32; 3],
        pub end: f32,
        pub area: [f32; 3],
        pub flux: f32,
    }
}

crate::gpu_struct! {
    /// One beam; see `kernels/technique/beams/beam.glsl`.
    pub struct Beam {
        pub corners: [BeamCorner; 3],
        pub normal: [f32; 3],
        pub medium: u32,
        pub flux: [f32; 3],
        pub flags: u32,
    }
}

crate::gpu_struct! {
    /// How many beams there are.
    pub struct BeamHeader {
        pub count: u32,
        pub padding0: u32,
        pub padding1: u32,
        pub padding2: u32,
    }
}

pub const LAYOUTS: &[Layout] = &[BeamCorner::LAYOUT, Beam::LAYOUT, BeamHeader::LAYOUT];

/// [`Beam::flags`]: the edges do not end on one smooth surface.
pub const STRADDLES: u32 = 1;
/// [`Beam::flags`]: the slot is empty.
pub const EMPTY: u32 = 2;
