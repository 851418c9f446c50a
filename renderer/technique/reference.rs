//! Stochastic progressive photon mapping (Hachisuka and Jensen 2009): consistent, so it gets more exact for as long as
//! it runs. What the other techniques are held against.

use super::emission::{EmissionCell, emission};
use super::{Context, LedgerEntry, Setting, SettingKind, Settings, Technique};
use crate::frame::Frame;
use crate::gpu::{Bindings, Buffer, GpuError, GpuStruct, Kernel, Layout, Recorder};
use crate::random;
use crate::scene::Scene;

pub const SETTINGS: &[Setting] = &[
    Setting {
        key: "photons",
        kind: SettingKind::Integer { min: 1, max: 4_000_000 },
        default: "2000000",
        unit: "photons",
        help: "Photons that leave the lights at once",
    },
    Setting {
        key: "reuse",
        kind: SettingKind::Integer { min: 1, max: 1024 },
        default: "4",
        unit: "samples",
        help: "Samples that gather from one set of photons: more of them smooth a pixel's own detail for less",
    },
    Setting {
        key: "radius",
        kind: SettingKind::Number { min: 0.1, max: 100.0 },
        default: "1",
        unit: "pixels",
        help: "First gathering radius; it shrinks as photons arrive",
    },
    Setting {
        key: "neighbours",
        kind: SettingKind::Number { min: 0.0, max: 1000.0 },
        default: "8",
        unit: "photons",
        help: "Photons that the first radius holds at least, were all spread evenly over the specular surfaces",
    },
    Setting {
        key: "alpha",
        kind: SettingKind::Number { min: 0.1, max: 0.99 },
        default: "0.67",
        unit: "",
        help: "Part of a sample's photons that is kept as the radius shrinks; lower shrinks faster",
    },
    Setting {
        key: "fresnel",
        kind: SettingKind::Choice(&["chance", "split"]),
        default: "chance",
        unit: "",
        help: "At the first interface: one branch by chance, or both with their weights (costs twice the rays)",
    },
    Setting {
        key: "paths",
        kind: SettingKind::Choice(&[
            "all",
            "refracted",
            "refracted-once",
            "not-refracted-once",
            "reflected",
            "reflected-once",
            "mixed",
        ]),
        default: "all",
        unit: "",
        help: "Which S+ of L S+ D counts: any, refractions only, one refraction, and so on",
    },
];

/// Grid buckets, the largest number that two levels of 1024-wide scans reach with room for the end.
const MAX_BUCKETS: u32 = 1 << 19;
/// Numbers that one workgroup scans.
const SCAN_BLOCK: u32 = 1024;
/// Directions are divided into about this many cells; more fit the specular objects' outline better.
const EMISSION_CELLS: usize = 4096;
/// Units of the integer sums in one photon of mean flux; the rounding of one photon is 1/2 of 1/65536.
const UNITS_PER_PHOTON: f32 = 65536.0;
/// Ledger units in the flux of one pass: half the range of its low word, so that no single entry wraps twice.
const LEDGER_UNITS: f32 = 2_147_483_648.0;
/// Of the scene's diagonal, the largest first radius.
const MAX_RADIUS: f32 = 0.02;

const LEDGER_NAMES: [&str; 8] =
    ["landed", "absorbed", "escaped", "unfocused", "given_up", "other_class", "wrong_side", "non_finite"];

crate::gpu_struct! {
    /// A landed photon; see `kernels/technique/reference/common.glsl`.
    pub struct Photon {
        pub position: [f32; 3],
        pub normal: u32,
        pub flux: [f32; 3],
        pub landed: u32,
    }
}

crate::gpu_struct! {
    /// What a pixel layer has gathered.
    pub struct Statistic {
        pub irradiance_flux: [f32; 3],
        pub radius2: f32,
        pub radiance_flux: [f32; 3],
        pub photons: f32,
    }
}

crate::gpu_struct! {
    pub struct GridState {
        pub max_radius: u32,
    }
}

crate::gpu_struct! {
    pub struct PreparePush {
        pub radius_pixels: f32,
        pub least_radius: f32,
        pub max_radius: f32,
        pub new_grid: u32,
    }
}

crate::gpu_struct! {
    pub struct EmitPush {
        pub pass: u32,
        pub cells: u32,
        pub samples: u32,
        pub split: u32,
        pub classes: u32,
        pub seed: u32,
        pub ledger_unit: f32,
        pub slots: u32,
    }
}

crate::gpu_struct! {
    pub struct GridPush {
        pub slots: u32,
        pub buckets: u32,
    }
}

crate::gpu_struct! {
    pub struct ScanPush {
        pub blocks: u32,
    }
}

crate::gpu_struct! {
    pub struct GatherPush {
        pub slots: u32,
        pub buckets: u32,
        pub alpha: f32,
        pub flux_unit: f32,
        pub odd: u32,
    }
}

