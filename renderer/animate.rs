//! Takes a scene to a frame of its animation, on the host and on the device.
//!
//! What a frame shows depends on the frame's number alone, never on the frames that were shown before.

mod previous;
mod simulation;
mod waves;

use std::time::Instant;

use crate::gpu::{Device, GpuError, Layout, PassTime};
use crate::gpu_scene::{GpuScene, Vertex};
use crate::scene::animation::{Water, WaterMotion};
use crate::scene::{Animation, MeshId, Scene};

pub use previous::Previous;
use simulation::SimulatedWater;
use waves::TravellingWater;

/// Structs that the kernels share with the host.
pub(crate) fn layouts() -> Vec<Layout> {
    [waves::LAYOUTS, simulation::LAYOUTS].concat()
}

/// What moves the vertices of a scene.
pub struct Animator {
    device: Device,
    previous: Option<Previous>,
    waters: Vec<(MeshId, MovingWater)>,
    /// Meshes whose vertices have moved on the device, and have not been [`followed`](Animator::followed) yet.
    moved: Vec<MeshId>,
}

/// A sheet of water and what it takes to move it.
enum MovingWater {
    Travelling(TravellingWater),
    Simulated(Box<SimulatedWater>),
}

/// What [`Animator::go_to`] did.
#[derive(Debug, Default)]
pub struct Moved {
    /// Meshes whose vertices have moved since they were last followed.
    pub meshes: Vec<MeshId>,
    /// One entry a kind of pass.
    pub times: Vec<PassTime>,
}

impl Animator {
    /// Makes the pipelines and what does not change. Nothing has moved yet.
    pub fn new(device: &Device, scene: &Scene, gpu_scene: &GpuScene) -> Result<Self, GpuError> {
        let fps = scene.animation.fps;
        let waters = scene.animation.waters.iter().map(|water| {
            let Water { mesh, field, motion } = water;
            let first_vertex = gpu_scene.meshes[*mesh].first_vertex;
            Ok((
                *mesh,
                match motion {
                    WaterMotion::Waves { depth } => MovingWater::Travelling(TravellingWater::new(
                        device,
                        field,
                        *depth,
                        fps,
                        (&gpu_scene.vertices, first_vertex),
                    )?),
                    WaterMotion::Simulated(simulation) => MovingWater::Simulated(Box::new(SimulatedWater::new(
                        device,
                        field,
                        simulation,
                        fps,
                        (&gpu_scene.vertices, first_vertex),
                    )?)),
                },
            ))
        });
        let waters = waters.collect::<Result<_, GpuError>>()?;
        Ok(Animator { device: device.clone(), previous: None, waters, moved: Vec::new() })
    }

    /// Keeps the frame before beside each frame that is gone to from now on. It depends on the frame's number alone, too:
    /// where another one was shown, the frame before is gone to first.
    pub fn keep_previous(&mut self, gpu_scene: &GpuScene) -> Result<(), GpuError> {
        self.previous = Some(Previous::new(&self.device, gpu_scene)?);
        Ok(())
    }

    /// As [`keep_previous`](Self::keep_previous), but what is kept from now on is what was there whenever this is called.
    pub fn keep_now(&mut self, scene: &Scene, gpu_scene: &GpuScene) -> Result<(), GpuError> {
        match &mut self.previous {
            Some(previous) => {
                previous.by_hand = true;
                previous.keep(&self.device, scene, gpu_scene, &mut Vec::new())
            }
            None => Ok(()),
        }
    }

    /// Keeps no frame before any more.
    pub fn drop_previous(&mut self) {
        self.previous = None;
    }

    /// The frame before, where it is kept and a frame has been gone to.
    pub fn previous(&self) -> Option<&Previous> {
        self.previous.as_ref()
    }

    /// Takes `scene` and its copy on the device to `frame`: cameras, instances, lights and vertices of both. Vertices that
    /// are where they were are left alone.
    ///
    /// Tell [`followed`](Self::followed) when all that is made of the vertices is as they are now. Until then their meshes
    /// are named again, so that nothing is left behind where an error came between.
    ///
    /// A simulation is continued from the frame it shows, or from time 0 where that is later: its cost grows with the
    /// number of frames passed over.
    pub fn go_to(&mut self, frame: u32, scene: &mut Scene, gpu_scene: &mut GpuScene) -> Result<Moved, GpuError> {
        let animation = std::mem::take(&mut scene.animation);
        let moved = self.move_all(&animation, frame, scene, gpu_scene);
        scene.animation = animation;
        moved
    }

    /// All that is made of the vertices has followed them.
    pub fn followed(&mut self) {
        self.moved.clear();
    }

    fn move_all(
        &mut self,
        animation: &Animation,
        frame: u32,
        scene: &mut Scene,
        gpu_scene: &mut GpuScene,
    ) -> Result<Moved, GpuError> {
        let mut times = Vec::new();
        // Going back costs a simulation all its steps.
        if let Some(previous) =
            self.previous.as_mut().filter(|previous| !previous.by_hand && previous.of != Some(frame))
        {
            previous.of = None;
            let before = frame.saturating_sub(1);
            animation.pose(scene, animation.time(before));
            move_waters(&mut self.waters, before, &mut self.moved, &mut times)?;
            previous.keep(&self.device, scene, gpu_scene, &mut times)?;
            previous.of = Some(frame);
        }
        animation.pose(scene, animation.time(frame));
        move_waters(&mut self.waters, frame, &mut self.moved, &mut times)?;
        if !self.moved.is_empty() {
            let started = Instant::now();
            self.moved.iter().try_for_each(|&mesh| read_back(mesh, scene, gpu_scene))?;
            let milliseconds = Some(started.elapsed().as_secs_f64() * 1e3);
            times.push(PassTime { name: "animate/read-back".to_string(), milliseconds });
        }
        gpu_scene.follow(scene)?;
        Ok(Moved { meshes: self.moved.clone(), times })
    }
}

fn move_waters(
    waters: &mut [(MeshId, MovingWater)],
    frame: u32,
    moved: &mut Vec<MeshId>,
    times: &mut Vec<PassTime>,
) -> Result<(), GpuError> {
    for (mesh, water) in waters {
        let has_moved = match water {
            MovingWater::Travelling(water) => water.go_to(frame, times)?,
            MovingWater::Simulated(water) => water.go_to(frame, times)?,
        };
        if has_moved && !moved.contains(mesh) {
            moved.push(*mesh);
        }
    }
    Ok(())
}

/// Techniques and bounds read positions and normals on the host.
fn read_back(mesh: MeshId, scene: &mut Scene, gpu_scene: &GpuScene) -> Result<(), GpuError> {
    let range = gpu_scene.meshes[mesh];
    let first = u64::from(range.first_vertex) * size_of::<Vertex>() as u64;
    let vertices: Vec<Vertex> = gpu_scene.vertices.read_at(first, range.vertices as usize)?;
    let mesh = &mut scene.meshes[mesh];
    for (index, vertex) in vertices.iter().enumerate() {
        mesh.positions[index] = vertex.position.into();
        mesh.normals[index] = vertex.normal.into();
    }
    Ok(())
}

/// Adds the times of one submission to those of all, passes of one name together.
fn add_times(all: &mut Vec<PassTime>, times: Vec<PassTime>) {
    for time in times {
        match all.iter_mut().find(|other| other.name == time.name) {
            Some(other) => other.milliseconds = other.milliseconds.zip(time.milliseconds).map(|(a, b)| a + b),
            None => all.push(time),
        }
    }
}
