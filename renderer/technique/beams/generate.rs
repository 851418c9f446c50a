//! From lights to beams: a lattice over what each light sees, refined where beams have to be narrow, whose vertices are
//! followed from surface to surface.

use super::accumulate::BeamBuffers;
use super::beam::{Beam, BeamHeader};
use super::kernels::Kernels;
use crate::frame::Frame;
use crate::gpu::{Bindings, Buffer, GpuError, GpuStruct, Layout, Recorder};
use crate::light_view::LightViews;
use crate::random;
use crate::scene::{Emitter, Scene};
use crate::technique::{Context, CounterEntry, LedgerEntry, Settings, double_words};

/// Places of leaves, or leaves, that one workgroup counts and writes.
const BLOCK: u32 = 64;
/// Of one entry of the block `BeamSizes`.
const SIZE_BYTES: u64 = 16;
/// Points along a side of a coarse cell at which the light through it is taken: an image of 512 texels across 16 cells has
/// each texel met.
const CELL_POINTS: u32 = 32;
/// Ledger units in all light at the most: half the range of a word, so that no single entry wraps twice.
const LEDGER_UNITS: f32 = 2_147_483_648.0;
/// Places on the lattice where a vertex can be, at least: rooms are not made larger than that.
const RECORDS_PER_VERTEX: u32 = 4;

const TALLY_NAMES: [&str; 7] = [
    "total_reflections",
    "branches_cut",
    "rejected_wrong_side",
    "non_finite",
    "beams_silhouette",
    "beams_too_wide",
    "refinements_dropped",
];
/// Words of tallies before the ledger, as in `ledger.glsl`.
const TALLY_COUNT: usize = 8;
const LEDGER_NAMES: [&str; 8] =
    ["missed", "landed", "absorbed", "scattered", "escaped", "cut", "silhouette", "emitted"];

crate::gpu_struct! {
    /// What stays for a set of beams; see `kernels/technique/beams/common.glsl`.
    pub struct BeamSettings {
        pub views: u32,
        pub grid: u32,
        pub levels: u32,
        pub sheets: u32,
        pub vertices: u32,
        pub records: u32,
        pub leaves: u32,
        pub beams: u32,
        pub rules: u32,
        pub least_level: u32,
        pub cos_normal: f32,
        pub depth: f32,
        pub convergence: f32,
        pub energy: f32,
        pub pixels: f32,
        pub deviation: f32,
        pub pattern: f32,
        pub cutoff: f32,
        pub reach: f32,
        pub ledger_unit: f32,
        pub extent: f32,
        pub margin: u32,
        pub buffered: u32,
        pub corners: u32,
    }
}

crate::gpu_struct! {
    /// What the stages of refinement hand on.
    #[derive(Default)]
    pub struct BeamState {
        pub groups_x: u32,
        pub groups_y: u32,
        pub groups_z: u32,
        pub traced: u32,
        pub vertices: u32,
        pub records: u32,
        pub leaves: u32,
        pub waiting: u32,
    }
}

crate::gpu_struct! {
    pub struct LatticePlace {
        pub view: u32,
        pub column: u32,
        pub row: u32,
        pub hidden: u32,
    }
}

crate::gpu_struct! {
    /// One ray of a lattice vertex; see `kernels/technique/beams/vertex.glsl`.
    pub struct BeamVertex {
        pub position: [f32; 3],
        pub normal: u32,
        pub direction: [f32; 3],
        pub distance: f32,
        pub throughput: [f32; 3],
        pub medium: u32,
        pub source: u32,
        pub target: u32,
        pub primitive: u32,
        pub barycentrics: u32,
    }
}

crate::gpu_struct! {
    /// A triangle of the lattice that is not split.
    pub struct BeamLeaf {
        pub vertices: [u32; 3],
        pub cell: u32,
        pub power: [f32; 3],
        pub padding0: u32,
    }
}

crate::gpu_struct! {
    pub struct RayArea {
        pub area: [f32; 3],
        pub flux: f32,
        pub gain: f32,
        pub padding0: u32,
        pub padding1: u32,
        pub padding2: u32,
    }
}

