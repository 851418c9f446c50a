//! A renderer whose pipelines are made, and what its samples take.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use nephroid::gpu::Device;
use nephroid::render::{RenderSettings, Renderer};
use nephroid::{scene, stats};

pub struct Run {
    pub renderer: Renderer,
    /// CPU seconds on a software device, else the clock's, of the samples so far.
    pub seconds: f64,
}

impl Run {
    /// Ready for the first sample, after one that made pipelines.
    pub fn new(device: &Device, scene: &Path, settings: &RenderSettings) -> Result<Self, Box<dyn Error>> {
        let mut renderer = Renderer::with_device(device.clone(), scene::load(scene)?, settings)?;
        renderer.sample()?;
        renderer.restart()?;
        Ok(Run { renderer, seconds: 0.0 })
    }

    pub fn sample(&mut self) -> Result<(), Box<dyn Error>> {
        let (cpu, start) = (stats::cpu_seconds(), Instant::now());
        self.renderer.sample()?;
        let software = self.renderer.device().info.kind == "cpu";
        self.seconds += if software { stats::cpu_seconds() - cpu } else { start.elapsed().as_secs_f64() };
        Ok(())
    }

    /// What the technique counted under that name, in all samples; 0 for what it did not.
    pub fn counter(&self, name: &str) -> Result<f64, Box<dyn Error>> {
        let counters = self.renderer.finish()?.stats.counters;
        Ok(counters.iter().find(|counter| counter.name == name).map_or(0.0, |counter| counter.value))
    }

    /// Milliseconds a sample of each pass.
    pub fn passes(&self) -> Result<Vec<(&str, f64)>, Box<dyn Error>> {
        let passes = self.renderer.passes().iter().map(|pass| {
            let time = pass.milliseconds.ok_or("the device has no timestamps to take costs from")?;
            Ok((pass.name.as_str(), time / f64::from(self.renderer.done())))
        });
        passes.collect()
    }
}
