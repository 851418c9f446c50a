//! Compute pipelines made from the kernel table, and the resources bound to them by name.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use ash::vk;

use super::error::Call;
use super::pipeline::{Module, Pipeline, PipelineLayout, PipelineSlot, module_words};
use super::reflect::{Interface, reflect};
#[cfg(feature = "hot-reload")]
use super::reload::{ModuleName, Reloadable};
use super::variant::{self, Parts, Variant};
use super::{Buffer, Device, GpuError, Image};
use crate::trace::AccelerationStructure;

/// Something to bind.
#[derive(Clone)]
pub enum Binding {
    Buffer(Buffer),
    /// Bytes of a buffer, from an offset on.
    Range(Buffer, u64, u64),
    Image(Image),
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

    /// Adds `bytes` of a buffer from byte `offset` on, a multiple of the device's `storage_offset_alignment`. Both are cut to
    /// the buffer.
    pub fn range(mut self, block: &'static str, buffer: &Buffer, offset: u64, bytes: u64) -> Self {
        let offset = offset.min(buffer.size().saturating_sub(4));
        let bytes = bytes.clamp(4, buffer.size() - offset);
        self.0.push((block, Binding::Range(buffer.clone(), offset, bytes)));
        self
    }

    /// Adds a storage image under the variable's name.
    pub fn image(mut self, name: &'static str, image: &Image) -> Self {
        self.0.push((name, Binding::Image(image.clone())));
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

/// A compute pipeline. Clones share it, and so do all kernels of one name and variant on a device.
#[derive(Clone)]
pub struct Kernel {
    inner: Arc<KernelInner>,
    // Keeps the pipeline's device open.
    _device: Device,
}

/// The kernels that a device has made, by name and variant; they live as long as it. SwiftShader takes 5 s for those of
/// `mnee`, which another renderer, or another technique and back, would have to wait for again.
#[derive(Default)]
pub(crate) struct MadeKernels(Mutex<HashMap<(String, Variant), Arc<KernelInner>>>);

impl MadeKernels {
    fn lock(&self) -> MutexGuard<'_, HashMap<(String, Variant), Arc<KernelInner>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Destroys them all; the device is about to be closed.
    pub(crate) fn clear(&self) {
        self.lock().clear();
    }
}

pub struct KernelInner {
    pub name: String,
    pub interface: Interface,
    pub(crate) layout: Arc<PipelineLayout>,
    pub(crate) pipeline: PipelineSlot,
    #[cfg(feature = "hot-reload")]
    module: ModuleName,
    #[cfg(feature = "hot-reload")]
    parts: Parts,
}

impl std::ops::Deref for Kernel {
    type Target = KernelInner;
    fn deref(&self) -> &KernelInner {
        &self.inner
    }
}

impl Kernel {
    /// The kernel of that name; `variant` is the tracer's, or "" for a kernel that traces no rays and serves any scene.
    pub fn new(device: &Device, name: &str, variant: impl Into<Variant>) -> Result<Kernel, GpuError> {
        let Variant { module, parts } = variant.into();
        let words = module_words(name, "comp", module)?;
        let variant = Variant { module, parts: parts.asked_by(&words) };
        let key = (name.to_string(), variant);
        let made = device.made.lock().get(&key).cloned();
        let inner = match made {
            Some(inner) => inner,
            // Not under the lock: others need not wait while this one compiles.
            None => {
                let inner = make(device, name, variant, &words)?;
                device.made.lock().entry(key).or_insert(inner).clone()
            }
        };
        Ok(Kernel { inner, _device: device.clone() })
    }

    /// As [`new`](Self::new), made anew whether the device has one or not, and shared with nobody.
    pub fn anew(device: &Device, name: &str, variant: impl Into<Variant>) -> Result<Kernel, GpuError> {
        let variant = variant.into();
        let words = module_words(name, "comp", variant.module)?;
        Ok(Kernel { inner: make(device, name, variant, &words)?, _device: device.clone() })
    }
}

fn make(device: &Device, name: &str, variant: Variant, words: &[u32]) -> Result<Arc<KernelInner>, GpuError> {
    let error = |reason| GpuError::Kernel { kernel: name.to_string(), reason };
    let interface = reflect(words).map_err(error)?;
    let invocations: u32 = interface.workgroup.iter().product();
    let allowed = device.info.limits.workgroup_invocations;
    if invocations > allowed {
        return Err(error(format!("its workgroup has {invocations} invocations; the device allows {allowed}")));
    }
    let layout = PipelineLayout::new(device, name, &[&interface], vk::ShaderStageFlags::COMPUTE)?;
    let layout = Arc::new(layout);
    let inner = Arc::new(KernelInner {
        name: name.to_string(),
        interface,
        pipeline: PipelineSlot::new(pipeline(device, name, &layout, variant.parts, words)?),
        layout,
        #[cfg(feature = "hot-reload")]
        module: ModuleName::new(name, "comp", variant.module),
        #[cfg(feature = "hot-reload")]
        parts: variant.parts,
    });
    #[cfg(feature = "hot-reload")]
    super::reload::register(device, inner.clone())?;
    Ok(inner)
}

fn pipeline(
    device: &Device,
    name: &str,
    layout: &Arc<PipelineLayout>,
    parts: Parts,
    words: &[u32],
) -> Result<Pipeline, GpuError> {
    let module = Module::new(device, words)?;
    let (entries, values) = (variant::entries(), parts.values());
    let constants = vk::SpecializationInfo::default().map_entries(&entries).data(bytemuck::bytes_of(&values));
    let stage = vk::PipelineShaderStageCreateInfo::default()
        .stage(vk::ShaderStageFlags::COMPUTE)
        .module(module.raw)
        .name(c"main")
        .specialization_info(&constants);
    let info = vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout.raw);
    // SAFETY: the module is valid SPIR-V whose interface the layout was made from, or has a part of that interface.
    let pipelines = unsafe { device.raw.create_compute_pipelines(vk::PipelineCache::null(), &[info], None) };
    let raw = pipelines.map_err(|(_, result)| result).call("vkCreateComputePipelines")?[0];
    Ok(Pipeline::new(device, raw, layout, name))
}

#[cfg(feature = "hot-reload")]
impl Reloadable for KernelInner {
    fn modules(&self) -> &[ModuleName] {
        std::slice::from_ref(&self.module)
    }

    fn reload(&self, device: &Device, modules: &[Vec<u32>]) -> Result<(), GpuError> {
        for words in modules {
            self.pipeline.replace(pipeline(device, &self.name, &self.layout, self.parts, words)?);
        }
        Ok(())
    }
}
