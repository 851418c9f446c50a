//! From beams to light on the film: the density of every beam that a visible point lies in, added up.

mod boxes;
mod counters;
mod depths;
mod filter;
mod hulls;
mod options;

pub use options::{Area, Bounds, Integral, Interval, Options, SETTINGS, Shadows, Tier};

use crate::film::VISIBLE_LAYERS;
use crate::frame::Frame;
use crate::gpu::{Bindings, Buffer, GpuError, GpuStruct, Kernel, Layout, Recorder};
use crate::technique::beams::kernels::by_media;
use crate::technique::{Context, CounterEntry, Settings};

use boxes::Boxes;
use depths::Depths;
use filter::Filter;
use hulls::Hulls;

/// The beams of a sample, wherever they come from.
#[derive(Clone)]
pub struct BeamBuffers {
    /// [`Beam`](super::beam::Beam)s. Accumulation is quick where those that follow each other are near each other.
    pub beams: Buffer,
    /// One [`BeamHeader`](super::beam::BeamHeader): how many there are.
    pub header: Buffer,
    /// Beams that there is room for.
    pub capacity: u32,
}

crate::gpu_struct! {
    /// What every kernel that works on tiles of slots is told.
    pub struct TilePush {
        pub capacity: u32,
        pub blocks: u32,
        pub listed: u32,
        pub drawn: u32,
        pub first: u32,
        pub padding0: u32,
        pub padding1: u32,
        pub padding2: u32,
    }
}

crate::gpu_struct! {
    /// How a beam's light is worked out; see `kernels/technique/beams/shade.glsl`.
    pub struct ShadePush {
        pub light_angle: f32,
        pub smooth_area: u32,
        pub shadows: u32,
        pub soft: f32,
    }
}

crate::gpu_struct! {
    /// How a beam's light in a medium is added up; see `kernels/technique/beams/inscatter.glsl`.
    pub struct VolumePush {
        pub scan_plane: u32,
        pub integral: u32,
        pub padding0: u32,
        pub padding1: u32,
    }
}

crate::gpu_struct! {
    pub struct VolumeLightPush {
        pub tile: TilePush,
        pub shade: ShadePush,
        pub volume: VolumePush,
    }
}

crate::gpu_struct! {
    pub struct LightPush {
        pub tile: TilePush,
        pub shade: ShadePush,
        pub jitter: [f32; 2],
        pub footprints: u32,
        pub parts: u32,
    }
}

pub const LAYOUTS: &[Layout] = &[
    TilePush::LAYOUT,
    ShadePush::LAYOUT,
    LightPush::LAYOUT,
    VolumePush::LAYOUT,
    VolumeLightPush::LAYOUT,
    boxes::BeamBox::LAYOUT,
    boxes::BoxesPush::LAYOUT,
    depths::BeamDepths::LAYOUT,
    depths::BeamDepthsPush::LAYOUT,
    hulls::Hull::LAYOUT,
    hulls::HullPush::LAYOUT,
    hulls::ExtrudePush::LAYOUT,
    filter::FilterPush::LAYOUT,
];

/// Slots of a tile, 8 x 8.
const TILE_SIDE: u32 = 8;
/// Tiles of a dispatch. Drivers and this program give up on what takes too long: smoke at 240x180, in one, took a busy
/// software device ten minutes.
const TILES_AT_ONCE: u32 = 512;

/// Adds up the light of beams; of one band.
pub struct Accumulator {
    shade: ShadePush,
    beams: BeamBuffers,
    boxes: Boxes,
    /// Where light is scattered in media of uneven density.
    depths: Option<Depths>,
    bindings: Bindings,
    tallies: Buffer,
    gather: Kernel,
    volume: Option<(Kernel, VolumePush)>,
    /// `None` where tiles look for all light.
    hulls: Option<Hulls>,
    filter: Option<Filter>,
    tiles: u32,
    listed: bool,
    footprints: bool,
}

impl Accumulator {
    /// For the beams in `beams`, as [`SETTINGS`] among `settings` say.
    pub fn new(settings: &Settings, context: &Context<'_>, beams: &BeamBuffers) -> Result<Self, GpuError> {
        Self::with_options(Options::of(settings), context, beams)
    }

