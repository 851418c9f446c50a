//! Cascaded image-space photon tracing (Meenrattanakorn and Lambers 2023): photons are followed over what the lights see
//! and over what the camera sees, with no ray traced.

pub mod denoise;
mod ledger;
mod points;
mod settings;
mod shares;
mod spaces;

use settings::{DENOISE_OFF, POINTS_AUTO, POINTS_BLUE, REFRACTION_SCREEN};
pub use settings::{DENOISE_TEMPORAL, SETTINGS};

use super::{Context, CounterEntry, LedgerEntry, Settings, Technique};
use crate::frame::Frame;
use crate::gpu::{Bindings, Buffer, GpuError, GpuStruct, Kernel, Layout, Recorder};
use crate::random;
use denoise::{DenoiseOptions, Denoiser, Receivers};
use shares::{Power, Share};
pub use spaces::CameraTexel;
use spaces::{SpaceOptions, Spaces};

crate::gpu_struct! {
    /// How light is stored; see `kernels/technique/photons/store.glsl`.
    pub struct StorePush {
        pub camera: u32,
        pub cubes: u32,
        pub cube_pixels: f32,
        pub seed: u32,
        pub flux_unit: f32,
        pub probes: u32,
        pub near: u32,
    }
}

crate::gpu_struct! {
    pub struct EmissionPush {
        pub ledger_unit: f32,
        pub photons: u32,
        pub views: u32,
        pub set: u32,
        pub rough_alpha: f32,
        pub faint: f32,
        pub seed: u32,
        pub shuffled: u32,
        pub blue_side: u32,
        pub fates: u32,
    }
}

crate::gpu_struct! {
    pub struct TracePush {
        pub store: StorePush,
        pub ledger_unit: f32,
        pub photons: u32,
        pub options: u32,
        pub max_steps: u32,
        pub turns: u32,
        pub fates: u32,
    }
}

crate::gpu_struct! {
    pub struct RescuePush {
        pub store: StorePush,
        pub ledger_unit: f32,
        pub photons: u32,
        pub printed_area: u32,
        pub splats: u32,
        pub fates: u32,
    }
}

crate::gpu_struct! {
    pub struct SplatPush {
        pub camera: u32,
        pub photons: u32,
        pub flux_unit: f32,
        pub radius: f32,
    }
}

crate::gpu_struct! {
    /// A photon on its way; see `kernels/technique/photons/photon.glsl`.
    pub struct PhotonRecord {
        pub origin: [f32; 3],
        pub direction: u32,
        pub flux: [f32; 3],
        pub medium_view: u32,
    }
}

crate::gpu_struct! {
    pub struct IrradiancePush {
        pub camera: u32,
        pub flux_unit: f32,
        pub printed_area: u32,
        pub padding0: u32,
    }
}

crate::gpu_struct! {
    pub struct ShowPush {
        pub store: StorePush,
    }
}

crate::gpu_struct! {
    pub struct RefractPush {
        pub camera: u32,
        pub max_steps: u32,
        pub jitter: [f32; 2],
        pub listed: u32,
        pub linear: u32,
        pub padding0: u32,
        pub padding1: u32,
    }
}

pub const LAYOUTS: &[Layout] = &[
    Share::LAYOUT,
    StorePush::LAYOUT,
    EmissionPush::LAYOUT,
    TracePush::LAYOUT,
    PhotonRecord::LAYOUT,
    RescuePush::LAYOUT,
    IrradiancePush::LAYOUT,
    ShowPush::LAYOUT,
    RefractPush::LAYOUT,
    SplatPush::LAYOUT,
    spaces::CoveragePush::LAYOUT,
    spaces::CameraTexel::LAYOUT,
    spaces::SeePush::LAYOUT,
    spaces::PyramidPush::LAYOUT,
    spaces::CameraPush::LAYOUT,
    denoise::DenoisePush::LAYOUT,
];

