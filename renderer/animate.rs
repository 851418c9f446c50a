//! Takes a scene to a frame of its animation, on the host and on the device.
//!
//! What a frame shows depends on the frame's number alone, never on the frames that were shown before.

mod simulation;
mod waves;

use std::time::Instant;

use crate::gpu::{Device, GpuError, Layout, PassTime};
use crate::gpu_scene::{GpuScene, Vertex};
use crate::scene::animation::{Water, WaterMotion};
use crate::scene::{MeshId, Scene};

use simulation::SimulatedWater;
use waves::TravellingWater;

/// Structs that the kernels share with the host.
pub(crate) fn layouts() -> Vec<Layout> {
    [waves::LAYOUTS, simulation::LAYOUTS].concat()
}

/// What moves the vertices of a scene.
pub struct Animator {
    waters: Vec<(MeshId, MovingWater)>,
}

/// A sheet of water and what it takes to move it.
enum MovingWater {
    Travelling(TravellingWater),
    Simulated(Box<SimulatedWater>),
}

/// What [`Animator::go_to`] did.
#[derive(Debug, Default)]
pub struct Moved {
    /// Meshes whose vertices have moved.
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
        Ok(Animator { waters: waters.collect::<Result<_, GpuError>>()? })
    }

    /// Takes `scene` and its copy on the device to `frame`: cameras, instances, lights and vertices of both. Vertices that
    /// are where they were are left alone.
    ///
    /// A simulation is continued from the frame it shows, or from time 0 where that is later: its cost grows with the
    /// number of frames passed over.
    pub fn go_to(&mut self, frame: u32, scene: &mut Scene, gpu_scene: &mut GpuScene) -> Result<Moved, GpuError> {
        let animation = std::mem::take(&mut scene.animation);
        animation.pose(scene, animation.time(frame));
        scene.animation = animation;
        let mut moved = Moved::default();
        for (mesh, water) in &mut self.waters {
            let has_moved = match water {
                MovingWater::Travelling(water) => water.go_to(frame, &mut moved.times)?,
                MovingWater::Simulated(water) => water.go_to(frame, &mut moved.times)?,
            };
            if has_moved {
                moved.meshes.push(*mesh);
            }
        }
        if !moved.meshes.is_empty() {
            let started = Instant::now();
            moved.meshes.iter().try_for_each(|&mesh| read_back(mesh, scene, gpu_scene))?;
            let milliseconds = Some(started.elapsed().as_secs_f64() * 1e3);
            moved.times.push(PassTime { name: "animate/read-back".to_string(), milliseconds });
        }
        gpu_scene.follow(scene)?;
        Ok(moved)
    }
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
