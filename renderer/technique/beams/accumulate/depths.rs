//! What lies along the edges of beams in media of uneven density, worked out once for all pixels that meet them.

use super::BeamBuffers;
use crate::gpu::{Bindings, Buffer, Device, GpuError, Kernel, Recorder};

/// As in `kernels/technique/beams/beam_depths.glsl`.
const BEAM_PLACES: usize = 16;

crate::gpu_struct! {
    /// Optical depth along an edge; see `kernels/technique/beams/beam_depths.glsl`.
    pub struct BeamDepths {
        pub first: f32,
        pub step: f32,
        pub total: f32,
        pub parts: [u32; BEAM_PLACES / 2],
    }
}

crate::gpu_struct! {
    pub struct BeamDepthsPush {
        pub capacity: u32,
    }
}

pub struct Depths {
    kernel: Kernel,
    bindings: Bindings,
    capacity: u32,
}

impl Depths {
    pub fn new(device: &Device, beams: &BeamBuffers) -> Result<Self, GpuError> {
        let bytes = 3 * u64::from(beams.capacity) * size_of::<BeamDepths>() as u64;
        Ok(Depths {
            kernel: Kernel::new(device, "beams/depths", "")?,
            bindings: Bindings::new().buffer("AllBeamDepths", &Buffer::new(device, "beam depths", bytes)?),
            capacity: beams.capacity,
        })
    }

    pub fn bindings(&self) -> &Bindings {
        &self.bindings
    }

    pub fn record(&self, recorder: &mut Recorder, bindings: &[&Bindings]) -> Result<(), GpuError> {
        let push = BeamDepthsPush { capacity: self.capacity };
        recorder.pass("beams/depths")?.dispatch(&self.kernel, bindings, &push, 3 * self.capacity)?;
        Ok(())
    }
}