/// Units of the integer sums in all light of a set: a photon of a million has a thousand, and the largest sum is a quarter
/// of what fits.
const UNITS: f64 = 1_073_741_824.0;
/// Bits of [`TracePush::options`].
const LINEAR_MARCH: u32 = 1;
const LINEAR_END: u32 = 2;
const RESCUE: u32 = 4;
const PRINTED_AREA: u32 = 8;
const SPLATS: u32 = 16;
/// Most slots of the table of cubes, which fill what a device has to offer to a buffer, and least.
const CUBES: [u32; 2] = [1 << 10, 1 << 23];
/// Slots looked at for a cube.
const PROBES: u32 = 16;
/// Texels looked at for a place: its own and those round it.
const NEAR: u32 = 9;
/// Entries of the ledger that one photon can have a share in.
const FATES: u32 = 6;
const CUBE_BYTES: u64 = 16;

struct Kernels {
    emit: Kernel,
    trace: Kernel,
    rescue: Option<Kernel>,
    /// Where photons are drawn as discs.
    splat: Option<Kernel>,
    irradiance: Kernel,
    show: Kernel,
    /// With screen-space refraction.
    refract: Option<Kernel>,
}

/// The technique's state for one band.
pub struct Photons {
    settings: Settings,
    kernels: Kernels,
    spaces: Spaces,
    bindings: Bindings,
    ledger: Buffer,
    tallies: Buffer,
    flux: Buffer,
    cubes: Buffer,
    emission: EmissionPush,
    trace: TracePush,
    /// Texels.
    footprint: f32,
    denoiser: Option<Denoiser>,
    /// Sets that the denoiser's history had when this began.
    first_set: u32,
    /// Whether the image spaces have been found since the scene or the camera changed.
    found: bool,
    reuse: u32,
}

impl Photons {
    pub fn new(settings: &Settings, context: &Context<'_>) -> Result<Self, GpuError> {
        Self::after(settings, context, None)
    }

