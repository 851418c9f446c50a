//! Stochastic progressive photon mapping (Hachisuka and Jensen 2009): consistent, so it gets more exact for as long as
//! it runs. What the other techniques are held against.

mod records;
mod settings;
mod sort;
mod volume;

use super::emission::{EmissionCell, emission};
use super::{Context, LedgerEntry, Settings, Technique, double_words};
use crate::frame::Frame;
use crate::gpu::{Bindings, Buffer, GpuError, Kernel, Recorder};
use crate::random;
use crate::scene::Scene;
use records::{EmitPush, GatherPush, PreparePush, ResolvePush, Statistic};
use settings::{ALL_CLASSES, class_bits};
use sort::{SortKernels, Sorted};
use volume::Volume;

pub use records::LAYOUTS;
pub use settings::SETTINGS;

/// Directions are divided into about this many cells; more fit the specular objects' outline better.
const EMISSION_CELLS: usize = 4096;
/// Units of the integer sums in one photon of mean flux; the rounding of one photon is 1/2 of 1/65536.
const UNITS_PER_PHOTON: f32 = 65536.0;
/// Ledger units in the flux of one pass: half the range of its low word, so that no single entry wraps twice.
const LEDGER_UNITS: f32 = 2_147_483_648.0;
/// Of the scene's diagonal, the largest first radius.
const MAX_RADIUS: f32 = 0.02;

const LEDGER_NAMES: [&str; 9] =
    ["landed", "absorbed", "scattered", "escaped", "unfocused", "given_up", "other_class", "wrong_side", "non_finite"];

#[derive(Clone)]
struct Kernels {
    prepare: Kernel,
    emit: Kernel,
    sort: SortKernels,
    gather: Kernel,
    resolve: Kernel,
}

impl Kernels {
    fn new(context: &Context<'_>) -> Result<Self, GpuError> {
        let plain = |name: &str| Kernel::new(context.device, &format!("reference/{name}"), "");
        Ok(Kernels {
            prepare: plain("prepare")?,
            emit: Kernel::new(context.device, "reference/emit", context.tracer.variant())?,
            sort: SortKernels::new(context.device)?,
            gather: plain("gather")?,
            resolve: plain("resolve")?,
        })
    }
}

/// The technique's state for one band.
pub struct Reference {
    settings: Settings,
    kernels: Kernels,
    bindings: Bindings,
    /// Where the picture goes that is to be added to another technique's; the film otherwise.
    picture: Option<Bindings>,
    /// A slot each path; `None` where no light reaches a specular object.
    sorted: Option<Sorted>,
    volume: Option<Volume>,
    ledger: Buffer,
    emit: EmitPush,
    prepare: PreparePush,
    alpha: f32,
    /// Samples a set of photons.
    reuse: u32,
    /// W of the mean channel that a pass emits.
    flux: f32,
}

impl Reference {
    pub fn new(settings: &Settings, context: &Context<'_>) -> Result<Self, GpuError> {
        Self::with(settings, Kernels::new(context)?, context)
    }

    fn with(settings: &Settings, kernels: Kernels, context: &Context<'_>) -> Result<Self, GpuError> {
        let device = context.device;
        let emission = emission(context.scene, EMISSION_CELLS.min(settings.integer("photons") as usize));
        let split = settings.choice("fresnel") == "split";
        let cells = emission.cells.len() as u32;
        let samples = (settings.integer("photons") / cells.max(1)).max(1);
        let slots = cells * samples * if split { 2 } else { 1 };
        let flux: f32 = emission.flux.iter().map(|f| f.element_sum() / 3.0).sum();

        let sorted = match slots {
            0 => None,
            _ => Some(Sorted::new(device, &kernels.sort, "reference/", slots)?),
        };
        let volume = Volume::new(settings, &kernels.sort, context, slots, flux)?;
        let volume_bindings = match &volume {
            Some(volume) => volume.bindings(),
            None => Bindings::new().buffer("VolumePhotons", &Buffer::new(device, "no volume photons", 0)?),
        };
        let statistics = u64::from(context.frame.slots());
        let ledger = Buffer::zeroed(device, "reference ledger", 2 * 4 * LEDGER_NAMES.len() as u64)?;
        let statistic_bytes = size_of::<Statistic>() as u64;
        let bindings = Bindings::new()
            .buffer("Statistics", &Buffer::zeroed(device, "reference statistics", statistics * statistic_bytes)?)
            .buffer("EmissionCells", &Buffer::from_slice::<EmissionCell>(device, "emission cells", &emission.cells)?)
            .buffer("Ledger", &ledger)
            .buffer("HalfFluxes", &Buffer::zeroed(device, "reference half fluxes", statistics * 4)?)
            .and(&volume_bindings);
        Ok(Reference {
            settings: settings.clone(),
            kernels,
            bindings,
            picture: None,
            sorted,
            ledger,
            emit: EmitPush {
                pass: 0,
                cells,
                samples,
                split: u32::from(split),
                classes: class_bits(settings.choice("paths")),
                seed: random::combine(context.seed, 0x7068_6f74),
                ledger_unit: (flux / LEDGER_UNITS).max(f32::MIN_POSITIVE),
                slots,
                volume_classes: class_bits(settings.choice("paths")),
                volume_points: volume.as_ref().map_or(0, |volume| volume.points),
            },
            volume,
            prepare: PreparePush {
                radius_pixels: settings.number("radius"),
                least_radius: density_radius(context.scene, settings.number("neighbours"), cells * samples),
                max_radius: MAX_RADIUS * scene_diagonal(context),
                new_grid: 1,
            },
            alpha: settings.number("alpha"),
            reuse: settings.integer("reuse"),
            flux,
        })
    }

