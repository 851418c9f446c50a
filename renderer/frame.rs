//! One frame, top to bottom: visibility -> walk to the visible diffuse points -> direct light. What the technique adds
//! comes after, and `film` composes.

use crate::film::Film;
use crate::gpu::{Bindings, Buffer, Capability, Device, GpuError, Kernel, Raster, RasterTargets, Recorder};
use crate::gpu_scene::GpuScene;
use crate::random;
use crate::trace::Tracer;
use crate::view::{Band, View};

crate::gpu_struct! {
    /// One visible diffuse point; see `kernels/shared/visible.glsl`.
    pub struct VisiblePoint {
        pub position: [f32; 3],
        pub instance: u32,
        pub normal: u32,
        pub geometric: u32,
        pub footprint: f32,
        pub medium: u32,
    }
}

crate::gpu_struct! {
    /// What a visible point's radiance becomes on its way to the camera.
    pub struct VisibleShade {
        pub throughput: [f32; 3],
        pub distance: f32,
        pub albedo: [f32; 3],
        pub events: u32,
    }
}

crate::gpu_struct! {
    /// What changes from sample to sample.
    pub struct Sample {
        pub jitter: [f32; 2],
        pub index: u32,
        pub padding0: u32,
    }
}

crate::gpu_struct! {
    /// Push constants of one instance's draw.
    pub struct DrawPush {
        pub jitter: [f32; 2],
        pub instance: u32,
        pub padding0: u32,
    }
}

/// How the first surface of each pixel is found.
enum Visibility {
    Raster { raster: Raster, targets: RasterTargets },
    Rays { primary: Kernel },
}

/// The shared part of every frame, for one band of rows.
pub struct Frame {
    /// Scene, tracer, view, visible points and film: what a technique's kernels see.
    pub bindings: Bindings,
    pub film: Film,
    visibility: Visibility,
    primary_ids: Buffer,
    walk: Kernel,
    direct: Kernel,
    accumulate: Kernel,
    draws: Vec<(u32, u32)>,
    seed: u32,
}

impl Frame {
    pub fn new(device: &Device, scene: &GpuScene, tracer: &Tracer, view: &View) -> Result<Self, GpuError> {
        let band = Band { first: view.first_row, count: view.rows };
        let film = Film::new(device, view.width, band)?;
        let pixels = u64::from(film.pixels());
        let points = crate::film::VISIBLE_LAYERS * pixels;
        let primary_ids = Buffer::new(device, "primary ids", pixels * 8)?;
        let variant = tracer.backend.variant();
        let fits = view.width.max(view.rows) <= device.info.limits.target_side;
        let visibility = if device.has(Capability::PreciseRaster) && fits {
            let targets = RasterTargets::ids(device, "visibility", view.width, view.rows)?;
            Visibility::Raster { raster: Raster::new(device, "frame/visibility", &targets)?, targets }
        } else {
            Visibility::Rays { primary: Kernel::new(device, "frame/primary", variant)? }
        };
        let bindings = scene
            .bindings
            .clone()
            .and(&tracer.bindings)
            .and(&film.bindings)
            .buffer("Views", &Buffer::from_slice(device, "view", &[*view])?)
            .buffer("PrimaryIds", &primary_ids)
            .buffer("VisiblePoints", &Buffer::new(device, "visible points", points * size_of::<VisiblePoint>() as u64)?)
            .buffer(
                "VisibleShades",
                &Buffer::new(device, "visible shades", points * size_of::<VisibleShade>() as u64)?,
            );
        Ok(Frame {
            bindings,
            film,
            visibility,
            primary_ids,
            walk: Kernel::new(device, "frame/walk", variant)?,
            direct: Kernel::new(device, "frame/direct", variant)?,
            accumulate: Kernel::new(device, "frame/accumulate", "")?,
            draws: (0u32..).zip(&scene.instances).map(|(i, instance)| (i, 3 * instance.triangles)).collect(),
            seed: view.seed,
        })
    }

    /// What the visibility stage is made of.
    pub fn visibility_tier(&self) -> &'static str {
        match self.visibility {
            Visibility::Raster { .. } => "raster visibility",
            Visibility::Rays { .. } => "compute visibility",
        }
    }

    /// Pixel layers: what a technique's kernels that work on visible points are dispatched over.
    pub fn slots(&self) -> u32 {
        self.film.pixels() * crate::film::VISIBLE_LAYERS as u32
    }

    /// Records sample `index`: afterwards the visible points are those of this sample, and the film holds its direct
    /// light.
    pub fn record(&self, recorder: &mut Recorder, index: u32) -> Result<(), GpuError> {
        // One jitter for all pixels: the raster can shift its projection only as a whole. Each pixel sees the whole
        // (0,2)-sequence all the same.
        let sample = Sample { jitter: random::sample_2d(index, self.seed), index, padding0: 0 };
        let bindings = [&self.bindings];
        match &self.visibility {
            Visibility::Raster { raster, targets } => {
                let items: Vec<_> = self
                    .draws
                    .iter()
                    .map(|&(instance, vertices)| (DrawPush { jitter: sample.jitter, instance, padding0: 0 }, vertices))
                    .collect();
                recorder.pass("frame/visibility")?.draw(raster, targets, &bindings, &items)?;
                recorder.pass("frame/visibility-copy")?.copy_image(&targets.color, &self.primary_ids);
            }
            Visibility::Rays { primary } => {
                recorder.pass("frame/primary")?.dispatch(primary, &bindings, &sample, self.film.pixels())?;
            }
        }
        recorder.pass("frame/walk")?.dispatch(&self.walk, &bindings, &sample, self.slots())?;
        recorder.pass("frame/direct")?.dispatch(&self.direct, &bindings, &(), self.slots())?;
        Ok(())
    }
    /// Records how sample `index` of a per-sample technique enters the film: the technique has filled the block
    /// `SampleIrradiance` for every slot that has a visible point. Afterwards the film's caustic layers are the means of
    /// the samples up to this one; odd samples are the half that is kept apart.
    pub fn record_caustic(&self, recorder: &mut Recorder, index: u32) -> Result<(), GpuError> {
        let sample = Sample { jitter: [0.0; 2], index, padding0: 0 };
        let bindings = [&self.bindings];
        recorder.pass("frame/accumulate")?.dispatch(&self.accumulate, &bindings, &sample, self.slots())?;
        Ok(())
    }
}
