//! A window's swapchain: one picture at a time is drawn, waited for and presented.

use ash::{khr, vk};

use super::error::Call;
use super::surface::EIGHT_BITS;
use super::{Buffer, Device, GpuError, Painter, Surface};

/// Nanoseconds to wait for a picture of the window. A display that shows none must not keep the program from its events.
const LONGEST_WAIT: u64 = 100_000_000;

/// What became of a picture for the window.
#[derive(Debug, PartialEq)]
pub enum Drawn {
    /// It is shown. Where it was asked for, the picture: width, height, 8-bit sRGB, row 0 on top.
    Shown(Option<(u32, u32, Vec<[u8; 3]>)>),
    /// The window has no area at this moment, being minimised.
    Hidden,
    /// The window has changed, or the display is not ready; it is to be drawn again.
    Again,
}

/// The pictures of a window, remade whenever the window changes.
pub struct Swapchain {
    raw: vk::SwapchainKHR,
    targets: Vec<Target>,
    extent: vk::Extent2D,
    format: vk::SurfaceFormatKHR,
    /// Whether pictures can be copied from.
    readable: bool,
    stale: bool,
    render_pass: vk::RenderPass,
    commands: Commands,
    functions: khr::swapchain::Device,
    surface: Surface,
    device: Device,
}

struct Target {
    image: vk::Image,
    view: vk::ImageView,
    framebuffer: vk::Framebuffer,
    /// Signalled when the image is drawn; the presentation waits for it.
    drawn: vk::Semaphore,
}

#[derive(Default)]
struct Commands {
    pool: vk::CommandPool,
    buffer: vk::CommandBuffer,
    acquired: vk::Semaphore,
    done: vk::Fence,
}

impl Swapchain {
    /// For the window of `surface`, which `device` was opened for.
    pub fn new(device: &Device, surface: Surface) -> Result<Self, GpuError> {
        let format = surface.format(device)?;
        let mut swapchain = Swapchain {
            raw: vk::SwapchainKHR::null(),
            targets: Vec::new(),
            extent: vk::Extent2D::default(),
            format,
            readable: false,
            stale: true,
            render_pass: vk::RenderPass::null(),
            commands: Commands::default(),
            functions: khr::swapchain::Device::new(&device.instance.raw, &device.raw),
            surface,
            device: device.clone(),
        };
        swapchain.render_pass = render_pass(device, format.format)?;
        swapchain.commands.create(device)?;
        Ok(swapchain)
    }

    /// Whether its pictures encode sRGB by themselves.
    pub fn is_srgb(&self) -> bool {
        matches!(self.format.format, vk::Format::B8G8R8A8_SRGB | vk::Format::R8G8B8A8_SRGB)
    }

    pub(super) fn render_pass(&self) -> vk::RenderPass {
        self.render_pass
    }

    /// Draws what `painter` holds, and waits for it. `size` is the window's in pixels; `capture` asks for the picture.
    ///
    /// # Errors
    /// Those of the device. A swapchain that is out of date or a surface that is lost is made anew instead.
    pub fn draw(&mut self, size: (u32, u32), painter: &mut Painter, capture: bool) -> Result<Drawn, GpuError> {
        if self.stale
            && let Some(not_drawn) = self.remake(size)?
        {
            return Ok(not_drawn);
        }
        // SAFETY: the semaphore is not in use, since the last submission that waited for it has ended.
        let acquired = unsafe {
            self.functions.acquire_next_image(self.raw, LONGEST_WAIT, self.commands.acquired, vk::Fence::null())
        };
        let index = match acquired {
            Ok((index, suboptimal)) => {
                self.stale |= suboptimal;
                index
            }
            Err(vk::Result::TIMEOUT | vk::Result::NOT_READY) => return Ok(Drawn::Again),
            Err(error) => return self.changed(error, "vkAcquireNextImageKHR"),
        };
        let read = if capture && self.readable { Some(self.capture_buffer()?) } else { None };
        self.record(index as usize, painter, read.as_ref())?;
        self.submit(index as usize)?;
        if let Err(error) = self.present(index) {
            return self.changed(error, "vkQueuePresentKHR");
        }
        let picture = read.map(|buffer| self.picture(&buffer)).transpose()?;
        Ok(Drawn::Shown(picture))
    }

