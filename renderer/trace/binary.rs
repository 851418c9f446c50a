//! Binary trees as `kernels/trace/bvh2.glsl` reads them.

use glam::Vec3;
use obvhs::bvh2::Bvh2;

use super::TraceError;
use super::refit::Levels;
use super::tree::{self, LeafTriangle};
use super::trees::MeshTree;
use crate::scene::Mesh;

crate::gpu_struct! {
    /// A box with what is in it; object space.
    pub struct BinaryNode {
        pub low: [f32; 3],
        pub triangles: u32,
        pub high: [f32; 3],
        pub first: u32,
    }
}

/// A mesh's tree on the host.
pub(super) struct BinaryTree(Bvh2);

impl MeshTree for BinaryTree {
    type Node = BinaryNode;
    const REFIT_KERNEL: &'static str = "trace/refit_binary";
    const QUANTISED: bool = false;

    fn build(mesh: &Mesh) -> Result<Self, TraceError> {
        tree::build(mesh).map(BinaryTree)
    }

    fn append(&self, mesh: &Mesh, nodes: &mut Vec<BinaryNode>, triangles: &mut Vec<LeafTriangle>) {
        let first_node = nodes.len() as u32;
        for node in &self.0.nodes {
            let first = if node.is_leaf() {
                let primitive = self.0.primitive_indices.get(node.first_index as usize).copied().unwrap_or_default();
                triangles.push(LeafTriangle::new(mesh, primitive));
                triangles.len() as u32 - 1
            } else {
                first_node + node.first_index
            };
            nodes.push(BinaryNode {
                low: Vec3::from(node.aabb().min).to_array(),
                triangles: node.prim_count,
                high: Vec3::from(node.aabb().max).to_array(),
                first,
            });
        }
    }

    fn levels(&self) -> Levels {
        let nodes = &self.0.nodes;
        Levels::new(nodes.len(), |at| {
            let first = nodes[at].first_index as usize;
            let children = if nodes[at].is_leaf() { 0 } else { 2 };
            first..first + children
        })
    }
}