    /// With the history that a denoiser has from before.
    fn after(settings: &Settings, context: &Context<'_>, before: Option<Denoiser>) -> Result<Self, GpuError> {
        let device = context.device;
        let options = SpaceOptions {
            resolution: settings.integer("resolution"),
            margin: settings.number("margin"),
            thickness: settings.number("thickness"),
        };
        let spaces = Spaces::new(&options, context)?;
        let lights = &context.scene.lights;
        let light_views = &spaces.views[..spaces.camera() as usize];
        let powers: Vec<Power> =
            light_views.iter().map(|view| shares::power(view, &lights[view.light as usize])).collect();
        let shares = shares::shares(light_views, &powers, settings.integer("photons"));
        let photons = shares::photons(&shares);
        let bound: f64 = powers.iter().map(|power| power.bound).sum();
        let unit = ((bound / UNITS) as f32).max(f32::MIN_POSITIVE);
        let rescue = settings.choice("rescue") == "rays";
        // No photon fills more than two in the mean.
        let slots = (2 * photons).next_power_of_two().clamp(CUBES[0], CUBES[1]);
        let cubes = if rescue { slots } else { 0 };
        let option = |key: &str, value: &str, bit: u32| if settings.choice(key) == value { bit } else { 0 };
        let roughness = settings.number("roughness");
        let trace = TracePush {
            store: StorePush {
                camera: spaces.camera(),
                cubes,
                cube_pixels: settings.number("cube"),
                seed: 0,
                flux_unit: unit,
                probes: PROBES,
                near: NEAR,
            },
            ledger_unit: unit,
            photons,
            options: option("march", "linear", LINEAR_MARCH)
                | option("end", "linear", LINEAR_END)
                | option("rescue", "rays", RESCUE)
                | option("area", "printed", PRINTED_AREA)
                | option("store", "splats", SPLATS),
            max_steps: settings.integer("steps"),
            turns: if rescue { 1 } else { 2 },
            fates: FATES,
        };
        let blue = match settings.choice("points") {
            POINTS_AUTO => settings.choice("denoise") != DENOISE_OFF,
            points => points == POINTS_BLUE,
        };
        let emission = EmissionPush {
            ledger_unit: unit,
            photons,
            views: spaces.camera(),
            set: 0,
            rough_alpha: roughness * roughness,
            faint: settings.number("luminance"),
            seed: random::combine(context.seed, 0x7068_6f74),
            shuffled: u32::from(settings.choice("order") == "shuffled"),
            blue_side: if blue { points::SIDE } else { 0 },
            fates: FATES,
        };
        let order = if emission.shuffled != 0 { shares::shuffled(photons, emission.seed) } else { Vec::new() };
        let blue: &[u32] = if blue { &points::BLUE_POINTS } else { &[] };
        let texels = u64::from(spaces.camera_texels());
        let ledger = Buffer::zeroed(device, "photons ledger", ledger::LEDGER_BYTES)?;
        let tallies = Buffer::zeroed(device, "photons tallies", ledger::TALLY_BYTES)?;
        let flux = Buffer::zeroed(device, "photons flux", 12 * texels)?;
        let cubes = Buffer::new(device, "photons cubes", CUBE_BYTES * u64::from(cubes))?;
        let records = Buffer::new(device, "photons records", size_of::<PhotonRecord>() as u64 * u64::from(photons))?;
        let irradiance = Buffer::new(device, "photons irradiance", 16 * texels)?;
        let bindings = spaces
            .bindings
            .clone()
            .buffer("PhotonFlux", &flux)
            .buffer("PhotonIrradiance", &irradiance)
            .buffer("PhotonCubes", &cubes)
            .buffer("Ledger", &ledger)
            .buffer("PhotonTallies", &tallies)
            .buffer("Shares", &Buffer::from_slice(device, "photons shares", &shares)?)
            .buffer("PhotonOrder", &Buffer::from_slice(device, "photons order", &order)?)
            .buffer("BluePoints", &Buffer::from_slice(device, "photons blue points", blue)?)
            .buffer("PhotonRecords", &records);
        let denoiser = match (before, DenoiseOptions::of(settings)) {
            (Some(denoiser), _) => Some(denoiser.follow(device, receivers(&spaces, &bindings, &irradiance, context))?),
            (None, Some(options)) => {
                Some(Denoiser::new(device, options, receivers(&spaces, &bindings, &irradiance, context))?)
            }
            (None, None) => None,
        };
        let first_set = denoiser.as_ref().map_or(0, Denoiser::sets);
        let variant = context.tracer.variant();
        let splats = trace.options & SPLATS != 0;
        let refracts = settings.choice("refraction") == REFRACTION_SCREEN;
        let kernels = Kernels {
            emit: Kernel::new(device, "photons/emit", context.tracer.plain())?,
            trace: Kernel::new(device, "photons/trace", context.tracer.plain())?,
            rescue: rescue.then(|| Kernel::new(device, "photons/rescue", variant)).transpose()?,
            splat: splats.then(|| Kernel::new(device, "photons/splat", "")).transpose()?,
            irradiance: Kernel::new(device, "photons/irradiance", "")?,
            show: Kernel::new(device, "photons/show", "")?,
            refract: refracts.then(|| Kernel::new(device, "photons/refract", "")).transpose()?,
        };
        Ok(Photons {
            settings: settings.clone(),
            kernels,
            spaces,
            bindings,
            ledger,
            tallies,
            flux,
            cubes,
            emission,
            trace,
            footprint: settings.number("footprint"),
            denoiser,
            first_set,
            found: false,
            reuse: settings.integer("reuse"),
        })
    }

    /// Records a set of photons, from lights to irradiance.
    fn record_set(
        &mut self,
        frame: &Frame,
        recorder: &mut Recorder,
        set: u32,
        store: StorePush,
    ) -> Result<(), GpuError> {
        let bindings = [&frame.bindings, &self.bindings];
        let emission = EmissionPush { set, ..self.emission };
        let trace = TracePush { store, ..self.trace };
        let mut pass = recorder.pass("photons/clear")?;
        pass.fill(&self.flux, 0);
        if trace.store.cubes > 0 {
            pass.fill(&self.cubes, 0);
        }
        drop(pass);
        recorder.pass("photons/emit")?.dispatch(&self.kernels.emit, &bindings, &emission, emission.photons)?;
        recorder.pass("photons/trace")?.dispatch(&self.kernels.trace, &bindings, &trace, trace.photons)?;
        let printed_area = u32::from(trace.options & PRINTED_AREA != 0);
        if let Some(rescue) = &self.kernels.rescue {
            let push = RescuePush {
                store,
                ledger_unit: trace.ledger_unit,
                photons: trace.photons,
                printed_area,
                splats: u32::from(self.kernels.splat.is_some()),
                fates: FATES,
            };
            recorder.pass("photons/rescue")?.dispatch(rescue, &bindings, &push, trace.photons)?;
        }
        if let Some(splat) = &self.kernels.splat {
            let (camera, flux_unit) = (store.camera, store.flux_unit);
            let push = SplatPush { camera, photons: trace.photons, flux_unit, radius: self.footprint };
            recorder.pass("photons/splat")?.dispatch(splat, &bindings, &push, trace.photons)?;
        }
        let push = IrradiancePush { camera: store.camera, flux_unit: store.flux_unit, printed_area, padding0: 0 };
        let texels = self.spaces.camera_texels();
        recorder.pass("photons/irradiance")?.dispatch(&self.kernels.irradiance, &bindings, &push, texels)?;
        if let Some(denoiser) = &mut self.denoiser {
            denoiser.record(recorder, &frame.bindings)?;
        }
        Ok(())
    }
}

