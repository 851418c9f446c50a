//! A raster pipeline with vertices pulled from buffers, drawn by dynamic rendering.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use ash::vk;

use super::error::Call;
use super::pipeline::{Module, Pipeline, PipelineLayout, PipelineSlot, module_words};
use super::reflect::{Interface, reflect};
#[cfg(feature = "hot-reload")]
use super::reload::{ModuleName, Reloadable};
use super::{Bindings, Buffer, Device, GpuError, Image, Pass};

/// The stages of a raster pipeline by their kernels' names.
#[derive(Debug, Clone, Copy)]
pub struct RasterStages<'a> {
    pub vertex: &'a str,
    /// Takes points and makes triangles of them.
    pub geometry: Option<&'a str>,
    pub fragment: &'a str,
    /// The tracing back-end's, of the fragment stage; empty where that traces no rays.
    pub variant: &'a str,
}

impl RasterStages<'_> {
    /// Name, stage and variant of each module.
    fn modules(&self) -> Vec<(&str, &'static str, &str)> {
        let geometry = self.geometry.map(|name| (name, "geom", ""));
        [Some((self.vertex, "vert", "")), geometry, Some((self.fragment, "frag", self.variant))]
            .into_iter()
            .flatten()
            .collect()
    }
}

/// What becomes of a pixel that several triangles cover.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Mixing {
    /// The nearest wins. Nearer is larger in depth (reversed, infinite far plane).
    Nearest,
    /// Values add up, of triangles seen from behind: a convex volume covers each pixel once, wherever the camera is.
    SumOfBacks,
    /// The last wins.
    Last,
}

/// What a pipeline is made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct State {
    color: vk::Format,
    /// `UNDEFINED` for none.
    depth: vk::Format,
    mixing: Mixing,
    points: bool,
}

/// A vertex, perhaps a geometry, and a fragment stage. Clones share it, and so do all of the same stages on a device.
#[derive(Clone)]
pub struct Raster {
    inner: Arc<RasterInner>,
    // Keeps the pipeline's device open.
    _device: Device,
}

