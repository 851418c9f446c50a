//! The devices of an instance: who they are and what they can do.

use ash::{ext, khr, vk};

use super::capability::{Capabilities, Capability};
use super::error::Call;
use super::{GpuError, Instance};

/// A physical device, as `nephroid devices` shows it.
#[derive(Debug, Clone, serde::Serialize)]
pub struct DeviceInfo {
    /// What `--device` takes, beside a part of the name.
    pub index: usize,
    pub name: String,
    /// `discrete`, `integrated`, `virtual`, `cpu` or `other`.
    pub kind: &'static str,
    pub driver: String,
    pub driver_version: String,
    pub vulkan: String,
    /// What the driver claims; ray queries are tried before they are used.
    pub capabilities: Capabilities,
    pub limits: Limits,
    /// Why the device cannot run Nephroid, if it cannot.
    pub unsuitable: Option<String>,
    #[serde(skip)]
    pub(crate) raw: vk::PhysicalDevice,
}

/// The limits that Nephroid minds.
#[derive(Debug, Clone, Copy, serde::Serialize)]
pub struct Limits {
    /// Bytes of one storage buffer range.
    pub storage_range: u64,
    /// Bytes.
    pub storage_offset_alignment: u64,
    pub push_constants: u32,
    pub descriptor_sets: u32,
    pub workgroup_invocations: u32,
    /// Workgroups along one axis of a dispatch.
    pub workgroup_count: u32,
    /// Storage buffers that one kernel can see.
    pub storage_buffers: u32,
    /// Invocations; no kernel relies on it.
    pub subgroup: u32,
    /// Pixels along one side of a raster target.
    pub target_side: u32,
    /// Bits of a pixel to which the rasteriser knows positions.
    pub subpixel_bits: u32,
    /// Whether rasterised colours of four 32-bit floats can add up.
    pub float_sums: bool,
    /// Vertices that one invocation of a geometry stage can emit; 0 without such stages.
    pub geometry_vertices: u32,
    /// Numbers in all of those vertices together.
    pub geometry_components: u32,
    /// Nanoseconds per timestamp tick.
    pub timestamp_period: f32,
}

impl DeviceInfo {
    /// `llvmpipe (LLVM 19.1.7, 256 bits), llvmpipe Mesa 25.0.7`.
    pub fn describe(&self) -> String {
        format!("{}, {} {}", self.name, self.driver, self.driver_version)
    }
}

/// Every device of the instance, in the loader's order.
pub fn survey(instance: &Instance) -> Result<Vec<DeviceInfo>, GpuError> {
    // SAFETY: the instance is alive.
    let devices = match unsafe { instance.raw.enumerate_physical_devices() } {
        // The loader's answer where it has no driver at all.
        Err(vk::Result::ERROR_INITIALIZATION_FAILED | vk::Result::ERROR_INCOMPATIBLE_DRIVER) => Vec::new(),
        other => other.call("vkEnumeratePhysicalDevices")?,
    };
    devices.into_iter().enumerate().map(|(index, raw)| describe(instance, index, raw)).collect()
}

fn describe(instance: &Instance, index: usize, raw: vk::PhysicalDevice) -> Result<DeviceInfo, GpuError> {
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut subgroup = vk::PhysicalDeviceSubgroupProperties::default();
    let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut driver).push_next(&mut subgroup);
    // SAFETY: `raw` belongs to this instance, and the chain is of structs of Vulkan 1.2.
    unsafe { instance.raw.get_physical_device_properties2(raw, &mut properties) };
    let properties = properties.properties;
    // SAFETY: `raw` belongs to this instance.
    let formats = unsafe {
        instance.raw.get_physical_device_format_properties(raw, vk::Format::R32G32B32A32_SFLOAT).optimal_tiling_features
    };
    let limits = Limits {
        storage_range: properties.limits.max_storage_buffer_range.into(),
        storage_offset_alignment: properties.limits.min_storage_buffer_offset_alignment,
        push_constants: properties.limits.max_push_constants_size,
        descriptor_sets: properties.limits.max_bound_descriptor_sets,
        workgroup_invocations: properties.limits.max_compute_work_group_invocations,
        workgroup_count: properties.limits.max_compute_work_group_count[0],
        storage_buffers: properties.limits.max_per_stage_descriptor_storage_buffers,
        subgroup: subgroup.subgroup_size,
        target_side: target_side(&properties.limits),
        subpixel_bits: properties.limits.sub_pixel_precision_bits,
        float_sums: formats.contains(vk::FormatFeatureFlags::COLOR_ATTACHMENT_BLEND),
        geometry_vertices: properties.limits.max_geometry_output_vertices,
        geometry_components: properties.limits.max_geometry_total_output_components,
        timestamp_period: properties.limits.timestamp_period,
    };
    let text = |s: Result<&std::ffi::CStr, _>| s.unwrap_or(c"?").to_string_lossy().into_owned();
    let version = properties.api_version;
    let unsuitable = (version < vk::API_VERSION_1_2).then(|| {
        format!(
            "it offers Vulkan {}.{}, and 1.2 is needed",
            vk::api_version_major(version),
            vk::api_version_minor(version)
        )
    });
    Ok(DeviceInfo {
        index,
        name: text(properties.device_name_as_c_str()),
        kind: match properties.device_type {
            vk::PhysicalDeviceType::DISCRETE_GPU => "discrete",
            vk::PhysicalDeviceType::INTEGRATED_GPU => "integrated",
            vk::PhysicalDeviceType::VIRTUAL_GPU => "virtual",
            vk::PhysicalDeviceType::CPU => "cpu",
            _ => "other",
        },
        driver: text(driver.driver_name_as_c_str()),
        driver_version: driver_version(&driver, properties.driver_version),
        vulkan: format!(
            "{}.{}.{}",
            vk::api_version_major(version),
            vk::api_version_minor(version),
            vk::api_version_patch(version)
        ),
        capabilities: capabilities(instance, raw, version, &limits)?,
        limits,
        unsuitable,
        raw,
    })
}

