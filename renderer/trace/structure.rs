//! A Vulkan acceleration structure and the memory under it.

use std::sync::Arc;

use ash::vk;

use crate::gpu::{Buffer, Device};

/// A built structure of either level. Clones share it.
#[derive(Clone)]
pub struct AccelerationStructure(Arc<Inner>);

struct Inner {
    raw: vk::AccelerationStructureKHR,
    device: Device,
    // The structure lives in it.
    _memory: Buffer,
}

impl AccelerationStructure {
    pub(crate) fn new(device: &Device, raw: vk::AccelerationStructureKHR, memory: Buffer) -> Self {
        AccelerationStructure(Arc::new(Inner { raw, device: device.clone(), _memory: memory }))
    }

    pub(crate) fn raw(&self) -> vk::AccelerationStructureKHR {
        self.0.raw
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        if let Some(functions) = &self.device.structures {
            // SAFETY: submissions are waited for, so nothing uses the structure.
            unsafe { functions.destroy_acceleration_structure(self.raw, None) };
        }
    }
}
