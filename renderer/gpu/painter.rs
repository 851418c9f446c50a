//! Draws what egui lays out.

use std::sync::Arc;

use ash::vk;
use egui::epaint::textures::TexturesDelta;
use egui::{ClippedPrimitive, TextureId};
use egui_ash_renderer::{Options, Renderer, RendererError};

use super::error::Call;
use super::{Device, GpuError, Swapchain};

/// egui's textures and the shapes to draw next.
pub struct Painter {
    // Dropped before the device.
    renderer: Renderer,
    pool: vk::CommandPool,
    shapes: Vec<ClippedPrimitive>,
    pixels_per_point: f32,
    /// Textures that the shapes drawn last still use.
    free: Vec<TextureId>,
    device: Device,
}

impl Painter {
    /// Draws into pictures of `swapchain`.
    pub fn new(device: &Device, swapchain: &Swapchain) -> Result<Self, GpuError> {
        let options = Options { srgb_framebuffer: swapchain.is_srgb(), ..Default::default() };
        let allocator = Arc::clone(&device.allocator);
        let pass = swapchain.render_pass();
        let renderer = Renderer::with_gpu_allocator(allocator, device.raw.clone(), pass, options)
            .map_err(|error| failure(device, error))?;
        let info = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::TRANSIENT)
            .queue_family_index(device.queue_family);
        // SAFETY: the family is the one the device was made with.
        let pool = unsafe { device.raw.create_command_pool(&info, None) }.call("vkCreateCommandPool")?;
        Ok(Painter {
            renderer,
            pool,
            shapes: Vec::new(),
            pixels_per_point: 1.0,
            free: Vec::new(),
            device: device.clone(),
        })
    }

    /// Takes what is to be drawn from now on. Textures are uploaded at once.
    pub fn set(
        &mut self,
        textures: TexturesDelta,
        shapes: Vec<ClippedPrimitive>,
        pixels_per_point: f32,
    ) -> Result<(), GpuError> {
        (self.shapes, self.pixels_per_point) = (shapes, pixels_per_point);
        // Every submission is waited for: nothing is in use any more that was to be freed after the last drawing.
        self.renderer.free_textures(&self.free).map_err(|error| failure(&self.device, error))?;
        self.free = textures.free;
        let queue = self.device.queue.lock().map_err(|_| lost(&self.device))?;
        self.renderer.set_textures(*queue, self.pool, &textures.set).map_err(|error| failure(&self.device, error))
    }

    pub(super) fn record(&mut self, commands: vk::CommandBuffer, extent: vk::Extent2D) -> Result<(), GpuError> {
        self.renderer
            .cmd_draw(commands, extent, self.pixels_per_point, &self.shapes)
            .map_err(|error| failure(&self.device, error))
    }
}

impl Drop for Painter {
    fn drop(&mut self) {
        // SAFETY: every submission is waited for, so the pool is not in use.
        unsafe { self.device.raw.destroy_command_pool(self.pool, None) };
    }
}

fn lost(device: &Device) -> GpuError {
    GpuError::DeviceLost { device: device.info.name.clone(), pass: "the window".to_string() }
}

fn failure(device: &Device, error: RendererError) -> GpuError {
    match error {
        RendererError::Vulkan(vk::Result::ERROR_DEVICE_LOST) => lost(device),
        RendererError::Vulkan(result) => GpuError::Vulkan { call: "drawing the window", result },
        other => GpuError::Unsuitable {
            device: device.info.name.clone(),
            reason: format!("the window cannot be drawn: {other}"),
        },
    }
}