    /// The window's size has changed.
    pub fn resized(&mut self) {
        self.stale = true;
    }

    /// What a changed window asks for: to be drawn again by a new swapchain.
    fn changed(&mut self, error: vk::Result, call: &'static str) -> Result<Drawn, GpuError> {
        self.stale = true;
        match error {
            vk::Result::ERROR_OUT_OF_DATE_KHR => Ok(Drawn::Again),
            vk::Result::ERROR_SURFACE_LOST_KHR => {
                self.clear()?;
                self.surface.renew()?;
                Ok(Drawn::Again)
            }
            error => Err(self.failure(error, call)),
        }
    }

    fn failure(&self, result: vk::Result, call: &'static str) -> GpuError {
        match result {
            vk::Result::ERROR_DEVICE_LOST => self.lost(),
            result => GpuError::Vulkan { call, result },
        }
    }

    fn lost(&self) -> GpuError {
        GpuError::DeviceLost { device: self.device.info.name.clone(), pass: "the window".to_string() }
    }

    /// Makes the swapchain anew for the window as it is, or tells why nothing can be drawn.
    fn remake(&mut self, (width, height): (u32, u32)) -> Result<Option<Drawn>, GpuError> {
        let allowed = match self.surface.capabilities(&self.device) {
            Err(GpuError::Vulkan { result: vk::Result::ERROR_SURFACE_LOST_KHR, .. }) => {
                self.clear()?;
                self.surface.renew()?;
                self.surface.capabilities(&self.device)?
            }
            other => other?,
        };
        let (least, most) = (allowed.min_image_extent, allowed.max_image_extent);
        let extent = match allowed.current_extent {
            // The surface leaves its size to the swapchain.
            vk::Extent2D { width: u32::MAX, .. } => vk::Extent2D {
                width: width.clamp(least.width, most.width),
                height: height.clamp(least.height, most.height),
            },
            current => current,
        };
        if extent.width == 0 || extent.height == 0 || width == 0 || height == 0 {
            return Ok(Some(Drawn::Hidden));
        }
        self.clear()?;
        self.readable = allowed.supported_usage_flags.contains(vk::ImageUsageFlags::TRANSFER_SRC)
            && EIGHT_BITS.contains(&self.format.format);
        let copied = if self.readable { vk::ImageUsageFlags::TRANSFER_SRC } else { vk::ImageUsageFlags::empty() };
        let opaque = vk::CompositeAlphaFlagsKHR::OPAQUE;
        let alpha = if allowed.supported_composite_alpha.contains(opaque) {
            opaque
        } else {
            vk::CompositeAlphaFlagsKHR::INHERIT
        };
        let most_images = if allowed.max_image_count == 0 { u32::MAX } else { allowed.max_image_count };
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(self.surface.raw)
            .min_image_count((allowed.min_image_count + 1).min(most_images))
            .image_format(self.format.format)
            .image_color_space(self.format.color_space)
            .image_extent(extent)
            .image_array_layers(1)
            .image_usage(vk::ImageUsageFlags::COLOR_ATTACHMENT | copied)
            .image_sharing_mode(vk::SharingMode::EXCLUSIVE)
            .pre_transform(allowed.current_transform)
            .composite_alpha(alpha)
            // The one mode that every device has; it never tears, and it waits for the display.
            .present_mode(vk::PresentModeKHR::FIFO)
            .clipped(true);
        // SAFETY: everything is within what the surface allows at this moment.
        self.raw = match unsafe { self.functions.create_swapchain(&info, None) } {
            Ok(raw) => raw,
            // The window changed in between: the next attempt will see it.
            Err(error) => return self.changed(error, "vkCreateSwapchainKHR").map(Some),
        };
        self.extent = extent;
        // SAFETY: the swapchain was just made.
        let images = unsafe { self.functions.get_swapchain_images(self.raw) }.call("vkGetSwapchainImagesKHR")?;
        for image in images {
            let target = Target {
                image,
                view: vk::ImageView::null(),
                framebuffer: vk::Framebuffer::null(),
                drawn: vk::Semaphore::null(),
            };
            self.targets.push(target);
        }
        for target in &mut self.targets {
            target.create(&self.device, self.format.format, self.render_pass, extent)?;
        }
        self.stale = false;
        Ok(None)
    }

