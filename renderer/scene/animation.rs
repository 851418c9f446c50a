//! How a scene moves: what its file says about later times. The scene's own values are those of time 0.

mod water;

use super::Scene;

pub use water::{
    Drop, GRAVITY, MOST_CELLS_PER_STEP, MOST_STEPS_PER_FRAME, Rain, Simulation, Water, WaterMotion, angular_frequency,
};

/// Everything that moves in a scene. Frame n shows the time n / `fps` seconds.
#[derive(Debug, Clone, PartialEq)]
pub struct Animation {
    /// Frames per second, positive.
    pub fps: f64,
    pub waters: Vec<Water>,
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
