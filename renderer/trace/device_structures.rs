//! Vulkan acceleration structures: one a mesh, and one over the instances.

use ash::vk;
use gpu_allocator::MemoryLocation;

use super::AccelerationStructure;
use crate::gpu::{Buffer, Call, Device, GpuError, Recorder};
use crate::gpu_scene::{GpuScene, MeshRange, Vertex, records};

/// The largest `minAccelerationStructureScratchOffsetAlignment` that the specification allows.
const SCRATCH_ALIGNMENT: u64 = 256;

/// An instance's bits that are left to `TRIANGLE_FACING_CULL_DISABLE`.
const CULL_DISABLE: u32 = 1 << 24;

/// Structures of both levels.
pub(super) struct DeviceStructures {
    /// One a mesh; `None` for a mesh without triangles.
    bottom: Vec<Option<AccelerationStructure>>,
    pub(super) top: AccelerationStructure,
}

impl DeviceStructures {
    pub(super) fn build(device: &Device, scene: &GpuScene) -> Result<Self, GpuError> {
        let bottom =
            scene.meshes.iter().map(|range| build_mesh(device, scene, range)).collect::<Result<Vec<_>, _>>()?;
        let top = build_top(device, &bottom, scene)?;
        Ok(DeviceStructures { bottom, top })
    }

    /// Builds the moved meshes' structures anew, and the one over the instances.
    pub(super) fn update(&mut self, device: &Device, scene: &GpuScene, moved: &[usize]) -> Result<(), GpuError> {
        for &mesh in moved {
            if let (Some(range), Some(structure)) = (scene.meshes.get(mesh), self.bottom.get_mut(mesh)) {
                *structure = build_mesh(device, scene, range)?;
            }
        }
        self.top = build_top(device, &self.bottom, scene)?;
        Ok(())
    }

    /// Bytes.
    pub(super) fn memory(&self) -> u64 {
        self.bottom.iter().flatten().map(AccelerationStructure::memory).sum::<u64>() + self.top.memory()
    }
}

fn build_mesh(device: &Device, scene: &GpuScene, range: &MeshRange) -> Result<Option<AccelerationStructure>, GpuError> {
    if range.triangles == 0 {
        return Ok(None);
    }
    let stride = size_of::<Vertex>() as u64;
    let address =
        |buffer: &Buffer, offset: u64| vk::DeviceOrHostAddressConstKHR { device_address: buffer.address() + offset };
    let triangles = vk::AccelerationStructureGeometryTrianglesDataKHR::default()
        .vertex_format(vk::Format::R32G32B32_SFLOAT)
        .vertex_data(address(&scene.vertices, u64::from(range.first_vertex) * stride))
        .vertex_stride(stride)
        .max_vertex(range.vertices.saturating_sub(1))
        .index_type(vk::IndexType::UINT32)
        .index_data(address(&scene.indices, u64::from(range.first_index) * 4));
    let geometry = vk::AccelerationStructureGeometryKHR::default()
        .geometry_type(vk::GeometryTypeKHR::TRIANGLES)
        .geometry(vk::AccelerationStructureGeometryDataKHR { triangles })
        .flags(vk::GeometryFlagsKHR::OPAQUE);
    let inputs = [scene.vertices.clone(), scene.indices.clone()];
    let level = vk::AccelerationStructureTypeKHR::BOTTOM_LEVEL;
    build(device, level, geometry, range.triangles, &inputs).map(Some)
}

fn build_top(
    device: &Device,
    bottom: &[Option<AccelerationStructure>],
    scene: &GpuScene,
) -> Result<AccelerationStructure, GpuError> {
    let mut packed = Vec::new();
    let mut inputs = Vec::new();
    for (index, instance) in scene.instances.iter().enumerate() {
        // A mesh without triangles starts where the next one does.
        let is_of = |mesh: &MeshRange| mesh.first_index == instance.first_index && mesh.triangles == instance.triangles;
        let mesh = scene.meshes.iter().position(is_of);
        if let Some(structure) = mesh.and_then(|mesh| bottom.get(mesh)).and_then(Option::as_ref) {
            packed.push(pack(instance, index as u32, structure.address()));
            inputs.push(structure.clone());
        }
    }
    let usage = vk::BufferUsageFlags::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR
        | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;
    let buffer = Buffer::from_slice_with_usage(device, "trace instances", &packed, usage)?;
    let instances = vk::AccelerationStructureGeometryInstancesDataKHR::default()
        .data(vk::DeviceOrHostAddressConstKHR { device_address: buffer.address() });
    let geometry = vk::AccelerationStructureGeometryKHR::default()
        .geometry_type(vk::GeometryTypeKHR::INSTANCES)
        .geometry(vk::AccelerationStructureGeometryDataKHR { instances });
    let level = vk::AccelerationStructureTypeKHR::TOP_LEVEL;
    let mut top = build(device, level, geometry, packed.len() as u32, &[buffer])?;
    top.keep(inputs);
    Ok(top)
}

