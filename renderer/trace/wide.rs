//! Eight-wide trees with quantised boxes, as `kernels/trace/cwbvh.glsl` reads them.
//!
//! obvhs decides which boxes share a node. The grids are our own: obvhs rounds planes to nearest on the way, which can
//! cut a box by some 1e-7 of the node's size; here every quantised box contains the exact one, and a tree whose vertices
//! moved is fitted to them without a new build.

use glam::{DVec3, Vec3};
use obvhs::aabb::Aabb;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::cwbvh::node::CwBvhNode;

use super::TraceError;
use super::tree::{self, LeafTriangle};
use crate::scene::Mesh;

/// Triangles a leaf at most; the format holds no more.
const LEAF_TRIANGLES: u32 = 3;

/// Biased exponents that a grid's step may have: below, it would be subnormal and flushed to zero on some devices.
const EXPONENTS: std::ops::RangeInclusive<i32> = 1..=254;

crate::gpu_struct! {
    /// Eight children; object space.
    pub struct WideNode {
        pub origin: [f32; 3],
        pub scales: u32,
        pub first_node: u32,
        pub first_triangle: u32,
        pub meta: [u32; 2],
        pub x: [u32; 4],
        pub y: [u32; 4],
        pub z: [u32; 4],
    }
}

/// A mesh's tree on the host.
pub(super) struct WideTree {
    nodes: Vec<CwBvhNode>,
    /// The mesh's triangle in each place of a leaf.
    primitives: Vec<u32>,
}

impl WideTree {
    pub(super) fn build(mesh: &Mesh) -> Result<Self, TraceError> {
        let binary = tree::build(mesh)?;
        let wide = tree::guarded(|| bvh2_to_cwbvh(&binary, LEAF_TRIANGLES, true, false)).ok_or_else(|| {
            TraceError::Build { mesh: mesh.name.clone(), reason: "the binary tree could not be widened".to_string() }
        })?;
        Ok(WideTree { nodes: wide.nodes, primitives: wide.primitive_indices })
    }

    pub(super) fn primitives(&self) -> usize {
        self.primitives.len()
    }

    /// Adds nodes and triangles, with boxes that fit the mesh as it is now. The tree's root is the first node added.
    pub(super) fn append(&self, mesh: &Mesh, nodes: &mut Vec<WideNode>, triangles: &mut Vec<LeafTriangle>) {
        let (first_node, first_triangle) = (nodes.len() as u32, triangles.len() as u32);
        triangles.extend(self.primitives.iter().map(|&primitive| LeafTriangle::new(mesh, primitive)));
        let boxes: Vec<Aabb> = self.primitives.iter().map(|&primitive| tree::bounds(mesh, primitive)).collect();
        let mut fitted = vec![Aabb::empty(); self.nodes.len()];
        let mut packed = Vec::with_capacity(self.nodes.len());
        // Children come after their parents.
        for (index, node) in self.nodes.iter().enumerate().rev() {
            let children: [Option<Aabb>; 8] = std::array::from_fn(|slot| child_box(node, slot, &boxes, &fitted));
            let whole = children.iter().flatten().fold(Aabb::empty(), |sum, b| sum.union(b));
            fitted[index] = whole;
            packed.push(pack(node, &whole, &children, first_node, first_triangle));
        }
        nodes.extend(packed.into_iter().rev());
    }
}

fn child_box(node: &CwBvhNode, slot: usize, boxes: &[Aabb], fitted: &[Aabb]) -> Option<Aabb> {
    if node.is_child_empty(slot) {
        return None;
    }
    if !node.is_leaf(slot) {
        return fitted.get(node.child_node_index(slot) as usize).copied();
    }
    let (first, count) = node.child_primitives(slot);
    let leaf = boxes.get(first as usize..(first + count) as usize)?;
    Some(leaf.iter().fold(Aabb::empty(), |sum, b| sum.union(b)))
}

fn pack(
    node: &CwBvhNode,
    whole: &Aabb,
    children: &[Option<Aabb>; 8],
    first_node: u32,
    first_triangle: u32,
) -> WideNode {
    let origin = Vec3::from(whole.min);
    let size = Vec3::from(whole.max).as_dvec3() - origin.as_dvec3();
    let exponents = size.to_array().map(step_exponent);
    let step = DVec3::from_array(exponents.map(|e| f64::from(e - 127).exp2()));
    let mut planes = [[[0u8; 8]; 2]; 3];
    for (slot, child) in children.iter().enumerate() {
        let Some(child) = child else { continue };
        let low = (Vec3::from(child.min).as_dvec3() - origin.as_dvec3()) / step;
        let high = (Vec3::from(child.max).as_dvec3() - origin.as_dvec3()) / step;
        for axis in 0..3 {
            planes[axis][0][slot] = low[axis].floor() as u8;
            planes[axis][1][slot] = high[axis].ceil() as u8;
        }
    }
    let words = |bytes: [u8; 8]| bytemuck::cast::<[u8; 8], [[u8; 4]; 2]>(bytes).map(u32::from_le_bytes);
    let axis = |[low, high]: [[u8; 8]; 2]| {
        let (low, high) = (words(low), words(high));
        [low[0], low[1], high[0], high[1]]
    };
    let [x, y, z] = exponents.map(|e| e as u32);
    WideNode {
        origin: origin.to_array(),
        scales: x | y << 8 | z << 16 | u32::from(node.imask) << 24,
        first_node: first_node + node.child_base_idx,
        first_triangle: first_triangle + node.primitive_base_idx,
        meta: words(node.child_meta),
        x: axis(planes[0]),
        y: axis(planes[1]),
        z: axis(planes[2]),
    }
}

/// The biased exponent of the least power of two of which 255 cover `size`.
fn step_exponent(size: f64) -> i32 {
    let least = *EXPONENTS.start();
    if size <= 0.0 {
        return least;
    }
    let exponent = (size / 255.0).log2().ceil() as i32;
    // The logarithm is rounded too.
    let exponent = if f64::from(exponent).exp2() * 255.0 < size { exponent + 1 } else { exponent };
    (exponent + 127).clamp(least, *EXPONENTS.end())
}
