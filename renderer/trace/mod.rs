//! One tracing interface with several back-ends.
//!
//! A kernel includes `trace/interface.glsl` and exists once per [`Backend`]; a [`Tracer`] holds what the kernels of its
//! back-end are bound to. All back-ends answer with the same ids: the scene's instance, and the triangle of its mesh.

mod binary;
mod choose;
mod device_structures;
mod error;
mod probe;
mod refit;
mod smoke;
mod structure;
mod top;
mod tracer;
mod tree;
mod trees;
mod wide;

pub use choose::{Choice, MARGIN, Measurement, TraceChoice, choose};
pub use device_structures::Following;
pub use error::TraceError;
pub use probe::{Probe, ProbeHit, Ray};
pub use structure::AccelerationStructure;
pub use tracer::{Backend, Tracer};

pub(crate) use smoke::smoke_test;

use crate::gpu::{Capability, Device, GpuStruct, Layout};

/// Instance of a hit that is none.
pub const NO_INSTANCE: u32 = u32::MAX;

/// Every struct of the tracer that kernels see.
pub const LAYOUTS: &[Layout] = &[
    Ray::LAYOUT,
    ProbeHit::LAYOUT,
    probe::ProbePush::LAYOUT,
    tree::LeafTriangle::LAYOUT,
    wide::WideNode::LAYOUT,
    binary::BinaryNode::LAYOUT,
    top::TopNode::LAYOUT,
    refit::RefitTrianglesPush::LAYOUT,
    refit::RefitPush::LAYOUT,
    refit::RefitBox::LAYOUT,
];

/// Usage flags that vertex and index buffers need for acceleration structures to be built from them.
pub(crate) fn geometry_usage(device: &Device) -> ash::vk::BufferUsageFlags {
    if device.has(Capability::RayQuery) {
        ash::vk::BufferUsageFlags::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR
            | ash::vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS
    } else {
        ash::vk::BufferUsageFlags::empty()
    }
}
