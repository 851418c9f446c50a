//! Water under waves that travel: every frame is worked out from the waves alone.

use std::f64::consts::TAU;

use glam::DVec2;

use super::add_times;
use crate::gpu::{Bindings, Buffer, Device, GpuError, GpuStruct, Kernel, Layout, PassTime, Recorder};
use crate::scene::animation::angular_frequency;
use crate::scene::height_field::{HeightField, Wave};

crate::gpu_struct! {
    /// What does not travel at a vertex; see `kernels/animate/waves.comp.glsl`.
    pub struct StillWater {
        pub height: f32,
        pub slope_x: f32,
        pub slope_z: f32,
    }
}

crate::gpu_struct! {
    /// A wave at one time. Angles are parts of a turn in fixed point.
    pub struct TravellingWave {
        pub along_x: [u32; 2],
        pub along_z: [u32; 2],
        pub phase: u32,
        pub amplitude: f32,
        pub slope: [f32; 2],
    }
}

crate::gpu_struct! {
    pub struct WavesPush {
        pub first_vertex: u32,
        pub columns: u32,
        pub rows: u32,
        pub waves: u32,
    }
}

pub(super) const LAYOUTS: &[Layout] = &[StillWater::LAYOUT, TravellingWave::LAYOUT, WavesPush::LAYOUT];

/// A height field whose waves travel.
pub(super) struct TravellingWater {
    device: Device,
    kernel: Kernel,
    bindings: Bindings,
    push: WavesPush,
    waves: Buffer,
    /// The field's, at time 0, with their angular frequencies, rad/s.
    at_start: Vec<(Wave, f64)>,
    /// The first vertex of the field, and the way to its neighbours, metres.
    origin: DVec2,
    spacing: DVec2,
    fps: f64,
    /// What the vertices show, where they show anything yet.
    shown: Option<Vec<TravellingWave>>,
}

impl TravellingWater {
    /// `vertices`: the buffer that the field's mesh is in, and the index of its first vertex there.
    pub fn new(
        device: &Device,
        field: &HeightField,
        depth: Option<f64>,
        fps: f64,
        (vertices, first_vertex): (&Buffer, u32),
    ) -> Result<Self, GpuError> {
        let still = HeightField { waves: Vec::new(), ..field.clone() };
        let [columns, rows] = field.quads.map(|quads| quads + 1);
        let record = |(x, z)| {
            let slope = still.slope(x, z).as_vec2();
            StillWater { height: still.height(x, z) as f32, slope_x: slope.x, slope_z: slope.y }
        };
        let still: Vec<StillWater> = field.vertices().map(record).collect();
        let size = (field.waves.len() * size_of::<TravellingWave>()) as u64;
        let waves = Buffer::new(device, "travelling waves", size)?;
        let bindings = Bindings::new()
            .buffer("Vertices", vertices)
            .buffer("StillWaters", &Buffer::from_slice(device, "still water", &still)?)
            .buffer("TravellingWaves", &waves);
        Ok(TravellingWater {
            device: device.clone(),
            kernel: Kernel::new(device, "animate/waves", "")?,
            bindings,
            push: WavesPush { first_vertex, columns, rows, waves: field.waves.len() as u32 },
            waves,
            at_start: field.waves.iter().map(|wave| (*wave, angular_frequency(wave, depth))).collect(),
            origin: DVec2::new(field.x[0], field.z[0]),
            spacing: field.spacing(),
            fps,
            shown: None,
        })
    }

    /// Moves the vertices on the device; false where they are there already.
    pub fn go_to(&mut self, frame: u32, times: &mut Vec<PassTime>) -> Result<bool, GpuError> {
        let waves = self.at(f64::from(frame) / self.fps);
        if self.shown.as_ref() == Some(&waves) {
            return Ok(false);
        }
        self.shown = None;
        self.waves.upload(bytemuck::cast_slice(&waves))?;
        let mut recorder = Recorder::new(&self.device)?;
        let vertices = self.push.columns * self.push.rows;
        recorder.pass("animate/waves")?.dispatch(&self.kernel, &[&self.bindings], &self.push, vertices)?;
        add_times(times, recorder.submit()?);
        self.shown = Some(waves);
        Ok(true)
    }

    fn at(&self, time: f64) -> Vec<TravellingWave> {
        let travelled = |(wave, frequency): &(Wave, f64)| {
            let k = wave.wave_vector();
            let step = k * self.spacing / TAU;
            let phase = (k.dot(self.origin) + wave.phase - frequency * time) / TAU;
            TravellingWave {
                along_x: turns(step.x),
                along_z: turns(step.y),
                phase: turns(phase)[0],
                amplitude: wave.amplitude as f32,
                slope: (wave.amplitude * k).as_vec2().to_array(),
            }
        };
        self.at_start.iter().map(travelled).collect()
    }
}

/// The part of a turn beyond whole ones, in 2^-32 and 2^-64 turns.
fn turns(turns: f64) -> [u32; 2] {
    // Rounding may make a tiny negative part a whole turn, which casts to the largest number below.
    let bits = (turns.rem_euclid(1.0) * 2f64.powi(64)) as u64;
    [(bits >> 32) as u32, bits as u32]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_what_is_left_of_whole_ones() {
        assert_eq!(turns(0.25), [1 << 30, 0]);
        assert_eq!(turns(-0.25), [3 << 30, 0]);
        assert_eq!(turns(7.0), [0, 0]);
        assert_eq!(turns(3.0 + 2f64.powi(-33)), [0, 1 << 31]);
        assert_eq!(turns(-1e-30), [u32::MAX, u32::MAX]);
    }
}
