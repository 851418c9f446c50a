//! Nephroid renders caustics on any Vulkan device.

pub mod commands;
pub mod gpu;
pub mod gpu_scene;
pub mod image;
pub mod scene;
pub mod trace;
