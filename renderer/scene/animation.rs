//! How a scene moves: what its file says about later times. The scene's own values are those of time 0.

use super::height_field::{HeightField, Wave};
use super::{MeshId, Scene};

/// Standard gravity, m/s2.
pub const GRAVITY: f64 = 9.806_65;

/// Everything that moves in a scene. Frame n shows the time n / `fps` seconds.
#[derive(Debug, Clone, PartialEq)]
pub struct Animation {
    /// Frames per second, positive.
    pub fps: f64,
    pub waters: Vec<Water>,
}

/// A height field whose mesh moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Water {
    pub mesh: MeshId,
    /// As it is at time 0; for simulated water, as it is let go at time 0.
    pub field: HeightField,
    pub motion: WaterMotion,
}

/// What moves a height field.
#[derive(Debug, Clone, PartialEq)]
pub enum WaterMotion {
    /// Each of the field's waves travels along its wave vector at the phase speed of gravity waves over `depth` metres of
    /// still water, deep water where `None`. Bumps and the relief stay.
    Waves { depth: Option<f64> },
    /// The damped wave equation on the field's vertices.
    Simulated(Simulation),
}

/// h_tt + `damping` h_t = `speed`^2 (h_xx + h_zz) for the height h above the field's `base`, at rest at time 0, with
/// walls that reflect (no slope across the rectangle's edges).
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// Of waves, m/s, positive.
    pub speed: f64,
    /// 1/s, not negative.
    pub damping: f64,
    pub drops: Vec<Drop>,
}

/// A Gaussian that is added to the surface at one time: `height` exp(-r^2 / (2 `radius`^2)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drop {
    /// Seconds.
    pub time: f64,
    /// x and z, metres.
    pub centre: glam::DVec2,
    /// Metres; negative for a hollow.
    pub height: f64,
    /// One standard deviation, metres, positive.
    pub radius: f64,
}

impl Default for Animation {
    fn default() -> Self {
        Animation { fps: 24.0, waters: Vec::new() }
    }
}

impl Animation {
    /// Whether anything moves at all.
    pub fn moves(&self) -> bool {
        !self.waters.is_empty()
    }

    /// Seconds.
    pub fn time(&self, frame: u32) -> f64 {
        f64::from(frame) / self.fps
    }

    /// Puts cameras, instances and lights where they are at `time`, seconds. Meshes are left alone: moving them is the
    /// device's work, see [`crate::animate`].
    pub fn pose(&self, _scene: &mut Scene, _time: f64) {}
}

/// Angular frequency of a gravity wave over `depth` metres of water, rad/s: omega^2 = g k tanh(k depth).
pub fn angular_frequency(wave: &Wave, depth: Option<f64>) -> f64 {
    let k = wave.wave_vector().length();
    (GRAVITY * k * depth.map_or(1.0, |depth| (k * depth).tanh())).sqrt()
}

impl HeightField {
    /// The field with its waves where they are at `time`, seconds.
    pub fn at(&self, depth: Option<f64>, time: f64) -> HeightField {
        let mut field = self.clone();
        for wave in &mut field.waves {
            wave.phase -= angular_frequency(wave, depth) * time;
        }
        field
    }
}
