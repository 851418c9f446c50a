//! What a renderer tells of its samples: times, counters, where the light went.

use super::{RenderError, Renderer};
use crate::adaptive::AdaptiveStats;
use crate::gpu::GpuError;
use crate::stats::{self, Stats};
use crate::technique::{CounterEntry, LedgerEntry};

impl Renderer {
    /// What the samples so far took, and where the light went.
    pub fn stats(&self) -> Result<Stats, RenderError> {
        let info = &self.device.info;
        Ok(Stats {
            version: env!("CARGO_PKG_VERSION"),
            scene: self.scene.path.display().to_string(),
            camera: self.camera.name.clone(),
            technique: self.technique_kind.name(),
            settings: self.settings.iter().map(|(k, v)| (k.to_string(), v.to_string())).collect(),
            width: self.size.0,
            height: self.size.1,
            samples: self.done,
            adaptive: self.adaptive(),
            seed: self.seed,
            device: info.name.clone(),
            driver: info.driver.clone(),
            driver_version: info.driver_version.clone(),
            capabilities: self.device.capabilities.clone(),
            tier: self.tier(),
            trace: self.tracer.backend.module(),
            trace_choice: self.trace_choice.clone(),
            bands: self.bands.len() as u32,
            passes: self.passes.clone(),
            cpu_seconds: stats::cpu_seconds(),
            wall_seconds: self.started.elapsed().as_secs_f64(),
            peak_memory_bytes: self.device.peak_memory(),
            ledger: self.ledger()?,
            counters: self.counters()?,
            noise: self.noise()?,
            warnings: self.warnings()?,
        })
    }

    fn adaptive(&self) -> Option<AdaptiveStats> {
        let bands: Option<Vec<_>> = self.bands.iter().map(|band| band.frame.adaptive()).collect();
        AdaptiveStats::new(&bands?, self.done)
    }

    /// Every band sends the same photons, so the first band's ledger is the picture's.
    fn ledger(&self) -> Result<Vec<LedgerEntry>, GpuError> {
        match self.bands.first().and_then(|band| band.technique.as_ref()) {
            Some(technique) => technique.ledger(self.done),
            None => Ok(Vec::new()),
        }
    }

    /// The first band's: others differ in number only, and means and maxima cannot be added.
    fn counters(&self) -> Result<Vec<CounterEntry>, GpuError> {
        match self.bands.first().and_then(|band| band.technique.as_ref()) {
            Some(technique) => technique.counters(),
            None => Ok(Vec::new()),
        }
    }

    fn warnings(&self) -> Result<Vec<String>, GpuError> {
        let mut warnings = self.scene.warnings.clone();
        warnings.extend(self.device.warnings());
        for band in &self.bands {
            let counters = band.frame.film.counters()?;
            for (count, what) in [
                (counters.non_finite, "values that were not finite were left out"),
                (counters.too_long, "camera paths met more than 16 specular surfaces and were given up"),
                (
                    counters.wrong_side,
                    "camera paths were bent across a surface by its shading normals and were given up",
                ),
                (
                    counters.stretches,
                    "camera paths had more than 4 stretches in media that scatter; light is missing from the rest",
                ),
            ] {
                if count > 0 {
                    warnings.push(format!("{count} {what}"));
                }
            }
            if let Some(technique) = &band.technique {
                warnings.extend(technique.warnings()?);
            }
        }
        warnings.dedup();
        Ok(warnings)
    }
}