    fn record(&self, index: usize, painter: &mut Painter, read: Option<&Buffer>) -> Result<(), GpuError> {
        let (raw, commands) = (&self.device.raw, self.commands.buffer);
        let target = &self.targets[index];
        let clear = [vk::ClearValue { color: vk::ClearColorValue { float32: [0.0, 0.0, 0.0, 1.0] } }];
        let area = vk::Rect2D { extent: self.extent, ..Default::default() };
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        let pass = vk::RenderPassBeginInfo::default()
            .render_pass(self.render_pass)
            .framebuffer(target.framebuffer)
            .render_area(area)
            .clear_values(&clear);
        // SAFETY: the last submission has ended, so the pool can be reset; the framebuffer fits the render pass.
        unsafe {
            raw.reset_command_pool(self.commands.pool, vk::CommandPoolResetFlags::empty())
                .call("vkResetCommandPool")?;
            raw.begin_command_buffer(commands, &begin).call("vkBeginCommandBuffer")?;
            raw.cmd_begin_render_pass(commands, &pass, vk::SubpassContents::INLINE);
        }
        let painted = painter.record(commands, self.extent);
        // SAFETY: closes what was opened above.
        unsafe { raw.cmd_end_render_pass(commands) };
        if let Some(buffer) = read {
            self.record_copy(target.image, buffer);
        }
        // SAFETY: as above.
        unsafe { raw.end_command_buffer(commands) }.call("vkEndCommandBuffer")?;
        painted
    }

    /// Copies the drawn image to the buffer and leaves it ready to be presented.
    fn record_copy(&self, image: vk::Image, buffer: &Buffer) {
        let (raw, commands) = (&self.device.raw, self.commands.buffer);
        let layers = vk::ImageSubresourceLayers {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            layer_count: 1,
            ..Default::default()
        };
        let region = vk::BufferImageCopy::default().image_subresource(layers).image_extent(vk::Extent3D {
            width: self.extent.width,
            height: self.extent.height,
            depth: 1,
        });
        let barrier = |from, to| {
            vk::ImageMemoryBarrier::default()
                .old_layout(from)
                .new_layout(to)
                .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
                .dst_access_mask(vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE)
                .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .image(image)
                .subresource_range(COLOR_RANGE)
        };
        let (shown, read) = (vk::ImageLayout::PRESENT_SRC_KHR, vk::ImageLayout::TRANSFER_SRC_OPTIMAL);
        let all = vk::PipelineStageFlags::ALL_COMMANDS;
        let none = vk::DependencyFlags::empty();
        // SAFETY: the image was made to be copied from, and the buffer holds four bytes for each of its pixels.
        unsafe {
            raw.cmd_pipeline_barrier(commands, all, all, none, &[], &[], &[barrier(shown, read)]);
            raw.cmd_copy_image_to_buffer(commands, image, read, buffer.raw, &[region]);
            raw.cmd_pipeline_barrier(commands, all, all, none, &[], &[], &[barrier(read, shown)]);
        }
    }