/// `VkAccelerationStructureInstanceKHR` in words.
fn pack(instance: &records::Instance, index: u32, structure: vk::DeviceAddress) -> [u32; 16] {
    let mut words = [0; 16];
    for (word, value) in words.iter_mut().zip(instance.to_world.iter().flatten()) {
        *word = value.to_bits();
    }
    words[12] = (index & 0x00ff_ffff) | instance.mask << 24;
    words[13] = CULL_DISABLE;
    words[14] = structure as u32;
    words[15] = (structure >> 32) as u32;
    words
}

fn build(
    device: &Device,
    level: vk::AccelerationStructureTypeKHR,
    geometry: vk::AccelerationStructureGeometryKHR<'_>,
    primitives: u32,
    inputs: &[Buffer],
) -> Result<AccelerationStructure, GpuError> {
    let functions = device.structures.as_ref().ok_or_else(|| GpuError::Unsuitable {
        device: device.info.name.clone(),
        reason: "it has no acceleration structures".to_string(),
    })?;
    let geometries = [geometry];
    let mut info = vk::AccelerationStructureBuildGeometryInfoKHR::default()
        .ty(level)
        .flags(vk::BuildAccelerationStructureFlagsKHR::PREFER_FAST_TRACE)
        .mode(vk::BuildAccelerationStructureModeKHR::BUILD)
        .geometries(&geometries);
    let mut sizes = vk::AccelerationStructureBuildSizesInfoKHR::default();
    let kind = vk::AccelerationStructureBuildTypeKHR::DEVICE;
    // SAFETY: one geometry and one count.
    unsafe { functions.get_acceleration_structure_build_sizes(kind, &info, &[primitives], &mut sizes) };

    let address = vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;
    let storage = vk::BufferUsageFlags::ACCELERATION_STRUCTURE_STORAGE_KHR | address;
    let size = sizes.acceleration_structure_size;
    let memory = Buffer::with_usage(device, "trace structure", size, storage, MemoryLocation::GpuOnly)?;
    let scratch_size = sizes.build_scratch_size + SCRATCH_ALIGNMENT;
    let scratch = Buffer::with_usage(device, "trace scratch", scratch_size, address, MemoryLocation::GpuOnly)?;
    let create = vk::AccelerationStructureCreateInfoKHR::default().buffer(memory.raw).size(size).ty(level);
    // SAFETY: the buffer is as large as the device asked and starts at offset 0.
    let raw =
        unsafe { functions.create_acceleration_structure(&create, None) }.call("vkCreateAccelerationStructureKHR")?;
    let structure = AccelerationStructure::new(device, raw, memory);

    info.dst_acceleration_structure = raw;
    info.scratch_data.device_address = scratch.address().next_multiple_of(SCRATCH_ALIGNMENT);
    let range = [vk::AccelerationStructureBuildRangeInfoKHR::default().primitive_count(primitives)];
    let mut recorder = Recorder::new(device)?;
    {
        let mut pass = recorder.pass("trace/build")?;
        pass.hold(&structure);
        pass.hold(&scratch);
        inputs.iter().for_each(|input| pass.hold(input));
        let commands = pass.commands();
        // SAFETY: structure, scratch and inputs are of the sizes asked for and held until the build is done; the pass
        // began with a barrier after whatever wrote the inputs.
        unsafe { functions.cmd_build_acceleration_structures(commands, &[info], &[&range]) };
    }
    recorder.submit()?;
    Ok(structure)
}
