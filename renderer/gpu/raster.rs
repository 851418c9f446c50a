//! A raster pipeline with vertices pulled from buffers, drawn by dynamic rendering.

use std::sync::Arc;

use ash::vk;

use super::error::Call;
use super::pipeline::{Module, Pipeline, PipelineLayout, PipelineSlot, module_words};
use super::reflect::reflect;
#[cfg(feature = "hot-reload")]
use super::reload::{ModuleName, Reloadable};
use super::{Bindings, Device, GpuError, Image, Pass};

/// A vertex and a fragment stage of one name. Nearer is larger in depth (reversed, infinite far plane). Clones share it.
#[derive(Clone)]
pub struct Raster(Arc<RasterInner>);

pub(crate) struct RasterInner {
    name: String,
    layout: Arc<PipelineLayout>,
    pipeline: PipelineSlot,
    /// What a new pipeline has to fit.
    #[cfg(feature = "hot-reload")]
    formats: [vk::Format; 2],
    #[cfg(feature = "hot-reload")]
    modules: [ModuleName; 2],
    // Keeps the pipeline's device open, and is dropped after it: fields go in their order.
    _device: Device,
}

/// What is drawn into: one colour target and its depth.
#[derive(Clone)]
pub struct RasterTargets {
    pub color: Image,
    depth: Image,
}

impl RasterTargets {
    /// Two unsigned integers a pixel.
    pub fn ids(device: &Device, name: &str, width: u32, height: u32) -> Result<Self, GpuError> {
        Ok(RasterTargets {
            color: Image::target(device, name, vk::Format::R32G32_UINT, width, height)?,
            depth: Image::target(device, &format!("{name} depth"), vk::Format::D32_SFLOAT, width, height)?,
        })
    }
}

impl Raster {
    /// The pipeline of `<name>.vert.glsl` and `<name>.frag.glsl` for targets like `targets`.
    pub fn new(device: &Device, name: &str, targets: &RasterTargets) -> Result<Self, GpuError> {
        let error = |reason| GpuError::Kernel { kernel: name.to_string(), reason };
        let (vertex, fragment) = (module_words(name, "vert", "")?, module_words(name, "frag", "")?);
        let interfaces = [reflect(&vertex).map_err(error)?, reflect(&fragment).map_err(error)?];
        let stages = vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT;
        let layout = Arc::new(PipelineLayout::new(device, name, &[&interfaces[0], &interfaces[1]], stages)?);
        let formats = [targets.color.format, targets.depth.format];
        let inner = Arc::new(RasterInner {
            name: name.to_string(),
            pipeline: PipelineSlot::new(pipeline(device, name, &layout, formats, [&vertex, &fragment])?),
            layout,
            #[cfg(feature = "hot-reload")]
            formats,
            #[cfg(feature = "hot-reload")]
            modules: ["vert", "frag"].map(|stage| ModuleName::new(name, stage, "")),
            _device: device.clone(),
        });
        #[cfg(feature = "hot-reload")]
        super::reload::register(device, inner.clone())?;
        Ok(Raster(inner))
    }
}

/// `formats` are the colour's and the depth's, the words those of the vertex and the fragment stage.
fn pipeline(
    device: &Device,
    name: &str,
    layout: &Arc<PipelineLayout>,
    [color, depth_format]: [vk::Format; 2],
    [vertex, fragment]: [&[u32]; 2],
) -> Result<Pipeline, GpuError> {
    let (vertex, fragment) = (Module::new(device, vertex)?, Module::new(device, fragment)?);
    let stage = |stage, module: &Module| {
        vk::PipelineShaderStageCreateInfo::default().stage(stage).module(module.raw).name(c"main")
    };
    let stages = [stage(vk::ShaderStageFlags::VERTEX, &vertex), stage(vk::ShaderStageFlags::FRAGMENT, &fragment)];
    let vertex_input = vk::PipelineVertexInputStateCreateInfo::default();
    let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(vk::PrimitiveTopology::TRIANGLE_LIST);
    let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
    let rasterisation = vk::PipelineRasterizationStateCreateInfo::default()
        .polygon_mode(vk::PolygonMode::FILL)
        .cull_mode(vk::CullModeFlags::NONE)
        .line_width(1.0);
    let samples = vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
    let depth = vk::PipelineDepthStencilStateCreateInfo::default()
        .depth_test_enable(true)
        .depth_write_enable(true)
        .depth_compare_op(vk::CompareOp::GREATER);
    let attachment = [vk::PipelineColorBlendAttachmentState::default().color_write_mask(vk::ColorComponentFlags::RGBA)];
    let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&attachment);
    let dynamic = vk::PipelineDynamicStateCreateInfo::default()
        .dynamic_states(&[vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR]);
    let colors = [color];
    let mut rendering = vk::PipelineRenderingCreateInfo::default()
        .color_attachment_formats(&colors)
        .depth_attachment_format(depth_format);
    let info = vk::GraphicsPipelineCreateInfo::default()
        .stages(&stages)
        .vertex_input_state(&vertex_input)
        .input_assembly_state(&assembly)
        .viewport_state(&viewport)
        .rasterization_state(&rasterisation)
        .multisample_state(&samples)
        .depth_stencil_state(&depth)
        .color_blend_state(&blend)
        .dynamic_state(&dynamic)
        .layout(layout.raw)
        .push_next(&mut rendering);
    // SAFETY: every state points to a local that outlives the call.
    let pipelines = unsafe { device.raw.create_graphics_pipelines(vk::PipelineCache::null(), &[info], None) };
    let raw = pipelines.map_err(|(_, result)| result).call("vkCreateGraphicsPipelines")?[0];
    Ok(Pipeline::new(device, raw, layout, name))
}

