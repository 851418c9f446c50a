//! A light's volume and what is let through it.

use super::file::StoredVolume;
use super::{Kernels, Volume, VolumeOptions, Wave, WaveKernels};
use crate::gpu::{Bindings, Device, GpuError, Recorder};
use crate::scene::Scene;

/// Kernels of what the options ask for.
pub(super) struct Stages {
    volume: Kernels,
    wave: Option<WaveKernels>,
}

impl Stages {
    pub fn new(device: &Device, options: &VolumeOptions) -> Result<Self, GpuError> {
        let wave = options.wave.as_ref().map(|_| WaveKernels::new(device)).transpose()?;
        Ok(Stages { volume: Kernels::new(device)?, wave })
    }
}

pub(super) struct LitVolume {
    pub volume: Volume,
    wave: Option<Wave>,
}

impl LitVolume {
    /// `None` where there is nothing to light. Host's schemes are run at once.
    pub fn new(
        device: &Device,
        (scene, bindings): (&Scene, &Bindings),
        light: usize,
        options: &VolumeOptions,
        stages: &Stages,
    ) -> Result<Option<Self>, GpuError> {
        let Some(volume) = Volume::new(device, scene, light, options)? else { return Ok(None) };
        let mut lit = LitVolume { volume, wave: None };
        lit.ready(device, (scene, bindings), options, stages)?;
        Ok(Some(lit))
    }

    pub fn stored(volume: Volume) -> Self {
        LitVolume { volume, wave: None }
    }

    /// Follows the scene; false where there is nothing left to light.
    pub fn update(
        &mut self,
        device: &Device,
        (scene, bindings): (&Scene, &Bindings),
        options: &VolumeOptions,
        stages: &Stages,
    ) -> Result<bool, GpuError> {
        let there = self.volume.update(device, scene)?;
        if there {
            self.ready(device, (scene, bindings), options, stages)?;
        }
        Ok(there)
    }

    fn ready(
        &mut self,
        device: &Device,
        (scene, bindings): (&Scene, &Bindings),
        options: &VolumeOptions,
        stages: &Stages,
    ) -> Result<(), GpuError> {
        self.wave = options.wave.as_ref().map(|wave| Wave::new(device, &self.volume, wave)).transpose()?;
        self.volume.solve_on_host(device, scene, bindings, &stages.volume)
    }

    pub fn record(&self, recorder: &mut Recorder, scene: &Bindings, stages: &Stages) -> Result<(), GpuError> {
        match (&self.wave, &stages.wave) {
            (Some(wave), Some(kernels)) => wave.record(recorder, scene, &self.volume, &stages.volume, kernels),
            _ => self.volume.record(recorder, scene, &stages.volume),
        }
    }

    pub fn store(&self) -> Result<StoredVolume, GpuError> {
        self.volume.store()
    }
}
