//! Eight-wide trees with quantised boxes, as `kernels/trace/cwbvh.glsl` reads them.
//!
//! obvhs decides which boxes share a node. The grids are our own: obvhs rounds planes to nearest on the way, which can
//! cut a box by some 1e-7 of the node's size; here every quantised box contains the exact one. A tree whose vertices moved
//! is fitted to them by `kernels/trace/refit_wide.comp.glsl`, which makes the same grids.

use glam::Vec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::cwbvh::node::CwBvhNode;

use super::TraceError;
use super::refit::Levels;
use super::tree::{self, LeafTriangle};
use super::trees::MeshTree;
use crate::scene::Mesh;

/// Triangles a leaf at most; the format holds no more.
const LEAF_TRIANGLES: u32 = 3;

/// Levels below the root that the stack of `kernels/trace/cwbvh.glsl` allows.
const MAX_DEPTH: usize = 31;

/// Biased exponents that a grid's step may have: below, it would be subnormal and flushed to zero on some devices; above,
/// its inverse would.
const EXPONENTS: std::ops::RangeInclusive<i32> = 1..=253;

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

impl MeshTree for WideTree {
    type Node = WideNode;
    const REFIT_KERNEL: &'static str = "trace/refit_wide";
    const QUANTISED: bool = true;

    fn build(mesh: &Mesh) -> Result<Self, TraceError> {
        widen(&tree::build(mesh)?).or_else(|| widen(&tree::build_balanced(mesh))).ok_or_else(|| TraceError::Build {
            mesh: mesh.name.clone(),
            reason: "it has too many triangles".to_string(),
        })
    }

