//! A binary tree over one mesh, built by obvhs and checked, with leaves of one triangle.

use std::panic::{AssertUnwindSafe, catch_unwind};

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::bvh2::{Bvh2, node::Bvh2Node};
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

use super::TraceError;
use crate::scene::Mesh;

/// Levels that the kernels' stacks hold, less one for the root.
pub(super) const MAX_DEPTH: usize = 31;

/// Share of the nodes that are put in better places after the build; more takes longer and traces hardly faster.
const REINSERTED: f32 = 0.05;

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
    let tree = if all_in_one_place(&boxes) { None } else { guarded(|| build_with_obvhs(&boxes)) };
    let tree = tree.filter(|tree| depth(tree).is_some_and(|depth| depth <= MAX_DEPTH));
    let mut tree = tree.unwrap_or_else(|| build_balanced(&boxes));
    if depth(&tree).is_none_or(|depth| depth > MAX_DEPTH) {
        return Err(error("it has too many triangles"));
    }
    tree.reorder_in_stack_traversal_order();
    Ok(tree)
}

/// obvhs panics on what it takes for a bug; the balanced tree is slower and always there.
pub(super) fn guarded<T>(work: impl FnOnce() -> T) -> Option<T> {
    catch_unwind(AssertUnwindSafe(work)).ok()
}

/// Then its sort keys are infinite and its nearest neighbours all equal.
fn all_in_one_place(boxes: &[Aabb]) -> bool {
    boxes.windows(2).all(|pair| pair[0].center() == pair[1].center())
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

/// Halves the triangles along the widest axis of their centres until one is left.
fn build_balanced(boxes: &[Aabb]) -> Bvh2 {
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
