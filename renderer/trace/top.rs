//! The level over the instances: a tree in depth-first order with skips, as `kernels/trace/top_level.glsl` walks it.

use glam::Vec3;

use super::NO_INSTANCE;
use crate::scene::{Mesh, Scene};

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

/// The tree over all instances of meshes that have triangles. `roots`: of each mesh's own tree; `masks`: one an
/// instance. Node 0 is the root, and its skip the number of nodes; it is there without any instance too.
pub(super) fn build(scene: &Scene, roots: &[u32], masks: &[u32]) -> Vec<TopNode> {
    let mut placed: Vec<Placed> = Vec::new();
    for (index, (instance, &mask)) in scene.instances.iter().zip(masks).enumerate() {
        let (Some(mesh), Some(&root)) = (scene.meshes.get(instance.mesh), roots.get(instance.mesh)) else { continue };
        if mesh.triangles.is_empty() {
            continue;
        }
        let (low, high) = world_box(mesh, instance.transform);
        placed.push(Placed { low, high, instance: index as u32, root, mask });
    }
    let mut nodes = Vec::with_capacity(2 * placed.len() + 1);
    emit(&mut placed, &mut nodes);
    nodes
}

/// Of the vertices rather than of the mesh's box: rotated instances fit more tightly.
fn world_box(mesh: &Mesh, transform: glam::Affine3A) -> (Vec3, Vec3) {
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for &index in mesh.triangles.iter().flatten() {
        let point = transform.transform_point3(mesh.positions.get(index as usize).copied().unwrap_or_default());
        low = low.min(point);
        high = high.max(point);
    }
    let margin = Vec3::splat(MARGIN * low.abs().max(high.abs()).max_element());
    (low - margin, high + margin)
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