crate::gpu_struct! {
    pub struct ResolvePush {
        pub passes: u32,
    }
}

/// What the reference shares with its kernels.
pub const LAYOUTS: &[Layout] = &[
    Photon::LAYOUT,
    Statistic::LAYOUT,
    GridState::LAYOUT,
    PreparePush::LAYOUT,
    EmitPush::LAYOUT,
    GridPush::LAYOUT,
    ScanPush::LAYOUT,
    GatherPush::LAYOUT,
    ResolvePush::LAYOUT,
];

#[derive(Clone)]
struct Kernels {
    prepare: Kernel,
    emit: Kernel,
    count: Kernel,
    scan_blocks: Kernel,
    scan_sums: Kernel,
    scan_add: Kernel,
    scatter: Kernel,
    gather: Kernel,
    resolve: Kernel,
}

impl Kernels {
    fn new(context: &Context<'_>) -> Result<Self, GpuError> {
        let plain = |name: &str| Kernel::new(context.device, &format!("reference/{name}"), "");
        Ok(Kernels {
            prepare: plain("prepare")?,
            emit: Kernel::new(context.device, "reference/emit", context.tracer.backend.variant())?,
            count: plain("count")?,
            scan_blocks: plain("scan_blocks")?,
            scan_sums: plain("scan_sums")?,
            scan_add: plain("scan_add")?,
            scatter: plain("scatter")?,
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
    picture: Bindings,
    grid: Buffer,
    bucket_starts: Buffer,
    ledger: Buffer,
    /// Photon slots a pass; 0 where no light reaches a specular object.
    slots: u32,
    buckets: u32,
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
        let buckets = slots.next_power_of_two().clamp(SCAN_BLOCK, MAX_BUCKETS);
        let flux: f32 = emission.flux.iter().map(|f| f.element_sum() / 3.0).sum();

        let photon_bytes = u64::from(slots) * size_of::<Photon>() as u64;
        let statistics = u64::from(context.frame.slots());
        let grid = Buffer::new(device, "reference grid", 16)?;
        let bucket_starts = Buffer::new(device, "reference buckets", u64::from(buckets + SCAN_BLOCK) * 4)?;
        let ledger = Buffer::zeroed(device, "reference ledger", 2 * 4 * LEDGER_NAMES.len() as u64)?;
        let statistic_bytes = size_of::<Statistic>() as u64;
        let bindings = Bindings::new()
            .buffer("PhotonGrid", &grid)
            .buffer("Statistics", &Buffer::zeroed(device, "reference statistics", statistics * statistic_bytes)?)
            .buffer("EmissionCells", &Buffer::from_slice::<EmissionCell>(device, "emission cells", &emission.cells)?)
            .buffer("Photons", &Buffer::new(device, "reference photons", photon_bytes)?)
            .buffer("Ledger", &ledger)
            .buffer("BucketStarts", &bucket_starts)
            .buffer("Places", &Buffer::new(device, "reference places", u64::from(slots) * 4)?)
            .buffer("SortedPhotons", &Buffer::new(device, "reference sorted photons", photon_bytes)?)
            .buffer("BlockSums", &Buffer::new(device, "reference block sums", u64::from(SCAN_BLOCK) * 4)?)
            .buffer("HalfFluxes", &Buffer::zeroed(device, "reference half fluxes", statistics * 4)?);
        Ok(Reference {
            settings: settings.clone(),
            kernels,
            bindings,
            picture: Bindings::new(),
            grid,
            bucket_starts,
            ledger,
            slots,
            buckets,
            emit: EmitPush {
                pass: 0,
                cells,
                samples,
                split: u32::from(split),
                classes: class_bits(settings.choice("paths")),
                seed: random::combine(context.seed, 0x7068_6f74),
                ledger_unit: (flux / LEDGER_UNITS).max(f32::MIN_POSITIVE),
                slots,
            },
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

    /// The same, but the picture goes to `caustic` and `irradiance`, laid out as the film's blocks, instead of the film.
    pub fn into(self, caustic: &Buffer, irradiance: &Buffer) -> Self {
        let picture = Bindings::new().buffer("FilmCaustic", caustic).buffer("FilmIrradiance", irradiance);
        Reference { picture, ..self }
    }

    fn record_grid(&self, recorder: &mut Recorder, bindings: &[&Bindings]) -> Result<(), GpuError> {
        let kernels = &self.kernels;
        let push = GridPush { slots: self.slots, buckets: self.buckets };
        let padded = self.buckets + SCAN_BLOCK;
        let blocks = padded / SCAN_BLOCK;
        recorder.pass("reference/clear")?.fill(&self.bucket_starts, 0);
        recorder.pass("reference/count")?.dispatch(&kernels.count, bindings, &push, self.slots)?;
        // One workgroup of 64 a block of 1024.
        recorder.pass("reference/scan_blocks")?.dispatch(&kernels.scan_blocks, bindings, &(), blocks * 64)?;
        recorder.pass("reference/scan_sums")?.dispatch(&kernels.scan_sums, bindings, &ScanPush { blocks }, 64)?;
        recorder.pass("reference/scan_add")?.dispatch(&kernels.scan_add, bindings, &(), padded)?;
        recorder.pass("reference/scatter")?.dispatch(&kernels.scatter, bindings, &push, self.slots)?;
        Ok(())
    }
}

/// The radius that holds `neighbours` of `photons` photons spread over an area as large as all specular surfaces.
fn density_radius(scene: &Scene, neighbours: f32, photons: u32) -> f32 {
    let area: f32 = scene
        .instances
        .iter()
        .filter(|i| scene.materials[i.material].surface.is_specular())
        .map(|i| scene.area(i))
        .sum();
    (neighbours * area / (std::f32::consts::PI * photons.max(1) as f32)).sqrt().max(1e-6)
}

fn scene_diagonal(context: &Context<'_>) -> f32 {
    let diagonal = context.scene.bounds().diagonal();
    if diagonal.is_finite() { diagonal.max(1e-6) } else { 1e-6 }
}

/// The bits of `path_class` in `emit.comp.glsl`.
fn class_bits(paths: &str) -> u32 {
    match paths {
        "refracted-once" => 1,
        "refracted" => 1 | 2,
        "not-refracted-once" => 31 & !1,
        "reflected-once" => 4,
        "reflected" => 4 | 8,
        "mixed" => 16,
        _ => 31,
    }
}

impl Technique for Reference {
    /// Emission cells depend on where specular surfaces are, and with them the number of photons.
    fn restart(&mut self, context: &Context<'_>) -> Result<(), GpuError> {
        let picture = std::mem::take(&mut self.picture);
        // The old buffers go before there are new ones: both would be twice the memory.
        self.bindings = Bindings::new();
        *self = Reference { picture, ..Self::with(&self.settings, self.kernels.clone(), context)? };
        Ok(())
    }

    fn record(&mut self, frame: &Frame, recorder: &mut Recorder, index: u32) -> Result<(), GpuError> {
        if self.slots == 0 {
            return Ok(());
        }
        let bindings = [&frame.bindings, &self.bindings];
        let kernels = &self.kernels;
        let new_photons = index.is_multiple_of(self.reuse);
        if new_photons {
            recorder.pass("reference/clear-grid")?.fill(&self.grid, 0);
        }
        let prepare = PreparePush { new_grid: new_photons.into(), ..self.prepare };
        recorder.pass("reference/prepare")?.dispatch(&kernels.prepare, &bindings, &prepare, frame.slots())?;
        if new_photons {
            let emit = EmitPush { pass: index / self.reuse, ..self.emit };
            recorder.pass("reference/emit")?.dispatch(&kernels.emit, &bindings, &emit, self.slots)?;
            self.record_grid(recorder, &bindings)?;
        }
        let photons = (self.slots >> self.emit.split).max(1);
        let gather = GatherPush {
            slots: self.slots,
            buckets: self.buckets,
            alpha: self.alpha,
            flux_unit: (self.flux / photons as f32 / UNITS_PER_PHOTON).max(f32::MIN_POSITIVE),
            odd: index / self.reuse % 2,
        };
        recorder.pass("reference/gather")?.dispatch(&kernels.gather, &bindings, &gather, frame.slots())?;
        let resolve = ResolvePush { passes: index + 1 };
        let bindings = [&self.picture, &frame.bindings, &self.bindings];
        recorder.pass("reference/resolve")?.dispatch(&kernels.resolve, &bindings, &resolve, frame.slots())?;
        Ok(())
    }

    fn ledger(&self, samples: u32) -> Result<Vec<LedgerEntry>, GpuError> {
        let words: Vec<u32> = self.ledger.read(2 * LEDGER_NAMES.len())?;
        let scale = f64::from(self.emit.ledger_unit) / f64::from(samples.div_ceil(self.reuse).max(1));
        let entries = LEDGER_NAMES.iter().zip(words.chunks_exact(2)).map(|(name, pair)| LedgerEntry {
            name,
            watts: (f64::from(pair[1]) * 4_294_967_296.0 + f64::from(pair[0])) * scale,
        });
        Ok(std::iter::once(LedgerEntry { name: "emitted", watts: self.flux.into() }).chain(entries).collect())
    }

    fn second_half(&self, samples: u32) -> Option<u32> {
        let sets = samples / self.reuse;
        let rest = if sets % 2 == 1 { samples % self.reuse } else { 0 };
        (self.slots > 0).then_some(sets / 2 * self.reuse + rest)
    }

    fn warnings(&self) -> Result<Vec<String>, GpuError> {
        if self.slots == 0 {
            return Ok(vec!["no light reaches a specular object, so there is no caustic light".to_string()]);
        }
        Ok(Vec::new())
    }
}