crate::gpu_struct! {
    pub struct StagePush {
        pub jitter: [f32; 2],
        pub stage: u32,
        pub padding0: u32,
    }
}

crate::gpu_struct! {
    pub struct JitterPush {
        pub jitter: [f32; 2],
        pub padding0: u32,
        pub padding1: u32,
    }
}

crate::gpu_struct! {
    pub struct CellsPush {
        pub jitter: [f32; 2],
        pub points: u32,
        pub padding0: u32,
    }
}

crate::gpu_struct! {
    pub struct BeamScanPush {
        pub blocks: u32,
        pub total: u32,
    }
}

pub const LAYOUTS: &[Layout] = &[
    BeamSettings::LAYOUT,
    BeamState::LAYOUT,
    LatticePlace::LAYOUT,
    BeamVertex::LAYOUT,
    BeamLeaf::LAYOUT,
    RayArea::LAYOUT,
    StagePush::LAYOUT,
    JitterPush::LAYOUT,
    CellsPush::LAYOUT,
    BeamScanPush::LAYOUT,
];

/// Makes sets of beams for one scene and camera.
pub struct Generator {
    kernels: Kernels,
    pub(super) bindings: Bindings,
    pub beams: BeamBuffers,
    state: Buffer,
    lattice_map: Buffer,
    vertex_fans: Buffer,
    sheet_counts: Buffer,
    tallies: Buffer,
    cell_fluxes: Buffer,
    scan_totals: Buffer,
    sizes: Buffer,
    settings: BeamSettings,
    jittered: bool,
    seed: u32,
}

impl Generator {
    pub fn new(settings: &Settings, context: &Context<'_>, views: &LightViews) -> Result<Self, GpuError> {
        let kernels = Kernels::new(context)?;
        Self::with(settings, kernels, context, views)
    }

    /// The same for a scene, camera or lights that have changed.
    pub fn restart(&mut self, settings: &Settings, context: &Context<'_>, views: &LightViews) -> Result<(), GpuError> {
        // The old buffers go before there are new ones: both would be twice the memory.
        self.bindings = Bindings::new();
        *self = Self::with(settings, self.kernels.clone(), context, views)?;
        Ok(())
    }

    fn with(
        settings: &Settings,
        kernels: Kernels,
        context: &Context<'_>,
        views: &LightViews,
    ) -> Result<Self, GpuError> {
        let device = context.device;
        let numbers = numbers(settings, context, views.views().len() as u32);
        let BeamSettings { views: view_count, grid, levels, sheets, .. } = numbers;
        let room = |name: &str, items: u64, bytes: usize| Buffer::new(device, name, items.max(1) * bytes as u64);
        let side = u64::from(grid << levels) + 1;
        let lattice_map = room("beams lattice", u64::from(view_count) * side * side, 4)?;
        let vertices = u64::from(numbers.vertices);
        let cells = u64::from(view_count * grid * grid);
        let beams = BeamBuffers {
            beams: room("beams", numbers.beams.into(), size_of::<Beam>())?,
            header: Buffer::zeroed(device, "beams header", size_of::<BeamHeader>() as u64)?,
            capacity: numbers.beams,
        };
        let blocks = u64::from(place_blocks(&numbers)).max(u64::from(sheets * leaf_blocks(&numbers)));
        let state = Buffer::zeroed(device, "beams state", size_of::<BeamState>() as u64)?;
        let vertex_fans = room("beams fans", 8 * vertices, 4)?;
        let sheet_counts = Buffer::zeroed(device, "beams sheet counts", 4 * u64::from(sheets))?;
        let tallies = Buffer::zeroed(device, "beams tallies", 4 * (TALLY_COUNT + 2 * LEDGER_NAMES.len()) as u64)?;
        let cell_fluxes = Buffer::zeroed(device, "beams cell fluxes", 16 * cells.max(1))?;
        let scan_totals = Buffer::zeroed(device, "beams scan totals", 8)?;
        let sizes = Buffer::zeroed(device, "beams sizes", 3 * SIZE_BYTES)?;
        let bindings = views
            .bindings()
            .clone()
            .buffer("BeamSettingsBlock", &Buffer::from_slice(device, "beams settings", &[numbers])?)
            .buffer("BeamStates", &state)
            .buffer("LatticeMap", &lattice_map)
            .buffer("LatticePlaces", &room("beams places", vertices, size_of::<LatticePlace>())?)
            .buffer("BeamVertices", &room("beams rays", numbers.records.into(), size_of::<BeamVertex>())?)
            .buffer("SheetRecords", &room("beams sheets", vertices * u64::from(sheets), 4)?)
            .buffer("SheetCounts", &sheet_counts)
            .buffer("GenerationTallies", &tallies)
            .buffer("BeamLeaves", &room("beams leaves", numbers.leaves.into(), size_of::<BeamLeaf>())?)
            .buffer("VertexFans", &vertex_fans)
            .buffer("CellScales", &room("beams cell scales", cells, 16)?)
            .buffer("CellLeaves", &room("beams cell leaves", cells + 1, 4)?)
            .buffer("CellFluxes", &cell_fluxes)
            .buffer("BlockSums", &room("beams block sums", blocks, 4)?)
            .buffer("ScanTotals", &scan_totals)
            .buffer("BeamSizes", &sizes)
            .buffer("RayAreas", &room("beams areas", numbers.records.into(), size_of::<RayArea>())?)
            .buffer("Beams", &beams.beams)
            .buffer("BeamHeaders", &beams.header);
        Ok(Generator {
            kernels,
            bindings,
            beams,
            state,
            lattice_map,
            vertex_fans,
            sheet_counts,
            tallies,
            cell_fluxes,
            scan_totals,
            sizes,
            settings: numbers,
            jittered: jitters(settings),
            seed: random::combine(context.seed, 0x6265_616d),
        })
    }

