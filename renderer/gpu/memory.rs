//! Buffers and images on the device, and the way to and from them.

use std::sync::Arc;

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};

use super::error::Call;
use super::{Device, GpuError, Pass, Recorder};

/// Bytes moved at once between host and device, so that a large mesh needs no staging buffer of its size.
const CHUNK: usize = 16 << 20;

/// Usage of scratch memory for building acceleration structures.
pub(crate) const SCRATCH: vk::BufferUsageFlags = vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;

/// A storage buffer that can be copied, filled and drawn from indirectly. Clones share it.
#[derive(Clone)]
pub struct Buffer(Arc<BufferInner>);

pub struct BufferInner {
    pub(crate) raw: vk::Buffer,
    pub(crate) size: u64,
    name: String,
    device: Device,
    allocation: Option<Allocation>,
}

impl std::ops::Deref for Buffer {
    type Target = BufferInner;
    fn deref(&self) -> &BufferInner {
        &self.0
    }
}

impl Buffer {
    /// A buffer of `size` bytes (at least 16: empty ranges cannot be bound) in device memory, not initialised.
    pub fn new(device: &Device, name: &str, size: u64) -> Result<Buffer, GpuError> {
        Self::with_usage(device, name, size, vk::BufferUsageFlags::empty(), MemoryLocation::GpuOnly)
    }

    /// As [`new`](Self::new), all bytes zero.
    pub fn zeroed(device: &Device, name: &str, size: u64) -> Result<Buffer, GpuError> {
        let buffer = Self::new(device, name, size)?;
        let mut recorder = Recorder::new(device)?;
        recorder.pass("memory/clear")?.fill(&buffer, 0);
        recorder.submit()?;
        Ok(buffer)
    }

    /// A buffer that holds `items`.
    pub fn from_slice<T: bytemuck::NoUninit>(device: &Device, name: &str, items: &[T]) -> Result<Buffer, GpuError> {
        Self::from_slice_with_usage(device, name, items, vk::BufferUsageFlags::empty())
    }

    pub(crate) fn from_slice_with_usage<T: bytemuck::NoUninit>(
        device: &Device,
        name: &str,
        items: &[T],
        usage: vk::BufferUsageFlags,
    ) -> Result<Buffer, GpuError> {
        let bytes: &[u8] = bytemuck::cast_slice(items);
        let buffer = Self::with_usage(device, name, bytes.len() as u64, usage, MemoryLocation::GpuOnly)?;
        buffer.upload(bytes)?;
        Ok(buffer)
    }

    pub(crate) fn with_usage(
        device: &Device,
        name: &str,
        size: u64,
        usage: vk::BufferUsageFlags,
        location: MemoryLocation,
    ) -> Result<Buffer, GpuError> {
        let size = size.max(16).next_multiple_of(4);
        let limit = device.info.limits.storage_range;
        // Acceleration structures and their scratch are never bound as storage buffers.
        let bound = !usage.contains(vk::BufferUsageFlags::ACCELERATION_STRUCTURE_STORAGE_KHR) && usage != SCRATCH;
        if size > limit && bound && location == MemoryLocation::GpuOnly {
            return Err(GpuError::BufferTooLarge {
                device: device.info.name.clone(),
                what: name.to_string(),
                bytes: size,
                limit,
            });
        }
        let usage = usage
            | vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::INDIRECT_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        let info = vk::BufferCreateInfo::default().size(size).usage(usage);
        // SAFETY: a plain buffer of a size that the device allows.
        let raw = unsafe { device.raw.create_buffer(&info, None) }.call("vkCreateBuffer")?;
        // SAFETY: the buffer was just created by this device.
        let requirements = unsafe { device.raw.get_buffer_memory_requirements(raw) };
        let allocation = match allocate(device, name, requirements, location, true) {
            Ok(allocation) => allocation,
            Err(error) => {
                // SAFETY: nothing uses the buffer yet.
                unsafe { device.raw.destroy_buffer(raw, None) };
                return Err(error);
            }
        };
        let inner =
            BufferInner { raw, size, name: name.to_string(), device: device.clone(), allocation: Some(allocation) };
        if let Some(allocation) = &inner.allocation {
            // SAFETY: memory of the type and size the buffer asked for, bound once.
            unsafe { device.raw.bind_buffer_memory(raw, allocation.memory(), allocation.offset()) }
                .call("vkBindBufferMemory")?;
        }
        device.set_name(raw, name);
        Ok(Buffer(Arc::new(inner)))
    }