    pub fn with_options(options: Options, context: &Context<'_>, beams: &BeamBuffers) -> Result<Self, GpuError> {
        let device = context.device;
        let tallies = Buffer::zeroed(device, "beam tallies", counters::BYTES)?;
        let bindings = Bindings::new()
            .buffer("Beams", &beams.beams)
            .buffer("BeamHeaders", &beams.header)
            .buffer("BeamTallies", &tallies);
        let boxes = Boxes::new(device, beams.capacity)?;
        let listed = context.frame.adaptive().is_some();
        let variant = context.tracer.variant();
        let volume = match context.frame.film.has_volume() {
            true => Some((
                Kernel::new(device, by_media(context, ["beams/gather_volume", "beams/gather_volume_grids"]), variant)?,
                volume_push(&options),
            )),
            false => None,
        };
        let shade = ShadePush {
            light_angle: options.light_angle,
            smooth_area: u32::from(options.area == Area::Vertex),
            shadows: u32::from(options.shadows == Shadows::Edges),
            soft: options.soft,
        };
        let uneven = volume.is_some() && !context.scene.densities.is_empty();
        let depths = uneven.then(|| Depths::new(device, beams)).transpose()?;
        let pushes = (shade, volume_push(&options));
        let hulls = Hulls::new(&options, context, beams, pushes)?;
        let drawn = hulls::drawn_bindings(device, hulls.as_ref())?;
        let mut bindings = bindings.and(boxes.bindings()).and(&drawn);
        if let Some(depths) = &depths {
            bindings = bindings.and(depths.bindings());
        }
        Ok(Accumulator {
            shade,
            hulls,
            filter: Filter::new(&options, context)?,
            beams: beams.clone(),
            bindings,
            boxes,
            depths,
            tallies,
            gather: Kernel::new(device, by_media(context, ["beams/gather", "beams/gather_grids"]), variant)?,
            volume,
            tiles: tiles(context.frame, listed),
            listed,
            footprints: options.footprints && !listed,
        })
    }

    /// What finds the beams.
    pub fn tier(&self) -> Tier {
        self.hulls.as_ref().map_or(Tier::Compute, Hulls::tier)
    }

    /// Forgets what was counted.
    pub fn restart(&mut self, context: &Context<'_>) -> Result<(), GpuError> {
        let mut recorder = Recorder::new(context.device)?;
        recorder.pass("beams/clear")?.fill(&self.tallies, 0);
        recorder.submit()?;
        Ok(())
    }

    /// Records how the beams' light comes to the sample's visible points: afterwards the block `SampleIrradiance` holds it,
    /// W/m2, and where the scene scatters `SampleVolume` what comes to the camera from media. `new_beams`: they have changed since the sample before.
    pub fn record(&self, frame: &Frame, recorder: &mut Recorder, new_beams: bool) -> Result<(), GpuError> {
        let bindings = [&frame.bindings, &self.bindings];
        if new_beams {
            self.boxes.record(recorder, &bindings)?;
            self.depths.as_ref().map_or(Ok(()), |depths| depths.record(recorder, &bindings))?;
        }
        if let Some(hulls) = &self.hulls {
            hulls.record(frame, recorder, &bindings)?;
        }
        for first in (0..self.tiles).step_by(TILES_AT_ONCE as usize) {
            let tiles = (self.tiles - first).min(TILES_AT_ONCE);
            let tile = self.tile_push(first);
            // Hulls bring light to points, not to what pixels cover.
            let push = LightPush {
                tile: TilePush { drawn: if self.footprints { 0 } else { tile.drawn }, ..tile },
                shade: self.shade,
                jitter: frame.jitter(),
                footprints: self.footprints.into(),
                parts: TILE_SIDE,
            };
            let invocations = tiles * TILE_SIDE * TILE_SIDE;
            recorder.pass("beams/gather")?.dispatch(&self.gather, &bindings, &push, invocations)?;
            if let Some((kernel, volume)) = &self.volume {
                let push = VolumeLightPush { tile, shade: self.shade, volume: *volume };
                recorder.pass("beams/gather_volume")?.dispatch(kernel, &bindings, &push, invocations)?;
            }
        }
        self.filter.as_ref().map_or(Ok(()), |filter| filter.record(frame, recorder))
    }

    /// For tiles from `first` on.
    fn tile_push(&self, first: u32) -> TilePush {
        TilePush {
            capacity: self.beams.capacity,
            blocks: self.boxes.blocks(),
            listed: u32::from(self.listed),
            drawn: u32::from(self.hulls.is_some()),
            first,
            padding0: 0,
            padding1: 0,
            padding2: 0,
        }
    }

    /// What was counted over all samples so far.
    pub fn counters(&self) -> Result<Vec<CounterEntry>, GpuError> {
        counters::read(&self.tallies)
    }
}

fn volume_push(options: &Options) -> VolumePush {
    VolumePush {
        scan_plane: u32::from(options.interval == Interval::ScanPlane),
        integral: options.integral as u32,
        padding0: 0,
        padding1: 0,
    }
}

/// Tiles of all layers, as `kernels/technique/beams/tile.glsl` has them.
fn tiles(frame: &Frame, listed: bool) -> u32 {
    let (width, rows) = frame.film.size();
    let one =
        if listed { frame.film.pixels().div_ceil(64) } else { width.div_ceil(TILE_SIDE) * rows.div_ceil(TILE_SIDE) };
    one * VISIBLE_LAYERS as u32
}
