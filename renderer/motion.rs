//! Motion vectors: how far what each pixel shows has moved since the frame before.

use crate::animate::Previous;
use crate::frame::Frame;
use crate::gpu::{Bindings, Buffer, Device, GpuError, Kernel, PassTime, Recorder};
use crate::image::{Channel, Layer};
use crate::trace::Tracer;
use crate::view::View;

/// Name of the layer.
pub const LAYER: &str = "motion";

/// Finds motion vectors of one band after the other.
pub struct MotionVectors {
    kernel: Kernel,
}

impl MotionVectors {
    pub fn new(device: &Device, tracer: &Tracer) -> Result<Self, GpuError> {
        Ok(MotionVectors { kernel: Kernel::new(device, "frame/motion", tracer.variant())? })
    }

    /// For each pixel of the band that `frame` renders, the way of the first surface's point at the pixel's centre from
    /// where `previous_view` saw it: pixels, +x to the right and +y down. Zero where it was behind that camera.
    pub fn find(
        &self,
        device: &Device,
        frame: &Frame,
        previous: &Previous,
        previous_view: &View,
    ) -> Result<(Vec<[f32; 2]>, Vec<PassTime>), GpuError> {
        let pixels = frame.film.pixels();
        let vectors = Buffer::new(device, "motion vectors", u64::from(pixels) * 8)?;
        let bindings = Bindings::new()
            .buffer("PreviousViews", &Buffer::from_slice(device, "view of the frame before", &[*previous_view])?)
            .buffer("MotionVectors", &vectors);
        let mut recorder = Recorder::new(device)?;
        let all = [&frame.bindings, &previous.bindings, &bindings];
        recorder.pass("frame/motion")?.dispatch(&self.kernel, &all, &(), pixels)?;
        let times = recorder.submit()?;
        Ok((vectors.read(pixels as usize)?, times))
    }
}

/// The layer of the whole picture's vectors, row by row.
pub fn layer((width, height): (u32, u32), vectors: &[[f32; 2]]) -> Layer {
    let channel = |name: &str, component: usize| Channel {
        name: name.to_string(),
        samples: vectors.iter().map(|vector| vector[component]).collect(),
    };
    let channels = vec![channel("X", 0), channel("Y", 1)];
    Layer { name: LAYER.to_string(), width: width as usize, height: height as usize, channels }
}