    fn submit(&self, index: usize) -> Result<(), GpuError> {
        let raw = &self.device.raw;
        let (wait, signal) = ([self.commands.acquired], [self.targets[index].drawn]);
        let commands = [self.commands.buffer];
        let submits = [vk::SubmitInfo::default()
            .wait_semaphores(&wait)
            .wait_dst_stage_mask(&[vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT])
            .command_buffers(&commands)
            .signal_semaphores(&signal)];
        let queue = self.device.queue.lock().map_err(|_| self.lost())?;
        let patience = self.device.patience();
        // SAFETY: the queue is locked for the call, the commands are complete, and the fence is not signalled.
        unsafe {
            raw.reset_fences(&[self.commands.done]).call("vkResetFences")?;
            raw.queue_submit(*queue, &submits, self.commands.done)
                .map_err(|error| self.failure(error, "vkQueueSubmit"))?;
            raw.wait_for_fences(&[self.commands.done], true, patience.as_nanos() as u64)
        }
        .map_err(|error| match error {
            vk::Result::TIMEOUT => GpuError::Timeout {
                device: self.device.info.name.clone(),
                pass: "the window".to_string(),
                seconds: patience.as_secs(),
            },
            other => self.failure(other, "vkWaitForFences"),
        })
    }

    fn present(&mut self, index: u32) -> Result<(), vk::Result> {
        let (wait, swapchains, indices) = ([self.targets[index as usize].drawn], [self.raw], [index]);
        let info = vk::PresentInfoKHR::default().wait_semaphores(&wait).swapchains(&swapchains).image_indices(&indices);
        let queue = self.device.queue.lock().map_err(|_| vk::Result::ERROR_DEVICE_LOST)?;
        // SAFETY: the image was acquired, and is presented once.
        let suboptimal = unsafe { self.functions.queue_present(*queue, &info) }?;
        self.stale |= suboptimal;
        Ok(())
    }

    fn capture_buffer(&self) -> Result<Buffer, GpuError> {
        let bytes = 4 * u64::from(self.extent.width) * u64::from(self.extent.height);
        Buffer::new(&self.device, "picture of the window", bytes)
    }

    fn picture(&self, buffer: &Buffer) -> Result<(u32, u32, Vec<[u8; 3]>), GpuError> {
        let vk::Extent2D { width, height } = self.extent;
        let bgr = matches!(self.format.format, vk::Format::B8G8R8A8_SRGB | vk::Format::B8G8R8A8_UNORM);
        let pixels: Vec<[u8; 4]> = buffer.read(width as usize * height as usize)?;
        let rgb = |[a, b, c, _]: [u8; 4]| if bgr { [c, b, a] } else { [a, b, c] };
        Ok((width, height, pixels.into_iter().map(rgb).collect()))
    }

    /// Destroys what belongs to the window's present size.
    fn clear(&mut self) -> Result<(), GpuError> {
        let raw = &self.device.raw;
        // SAFETY: the device is idle, a lost one included, so that nothing uses what is destroyed. Null handles are
        // allowed.
        unsafe {
            // The presentation engine may wait for a semaphore still.
            let idle = raw.device_wait_idle();
            for target in self.targets.drain(..) {
                raw.destroy_semaphore(target.drawn, None);
                raw.destroy_framebuffer(target.framebuffer, None);
                raw.destroy_image_view(target.view, None);
            }
            self.functions.destroy_swapchain(std::mem::take(&mut self.raw), None);
            idle.map_err(|error| self.failure(error, "vkDeviceWaitIdle"))
        }
    }
}

impl Drop for Swapchain {
    fn drop(&mut self) {
        let _ = self.clear();
        let raw = &self.device.raw;
        // SAFETY: the device is idle since `clear`; null handles are allowed.
        unsafe {
            raw.destroy_render_pass(self.render_pass, None);
            raw.destroy_fence(self.commands.done, None);
            raw.destroy_semaphore(self.commands.acquired, None);
            raw.destroy_command_pool(self.commands.pool, None);
        }
    }
}

