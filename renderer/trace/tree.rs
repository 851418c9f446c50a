//! A binary tree over one mesh, built by obvhs and checked, with leaves of one triangle.

use std::panic::{AssertUnwindSafe, catch_unwind};

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::bvh2::{Bvh2, node::Bvh2Node};
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

use super::TraceError;
use crate::scene::Mesh;

/// Levels below the root that the stack of `kernels/trace/bvh2.glsl` allows.
const MAX_DEPTH: usize = 63;

/// Share of the nodes that are put in better places after the build; more takes longer and traces hardly faster.
const REINSERTED: f32 = 0.05;

/// Boxes that take no time in any arrangement.
const FEW: usize = 2000;

/// Mean area of boxes, relative to the box of all, from which on they are taken for nested. Surfaces of `FEW` triangles
/// have a hundredth of it.
const NESTED_AREA: f64 = 0.02;

crate::gpu_struct! {
    /// A triangle in the order of a tree's leaves; object space.
    pub struct LeafTriangle {
        pub a: [f32; 3],
        pub primitive: u32,
        pub b: [f32; 3],
        pub padding0: u32,
        pub c: [f32; 3],
        pub padding1: u32,
    }
}

impl LeafTriangle {
    pub(super) fn new(mesh: &Mesh, primitive: u32) -> Self {
        let [a, b, c] = corners(mesh, primitive).map(Vec3::from);
        LeafTriangle { a: a.to_array(), primitive, b: b.to_array(), padding0: 0, c: c.to_array(), padding1: 0 }
    }
}

fn corners(mesh: &Mesh, primitive: u32) -> [Vec3A; 3] {
    let triangle = mesh.triangles.get(primitive as usize).copied().unwrap_or_default();
    triangle.map(|i| mesh.positions.get(i as usize).copied().map(Vec3A::from).unwrap_or_default())
}

pub(super) fn bounds(mesh: &Mesh, primitive: u32) -> Aabb {
    let [a, b, c] = corners(mesh, primitive);
    Aabb::new(a.min(b).min(c), a.max(b).max(c))
}

/// A tree over a mesh with at least one triangle, no deeper than [`MAX_DEPTH`], parents before children.
pub(super) fn build(mesh: &Mesh) -> Result<Bvh2, TraceError> {
    let boxes: Vec<Aabb> = (0..mesh.triangles.len() as u32).map(|i| bounds(mesh, i)).collect();
    let error = |reason: &str| TraceError::Build { mesh: mesh.name.clone(), reason: reason.to_string() };
    if boxes.iter().any(|b| !b.min.is_finite() || !b.max.is_finite()) {
        return Err(error("a vertex is not finite"));
    }
    let tree = if nested(&boxes) { None } else { guarded(|| build_with_obvhs(&boxes)) };
    let tree = tree.filter(|tree| depth(tree).is_some_and(|depth| depth <= MAX_DEPTH));
    let mut tree = tree.unwrap_or_else(|| balanced(&boxes));
    tree.reorder_in_stack_traversal_order();
    Ok(tree)
}

/// obvhs panics on what it takes for a bug; the balanced tree is slower and always there.
pub(super) fn guarded<T>(work: impl FnOnce() -> T) -> Option<T> {
    catch_unwind(AssertUnwindSafe(work)).ok()
}

/// Whether obvhs would make a chain of them, in quadratic time: it joins mutual nearest neighbours, and of boxes that lie
/// in each other only one pair a round are. 20,000 of them took 27 s.
fn nested(boxes: &[Aabb]) -> bool {
    if boxes.windows(2).all(|pair| pair[0].center() == pair[1].center()) {
        return true;
    }
    let whole = boxes.iter().fold(Aabb::empty(), |sum, b| sum.union(b)).half_area();
    let mean = boxes.iter().map(|b| f64::from(b.half_area())).sum::<f64>() / boxes.len() as f64;
    boxes.len() > FEW && mean >= NESTED_AREA * f64::from(whole)
}

fn build_with_obvhs(boxes: &[Aabb]) -> Bvh2 {
    let indices = (0..boxes.len() as u32).collect();
    let mut builder = PlocBuilder::with_capacity(boxes.len());
    let mut tree = builder.build(PlocSearchDistance::Medium, boxes, indices, SortPrecision::U64, 3);
    ReinsertionOptimizer::default().run(&mut tree, REINSERTED, None);
    tree
}

/// Levels below the root. `None` if the tree is none: a child out of range, a leaf of several triangles, a cycle.
fn depth(tree: &Bvh2) -> Option<usize> {
    let mut deepest = 0;
    let mut visited = 0;
    let mut stack = vec![(0usize, 0usize)];
    while let Some((index, level)) = stack.pop() {
        let node = tree.nodes.get(index)?;
        visited += 1;
        if visited > tree.nodes.len() {
            return None;
        }
        deepest = deepest.max(level);
        match node.prim_count {
            0 => stack.extend([0, 1].map(|side| (node.first_index as usize + side, level + 1))),
            1 => {
                tree.primitive_indices.get(node.first_index as usize)?;
            }
            _ => return None,
        }
    }
    Some(deepest)
}

