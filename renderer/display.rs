//! The film as 8-bit values for a screen, made on the device: four bytes a pixel come back instead of all layers.

use crate::film::Film;
use crate::gpu::{Buffer, Device, GpuError, Kernel, Recorder};
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
        pub padding0: u32,
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
        let pixels = film.pixels();
        let bytes = 4 * u64::from(pixels);
        let buffer = match self.pixels.take().filter(|buffer| buffer.size() >= bytes) {
            Some(buffer) => buffer,
            None => Buffer::new(&self.device, "display pixels", bytes)?,
        };
        let push = DisplayPush {
            pixels,
            curve: match look.tone_curve {
                ToneCurve::Linear => 0,
                ToneCurve::Reinhard => 1,
            },
            samples: samples.max(1) as f32,
            gain: look.exposure.exp2(),
            white: REINHARD_WHITE,
            volume: film.has_volume().into(),
            padding0: 0,
            padding1: 0,
        };
        let bindings = film.bindings.clone().buffer("DisplayPixels", &buffer);
        let mut recorder = Recorder::new(&self.device)?;
        recorder.pass("frame/display")?.dispatch(&self.kernel, &[&bindings], &push, pixels)?;
        recorder.submit()?;
        let read = buffer.read(pixels as usize);
        self.pixels = Some(buffer);
        read
    }
}
