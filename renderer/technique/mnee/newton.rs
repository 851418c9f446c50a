//! The baselines: Newton's method on the surface from the walk's start (Hanika et al. 2015) or from random starts
//! (specular manifold sampling, Zeltner et al. 2020), instead of the walk.

use super::super::{Context, Settings};
use crate::frame::Frame;
use crate::gpu::{Bindings, Buffer, GpuError, GpuStruct, Kernel, Layout, Recorder};
use crate::scene::{Instance, Scene, Surface};

/// Random starts of `sms-biased` where no number is given: what the walk's paper compares with.
const STARTS: u32 = 20;
/// Trials of `sms-unbiased` to find a path again where no number is given.
const TRIALS: u32 = 1000;

crate::gpu_struct! {
    pub struct NewtonPush {
        pub first_slot: u32,
        pub items: u32,
        pub light: u32,
        pub sample_index: u32,
        pub solver: u32,
        pub trials: u32,
        pub surfaces: u32,
        pub width: f32,
    }
}

crate::gpu_struct! {
    /// The refracting triangles of an instance; see `kernels/technique/mnee/areas.glsl`.
    pub struct StartSurface {
        pub first_triangle: u32,
        pub triangles: u32,
        pub front: u32,
        pub back: u32,
        pub area: f32,
        pub padding0: u32,
        pub padding1: u32,
        pub padding2: u32,
    }
}

pub const LAYOUTS: &[Layout] = &[NewtonPush::LAYOUT, StartSurface::LAYOUT];

/// A solver that takes the walk's place.
pub struct Newton {
    kernel: Kernel,
    bindings: Bindings,
    solver: u32,
    trials: u32,
    surfaces: u32,
}

impl Newton {
    /// `None` where the settings ask for the walk. Areas are those of the scene as it is now.
    pub fn new(settings: &Settings, context: &Context<'_>) -> Result<Option<Self>, GpuError> {
        let (solver, usual) = match settings.choice("solver") {
            "newton" => (0, 1),
            "sms-biased" => (1, STARTS),
            "sms-unbiased" => (2, TRIALS),
            _ => return Ok(None),
        };
        let trials = match settings.integer("trials") {
            0 => usual,
            trials => trials,
        };
        let (bindings, surfaces) = start_surfaces(context)?;
        let kernel = Kernel::new(context.device, "mnee/newton", context.tracer.variant())?;
        Ok(Some(Newton { kernel, bindings, solver, trials, surfaces }))
    }

    /// As [`Technique::restart`](crate::technique::Technique::restart).
    pub fn restart(&mut self, context: &Context<'_>) -> Result<(), GpuError> {
        (self.bindings, self.surfaces) = start_surfaces(context)?;
        Ok(())
    }

    /// Records all that is found for `items` pixel layers from `first_slot` on and one light, in sample `sample_index`;
    /// `width` as in `path.glsl`, but in pixels. Clears what the sample has so far if it is the first light.
    pub fn record(
        &self,
        recorder: &mut Recorder,
        (frame, mnee): (&Frame, &Bindings),
        (first_slot, items): (u32, u32),
        light: u32,
        (sample_index, width): (u32, f32),
    ) -> Result<(), GpuError> {
        let &Newton { solver, trials, surfaces, .. } = self;
        let push = NewtonPush { first_slot, items, light, sample_index, solver, trials, surfaces, width };
        let bindings = [&frame.bindings, mnee, &self.bindings];
        recorder.pass("mnee/newton")?.dispatch(&self.kernel, &bindings, &push, items)?;
        Ok(())
    }
}

/// Where starts are drawn from, and on how many instances.
fn start_surfaces(context: &Context<'_>) -> Result<(Bindings, u32), GpuError> {
    let (surfaces, areas) = areas_of(context.scene);
    let bindings = Bindings::new()
        .buffer("StartSurfaces", &Buffer::from_slice(context.device, "mnee start surfaces", &surfaces)?)
        .buffer("StartAreas", &Buffer::from_slice(context.device, "mnee start areas", &areas)?);
    Ok((bindings, surfaces.len() as u32))
}

/// The refracting instances and, in their order, each triangle's area added up to it in parts of 2^32 of the instance's.
fn areas_of(scene: &Scene) -> (Vec<StartSurface>, Vec<u32>) {
    let (mut surfaces, mut sums) = (Vec::new(), Vec::new());
    for instance in &scene.instances {
        let Surface::Dielectric { front, back } = scene.materials[instance.material].surface else { continue };
        let areas = triangle_areas(scene, instance);
        let total: f64 = areas.iter().sum();
        surfaces.push(StartSurface {
            first_triangle: sums.len() as u32,
            triangles: areas.len() as u32,
            front: front as u32,
            back: back as u32,
            area: total as f32,
            padding0: 0,
            padding1: 0,
            padding2: 0,
        });
        sums.extend(areas.iter().scan(0.0, |sum, area| {
            *sum += area / total * 4_294_967_296.0;
            Some(*sum as u32) // saturates
        }));
    }
    (surfaces, sums)
}

/// World space, m2.
fn triangle_areas(scene: &Scene, instance: &Instance) -> Vec<f64> {
    let mesh = &scene.meshes[instance.mesh];
    let world = |corner: u32| instance.transform.transform_point3(mesh.positions[corner as usize]).as_dvec3();
    let area = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(world);
        0.5 * (b - a).cross(c - a).length()
    };
    mesh.triangles.iter().map(area).collect()
}
