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
mod pipeline;
mod quirks;
mod raster;
mod recorder;
mod reflect;
#[cfg(feature = "hot-reload")]
mod reload;
mod survey;

pub use capability::{Capabilities, Capability};
pub use device::{Device, DeviceInner, DeviceRequest};
pub(crate) use error::Call;
pub use error::GpuError;
pub use instance::Instance;
pub use kernel::{Binding, Bindings, Kernel};
pub use layout::{Field, GpuStruct, Layout};
pub use memory::{Buffer, Image};
pub use quirks::Quirks;
pub use raster::{Raster, RasterTargets};
pub use recorder::{Pass, PassTime, Recorder};
pub use reflect::{Interface, Struct, reflect};
#[cfg(feature = "hot-reload")]
pub use reload::{KernelWatch, ReloadReport, WatchError};
pub use survey::{DeviceInfo, Limits};
