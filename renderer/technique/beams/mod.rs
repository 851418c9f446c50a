//! Adaptive beam tracing (Liktor and Dachsbacher 2011): light between neighbouring rays, in volumes and on surfaces.

pub mod accumulate;
pub mod beam;

use crate::gpu::Layout;

/// What the technique shares with its kernels.
pub fn layouts() -> impl Iterator<Item = Layout> {
    [beam::LAYOUTS, accumulate::LAYOUTS].into_iter().flatten().copied()
}
