//! Boxes round blocks of beams and round groups of blocks: whole regions of the picture pass by most beams with a few of
//! them looked at.

use crate::gpu::{Bindings, Buffer, Device, GpuError, Kernel, Recorder};

/// As in `kernels/technique/beams/stored.glsl`.
const BLOCK_BEAMS: u32 = 32;
const GROUP_BLOCKS: u32 = 32;

crate::gpu_struct! {
    /// A box round beams; see `kernels/technique/beams/stored.glsl`.
    pub struct BeamBox {
        pub low: [f32; 3],
        pub beams: u32,
        pub high: [f32; 3],
        pub media: u32,
        pub axis: [f32; 3],
        pub near: f32,
        pub at_near: [f32; 4],
        pub at_far: [f32; 4],
        pub far: f32,
        pub padding0: f32,
        pub padding1: f32,
        pub padding2: f32,
    }
}

crate::gpu_struct! {
    pub struct BoxesPush {
        pub capacity: u32,
        pub groups: u32,
        pub blocks: u32,
        pub boxes: u32,
    }
}

pub struct Boxes {
    kernel: Kernel,
    bindings: Bindings,
    capacity: u32,
}

impl Boxes {
    pub fn new(device: &Device, capacity: u32) -> Result<Self, GpuError> {
        let mut boxes = Boxes { kernel: Kernel::new(device, "beams/boxes", "")?, bindings: Bindings::new(), capacity };
        let bytes = u64::from(boxes.blocks() + boxes.groups()) * size_of::<BeamBox>() as u64;
        boxes.bindings = Bindings::new().buffer("BeamBoxes", &Buffer::new(device, "beam boxes", bytes)?);
        Ok(boxes)
    }

    pub fn blocks(&self) -> u32 {
        self.capacity.div_ceil(BLOCK_BEAMS)
    }

    pub fn groups(&self) -> u32 {
        self.blocks().div_ceil(GROUP_BLOCKS)
    }

    pub fn bindings(&self) -> &Bindings {
        &self.bindings
    }

    pub fn record(&self, recorder: &mut Recorder, bindings: &[&Bindings]) -> Result<(), GpuError> {
        for (groups, boxes) in [(0, self.blocks()), (1, self.groups())] {
            let push = BoxesPush { capacity: self.capacity, groups, blocks: self.blocks(), boxes };
            recorder.pass("beams/boxes")?.dispatch(&self.kernel, bindings, &push, boxes)?;
        }
        Ok(())
    }
}
