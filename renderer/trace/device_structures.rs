//! Vulkan acceleration structures: one a mesh, and one over the instances.

use ash::vk;
use gpu_allocator::MemoryLocation;

use super::AccelerationStructure;
use crate::gpu::{Bindings, Buffer, Call, Device, GpuError, Pass, PassTime, Recorder};
use crate::gpu_scene::{GpuScene, MeshRange, Vertex, records};
use crate::scene::MeshId;

/// The largest `minAccelerationStructureScratchOffsetAlignment` that the specification allows.
const SCRATCH_ALIGNMENT: u64 = 256;

/// An instance's bits that are left to `TRIANGLE_FACING_CULL_DISABLE`.
const CULL_DISABLE: u32 = 1 << 24;

/// How ray queries follow a mesh whose vertices have moved. Either way the structure stays where it is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Following {
    /// The structure is built anew. It is as fast to trace as any, and its content cannot depend on earlier frames.
    #[default]
    Rebuild,
    /// The driver fits the structure that was built first, for meshes that the scene's animation moves; where it keeps
    /// the topology, rays get slower the farther vertices move.
    Update,
}

/// Structures of both levels.
pub(super) struct DeviceStructures {
    /// One a mesh; `None` for a mesh without triangles.
    bottom: Vec<Option<Level>>,
    top: Level,
    /// What `top` is built from.
    instances: Buffer,
}

/// One structure, in memory that it keeps.
struct Level {
    structure: AccelerationStructure,
    ty: vk::AccelerationStructureTypeKHR,
    /// Whether it can be updated rather than built anew.
    updates: bool,
    primitives: u32,
    scratch_size: vk::DeviceSize,
    /// Kept by structures that have been built more than once.
    scratch: Option<Buffer>,
}

impl DeviceStructures {
    /// `moving`: the meshes whose vertices will move.
    pub(super) fn build(
        device: &Device,
        scene: &GpuScene,
        moving: &[MeshId],
        following: Following,
    ) -> Result<Self, GpuError> {
        let bottom = (0..scene.meshes.len()).map(|mesh| {
            let updates = following == Following::Update && moving.contains(&mesh);
            build_mesh(device, scene, &scene.meshes[mesh], updates)
        });
        let bottom = bottom.collect::<Result<Vec<_>, _>>()?;
        let (top, instances) = build_top(device, &bottom, scene)?;
        Ok(DeviceStructures { bottom, top, instances })
    }

    /// What kernels are bound to.
    pub(super) fn bindings(&self) -> Bindings {
        Bindings::new().structure("top_level", &self.top.structure)
    }

    /// Has the moved meshes' structures follow their vertices, and builds the one over the instances again, which are as
    /// many as ever and of the same meshes.
    pub(super) fn update(
        &mut self,
        device: &Device,
        scene: &GpuScene,
        moved: &[MeshId],
    ) -> Result<Vec<PassTime>, GpuError> {
        let mut recorder = Recorder::new(device)?;
        for &mesh in moved {
            let (Some(range), Some(Some(level))) = (scene.meshes.get(mesh), self.bottom.get_mut(mesh)) else {
                continue;
            };
            level.keep_scratch(device)?;
            let mut pass = recorder.pass(if level.updates { "trace/refit" } else { "trace/build" })?;
            level.record(&mut pass, triangles(scene, range), level.updates);
            pass.hold(&scene.vertices);
            pass.hold(&scene.indices);
        }
        // Their structures have stayed where they are.
        let (packed, _) = pack_instances(&self.bottom, scene);
        self.instances.upload(bytemuck::cast_slice(&packed))?;
        self.top.keep_scratch(device)?;
        let mut pass = recorder.pass("trace/top")?;
        self.top.record(&mut pass, instances(&self.instances), false);
        pass.hold(&self.instances);
        drop(pass);
        recorder.submit()
    }

