//! Descriptor sets for one recording, filled by the names that the kernels declare.

use ash::vk;

use super::error::Call;
use super::pipeline::{PipelineLayout, descriptor_type};
use super::reflect::SlotKind;
use super::{Binding, Bindings, Device, GpuError};

/// Sets of one pool; another is made when it is used up.
const SETS_PER_POOL: u32 = 128;

/// Pools that live as long as a recording.
pub(crate) struct DescriptorPools {
    device: Device,
    pools: Vec<vk::DescriptorPool>,
    left: u32,
}

impl DescriptorPools {
    pub(crate) fn new(device: &Device) -> Self {
        DescriptorPools { device: device.clone(), pools: Vec::new(), left: 0 }
    }

    /// The sets that `layout` wants, filled from the first of `bindings` that knows each slot's name.
    pub(crate) fn sets(
        &mut self,
        kernel: &str,
        layout: &PipelineLayout,
        bindings: &[&Bindings],
        push_bytes: usize,
    ) -> Result<Vec<vk::DescriptorSet>, GpuError> {
        if push_bytes != layout.push_constants as usize {
            return Err(GpuError::Kernel {
                kernel: kernel.to_string(),
                reason: format!("it takes {} bytes of push constants, and {push_bytes} came", layout.push_constants),
            });
        }
        if layout.sets.is_empty() {
            return Ok(Vec::new());
        }
        let sets = self.allocate(&layout.sets)?;
        for slot in &layout.slots {
            let found = bindings.iter().find_map(|b| b.get(&slot.name));
            let missing = || GpuError::Kernel {
                kernel: kernel.to_string(),
                reason: format!("nothing is bound to its {:?} \"{}\"", slot.kind, slot.name),
            };
            let write = vk::WriteDescriptorSet::default()
                .dst_set(sets[slot.set as usize])
                .dst_binding(slot.binding)
                .descriptor_type(descriptor_type(slot.kind));
            match (found, slot.kind) {
                (Some(Binding::Buffer(buffer)), SlotKind::StorageBuffer) => {
                    let info = [vk::DescriptorBufferInfo { buffer: buffer.raw, offset: 0, range: vk::WHOLE_SIZE }];
                    // SAFETY: the set is new, and the buffer is held by the recording.
                    unsafe { self.device.raw.update_descriptor_sets(&[write.buffer_info(&info)], &[]) };
                }
                (Some(Binding::Range(buffer, offset, bytes)), SlotKind::StorageBuffer) => {
                    let info = [vk::DescriptorBufferInfo { buffer: buffer.raw, offset: *offset, range: *bytes }];
                    // SAFETY: as above; the range was cut to the buffer.
                    unsafe { self.device.raw.update_descriptor_sets(&[write.buffer_info(&info)], &[]) };
                }
                (Some(Binding::Image(image)), SlotKind::StorageImage) => {
                    let info = [vk::DescriptorImageInfo {
                        image_view: image.view,
                        image_layout: vk::ImageLayout::GENERAL,
                        ..Default::default()
                    }];
                    // SAFETY: as above; storage images are in GENERAL since they were made.
                    unsafe { self.device.raw.update_descriptor_sets(&[write.image_info(&info)], &[]) };
                }
                (Some(Binding::AccelerationStructure(structure)), SlotKind::AccelerationStructure) => {
                    let structures = [structure.raw()];
                    let mut info =
                        vk::WriteDescriptorSetAccelerationStructureKHR::default().acceleration_structures(&structures);
                    let write = write.descriptor_count(1).push_next(&mut info);
                    // SAFETY: as above; the structure is held by the recording.
                    unsafe { self.device.raw.update_descriptor_sets(&[write], &[]) };
                }
                _ => return Err(missing()),
            }
        }
        Ok(sets)
    }

    fn allocate(&mut self, layouts: &[vk::DescriptorSetLayout]) -> Result<Vec<vk::DescriptorSet>, GpuError> {
        let count = layouts.len() as u32;
        if self.left < count {
            self.grow()?;
        }
        let pool = self.pools.last().copied().unwrap_or_default();
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(layouts);
        // SAFETY: the pool has room, since it is counted.
        let sets = unsafe { self.device.raw.allocate_descriptor_sets(&info) }.call("vkAllocateDescriptorSets")?;
        self.left -= count;
        Ok(sets)
    }

    fn grow(&mut self) -> Result<(), GpuError> {
        let size = |ty, descriptor_count| vk::DescriptorPoolSize { ty, descriptor_count };
        let mut sizes = vec![
            size(vk::DescriptorType::STORAGE_BUFFER, SETS_PER_POOL * 16),
            size(vk::DescriptorType::STORAGE_IMAGE, SETS_PER_POOL),
        ];
        if self.device.structures.is_some() {
            sizes.push(size(vk::DescriptorType::ACCELERATION_STRUCTURE_KHR, SETS_PER_POOL));
        }
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(SETS_PER_POOL).pool_sizes(&sizes);
        // SAFETY: no preconditions.
        let pool = unsafe { self.device.raw.create_descriptor_pool(&info, None) }.call("vkCreateDescriptorPool")?;
        self.pools.push(pool);
        self.left = SETS_PER_POOL;
        Ok(())
    }
}

impl Drop for DescriptorPools {
    fn drop(&mut self) {
        for &pool in &self.pools {
            // SAFETY: the recording that used the sets has run or was never submitted.
            unsafe { self.device.raw.destroy_descriptor_pool(pool, None) };
        }
    }
}
