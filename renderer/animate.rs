//! Takes a scene to a frame of its animation, on the host and on the device.
//!
//! What a frame shows depends on the frame's number alone, never on the frames that were shown before.

use glam::Vec3;

use crate::gpu::{Device, GpuError, PassTime};
use crate::gpu_scene::{GpuScene, Vertex};
use crate::scene::animation::WaterMotion;
use crate::scene::{MeshId, Scene};

/// What moves the vertices of a scene.
pub struct Animator;

/// What [`Animator::go_to`] did.
#[derive(Debug, Default)]
pub struct Moved {
    /// Meshes whose vertices have moved.
    pub meshes: Vec<MeshId>,
    pub times: Vec<PassTime>,
}

impl Animator {
    pub fn new(_device: &Device, _scene: &Scene, _gpu_scene: &GpuScene) -> Result<Self, GpuError> {
        Ok(Animator)
    }

    /// Takes `scene` and its copy on the device to `frame`: cameras, instances, lights and vertices of both.
    pub fn go_to(&mut self, frame: u32, scene: &mut Scene, gpu_scene: &mut GpuScene) -> Result<Moved, GpuError> {
        let animation = scene.animation.clone();
        let time = animation.time(frame);
        animation.pose(scene, time);
        let mut moved = Moved::default();
        for water in &animation.waters {
            let WaterMotion::Waves { depth } = water.motion else { continue };
            let field = water.field.at(depth, time);
            let mesh = field.mesh(&scene.meshes[water.mesh].name);
            (scene.meshes[water.mesh].positions, scene.meshes[water.mesh].normals) = (mesh.positions, mesh.normals);
            let vertices: Vec<Vertex> = pack(&scene.meshes[water.mesh]);
            let first = u64::from(gpu_scene.meshes[water.mesh].first_vertex) * size_of::<Vertex>() as u64;
            gpu_scene.vertices.upload_at(first, bytemuck::cast_slice(&vertices))?;
            moved.meshes.push(water.mesh);
        }
        gpu_scene.follow(scene)?;
        Ok(moved)
    }
}

fn pack(mesh: &crate::scene::Mesh) -> Vec<Vertex> {
    let vertex = |(i, position): (usize, &Vec3)| Vertex {
        position: position.to_array(),
        u: mesh.uvs[i].x,
        normal: mesh.normals[i].to_array(),
        v: mesh.uvs[i].y,
    };
    mesh.positions.iter().enumerate().map(vertex).collect()
}
