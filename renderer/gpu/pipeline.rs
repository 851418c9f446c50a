//! What compute and raster pipelines have in common: modules, layouts, and the place where the pipeline in use is kept.

use std::sync::Arc;
#[cfg(feature = "hot-reload")]
use std::sync::{Mutex, PoisonError};

use ash::vk;

use super::error::Call;
use super::reflect::{Interface, Slot, SlotKind};
use super::{Device, GpuError};

/// Push constants and descriptor sets that every Vulkan device offers.
const PORTABLE_PUSH_CONSTANTS: u32 = 128;
const PORTABLE_SETS: u32 = 4;

/// A pipeline with its layout. What records commands with it holds it until they have run. It does not keep its device
/// open, so that a device can own pipelines; whatever else owns one keeps the device too.
pub(crate) struct Pipeline {
    pub(crate) raw: vk::Pipeline,
    pub(crate) layout: Arc<PipelineLayout>,
    device: ash::Device,
}

impl Pipeline {
    /// Takes `raw` over, which `device` made with `layout`.
    pub(crate) fn new(device: &Device, raw: vk::Pipeline, layout: &Arc<PipelineLayout>, name: &str) -> Self {
        device.set_name(raw, name);
        Pipeline { raw, layout: layout.clone(), device: device.raw.clone() }
    }
}

impl Drop for Pipeline {
    fn drop(&mut self) {
        // SAFETY: submissions are waited for, and a recorder holds its pipelines until then; the device is still open.
        unsafe { self.device.destroy_pipeline(self.raw, None) };
    }
}

/// The pipeline in use.
#[cfg(not(feature = "hot-reload"))]
pub(crate) struct PipelineSlot(Arc<Pipeline>);

#[cfg(not(feature = "hot-reload"))]
impl PipelineSlot {
    pub(crate) fn new(pipeline: Pipeline) -> Self {
        PipelineSlot(Arc::new(pipeline))
    }

    pub(crate) fn get(&self) -> Arc<Pipeline> {
        self.0.clone()
    }
}

/// The pipeline in use, which can be replaced at any time: commands recorded before run with the one they hold.
#[cfg(feature = "hot-reload")]
pub(crate) struct PipelineSlot(Mutex<Arc<Pipeline>>);

#[cfg(feature = "hot-reload")]
impl PipelineSlot {
    pub(crate) fn new(pipeline: Pipeline) -> Self {
        PipelineSlot(Mutex::new(Arc::new(pipeline)))
    }

    pub(crate) fn get(&self) -> Arc<Pipeline> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub(crate) fn replace(&self, pipeline: Pipeline) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Arc::new(pipeline);
    }
}

pub(crate) fn module_words(name: &str, stage: &str, variant: &str) -> Result<Vec<u32>, GpuError> {
    nephroid_kernels::find(name, stage, variant).map(|k| k.words()).ok_or_else(|| GpuError::Kernel {
        kernel: name.to_string(),
        reason: format!("there is no such kernel for stage \"{stage}\" and variant \"{variant}\""),
    })
}

/// A shader module, needed only while a pipeline is made.
pub(crate) struct Module {
    pub(crate) raw: vk::ShaderModule,
    device: Device,
}

impl Module {
    pub(crate) fn new(device: &Device, words: &[u32]) -> Result<Self, GpuError> {
        let info = vk::ShaderModuleCreateInfo::default().code(words);
        // SAFETY: the words were compiled for Vulkan 1.2.
        let raw = unsafe { device.raw.create_shader_module(&info, None) }.call("vkCreateShaderModule")?;
        Ok(Module { raw, device: device.clone() })
    }
}

impl Drop for Module {
    fn drop(&mut self) {
        // SAFETY: pipelines do not need their modules once they are made.
        unsafe { self.device.raw.destroy_shader_module(self.raw, None) };
    }
}

/// A pipeline layout with its descriptor set layouts.
pub(crate) struct PipelineLayout {
    pub(crate) raw: vk::PipelineLayout,
    pub(crate) sets: Vec<vk::DescriptorSetLayout>,
    pub(crate) stages: vk::ShaderStageFlags,
    /// Slots of all stages, without repetition.
    pub(crate) slots: Vec<Slot>,
    pub(crate) push_constants: u32,
    device: ash::Device,
}

impl PipelineLayout {
    pub(crate) fn new(
        device: &Device,
        name: &str,
        interfaces: &[&Interface],
        stages: vk::ShaderStageFlags,
    ) -> Result<Self, GpuError> {
        let mut slots: Vec<_> = interfaces.iter().flat_map(|i| i.slots.clone()).collect();
        slots.sort_by_key(|slot| (slot.set, slot.binding));
        slots.dedup();
        let push_constants = interfaces.iter().map(|i| i.push_constants).max().unwrap_or(0);
        let set_count = slots.iter().map(|slot| slot.set + 1).max().unwrap_or(0);
        if push_constants > PORTABLE_PUSH_CONSTANTS || set_count > PORTABLE_SETS {
            return Err(GpuError::Kernel {
                kernel: name.to_string(),
                reason: format!(
                    "it wants {push_constants} bytes of push constants and {set_count} descriptor sets; the portable \
                     core has {PORTABLE_PUSH_CONSTANTS} and {PORTABLE_SETS}"
                ),
            });
        }
        let mut layout = PipelineLayout {
            raw: vk::PipelineLayout::null(),
            sets: Vec::new(),
            stages,
            slots,
            push_constants,
            device: device.raw.clone(),
        };
        for set in 0..set_count {
            let bindings: Vec<_> = layout
                .slots
                .iter()
                .filter(|slot| slot.set == set)
                .map(|slot| {
                    vk::DescriptorSetLayoutBinding::default()
                        .binding(slot.binding)
                        .descriptor_type(descriptor_type(slot.kind))
                        .descriptor_count(1)
                        .stage_flags(stages)
                })
                .collect();
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            // SAFETY: bindings are distinct, since slots were made unique.
            let raw =
                unsafe { device.raw.create_descriptor_set_layout(&info, None) }.call("vkCreateDescriptorSetLayout")?;
            layout.sets.push(raw);
        }
        let ranges = [vk::PushConstantRange::default().stage_flags(stages).size(push_constants)];
        let ranges = if push_constants > 0 { &ranges[..] } else { &[] };
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&layout.sets).push_constant_ranges(ranges);
        // SAFETY: the set layouts were just made by this device.
        layout.raw = unsafe { device.raw.create_pipeline_layout(&info, None) }.call("vkCreatePipelineLayout")?;
        Ok(layout)
    }
}

impl Drop for PipelineLayout {
    fn drop(&mut self) {
        // SAFETY: the pipeline that uses the layout is gone, or was never made.
        unsafe {
            self.device.destroy_pipeline_layout(self.raw, None);
            for &set in &self.sets {
                self.device.destroy_descriptor_set_layout(set, None);
            }
        }
    }
}

pub(crate) fn descriptor_type(kind: SlotKind) -> vk::DescriptorType {
    match kind {
        SlotKind::StorageBuffer => vk::DescriptorType::STORAGE_BUFFER,
        SlotKind::StorageImage => vk::DescriptorType::STORAGE_IMAGE,
        SlotKind::AccelerationStructure => vk::DescriptorType::ACCELERATION_STRUCTURE_KHR,
    }
}
