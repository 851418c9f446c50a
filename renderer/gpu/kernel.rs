//! Compute pipelines made from the kernel table, and the resources bound to them by name.

use std::sync::Arc;

use ash::vk;

use super::error::Call;
use super::reflect::{Interface, SlotKind, reflect};
use super::{Buffer, Device, GpuError};
use crate::trace::AccelerationStructure;

/// Push constants and descriptor sets that every Vulkan device offers.
const PORTABLE_PUSH_CONSTANTS: u32 = 128;
const PORTABLE_SETS: u32 = 4;

/// Something to bind.
#[derive(Clone)]
pub enum Binding {
    Buffer(Buffer),
    AccelerationStructure(AccelerationStructure),
}

/// Resources by the name of the block that a kernel declares.
#[derive(Clone, Default)]
pub struct Bindings(Vec<(&'static str, Binding)>);

impl Bindings {
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a buffer under the block's name.
    pub fn buffer(mut self, block: &'static str, buffer: &Buffer) -> Self {
        self.0.push((block, Binding::Buffer(buffer.clone())));
        self
    }

    /// Adds an acceleration structure under the variable's name.
    pub fn structure(mut self, name: &'static str, structure: &AccelerationStructure) -> Self {
        self.0.push((name, Binding::AccelerationStructure(structure.clone())));
        self
    }

    /// Adds everything that `other` has.
    pub fn and(mut self, other: &Bindings) -> Self {
        self.0.extend(other.0.iter().cloned());
        self
    }

    /// What is bound under a block's or variable's name.
    pub fn get(&self, name: &str) -> Option<&Binding> {
        self.0.iter().find(|(n, _)| *n == name).map(|(_, binding)| binding)
    }
}

/// A compute pipeline. Clones share it.
#[derive(Clone)]
pub struct Kernel(Arc<KernelInner>);

pub struct KernelInner {
    pub name: String,
    pub interface: Interface,
    pub(crate) pipeline: vk::Pipeline,
    pub(crate) layout: PipelineLayout,
    device: Device,
}

impl std::ops::Deref for Kernel {
    type Target = KernelInner;
    fn deref(&self) -> &KernelInner {
        &self.0
    }
}

impl Kernel {
    /// The kernel of that name; `variant` is the tracing back-end's, or empty for a kernel that traces no rays.
    pub fn new(device: &Device, name: &str, variant: &str) -> Result<Kernel, GpuError> {
        let words = module_words(name, "comp", variant)?;
        Self::from_words(device, name, &words)
    }

    /// A kernel from SPIR-V words.
    pub fn from_words(device: &Device, name: &str, words: &[u32]) -> Result<Kernel, GpuError> {
        let error = |reason| GpuError::Kernel { kernel: name.to_string(), reason };
        let interface = reflect(words).map_err(error)?;
        let invocations: u32 = interface.workgroup.iter().product();
        let allowed = device.info.limits.workgroup_invocations;
        if invocations > allowed {
            return Err(error(format!("its workgroup has {invocations} invocations; the device allows {allowed}")));
        }
        let layout = PipelineLayout::new(device, name, &[&interface], vk::ShaderStageFlags::COMPUTE)?;
        let module = Module::new(device, words)?;
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module.raw)
            .name(c"main");
        let info = vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout.raw);
        // SAFETY: the module is valid SPIR-V whose interface the layout was made from.
        let pipelines = unsafe { device.raw.create_compute_pipelines(vk::PipelineCache::null(), &[info], None) };
        let pipeline = pipelines.map_err(|(_, result)| result).call("vkCreateComputePipelines")?[0];
        device.set_name(pipeline, name);
        Ok(Kernel(Arc::new(KernelInner {
            name: name.to_string(),
            interface,
            pipeline,
            layout,
            device: device.clone(),
        })))
    }
}

impl Drop for KernelInner {
    fn drop(&mut self) {
        // SAFETY: submissions are waited for, and a recorder holds its kernels until then.
        unsafe { self.device.raw.destroy_pipeline(self.pipeline, None) };
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
    pub(crate) slots: Vec<super::reflect::Slot>,
    pub(crate) push_constants: u32,
    device: Device,
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
            device: device.clone(),
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
            self.device.raw.destroy_pipeline_layout(self.raw, None);
            for &set in &self.sets {
                self.device.raw.destroy_descriptor_set_layout(set, None);
            }
        }
    }
}

pub(crate) fn descriptor_type(kind: SlotKind) -> vk::DescriptorType {
    match kind {
        SlotKind::StorageBuffer => vk::DescriptorType::STORAGE_BUFFER,
        SlotKind::AccelerationStructure => vk::DescriptorType::ACCELERATION_STRUCTURE_KHR,
    }
}
