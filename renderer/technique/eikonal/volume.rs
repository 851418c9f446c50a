//! One light's volume: where it is, what is given next to the surface, and what the wave makes of it.

use super::Grid;
use super::device::{EikonalGrid, EikonalPush, EikonalSource, EikonalVolume, FacetPush, LightPush, OUTSIDE, UNKNOWN};
use super::path::Source;
use super::solver::{BLOCK, Settled, Solver, SolverOptions};
use super::surface::RefractingSurface;
use crate::gpu::{Bindings, Buffer, Device, GpuError, Kernel, Recorder};
use crate::scene::{Emitter, Light, MediumId, Scene};

/// What a volume is made by.
#[derive(Debug, Clone, PartialEq)]
pub struct VolumeOptions {
    /// Cells along the longest side.
    pub resolution: u32,
    /// Instead of the box of what is to be lit.
    pub grid: Option<Grid>,
    /// The paper's infinite index: phi is the distance to the surface, in metres.
    pub infinite: bool,
    pub solver: SolverOptions,
}

impl Default for VolumeOptions {
    fn default() -> Self {
        VolumeOptions { resolution: 128, grid: None, infinite: false, solver: SolverOptions::default() }
    }
}

/// Cells below the surface that are given: differences of second order reach as far, and so does what goes on beyond sides.
const BAND: u32 = 2;
/// Components of the light's mean way below which it comes in by neither of two sides.
const UPRIGHT: f32 = 0.02;

/// Quads that an invocation of `eikonal/light` goes through.
const RUN: u32 = 8;

pub struct Kernels {
    cross: Kernel,
    classify: Kernel,
    mark: Kernel,
    given: Kernel,
    seal: Kernel,
    sides: Kernel,
    light: Kernel,
    open: Kernel,
    pub solver: Solver,
}

impl Kernels {
    pub fn new(device: &Device) -> Result<Self, GpuError> {
        let kernel = |name: &str| Kernel::new(device, name, "");
        Ok(Kernels {
            cross: kernel("eikonal/cross")?,
            classify: kernel("eikonal/classify")?,
            mark: kernel("eikonal/mark")?,
            given: kernel("eikonal/given")?,
            seal: kernel("eikonal/seal")?,
            sides: kernel("eikonal/sides")?,
            light: kernel("eikonal/light")?,
            open: kernel("eikonal/open")?,
            solver: Solver::new(device)?,
        })
    }
}

/// One light's volume on a device.
pub struct Volume {
    pub grid: Grid,
    /// The column from which light spreads, of the planes' columns.
    pub foot: [i32; 2],
    pub bindings: Bindings,
    options: VolumeOptions,
    light: usize,
    shared: EikonalVolume,
    volumes: Buffer,
    values: Buffer,
    lights: Buffer,
    /// What the kernels' values lack, metres times index.
    offset: f64,
    facets: Vec<FacetPush>,
}

/// All of a volume that the host works out.
struct Plan {
    grid: Grid,
    foot: [i32; 2],
    shared: EikonalVolume,
    offset: f64,
    facets: Vec<FacetPush>,
}

impl Plan {
    fn new(scene: &Scene, light: usize, options: &VolumeOptions, before: Option<&Grid>) -> Option<Self> {
        let light = &scene.lights[light];
        let surface = RefractingSurface::of(scene, light)?;
        let index = |medium: MediumId| if options.infinite { 1.0 } else { f64::from(scene.media[medium].index) };
        let source = source_of(light, index(light.medium), options.infinite);
        let way = surface.mean_way(&source, index(surface.wave_medium));
        let grid = match options.grid {
            Some(grid) => grid,
            None => surface.grid(scene, way, options.resolution, before)?,
        };
        let planes = EikonalGrid::new(&grid, way, index(surface.wave_medium));
        let (shared_source, offset) = EikonalSource::new(&source, &grid);
        let foot = match source {
            Source::Point { position, .. } => planes.column(&grid, position),
            _ => [0, 1].map(|i| match way[planes.axes[i] as usize] {
                w if w > UPRIGHT => 0,
                w if w < -UPRIGHT => planes.cells[i] as i32 - 1,
                _ => planes.cells[i] as i32 / 2,
            }),
        };
        let columns = planes.cells[0] * planes.cells[1];
        let facets = surface.instances.iter().map(|&instance| {
            let triangles = scene.meshes[scene.instances[instance].mesh].triangles.len() as u32;
            let parts = (columns / triangles.max(1)).clamp(1, 4096);
            FacetPush { volume: 0, instance: instance as u32, triangles, parts }
        });
        let shared = EikonalVolume {
            grid: planes,
            source: shared_source,
            light_medium: light.medium as u32,
            wave_medium: surface.wave_medium as u32,
            band: BAND,
            padding0: 0,
        };
        Some(Plan { grid, foot, shared, offset, facets: facets.collect() })
    }
}

