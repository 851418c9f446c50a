//! `--watch-kernels`: between samples, changed kernels are reloaded and the rendering starts over.

use super::RenderArgs;
use crate::commands::progress::Display;
use crate::gpu::{KernelWatch, ReloadReport, WatchError};
use crate::render::{RenderError, Renderer};

/// Nothing where the flag is not given.
pub struct Watch(Option<KernelWatch>);

impl Watch {
    pub fn new(args: &RenderArgs, renderer: &Renderer) -> Result<Self, WatchError> {
        let watch = args.watch_kernels.as_ref().map(|folder| {
            let folder = folder.as_deref().unwrap_or(nephroid_kernels::source_folder());
            KernelWatch::new(renderer.device(), folder)
        });
        Ok(Watch(watch.transpose()?))
    }

    /// Whether the rendering has started over. What changed is told on standard error, quiet or not: the flag asks
    /// for it.
    pub fn poll(&mut self, renderer: &mut Renderer, display: &Display) -> Result<bool, RenderError> {
        let reports = self.0.as_mut().map(KernelWatch::poll).unwrap_or_default();
        for report in &reports {
            display.aside(&format!("nephroid: {report}"));
        }
        let reloaded = reports.iter().any(|report| matches!(report, ReloadReport::Reloaded { .. }));
        if reloaded {
            renderer.restart()?;
        }
        Ok(reloaded)
    }
}