/// A tree of the least depth, for meshes of which obvhs makes a chain.
pub(super) fn build_balanced(mesh: &Mesh) -> Bvh2 {
    let boxes: Vec<Aabb> = (0..mesh.triangles.len() as u32).map(|i| bounds(mesh, i)).collect();
    balanced(&boxes)
}

/// Halves the triangles along the widest axis of their centres until one is left.
fn balanced(boxes: &[Aabb]) -> Bvh2 {
    let mut tree = Bvh2 { primitive_indices: (0..boxes.len() as u32).collect(), ..Bvh2::default() };
    tree.nodes.push(Bvh2Node::default());
    let mut order: Vec<u32> = tree.primitive_indices.clone();
    let mut todo = vec![(0usize, 0usize, order.len())];
    while let Some((node, from, to)) = todo.pop() {
        let part = &mut order[from..to];
        let mut bounds = Aabb::empty();
        let mut centres = Aabb::empty();
        for &primitive in part.iter() {
            let b = boxes[primitive as usize];
            bounds = bounds.union(&b);
            centres.extend(b.center());
        }
        if let [primitive] = *part {
            tree.nodes[node] = Bvh2Node::new(bounds, 1, primitive);
            continue;
        }
        let size = centres.max - centres.min;
        let axis = (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(0);
        let middle = part.len() / 2;
        part.select_nth_unstable_by(middle, |&a, &b| {
            let key = |i: u32| (boxes[i as usize].center()[axis], i);
            key(a).partial_cmp(&key(b)).unwrap_or(std::cmp::Ordering::Equal)
        });
        let children = tree.nodes.len();
        tree.nodes[node] = Bvh2Node::new(bounds, 0, children as u32);
        tree.nodes.extend([Bvh2Node::default(); 2]);
        todo.push((children, from, from + middle));
        todo.push((children + 1, from + middle, to));
    }
    tree
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernel_holds_the_deepest_tree() {
        let kernel = include_str!("../../kernels/trace/bvh2.glsl");
        assert!(kernel.contains(&format!("const int STACK_SIZE = {};", MAX_DEPTH + 1)));
    }

    #[test]
    fn balanced_trees_are_as_shallow_as_can_be() {
        for count in [1usize, 2, 3, 1000, 1024, 1025] {
            let boxes: Vec<Aabb> =
                (0..count).map(|i| Aabb::from_point(Vec3A::new((i * 7 % 13) as f32, 0.0, 1.0))).collect();
            let tree = balanced(&boxes);
            assert_eq!(depth(&tree), Some(count.next_power_of_two().ilog2() as usize));
            assert_eq!(tree.nodes.len(), 2 * count - 1);
            let mut leaves: Vec<u32> = tree.nodes.iter().filter(|n| n.is_leaf()).map(|n| n.first_index).collect();
            leaves.sort_unstable();
            assert_eq!(leaves, tree.primitive_indices);
        }
    }

    #[test]
    fn trees_of_similar_triangles_are_never_too_deep() {
        // Triangles in one corner, each smaller than the one before: the worst case for clustering by area.
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for i in 0..200 {
            let size = 1.5f32.powi(-i);
            triangles.push([3 * i as u32, 3 * i as u32 + 1, 3 * i as u32 + 2]);
            positions.extend([Vec3::ZERO, Vec3::X * size, Vec3::Y * size]);
        }
        let mesh = Mesh { positions, triangles, ..Mesh::default() };
        assert!(depth(&build(&mesh).unwrap()).unwrap() <= MAX_DEPTH);
    }

    #[test]
    fn nested_triangles_are_told_from_surfaces() {
        let boxes = |place: &dyn Fn(f32) -> (f32, f32)| -> Vec<Aabb> {
            let one = |i: usize| {
                let (at, size) = place(i as f32);
                Aabb::new(Vec3A::splat(at), Vec3A::splat(at + size))
            };
            (0..20_000).map(one).collect()
        };
        assert!(nested(&boxes(&|_| (0.0, 1.0))));
        assert!(nested(&boxes(&|i| (0.0, 1.0 + i * 1e-3))));
        assert!(nested(&boxes(&|i| (0.0, if i == 0.0 { 2.0 } else { 1.0 }))));
        assert!(!nested(&boxes(&|i| (i, 2.0))));
    }

    #[test]
    fn meshes_that_are_not_finite_are_refused() {
        let mesh = Mesh {
            name: "broken".to_string(),
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::NAN],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        let error = build(&mesh).err().unwrap().to_string();
        assert_eq!(error, "no tree could be built over the mesh broken: a vertex is not finite");
    }
}
