//! `nephroid conformance`: does a Vulkan driver do what caustics depend on?
//!
//! A [`Case`] checks one behaviour against a closed form or an oracle in f64, never against another device. [`run`] has each
//! case run on every [`Tier`] of a device, in child processes of this program, so that a driver that crashes or hangs
//! costs one case. The [`ledger`] knows what is expected to fail where.

mod case;
mod child;
pub mod closed_forms;
pub mod drivers;
pub mod faults;
mod groups;
pub mod ledger;
pub mod rays;
pub mod report;
mod runner;
mod tier;
mod ulps;

pub use case::{Bench, Case, CaseError, CaseReport, Check, Note, PictureOfCase};
pub use child::{ChildRequest, serve};
pub use groups::{CASES, DEVICE_LOSS};
pub use report::{Outcome, Report, Run, Summary};
pub use runner::{Plan, RunnerError, run};
pub use tier::{TIERS, Tier};

use crate::gpu::{GpuStruct, Layout};

crate::gpu_struct! {
    /// What `a`, `b` and `c` mean is the kernel's own.
    pub struct ConformancePush {
        pub count: u32,
        pub a: u32,
        pub b: u32,
        pub c: u32,
    }
}

crate::gpu_struct! {
    /// Of the raster cases: what fragments write, the first triangle, pixels in a row, and quads that a point becomes.
    pub struct DrawnPush {
        pub mode: u32,
        pub first: u32,
        pub columns: u32,
        pub per_point: u32,
    }
}

/// Every struct of the cases' kernels.
pub const LAYOUTS: &[Layout] = &[ConformancePush::LAYOUT, DrawnPush::LAYOUT];
