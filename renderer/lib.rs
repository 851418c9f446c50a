//! Nephroid renders caustics on any Vulkan device.
//!
//! Data flows one way: [`scene`] -> [`gpu_scene`] -> [`view`] -> [`frame`] and [`technique`] -> [`film`] -> [`image`];
//! [`render`] puts them in order.

pub mod adaptive;
pub mod animate;
pub mod commands;
pub mod conformance;
pub mod display;
pub mod film;
pub mod frame;
pub mod gpu;
pub mod gpu_scene;
pub mod image;
pub mod layouts;
pub mod light_view;
pub mod motion;
pub mod random;
pub mod render;
pub mod scene;
pub mod spans;
pub mod stats;
pub mod taa;
pub mod technique;
pub mod trace;
pub mod view;
#[cfg(feature = "viewer")]
pub mod viewer;
