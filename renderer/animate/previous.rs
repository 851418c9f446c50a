//! The frame before: what motion vectors are measured from.

use super::add_times;
use crate::gpu::{Bindings, Buffer, Device, GpuError, PassTime, Recorder};
use crate::gpu_scene::{GpuScene, records};
use crate::scene::{Camera, Scene};

/// Where vertices, instances and cameras were a frame before the one that is shown; at frame 0, where they are.
pub struct Previous {
    /// The blocks `PreviousVertices` and `PreviousInstances`, laid out as the scene's own.
    pub bindings: Bindings,
    /// The scene's.
    pub cameras: Vec<Camera>,
    /// The frame whose predecessor this is.
    pub(super) of: Option<u32>,
    /// Whether it is what was shown before, whatever frame that was of.
    pub(super) by_hand: bool,
    vertices: Buffer,
    instances: Buffer,
}

impl Previous {
    pub(super) fn new(device: &Device, gpu_scene: &GpuScene) -> Result<Self, GpuError> {
        let vertices = Buffer::new(device, "vertices of the frame before", gpu_scene.vertices.size())?;
        let size = (gpu_scene.instances.len() * size_of::<records::Instance>()) as u64;
        let instances = Buffer::new(device, "instances of the frame before", size)?;
        let bindings = Bindings::new().buffer("PreviousVertices", &vertices).buffer("PreviousInstances", &instances);
        Ok(Previous { bindings, cameras: Vec::new(), of: None, by_hand: false, vertices, instances })
    }

    /// Takes over where everything is now.
    pub(super) fn keep(
        &mut self,
        device: &Device,
        scene: &Scene,
        gpu_scene: &GpuScene,
        times: &mut Vec<PassTime>,
    ) -> Result<(), GpuError> {
        let mut recorder = Recorder::new(device)?;
        let bytes = gpu_scene.vertices.size();
        recorder.pass("animate/keep")?.copy(&gpu_scene.vertices, 0, &self.vertices, 0, bytes);
        add_times(times, recorder.submit()?);
        self.instances.upload(bytemuck::cast_slice(&gpu_scene.instances_of(scene)))?;
        self.cameras.clone_from(&scene.cameras);
        Ok(())
    }
}
