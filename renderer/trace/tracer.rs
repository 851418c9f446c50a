//! What the kernels of one back-end are bound to, for one scene on one device.

use std::time::Instant;

use super::TraceError;
use super::binary::BinaryTree;
use super::device_structures::{DeviceStructures, Following};
use super::trees::Trees;
use super::wide::WideTree;
use crate::gpu::{Bindings, Capability, Device, Parts, PassTime, Variant};
use crate::gpu_scene::GpuScene;
use crate::scene::{MeshId, Scene, Surface};

/// Who answers the rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Backend {
    /// The device's ray queries.
    RayQuery,
    /// Compute traversal of an eight-wide tree with quantised boxes.
    Cwbvh,
    /// Compute traversal of a binary tree.
    Bvh2,
}

impl Backend {
    pub const ALL: [Backend; 3] = [Backend::RayQuery, Backend::Cwbvh, Backend::Bvh2];

    /// The kernels' module.
    pub fn module(self) -> &'static str {
        match self {
            Backend::RayQuery => "ray_query",
            Backend::Cwbvh => "cwbvh",
            Backend::Bvh2 => "bvh2",
        }
    }

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Backend::RayQuery => "ray-query",
            Backend::Cwbvh => "cwbvh",
            Backend::Bvh2 => "bvh2",
        }
    }

    /// Whether the device has what it takes, in use.
    pub fn available(self, device: &Device) -> bool {
        self != Backend::RayQuery || device.has(Capability::RayQuery)
    }
}

/// A scene's structures for one back-end.
pub struct Tracer {
    pub backend: Backend,
    /// What kernels of the scene are to know.
    pub parts: Parts,
    /// For kernels of the variant [`Tracer::variant`], beside those of the [`GpuScene`].
    pub bindings: Bindings,
    /// Wall-clock time of the first build, milliseconds, uploads included.
    pub build_milliseconds: f64,
    /// Bytes of device memory that the structures hold.
    pub memory: u64,
    structures: Structures,
    /// Of each mesh: triangles and vertices.
    counts: Vec<(usize, usize)>,
    /// Of each instance: its mesh.
    instances: Vec<MeshId>,
}

enum Structures {
    Device(DeviceStructures),
    Trees(Trees),
}

impl Tracer {
    /// Builds the structures. `gpu_scene` is the scene's copy on the device.
    pub fn new(device: &Device, scene: &Scene, gpu_scene: &GpuScene, backend: Backend) -> Result<Tracer, TraceError> {
        Self::following(device, scene, gpu_scene, backend, Following::default())
    }

    /// As [`new`](Self::new), with a say in how ray queries follow moved vertices; other back-ends have one way only.
    pub fn following(
        device: &Device,
        scene: &Scene,
        gpu_scene: &GpuScene,
        backend: Backend,
        following: Following,
    ) -> Result<Tracer, TraceError> {
        if !backend.available(device) {
            return Err(TraceError::NoRayQuery { device: device.info.name.clone() });
        }
        let started = Instant::now();
        let structures = match backend {
            Backend::RayQuery => {
                let moving: Vec<MeshId> = scene.animation.waters.iter().map(|water| water.mesh).collect();
                Structures::Device(DeviceStructures::build(device, gpu_scene, &moving, following)?)
            }
            Backend::Cwbvh => Structures::Trees(Trees::build::<WideTree>(device, scene, gpu_scene)?),
            Backend::Bvh2 => Structures::Trees(Trees::build::<BinaryTree>(device, scene, gpu_scene)?),
        };
        let build_milliseconds = started.elapsed().as_secs_f64() * 1e3;
        let (bindings, memory) = structures.bindings();
        Ok(Tracer {
            backend,
            parts: parts(scene),
            bindings,
            build_milliseconds,
            memory,
            structures,
            counts: counts(scene),
            instances: instances(scene),
        })
    }

    /// Of kernels that trace.
    pub fn variant(&self) -> Variant {
        Variant { module: self.backend.module(), parts: self.parts }
    }

    /// Of kernels that do not.
    pub fn plain(&self) -> Variant {
        Variant { module: "", parts: self.parts }
    }

    /// Follows a scene whose instances or vertices have moved, `moved` naming the meshes whose vertices have.
    ///
    /// `scene` and `gpu_scene` hold the new positions and transforms; meshes keep their triangles, instances their meshes. Trees are fitted to the
    /// vertices, not built again, and get slower the farther those move; what was in between makes no difference.
    ///
    /// The times are the device's, except for `trace/top` of the trees, which is made by the host and timed by its clock.
    pub fn update(
        &mut self,
        device: &Device,
        scene: &Scene,
        gpu_scene: &GpuScene,
        moved: &[MeshId],
    ) -> Result<Vec<PassTime>, TraceError> {
        self.check_counts(scene)?;
        let times = match &mut self.structures {
            Structures::Device(structures) => structures.update(device, gpu_scene, moved)?,
            Structures::Trees(trees) => trees.update(device, scene, gpu_scene, moved)?,
        };
        (self.bindings, self.memory) = self.structures.bindings();
        Ok(times)
    }

    fn check_counts(&self, scene: &Scene) -> Result<(), TraceError> {
        let (meshes, now) = (counts(scene), instances(scene));
        let pairs = [("meshes", self.counts.len(), meshes.len()), ("instances", self.instances.len(), now.len())];
        if let Some(&(what, was, now)) = pairs.iter().find(|(_, was, now)| was != now) {
            return Err(TraceError::ChangedCount { what, was, now });
        }
        if let Some(id) = (0..meshes.len()).find(|&id| self.counts[id] != meshes[id]) {
            return Err(TraceError::Changed { mesh: scene.meshes[id].name.clone() });
        }
        let exchanged = (0..now.len()).find(|&index| self.instances[index] != now[index]);
        exchanged.map_or(Ok(()), |index| Err(TraceError::Exchanged { instance: scene.instances[index].name.clone() }))
    }
}

impl Structures {
    /// What kernels are bound to, and bytes of device memory.
    fn bindings(&self) -> (Bindings, u64) {
        match self {
            Structures::Device(structures) => (structures.bindings(), structures.memory()),
            Structures::Trees(trees) => (trees.bindings(), trees.memory()),
        }
    }
}

fn parts(scene: &Scene) -> Parts {
    Parts {
        grids: !scene.densities.is_empty(),
        rough: scene.materials.iter().any(|material| matches!(material.surface, Surface::Rough { .. })),
    }
}

fn counts(scene: &Scene) -> Vec<(usize, usize)> {
    scene.meshes.iter().map(|mesh| (mesh.triangles.len(), mesh.positions.len())).collect()
}

fn instances(scene: &Scene) -> Vec<MeshId> {
    scene.instances.iter().map(|instance| instance.mesh).collect()
}
