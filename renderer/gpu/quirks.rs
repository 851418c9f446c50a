//! What is done differently for particular drivers. DRIVERS.md has the symptoms; everything driver-specific is here.

use super::DeviceInfo;

/// Workarounds in use.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Quirks {
    /// Each pass is submitted alone and timed on the host.
    ///
    /// llvmpipe (seen in Mesa 25.0.7) runs compute at once but writes timestamps when it rasterises what was binned, so
    /// that every compute pass seems to take a tenth of a millisecond. An empty submission costs it 18 us.
    pub submit_each_pass: bool,
}

impl Quirks {
    pub(crate) fn of(info: &DeviceInfo) -> Self {
        Quirks { submit_each_pass: info.driver == "llvmpipe" }
    }
}
