//! Light in volumes, L S+ V: photons that paths leave in media which scatter, gathered along the camera's paths.

use super::records::GatherVolumePush;
use super::sort::{SortKernels, Sorted};
use super::{MAX_RADIUS, scene_diagonal, specular_area};
use crate::frame::Frame;
use crate::gpu::{Bindings, GpuError, Kernel, Recorder};
use crate::technique::{Context, Settings};

/// Units of the integer sums in what a photon of mean flux can scatter: a photon of 10^-4 of it is still exact to 10^-3,
/// and the sum of 10^6 of them, 10^5 times as bright as the mean, does not overflow.
const UNITS_PER_PHOTON: f32 = 16_777_216.0;

/// The longest stretch over the first radius, at most.
const LONGEST_OVER_RADIUS: f32 = 10_000.0;

/// What cells go by, over the gathering radius: they are half to all of that.
const CELLS_OVER_RADIUS: f32 = 4.0;

/// Photons that one path leaves at most: beyond, they lie closer than the radius, and more of them tell nothing new.
const MOST_POINTS: u32 = 64;

/// Volume photons of one band.
pub struct Volume {
    /// Photons a path.
    pub points: u32,
    sorted: Sorted,
    gather: Kernel,
    first_radius: f32,
    alpha: f64,
    flux_unit: f32,
}

impl Volume {
    /// `None` where no medium scatters. `slots` paths of `flux` W (mean of the channels) in all leave photons.
    pub fn new(
        settings: &Settings,
        kernels: &SortKernels,
        context: &Context<'_>,
        slots: u32,
        flux: f32,
    ) -> Result<Option<Self>, GpuError> {
        let Context { device, scene, .. } = context;
        if !scene.scatters() || slots == 0 {
            return Ok(None);
        }
        let points = (settings.integer("volume_photons") / slots).clamp(1, MOST_POINTS);
        let photons = slots * points;
        let density = photons as f32 / specular_area(scene);
        let radius = (settings.number("volume_neighbours") / (std::f32::consts::PI * density)).sqrt();
        // A small object in a large room: the longest stretch still crosses some thousands of cells only.
        let least = (scene.reach() / LONGEST_OVER_RADIUS).max(1e-6);
        let most = (MAX_RADIUS * scene_diagonal(context)).max(least);
        let thickest = scene.media.iter().map(|m| m.scattering.max_element()).fold(0.0, f32::max);
        let scattered = (thickest * scene.reach()).min(1.0) * flux / photons as f32;
        Ok(Some(Volume {
            points,
            sorted: Sorted::new(device, kernels, "reference/volume-", photons)?,
            gather: Kernel::new(device, "reference/gather_volume", context.tracer.plain())?,
            first_radius: radius.clamp(least, most),
            alpha: settings.number("alpha").into(),
            flux_unit: (scattered / UNITS_PER_PHOTON).max(f32::MIN_POSITIVE),
        }))
    }

    /// Where paths leave their photons: the block `VolumePhotons`.
    pub fn bindings(&self) -> Bindings {
        Bindings::new().buffer("VolumePhotons", &self.sorted.photons)
    }

    /// Of set `set`, m: its square is taken times (i + alpha) / (i + 1) from set to set (Knaus and Zwicker 2011), which lets
    /// noise and blur both vanish.
    fn radius(&self, set: u32) -> f32 {
        let part: f64 = (1..=set).map(f64::from).map(|i| (i + self.alpha) / (i + 1.0)).product();
        (f64::from(self.first_radius) * part.sqrt()) as f32
    }

    /// Sorts the photons of set `set`.
    pub fn record_sort(&self, recorder: &mut Recorder, set: u32) -> Result<(), GpuError> {
        let size = CELLS_OVER_RADIUS * self.radius(set);
        recorder.pass("reference/volume-grid")?.fill(&self.sorted.grid, size.to_bits());
        self.sorted.record(recorder)
    }

    /// Takes the light that sample `index` sees into the block `FilmCausticVolume` of the leftmost bindings that have it.
    pub fn record_gather(
        &self,
        frame: &Frame,
        recorder: &mut Recorder,
        picture: &Bindings,
        (index, set): (u32, u32),
    ) -> Result<(), GpuError> {
        let push = GatherVolumePush {
            slots: self.sorted.slots,
            buckets: self.sorted.buckets,
            radius: self.radius(set),
            flux_unit: self.flux_unit,
            index,
        };
        let bindings = [picture, &frame.bindings, &self.sorted.bindings];
        recorder.pass("reference/gather_volume")?.dispatch(&self.gather, &bindings, &push, frame.slots())?;
        Ok(())
    }
}
