//! Trees fitted on the device to vertices that have moved. Which nodes and triangles hang together stays as it was
//! built, so that the result depends on the tree and the vertices as they are, not on where they were in between.

use crate::gpu::{Bindings, Buffer, Device, GpuError, Kernel, Recorder};
use crate::gpu_scene::{GpuScene, MeshRange};

crate::gpu_struct! {
    pub struct RefitTrianglesPush {
        pub first: u32,
        pub count: u32,
        pub first_vertex: u32,
        pub first_index: u32,
    }
}

crate::gpu_struct! {
    pub struct RefitPush {
        pub first: u32,
        pub count: u32,
        pub root: u32,
        pub padding0: u32,
    }
}

crate::gpu_struct! {
    pub struct RefitBox {
        pub low: [f32; 3],
        pub padding0: u32,
        pub high: [f32; 3],
        pub padding1: u32,
    }
}

/// A tree's nodes by their height over the leaves: each level needs only those before it.
pub(super) struct Levels {
    order: Vec<u32>,
    /// Where each level ends in `order`.
    ends: Vec<u32>,
}

impl Levels {
    /// Of a tree of `nodes` nodes, parents before children. `children` names the nodes right below one.
    pub(super) fn new<C: IntoIterator<Item = usize>>(nodes: usize, children: impl Fn(usize) -> C) -> Levels {
        let mut heights = vec![0usize; nodes];
        let mut levels: Vec<Vec<u32>> = Vec::new();
        for node in (0..nodes).rev() {
            let below = |child: usize| heights.get(child).map_or(0, |height| height + 1);
            let height = children(node).into_iter().map(below).max().unwrap_or(0);
            heights[node] = height;
            levels.resize_with(levels.len().max(height + 1), Vec::new);
            levels[height].push(node as u32);
        }
        let mut end = 0;
        let ends = levels.iter().map(|level| {
            end += level.len() as u32;
            end
        });
        Levels { ends: ends.collect(), order: levels.concat() }
    }

    pub(super) fn nodes(&self) -> usize {
        self.order.len()
    }
}

/// Where a mesh's tree lies in the buffers of all.
pub(super) struct Place {
    /// Its first node.
    pub(super) root: u32,
    pub(super) first_triangle: u32,
    pub(super) levels: Levels,
}

/// The kernels.
pub(super) struct Refit {
    triangles: Kernel,
    level: Kernel,
}

impl Refit {
    /// `level`: the kernel that fits one level of this kind of tree.
    pub(super) fn new(device: &Device, level: &str) -> Result<Self, GpuError> {
        Ok(Refit {
            triangles: Kernel::new(device, "trace/refit_triangles", "")?,
            level: Kernel::new(device, level, "")?,
        })
    }

    /// Fits the tree at `place` to the mesh at `range`. `bindings` has the trees.
    pub(super) fn record(
        &self,
        recorder: &mut Recorder,
        scene: &GpuScene,
        range: &MeshRange,
        bindings: &Bindings,
        place: &Place,
        memory: &RefitMemory,
    ) -> Result<(), GpuError> {
        let MeshRange { first_vertex, first_index, triangles, .. } = *range;
        let push = RefitTrianglesPush { first: place.first_triangle, count: triangles, first_vertex, first_index };
        recorder.pass("trace/refit")?.dispatch(&self.triangles, &[bindings, &scene.bindings], &push, triangles)?;
        let mut first = 0;
        for &end in &place.levels.ends {
            let push = RefitPush { first, count: end - first, root: place.root, padding0: 0 };
            recorder.pass("trace/refit")?.dispatch(&self.level, &[bindings, &memory.bindings], &push, push.count)?;
            first = end;
        }
        Ok(())
    }
}

/// What fitting one tree takes beside the tree.
pub(super) struct RefitMemory {
    bindings: Bindings,
    pub(super) bytes: u64,
}

impl RefitMemory {
    /// `boxes`: whether the nodes' exact boxes have to be kept apart, since the nodes do not hold them.
    pub(super) fn new(device: &Device, levels: &Levels, boxes: bool) -> Result<Self, GpuError> {
        let order = Buffer::from_slice(device, "trace refit order", &levels.order)?;
        let mut bytes = order.size();
        let mut bindings = Bindings::new().buffer("RefitOrder", &order);
        if boxes {
            let boxes = Buffer::new(device, "trace refit boxes", (levels.nodes() * size_of::<RefitBox>()) as u64)?;
            bytes += boxes.size();
            bindings = bindings.buffer("RefitBoxes", &boxes);
        }
        Ok(RefitMemory { bindings, bytes })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_have_children_before_parents() {
        // 0 - (1, 2), 1 - (3, 4), 4 - (5, 6).
        let children = |node: usize| match node {
            0 => vec![1, 2],
            1 => vec![3, 4],
            4 => vec![5, 6],
            _ => Vec::new(),
        };
        let levels = Levels::new(7, children);
        assert_eq!(levels.order, [6, 5, 3, 2, 4, 1, 0]);
        assert_eq!(levels.ends, [4, 5, 6, 7]);
        assert_eq!(Levels::new(1, |_| None).order, [0]);
    }
}
