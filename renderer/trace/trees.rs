//! Trees of our own over meshes, with a level over the instances above them, in buffers.

use std::time::Instant;

use super::TraceError;
use super::refit::{Levels, Place, Refit, RefitMemory};
use super::top::Top;
use super::tree::LeafTriangle;
use crate::gpu::{Bindings, Buffer, Device, GpuError, PassTime, Recorder};
use crate::gpu_scene::GpuScene;
use crate::scene::{Mesh, MeshId, Scene};

/// A kind of tree, as the host builds it over one mesh.
pub(super) trait MeshTree: Sized {
    type Node: bytemuck::NoUninit;
    /// The kernel that fits one level of it.
    const REFIT_KERNEL: &'static str;
    /// Whether its nodes hold boxes that are coarser than the exact ones.
    const QUANTISED: bool;

    fn build(mesh: &Mesh) -> Result<Self, TraceError>;

    /// Adds nodes and triangles. The tree's root is the first node added.
    fn append(&self, mesh: &Mesh, nodes: &mut Vec<Self::Node>, triangles: &mut Vec<LeafTriangle>);

    fn levels(&self) -> Levels;
}

/// The trees of a scene on the device.
pub(super) struct Trees {
    nodes: Buffer,
    triangles: Buffer,
    top: Top,
    /// One a mesh; `None` for a mesh without triangles.
    places: Vec<Option<Place>>,
    refit_kernel: &'static str,
    quantised: bool,
    /// Made when vertices move for the first time.
    refit: Option<Refit>,
    /// One a mesh, likewise.
    refit_memory: Vec<Option<RefitMemory>>,
}

impl Trees {
    pub(super) fn build<T: MeshTree>(device: &Device, scene: &Scene, gpu_scene: &GpuScene) -> Result<Self, TraceError> {
        let (mut nodes, mut triangles, mut places) = (Vec::new(), Vec::new(), Vec::new());
        let mut roots = Vec::with_capacity(scene.meshes.len());
        for mesh in &scene.meshes {
            let (root, first_triangle) = (nodes.len() as u32, triangles.len() as u32);
            roots.push(root);
            if mesh.triangles.is_empty() {
                places.push(None);
                continue;
            }
            let tree = T::build(mesh)?;
            tree.append(mesh, &mut nodes, &mut triangles);
            places.push(Some(Place { root, first_triangle, levels: tree.levels() }));
        }
        Ok(Trees {
            nodes: Buffer::from_slice(device, "trace nodes", &nodes)?,
            triangles: Buffer::from_slice(device, "trace triangles", &triangles)?,
            top: Top::new(device, scene, roots, &masks(gpu_scene))?,
            refit_memory: places.iter().map(|_| None).collect(),
            places,
            refit_kernel: T::REFIT_KERNEL,
            quantised: T::QUANTISED,
            refit: None,
        })
    }

    /// What kernels are bound to.
    pub(super) fn bindings(&self) -> Bindings {
        Bindings::new()
            .buffer("TraceNodes", &self.nodes)
            .buffer("TraceTriangles", &self.triangles)
            .buffer("TraceTop", self.top.buffer())
    }

    /// Bytes.
    pub(super) fn memory(&self) -> u64 {
        let refit: u64 = self.refit_memory.iter().flatten().map(|memory| memory.bytes).sum();
        self.nodes.size() + self.triangles.size() + self.top.buffer().size() + refit
    }

    /// Fits the trees of the moved meshes, and the level over the instances.
    pub(super) fn update(
        &mut self,
        device: &Device,
        scene: &Scene,
        gpu_scene: &GpuScene,
        moved: &[MeshId],
    ) -> Result<Vec<PassTime>, GpuError> {
        let mut times = self.refit(device, gpu_scene, moved)?;
        let started = Instant::now();
        if self.top.follow(device, scene, &masks(gpu_scene), moved)? {
            let milliseconds = Some(started.elapsed().as_secs_f64() * 1e3);
            times.push(PassTime { name: "trace/top".to_string(), milliseconds });
        }
        Ok(times)
    }

    fn refit(&mut self, device: &Device, scene: &GpuScene, moved: &[MeshId]) -> Result<Vec<PassTime>, GpuError> {
        if moved.is_empty() {
            return Ok(Vec::new());
        }
        let bindings = self.bindings();
        let mut recorder = Recorder::new(device)?;
        for &mesh in moved {
            let (Some(range), Some(Some(place))) = (scene.meshes.get(mesh), self.places.get(mesh)) else { continue };
            let refit = match &mut self.refit {
                Some(refit) => refit,
                none => none.insert(Refit::new(device, self.refit_kernel)?),
            };
            let memory = match &mut self.refit_memory[mesh] {
                Some(memory) => memory,
                none => none.insert(RefitMemory::new(device, &place.levels, self.quantised)?),
            };
            refit.record(&mut recorder, scene, range, &bindings, place, memory)?;
        }
        recorder.submit()
    }
}

fn masks(scene: &GpuScene) -> Vec<u32> {
    scene.instances.iter().map(|instance| instance.mask).collect()
}
