//! Wave fronts in a grid (Mercier, Eikonal Approximation for Real-Time Height Field Caustics): the optical path from a light
//! to every cell under a refracting surface, and the light that goes along it. Any receiver looks it up.

pub mod device;
pub mod file;
pub mod grid;
mod host;
mod lit;
pub mod marching;
pub mod path;
mod plan;
mod settings;
pub mod solver;
mod surface;
pub mod volume;
pub mod wave;

pub use grid::Grid;
pub use settings::SETTINGS;
pub use solver::{Marching, Scheme, Settled, Solver, SolverOptions};
pub use volume::{Intensity, Kernels, Spread, Volume, VolumeOptions};
pub use wave::{Start, Sum, Wave, WaveKernels, WaveOptions};

use std::path::{Path, PathBuf};

use super::{Context, CreateError, LedgerEntry, Settings, Technique};
use crate::frame::Frame;
use crate::gpu::{Device, GpuError, Kernel, Recorder};
use crate::gpu_scene::GpuScene;
use crate::scene::Scene;
use device::LookUpPush;
use file::{LightUnit, StoredVolume, VolumeFileError};
use lit::{LitVolume, Stages};

/// The technique's state for one band.
pub struct Eikonal {
    options: VolumeOptions,
    stages: Stages,
    gather: Kernel,
    /// One a light, where its light gets through a surface to anything.
    volumes: Vec<Option<LitVolume>>,
    shadows: bool,
    /// What of the settings has no effect, in sentences.
    useless: Vec<String>,
    /// The file that volumes were read from.
    stored: Option<PathBuf>,
    /// Whether volumes hold the scene as it is.
    current: bool,
}

impl Eikonal {
    /// Fails where a volume does not fit the device, or a file of volumes is none or of another scene.
    pub fn new(settings: &Settings, context: &Context<'_>) -> Result<Self, CreateError> {
        let options = settings::volume_options(settings);
        let stages = Stages::new(context.device, &options)?;
        let mut made = Eikonal {
            volumes: context.scene.lights.iter().map(|_| None).collect(),
            options,
            stages,
            gather: Kernel::new(context.device, "eikonal/gather", context.tracer.variant())?,
            shadows: settings.choice("shadows") == "rays",
            useless: settings::useless(settings),
            stored: None,
            current: false,
        };
        match settings::file(settings) {
            Some(path) => made.take_stored(context, &path)?,
            None => made.follow(context)?,
        }
        Ok(made)
    }

    fn take_stored(&mut self, context: &Context<'_>, path: &Path) -> Result<(), CreateError> {
        for stored in file::read(path)? {
            let volume = Volume::from_stored(context.device, context.scene, &stored)?
                .map_err(|reason| VolumeFileError::OtherScene { path: path.to_owned(), reason })?;
            self.volumes[stored.header.light] = Some(LitVolume::stored(volume));
        }
        self.stored = Some(path.to_owned());
        Ok(())
    }

    fn record_volumes(&mut self, frame: &Frame, recorder: &mut Recorder) -> Result<(), GpuError> {
        for volume in self.volumes.iter().flatten() {
            volume.record(recorder, &frame.bindings, &self.stages)?;
        }
        self.current = true;
        Ok(())
    }

    /// Volumes and the lights that they are of.
    fn lit(&self) -> impl Iterator<Item = (u32, &Volume)> {
        (0u32..).zip(&self.volumes).filter_map(|(light, lit)| Some((light, &lit.as_ref()?.volume)))
    }

    /// Makes volumes follow the scene.
    fn follow(&mut self, context: &Context<'_>) -> Result<(), GpuError> {
        if self.stored.is_some() {
            return Ok(());
        }
        let Context { device, scene, frame, .. } = context;
        let scene = (*scene, &frame.bindings);
        for (light, volume) in self.volumes.iter_mut().enumerate() {
            let (options, stages) = (&self.options, &self.stages);
            let there = volume.as_mut().map_or(Ok(false), |lit| lit.update(device, scene, options, stages))?;
            if !there {
                *volume = LitVolume::new(device, scene, light, options, stages)?;
            }
        }
        self.current = false;
        Ok(())
    }
}

impl Technique for Eikonal {
    fn restart(&mut self, context: &Context<'_>) -> Result<(), GpuError> {
        self.follow(context)
    }

    fn record(&mut self, frame: &Frame, recorder: &mut Recorder, index: u32) -> Result<(), GpuError> {
        if !self.current {
            self.record_volumes(frame, recorder)?;
        }
        for (at, (light, volume)) in self.lit().enumerate() {
            let push = LookUpPush {
                light,
                first: u32::from(at == 0),
                shadows: u32::from(self.shadows),
                factor: u32::from(volume.unit() == LightUnit::Factor),
                between: u32::from(volume.is_between()),
            };
            let bindings = [&frame.bindings, &volume.bindings];
            recorder.pass("eikonal/gather")?.dispatch(&self.gather, &bindings, &push, frame.slots())?;
        }
        if self.lit().next().is_none() {
            return Ok(());
        }
        frame.record_caustic(recorder, index)
    }

    fn ledger(&self, _samples: u32) -> Result<Vec<LedgerEntry>, GpuError> {
        Ok(Vec::new())
    }

    fn second_half(&self, samples: u32) -> Option<u32> {
        self.lit().next().map(|_| samples / 2)
    }

    fn warnings(&self) -> Result<Vec<String>, GpuError> {
        if self.lit().next().is_none() {
            return Ok(vec![
                "no light shines through a refracting surface on anything, so eikonal finds no caustic light"
                    .to_string(),
            ]);
        }
        Ok(self.useless.clone())
    }
}

/// The volumes of all lights of a scene, as a file keeps them; none of lights that get through no surface.
pub fn precompute(
    device: &Device,
    scene: &Scene,
    gpu_scene: &GpuScene,
    settings: &Settings,
) -> Result<Vec<StoredVolume>, GpuError> {
    let options = settings::volume_options(settings);
    let stages = Stages::new(device, &options)?;
    let mut stored = Vec::new();
    for light in 0..scene.lights.len() {
        let placed = (scene, &gpu_scene.bindings);
        let Some(volume) = LitVolume::new(device, placed, light, &options, &stages)? else { continue };
        let mut recorder = Recorder::new(device)?;
        volume.record(&mut recorder, &gpu_scene.bindings, &stages)?;
        recorder.submit()?;
        stored.push(volume.store()?);
    }
    Ok(stored)
}