    /// Bytes.
    pub fn size(&self) -> u64 {
        self.0.size
    }

    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// Writes `bytes` to the start of the buffer and waits.
    pub fn upload(&self, bytes: &[u8]) -> Result<(), GpuError> {
        self.upload_at(0, bytes)
    }

    /// Writes `bytes` from byte `offset` of the buffer on, a multiple of four, and waits.
    pub fn upload_at(&self, offset: u64, bytes: &[u8]) -> Result<(), GpuError> {
        if bytes.is_empty() {
            return Ok(());
        }
        let staging = self.staging(bytes.len(), MemoryLocation::CpuToGpu)?;
        for (index, chunk) in bytes.chunks(CHUNK).enumerate() {
            staging.write_mapped(chunk)?;
            let mut recorder = Recorder::new(&self.device)?;
            let at = offset + (index * CHUNK) as u64;
            recorder.pass("memory/upload")?.copy(&staging, 0, self, at, chunk.len() as u64);
            recorder.submit()?;
        }
        Ok(())
    }

    /// Reads `count` items from the start of the buffer, and waits for them.
    pub fn read<T: bytemuck::Pod>(&self, count: usize) -> Result<Vec<T>, GpuError> {
        self.read_at(0, count)
    }

    /// Reads `count` items from byte `offset` of the buffer on, a multiple of four, and waits for them.
    pub fn read_at<T: bytemuck::Pod>(&self, offset: u64, count: usize) -> Result<Vec<T>, GpuError> {
        let wanted = (count * size_of::<T>()).min(self.size.saturating_sub(offset) as usize);
        let staging = self.staging(wanted, MemoryLocation::GpuToCpu)?;
        let mut bytes = Vec::with_capacity(wanted);
        while bytes.len() < wanted {
            let length = (wanted - bytes.len()).min(CHUNK);
            let mut recorder = Recorder::new(&self.device)?;
            recorder.pass("memory/readback")?.copy(self, offset + bytes.len() as u64, &staging, 0, length as u64);
            recorder.submit()?;
            bytes.extend_from_slice(staging.mapped()?.get(..length).unwrap_or_default());
        }
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }

    fn staging(&self, bytes: usize, location: MemoryLocation) -> Result<Buffer, GpuError> {
        let name = format!("staging for {}", self.name);
        Self::with_usage(&self.device, &name, bytes.min(CHUNK) as u64, vk::BufferUsageFlags::empty(), location)
    }

    fn mapped(&self) -> Result<&[u8], GpuError> {
        self.0.allocation.as_ref().and_then(|a| a.mapped_slice()).ok_or_else(|| self.not_mapped())
    }

    fn write_mapped(&self, bytes: &[u8]) -> Result<(), GpuError> {
        let pointer = self.0.allocation.as_ref().and_then(|a| a.mapped_ptr()).ok_or_else(|| self.not_mapped())?;
        let bytes = &bytes[..bytes.len().min(self.size as usize)];
        // SAFETY: the mapping holds `size` bytes, and no more are copied; and no submission that reads them is under way, since
        // every submission is waited for.
        unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), pointer.as_ptr().cast(), bytes.len()) };
        Ok(())
    }

    fn not_mapped(&self) -> GpuError {
        GpuError::Unsuitable {
            device: self.device.info.name.clone(),
            reason: format!("its memory for {} cannot be mapped", self.name),
        }
    }

    /// The buffer's address on the device; only for buffers made with that usage.
    pub(crate) fn address(&self) -> vk::DeviceAddress {
        let info = vk::BufferDeviceAddressInfo::default().buffer(self.0.raw);
        // SAFETY: called only where ray queries, and so buffer addresses, are enabled.
        unsafe { self.device.raw.get_buffer_device_address(&info) }
    }
}