/// What the camera sees light land on.
fn receivers<'a>(
    spaces: &'a Spaces,
    bindings: &'a Bindings,
    irradiance: &'a Buffer,
    context: &Context<'_>,
) -> Receivers<'a> {
    Receivers {
        bindings,
        texels: &spaces.texels,
        irradiance,
        camera: spaces.camera(),
        view: spaces.views[spaces.camera() as usize],
        transforms: context.scene.instances.iter().map(|instance| instance.transform).collect(),
    }
}

impl Technique for Photons {
    fn restart(&mut self, context: &Context<'_>) -> Result<(), GpuError> {
        *self = Photons::after(&self.settings, context, self.denoiser.take())?;
        Ok(())
    }

    fn record(&mut self, frame: &Frame, recorder: &mut Recorder, index: u32) -> Result<(), GpuError> {
        if self.trace.photons > 0 {
            if !self.found {
                self.spaces.record(recorder, &frame.bindings, self.trace.store)?;
                self.found = true;
            }
            let set = self.first_set.wrapping_add(index / self.reuse);
            let store = StorePush { seed: random::combine(self.emission.seed, set), ..self.trace.store };
            if index.is_multiple_of(self.reuse) {
                self.record_set(frame, recorder, set, store)?;
            }
            let bindings = [&frame.bindings, &self.bindings];
            recorder.pass("photons/show")?.dispatch(
                &self.kernels.show,
                &bindings,
                &ShowPush { store },
                frame.slots(),
            )?;
            if let Some(refract) = &self.kernels.refract {
                let push = RefractPush {
                    camera: store.camera,
                    max_steps: self.trace.max_steps,
                    jitter: frame.jitter(),
                    listed: u32::from(frame.adaptive().is_some()),
                    linear: u32::from(self.trace.options & LINEAR_MARCH != 0),
                    padding0: 0,
                    padding1: 0,
                };
                // The first layer's slots: what is reflected is looked up at its points.
                recorder.pass("photons/refract")?.dispatch(refract, &bindings, &push, frame.slots() / 2)?;
            }
        }
        frame.record_caustic(recorder, index)
    }

    fn ledger(&self, samples: u32) -> Result<Vec<LedgerEntry>, GpuError> {
        ledger::ledger(&self.ledger, self.trace.ledger_unit, samples.div_ceil(self.reuse))
    }

    fn counters(&self) -> Result<Vec<CounterEntry>, GpuError> {
        ledger::counters(&self.tallies)
    }

    fn second_half(&self, samples: u32) -> Option<u32> {
        // Samples that share a history are no two halves.
        let apart = self.settings.choice("denoise") != DENOISE_TEMPORAL;
        (self.trace.photons > 0 && apart).then_some(samples / 2)
    }

    fn warnings(&self) -> Result<Vec<String>, GpuError> {
        if self.trace.photons == 0 {
            return Ok(vec!["no light reaches a specular object, so there is no caustic light".to_string()]);
        }
        let dropped = self.counters()?.into_iter().filter(|entry| entry.value > 0.0);
        Ok(dropped
            .filter_map(|entry| match entry.name {
                "photons_dropped" => {
                    Some(format!("photons had no room for {} of them; some light is missing", entry.value))
                }
                "marches_cut" => {
                    Some(format!("{} photons took more than photons.steps steps and are lost", entry.value))
                }
                _ => None,
            })
            .collect())
    }
}
