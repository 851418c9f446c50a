//! What can go wrong between the program and a Vulkan device.

use ash::vk;

/// An error of the GPU layer; each message is a sentence for the user.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    #[error(
        "no Vulkan loader was found ({0}); install one: the package libvulkan1 on Debian and Ubuntu, vulkan-loader \
         on Fedora, vulkan-icd-loader on Arch"
    )]
    NoLoader(String),
    #[error(
        "the Vulkan loader reports no device; install a driver for the GPU, or lavapipe, a software driver: the \
         package mesa-vulkan-drivers on Debian and Ubuntu"
    )]
    NoDevice,
    #[error("no Vulkan device matches \"{wanted}\"; there are: {found}")]
    UnknownDevice { wanted: String, found: String },
    #[error("the device {device} cannot be used: {reason}")]
    Unsuitable { device: String, reason: String },
    #[error("validation was asked for, but the layer VK_LAYER_KHRONOS_validation is not installed")]
    NoValidation,
    #[error("validation was asked for, but the extension VK_EXT_debug_utils, which brings its messages, is missing")]
    NoMessages,
    #[error(
        "no Vulkan driver here offers {missing}, which a window on this display needs; install another driver, or make \
         pictures without a window by 'nephroid render'"
    )]
    NoSurfaces { missing: String },
    #[error(
        "the device {device} cannot show pictures in this window; take another by --device (see 'nephroid devices'), or \
         make pictures without a window by 'nephroid render'"
    )]
    CannotPresent { device: String },
    #[error("unknown capability \"{found}\" in the list of what to disable; allowed are: {allowed}")]
    UnknownCapability { found: String, allowed: String },
    #[error("the capability {0} cannot be disabled: it has no fallback")]
    NoFallback(&'static str),
    #[error("{device} ran out of memory at {what} ({bytes} bytes; {held} bytes are held already)")]
    OutOfMemory { device: String, what: String, bytes: u64, held: u64 },
    #[error("{what} takes {bytes} bytes, more than the {limit} bytes that {device} allows for one storage buffer")]
    BufferTooLarge { device: String, what: String, bytes: u64, limit: u64 },
    #[error("the device {device} was lost while it ran {pass}")]
    DeviceLost { device: String, pass: String },
    #[error("the device {device} did not finish {pass} within {seconds} s")]
    Timeout { device: String, pass: String, seconds: u64 },
    #[error("{call} failed: {result}")]
    Vulkan { call: &'static str, result: vk::Result },
    #[error("kernel {kernel}: {reason}")]
    Kernel { kernel: String, reason: String },
}

/// Names the Vulkan call that an error came from.
pub(crate) trait Call<T> {
    fn call(self, call: &'static str) -> Result<T, GpuError>;
}

impl<T> Call<T> for Result<T, vk::Result> {
    fn call(self, call: &'static str) -> Result<T, GpuError> {
        self.map_err(|result| GpuError::Vulkan { call, result })
    }
}