#[cfg(feature = "hot-reload")]
impl Reloadable for RasterInner {
    fn modules(&self) -> &[ModuleName] {
        &self.modules
    }

    fn reload(&self, device: &Device, modules: &[Vec<u32>]) -> Result<(), GpuError> {
        if let [vertex, fragment] = modules {
            let pipeline = pipeline(device, &self.name, &self.layout, self.formats, [vertex, fragment])?;
            self.pipeline.replace(pipeline);
        }
        Ok(())
    }
}

impl Pass<'_> {
    /// Clears the targets to zero and draws: for each item its push constants and its number of vertices.
    pub fn draw<P: bytemuck::NoUninit>(
        &mut self,
        raster: &Raster,
        targets: &RasterTargets,
        bindings: &[&Bindings],
        items: &[(P, u32)],
    ) -> Result<&mut Self, GpuError> {
        let inner = &raster.0;
        let sets = self.descriptors().sets(&inner.name, &inner.layout, bindings, size_of::<P>())?;
        let pipeline = inner.pipeline.get();
        self.hold(&pipeline);
        self.hold(targets);
        bindings.iter().for_each(|b| self.hold(*b));
        let device = self.device().clone();
        let commands = self.commands();
        let Some(rendering) = &device.rendering else {
            return Err(GpuError::Kernel {
                kernel: inner.name.clone(),
                reason: "it needs graphics, and this device is used without".to_string(),
            });
        };
        let extent = targets.color.extent;
        let area = vk::Rect2D { extent, ..Default::default() };
        let viewport = vk::Viewport {
            width: extent.width as f32,
            height: extent.height as f32,
            max_depth: 1.0,
            ..Default::default()
        };
        let attachment = |image: &Image| {
            vk::RenderingAttachmentInfo::default()
                .image_view(image.view)
                .image_layout(vk::ImageLayout::GENERAL)
                .load_op(vk::AttachmentLoadOp::CLEAR)
                .store_op(vk::AttachmentStoreOp::STORE)
        };
        let colors = [attachment(&targets.color)];
        let depth = attachment(&targets.depth);
        let info = vk::RenderingInfo::default()
            .render_area(area)
            .layer_count(1)
            .color_attachments(&colors)
            .depth_attachment(&depth);
        let layouts = [
            to_general(&targets.color, vk::ImageAspectFlags::COLOR),
            to_general(&targets.depth, vk::ImageAspectFlags::DEPTH),
        ];
        // SAFETY: targets and pipeline agree in their formats; all is held until the commands have run. The transition
        // discards the old content, which the clear replaces.
        unsafe {
            device.raw.cmd_pipeline_barrier(
                commands,
                vk::PipelineStageFlags::ALL_COMMANDS,
                vk::PipelineStageFlags::ALL_COMMANDS,
                vk::DependencyFlags::empty(),
                &[],
                &[],
                &layouts,
            );
            rendering.cmd_begin_rendering(commands, &info);
            device.raw.cmd_set_viewport(commands, 0, &[viewport]);
            device.raw.cmd_set_scissor(commands, 0, &[area]);
            device.raw.cmd_bind_pipeline(commands, vk::PipelineBindPoint::GRAPHICS, pipeline.raw);
            if !sets.is_empty() {
                let point = vk::PipelineBindPoint::GRAPHICS;
                device.raw.cmd_bind_descriptor_sets(commands, point, pipeline.layout.raw, 0, &sets, &[]);
            }
            for (push, vertices) in items {
                let bytes = bytemuck::bytes_of(push);
                device.raw.cmd_push_constants(commands, pipeline.layout.raw, pipeline.layout.stages, 0, bytes);
                device.raw.cmd_draw(commands, *vertices, 1, 0, 0);
            }
            rendering.cmd_end_rendering(commands);
        }
        Ok(self)
    }
}

fn to_general(image: &Image, aspect: vk::ImageAspectFlags) -> vk::ImageMemoryBarrier<'static> {
    vk::ImageMemoryBarrier::default()
        .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
        .dst_access_mask(vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE)
        .old_layout(vk::ImageLayout::UNDEFINED)
        .new_layout(vk::ImageLayout::GENERAL)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .image(image.raw)
        .subresource_range(vk::ImageSubresourceRange {
            aspect_mask: aspect,
            level_count: 1,
            layer_count: 1,
            ..Default::default()
        })
}
