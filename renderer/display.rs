//! The film as 8-bit values for a screen, made on the device: four bytes a pixel come back instead of all layers.

use crate::film::Film;
use crate::gpu::{Bindings, Buffer, Device, GpuError, Kernel, Recorder};
use crate::image::tone::REINHARD_WHITE;
use crate::scene::{FilmSettings, ToneCurve};

crate::gpu_struct! {
    /// See `kernels/frame/display.comp.glsl`.
    pub struct DisplayPush {
        pub pixels: u32,
        pub curve: u32,
        pub samples: f32,
        pub gain: f32,
        pub white: f32,
        pub volume: u32,
        pub summed: u32,
        pub padding1: u32,
    }
}

/// How linear radiance is shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// Stops.
    pub exposure: f32,
    pub tone_curve: ToneCurve,
}

impl From<&FilmSettings> for Look {
    fn from(film: &FilmSettings) -> Self {
        Look { exposure: film.exposure, tone_curve: film.tone_curve }
    }
}

/// Makes a display's picture of a film.
pub struct Display {
    kernel: Kernel,
    pixels: Option<Buffer>,
    device: Device,
}

impl Display {
    pub fn new(device: &Device) -> Result<Self, GpuError> {
        Ok(Display { kernel: Kernel::new(device, "frame/display", "")?, pixels: None, device: device.clone() })
    }

    /// The film's final layer as 8-bit sRGB with alpha 255, row by row. `samples`: those of every pixel, at least 1.
    ///
    /// Within one step of 255 of what [`crate::image::tone::display`] makes of the same radiance: a device's `pow` is its
    /// own.
    pub fn read(&mut self, film: &Film, samples: u32, look: Look) -> Result<Vec<[u8; 4]>, GpuError> {
        let of = DisplayPush { samples: samples.max(1) as f32, volume: film.has_volume().into(), ..push(look) };
        // What is not looked at is bound to anything.
        let bindings = film.bindings.clone().buffer("TaaSums", film.sample_irradiance());
        self.make(bindings, DisplayPush { pixels: film.pixels(), ..of })
    }

    /// The same of a picture of vec4 sums, radiance times weight and weight.
    pub fn read_sums(&mut self, sums: &Buffer, pixels: u32, look: Look) -> Result<Vec<[u8; 4]>, GpuError> {
        let mut bindings = Bindings::new().buffer("TaaSums", sums);
        for name in ["FilmDirect", "FilmCaustic", "FilmVolume", "FilmCausticVolume"] {
            bindings = bindings.buffer(name, sums);
        }
        self.make(bindings, DisplayPush { pixels, summed: 1, ..push(look) })
    }

    fn make(&mut self, bindings: Bindings, push: DisplayPush) -> Result<Vec<[u8; 4]>, GpuError> {
        let bytes = 4 * u64::from(push.pixels);
        let buffer = match self.pixels.take().filter(|buffer| buffer.size() >= bytes) {
            Some(buffer) => buffer,
            None => Buffer::new(&self.device, "display pixels", bytes)?,
        };
        let bindings = bindings.buffer("DisplayPixels", &buffer);
        let mut recorder = Recorder::new(&self.device)?;
        recorder.pass("frame/display")?.dispatch(&self.kernel, &[&bindings], &push, push.pixels)?;
        recorder.submit()?;
        let read = buffer.read(push.pixels as usize);
        self.pixels = Some(buffer);
        read
    }
}

/// Of no pixels.
fn push(look: Look) -> DisplayPush {
    DisplayPush {
        pixels: 0,
        curve: match look.tone_curve {
            ToneCurve::Linear => 0,
            ToneCurve::Reinhard => 1,
        },
        samples: 1.0,
        gain: look.exposure.exp2(),
        white: REINHARD_WHITE,
        volume: 0,
        summed: 0,
        padding1: 0,
    }
}
