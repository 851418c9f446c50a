//! Where each refracting triangle's light can land: how a visible point finds the triangles that may light it.

use super::surface::SpecularSurface;
use crate::gpu::{Bindings, Buffer, GpuError, GpuStruct, Kernel, Layout, Recorder};
use crate::scene::Scene;
use crate::technique::Context;

crate::gpu_struct! {
    /// Where light that is refracted at a vertex goes; see `kernels/technique/mnee/footprints.glsl`.
    pub struct Landing {
        pub direction: [f32; 3],
        pub distance: f32,
    }
}

crate::gpu_struct! {
    /// What light can reach that passes a triangle: a piece of a cone's stump.
    pub struct Footprint {
        pub origin: [f32; 3],
        pub radius: f32,
        pub direction: [f32; 3],
        pub spread: f32,
        pub nearest: f32,
        pub farthest: f32,
        pub level: u32,
        pub padding0: u32,
    }
}

crate::gpu_struct! {
    pub struct FootprintGrid {
        pub cell: f32,
        pub buckets: u32,
        pub used: u32,
        pub padding0: u32,
    }
}

crate::gpu_struct! {
    pub struct LandingPush {
        pub instance: u32,
        pub vertices: u32,
        pub light: u32,
        pub far: f32,
    }
}

crate::gpu_struct! {
    pub struct FootprintPush {
        pub low: [f32; 3],
        pub triangles: u32,
        pub high: [f32; 3],
    }
}

pub const LAYOUTS: &[Layout] =
    &[Landing::LAYOUT, Footprint::LAYOUT, FootprintGrid::LAYOUT, LandingPush::LAYOUT, FootprintPush::LAYOUT];

/// Entries of the grid that a triangle has room for, as in `footprints.glsl`.
const CELLS: u64 = 16;
/// At least, so that cells rarely share one.
const MIN_BUCKETS: u32 = 1 << 12;
/// At most, 32 MiB: enough for two million triangles, where with an eighth of it looking for paths took twice as long.
const MAX_BUCKETS: u32 = 1 << 23;

/// The kernels, and what all lights share.
pub struct Footprints {
    landing: Kernel,
    footprint: Kernel,
    far: f32,
    low: [f32; 3],
    high: [f32; 3],
    /// One grid a light.
    grids: Vec<Grid>,
}

struct Grid {
    bindings: Bindings,
    state: Buffer,
    heads: Buffer,
}

impl Footprints {
    /// Makes room for every light: 112 bytes a triangle each, and 16 a vertex once.
    pub fn new(context: &Context<'_>, surface: &SpecularSurface) -> Result<Self, GpuError> {
        let device = context.device;
        let variant = context.tracer.variant();
        let landings = Buffer::new(device, "mnee landings", u64::from(surface.vertices) * size_of::<Landing>() as u64)?;
        let triangles = u64::from(surface.triangles);
        let first = first_state(context.scene, surface.triangles);
        let grid = |_| {
            let state = Buffer::from_slice(device, "mnee footprint grid", &[first])?;
            let heads = Buffer::new(device, "mnee footprint heads", u64::from(first.buckets) * 4)?;
            let bindings = Bindings::new()
                .buffer("Landings", &landings)
                .buffer(
                    "Footprints",
                    &Buffer::new(device, "mnee footprints", triangles * size_of::<Footprint>() as u64)?,
                )
                .buffer("FootprintGrids", &state)
                .buffer("FootprintHeads", &heads)
                .buffer("FootprintNext", &Buffer::new(device, "mnee footprint entries", triangles * CELLS * 4)?);
            Ok(Grid { bindings, state, heads })
        };
        let (low, high, far) = reach(context.scene);
        Ok(Footprints {
            landing: Kernel::new(device, "mnee/landing", variant)?,
            footprint: Kernel::new(device, "mnee/footprint", "")?,
            far,
            low,
            high,
            grids: context.scene.lights.iter().map(grid).collect::<Result<_, GpuError>>()?,
        })
    }

    /// Follows a scene that has moved.
    pub fn update(&mut self, scene: &Scene, surface: &SpecularSurface) -> Result<(), GpuError> {
        (self.low, self.high, self.far) = reach(scene);
        let first = first_state(scene, surface.triangles);
        self.grids.iter().try_for_each(|grid| grid.state.upload(bytemuck::bytes_of(&first)))
    }

    /// Records the footprints of every light, for surfaces as they are then.
    pub fn record(
        &self,
        recorder: &mut Recorder,
        (frame, mnee): (&Bindings, &Bindings),
        surface: &SpecularSurface,
    ) -> Result<(), GpuError> {
        for (light, grid) in (0u32..).zip(&self.grids) {
            let bindings = [frame, mnee, &grid.bindings];
            recorder.pass("mnee/clear")?.fill(&grid.heads, u32::MAX);
            let mut pass = recorder.pass("mnee/landing")?;
            for range in &surface.instances {
                let push = LandingPush { instance: range.instance, vertices: range.vertices, light, far: self.far };
                pass.dispatch(&self.landing, &bindings, &push, range.vertices)?;
            }
            drop(pass);
            let push = FootprintPush { low: self.low, triangles: surface.triangles, high: self.high };
            recorder.pass("mnee/footprint")?.dispatch(&self.footprint, &bindings, &push, surface.triangles)?;
        }
        Ok(())
    }

    /// What a kernel needs to look into a light's grid.
    pub fn bindings(&self, light: u32) -> &Bindings {
        &self.grids[light as usize].bindings
    }
}

/// The box in which footprints count, with room for rounding, and how far light can go in it, m.
fn reach(scene: &Scene) -> ([f32; 3], [f32; 3], f32) {
    let bounds = scene.bounds();
    let margin = 1e-3 * bounds.diagonal();
    ((bounds.min - margin).to_array(), (bounds.max + margin).to_array(), bounds.diagonal())
}

/// An empty grid for `triangles` footprints.
fn first_state(scene: &Scene, triangles: u32) -> FootprintGrid {
    let buckets = triangles.clamp(MIN_BUCKETS / 4, MAX_BUCKETS / 4).next_power_of_two() * 4;
    FootprintGrid { cell: first_cell(scene, triangles), buckets, used: 0, padding0: 0 }
}

/// A power of two near a quarter of the mean edge of the refracting triangles, m: few footprints are smaller.
fn first_cell(scene: &Scene, triangles: u32) -> f32 {
    let refracting = scene.instances.iter().filter(|instance| scene.refracts(instance));
    let area: f32 = refracting.map(|instance| scene.area(instance)).sum();
    let edge = (2.0 * area / triangles.max(1) as f32).sqrt().max(1e-6);
    (0.25 * edge).log2().floor().exp2()
}
