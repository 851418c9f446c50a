//! Wave fronts in a grid (Mercier, Eikonal Approximation for Real-Time Height Field Caustics): the optical path from a light
//! to every cell under a refracting surface, and the light that goes along it. Any receiver looks it up.

pub mod device;
pub mod grid;
pub mod marching;
pub mod path;
mod settings;
pub mod solver;
mod surface;
pub mod volume;

pub use grid::Grid;
pub use settings::SETTINGS;
pub use solver::{Scheme, Settled, Solver, SolverOptions};
pub use volume::{Kernels, Volume, VolumeOptions};

use super::{Context, LedgerEntry, Settings, Technique};
use crate::frame::Frame;
use crate::gpu::{GpuError, Kernel, Recorder};
use device::GatherPush;

/// The technique's state for one band: a volume for each light that gets through a surface.
pub struct Eikonal {
    options: VolumeOptions,
    kernels: Kernels,
    gather: Kernel,
    volumes: Vec<LitVolume>,
    shadows: bool,
    /// Whether volumes hold the scene as it is.
    current: bool,
}

struct LitVolume {
    light: u32,
    volume: Volume,
}

impl Eikonal {
    /// Fails where a volume does not fit the device.
    pub fn new(settings: &Settings, context: &Context<'_>) -> Result<Self, GpuError> {
        let options = settings::volume_options(settings);
        Ok(Eikonal {
            volumes: volumes(context, &options)?,
            options,
            kernels: Kernels::new(context.device)?,
            gather: Kernel::new(context.device, "eikonal/gather", context.tracer.backend.variant())?,
            shadows: settings.choice("shadows") == "rays",
            current: false,
        })
    }

    fn record_volumes(&mut self, frame: &Frame, recorder: &mut Recorder) -> Result<(), GpuError> {
        for LitVolume { volume, .. } in &self.volumes {
            volume.record(recorder, &frame.bindings, &self.kernels)?;
        }
        self.current = true;
        Ok(())
    }
}

fn volumes(context: &Context<'_>, options: &VolumeOptions) -> Result<Vec<LitVolume>, GpuError> {
    let mut volumes = Vec::new();
    for (light, index) in (0u32..).zip(0..context.scene.lights.len()) {
        if let Some(volume) = Volume::new(context.device, context.scene, index, options)? {
            volumes.push(LitVolume { light, volume });
        }
    }
    Ok(volumes)
}

impl Technique for Eikonal {
    fn restart(&mut self, context: &Context<'_>) -> Result<(), GpuError> {
        self.current = false;
        let mut all_there = true;
        for lit in &mut self.volumes {
            all_there &= lit.volume.update(context.device, context.scene)?;
        }
        if !all_there || self.volumes.len() < context.scene.lights.len() {
            self.volumes = volumes(context, &self.options)?;
        }
        Ok(())
    }

    fn record(&mut self, frame: &Frame, recorder: &mut Recorder, index: u32) -> Result<(), GpuError> {
        if !self.current {
            self.record_volumes(frame, recorder)?;
        }
        for (at, LitVolume { light, volume }) in self.volumes.iter().enumerate() {
            let push =
                GatherPush { light: *light, first: u32::from(at == 0), shadows: u32::from(self.shadows), mapped: 0 };
            let bindings = [&frame.bindings, &volume.bindings];
            recorder.pass("eikonal/gather")?.dispatch(&self.gather, &bindings, &push, frame.slots())?;
        }
        if self.volumes.is_empty() {
            return Ok(());
        }
        frame.record_caustic(recorder, index)
    }

    fn ledger(&self, _samples: u32) -> Result<Vec<LedgerEntry>, GpuError> {
        Ok(Vec::new())
    }

    fn second_half(&self, samples: u32) -> Option<u32> {
        (!self.volumes.is_empty()).then_some(samples / 2)
    }

    fn warnings(&self) -> Result<Vec<String>, GpuError> {
        if self.volumes.is_empty() {
            return Ok(vec![
                "no light shines through a refracting surface on anything, so eikonal finds no caustic light"
                    .to_string(),
            ]);
        }
        Ok(Vec::new())
    }
}