impl Drop for BufferInner {
    fn drop(&mut self) {
        // SAFETY: submissions are waited for, and a recorder holds its buffers until then.
        unsafe { self.device.raw.destroy_buffer(self.raw, None) };
        free(&self.device, self.allocation.take());
    }
}

/// A colour or depth target that can be copied to a buffer; always in the layout GENERAL once it was drawn to.
#[derive(Clone)]
pub struct Image(Arc<ImageInner>);

pub struct ImageInner {
    pub(crate) raw: vk::Image,
    pub(crate) view: vk::ImageView,
    pub(crate) format: vk::Format,
    pub(crate) extent: vk::Extent2D,
    device: Device,
    allocation: Option<Allocation>,
}

impl std::ops::Deref for Image {
    type Target = ImageInner;
    fn deref(&self) -> &ImageInner {
        &self.0
    }
}

impl Image {
    pub(crate) fn target(
        device: &Device,
        name: &str,
        format: vk::Format,
        width: u32,
        height: u32,
    ) -> Result<Image, GpuError> {
        let usage = match format {
            vk::Format::D32_SFLOAT => vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT,
            _ => vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC,
        };
        Self::with_usage(device, name, format, usage, width, height)
    }

    /// One unsigned integer a pixel, for kernels to read, write and count in; all zero.
    pub fn counters(device: &Device, name: &str, width: u32, height: u32) -> Result<Image, GpuError> {
        let usage =
            vk::ImageUsageFlags::STORAGE | vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST;
        let image = Self::with_usage(device, name, vk::Format::R32_UINT, usage, width, height)?;
        let mut recorder = Recorder::new(device)?;
        recorder.pass("memory/clear")?.clear_image(&image);
        recorder.submit()?;
        Ok(image)
    }

    /// Reads `count` items of as many bytes as a pixel has, row after row, and waits for them. Colour alone.
    pub fn read<T: bytemuck::Pod>(&self, count: usize) -> Result<Vec<T>, GpuError> {
        let bytes = (count * size_of::<T>()) as u64;
        let buffer = Buffer::new(&self.device, "picture", bytes)?;
        let mut recorder = Recorder::new(&self.device)?;
        recorder.pass("memory/readback")?.copy_image(self, &buffer, 0);
        recorder.submit()?;
        buffer.read(count)
    }

    fn with_usage(
        device: &Device,
        name: &str,
        format: vk::Format,
        usage: vk::ImageUsageFlags,
        width: u32,
        height: u32,
    ) -> Result<Image, GpuError> {
        let aspect = match format {
            vk::Format::D32_SFLOAT => vk::ImageAspectFlags::DEPTH,
            _ => vk::ImageAspectFlags::COLOR,
        };
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D { width, height, depth: 1 })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(usage);
        // SAFETY: a plain two-dimensional image; the frame asks for no larger one than the device allows.
        let raw = unsafe { device.raw.create_image(&info, None) }.call("vkCreateImage")?;
        let mut image = ImageInner {
            raw,
            view: vk::ImageView::null(),
            format,
            extent: vk::Extent2D { width, height },
            device: device.clone(),
            allocation: None,
        };
        // SAFETY: the image was just created by this device.
        let requirements = unsafe { device.raw.get_image_memory_requirements(raw) };
        image.allocation = Some(allocate(device, name, requirements, MemoryLocation::GpuOnly, false)?);
        if let Some(allocation) = &image.allocation {
            // SAFETY: memory of the type and size the image asked for, bound once.
            unsafe { device.raw.bind_image_memory(raw, allocation.memory(), allocation.offset()) }
                .call("vkBindImageMemory")?;
        }
        let range =
            vk::ImageSubresourceRange { aspect_mask: aspect, level_count: 1, layer_count: 1, ..Default::default() };
        let view = vk::ImageViewCreateInfo::default()
            .image(raw)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(format)
            .subresource_range(range);
        // SAFETY: the whole of an image that has its memory.
        image.view = unsafe { device.raw.create_image_view(&view, None) }.call("vkCreateImageView")?;
        device.set_name(raw, name);
        Ok(Image(Arc::new(image)))
    }
}

