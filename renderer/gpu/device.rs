//! A device that has been opened: its queue, its memory, and the capabilities in use.

use std::mem::ManuallyDrop;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use ash::{ext, khr, vk};
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};

use super::capability::{Capabilities, Capability};
use super::kernel::MadeKernels;
use super::raster::MadeRasters;
use super::survey::{DeviceInfo, choose, survey};
use super::{GpuError, Instance, Quirks};
#[cfg(feature = "viewer")]
use super::{Surface, surface::WindowHandles};

/// How a device is to be opened.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DeviceRequest {
    /// Index or part of the name; the best device if `None`.
    pub device: Option<String>,
    /// Capabilities to do without, as if the device lacked them.
    pub disable: Capabilities,
    /// Run under the validation layers, synchronisation validation included.
    pub validation: bool,
}

/// A logical device with one queue. Clones share it.
#[derive(Clone)]
pub struct Device(Arc<DeviceInner>);

impl std::ops::Deref for Device {
    type Target = DeviceInner;
    fn deref(&self) -> &DeviceInner {
        &self.0
    }
}

pub struct DeviceInner {
    pub info: DeviceInfo,
    /// What is used: offered by the driver, found to work, and not disabled.
    pub capabilities: Capabilities,
    /// Workarounds for this driver.
    pub quirks: Quirks,
    /// What the user should know, such as a capability that was claimed and did not work.
    pub(crate) warnings: Mutex<Vec<String>>,
    pub(crate) raw: ash::Device,
    pub(crate) queue: Mutex<vk::Queue>,
    pub(crate) queue_family: u32,
    /// Shared with what draws the window.
    pub(crate) allocator: ManuallyDrop<Arc<Mutex<Allocator>>>,
    pub(crate) labels: Option<ext::debug_utils::Device>,
    pub(crate) structures: Option<khr::acceleration_structure::Device>,
    pub(crate) rendering: Option<khr::dynamic_rendering::Device>,
    /// The kernels that live on this device, for hot reload.
    #[cfg(feature = "hot-reload")]
    pub(crate) kernels: super::reload::LiveKernels,
    pub(crate) made: MadeKernels,
    pub(crate) made_rasters: MadeRasters,
    held: AtomicU64,
    peak: AtomicU64,
    pub(super) instance: Arc<Instance>,
}

impl Device {
    /// Opens the device that the request names.
    pub fn open(request: &DeviceRequest) -> Result<Device, GpuError> {
        let instance = Arc::new(Instance::new(request.validation, &[])?);
        let devices = survey(&instance)?;
        let info = choose(&devices, request.device.as_deref())?;
        Device::open_on(&instance, info, request, None)
    }

    /// Opens the device that the request names, or else the best that can show pictures in `window`.
    #[cfg(feature = "viewer")]
    pub fn open_for_window(request: &DeviceRequest, window: WindowHandles) -> Result<(Device, Surface), GpuError> {
        let extensions = Surface::extensions(&*window)?;
        let instance = Arc::new(Instance::new(request.validation, &extensions)?);
        let surface = Surface::new(&instance, window)?;
        let (info, family) = surface.choose(&survey(&instance)?, request.device.as_deref())?;
        Ok((Device::open_on(&instance, &info, request, Some(family))?, surface))
    }

    /// `presenting`: the queue family that shows pictures in a window, if there is one.
    fn open_on(
        instance: &Arc<Instance>,
        info: &DeviceInfo,
        request: &DeviceRequest,
        presenting: Option<u32>,
    ) -> Result<Device, GpuError> {
        let open = |capabilities| Device::with_capabilities(instance, info, capabilities, presenting);
        let device = open(info.capabilities.without(&request.disable))?;
        if device.has(Capability::RayQuery)
            && let Err(reason) = crate::trace::smoke_test(&device)
        {
            let without = device.capabilities.without(&Capabilities::new([Capability::RayQuery]));
            let device = open(without)?;
            device.warn(format!("{} offers ray queries that do not work ({reason}); a BVH is used", info.name));
            return Ok(device);
        }
        Ok(device)
    }

