//! How a scene moves: what its file says about later times. The scene's own values are those of time 0.

mod pose;
mod timeline;
mod water;

use super::Scene;
use super::transform::Placement;

pub use pose::{Aim, CameraPose, Keys, LightPose, Pose};
pub use timeline::{Interpolation, Span, Timeline};
pub use water::{
    Drop, GRAVITY, MOST_CELLS_PER_STEP, MOST_DAMPING_PER_STEP, MOST_STEPS_PER_FRAME, Rain, Simulation, Water,
    WaterMotion, angular_frequency,
};

/// Everything that moves in a scene. Frame n shows the time n / `fps` seconds.
#[derive(Debug, Clone, PartialEq)]
pub struct Animation {
    /// Frames per second, positive.
    pub fps: f64,
    /// How many frames, from frame 0 on, make the whole animation where nobody says otherwise; at least 1.
    pub frames: Option<u32>,
    pub waters: Vec<Water>,
    pub cameras: Vec<Keys<CameraPose>>,
    /// Of instances.
    pub objects: Vec<Keys<Placement>>,
    pub lights: Vec<Keys<LightPose>>,
}

impl Default for Animation {
    fn default() -> Self {
        Animation {
            fps: 24.0,
            frames: None,
            waters: Vec::new(),
            cameras: Vec::new(),
            objects: Vec::new(),
            lights: Vec::new(),
        }
    }
}

impl Animation {
    /// Whether anything moves at all.
    pub fn moves(&self) -> bool {
        let keyed = self.cameras.len() + self.objects.len() + self.lights.len();
        keyed + self.waters.len() > 0
    }

    /// Seconds.
    pub fn time(&self, frame: u32) -> f64 {
        f64::from(frame) / self.fps
    }

    /// The last frame that may be gone to.
    pub fn last_frame(&self) -> u32 {
        let of = |water: &Water| match &water.motion {
            WaterMotion::Waves { .. } => u32::MAX,
            WaterMotion::Simulated(simulation) => simulation.last_frame(&water.field, self.fps),
        };
        self.waters.iter().map(of).min().unwrap_or(u32::MAX)
    }

    /// Puts cameras, instances and lights where they are at `time`, seconds. Meshes are left alone: moving them is the
    /// device's work, see [`crate::animate`].
    pub fn pose(&self, scene: &mut Scene, time: f64) {
        for keys in &self.cameras {
            let pose = keys.at(time);
            scene.cameras[keys.of.clone()].iter_mut().for_each(|camera| pose.put(camera));
        }
        for keys in &self.objects {
            let transform = keys.at(time).transform();
            scene.instances[keys.of.clone()].iter_mut().for_each(|instance| instance.transform = transform);
        }
        for keys in &self.lights {
            let pose = keys.at(time);
            scene.lights[keys.of.clone()].iter_mut().for_each(|light| pose.put(light));
        }
    }
}
