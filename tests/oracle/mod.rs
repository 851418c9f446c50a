//! The truth about light that crosses one specular surface once, in f64 and without a device.
//!
//! [`all_paths`] finds every refracted path between a point and a light by proof over a mesh, not by walking or by
//! trying starts: a part of a triangle is given up only where bounds say that no path crosses it. [`meshes`] makes
//! surfaces and questions to ask of them.
#![allow(dead_code, unused_imports, reason = "each test binary uses its part")]

mod curve;
pub mod meshes;
mod paths;
mod roots;
mod spread;
mod surface;

pub use curve::{on_start_curve, start};
pub use paths::{Light, Path, Query, all_paths};
pub use spread::{finite_difference, fresnel_transmittance, light_side, point_side, refract};
pub use surface::{Patch, Surface};