    /// Opens `info` with exactly these capabilities.
    fn with_capabilities(
        instance: &Arc<Instance>,
        info: &DeviceInfo,
        capabilities: Capabilities,
        presenting: Option<u32>,
    ) -> Result<Device, GpuError> {
        let queue_family = presenting.map_or_else(|| queue_family(instance, info, &capabilities), Ok)?;
        let raw = create(instance, info, &capabilities, queue_family, presenting.is_some())?;
        let buffer_device_address = capabilities.has(Capability::RayQuery);
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.raw.clone(),
            device: raw.clone(),
            physical_device: info.raw,
            debug_settings: Default::default(),
            buffer_device_address,
            allocation_sizes: Default::default(),
        })
        .map_err(|e| GpuError::Unsuitable { device: info.name.clone(), reason: e.to_string() })?;
        // SAFETY: the family was chosen from this device and one queue of it was created.
        let queue = unsafe { raw.get_device_queue(queue_family, 0) };
        Ok(Device(Arc::new(DeviceInner {
            labels: instance.debug_utils.then(|| ext::debug_utils::Device::new(&instance.raw, &raw)),
            structures: capabilities
                .has(Capability::RayQuery)
                .then(|| khr::acceleration_structure::Device::new(&instance.raw, &raw)),
            rendering: capabilities
                .has(Capability::Graphics)
                .then(|| khr::dynamic_rendering::Device::new(&instance.raw, &raw)),
            info: info.clone(),
            quirks: Quirks::of(info),
            capabilities,
            warnings: Mutex::default(),
            raw,
            queue: Mutex::new(queue),
            queue_family,
            allocator: ManuallyDrop::new(Arc::new(Mutex::new(allocator))),
            #[cfg(feature = "hot-reload")]
            kernels: Default::default(),
            made: MadeKernels::default(),
            made_rasters: MadeRasters::default(),
            held: AtomicU64::new(0),
            peak: AtomicU64::new(0),
            instance: instance.clone(),
        })))
    }

    /// The devices that could be opened.
    pub fn list() -> Result<Vec<DeviceInfo>, GpuError> {
        survey(&Instance::new(false, &[])?)
    }
}

impl DeviceInner {
    pub fn has(&self, capability: Capability) -> bool {
        self.capabilities.has(capability)
    }

    /// What the validation layers have said so far; empty without validation.
    pub fn validation_messages(&self) -> Vec<String> {
        self.instance.messages()
    }

    /// The list that the validation layers write to, for after the device is gone.
    #[cfg(feature = "viewer")]
    pub(crate) fn validation_log(&self) -> super::instance::Messages {
        self.instance.log()
    }

    pub fn warnings(&self) -> Vec<String> {
        self.warnings.lock().map(|w| w.clone()).unwrap_or_default()
    }

    pub(crate) fn warn(&self, text: String) {
        if let Ok(mut warnings) = self.warnings.lock() {
            warnings.push(text);
        }
    }

    /// Bytes of device memory that buffers and images held at most, so far.
    pub fn peak_memory(&self) -> u64 {
        self.peak.load(Ordering::Relaxed)
    }

    pub(crate) fn held_memory(&self) -> u64 {
        self.held.load(Ordering::Relaxed)
    }

    pub(crate) fn count_allocated(&self, bytes: u64) {
        let held = self.held.fetch_add(bytes, Ordering::Relaxed) + bytes;
        self.peak.fetch_max(held, Ordering::Relaxed);
    }

    pub(crate) fn count_freed(&self, bytes: u64) {
        self.held.fetch_sub(bytes, Ordering::Relaxed);
    }

    /// How long one submission may take. A software device under a validation layer needs minutes for what a GPU does
    /// in a second; a GPU that takes this long hangs.
    pub(crate) fn patience(&self) -> Duration {
        Duration::from_secs(if self.info.kind == "cpu" { 600 } else { 60 })
    }