fn source_of(light: &Light, index: f64, infinite: bool) -> Source {
    match &light.emitter {
        _ if infinite => Source::Surface,
        Emitter::Point { position, .. } | Emitter::Spot { position, .. } => {
            Source::Point { position: position.as_dvec3(), index }
        }
        Emitter::Directional { direction, .. } => {
            Source::Directional { direction: direction.as_dvec3().normalize(), index }
        }
    }
}

impl Volume {
    /// The volume that a light of the scene fills; `None` where no surface parts its medium from another, or nothing lies
    /// beyond it. Fails where the cells do not fit a buffer.
    pub fn new(
        device: &Device,
        scene: &Scene,
        light: usize,
        options: &VolumeOptions,
    ) -> Result<Option<Self>, GpuError> {
        let plan = Plan::new(scene, light, options, None);
        plan.map(|plan| Self::with_plan(device, plan, light, options)).transpose()
    }

    fn with_plan(device: &Device, plan: Plan, light: usize, options: &VolumeOptions) -> Result<Self, GpuError> {
        let Plan { grid, foot, shared, offset, facets } = plan;
        let planes = &shared.grid;
        let columns = planes.cells[0] * planes.cells[1];
        let buffer = |name: &str, words: u64| Buffer::new(device, name, 4 * words);
        let sides = 2 * u64::from(planes.cells[0] + planes.cells[1]) * u64::from(planes.cells[2]);
        let blocks = u64::from(columns) * u64::from(planes.cells[2].div_ceil(BLOCK));
        let volumes = Buffer::from_slice(device, "eikonal volumes", &[shared])?;
        let values = buffer("eikonal values", grid.len() as u64)?;
        let lights = buffer("eikonal lights", grid.len() as u64)?;
        let bindings = Bindings::new()
            .buffer("EikonalVolumes", &volumes)
            .buffer("EikonalValues", &values)
            .buffer("EikonalTops", &buffer("eikonal tops", columns.into())?)
            .buffer("EikonalSides", &buffer("eikonal sides", sides)?)
            .buffer("EikonalAsked", &buffer("eikonal asked", blocks)?)
            .buffer("EikonalLights", &lights);
        let options = options.clone();
        Ok(Volume { grid, foot, bindings, options, light, shared, volumes, values, lights, offset, facets })
    }

    /// Takes the volume to what the scene has become: the same light, and instances with the triangles they had. False where
    /// there is nothing left to light. Cells stay where they were in space, but there may be more or fewer.
    pub fn update(&mut self, device: &Device, scene: &Scene) -> Result<bool, GpuError> {
        let Some(plan) = Plan::new(scene, self.light, &self.options, Some(&self.grid)) else { return Ok(false) };
        if plan.grid.cells != self.grid.cells || plan.shared.grid.axes != self.shared.grid.axes {
            *self = Self::with_plan(device, plan, self.light, &self.options)?;
            return Ok(true);
        }
        let Plan { grid, foot, shared, offset, facets } = plan;
        self.volumes.upload(bytemuck::bytes_of(&shared))?;
        (self.grid, self.foot, self.shared, self.offset, self.facets) = (grid, foot, shared, offset, facets);
        Ok(true)
    }

