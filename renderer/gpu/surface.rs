//! Where a window takes pictures: the surface, and the devices that can present to it.

use std::ffi::CStr;
use std::sync::Arc;

use ash::{khr, vk};
use winit::raw_window_handle::{HandleError, HasDisplayHandle, HasWindowHandle, RawDisplayHandle, RawWindowHandle};

use super::error::Call;
use super::survey::{DeviceInfo, choose};
use super::{Device, GpuError, Instance};

/// A window and the display it is on.
pub trait Handles: HasDisplayHandle + HasWindowHandle + Send + Sync {}
impl<T: HasDisplayHandle + HasWindowHandle + Send + Sync> Handles for T {}

/// A window that lives as long as what shows pictures in it.
pub type WindowHandles = Arc<dyn Handles>;

/// Formats of four bytes, those that encode sRGB by themselves first. Pictures of others cannot be captured.
pub(super) const EIGHT_BITS: [vk::Format; 4] =
    [vk::Format::B8G8R8A8_SRGB, vk::Format::R8G8B8A8_SRGB, vk::Format::B8G8R8A8_UNORM, vk::Format::R8G8B8A8_UNORM];

/// A window's surface. It keeps the window and the instance alive.
pub struct Surface {
    pub(super) raw: vk::SurfaceKHR,
    pub(super) functions: khr::surface::Instance,
    instance: Arc<Instance>,
    window: WindowHandles,
}

impl Surface {
    /// The instance extensions that windows of this display need.
    pub(super) fn extensions(window: &dyn Handles) -> Result<Vec<&'static CStr>, GpuError> {
        let display = window.display_handle().map_err(no_handle)?;
        let names = ash_window::enumerate_required_extensions(display.as_raw()).call("vkCreateSurfaceKHR")?;
        // SAFETY: the list is of constant zero-terminated strings.
        Ok(names.iter().map(|&name| unsafe { CStr::from_ptr(name) }).collect())
    }

    pub(super) fn new(instance: &Arc<Instance>, window: WindowHandles) -> Result<Self, GpuError> {
        let functions = khr::surface::Instance::new(&instance.entry, &instance.raw);
        let raw = vk::SurfaceKHR::null();
        let mut surface = Surface { raw, functions, instance: instance.clone(), window };
        surface.renew()?;
        Ok(surface)
    }

    /// Makes the surface anew, after it was lost. Nothing may use the old one any more.
    pub(super) fn renew(&mut self) -> Result<(), GpuError> {
        let display = self.window.display_handle().map_err(no_handle)?.as_raw();
        let handle = self.window.window_handle().map_err(no_handle)?.as_raw();
        let instance = &self.instance;
        // SAFETY: the old surface, if any, has no swapchain. The instance has the extensions of this display, and the
        // window outlives the surface, which holds it.
        unsafe {
            self.functions.destroy_surface(std::mem::take(&mut self.raw), None);
            self.raw = ash_window::create_surface(&instance.entry, &instance.raw, display, handle, None)
                .call("vkCreateSurfaceKHR")?;
        }
        Ok(())
    }

    /// The device that `wanted` names, or else the most capable one that can present here, with the queue family that
    /// can.
    pub(super) fn choose(&self, devices: &[DeviceInfo], wanted: Option<&str>) -> Result<(DeviceInfo, u32), GpuError> {
        let best = choose(devices, wanted)?;
        let able: Vec<DeviceInfo> = devices.iter().filter(|device| self.family(device).is_some()).cloned().collect();
        let chosen = match wanted {
            None if !able.is_empty() => choose(&able, None)?,
            _ => best,
        };
        let family = self.family(chosen).ok_or_else(|| GpuError::CannotPresent { device: chosen.name.clone() })?;
        Ok((chosen.clone(), family))
    }

    /// A queue family that draws, computes and presents.
    fn family(&self, device: &DeviceInfo) -> Option<u32> {
        let raw = &self.instance.raw;
        // SAFETY: the physical device belongs to this instance.
        let extensions = unsafe { raw.enumerate_device_extension_properties(device.raw) }.unwrap_or_default();
        if !extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(khr::swapchain::NAME)) {
            return None;
        }
        // SAFETY: as above.
        let families = unsafe { raw.get_physical_device_queue_family_properties(device.raw) };
        let presents = |family: u32| {
            // SAFETY: the family is one of the device's, and the surface is of the same instance.
            unsafe { self.functions.get_physical_device_surface_support(device.raw, family, self.raw) }.unwrap_or(false)
                && self.display_is_known(device, family)
        };
        let wanted = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
        let fits = |&(family, f): &(u32, &vk::QueueFamilyProperties)| {
            f.queue_count > 0 && f.queue_flags.contains(wanted) && presents(family)
        };
        (0u32..).zip(&families).find(fits).map(|(family, _)| family)
    }

    /// Whether the driver knows this kind of display. SwiftShader (5.0.0) says of any surface that it supports it, and
    /// crashes at an Xlib one, whose extension it does not have.
    fn display_is_known(&self, device: &DeviceInfo, family: u32) -> bool {
        let (Ok(display), Ok(window)) = (self.window.display_handle(), self.window.window_handle()) else {
            return false;
        };
        let (RawDisplayHandle::Xlib(display), RawWindowHandle::Xlib(window)) = (display.as_raw(), window.as_raw())
        else {
            return true;
        };
        let xlib = khr::xlib_surface::Instance::new(&self.instance.entry, &self.instance.raw);
        let Some(display) = display.display else { return false };
        // SAFETY: the instance has the extension of this display, which is open as long as the window. The ids of X have 29
        // bits.
        unsafe {
            xlib.get_physical_device_xlib_presentation_support(
                device.raw,
                family,
                display.as_ptr(),
                window.visual_id as vk::VisualID,
            )
        }
    }

    /// What the surface allows at this moment.
    pub(super) fn capabilities(&self, device: &Device) -> Result<vk::SurfaceCapabilitiesKHR, GpuError> {
        // SAFETY: device and surface are of the same instance.
        unsafe { self.functions.get_physical_device_surface_capabilities(device.info.raw, self.raw) }
            .call("vkGetPhysicalDeviceSurfaceCapabilitiesKHR")
    }

    /// The format of its pictures: the first of [`EIGHT_BITS`] that there is, or else any.
    pub(super) fn format(&self, device: &Device) -> Result<vk::SurfaceFormatKHR, GpuError> {
        // SAFETY: as above.
        let formats = unsafe { self.functions.get_physical_device_surface_formats(device.info.raw, self.raw) }
            .call("vkGetPhysicalDeviceSurfaceFormatsKHR")?;
        let rank = |format: &vk::SurfaceFormatKHR| {
            EIGHT_BITS.iter().position(|known| *known == format.format).unwrap_or(EIGHT_BITS.len())
        };
        let best = formats.iter().min_by_key(|format| rank(format)).copied();
        best.ok_or_else(|| GpuError::CannotPresent { device: device.info.name.clone() })
    }
}

impl Drop for Surface {
    fn drop(&mut self) {
        // SAFETY: the swapchain, which holds the surface, is gone.
        unsafe { self.functions.destroy_surface(self.raw, None) };
    }
}

fn no_handle(error: HandleError) -> GpuError {
    GpuError::NoSurfaces { missing: format!("surface for this window ({error})") }
}
