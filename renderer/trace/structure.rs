//! A Vulkan acceleration structure and the memory under it.

use std::sync::Arc;

use ash::vk;

use crate::gpu::{Buffer, Device};

/// A built structure of either level. Clones share it.
#[derive(Clone)]
pub struct AccelerationStructure {
    inner: Arc<Inner>,
    /// What a structure over instances refers to.
    parts: Arc<[AccelerationStructure]>,
}

struct Inner {
    raw: vk::AccelerationStructureKHR,
    device: Device,
    // The structure lives in it.
    memory: Buffer,
}

impl AccelerationStructure {
    pub(crate) fn new(device: &Device, raw: vk::AccelerationStructureKHR, memory: Buffer) -> Self {
        let inner = Arc::new(Inner { raw, device: device.clone(), memory });
        AccelerationStructure { inner, parts: Arc::default() }
    }

    /// Ties the life of `parts` to this structure's.
    pub(super) fn keep(&mut self, parts: Vec<AccelerationStructure>) {
        self.parts = parts.into();
    }

    pub(crate) fn raw(&self) -> vk::AccelerationStructureKHR {
        self.inner.raw
    }

    /// Bytes.
    pub(super) fn memory(&self) -> u64 {
        self.inner.memory.size()
    }

    pub(super) fn address(&self) -> vk::DeviceAddress {
        let info = vk::AccelerationStructureDeviceAddressInfoKHR::default().acceleration_structure(self.inner.raw);
        // SAFETY: the structure was made by these functions.
        let address = |f: &ash::khr::acceleration_structure::Device| unsafe {
            f.get_acceleration_structure_device_address(&info)
        };
        self.inner.device.structures.as_ref().map(address).unwrap_or_default()
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
