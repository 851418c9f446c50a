//! The level over the instances: a tree in depth-first order with skips, as `kernels/trace/top_level.glsl` walks it.

use glam::{Affine3A, Vec3, Vec3A};

use super::NO_INSTANCE;
use crate::gpu::{Buffer, Device, GpuError};
use crate::scene::{Instance, Mesh, MeshId, Scene};

/// Instances that are tried one after the other rather than through a tree over them.
const FLAT: usize = 4;

/// What world boxes grow by, relative to their largest coordinate: rays are intersected in object space, and the
/// rounding of the way there must not lead past the box.
const MARGIN: f32 = 2e-6;

crate::gpu_struct! {
    /// World space.
    pub struct TopNode {
        pub low: [f32; 3],
        pub skip: u32,
        pub high: [f32; 3],
        pub instance: u32,
        pub root: u32,
        pub mask: u32,
        pub padding0: u32,
        pub padding1: u32,
    }
}

#[derive(Clone, Copy)]
struct Placed {
    low: Vec3,
    high: Vec3,
    instance: u32,
    root: u32,
    mask: u32,
}

/// The tree over all instances of meshes that have triangles, on the host and on the device.
pub(super) struct Top {
    /// Node 0 is the root, and its skip the number of nodes; it is there without any instance too.
    nodes: Vec<TopNode>,
    buffer: Buffer,
    /// Of each mesh's own tree.
    roots: Vec<u32>,
    /// Of each mesh, the vertices that its triangles have.
    corners: Vec<Vec<u32>>,
    /// Of each instance: where it stands, and its box there.
    boxes: Vec<(Affine3A, Vec3, Vec3)>,
}

impl Top {
    /// `roots`: of each mesh's own tree; `masks`: one an instance.
    pub(super) fn new(device: &Device, scene: &Scene, roots: Vec<u32>, masks: &[u32]) -> Result<Self, GpuError> {
        let corners: Vec<Vec<u32>> = scene.meshes.iter().map(corners).collect();
        let boxes: Vec<_> = scene.instances.iter().map(|instance| world_box(scene, instance, &corners)).collect();
        let nodes = build(scene, &roots, masks, &boxes);
        let buffer = Buffer::from_slice(device, "trace top", &nodes)?;
        Ok(Top { nodes, buffer, roots, corners, boxes })
    }

    pub(super) fn buffer(&self) -> &Buffer {
        &self.buffer
    }

    /// Follows instances that have moved, and meshes whose vertices have. Whether there was anything to do.
    pub(super) fn follow(
        &mut self,
        device: &Device,
        scene: &Scene,
        masks: &[u32],
        moved: &[MeshId],
    ) -> Result<bool, GpuError> {
        for (known, instance) in self.boxes.iter_mut().zip(&scene.instances) {
            if known.0 != instance.transform || moved.contains(&instance.mesh) {
                *known = world_box(scene, instance, &self.corners);
            }
        }
        let nodes = build(scene, &self.roots, masks, &self.boxes);
        if nodes == self.nodes {
            return Ok(false);
        }
        self.nodes = nodes;
        let bytes: &[u8] = bytemuck::cast_slice(&self.nodes);
        if bytes.len() as u64 <= self.buffer.size() {
            self.buffer.upload(bytes)?;
        } else {
            self.buffer = Buffer::from_slice(device, "trace top", &self.nodes)?;
        }
        Ok(true)
    }
}

fn build(scene: &Scene, roots: &[u32], masks: &[u32], boxes: &[(Affine3A, Vec3, Vec3)]) -> Vec<TopNode> {
    let mut placed: Vec<Placed> = Vec::new();
    for (index, ((instance, &mask), &(_, low, high))) in scene.instances.iter().zip(masks).zip(boxes).enumerate() {
        let (Some(mesh), Some(&root)) = (scene.meshes.get(instance.mesh), roots.get(instance.mesh)) else { continue };
        if !mesh.triangles.is_empty() {
            placed.push(Placed { low, high, instance: index as u32, root, mask });
        }
    }
    let mut nodes = Vec::with_capacity(2 * placed.len() + 1);
    emit(&mut placed, &mut nodes);
    nodes
}

fn corners(mesh: &Mesh) -> Vec<u32> {
    let mut used = vec![false; mesh.positions.len()];
    for &index in mesh.triangles.iter().flatten() {
        if let Some(used) = used.get_mut(index as usize) {
            *used = true;
        }
    }
    (0u32..).zip(&used).filter_map(|(index, &used)| used.then_some(index)).collect()
}

/// Of the vertices rather than of the mesh's box: rotated instances fit more tightly.
fn world_box(scene: &Scene, instance: &Instance, corners: &[Vec<u32>]) -> (Affine3A, Vec3, Vec3) {
    let (mut low, mut high) = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
    if let (Some(mesh), Some(corners)) = (scene.meshes.get(instance.mesh), corners.get(instance.mesh)) {
        for position in corners.iter().filter_map(|&index| mesh.positions.get(index as usize)) {
            let point = instance.transform.transform_point3a(Vec3A::from(*position));
            // Triangles with another vertex are left out of the trees too.
            if point.is_finite() {
                low = low.min(point);
                high = high.max(point);
            }
        }
    }
    let margin = Vec3A::splat(MARGIN * low.abs().max(high.abs()).max_element());
    (instance.transform, (low - margin).into(), (high + margin).into())
}

fn emit(placed: &mut [Placed], nodes: &mut Vec<TopNode>) {
    let at = nodes.len();
    let (mut low, mut high, mut mask) = (Vec3::INFINITY, Vec3::NEG_INFINITY, 0);
    for one in placed.iter() {
        low = low.min(one.low);
        high = high.max(one.high);
        mask |= one.mask;
    }
    nodes.push(TopNode {
        low: low.to_array(),
        skip: 0,
        high: high.to_array(),
        instance: NO_INSTANCE,
        root: 0,
        mask,
        padding0: 0,
        padding1: 0,
    });
    if placed.len() <= FLAT {
        for one in placed.iter() {
            nodes.push(TopNode {
                low: one.low.to_array(),
                skip: nodes.len() as u32 + 1,
                high: one.high.to_array(),
                instance: one.instance,
                root: one.root,
                mask: one.mask,
                padding0: 0,
                padding1: 0,
            });
        }
    } else {
        let centres = |p: &Placed| p.low + p.high;
        let (least, most) = placed.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(least, most), p| {
            (least.min(centres(p)), most.max(centres(p)))
        });
        let axis = (most - least).max_position();
        placed.sort_by(|a, b| centres(a)[axis].total_cmp(&centres(b)[axis]));
        let (first, second) = placed.split_at_mut(placed.len() / 2);
        emit(first, nodes);
        emit(second, nodes);
    }
    nodes[at].skip = nodes.len() as u32;
}
