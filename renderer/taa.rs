//! Temporal anti-aliasing: a picture made of the samples of several frames.
//!
//! What a pixel shows is followed back from frame to frame by the motion of the first surface, and each frame is looked up
//! once, at the end of that way, by a cubic. A frame counts where the same instance is seen there at the distance at which
//! it is expected. Then:
//!
//! - Frames weigh less the further back they are, where the two halves of the window differ by more than successive frames
//!   do: that is light which moves, such as caustics under waves. All of the past weighs less where 5 x 5 pixels are brighter
//!   or darker than it: a lamp was switched. Else all frames weigh alike.
//! - Light of the past is drawn into the spread of the 3 x 3 pixels around in the frame at hand (variance clipping in YCoCg,
//!   Salvi 2016), so that light which has gone at once leaves no trail. Three standard deviations are wide, and keep the
//!   mean of light that is rare; frames are averaged in linear light for the same reason.
//!
//! The usual way carries one history from frame to frame, in which every frame leaves a trace for ever, and which is
//! filtered again at every step. A window of frames has an end: a frame depends on the window's frames alone, however it
//! is come to, and is as sharp after many frames as after one.

use std::cell::Cell;
use std::collections::VecDeque;
use std::ops::RangeInclusive;

use crate::animate::Previous;
use crate::film::SampleCounts;
use crate::frame::Frame;
use crate::gpu::{Bindings, Buffer, Device, GpuError, GpuStruct, Kernel, Layout, PassTime, Recorder};
use crate::trace::Tracer;
use crate::view::View;

/// Frames that a picture is made of where no number is given.
pub const DEFAULT_FRAMES: u32 = 8;
/// Those that are allowed.
pub const FRAMES: RangeInclusive<u32> = 2..=64;

/// What a picture is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TaaSettings {
    /// Frames, the one at hand among them.
    pub frames: u32,
    pub history: History,
}

/// Which frames are those before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum History {
    /// Of the scene's animation, by number: they are rendered where they have not been. A frame depends on its number
    /// alone.
    Numbered,
    /// Those that were shown before, whatever they were of: for a window. The film's own layers stay what they are.
    Shown,
}

crate::gpu_struct! {
    /// A frame's radiance at a pixel; see `kernels/taa/common.glsl`.
    pub struct TaaLight {
        pub radiance: [f32; 3],
        pub instance: u32,
    }
}

crate::gpu_struct! {
    /// Of what a pixel's centre shows, the motion and distances.
    pub struct TaaSeen {
        pub motion: [f32; 2],
        pub distance: f32,
        pub then: f32,
    }
}

crate::gpu_struct! {
    /// Where what a pixel shows was.
    pub struct TaaPlace {
        pub at: [f32; 2],
        pub distance: f32,
        pub instance: u32,
    }
}

crate::gpu_struct! {
    /// How luma went over the frames of the past.
    pub struct TaaRun {
        pub last: f32,
        pub recent: f32,
        pub older: f32,
        pub steps: f32,
    }
}

crate::gpu_struct! {
    pub struct TaaTakePush {
        pub samples: f32,
        pub counted: u32,
        pub volume: u32,
        pub padding0: u32,
    }
}

crate::gpu_struct! {
    pub struct TaaPush {
        pub width: u32,
        pub height: u32,
        pub weight: f32,
        pub back: u32,
        pub half_way: u32,
        pub padding0: u32,
        pub padding1: u32,
        pub padding2: u32,
    }
}

pub(crate) const LAYOUTS: [Layout; 6] =
    [TaaLight::LAYOUT, TaaSeen::LAYOUT, TaaPlace::LAYOUT, TaaRun::LAYOUT, TaaTakePush::LAYOUT, TaaPush::LAYOUT];

/// Bytes of each of these records, and of a sum.
const RECORD_BYTES: u64 = 16;

/// What is kept of a frame, all rows of it.
#[derive(Clone)]
struct Taken {
    lights: Buffer,
    seens: Buffer,
}

impl Taken {
    fn new(device: &Device, pixels: u64) -> Result<Self, GpuError> {
        Ok(Taken {
            lights: Buffer::new(device, "anti-aliasing: light of a frame", RECORD_BYTES * pixels)?,
            seens: Buffer::new(device, "anti-aliasing: motion of a frame", RECORD_BYTES * pixels)?,
        })
    }
}

/// The frame at hand and those before it.
pub struct Taa {
    settings: TaaSettings,
    size: (u32, u32),
    take: Kernel,
    begin: Kernel,
    measure: Kernel,
    weigh: Kernel,
    gather: Kernel,
    now: Taken,
    /// Samples of the frame at hand when it was taken; 0 where it has not been.
    taken: Cell<u32>,
    /// Newest last; with each its number, which go up by one.
    past: VecDeque<(u32, Taken)>,
    /// What is made of a picture on its way, and the sums that it ends in.
    scratch: Bindings,
    sums: Buffer,
}

impl Taa {
    /// For pictures of `size` pixels, with nothing taken. 32 B a pixel and frame.
    pub fn new(device: &Device, tracer: &Tracer, size: (u32, u32), settings: TaaSettings) -> Result<Self, GpuError> {
        let pixels = u64::from(size.0) * u64::from(size.1);
        let sums = Buffer::new(device, "anti-aliasing: sums", RECORD_BYTES * pixels)?;
        Ok(Taa {
            settings,
            size,
            take: Kernel::new(device, "taa/take", tracer.variant())?,
            begin: Kernel::new(device, "taa/begin", "")?,
            measure: Kernel::new(device, "taa/measure", "")?,
            weigh: Kernel::new(device, "taa/weigh", "")?,
            gather: Kernel::new(device, "taa/gather", "")?,
            now: Taken::new(device, pixels)?,
            taken: Cell::new(0),
            past: VecDeque::new(),
            scratch: Bindings::new()
                .buffer("TaaPlaces", &Buffer::new(device, "anti-aliasing: ways back", RECORD_BYTES * pixels)?)
                .buffer("TaaRuns", &Buffer::new(device, "anti-aliasing: light on ways back", RECORD_BYTES * pixels)?)
                .buffer("TaaFound", &Buffer::new(device, "anti-aliasing: lengths of ways back", 4 * pixels)?)
                .buffer("TaaWeights", &Buffer::new(device, "anti-aliasing: weights", 8 * pixels)?)
                .buffer("TaaSums", &sums),
            sums,
        })
    }

