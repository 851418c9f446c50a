//! Binary trees as `kernels/trace/bvh2.glsl` reads them.

use glam::Vec3;
use obvhs::bvh2::Bvh2;

use super::TraceError;
use super::tree::{self, LeafTriangle};
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

impl BinaryTree {
    pub(super) fn build(mesh: &Mesh) -> Result<Self, TraceError> {
        tree::build(mesh).map(BinaryTree)
    }

    pub(super) fn primitives(&self) -> usize {
        self.0.primitive_indices.len()
    }

    /// Fits the boxes to moved vertices.
    pub(super) fn refit(&mut self, mesh: &Mesh) {
        let Bvh2 { nodes, primitive_indices, .. } = &mut self.0;
        for leaf in nodes.iter_mut().filter(|node| node.is_leaf()) {
            if let Some(&primitive) = primitive_indices.get(leaf.first_index as usize) {
                leaf.set_aabb(tree::bounds(mesh, primitive));
            }
        }
        self.0.refit_all();
    }

    /// Adds nodes and triangles. The tree's root is the first node added.
    pub(super) fn append(&self, mesh: &Mesh, nodes: &mut Vec<BinaryNode>, triangles: &mut Vec<LeafTriangle>) {
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
}
