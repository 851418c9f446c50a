//! What the reference shares with its kernels.

use crate::gpu::{GpuStruct, Layout};

crate::gpu_struct! {
    /// A photon on a surface or in a volume; see `kernels/technique/reference/common.glsl`.
    pub struct Photon {
        pub position: [f32; 3],
        pub normal: u32,
        pub flux: [f32; 3],
        pub landed: u32,
    }
}

crate::gpu_struct! {
    /// What a pixel layer has gathered.
    pub struct Statistic {
        pub irradiance_flux: [f32; 3],
        pub radius2: f32,
        pub radiance_flux: [f32; 3],
        pub photons: f32,
    }
}

crate::gpu_struct! {
    pub struct GridState {
        pub max_radius: u32,
    }
}

crate::gpu_struct! {
    pub struct PreparePush {
        pub radius_pixels: f32,
        pub least_radius: f32,
        pub max_radius: f32,
        pub new_grid: u32,
    }
}

crate::gpu_struct! {
    pub struct EmitPush {
        pub pass: u32,
        pub cells: u32,
        pub samples: u32,
        pub split: u32,
        pub classes: u32,
        pub seed: u32,
        pub ledger_unit: f32,
        pub slots: u32,
        pub volume_classes: u32,
        pub volume_points: u32,
    }
}

crate::gpu_struct! {
    pub struct GridPush {
        pub slots: u32,
        pub buckets: u32,
    }
}

crate::gpu_struct! {
    pub struct ScanPush {
        pub blocks: u32,
    }
}

crate::gpu_struct! {
    pub struct GatherPush {
        pub slots: u32,
        pub buckets: u32,
        pub alpha: f32,
        pub flux_unit: f32,
        pub odd: u32,
    }
}

crate::gpu_struct! {
    pub struct GatherVolumePush {
        pub slots: u32,
        pub buckets: u32,
        pub radius: f32,
        pub flux_unit: f32,
        pub index: u32,
    }
}

crate::gpu_struct! {
    pub struct ResolvePush {
        pub passes: u32,
    }
}

/// What the reference shares with its kernels.
pub const LAYOUTS: &[Layout] = &[
    Photon::LAYOUT,
    Statistic::LAYOUT,
    GridState::LAYOUT,
    PreparePush::LAYOUT,
    EmitPush::LAYOUT,
    GridPush::LAYOUT,
    ScanPush::LAYOUT,
    GatherPush::LAYOUT,
    GatherVolumePush::LAYOUT,
    ResolvePush::LAYOUT,
];