/// Names, stages and variants of the modules, and what the pipeline is made for.
type MadeKey = (Vec<(String, &'static str, String)>, State);

/// The raster pipelines that a device has made; they live as long as it.
#[derive(Default)]
pub(crate) struct MadeRasters(Mutex<HashMap<MadeKey, Arc<RasterInner>>>);

impl MadeRasters {
    fn lock(&self) -> MutexGuard<'_, HashMap<MadeKey, Arc<RasterInner>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Destroys them all; the device is about to be closed.
    pub(crate) fn clear(&self) {
        self.lock().clear();
    }
}

pub(crate) struct RasterInner {
    name: String,
    layout: Arc<PipelineLayout>,
    pipeline: PipelineSlot,
    /// What a new pipeline has to fit.
    #[cfg(feature = "hot-reload")]
    state: State,
    #[cfg(feature = "hot-reload")]
    modules: Vec<ModuleName>,
}

/// What a pixel of a [plain](RasterTargets::plain) target holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Plain {
    /// Two unsigned integers.
    Ids,
    /// Four 32-bit floats.
    Floats,
    /// Four 16-bit floats.
    Halves,
    /// Four bytes that stand for 0 to 1.
    Display,
}

/// What is drawn into: one colour target, and its depth where the nearest wins.
#[derive(Clone)]
pub struct RasterTargets {
    pub color: Image,
    depth: Option<Image>,
    mixing: Mixing,
}

impl RasterTargets {
    /// Two unsigned integers a pixel.
    pub fn ids(device: &Device, name: &str, width: u32, height: u32) -> Result<Self, GpuError> {
        let depth = Image::target(device, &format!("{name} depth"), vk::Format::D32_SFLOAT, width, height)?;
        Ok(RasterTargets {
            color: Image::target(device, name, vk::Format::R32G32_UINT, width, height)?,
            depth: Some(depth),
            mixing: Mixing::Nearest,
        })
    }

    /// Four floats a pixel, which add up. Only where [`Limits::float_sums`](super::Limits::float_sums) says so.
    pub fn sums(device: &Device, name: &str, width: u32, height: u32) -> Result<Self, GpuError> {
        let color = Image::target(device, name, vk::Format::R32G32B32A32_SFLOAT, width, height)?;
        Ok(RasterTargets { color, depth: None, mixing: Mixing::SumOfBacks })
    }

    /// Four 16-bit floats a pixel, which add up. Every device has these.
    pub fn half_sums(device: &Device, name: &str, width: u32, height: u32) -> Result<Self, GpuError> {
        let color = Image::target(device, name, vk::Format::R16G16B16A16_SFLOAT, width, height)?;
        Ok(RasterTargets { color, depth: None, mixing: Mixing::SumOfBacks })
    }

    /// What is drawn last, unmixed.
    pub fn plain(device: &Device, name: &str, format: Plain, width: u32, height: u32) -> Result<Self, GpuError> {
        let format = match format {
            Plain::Ids => vk::Format::R32G32_UINT,
            Plain::Floats => vk::Format::R32G32B32A32_SFLOAT,
            Plain::Halves => vk::Format::R16G16B16A16_SFLOAT,
            Plain::Display => vk::Format::R8G8B8A8_UNORM,
        };
        let color = Image::target(device, name, format, width, height)?;
        Ok(RasterTargets { color, depth: None, mixing: Mixing::Last })
    }

    fn state(&self, points: bool) -> State {
        State {
            color: self.color.format,
            depth: self.depth.as_ref().map_or(vk::Format::UNDEFINED, |depth| depth.format),
            mixing: self.mixing,
            points,
        }
    }
}

impl Raster {
    /// The pipeline of `<name>.vert.glsl` and `<name>.frag.glsl` for targets like `targets`.
    pub fn new(device: &Device, name: &str, targets: &RasterTargets) -> Result<Self, GpuError> {
        Self::of_stages(device, &RasterStages { vertex: name, geometry: None, fragment: name, variant: "" }, targets)
    }

    /// The pipeline of these stages for targets like `targets`; its name is the fragment stage's.
    pub fn of_stages(device: &Device, stages: &RasterStages<'_>, targets: &RasterTargets) -> Result<Self, GpuError> {
        let state = targets.state(stages.geometry.is_some());
        let owned = |(name, stage, variant): (&str, &'static str, &str)| (name.to_string(), stage, variant.to_string());
        let key: MadeKey = (stages.modules().into_iter().map(owned).collect(), state);
        let made = device.made_rasters.lock().get(&key).cloned();
        let inner = match made {
            Some(inner) => inner,
            // Not under the lock: others need not wait while this one compiles.
            None => {
                let inner = make(device, stages, state)?;
                device.made_rasters.lock().entry(key).or_insert(inner).clone()
            }
        };
        Ok(Raster { inner, _device: device.clone() })
    }
}

fn make(device: &Device, stages: &RasterStages<'_>, state: State) -> Result<Arc<RasterInner>, GpuError> {
    let name = stages.fragment;
    let error = |reason| GpuError::Kernel { kernel: name.to_string(), reason };
    let modules = stages.modules();
    let words: Vec<Vec<u32>> =
        modules.iter().map(|&(name, stage, variant)| module_words(name, stage, variant)).collect::<Result<_, _>>()?;
    let interfaces: Vec<Interface> =
        words.iter().map(|words| reflect(words).map_err(error)).collect::<Result<_, _>>()?;
    let flags = modules.iter().fold(vk::ShaderStageFlags::empty(), |all, (_, stage, _)| all | stage_flag(stage));
    let layout = Arc::new(PipelineLayout::new(device, name, &interfaces.iter().collect::<Vec<_>>(), flags)?);
    let inner = Arc::new(RasterInner {
        name: name.to_string(),
        pipeline: PipelineSlot::new(pipeline(device, name, &layout, state, &words)?),
        layout,
        #[cfg(feature = "hot-reload")]
        state,
        #[cfg(feature = "hot-reload")]
        modules: modules.iter().map(|&(name, stage, variant)| ModuleName::new(name, stage, variant)).collect(),
    });
    #[cfg(feature = "hot-reload")]
    super::reload::register(device, inner.clone())?;
    Ok(inner)
}

fn stage_flag(stage: &str) -> vk::ShaderStageFlags {
    match stage {
        "vert" => vk::ShaderStageFlags::VERTEX,
        "geom" => vk::ShaderStageFlags::GEOMETRY,
        _ => vk::ShaderStageFlags::FRAGMENT,
    }
}

/// `words` are those of the vertex, perhaps the geometry, and the fragment stage.
fn pipeline(
    device: &Device,
    name: &str,
    layout: &Arc<PipelineLayout>,
    state: State,
    words: &[Vec<u32>],
) -> Result<Pipeline, GpuError> {
    let names: &[&str] = if words.len() == 3 { &["vert", "geom", "frag"] } else { &["vert", "frag"] };
    let modules = words.iter().map(|words| Module::new(device, words)).collect::<Result<Vec<_>, _>>()?;
    let stages: Vec<_> = names
        .iter()
        .zip(&modules)
        .map(|(stage, module)| {
            vk::PipelineShaderStageCreateInfo::default().stage(stage_flag(stage)).module(module.raw).name(c"main")
        })
        .collect();
    let (nearest, sums) = (state.mixing == Mixing::Nearest, state.mixing == Mixing::SumOfBacks);
    let vertex_input = vk::PipelineVertexInputStateCreateInfo::default();
    let topology = if state.points { vk::PrimitiveTopology::POINT_LIST } else { vk::PrimitiveTopology::TRIANGLE_LIST };
    let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(topology);
    let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
    let rasterisation = vk::PipelineRasterizationStateCreateInfo::default()
        .polygon_mode(vk::PolygonMode::FILL)
        .cull_mode(if sums { vk::CullModeFlags::FRONT } else { vk::CullModeFlags::NONE })
        .front_face(vk::FrontFace::COUNTER_CLOCKWISE)
        .line_width(1.0);
    let samples = vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
    let depth = vk::PipelineDepthStencilStateCreateInfo::default()
        .depth_test_enable(nearest)
        .depth_write_enable(nearest)
        .depth_compare_op(vk::CompareOp::GREATER);
    let attachment = [vk::PipelineColorBlendAttachmentState::default()
        .blend_enable(sums)
        .src_color_blend_factor(vk::BlendFactor::ONE)
        .dst_color_blend_factor(vk::BlendFactor::ONE)
        .src_alpha_blend_factor(vk::BlendFactor::ONE)
        .dst_alpha_blend_factor(vk::BlendFactor::ONE)
        .color_write_mask(vk::ColorComponentFlags::RGBA)];
    let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&attachment);
    let dynamic = vk::PipelineDynamicStateCreateInfo::default()
        .dynamic_states(&[vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR]);
    let colors = [state.color];
    let mut rendering = vk::PipelineRenderingCreateInfo::default()
        .color_attachment_formats(&colors)
        .depth_attachment_format(state.depth);
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
        let pipeline = pipeline(device, &self.name, &self.layout, self.state, modules)?;
        self.pipeline.replace(pipeline);
        Ok(())
    }
}