fn target_side(limits: &vk::PhysicalDeviceLimits) -> u32 {
    let viewport = limits.max_viewport_dimensions;
    [
        limits.max_image_dimension2_d,
        limits.max_framebuffer_width,
        limits.max_framebuffer_height,
        viewport[0],
        viewport[1],
    ]
    .into_iter()
    .min()
    .unwrap_or(0)
}

/// The driver's own words, or its number where it has none (SwiftShader).
fn driver_version(driver: &vk::PhysicalDeviceDriverProperties<'_>, number: u32) -> String {
    let words = driver.driver_info_as_c_str().unwrap_or(c"").to_string_lossy();
    if !words.is_empty() {
        return words.into_owned();
    }
    format!("{}.{}.{}", vk::api_version_major(number), vk::api_version_minor(number), vk::api_version_patch(number))
}

fn capabilities(
    instance: &Instance,
    raw: vk::PhysicalDevice,
    version: u32,
    limits: &Limits,
) -> Result<Capabilities, GpuError> {
    // SAFETY: `raw` belongs to this instance.
    let extensions = unsafe { instance.raw.enumerate_device_extension_properties(raw) }
        .call("vkEnumerateDeviceExtensionProperties")?;
    let has = |name: &std::ffi::CStr| extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(name));

    let mut vulkan12 = vk::PhysicalDeviceVulkan12Features::default();
    let mut rendering = vk::PhysicalDeviceDynamicRenderingFeatures::default();
    let mut ray_query = vk::PhysicalDeviceRayQueryFeaturesKHR::default();
    let mut structures = vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default();
    let mut atomics = vk::PhysicalDeviceShaderAtomicFloatFeaturesEXT::default();
    let has_rendering = has(khr::dynamic_rendering::NAME);
    let has_ray_query =
        has(khr::ray_query::NAME) && has(khr::acceleration_structure::NAME) && has(khr::deferred_host_operations::NAME);
    let has_atomics = has(ext::shader_atomic_float::NAME);
    let mut features = vk::PhysicalDeviceFeatures2::default();
    if version >= vk::API_VERSION_1_2 {
        features = features.push_next(&mut vulkan12);
    }
    if has_rendering {
        features = features.push_next(&mut rendering);
    }
    if has_ray_query {
        features = features.push_next(&mut ray_query).push_next(&mut structures);
    }
    if has_atomics {
        features = features.push_next(&mut atomics);
    }
    // SAFETY: structs of extensions are chained only where the device lists the extension.
    unsafe { instance.raw.get_physical_device_features2(raw, &mut features) };
    let geometry_shader = features.features.geometry_shader == vk::TRUE;
    // SAFETY: `raw` belongs to this instance.
    let families = unsafe { instance.raw.get_physical_device_queue_family_properties(raw) };
    let graphics_queue = families
        .iter()
        .any(|f| f.queue_flags.contains(vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE) && f.queue_count > 0);
    let timestamps = limits.timestamp_period > 0.0 && families.iter().all(|f| f.timestamp_valid_bits >= 32);

    let graphics = graphics_queue && rendering.dynamic_rendering == vk::TRUE;
    let offered = [
        (
            Capability::RayQuery,
            ray_query.ray_query == vk::TRUE
                && structures.acceleration_structure == vk::TRUE
                && vulkan12.buffer_device_address == vk::TRUE,
        ),
        (Capability::Graphics, graphics),
        (Capability::PreciseRaster, graphics && limits.subpixel_bits >= 8),
        (Capability::GeometryShader, graphics && geometry_shader),
        (Capability::FloatAtomics, atomics.shader_buffer_float32_atomic_add == vk::TRUE),
        (Capability::Timestamps, timestamps),
    ];
    Ok(Capabilities::new(offered.into_iter().filter(|(_, yes)| *yes).map(|(c, _)| c)))
}

/// The device that `wanted` names by index or by a part of its name (any case), or else the most capable kind.
pub fn choose<'a>(devices: &'a [DeviceInfo], wanted: Option<&str>) -> Result<&'a DeviceInfo, GpuError> {
    if devices.is_empty() {
        return Err(GpuError::NoDevice);
    }
    let chosen = match wanted {
        Some(wanted) => {
            let lower = wanted.to_lowercase();
            let by_index = wanted.parse::<usize>().ok().and_then(|i| devices.get(i));
            by_index.or_else(|| devices.iter().find(|d| d.name.to_lowercase().contains(&lower))).ok_or_else(|| {
                let found: Vec<_> = devices.iter().map(|d| format!("{} {}", d.index, d.name)).collect();
                GpuError::UnknownDevice { wanted: wanted.to_string(), found: found.join("; ") }
            })?
        }
        None => {
            let rank = |d: &DeviceInfo| {
                let kinds = ["discrete", "integrated", "virtual", "other", "cpu"];
                let kind = kinds.iter().position(|k| *k == d.kind);
                (d.unsuitable.is_some(), kind, !d.capabilities.has(Capability::RayQuery), d.index)
            };
            devices.iter().min_by_key(|d| rank(d)).ok_or(GpuError::NoDevice)?
        }
    };
    match &chosen.unsuitable {
        Some(reason) => Err(GpuError::Unsuitable { device: chosen.name.clone(), reason: reason.clone() }),
        None => Ok(chosen),
    }
}
