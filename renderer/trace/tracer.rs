//! What the kernels of one back-end are bound to, for one scene on one device.

use std::time::Instant;

use super::TraceError;
use super::binary::{BinaryNode, BinaryTree};
use super::device_structures::DeviceStructures;
use super::top;
use super::tree::LeafTriangle;
use super::wide::{WideNode, WideTree};
use crate::gpu::{Bindings, Buffer, Capability, Device};
use crate::gpu_scene::GpuScene;
use crate::scene::{Mesh, MeshId, Scene};

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

    /// The kernels' variant.
    pub fn variant(self) -> &'static str {
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
    /// For kernels of the variant [`Backend::variant`], beside those of the [`GpuScene`].
    pub bindings: Bindings,
    /// Wall-clock time of the first build, milliseconds, uploads included.
    pub build_milliseconds: f64,
    /// Bytes of device memory that the structures hold.
    pub memory: u64,
    structures: Structures,
}

enum Structures {
    Device(DeviceStructures),
    Wide(Vec<Option<WideTree>>),
    Binary(Vec<Option<BinaryTree>>),
}

impl Tracer {
    /// Builds the structures. `gpu_scene` is the scene's copy on the device.
    pub fn new(device: &Device, scene: &Scene, gpu_scene: &GpuScene, backend: Backend) -> Result<Tracer, TraceError> {
        if !backend.available(device) {
            return Err(TraceError::NoRayQuery { device: device.info.name.clone() });
        }
        let started = Instant::now();
        let structures = match backend {
            Backend::RayQuery => Structures::Device(DeviceStructures::build(device, gpu_scene)?),
            Backend::Cwbvh => Structures::Wide(each_mesh(scene, WideTree::build)?),
            Backend::Bvh2 => Structures::Binary(each_mesh(scene, BinaryTree::build)?),
        };
        let (bindings, memory) = structures.upload(device, scene, gpu_scene)?;
        let build_milliseconds = started.elapsed().as_secs_f64() * 1e3;
        Ok(Tracer { backend, bindings, build_milliseconds, memory, structures })
    }

    /// Follows a scene whose instances or vertices have moved, `moved` naming the meshes whose vertices have.
    ///
    /// `scene` and `gpu_scene` hold the new positions and transforms; meshes keep their triangles. The bindings are
    /// new afterwards. Trees are fitted to the vertices, not built again, and get slower the farther those move.
    pub fn update(
        &mut self,
        device: &Device,
        scene: &Scene,
        gpu_scene: &GpuScene,
        moved: &[MeshId],
    ) -> Result<(), TraceError> {
        self.structures.check_counts(scene)?;
        match &mut self.structures {
            Structures::Device(structures) => structures.update(device, gpu_scene, moved)?,
            // Fitted whenever it is packed.
            Structures::Wide(_) => {}
            Structures::Binary(trees) => {
                for &id in moved {
                    if let (Some(Some(tree)), Some(mesh)) = (trees.get_mut(id), scene.meshes.get(id)) {
                        tree.refit(mesh);
                    }
                }
            }
        }
        (self.bindings, self.memory) = self.structures.upload(device, scene, gpu_scene)?;
        Ok(())
    }
}

impl Structures {
    fn check_counts(&self, scene: &Scene) -> Result<(), TraceError> {
        for (id, mesh) in scene.meshes.iter().enumerate() {
            let built = match self {
                Structures::Device(_) => return Ok(()),
                Structures::Wide(trees) => trees.get(id).map(|t| t.as_ref().map_or(0, WideTree::primitives)),
                Structures::Binary(trees) => trees.get(id).map(|t| t.as_ref().map_or(0, BinaryTree::primitives)),
            };
            if built != Some(mesh.triangles.len()) {
                return Err(TraceError::Changed { mesh: mesh.name.clone() });
            }
        }
        Ok(())
    }

    /// What kernels are bound to, and its bytes.
    fn upload(&self, device: &Device, scene: &Scene, gpu_scene: &GpuScene) -> Result<(Bindings, u64), TraceError> {
        let mut triangles = Vec::new();
        let (nodes, roots) = match self {
            Structures::Device(structures) => {
                return Ok((Bindings::new().structure("top_level", &structures.top), structures.memory()));
            }
            Structures::Wide(trees) => {
                let mut nodes: Vec<WideNode> = Vec::new();
                let roots = append_all(trees, scene, &mut nodes, &mut triangles, WideTree::append);
                (Buffer::from_slice(device, "trace nodes", &nodes)?, roots)
            }
            Structures::Binary(trees) => {
                let mut nodes: Vec<BinaryNode> = Vec::new();
                let roots = append_all(trees, scene, &mut nodes, &mut triangles, BinaryTree::append);
                (Buffer::from_slice(device, "trace nodes", &nodes)?, roots)
            }
        };
        let masks: Vec<u32> = gpu_scene.instances.iter().map(|instance| instance.mask).collect();
        let triangles = Buffer::from_slice(device, "trace triangles", &triangles)?;
        let top = Buffer::from_slice(device, "trace top", &top::build(scene, &roots, &masks))?;
        let memory = nodes.size() + triangles.size() + top.size();
        let bindings =
            Bindings::new().buffer("TraceNodes", &nodes).buffer("TraceTriangles", &triangles).buffer("TraceTop", &top);
        Ok((bindings, memory))
    }
}

/// A tree for each mesh that has triangles.
fn each_mesh<T>(scene: &Scene, build: impl Fn(&Mesh) -> Result<T, TraceError>) -> Result<Vec<Option<T>>, TraceError> {
    scene.meshes.iter().map(|mesh| (!mesh.triangles.is_empty()).then(|| build(mesh)).transpose()).collect()
}

/// Joins the meshes' trees; the result is where each one's root is.
fn append_all<T, N>(
    trees: &[Option<T>],
    scene: &Scene,
    nodes: &mut Vec<N>,
    triangles: &mut Vec<LeafTriangle>,
    append: impl Fn(&T, &Mesh, &mut Vec<N>, &mut Vec<LeafTriangle>),
) -> Vec<u32> {
    let mut roots = Vec::with_capacity(trees.len());
    for (tree, mesh) in trees.iter().zip(&scene.meshes) {
        roots.push(nodes.len() as u32);
        if let Some(tree) = tree {
            append(tree, mesh, nodes, triangles);
        }
    }
    roots
}