    /// Whether any light reaches anything specular.
    pub fn has_light(&self) -> bool {
        self.settings.views > 0
    }

    /// Records how the beams of a set are made.
    pub fn record(&self, frame: &Frame, recorder: &mut Recorder, set: u32) -> Result<(), GpuError> {
        let jitter = if self.jittered { random::sample_2d(set, self.seed) } else { [0.0; 2] };
        let mut pass = recorder.pass("beams/clear")?;
        for buffer in [&self.state, &self.lattice_map, &self.vertex_fans, &self.sheet_counts] {
            pass.fill(buffer, 0);
        }
        drop(pass);
        self.record_refinement(frame, recorder, jitter)?;
        self.record_beams(frame, recorder, jitter)
    }

    fn record_refinement(&self, frame: &Frame, recorder: &mut Recorder, jitter: [f32; 2]) -> Result<(), GpuError> {
        let kernels = &self.kernels;
        let bindings = [&frame.bindings, &self.bindings];
        let BeamSettings { views, grid, levels, .. } = self.settings;
        recorder.pass("beams/corners")?.dispatch(&kernels.corners, &bindings, &(), views * (grid + 1) * (grid + 1))?;
        self.record_trace(frame, recorder, jitter)?;
        for stage in 0..2 * levels {
            let push = StagePush { jitter, stage, padding0: 0 };
            let candidates = views * stage_size(grid, stage);
            recorder.pass("beams/split")?.dispatch(&kernels.split, &bindings, &push, candidates)?;
            self.record_trace(frame, recorder, jitter)?;
        }
        for stage in (0..(2 * levels).saturating_sub(1)).rev() {
            let push = StagePush { jitter, stage, padding0: 0 };
            let candidates = views * stage_size(grid, stage);
            recorder.pass("beams/close")?.dispatch(&kernels.close, &bindings, &push, candidates)?;
        }
        self.record_trace(frame, recorder, jitter)
    }

    /// Follows the rays of all vertices that are new.
    fn record_trace(&self, frame: &Frame, recorder: &mut Recorder, jitter: [f32; 2]) -> Result<(), GpuError> {
        let bindings = [&frame.bindings, &self.bindings];
        let push = JitterPush { jitter, padding0: 0, padding1: 0 };
        recorder.pass("beams/advance")?.dispatch(&self.kernels.advance, &bindings, &(), 1)?;
        recorder.pass("beams/trace")?.dispatch_indirect(&self.kernels.trace, &bindings, &push, &self.state, 0)?;
        Ok(())
    }

