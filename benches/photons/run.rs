//! A renderer whose pipelines are made, and what its samples take.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

use nephroid::gpu::Device;
use nephroid::render::{RenderSettings, Renderer};
use nephroid::scene;
use nephroid::stats;

use crate::Options;

/// The scenes without `--scene`.
const SCENES: [&str; 2] = ["cornell_flooded", "pool"];

pub fn scenes(options: &Options) -> Vec<PathBuf> {
    let shipped = || SCENES.map(|name| PathBuf::from(format!("scenes/{name}.toml"))).to_vec();
    options.scene.clone().map_or_else(shipped, |scene| vec![scene])
}

pub fn name_of(scene: &Path) -> String {
    scene.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

pub struct Run {
    pub renderer: Renderer,
    /// CPU seconds on a software device, else the clock's, of the samples so far.
    pub seconds: f64,
}

/// Milliseconds a sample, by what they were for.
#[derive(Debug, Clone, Copy, Default, serde::Serialize)]
pub struct Split {
    pub emit: f64,
    pub trace: f64,
    pub rescue: f64,
    /// Emptying texels and making irradiance of what they hold.
    pub store: f64,
    pub show: f64,
    /// Whatever else the technique does; denoising is here.
    pub other: f64,
    pub frame: f64,
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

    /// `count` of them; CPU seconds of the quickest, which what else the machine does disturbs least.
    pub fn quickest(&mut self, count: u32) -> Result<f64, Box<dyn Error>> {
        let mut quickest = f64::INFINITY;
        for _ in 0..count {
            let before = self.seconds;
            self.sample()?;
            quickest = quickest.min(self.seconds - before);
        }
        Ok(quickest)
    }

    /// A sample's part of what the technique counted.
    pub fn counter(&self, name: &str) -> Result<f64, Box<dyn Error>> {
        let counters = self.renderer.finish()?.stats.counters;
        let value = counters.iter().find(|counter| counter.name == name).map_or(0.0, |counter| counter.value);
        Ok(value / f64::from(self.renderer.done()))
    }

    /// The views are found by the first sample alone, so their passes are left out.
    pub fn split(&self) -> Result<Split, Box<dyn Error>> {
        let mut split = Split::default();
        for pass in self.renderer.passes() {
            let time = pass.milliseconds.ok_or("the device has no timestamps to take costs from")?;
            let time = time / f64::from(self.renderer.done());
            match pass.name.strip_prefix("photons/") {
                Some("emit") => split.emit += time,
                Some("trace") => split.trace += time,
                Some("rescue") => split.rescue += time,
                Some("clear" | "irradiance") => split.store += time,
                Some("show") => split.show += time,
                Some("visibility" | "visibility-copy" | "see" | "pyramid" | "camera") => {}
                Some(_) => split.other += time,
                None => split.frame += time,
            }
        }
        Ok(split)
    }
}

/// `options`' settings with a size and more `--set` items, which those of `options` win over.
pub fn settings(options: &Options, size: (u32, u32), set: &[String]) -> RenderSettings {
    let set = [set, &options.settings.set].concat();
    let camera = options.camera.clone();
    RenderSettings { camera, size: Some(options.size.unwrap_or(size)), set, ..options.settings.clone() }
}

/// `photons.key=value` for each.
pub fn items(pairs: &[(&str, &str)]) -> Vec<String> {
    pairs.iter().map(|(key, value)| format!("photons.{key}={value}")).collect()
}