    fn append(&self, mesh: &Mesh, nodes: &mut Vec<WideNode>, triangles: &mut Vec<LeafTriangle>) {
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

    fn levels(&self) -> Levels {
        Levels::new(self.nodes.len(), |at| {
            let node = &self.nodes[at];
            (0..8).filter(|&slot| is_node(node, slot)).map(|slot| node.child_node_index(slot) as usize)
        })
    }
}

fn is_node(node: &CwBvhNode, slot: usize) -> bool {
    !node.is_child_empty(slot) && !node.is_leaf(slot)
}

/// `None` where the result would be too deep for the kernel's stack.
fn widen(binary: &Bvh2) -> Option<WideTree> {
    let wide = tree::guarded(|| bvh2_to_cwbvh(binary, LEAF_TRIANGLES, true, false))?;
    (depth(&wide.nodes)? <= MAX_DEPTH).then_some(WideTree { nodes: wide.nodes, primitives: wide.primitive_indices })
}

/// Levels below the root. `None` if a child is out of range or in front of its parent.
fn depth(nodes: &[CwBvhNode]) -> Option<usize> {
    let mut levels = vec![0usize; nodes.len()];
    for (index, node) in nodes.iter().enumerate() {
        let level = *levels.get(index)? + 1;
        for slot in (0..8).filter(|&slot| is_node(node, slot)) {
            let child = node.child_node_index(slot) as usize;
            *levels.get_mut(child).filter(|_| child > index)? = level;
        }
    }
    levels.into_iter().max()
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
    let size = Vec3::from(whole.max);
    let exponents: [i32; 3] = std::array::from_fn(|axis| step_exponent(difference(size[axis], origin[axis])));
    let mut planes = [[[0u8; 8]; 2]; 3];
    for (slot, child) in children.iter().enumerate() {
        let Some(child) = child else { continue };
        for axis in 0..3 {
            let step = f64::from(exponents[axis] - 127).exp2();
            planes[axis][0][slot] = plane_below(difference(child.min[axis], origin[axis]), step);
            planes[axis][1][slot] = plane_above(difference(child.max[axis], origin[axis]), step);
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

/// a - b is the sum of both numbers without an error: the rounded difference, and what rounding took away (Knuth).
fn difference(a: f32, b: f32) -> (f64, f64) {
    let (a, b) = (f64::from(a), f64::from(b));
    let rounded = a - b;
    let b_seen = a - rounded;
    let a_seen = rounded + b_seen;
    (rounded, (a - a_seen) + (b_seen - b))
}

/// The last plane that is not above.
fn plane_below((rounded, rest): (f64, f64), step: f64) -> u8 {
    let plane = (rounded / step).floor();
    let above = plane * step == rounded && rest < 0.0;
    (plane - f64::from(u8::from(above))) as u8
}

/// The first plane that is not below.
fn plane_above((rounded, rest): (f64, f64), step: f64) -> u8 {
    let plane = (rounded / step).ceil();
    let below = plane * step == rounded && rest > 0.0;
    (plane + f64::from(u8::from(below))) as u8
}

/// The biased exponent of the least power of two of which 255 cover the size.
fn step_exponent((rounded, rest): (f64, f64)) -> i32 {
    let least = *EXPONENTS.start();
    if rounded <= 0.0 {
        return least;
    }
    let exponent = (rounded / 255.0).log2().ceil() as i32;
    // The logarithm is rounded too.
    let covered = f64::from(exponent).exp2() * 255.0;
    let exponent = if covered < rounded || (covered == rounded && rest > 0.0) { exponent + 1 } else { exponent };
    (exponent + 127).clamp(least, *EXPONENTS.end())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernel_holds_the_deepest_tree() {
        let kernel = include_str!("../../kernels/trace/cwbvh.glsl");
        assert!(kernel.contains(&format!("const int STACK_SIZE = {};", MAX_DEPTH + 1)));
    }

    #[test]
    fn quantised_boxes_contain_the_exact_ones() {
        // Far from the origin, where obvhs's own rounding shows.
        let corner = |i: i32| {
            let f = |k: i32| ((i * k) % 1009) as f32 * 1e-3;
            Vec3::new(900.0 + f(17), -300.0 + f(71), 50.0 + f(7) * 1e-3)
        };
        let positions: Vec<Vec3> = (0..900).map(corner).collect();
        let triangles = (0..300).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = Mesh { positions, triangles, ..Mesh::default() };
        let tree = WideTree::build(&mesh).unwrap();
        let (mut nodes, mut leaves) = (Vec::new(), Vec::new());
        tree.append(&mesh, &mut nodes, &mut leaves);
        let mut checked = 0;
        for (node, packed) in tree.nodes.iter().zip(&nodes) {
            let planes = [packed.x, packed.y, packed.z];
            for slot in (0..8).filter(|&slot| !node.is_child_empty(slot) && node.is_leaf(slot)) {
                let (first, count) = node.child_primitives(slot);
                for leaf in &leaves[first as usize..(first + count) as usize] {
                    for point in [leaf.a, leaf.b, leaf.c] {
                        for axis in 0..3 {
                            let step = f64::from((packed.scales >> (8 * axis) & 255) as i32 - 127).exp2();
                            let plane =
                                |word: usize| f64::from(planes[axis][word + slot / 4] >> (8 * (slot % 4)) & 255);
                            let at = f64::from(point[axis]) - f64::from(packed.origin[axis]);
                            assert!(plane(0) * step <= at && at <= plane(2) * step);
                            checked += 1;
                        }
                    }
                }
            }
        }
        assert_eq!(checked, 300 * 9);
    }

    #[test]
    fn steps_are_the_least_that_cover() {
        for size in [1e-30, 1e-3, 255.0, 255.0001, 256.0, 1e20] {
            let step = f64::from(step_exponent((size, 0.0)) - 127).exp2();
            assert!(step * 255.0 >= size && step * 127.5 < size, "{size}");
        }
        assert_eq!(step_exponent((0.0, 0.0)), 1);
        assert_eq!([step_exponent((255.0, 0.0)), step_exponent((255.0, 1e-20))], [127, 128]);
    }

    #[test]
    fn planes_go_by_exact_differences() {
        // The difference rounds to 1; the least of what was rounded away decides.
        assert_eq!(difference(1.0, -1e-20), (1.0, 1e-20f32.into()));
        assert_eq!(plane_above(difference(1.0, -1e-20), 1.0), 2);
        assert_eq!(plane_above(difference(1.0, 1e-20), 1.0), 1);
        assert_eq!(plane_below(difference(1.0, 1e-20), 1.0), 0);
        assert_eq!(plane_below(difference(1.0, -1e-20), 1.0), 1);
        assert_eq!([plane_below((2.5, 0.0), 1.0), plane_above((2.5, 0.0), 1.0)], [2, 3]);
    }
}