    fn record_beams(&self, frame: &Frame, recorder: &mut Recorder, jitter: [f32; 2]) -> Result<(), GpuError> {
        let kernels = &self.kernels;
        let bindings = [&frame.bindings, &self.bindings];
        let BeamSettings { views, grid, .. } = self.settings;
        let places = place_blocks(&self.settings);
        let push = JitterPush { jitter, padding0: 0, padding1: 0 };
        let cells = CellsPush { jitter, points: CELL_POINTS, padding0: 0 };
        recorder.pass("beams/count_leaves")?.dispatch(&kernels.count_leaves, &bindings, &(), places * BLOCK)?;
        let scan = BeamScanPush { blocks: places, total: 0 };
        recorder.pass("beams/scan")?.dispatch(&kernels.scan, &bindings, &scan, BLOCK)?;
        recorder.pass("beams/write_leaves")?.dispatch(&kernels.write_leaves, &bindings, &push, places * BLOCK)?;
        recorder.pass("beams/cells")?.dispatch(&kernels.cells, &bindings, &cells, views * grid * grid)?;
        recorder.pass("beams/size")?.dispatch(&kernels.size, &bindings, &(), 1)?;
        let sizes = &self.sizes;
        let [leaves, sheets, rays] = [0, SIZE_BYTES, 2 * SIZE_BYTES];
        recorder.pass("beams/areas")?.dispatch_indirect(&kernels.areas, &bindings, &(), sizes, rays)?;
        recorder.pass("beams/count_beams")?.dispatch_indirect(&kernels.count_beams, &bindings, &(), sizes, sheets)?;
        let scan = BeamScanPush { blocks: 0, total: 1 };
        recorder.pass("beams/scan")?.dispatch(&kernels.scan, &bindings, &scan, BLOCK)?;
        recorder.pass("beams/write_beams")?.dispatch_indirect(&kernels.write_beams, &bindings, &(), sizes, sheets)?;
        recorder.pass("beams/ledger")?.dispatch_indirect(&kernels.ledger, &bindings, &(), sizes, leaves)?;
        Ok(())
    }

    /// Where the light of one set went on average, after what was emitted; W of the mean channel.
    pub fn ledger(&self, sets: u32) -> Result<Vec<LedgerEntry>, GpuError> {
        let words: Vec<u32> = self.tallies.read(TALLY_COUNT + 2 * LEDGER_NAMES.len())?;
        let scale = f64::from(self.settings.ledger_unit) / f64::from(sets.max(1));
        let entries = LEDGER_NAMES.iter().zip(double_words(&words[TALLY_COUNT..]));
        let mut entries: Vec<LedgerEntry> =
            entries.map(|(name, units)| LedgerEntry { name, watts: units * scale }).collect();
        entries.rotate_right(1);
        Ok(entries)
    }

    /// W through each cell of the coarse grids, rgb, of the last set.
    pub fn cell_flux(&self) -> Result<Vec<[f64; 3]>, GpuError> {
        let BeamSettings { views, grid, .. } = self.settings;
        let fluxes: Vec<[f32; 4]> = self.cell_fluxes.read((views * grid * grid) as usize)?;
        Ok(fluxes.iter().map(|&[r, g, b, _]| [r.into(), g.into(), b.into()]).collect())
    }

    /// Of the last set, and of all sets what went wrong.
    pub fn counters(&self) -> Result<Vec<CounterEntry>, GpuError> {
        let state = self.state.read::<BeamState>(1)?.first().copied().unwrap_or_default();
        let totals: Vec<u32> = self.scan_totals.read(2)?;
        let words: Vec<u32> = self.tallies.read(TALLY_NAMES.len())?;
        let entry = |name, value: u32| CounterEntry { name, value: value.into() };
        let over = |asked: u32, room: u32| asked.saturating_sub(room);
        let BeamSettings { vertices, records, leaves, beams, .. } = self.settings;
        let mut entries = vec![
            entry("vertices", state.vertices.min(vertices)),
            entry("rays", state.records.min(records)),
            entry("leaves", state.leaves),
            entry("beams", totals[1].min(beams)),
            entry("vertices_dropped", over(state.vertices, vertices)),
            entry("rays_dropped", over(state.records, records)),
            entry("leaves_dropped", over(totals[0], leaves)),
            entry("beams_dropped", over(totals[1], beams)),
        ];
        entries.extend(TALLY_NAMES.iter().zip(words).map(|(name, value)| entry(name, value)));
        Ok(entries)
    }
}