impl Drop for ImageInner {
    fn drop(&mut self) {
        // SAFETY: submissions are waited for, and a recorder holds its images until then.
        unsafe {
            self.device.raw.destroy_image_view(self.view, None);
            self.device.raw.destroy_image(self.raw, None);
        }
        free(&self.device, self.allocation.take());
    }
}

impl Pass<'_> {
    /// Makes a new image usable in the layout GENERAL, with zeros.
    fn clear_image(&mut self, image: &Image) -> &mut Self {
        self.hold(image);
        let range = vk::ImageSubresourceRange {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            level_count: 1,
            layer_count: 1,
            ..Default::default()
        };
        let (raw, commands) = (&self.device().raw, self.commands());
        let general = super::raster::to_general(image, vk::ImageAspectFlags::COLOR);
        let all = vk::PipelineStageFlags::ALL_COMMANDS;
        // SAFETY: a colour image made for transfers; its old content is discarded, and zeros fit every format.
        unsafe {
            raw.cmd_pipeline_barrier(commands, all, all, vk::DependencyFlags::empty(), &[], &[], &[general]);
            let zero = vk::ClearColorValue { uint32: [0; 4] };
            raw.cmd_clear_color_image(commands, image.raw, vk::ImageLayout::GENERAL, &zero, &[range]);
        }
        self
    }

    /// Copies a colour image, row after row without gaps, to byte `offset` of a buffer.
    pub(crate) fn copy_image(&mut self, from: &Image, to: &Buffer, offset: u64) -> &mut Self {
        self.hold(to);
        self.hold(from);
        let region = vk::BufferImageCopy::default()
            .buffer_offset(offset)
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: vk::ImageAspectFlags::COLOR,
                layer_count: 1,
                ..Default::default()
            })
            .image_extent(vk::Extent3D { width: from.extent.width, height: from.extent.height, depth: 1 });
        // SAFETY: the image is in GENERAL since it was drawn to or cleared; the buffer holds the whole of it from `offset` on.
        unsafe {
            self.device().raw.cmd_copy_image_to_buffer(
                self.commands(),
                from.raw,
                vk::ImageLayout::GENERAL,
                to.raw,
                &[region],
            );
        }
        self
    }
}

fn allocate(
    device: &Device,
    name: &str,
    requirements: vk::MemoryRequirements,
    location: MemoryLocation,
    linear: bool,
) -> Result<Allocation, GpuError> {
    let out_of_memory = || GpuError::OutOfMemory {
        device: device.info.name.clone(),
        what: name.to_string(),
        bytes: requirements.size,
        held: device.held_memory(),
    };
    let mut allocator = device.allocator.lock().map_err(|_| out_of_memory())?;
    let allocation = allocator
        .allocate(&AllocationCreateDesc {
            name,
            requirements,
            location,
            linear,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        })
        .map_err(|_| out_of_memory())?;
    device.count_allocated(allocation.size());
    Ok(allocation)
}

fn free(device: &Device, allocation: Option<Allocation>) {
    if let (Some(allocation), Ok(mut allocator)) = (allocation, device.allocator.lock()) {
        device.count_freed(allocation.size());
        // Freeing fails only for memory of another allocator.
        let _ = allocator.free(allocation);
    }
}
