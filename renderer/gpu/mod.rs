//! Vulkan, as thin as it can be: devices and their capabilities, memory, kernels by reflection, recorded passes.
//!
//! Everything is synchronous: a [`Recorder`] is submitted and waited for, so nothing can be freed while in use.

mod capability;
mod descriptors;
mod device;
mod error;
mod instance;
mod kernel;
mod layout;
mod memory;
#[cfg(feature = "viewer")]
mod painter;
mod pipeline;
mod queries;
mod quirks;
mod raster;
mod recorder;
mod reflect;
#[cfg(feature = "hot-reload")]
mod reload;
#[cfg(feature = "viewer")]
mod surface;
mod survey;
#[cfg(feature = "viewer")]
mod swapchain;
mod variant;

pub use capability::{Capabilities, Capability};
pub use device::{Device, DeviceInner, DeviceRequest};
pub(crate) use error::Call;
pub use error::GpuError;
pub use instance::Instance;
pub use kernel::{Binding, Bindings, Kernel};
pub use layout::{Field, GpuStruct, Layout};
pub use memory::{Buffer, Image};
#[cfg(feature = "viewer")]
pub use painter::Painter;
pub use quirks::Quirks;
pub use raster::{Plain, Raster, RasterStages, RasterTargets};
pub use recorder::{Groups, Pass, PassTime, Recorder};
pub use reflect::{Interface, Struct, constants, reflect};
#[cfg(feature = "hot-reload")]
pub use reload::{KernelWatch, ReloadReport, WatchError};
#[cfg(feature = "viewer")]
pub use surface::{Surface, WindowHandles};
pub(crate) use survey::choose;
pub use survey::{DeviceInfo, Limits};
#[cfg(feature = "viewer")]
pub use swapchain::{Drawn, Swapchain};
pub use variant::{Parts, Variant};