/// What the kernels are told.
fn numbers(settings: &Settings, context: &Context<'_>, views: u32) -> BeamSettings {
    let grid = settings.integer("grid");
    let bounces = settings.integer("bounces");
    let range = context.device.info.limits.storage_range;
    let coarse = views * (grid + 1) * (grid + 1);
    let vertices = settings.integer("vertices").max(coarse);
    let fits = |bytes: usize| (range / bytes as u64).min(u32::MAX.into()) as u32;
    let records = (RECORDS_PER_VERTEX * vertices).min(fits(size_of::<BeamVertex>()));
    let leaves = (2 * vertices).min(fits(size_of::<BeamLeaf>()));
    let beams = (2 * records).min(fits(size_of::<Beam>()));
    BeamSettings {
        views,
        grid,
        levels: settings.integer("levels"),
        sheets: (2 << bounces) - 2,
        vertices,
        records,
        leaves,
        beams,
        rules: rules(settings),
        least_level: settings.integer("least_level").min(settings.integer("levels")),
        cos_normal: settings.number("normal").to_radians().cos(),
        depth: settings.number("depth"),
        convergence: settings.number("convergence"),
        energy: settings.number("energy"),
        pixels: settings.number("pixels"),
        deviation: settings.number("deviation"),
        pattern: settings.number("pattern"),
        cutoff: settings.number("cutoff"),
        reach: context.scene.reach(),
        ledger_unit: (most_flux(context.scene) / LEDGER_UNITS).max(f32::MIN_POSITIVE),
        extent: settings.number("extent"),
        margin: jitters(settings).into(),
        buffered: (settings.choice("light") != "rays").into(),
        corners: 3,
    }
}

/// Whether lattices move from set to set: not over texels that stay.
fn jitters(settings: &Settings) -> bool {
    settings.choice("jitter") == "on" && settings.choice("light") == "rays"
}

/// The bits of `RULE_*` in `common.glsl`.
fn rules(settings: &Settings) -> u32 {
    ["split_surface", "split_energy", "split_camera", "split_light", "split_deviation"]
        .iter()
        .enumerate()
        .map(|(bit, key)| u32::from(settings.choice(key) == "on") << bit)
        .sum()
}

/// W that all lights can send at the most, mean of the channels: what the ledger's unit goes by.
fn most_flux(scene: &Scene) -> f32 {
    let diagonal = scene.bounds().diagonal();
    let flux = |emitter: &Emitter| match emitter {
        Emitter::Point { intensity, .. } | Emitter::Spot { intensity, .. } => {
            4.0 * std::f32::consts::PI * intensity.element_sum() / 3.0
        }
        Emitter::Directional { irradiance, .. } => diagonal * diagonal * irradiance.element_sum() / 3.0,
    };
    scene.lights.iter().map(|light| flux(&light.emitter)).sum()
}

/// Candidates of a stage in one view, as in `stages.glsl`.
fn stage_size(grid: u32, stage: u32) -> u32 {
    let cells = grid << (stage / 2);
    if stage.is_multiple_of(2) { cells * cells } else { 2 * cells * (cells + 1) }
}

/// Blocks of the places where a leaf can be: eight a node, see `nodes.glsl`.
fn place_blocks(settings: &BeamSettings) -> u32 {
    let per_cell = 1 + ((1 << (2 * settings.levels)) - 1) / 3;
    (8 * settings.views * settings.grid * settings.grid * per_cell).div_ceil(BLOCK)
}

fn leaf_blocks(settings: &BeamSettings) -> u32 {
    settings.leaves.div_ceil(BLOCK)
}
