//! What `mnee` does not look for, by photons: light that is reflected, or refracted more than once, and light in volumes.

use crate::film::VISIBLE_LAYERS;
use crate::frame::Frame;
use crate::gpu::{Bindings, Buffer, GpuError, GpuStruct, Kernel, Layout, Recorder};
use crate::technique::reference::Reference;
use crate::technique::{Context, Settings, Technique, TechniqueKind};

crate::gpu_struct! {
    pub struct RestPush {
        pub sign: f32,
    }
}

pub const LAYOUTS: &[Layout] = &[RestPush::LAYOUT];

/// The technique `reference`, restricted to the other path classes, with a picture of its own.
pub struct Rest {
    reference: Reference,
    add: Kernel,
    caustic: Buffer,
    irradiance: Buffer,
    volume: Buffer,
    bindings: Bindings,
}

impl Rest {
    /// `None` unless `mnee.rest=photons`.
    pub fn new(settings: &Settings, context: &Context<'_>) -> Result<Option<Self>, GpuError> {
        if settings.choice("rest") != "photons" {
            return Ok(None);
        }
        let photons = settings.integer("rest_photons");
        let set = [format!("reference.photons={photons}"), "reference.paths=not-refracted-once".to_string()];
        let settings = Settings::parse(TechniqueKind::Reference, &set)
            .map_err(|error| GpuError::Kernel { kernel: "mnee/rest".to_string(), reason: error.to_string() })?;
        let pixels = u64::from(context.frame.film.pixels());
        let caustic = Buffer::zeroed(context.device, "mnee rest caustic", pixels * VISIBLE_LAYERS * 16)?;
        let irradiance = Buffer::zeroed(context.device, "mnee rest irradiance", pixels * 16)?;
        let in_volume = if context.frame.film.has_volume() { pixels * VISIBLE_LAYERS * 16 } else { 0 };
        let volume = Buffer::zeroed(context.device, "mnee rest volume", in_volume)?;
        let bindings = Bindings::new()
            .buffer("RestCaustic", &caustic)
            .buffer("RestIrradiance", &irradiance)
            .buffer("RestCausticVolume", &volume);
        let picture = Bindings::new()
            .buffer("FilmCaustic", &caustic)
            .buffer("FilmIrradiance", &irradiance)
            .buffer("FilmCausticVolume", &volume);
        let reference = Reference::new(&settings, context)?.into(picture);
        let add = Kernel::new(context.device, "mnee/rest", "")?;
        Ok(Some(Rest { reference, add, caustic, irradiance, volume, bindings }))
    }

    /// As [`Technique::restart`].
    pub fn restart(&mut self, context: &Context<'_>) -> Result<(), GpuError> {
        let mut recorder = Recorder::new(context.device)?;
        recorder.pass("mnee/clear")?.fill(&self.caustic, 0).fill(&self.irradiance, 0).fill(&self.volume, 0);
        recorder.submit()?;
        self.reference.restart(context)
    }

    /// Takes the photons' picture out of the film again, so that the film holds means over samples alone.
    pub fn take_out(&self, frame: &Frame, recorder: &mut Recorder) -> Result<(), GpuError> {
        self.record_sign(frame, recorder, -1.0)
    }

    /// Sends more photons and puts their picture into the film.
    pub fn put_in(&mut self, frame: &Frame, recorder: &mut Recorder, index: u32) -> Result<(), GpuError> {
        self.reference.record(frame, recorder, index)?;
        self.record_sign(frame, recorder, 1.0)
    }

    fn record_sign(&self, frame: &Frame, recorder: &mut Recorder, sign: f32) -> Result<(), GpuError> {
        let bindings = [&frame.bindings, &self.bindings];
        recorder.pass("mnee/rest")?.dispatch(&self.add, &bindings, &RestPush { sign }, frame.slots())?;
        Ok(())
    }
}
