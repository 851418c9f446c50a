//! The kernels that make beams, and which of two a scene's media need.

use crate::gpu::{GpuError, Kernel};
use crate::technique::Context;

#[derive(Clone)]
pub struct Kernels {
    pub corners: Kernel,
    pub advance: Kernel,
    pub trace: Kernel,
    pub split: Kernel,
    pub close: Kernel,
    pub count_leaves: Kernel,
    pub scan: Kernel,
    pub size: Kernel,
    pub write_leaves: Kernel,
    pub cells: Kernel,
    pub areas: Kernel,
    pub count_beams: Kernel,
    pub write_beams: Kernel,
    pub ledger: Kernel,
}

impl Kernels {
    pub fn new(context: &Context<'_>) -> Result<Self, GpuError> {
        let plain = |name: &str| Kernel::new(context.device, &format!("beams/{name}"), "");
        let trace = by_media(context, ["beams/trace", "beams/trace_grids"]);
        Ok(Kernels {
            corners: plain("corners")?,
            advance: plain("advance")?,
            trace: Kernel::new(context.device, trace, context.tracer.variant())?,
            split: plain("split")?,
            close: plain("close")?,
            count_leaves: plain("count_leaves")?,
            scan: plain("scan")?,
            size: plain("size")?,
            write_leaves: plain("write_leaves")?,
            cells: plain("cells")?,
            areas: plain("areas")?,
            count_beams: plain("count_beams")?,
            write_beams: plain("write_beams")?,
            ledger: plain(by_media(context, ["ledger", "ledger_grids"]))?,
        })
    }
}

/// The second where a medium has a density grid: software drivers pay for its code wherever it is.
pub fn by_media(context: &Context<'_>, names: [&'static str; 2]) -> &'static str {
    names[usize::from(!context.scene.densities.is_empty())]
}