    /// Bytes.
    pub(super) fn memory(&self) -> u64 {
        self.bottom.iter().flatten().chain([&self.top]).map(Level::memory).sum()
    }
}

fn build_mesh(device: &Device, scene: &GpuScene, range: &MeshRange, updates: bool) -> Result<Option<Level>, GpuError> {
    if range.triangles == 0 {
        return Ok(None);
    }
    let inputs = [scene.vertices.clone(), scene.indices.clone()];
    let level = vk::AccelerationStructureTypeKHR::BOTTOM_LEVEL;
    Level::build(device, level, triangles(scene, range), range.triangles, updates, &inputs).map(Some)
}

fn triangles(scene: &GpuScene, range: &MeshRange) -> vk::AccelerationStructureGeometryKHR<'static> {
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
    vk::AccelerationStructureGeometryKHR::default()
        .geometry_type(vk::GeometryTypeKHR::TRIANGLES)
        .geometry(vk::AccelerationStructureGeometryDataKHR { triangles })
        .flags(vk::GeometryFlagsKHR::OPAQUE)
}

fn build_top(device: &Device, bottom: &[Option<Level>], scene: &GpuScene) -> Result<(Level, Buffer), GpuError> {
    let (packed, parts) = pack_instances(bottom, scene);
    let usage = vk::BufferUsageFlags::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR
        | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;
    let buffer = Buffer::from_slice_with_usage(device, "trace instances", &packed, usage)?;
    let level = vk::AccelerationStructureTypeKHR::TOP_LEVEL;
    let inputs = [buffer.clone()];
    let mut top = Level::build(device, level, instances(&buffer), packed.len() as u32, false, &inputs)?;
    top.structure.keep(parts);
    Ok((top, buffer))
}

fn instances(buffer: &Buffer) -> vk::AccelerationStructureGeometryKHR<'static> {
    let instances = vk::AccelerationStructureGeometryInstancesDataKHR::default()
        .data(vk::DeviceOrHostAddressConstKHR { device_address: buffer.address() });
    vk::AccelerationStructureGeometryKHR::default()
        .geometry_type(vk::GeometryTypeKHR::INSTANCES)
        .geometry(vk::AccelerationStructureGeometryDataKHR { instances })
}

