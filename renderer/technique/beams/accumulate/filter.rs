//! A low-pass filter for surface caustics, in image space (Liktor and Dachsbacher 2011, section 7): a Gaussian along rows,
//! then one along columns, each over pixels that see the same surface.

use super::Options;
use crate::frame::Frame;
use crate::gpu::{Bindings, Buffer, GpuError, Kernel, Recorder};
use crate::technique::Context;

crate::gpu_struct! {
    pub struct FilterPush {
        pub down: u32,
        pub radius: u32,
        pub falloff: f32,
        pub share: f32,
    }
}

/// Standard deviations beyond which a pixel is no neighbour: 0.3 % of a Gaussian lie there.
const REACH: f64 = 3.0;

pub struct Filter {
    areas: Kernel,
    spread: Kernel,
    /// Of the passes along rows and along columns.
    bindings: [Bindings; 2],
    push: FilterPush,
}

impl Filter {
    /// `None` where the options ask for none, and where slots are not pixels: with adaptive sampling.
    pub fn new(options: &Options, context: &Context<'_>) -> Result<Option<Self>, GpuError> {
        if options.filter <= 0.0 || context.frame.adaptive().is_some() {
            return Ok(None);
        }
        let device = context.device;
        let slots = u64::from(context.frame.slots());
        let areas = Buffer::new(device, "filter areas", 4 * slots)?;
        let between = Buffer::new(device, "filtered rows", 16 * slots)?;
        let found = context.frame.film.sample_irradiance();
        let pass =
            |from, to| Bindings::new().buffer("FilterAreas", &areas).buffer("FilterFrom", from).buffer("FilterTo", to);
        Ok(Some(Filter {
            areas: Kernel::new(device, "beams/filter_areas", "")?,
            spread: Kernel::new(device, "beams/filter", "")?,
            bindings: [pass(found, &between), pass(&between, found)],
            push: gaussian(options.filter.into()),
        }))
    }

    /// Records how the sample's irradiance, in the block `SampleIrradiance`, is spread.
    pub fn record(&self, frame: &Frame, recorder: &mut Recorder) -> Result<(), GpuError> {
        let bindings = |pass: usize| [&self.bindings[pass], &frame.bindings];
        recorder.pass("beams/filter_areas")?.dispatch(&self.areas, &bindings(0), &(), frame.slots())?;
        for pass in 0..2 {
            let push = FilterPush { down: pass as u32, ..self.push };
            recorder.pass("beams/filter")?.dispatch(&self.spread, &bindings(pass), &push, frame.slots())?;
        }
        Ok(())
    }
}

/// One of a standard deviation of `sigma` pixels.
fn gaussian(sigma: f64) -> FilterPush {
    let radius = (REACH * sigma).ceil();
    let falloff = 0.5 / (sigma * sigma);
    let beside: f64 = (1..=radius as u32).map(|k| (-f64::from(k * k) * falloff).exp()).sum();
    FilterPush { down: 0, radius: radius as u32, falloff: falloff as f32, share: (1.0 / (1.0 + 2.0 * beside)) as f32 }
}