    /// The same, but the picture goes to `picture`, which has the film's blocks `FilmCaustic`, `FilmIrradiance` and
    /// `FilmCausticVolume`, instead of the film. `paths` then holds on surfaces alone: volumes get the light of all paths.
    pub fn into(self, picture: Bindings) -> Self {
        let emit = EmitPush { volume_classes: ALL_CLASSES, ..self.emit };
        Reference { picture: Some(picture), emit, ..self }
    }
}

/// The radius that holds `neighbours` of `photons` photons spread over an area as large as all specular surfaces.
fn density_radius(scene: &Scene, neighbours: f32, photons: u32) -> f32 {
    (neighbours * specular_area(scene) / (std::f32::consts::PI * photons.max(1) as f32)).sqrt().max(1e-6)
}

/// Of all specular surfaces, m2.
fn specular_area(scene: &Scene) -> f32 {
    let specular = scene.instances.iter().filter(|i| scene.materials[i.material].surface.is_specular());
    specular.map(|i| scene.area(i)).sum()
}

fn scene_diagonal(context: &Context<'_>) -> f32 {
    let diagonal = context.scene.bounds().diagonal();
    if diagonal.is_finite() { diagonal.max(1e-6) } else { 1e-6 }
}

impl Technique for Reference {
    /// Emission cells depend on where specular surfaces are, and with them the number of photons.
    fn restart(&mut self, context: &Context<'_>) -> Result<(), GpuError> {
        let picture = self.picture.take();
        // The old buffers go before there are new ones: both would be twice the memory.
        self.bindings = Bindings::new();
        (self.sorted, self.volume) = (None, None);
        let anew = Self::with(&self.settings, self.kernels.clone(), context)?;
        *self = match picture {
            Some(picture) => anew.into(picture),
            None => anew,
        };
        Ok(())
    }

    fn record(&mut self, frame: &Frame, recorder: &mut Recorder, index: u32) -> Result<(), GpuError> {
        let Some(sorted) = &self.sorted else { return Ok(()) };
        let (slots, buckets) = (sorted.slots, sorted.buckets);
        let bindings = [&frame.bindings, &self.bindings, &sorted.bindings];
        let kernels = &self.kernels;
        let set = index / self.reuse;
        let new_photons = index.is_multiple_of(self.reuse);
        if new_photons {
            recorder.pass("reference/clear-grid")?.fill(&sorted.grid, 0);
        }
        let prepare = PreparePush { new_grid: new_photons.into(), ..self.prepare };
        recorder.pass("reference/prepare")?.dispatch(&kernels.prepare, &bindings, &prepare, frame.slots())?;
        if new_photons {
            let emit = EmitPush { pass: set, ..self.emit };
            recorder.pass("reference/emit")?.dispatch(&kernels.emit, &bindings, &emit, slots)?;
            sorted.record(recorder)?;
        }
        let photons = (slots >> self.emit.split).max(1);
        let gather = GatherPush {
            slots,
            buckets,
            alpha: self.alpha,
            flux_unit: (self.flux / photons as f32 / UNITS_PER_PHOTON).max(f32::MIN_POSITIVE),
            odd: set % 2,
        };
        recorder.pass("reference/gather")?.dispatch(&kernels.gather, &bindings, &gather, frame.slots())?;
        let resolve = ResolvePush { passes: index + 1 };
        let film = Bindings::new();
        let picture = self.picture.as_ref().unwrap_or(&film);
        let bindings = [picture, &frame.bindings, &self.bindings];
        recorder.pass("reference/resolve")?.dispatch(&kernels.resolve, &bindings, &resolve, frame.slots())?;
        if let Some(volume) = &self.volume {
            if new_photons {
                volume.record_sort(recorder, set)?;
            }
            volume.record_gather(frame, recorder, picture, (index, set))?;
        }
        Ok(())
    }

    fn ledger(&self, samples: u32) -> Result<Vec<LedgerEntry>, GpuError> {
        let words: Vec<u32> = self.ledger.read(2 * LEDGER_NAMES.len())?;
        let scale = f64::from(self.emit.ledger_unit) / f64::from(samples.div_ceil(self.reuse).max(1));
        let entries = LEDGER_NAMES.iter().zip(double_words(&words));
        let entries = entries.map(|(name, units)| LedgerEntry { name, watts: units * scale });
        Ok(std::iter::once(LedgerEntry { name: "emitted", watts: self.flux.into() }).chain(entries).collect())
    }

    fn second_half(&self, samples: u32) -> Option<u32> {
        let sets = samples / self.reuse;
        let rest = if sets % 2 == 1 { samples % self.reuse } else { 0 };
        self.sorted.as_ref().map(|_| sets / 2 * self.reuse + rest)
    }

    fn warnings(&self) -> Result<Vec<String>, GpuError> {
        if self.sorted.is_none() {
            return Ok(vec!["no light reaches a specular object, so there is no caustic light".to_string()]);
        }
        Ok(Vec::new())
    }
}