/// The instances of meshes that have triangles, and those meshes' structures.
fn pack_instances(bottom: &[Option<Level>], scene: &GpuScene) -> (Vec<[u32; 16]>, Vec<AccelerationStructure>) {
    let mut packed = Vec::new();
    let mut parts = Vec::new();
    for (index, instance) in scene.instances.iter().enumerate() {
        // A mesh without triangles starts where the next one does.
        let is_of = |mesh: &MeshRange| mesh.first_index == instance.first_index && mesh.triangles == instance.triangles;
        let mesh = scene.meshes.iter().position(is_of);
        if let Some(level) = mesh.and_then(|mesh| bottom.get(mesh)).and_then(Option::as_ref) {
            packed.push(pack(instance, index as u32, level.structure.address()));
            parts.push(level.structure.clone());
        }
    }
    (packed, parts)
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

impl Level {
    /// Builds a structure from `geometry`, whose memory is in `inputs`, and waits.
    fn build(
        device: &Device,
        ty: vk::AccelerationStructureTypeKHR,
        geometry: vk::AccelerationStructureGeometryKHR<'static>,
        primitives: u32,
        updates: bool,
        inputs: &[Buffer],
    ) -> Result<Self, GpuError> {
        let functions = device.structures.as_ref().ok_or_else(|| GpuError::Unsuitable {
            device: device.info.name.clone(),
            reason: "it has no acceleration structures".to_string(),
        })?;
        let geometries = [geometry];
        let info = info(ty, &geometries, updates);
        let mut sizes = vk::AccelerationStructureBuildSizesInfoKHR::default();
        let kind = vk::AccelerationStructureBuildTypeKHR::DEVICE;
        // SAFETY: one geometry and one count.
        unsafe { functions.get_acceleration_structure_build_sizes(kind, &info, &[primitives], &mut sizes) };

        let storage =
            vk::BufferUsageFlags::ACCELERATION_STRUCTURE_STORAGE_KHR | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;
        let size = sizes.acceleration_structure_size;
        let memory = Buffer::with_usage(device, "trace structure", size, storage, MemoryLocation::GpuOnly)?;
        let create = vk::AccelerationStructureCreateInfoKHR::default().buffer(memory.raw).size(size).ty(ty);
        // SAFETY: the buffer is as large as the device asked and starts at offset 0.
        let raw = unsafe { functions.create_acceleration_structure(&create, None) }
            .call("vkCreateAccelerationStructureKHR")?;
        let structure = AccelerationStructure::new(device, raw, memory);
        let scratch_size = sizes.build_scratch_size.max(sizes.update_scratch_size);
        let mut level = Level { structure, ty, updates, primitives, scratch_size, scratch: None };
        level.keep_scratch(device)?;
        let mut recorder = Recorder::new(device)?;
        {
            let mut pass = recorder.pass("trace/build")?;
            level.record(&mut pass, geometry, false);
            inputs.iter().for_each(|input| pass.hold(input));
        }
        recorder.submit()?;
        level.scratch = None;
        Ok(level)
    }

    fn keep_scratch(&mut self, device: &Device) -> Result<(), GpuError> {
        if self.scratch.is_none() {
            let usage = vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;
            let size = self.scratch_size + SCRATCH_ALIGNMENT;
            self.scratch = Some(Buffer::with_usage(device, "trace scratch", size, usage, MemoryLocation::GpuOnly)?);
        }
        Ok(())
    }

    /// Builds or updates the structure in its memory, from as many primitives as ever. The caller holds what `geometry`
    /// refers to.
    fn record(&self, pass: &mut Pass<'_>, geometry: vk::AccelerationStructureGeometryKHR<'static>, update: bool) {
        let device = pass.device().clone();
        let (Some(functions), Some(scratch)) = (device.structures.as_ref(), self.scratch.as_ref()) else { return };
        let geometries = [geometry];
        let mut info = info(self.ty, &geometries, self.updates);
        info.dst_acceleration_structure = self.structure.raw();
        if update {
            info.mode = vk::BuildAccelerationStructureModeKHR::UPDATE;
            info.src_acceleration_structure = self.structure.raw();
        }
        info.scratch_data.device_address = scratch.address().next_multiple_of(SCRATCH_ALIGNMENT);
        let range = [vk::AccelerationStructureBuildRangeInfoKHR::default().primitive_count(self.primitives)];
        pass.hold(&self.structure);
        pass.hold(scratch);
        // SAFETY: structure and scratch are of the sizes asked for with this geometry, flags and count; they are held, as
        // are the inputs, until the build is done; the pass began with a barrier after whatever wrote the inputs or used
        // the structure. Only structures made for it are updated, from themselves.
        unsafe { functions.cmd_build_acceleration_structures(pass.commands(), &[info], &[&range]) };
    }

    /// Bytes.
    fn memory(&self) -> u64 {
        self.structure.memory() + self.scratch.as_ref().map_or(0, |scratch| scratch.size())
    }
}

fn info<'a>(
    ty: vk::AccelerationStructureTypeKHR,
    geometries: &'a [vk::AccelerationStructureGeometryKHR<'static>],
    updates: bool,
) -> vk::AccelerationStructureBuildGeometryInfoKHR<'a> {
    let mut flags = vk::BuildAccelerationStructureFlagsKHR::PREFER_FAST_TRACE;
    if updates {
        flags |= vk::BuildAccelerationStructureFlagsKHR::ALLOW_UPDATE;
    }
    vk::AccelerationStructureBuildGeometryInfoKHR::default()
        .ty(ty)
        .flags(flags)
        .mode(vk::BuildAccelerationStructureModeKHR::BUILD)
        .geometries(geometries)
}
