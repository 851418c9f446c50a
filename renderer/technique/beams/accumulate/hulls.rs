//! Beams drawn by a rasteriser: hulls whose back faces cover each pixel once, and values that add up. They serve what the
//! camera sees straight, without a specular surface on the way; tiles serve the rest.

use super::options::{Bounds, Options, Tier};
use super::{BeamBuffers, ShadePush, VolumePush};
use crate::frame::Frame;
use crate::gpu::{
    Bindings, Buffer, Capability, Device, GpuError, GpuStruct as _, Kernel, Raster, RasterStages, RasterTargets,
    Recorder,
};
use crate::technique::Context;
use crate::technique::beams::kernels::by_media;

crate::gpu_struct! {
    /// A convex volume round a beam; see `kernels/technique/beams/hull.glsl`.
    pub struct Hull {
        pub corner0: [f32; 3],
        pub faces: u32,
        pub corner1: [f32; 3],
        pub padding0: u32,
        pub corner2: [f32; 3],
        pub padding1: u32,
        pub corner3: [f32; 3],
        pub padding2: u32,
        pub corner4: [f32; 3],
        pub padding3: u32,
        pub corner5: [f32; 3],
        pub padding4: u32,
    }
}

crate::gpu_struct! {
    pub struct ExtrudePush {
        pub capacity: u32,
        pub prism: u32,
        pub points: u32,
        pub padding0: u32,
    }
}

crate::gpu_struct! {
    /// What all stages of the drawing of hulls are told.
    pub struct HullPush {
        pub jitter: [f32; 2],
        pub prism: u32,
        pub padding0: u32,
        pub shade: ShadePush,
        pub volume: VolumePush,
    }
}

/// Bytes of a pixel's sum.
const SUM_BYTES: u64 = 16;

/// What one kind of light is drawn with.
struct Layer {
    raster: Raster,
    targets: RasterTargets,
    /// The target's pixels, for kernels.
    sums: Buffer,
}

pub struct Hulls {
    tier: Tier,
    extrude: Kernel,
    push: ExtrudePush,
    pushes: (ShadePush, VolumePush),
    bindings: Bindings,
    draws: Buffer,
    /// Where points are lit, not what pixels cover.
    surface: Option<Layer>,
    volume: Option<Layer>,
}

impl Hulls {
    /// `None` where tiles find the beams: if the options say so, or because the device or the frame has no use for hulls.
    pub fn new(
        options: &Options,
        context: &Context<'_>,
        beams: &BeamBuffers,
        pushes: (ShadePush, VolumePush),
    ) -> Result<Option<Self>, GpuError> {
        let device = context.device;
        let Some(tier) = tier(options, context) else { return Ok(None) };
        let points = tier == Tier::Geometry;
        let (width, rows) = context.frame.film.size();
        let layer = |fragment: &str| -> Result<Layer, GpuError> {
            let targets = RasterTargets::sums(device, fragment, width, rows)?;
            let stages = RasterStages {
                vertex: if points { "beams/hull_points" } else { "beams/hull" },
                geometry: points.then_some("beams/hull_points"),
                fragment,
                variant: context.tracer.backend.module(),
            };
            let sums = Buffer::new(device, fragment, u64::from(width) * u64::from(rows) * SUM_BYTES)?;
            Ok(Layer { raster: Raster::of_stages(device, &stages, &targets)?, targets, sums })
        };
        let surface_name = by_media(context, ["beams/light", "beams/light_grids"]);
        let volume_name = by_media(context, ["beams/light_volume", "beams/light_volume_grids"]);
        let hulls = if points { 0 } else { u64::from(beams.capacity) * Hull::LAYOUT.size as u64 };
        let draws = Buffer::new(device, "hull draws", 16)?;
        let push = ExtrudePush {
            capacity: beams.capacity,
            prism: u32::from(options.bounds == Bounds::Prism),
            points: u32::from(points),
            padding0: 0,
        };
        Ok(Some(Hulls {
            tier,
            extrude: Kernel::new(device, "beams/extrude", "")?,
            push,
            pushes,
            bindings: Bindings::new()
                .buffer("Hulls", &Buffer::new(device, "hulls", hulls)?)
                .buffer("HullDraws", &draws),
            draws,
            surface: (!options.footprints).then(|| layer(surface_name)).transpose()?,
            volume: context.frame.film.has_volume().then(|| layer(volume_name)).transpose()?,
        }))
    }

    pub fn tier(&self) -> Tier {
        self.tier
    }

    /// Draws all beams for the frame's last sample.
    pub fn record(&self, frame: &Frame, recorder: &mut Recorder, bindings: &[&Bindings]) -> Result<(), GpuError> {
        let all: Vec<&Bindings> = bindings.iter().copied().chain([&self.bindings]).collect();
        let count = if self.tier == Tier::Geometry { 1 } else { self.push.capacity };
        recorder.pass("beams/extrude")?.dispatch(&self.extrude, &all, &self.push, count)?;
        let (shade, volume) = self.pushes;
        let push = HullPush { jitter: frame.jitter(), prism: self.push.prism, padding0: 0, shade, volume };
        for (name, layer) in [("beams/light", self.surface.as_ref()), ("beams/light_volume", self.volume.as_ref())] {
            let Some(layer) = layer else { continue };
            recorder.pass(name)?.draw_indirect(&layer.raster, &layer.targets, &all, &push, &self.draws)?;
            recorder.pass("beams/light-copy")?.copy_image(&layer.targets.color, &layer.sums, 0);
        }
        Ok(())
    }
}

/// What to draw with, if at all.
fn tier(options: &Options, context: &Context<'_>) -> Option<Tier> {
    let device = context.device;
    let (width, rows) = context.frame.film.size();
    let fits = width.max(rows) <= device.info.limits.target_side && device.info.limits.float_sums;
    // Adaptive samples each have a pixel and a place of their own, and a projection shifts as a whole.
    let draws = fits && device.has(Capability::Graphics) && context.frame.adaptive().is_none();
    match options.tier {
        Some(Tier::Geometry) if draws && device.has(Capability::GeometryShader) => Some(Tier::Geometry),
        Some(Tier::Geometry | Tier::Vertices) if draws => Some(Tier::Vertices),
        _ => None,
    }
}

/// Where kernels find what was drawn.
pub fn drawn_bindings(device: &Device, hulls: Option<&Hulls>) -> Result<Bindings, GpuError> {
    let none = Buffer::new(device, "nothing drawn", SUM_BYTES)?;
    let surface = hulls.and_then(|hulls| hulls.surface.as_ref()).map_or(&none, |layer| &layer.sums);
    let volume = hulls.and_then(|hulls| hulls.volume.as_ref()).map_or(&none, |layer| &layer.sums);
    Ok(Bindings::new().buffer("DrawnIrradiance", surface).buffer("DrawnVolume", volume))
}