    /// Whether there are frames before the one at hand.
    pub fn has_past(&self) -> bool {
        !self.past.is_empty()
    }

    /// The frame at hand is begun anew.
    pub fn restart(&mut self) {
        self.taken.set(0);
    }

    /// Forgets the frames before, and begins anew.
    pub fn forget(&mut self) {
        self.past.clear();
        self.restart();
    }

    /// The first frame that is still to be rendered before `frame` is, where those of its window that are there are kept
    /// and all others forgotten.
    pub fn first_missing(&mut self, frame: u32) -> u32 {
        let first = frame.saturating_sub(self.settings.frames - 1);
        let newest = self.past.back().map(|(number, _)| *number);
        match newest.zip(self.past.front()) {
            Some((newest, &(oldest, _))) if oldest <= first && (first..frame).contains(&newest) => newest + 1,
            _ => {
                self.past.clear();
                first
            }
        }
    }

    /// Takes the frame at hand as it is after `done` samples, unless it has been; `bands` are all of the picture's, each
    /// with the view of the frame before.
    pub fn take<'a>(
        &self,
        device: &Device,
        previous: &Previous,
        done: u32,
        bands: impl Iterator<Item = (&'a Frame, View)>,
    ) -> Result<Vec<PassTime>, GpuError> {
        if self.taken.get() == done {
            return Ok(Vec::new());
        }
        let mut recorder = Recorder::new(device)?;
        for (frame, before) in bands {
            let counts = match frame.sample_counts(done) {
                SampleCounts::Same(_) => Vec::new(),
                SampleCounts::Each(counts) => counts,
            };
            let push = TaaTakePush {
                samples: done.max(1) as f32,
                counted: u32::from(!counts.is_empty()),
                volume: frame.film.has_volume().into(),
                padding0: 0,
            };
            let bindings = Bindings::new()
                .buffer("PreviousViews", &Buffer::from_slice(device, "view of the frame before", &[before])?)
                .buffer("SampleCounts", &Buffer::from_slice(device, "samples of pixels", &counts)?)
                .buffer("TaaLights", &self.now.lights)
                .buffer("TaaSeens", &self.now.seens);
            let all = [&frame.bindings, &previous.bindings, &bindings];
            recorder.pass("taa/take")?.dispatch(&self.take, &all, &push, frame.film.pixels())?;
        }
        let times = recorder.submit()?;
        self.taken.set(done);
        Ok(times)
    }

    /// What was taken becomes the newest frame before, by that number, and the frame at hand begins anew.
    pub fn keep(&mut self, device: &Device, number: u32) -> Result<(), GpuError> {
        if self.past.back().is_some_and(|(newest, _)| newest.wrapping_add(1) != number) {
            self.past.clear();
        }
        let full = self.past.len() + 1 >= self.settings.frames as usize;
        let oldest = if full { self.past.pop_front() } else { None };
        let next = match oldest {
            Some((_, buffers)) => buffers,
            None => Taken::new(device, u64::from(self.size.0) * u64::from(self.size.1))?,
        };
        self.past.push_back((number, std::mem::replace(&mut self.now, next)));
        self.restart();
        Ok(())
    }

    /// Makes the picture of what was taken and the frames before; those weigh 1 each, the one at hand `weight`.
    pub fn resolve(&self, device: &Device, weight: f32) -> Result<Vec<PassTime>, GpuError> {
        let ((width, height), frames) = (self.size, self.past.len() as u32 + 1);
        let none =
            TaaPush { width, height, weight, back: 0, half_way: frames / 2, padding0: 0, padding1: 0, padding2: 0 };
        let scratch = self.scratch.clone().buffer("TaaLights", &self.now.lights).buffer("TaaSeens", &self.now.seens);
        let mut recorder = Recorder::new(device)?;
        for (name, first, each) in
            [("taa/measure", &self.begin, &self.measure), ("taa/gather", &self.weigh, &self.gather)]
        {
            recorder.pass(name)?.dispatch(first, &[&scratch], &none, width * height)?;
            for (back, (_, past)) in (1..).zip(self.past.iter().rev()) {
                let past = Bindings::new().buffer("PastLights", &past.lights).buffer("PastSeens", &past.seens);
                let push = TaaPush { back, ..none };
                recorder.pass(name)?.dispatch(each, &[&scratch, &past], &push, width * height)?;
            }
        }
        recorder.submit()
    }

    /// The picture: a vec4 a pixel, radiance times weight and weight.
    pub fn sums(&self) -> &Buffer {
        &self.sums
    }

    /// The picture's radiance, W/(m2 sr), row by row.
    pub fn read(&self) -> Result<Vec<[f32; 3]>, GpuError> {
        let sums: Vec<[f32; 4]> = self.sums.read(self.size.0 as usize * self.size.1 as usize)?;
        Ok(sums.into_iter().map(picture_of).collect())
    }
}

/// A cubic has negative parts: where all else is dark, they are cut off.
fn picture_of([r, g, b, weight]: [f32; 4]) -> [f32; 3] {
    [r, g, b].map(|sum| (sum / weight).max(0.0))
}
