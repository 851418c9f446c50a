//! Adaptive beam tracing (Liktor and Dachsbacher 2011): light between neighbouring rays, in volumes and on surfaces.

pub mod accumulate;
pub mod beam;
pub mod generate;
pub mod inspect;
mod kernels;
mod settings;

pub use settings::SETTINGS;

use super::{Context, CounterEntry, LedgerEntry, Settings, Technique};
use crate::frame::Frame;
use crate::gpu::{GpuError, Layout, Recorder};
use crate::light_view::{LightViewTier, LightViews};
use accumulate::Accumulator;
use generate::Generator;

/// What the technique shares with its kernels.
pub fn layouts() -> impl Iterator<Item = Layout> {
    [beam::LAYOUTS, generate::LAYOUTS, accumulate::LAYOUTS].into_iter().flatten().copied()
}

/// The technique's state for one band.
pub struct Beams {
    settings: Settings,
    views: LightViews,
    generator: Generator,
    accumulator: Accumulator,
    reuse: u32,
    /// Whether the views' texels are looked up.
    buffered: bool,
    /// Whether light was to be filtered and is not.
    unfiltered: bool,
}

const UNFILTERED: &str = "beams.filter is left out with --adaptive: a sample's neighbours are not its pixel's there";

/// Texels along a side of a light's view where none are looked up, the fewest there can be.
const UNUSED_TEXELS: u32 = 2;

/// Texels along a side of a light's view: one at each place where a vertex can be.
fn texels(settings: &Settings) -> u32 {
    (settings.integer("grid") << settings.integer("levels")) + 1
}

impl Beams {
    pub fn new(settings: &Settings, context: &Context<'_>) -> Result<Self, GpuError> {
        let (tier, resolution) = match settings.choice("light") {
            "raster" => (LightViewTier::Auto, texels(settings)),
            "cast" => (LightViewTier::Rays, texels(settings)),
            _ => (LightViewTier::Rays, UNUSED_TEXELS),
        };
        let views = LightViews::new(context.device, context.scene, context.tracer, resolution, tier)?;
        let generator = Generator::new(settings, context, &views)?;
        let accumulator = Accumulator::new(settings, context, &generator.beams)?;
        Ok(Beams {
            settings: settings.clone(),
            views,
            generator,
            accumulator,
            reuse: settings.integer("reuse"),
            buffered: settings.choice("light") != "rays",
            unfiltered: settings.number("filter") > 0.0 && context.frame.adaptive().is_some(),
        })
    }
}

impl Technique for Beams {
    fn restart(&mut self, context: &Context<'_>) -> Result<(), GpuError> {
        self.views.restart(context.device, context.scene)?;
        self.generator.restart(&self.settings, context, &self.views)?;
        self.accumulator = Accumulator::new(&self.settings, context, &self.generator.beams)?;
        Ok(())
    }

    fn record(&mut self, frame: &Frame, recorder: &mut Recorder, index: u32) -> Result<(), GpuError> {
        if self.generator.has_light() {
            let new_beams = index.is_multiple_of(self.reuse);
            if new_beams && self.buffered {
                self.views.record(recorder, &frame.bindings)?;
            }
            if new_beams {
                self.generator.record(frame, recorder, index / self.reuse)?;
            }
            self.accumulator.record(frame, recorder, new_beams)?;
        }
        frame.record_caustic(recorder, index)
    }

    fn ledger(&self, samples: u32) -> Result<Vec<LedgerEntry>, GpuError> {
        self.generator.ledger(samples.div_ceil(self.reuse))
    }

    fn counters(&self) -> Result<Vec<CounterEntry>, GpuError> {
        let mut counters = self.generator.counters()?;
        counters.extend(self.accumulator.counters()?);
        Ok(counters)
    }

    fn second_half(&self, samples: u32) -> Option<u32> {
        self.generator.has_light().then_some(samples / 2)
    }

    fn warnings(&self) -> Result<Vec<String>, GpuError> {
        if !self.generator.has_light() {
            return Ok(vec!["no light reaches a specular object, so there is no caustic light".to_string()]);
        }
        let dropped =
            self.counters()?.into_iter().filter(|entry| entry.value > 0.0 && entry.name.ends_with("_dropped"));
        let dropped = dropped.map(|entry| {
            let what = entry.name.trim_end_matches("_dropped");
            if what == "refinements" {
                return "beams had no room to be as fine as asked for: beams.vertices makes some, as far as the device's \
                        storage goes"
                    .to_string();
            }
            format!("beams had no room for {} {what}; some light may be missing", entry.value)
        });
        let unfiltered = self.unfiltered.then(|| UNFILTERED.to_string());
        Ok(dropped.chain(unfiltered).collect())
    }
}