/// What a draw takes its number of vertices from.
enum Vertices<'a, P> {
    /// For each item its push constants and its number of vertices.
    Items(&'a [(P, u32)]),
    /// Push constants, and the arguments of one indirect draw.
    Indirect(&'a P, &'a Buffer),
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
        self.draw_vertices(raster, targets, bindings, Vertices::Items(items))
    }

    /// Clears the targets to zero and draws what the four u32 at the start of `arguments` say: vertices, instances, first
    /// vertex, first instance.
    pub fn draw_indirect<P: bytemuck::NoUninit>(
        &mut self,
        raster: &Raster,
        targets: &RasterTargets,
        bindings: &[&Bindings],
        push: &P,
        arguments: &Buffer,
    ) -> Result<&mut Self, GpuError> {
        self.hold(arguments);
        self.draw_vertices(raster, targets, bindings, Vertices::Indirect(push, arguments))
    }

    fn draw_vertices<P: bytemuck::NoUninit>(
        &mut self,
        raster: &Raster,
        targets: &RasterTargets,
        bindings: &[&Bindings],
        what: Vertices<'_, P>,
    ) -> Result<&mut Self, GpuError> {
        let inner = &raster.inner;
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
        let depth = targets.depth.as_ref().map(attachment);
        let mut info = vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&colors);
        if let Some(depth) = &depth {
            info = info.depth_attachment(depth);
        }
        let color = to_general(&targets.color, vk::ImageAspectFlags::COLOR);
        let layouts: Vec<_> = std::iter::once(color)
            .chain(targets.depth.iter().map(|depth| to_general(depth, vk::ImageAspectFlags::DEPTH)))
            .collect();
        let push_constants = |push: &P| {
            let bytes = bytemuck::bytes_of(push);
            // SAFETY: the bytes are as many as the layout has, which its sets were checked for.
            unsafe {
                device.raw.cmd_push_constants(commands, pipeline.layout.raw, pipeline.layout.stages, 0, bytes);
            }
        };
        // SAFETY: targets and pipeline agree in their formats; all is held until the commands have run. The transition
        // discards the old content, which the clear replaces. Buffers are made for indirect use, and have 16 bytes.
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
            match what {
                Vertices::Items(items) => {
                    for (push, vertices) in items {
                        push_constants(push);
                        device.raw.cmd_draw(commands, *vertices, 1, 0, 0);
                    }
                }
                Vertices::Indirect(push, arguments) => {
                    push_constants(push);
                    device.raw.cmd_draw_indirect(commands, arguments.raw, 0, 1, 16);
                }
            }
            rendering.cmd_end_rendering(commands);
        }
        Ok(self)
    }
}

pub(super) fn to_general(image: &Image, aspect: vk::ImageAspectFlags) -> vk::ImageMemoryBarrier<'static> {
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