const COLOR_RANGE: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: 1,
    base_array_layer: 0,
    layer_count: 1,
};

impl Target {
    /// What was made stays with the target if a later step fails.
    fn create(
        &mut self,
        device: &Device,
        format: vk::Format,
        pass: vk::RenderPass,
        extent: vk::Extent2D,
    ) -> Result<(), GpuError> {
        let view = vk::ImageViewCreateInfo::default()
            .image(self.image)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(format)
            .subresource_range(COLOR_RANGE);
        // SAFETY: the whole of a swapchain's image, in its own format, for a render pass of that format.
        unsafe {
            self.view = device.raw.create_image_view(&view, None).call("vkCreateImageView")?;
            let views = [self.view];
            let framebuffer = vk::FramebufferCreateInfo::default()
                .render_pass(pass)
                .attachments(&views)
                .width(extent.width)
                .height(extent.height)
                .layers(1);
            self.framebuffer = device.raw.create_framebuffer(&framebuffer, None).call("vkCreateFramebuffer")?;
            self.drawn = device.raw.create_semaphore(&Default::default(), None).call("vkCreateSemaphore")?;
        }
        Ok(())
    }
}

impl Commands {
    fn create(&mut self, device: &Device) -> Result<(), GpuError> {
        let raw = &device.raw;
        let pool = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::TRANSIENT)
            .queue_family_index(device.queue_family);
        // SAFETY: the family is the one the device was made with.
        unsafe {
            self.pool = raw.create_command_pool(&pool, None).call("vkCreateCommandPool")?;
            let info = vk::CommandBufferAllocateInfo::default().command_pool(self.pool).command_buffer_count(1);
            self.buffer = raw.allocate_command_buffers(&info).call("vkAllocateCommandBuffers")?[0];
            self.acquired = raw.create_semaphore(&Default::default(), None).call("vkCreateSemaphore")?;
            self.done = raw.create_fence(&Default::default(), None).call("vkCreateFence")?;
        }
        Ok(())
    }
}

/// One colour target, cleared first and presented afterwards. Every Vulkan device has render passes, dynamic rendering or
/// not.
fn render_pass(device: &Device, format: vk::Format) -> Result<vk::RenderPass, GpuError> {
    let attachments = [vk::AttachmentDescription::default()
        .format(format)
        .samples(vk::SampleCountFlags::TYPE_1)
        .load_op(vk::AttachmentLoadOp::CLEAR)
        .store_op(vk::AttachmentStoreOp::STORE)
        .stencil_load_op(vk::AttachmentLoadOp::DONT_CARE)
        .stencil_store_op(vk::AttachmentStoreOp::DONT_CARE)
        .initial_layout(vk::ImageLayout::UNDEFINED)
        .final_layout(vk::ImageLayout::PRESENT_SRC_KHR)];
    let color = [vk::AttachmentReference { attachment: 0, layout: vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL }];
    let subpasses = [vk::SubpassDescription::default()
        .pipeline_bind_point(vk::PipelineBindPoint::GRAPHICS)
        .color_attachments(&color)];
    // The image changes its layout after it was acquired: the semaphore is waited for at the same stage.
    let output = vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT;
    let dependencies = [vk::SubpassDependency::default()
        .src_subpass(vk::SUBPASS_EXTERNAL)
        .dst_subpass(0)
        .src_stage_mask(output)
        .dst_stage_mask(output)
        .dst_access_mask(vk::AccessFlags::COLOR_ATTACHMENT_WRITE)];
    let info =
        vk::RenderPassCreateInfo::default().attachments(&attachments).subpasses(&subpasses).dependencies(&dependencies);
    // SAFETY: every reference is to the one attachment.
    unsafe { device.raw.create_render_pass(&info, None) }.call("vkCreateRenderPass")
}