    /// Records the way from the scene's triangles, as they are then, to values and light in all cells.
    pub fn record(&self, recorder: &mut Recorder, scene: &Bindings, kernels: &Kernels) -> Result<(), GpuError> {
        self.record_given(recorder, scene, kernels)?;
        self.record_wave(recorder, kernels)?;
        self.record_light(recorder, scene, kernels)
    }

    /// Records what is given next to the surface, marked as such.
    pub fn record_given(&self, recorder: &mut Recorder, scene: &Bindings, kernels: &Kernels) -> Result<(), GpuError> {
        let bindings = [scene, &self.bindings];
        let push = EikonalPush { volume: 0 };
        let [u, v, _] = self.shared.grid.cells;
        recorder.pass("eikonal/clear")?.fill(&self.values, 0);
        let mut pass = recorder.pass("eikonal/cross")?;
        for facets in &self.facets {
            pass.dispatch(&kernels.cross, &bindings, facets, facets.triangles * facets.parts)?;
        }
        drop(pass);
        recorder.pass("eikonal/classify")?.dispatch(&kernels.classify, &bindings, &push, u * v)?;
        recorder.pass("eikonal/mark")?.dispatch(&kernels.mark, &bindings, &push, u * v)?;
        let mut pass = recorder.pass("eikonal/given")?;
        for facets in &self.facets {
            pass.dispatch(&kernels.given, &bindings, facets, facets.triangles * facets.parts)?;
        }
        drop(pass);
        recorder.pass("eikonal/seal")?.dispatch(&kernels.seal, &bindings, &push, self.grid.len() as u32)?;
        recorder.pass("eikonal/sides")?.dispatch(&kernels.sides, &bindings, &push, 2 * (u + v))?;
        Ok(())
    }

    /// Records the wave from what is given.
    pub fn record_wave(&self, recorder: &mut Recorder, kernels: &Kernels) -> Result<(), GpuError> {
        kernels.solver.record(recorder, &self.bindings, &self.shared.grid, self.foot, &self.options.solver)
    }

    /// Takes the marks off a recorded wave and records the light that goes along it.
    pub fn record_light(&self, recorder: &mut Recorder, scene: &Bindings, kernels: &Kernels) -> Result<(), GpuError> {
        let bindings = [scene, &self.bindings];
        let cells = self.grid.len() as u32;
        recorder.pass("eikonal/open")?.dispatch(&kernels.open, &bindings, &EikonalPush { volume: 0 }, cells)?;
        let [u, v, planes] = self.shared.grid.cells;
        let push = LightPush { volume: 0, runs: u.div_ceil(RUN) };
        recorder.pass("eikonal/light")?.dispatch(&kernels.light, &bindings, &push, push.runs * v * planes)?;
        Ok(())
    }

    /// Irradiance across the light's way over what the light sends there: over W/sr, in 1/m2, or over W/m2; less than 0 where it is not known.
    /// Of the quad from a cell to the next along both columns' axes, u and v of [`EikonalGrid`]. Media take nothing.
    pub fn read_light(&self) -> Result<Vec<f32>, GpuError> {
        self.lights.read(self.grid.len())
    }

    /// How well a recorded wave has settled; only before the marks are taken off, after [`record_wave`](Self::record_wave).
    pub fn check(&self, device: &Device, kernels: &Kernels) -> Result<Settled, GpuError> {
        kernels.solver.check(device, &self.bindings, &self.shared.grid, self.foot, &self.options.solver)
    }

    /// Optical paths from the light, metres times index (with an infinite index: metres from the surface); infinite where no
    /// wave came, NaN outside of the medium. Whether a value was given is told apart where the marks are still there.
    pub fn read(&self) -> Result<(Vec<f64>, Vec<bool>), GpuError> {
        let values: Vec<f32> = self.values.read(self.grid.len())?;
        let path = |value: f32| match value.abs() {
            OUTSIDE => f64::NAN,
            UNKNOWN => f64::INFINITY,
            value => f64::from(value) + self.offset,
        };
        let given = values.iter().map(|value| value.is_sign_negative()).collect();
        Ok((values.into_iter().map(path).collect(), given))
    }
}