    pub(crate) fn set_name<H: vk::Handle>(&self, handle: H, name: &str) {
        let (Some(labels), Ok(name)) = (&self.labels, std::ffi::CString::new(name)) else { return };
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&name);
        // SAFETY: the handle belongs to this device. A name that could not be set is not worth an error.
        let _ = unsafe { labels.set_debug_utils_object_name(&info) };
    }
}

impl Drop for DeviceInner {
    fn drop(&mut self) {
        // SAFETY: resources hold the device by reference count, or are the device's own and destroyed here, so that every
        // other handle to the allocator is gone; it is dropped once, before the device whose memory it frees.
        unsafe {
            let _ = self.raw.device_wait_idle();
            self.made.clear();
            self.made_rasters.clear();
            ManuallyDrop::drop(&mut self.allocator);
            self.raw.destroy_device(None);
        }
    }
}

/// With graphics: a family that has graphics and compute. Without: compute alone where there is such a family.
fn queue_family(instance: &Instance, info: &DeviceInfo, capabilities: &Capabilities) -> Result<u32, GpuError> {
    // SAFETY: the physical device belongs to this instance.
    let families = unsafe { instance.raw.get_physical_device_queue_family_properties(info.raw) };
    let graphics = capabilities.has(Capability::Graphics);
    (0u32..)
        .zip(&families)
        .filter(|(_, f)| f.queue_count > 0 && f.queue_flags.contains(vk::QueueFlags::COMPUTE))
        .max_by_key(|(_, f)| f.queue_flags.contains(vk::QueueFlags::GRAPHICS) == graphics)
        .map(|(index, _)| index)
        .ok_or_else(|| GpuError::Unsuitable {
            device: info.name.clone(),
            reason: "it has no queue for compute".to_string(),
        })
}

fn create(
    instance: &Instance,
    info: &DeviceInfo,
    capabilities: &Capabilities,
    queue_family: u32,
    presenting: bool,
) -> Result<ash::Device, GpuError> {
    let mut extensions = if presenting { vec![khr::swapchain::NAME.as_ptr()] } else { Vec::new() };
    let mut vulkan12 = vk::PhysicalDeviceVulkan12Features::default();
    let mut rendering = vk::PhysicalDeviceDynamicRenderingFeatures::default().dynamic_rendering(true);
    let mut ray_query = vk::PhysicalDeviceRayQueryFeaturesKHR::default().ray_query(true);
    let mut structures = vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default().acceleration_structure(true);
    let mut atomics = vk::PhysicalDeviceShaderAtomicFloatFeaturesEXT::default().shader_buffer_float32_atomic_add(true);
    let core = vk::PhysicalDeviceFeatures::default().geometry_shader(capabilities.has(Capability::GeometryShader));
    let mut features = vk::PhysicalDeviceFeatures2::default().features(core);
    if capabilities.has(Capability::Graphics) {
        extensions.push(khr::dynamic_rendering::NAME.as_ptr());
        features = features.push_next(&mut rendering);
    }
    if capabilities.has(Capability::RayQuery) {
        extensions.extend([
            khr::ray_query::NAME.as_ptr(),
            khr::acceleration_structure::NAME.as_ptr(),
            khr::deferred_host_operations::NAME.as_ptr(),
        ]);
        vulkan12 = vulkan12.buffer_device_address(true);
        features = features.push_next(&mut ray_query).push_next(&mut structures);
    }
    if capabilities.has(Capability::FloatAtomics) {
        extensions.push(ext::shader_atomic_float::NAME.as_ptr());
        features = features.push_next(&mut atomics);
    }
    features = features.push_next(&mut vulkan12);
    let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(queue_family).queue_priorities(&[1.0])];
    let device_info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(&extensions)
        .push_next(&mut features);
    // SAFETY: only features and extensions that the survey found are asked for.
    unsafe { instance.raw.create_device(info.raw, &device_info, None) }.map_err(|result| GpuError::Unsuitable {
        device: info.name.clone(),
        reason: format!("vkCreateDevice failed: {result}"),
    })
}
