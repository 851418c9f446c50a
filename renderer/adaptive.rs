//! Adaptive sampling: samples go where pixels vary, and the mean stays unbiased.
//!
//! First a pilot, some samples of every pixel. Then the host decides once how many more each pixel gets
//! ([`allocation`]), and every further round holds as many samples as the picture has pixels, taken from one line in
//! which each pixel stands as often as it was given samples. So every round costs the same and has the same number of
//! slots; only what pixel a slot belongs to changes. `frame/list` writes that down, and `frame/merge` takes the round's
//! samples into the film, each pixel's in the order of its own sequence.

mod allocation;

use crate::film::{Film, SampleCounts, VISIBLE_LAYERS};
use crate::gpu::{Binding, Bindings, Buffer, Device, GpuError, Kernel, Recorder};

crate::gpu_struct! {
    /// Which sample of which pixel a slot stands for; see `kernels/shared/round.glsl`.
    pub struct RoundSample {
        pub pixel: u32,
        pub index: u32,
        pub jitter: [f32; 2],
    }
}

crate::gpu_struct! {
    /// A pixel's place in the line.
    pub struct PixelPlan {
        pub first_round: u32,
        pub first_place: u32,
        pub last_round: u32,
        pub last_place: u32,
    }
}

crate::gpu_struct! {
    pub struct RoundPush {
        pub pilot: u32,
        pub index: u32,
        pub padding0: u32,
        pub padding1: u32,
    }
}

/// What adaptive sampling did, for the record.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct AdaptiveStats {
    /// Samples that every pixel got first.
    pub pilot: u32,
    /// Rounds after the pilot.
    pub rounds: u32,
    /// Samples of a pixel: fewest, mean and most.
    pub least: u32,
    pub mean: f64,
    pub most: u32,
}

/// The rounds of one band.
pub struct Adaptive {
    /// What the frame's kernels write instead of the film: one round's samples, a slot each.
    round: Bindings,
    /// The same by the names under which `frame/merge` reads them, and what it keeps of pixels.
    pixel: Bindings,
    list: Kernel,
    merge: Kernel,
    plans: Buffer,
    moments: Buffer,
    width: u32,
    pixels: u32,
    samples: u32,
    pilot: u32,
    /// Empty before it is decided.
    line: Vec<PixelPlan>,
}

impl Adaptive {
    /// For `samples` samples a pixel in the mean, over a band that is `width` pixels wide.
    pub fn new(device: &Device, film: &Film, width: u32, samples: u32) -> Result<Self, GpuError> {
        let pixels = film.pixels();
        let zeroed = |name, bytes: u64| Buffer::zeroed(device, name, u64::from(pixels) * bytes);
        let plans = zeroed("pixel plans", size_of::<PixelPlan>() as u64)?;
        let moments = zeroed("pilot moments", size_of::<[f32; 2]>() as u64)?;
        let direct = zeroed("round direct", 16 * VISIBLE_LAYERS)?;
        let albedo = zeroed("round albedo", 16)?;
        let normal = zeroed("round normal", 16)?;
        let volume = zeroed("round volume", if film.has_volume() { 16 * VISIBLE_LAYERS } else { 0 })?;
        let round = Bindings::new()
            .buffer("FilmDirect", &direct)
            .buffer("FilmAlbedo", &albedo)
            .buffer("FilmNormal", &normal)
            .buffer("FilmVolume", &volume);
        let pixel = Bindings::new()
            .buffer("RoundDirect", &direct)
            .buffer("RoundAlbedo", &albedo)
            .buffer("RoundNormal", &normal)
            .buffer("RoundVolume", &volume)
            .buffer("PixelPlans", &plans)
            .buffer("PilotMoments", &moments);
        Ok(Adaptive {
            round,
            pixel,
            list: Kernel::new(device, "frame/list", "")?,
            merge: Kernel::new(device, "frame/merge", "")?,
            plans,
            moments,
            width,
            pixels,
            samples,
            pilot: allocation::pilot(samples),
            line: Vec::new(),
        })
    }

    /// Forgets the pilot and what it decided.
    pub fn clear(&mut self, device: &Device) -> Result<(), GpuError> {
        self.line.clear();
        let mut recorder = Recorder::new(device)?;
        let mut pass = recorder.pass("film/clear")?;
        pass.fill(&self.plans, 0).fill(&self.moments, 0);
        for block in ["FilmDirect", "FilmAlbedo", "FilmNormal", "FilmVolume"] {
            if let Some(Binding::Buffer(buffer)) = self.round.get(block) {
                pass.fill(buffer, 0);
            }
        }
        drop(pass);
        recorder.submit()?;
        Ok(())
    }

    /// What takes the place of the film for the kernels that find one round's samples.
    pub fn round_bindings(&self) -> &Bindings {
        &self.round
    }

    /// Records the list of round `index`. The first one after the pilot reads the pilot back and decides.
    pub fn record_list(&mut self, recorder: &mut Recorder, frame: &Bindings, index: u32) -> Result<(), GpuError> {
        if index >= self.pilot && self.line.is_empty() {
            let moments: Vec<[f32; 2]> = self.moments.read(self.pixels as usize)?;
            let squares: Vec<f32> = moments.into_iter().map(|[_, squares]| squares).collect();
            let extra = allocation::extra_samples(&squares, self.width, self.pilot, self.samples);
            self.line = allocation::line(&extra);
            self.plans.upload(bytemuck::cast_slice(&self.line))?;
        }
        let bindings = [&self.pixel, frame];
        recorder.pass("frame/list")?.dispatch(&self.list, &bindings, &self.push(index), self.pixels)?;
        Ok(())
    }

    /// Records how round `index` enters the film.
    pub fn record_merge(&self, recorder: &mut Recorder, frame: &Bindings, index: u32) -> Result<(), GpuError> {
        let bindings = [&self.pixel, frame];
        recorder.pass("frame/merge")?.dispatch(&self.merge, &bindings, &self.push(index), self.pixels)?;
        Ok(())
    }

    fn push(&self, index: u32) -> RoundPush {
        RoundPush { pilot: self.pilot, index, padding0: 0, padding1: 0 }
    }

    /// Samples of each pixel after `done` rounds, the pilot's included.
    pub fn counts(&self, done: u32) -> SampleCounts {
        let Some(rounds) = done.checked_sub(self.pilot).filter(|_| !self.line.is_empty()) else {
            return SampleCounts::Same(done);
        };
        let count = |plan| self.pilot + allocation::taken(plan, rounds, self.pixels);
        SampleCounts::Each(self.line.iter().map(count).collect())
    }
}

impl AdaptiveStats {
    /// Of all bands, each given by its pilot's samples and its pixels' counts after `done` rounds.
    pub fn new(bands: &[&Adaptive], done: u32) -> Option<Self> {
        let pilot = bands.first()?.pilot.min(done);
        let counts: Vec<u32> = bands
            .iter()
            .flat_map(|band| {
                let counts = band.counts(done);
                (0..band.pixels as usize).map(move |pixel| counts.of(pixel)).collect::<Vec<_>>()
            })
            .collect();
        Some(AdaptiveStats {
            pilot,
            rounds: done - pilot,
            least: counts.iter().copied().min()?,
            mean: counts.iter().map(|&n| f64::from(n)).sum::<f64>() / counts.len() as f64,
            most: counts.iter().copied().max()?,
        })
    }
}
