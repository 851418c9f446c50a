//! One frame, top to bottom: visibility -> walk to the visible diffuse points -> direct light -> light that media scatter.
//! What the technique adds comes after, and `film` composes.

use crate::adaptive::{Adaptive, RoundSample};
use crate::film::{Film, SampleCounts};
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
    /// A stretch of a camera path in a medium that scatters; see `kernels/shared/segments.glsl`.
    pub struct ViewSegment {
        pub origin: [f32; 3],
        pub throughput_rg: u32,
        pub end: [f32; 3],
        pub throughput_b_medium: u32,
    }
}

crate::gpu_struct! {
    /// What changes from sample to sample.
    pub struct Sample {
        pub jitter: [f32; 2],
        pub index: u32,
        pub listed: u32,
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

/// How samples are spread over pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sampling {
    /// Every sample is one of each pixel.
    Uniform,
    /// This many samples a pixel in the mean, where pixels vary; for per-sample techniques only.
    Adaptive { samples: u32 },
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
    /// Of `bindings`, what is the frame's own.
    own: Bindings,
    view: View,
    view_buffer: Buffer,
    adaptive: Option<Adaptive>,
    visibility: Visibility,
    primary_ids: Buffer,
    walk: Kernel,
    direct: Kernel,
    /// Only where a medium scatters and there is light.
    volume: Option<Kernel>,
    accumulate: Kernel,
    draws: Vec<(u32, u32)>,
    /// Seed of the jitter's sequence, and the number of its point that the first sample gets.
    sequence: (u32, u32),
    jitter: [f32; 2],
}

impl Frame {
    pub fn new(
        device: &Device,
        scene: &GpuScene,
        tracer: &Tracer,
        view: &View,
        sampling: Sampling,
    ) -> Result<Self, GpuError> {
        let band = Band { first: view.first_row, count: view.rows };
        let film = Film::new(device, view.width, band, view.segments > 0)?;
        let pixels = u64::from(film.pixels());
        let points = crate::film::VISIBLE_LAYERS * pixels;
        let adaptive = match sampling {
            Sampling::Uniform => None,
            Sampling::Adaptive { samples } => Some(Adaptive::new(device, &film, view.width, samples)?),
        };
        let segments = u64::from(view.segments) * points * size_of::<ViewSegment>() as u64;
        let listed = if adaptive.is_some() { pixels } else { 0 };
        let primary_ids = Buffer::new(device, "primary ids", pixels * 8)?;
        let variant = tracer.variant();
        let fits = view.width.max(view.rows) <= device.info.limits.target_side;
        // The raster shifts its projection as a whole, and adaptive samples each have a pixel and a place of their own.
        let visibility = if device.has(Capability::PreciseRaster) && fits && adaptive.is_none() {
            let targets = RasterTargets::ids(device, "visibility", view.width, view.rows)?;
            Visibility::Raster { raster: Raster::new(device, "frame/visibility", &targets)?, targets }
        } else {
            Visibility::Rays { primary: Kernel::new(device, "frame/primary", variant)? }
        };
        let lit_volume = view.segments > 0 && view.lights > 0;
        let view_buffer = Buffer::from_slice(device, "view", &[*view])?;
        let own = film
            .bindings
            .clone()
            .buffer("Views", &view_buffer)
            .buffer("PrimaryIds", &primary_ids)
            .buffer("RoundSamples", &Buffer::new(device, "round samples", listed * size_of::<RoundSample>() as u64)?)
            .buffer("ViewSegments", &Buffer::new(device, "view segments", segments)?)
            .buffer("VisiblePoints", &Buffer::new(device, "visible points", points * size_of::<VisiblePoint>() as u64)?)
            .buffer(
                "VisibleShades",
                &Buffer::new(device, "visible shades", points * size_of::<VisibleShade>() as u64)?,
            );
        Ok(Frame {
            bindings: scene.bindings.clone().and(&tracer.bindings).and(&own),
            film,
            own,
            view: *view,
            view_buffer,
            adaptive,
            visibility,
            primary_ids,
            walk: Kernel::new(device, "frame/walk", variant)?,
            direct: Kernel::new(device, "frame/direct", variant)?,
            volume: lit_volume.then(|| Kernel::new(device, "frame/volume", variant)).transpose()?,
            accumulate: Kernel::new(device, "frame/accumulate", "")?,
            draws: (0u32..).zip(&scene.instances).map(|(i, instance)| (i, 3 * instance.triangles)).collect(),
            sequence: (view.seed, 0),
            jitter: [0.5; 2],
        })
    }

    /// Starts over with no samples, through `view` and on what `scene` and `tracer` have become. The view's size, the
    /// scene's number of instances and their triangles are as they were.
    pub fn restart(&mut self, device: &Device, scene: &GpuScene, tracer: &Tracer, view: &View) -> Result<(), GpuError> {
        self.bindings = scene.bindings.clone().and(&tracer.bindings).and(&self.own);
        self.view = *view;
        self.view_buffer.upload(bytemuck::bytes_of(view))?;
        self.sequence = (view.seed, 0);
        if let Some(adaptive) = &mut self.adaptive {
            adaptive.clear(device)?;
        }
        self.film.clear(device)
    }

    /// Takes the jitter from another sequence than the view's seed starts, from a point on; not where sampling is adaptive.
    pub fn jitter_by(&mut self, (seed, first): (u32, u32)) {
        self.sequence = (seed, first);
    }

    /// The camera, and the band that is rendered.
    pub fn view(&self) -> &View {
        &self.view
    }

    /// What the visibility stage is made of.
    pub fn visibility_tier(&self) -> &'static str {
        match self.visibility {
            Visibility::Raster { .. } => "raster visibility",
            Visibility::Rays { .. } => "compute visibility",
        }
    }

    /// Slots of visible points: what a technique's kernels that work on them are dispatched over, the same in every
    /// sample. Layer after layer; which pixel a slot belongs to is nothing that a technique may count on, see
    /// [`crate::adaptive`].
    pub fn slots(&self) -> u32 {
        self.film.pixels() * crate::film::VISIBLE_LAYERS as u32
    }

    /// Where in its pixel the sample recorded last looks, [0, 1), the same for all pixels; not where sampling is adaptive.
    pub fn jitter(&self) -> [f32; 2] {
        self.jitter
    }

    /// Samples of each pixel after `done` samples of the picture.
    pub fn sample_counts(&self, done: u32) -> SampleCounts {
        self.adaptive.as_ref().map_or(SampleCounts::Same(done), |adaptive| adaptive.counts(done))
    }

    /// Where sampling is adaptive, how.
    pub fn adaptive(&self) -> Option<&Adaptive> {
        self.adaptive.as_ref()
    }

    /// Records sample `index`: afterwards the visible points are those of this sample, and the film holds its direct
    /// light; where sampling is adaptive, the film holds it after [`record_caustic`](Self::record_caustic).
    ///
    /// # Errors
    /// Those of the device. After an adaptive pilot the host reads back how much pixels vary.
    pub fn record(&mut self, recorder: &mut Recorder, index: u32) -> Result<(), GpuError> {
        let listed = self.adaptive.is_some().into();
        let (seed, first) = self.sequence;
        let sample = Sample { jitter: random::sample_2d(first.wrapping_add(index), seed), index, listed };
        self.jitter = sample.jitter;
        if let Some(adaptive) = &mut self.adaptive {
            adaptive.record_list(recorder, &self.bindings, index)?;
        }
        // Names are looked up from the left: adaptive rounds have a film of their own.
        let round = self.adaptive.as_ref().map(Adaptive::round_bindings);
        let bindings: Vec<&Bindings> = round.into_iter().chain([&self.bindings]).collect();
        match &self.visibility {
            Visibility::Raster { raster, targets } => {
                let items: Vec<_> = self
                    .draws
                    .iter()
                    .map(|&(instance, vertices)| (DrawPush { jitter: sample.jitter, instance, padding0: 0 }, vertices))
                    .collect();
                recorder.pass("frame/visibility")?.draw(raster, targets, &bindings, &items)?;
                recorder.pass("frame/visibility-copy")?.copy_image(&targets.color, &self.primary_ids, 0);
            }
            Visibility::Rays { primary } => {
                recorder.pass("frame/primary")?.dispatch(primary, &bindings, &sample, self.film.pixels())?;
            }
        }
        recorder.pass("frame/walk")?.dispatch(&self.walk, &bindings, &sample, self.slots())?;
        recorder.pass("frame/direct")?.dispatch(&self.direct, &bindings, &(), self.slots())?;
        if let Some(volume) = &self.volume {
            recorder.pass("frame/volume")?.dispatch(volume, &bindings, &sample, self.slots())?;
        }
        Ok(())
    }

    /// Records how sample `index` of a per-sample technique enters the film: the technique has filled the block
    /// `SampleIrradiance` for every slot that has a visible point. Afterwards the film's caustic layers are the means of
    /// the samples up to this one; odd samples are the half that is kept apart.
    pub fn record_caustic(&self, recorder: &mut Recorder, index: u32) -> Result<(), GpuError> {
        if let Some(adaptive) = &self.adaptive {
            return adaptive.record_merge(recorder, &self.bindings, index);
        }
        let sample = Sample { jitter: [0.0; 2], index, listed: 0 };
        let bindings = [&self.bindings];
        recorder.pass("frame/accumulate")?.dispatch(&self.accumulate, &bindings, &sample, self.slots())?;
        Ok(())
    }
}
