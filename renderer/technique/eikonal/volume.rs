//! One light's volume: where it is, what is given next to the surface, and what the wave makes of it.

use super::Grid;
use super::device::{CurvePush, EikonalPush, EikonalVolume, LitPush, OUTSIDE, SpreadPush, UNKNOWN};
use super::file::{LightUnit, StoredVolume, VolumeHeader};
use super::host;
use super::plan::{Dissipation, Plan};
use super::solver::{BLOCK, Scheme, Settled, Solver, SolverOptions};
use super::wave::WaveOptions;
use crate::gpu::{Bindings, Buffer, Device, GpuError, Groups, Kernel, Recorder};
use crate::scene::Scene;

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
    pub intensity: Intensity,
    /// Whether light spreads in planes below a depth.
    pub spread: Option<Spread>,
    /// A [`Wave`](super::Wave) is let through instead, which [`Wave::record`](super::Wave::record) does.
    pub wave: Option<WaveOptions>,
}

/// How bright a cell is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Intensity {
    /// Irradiance, of the light that goes along the wave (erratum 16).
    Transport,
    /// The paper's, from the wave's Laplacian (Eqs. 3 and 4): `base + gain x^power`, x in turns of the front a cell, over what
    /// flat water would let through.
    Laplacian { base: f32, gain: f32, power: f32 },
}

/// The paper's dissipation (section 3.3).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Metres below the surface's middle height from which on light spreads; 0: where strong hollows of it focus.
    pub threshold: f64,
    /// Metres across, a metre on; 0: as light turns at the surface in the mean.
    pub slope: f64,
}

impl Default for VolumeOptions {
    fn default() -> Self {
        VolumeOptions {
            resolution: 128,
            grid: None,
            infinite: false,
            solver: SolverOptions::default(),
            intensity: Intensity::Transport,
            spread: None,
            wave: None,
        }
    }
}

/// Quads that an invocation of `eikonal/light` goes through.
const RUN: u32 = 8;
/// Of a cell, the way of a wave in a step of `eikonal/spread`.
const SPREAD_STEP: f32 = 0.5;

pub struct Kernels {
    cross: Kernel,
    classify: Kernel,
    mark: Kernel,
    given: Kernel,
    seal: Kernel,
    sides: Kernel,
    light: Kernel,
    curve: Kernel,
    spread: Kernel,
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
            curve: kernel("eikonal/curve")?,
            spread: kernel("eikonal/spread")?,
            solver: Solver::new(device)?,
        })
    }
}

/// One light's volume on a device.
pub struct Volume {
    pub bindings: Bindings,
    options: VolumeOptions,
    light: usize,
    plan: Plan,
    unit: LightUnit,
    between: bool,
    /// Whether cells were read from a file and stay as they are.
    stored: bool,
    volumes: Buffer,
    values: Buffer,
    lights: Buffer,
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
        let plan = Plan::new(scene, light, options);
        plan.map(|plan| Self::with_plan(device, plan, light, options)).transpose()
    }

    fn with_plan(device: &Device, plan: Plan, light: usize, options: &VolumeOptions) -> Result<Self, GpuError> {
        let [u, v, planes] = plan.shared.grid.cells;
        let buffer = |name: &str, words: u64| Buffer::new(device, name, 4 * words);
        let sides = 2 * u64::from(u + v) * u64::from(planes);
        let blocks = u64::from(u * v) * u64::from(planes.div_ceil(BLOCK));
        let cells = plan.grid.len() as u64;
        let volumes = Buffer::from_slice(device, "eikonal volumes", &[plan.shared])?;
        let values = buffer("eikonal values", cells)?;
        let lights = buffer("eikonal lights", cells)?;
        let spread = buffer("eikonal spread", if plan.dissipation.is_some() { cells } else { 0 })?;
        let bindings = Bindings::new()
            .buffer("EikonalVolumes", &volumes)
            .buffer("EikonalValues", &values)
            .buffer("EikonalTops", &buffer("eikonal tops", (u * v).into())?)
            .buffer("EikonalSides", &buffer("eikonal sides", sides)?)
            .buffer("EikonalAsked", &buffer("eikonal asked", blocks)?)
            .buffer("EikonalLights", &lights)
            .buffer("EikonalSpread", &spread);
        let transport = options.wave.is_some() || options.intensity == Intensity::Transport;
        let unit = if transport && !options.infinite { LightUnit::Irradiance } else { LightUnit::Factor };
        let between = options.wave.is_none() && options.intensity == Intensity::Transport;
        let options = options.clone();
        Ok(Volume { bindings, options, light, plan, unit, between, stored: false, volumes, values, lights })
    }

    /// A volume from a file, for a scene of the same light and surface; else a sentence that says what differs.
    pub fn from_stored(
        device: &Device,
        scene: &Scene,
        stored: &StoredVolume,
    ) -> Result<Result<Self, String>, GpuError> {
        let header = &stored.header;
        if header.light >= scene.lights.len() {
            return Ok(Err(format!("it has light {}, and the scene has {}", header.light, scene.lights.len())));
        }
        let grid = Grid { lower: header.lower.into(), cell: header.cell, cells: header.cells };
        let options = VolumeOptions { grid: Some(grid), ..VolumeOptions::default() };
        let Some(mut plan) = Plan::new(scene, header.light, &options) else {
            return Ok(Err(format!("light {} comes through no surface here", header.light)));
        };
        let planes = &plan.shared.grid;
        if planes.axes != header.axes || (planes.backward != 0) != header.backward {
            return Ok(Err(format!("light {} comes another way through the surface here", header.light)));
        }
        plan.offset = header.offset;
        let mut volume = Self::with_plan(device, plan, header.light, &options)?;
        let shared = |&value: &f32| match value {
            value if value.is_nan() => OUTSIDE,
            value => value.min(UNKNOWN),
        };
        volume.values.upload(bytemuck::cast_slice(&stored.phi.iter().map(shared).collect::<Vec<f32>>()))?;
        volume.lights.upload(bytemuck::cast_slice(&stored.light))?;
        (volume.unit, volume.between, volume.stored) = (header.unit, header.between, true);
        Ok(Ok(volume))
    }

    /// What a recorded volume holds, for a file.
    pub fn store(&self) -> Result<StoredVolume, GpuError> {
        let planes = &self.plan.shared.grid;
        let header = VolumeHeader {
            light: self.light,
            lower: self.plan.grid.lower.to_array(),
            cell: self.plan.grid.cell,
            cells: self.plan.grid.cells,
            axes: planes.axes,
            backward: planes.backward != 0,
            offset: self.plan.offset,
            unit: self.unit,
            between: self.between,
        };
        let mut phi: Vec<f32> = self.values.read(self.plan.grid.len())?;
        for value in &mut phi {
            *value = match value.abs() {
                OUTSIDE => f32::NAN,
                UNKNOWN => f32::INFINITY,
                value => value,
            };
        }
        Ok(StoredVolume { header, phi, light: self.read_light()? })
    }

    pub fn grid(&self) -> &Grid {
        &self.plan.grid
    }

    /// What [`read_light`](Self::read_light) has.
    pub fn unit(&self) -> LightUnit {
        self.unit
    }

    /// Whether it is that of the quad from a cell to the next along both axes across the planes, u and v of
    /// [`EikonalGrid`](super::device::EikonalGrid), not of the cell.
    pub fn is_between(&self) -> bool {
        self.between
    }

    /// Takes the volume to what the scene has become: the same light, and instances with the triangles they had. False where
    /// there is nothing left to light. There may be other cells.
    pub fn update(&mut self, device: &Device, scene: &Scene) -> Result<bool, GpuError> {
        let Some(plan) = Plan::new(scene, self.light, &self.options) else { return Ok(false) };
        if plan.grid.cells != self.plan.grid.cells || plan.shared.grid.axes != self.plan.shared.grid.axes {
            *self = Self::with_plan(device, plan, self.light, &self.options)?;
            return Ok(true);
        }
        self.volumes.upload(bytemuck::bytes_of(&plan.shared))?;
        self.plan = plan;
        Ok(true)
    }

    /// Where the scheme is the host's, finds the wave there and waits; [`record`](Self::record) then goes on from it.
    pub fn solve_on_host(
        &self,
        device: &Device,
        scene: &Scene,
        bindings: &Bindings,
        kernels: &Kernels,
    ) -> Result<(), GpuError> {
        let Scheme::Marching(marching) = self.options.solver.scheme else { return Ok(()) };
        let mut recorder = Recorder::new(device)?;
        self.record_given(&mut recorder, bindings, kernels)?;
        recorder.submit()?;
        let (values, given) = self.read()?;
        let found = host::march_from(&self.plan, scene, &values, &given, marching);
        let shared = |value: f64| match value {
            value if value.is_nan() => OUTSIDE,
            value if value.is_infinite() => UNKNOWN,
            value => (value - self.plan.offset).max(0.0) as f32,
        };
        let values: Vec<f32> = found.into_iter().map(shared).collect();
        self.values.upload(bytemuck::cast_slice(&values))
    }

    /// Records the way from the scene's triangles, as they are then, to values and light in all cells.
    pub fn record(&self, recorder: &mut Recorder, scene: &Bindings, kernels: &Kernels) -> Result<(), GpuError> {
        if self.stored {
            return Ok(());
        }
        if !matches!(self.options.solver.scheme, Scheme::Marching(_)) {
            self.record_given(recorder, scene, kernels)?;
            self.record_wave(recorder, kernels)?;
        }
        self.record_light(recorder, scene, kernels)
    }

    /// Records what is given next to the surface, marked as such.
    pub fn record_given(&self, recorder: &mut Recorder, scene: &Bindings, kernels: &Kernels) -> Result<(), GpuError> {
        let bindings = [scene, &self.bindings];
        let push = EikonalPush { volume: 0 };
        let [u, v, _] = self.plan.shared.grid.cells;
        recorder.pass("eikonal/clear")?.fill(&self.values, 0);
        let mut pass = recorder.pass("eikonal/cross")?;
        for facets in &self.plan.facets {
            pass.dispatch(&kernels.cross, &bindings, facets, facets.triangles * facets.parts)?;
        }
        drop(pass);
        recorder.pass("eikonal/classify")?.dispatch(&kernels.classify, &bindings, &push, u * v)?;
        recorder.pass("eikonal/mark")?.dispatch(&kernels.mark, &bindings, &push, u * v)?;
        let mut pass = recorder.pass("eikonal/given")?;
        for facets in &self.plan.facets {
            pass.dispatch(&kernels.given, &bindings, facets, facets.triangles * facets.parts)?;
        }
        drop(pass);
        recorder.pass("eikonal/seal")?.dispatch(&kernels.seal, &bindings, &push, self.plan.grid.len() as u32)?;
        recorder.pass("eikonal/sides")?.dispatch(&kernels.sides, &bindings, &push, 2 * (u + v))?;
        Ok(())
    }

    /// Records the wave from what is given.
    pub fn record_wave(&self, recorder: &mut Recorder, kernels: &Kernels) -> Result<(), GpuError> {
        kernels.solver.record(recorder, &self.bindings, &self.plan.shared.grid, self.plan.foot, &self.options.solver)
    }

    /// Records how bright a recorded wave makes the cells.
    pub fn record_light(&self, recorder: &mut Recorder, scene: &Bindings, kernels: &Kernels) -> Result<(), GpuError> {
        let bindings = [scene, &self.bindings];
        let cells = self.plan.grid.len() as u32;
        match self.options.intensity {
            Intensity::Transport => {
                let [u, v, planes] = self.plan.shared.grid.cells;
                let push = LitPush { volume: 0, runs: u.div_ceil(RUN) };
                recorder.pass("eikonal/light")?.dispatch(&kernels.light, &bindings, &push, push.runs * v * planes)?;
            }
            Intensity::Laplacian { base, gain, power } => {
                let push = CurvePush { volume: 0, base, gain, power };
                recorder.pass("eikonal/curve")?.dispatch(&kernels.curve, &bindings, &push, cells)?;
            }
        }
        self.record_spread(recorder, kernels)
    }

    /// Grid and light as kernels see them.
    pub(super) fn shared(&self) -> &EikonalVolume {
        &self.plan.shared
    }

    fn record_spread(&self, recorder: &mut Recorder, kernels: &Kernels) -> Result<(), GpuError> {
        let Some(Dissipation { first, slope }) = self.plan.dissipation else { return Ok(()) };
        let below = self.plan.shared.grid.cells[2] as f32 - 1.0 - first;
        let steps = (below * slope / SPREAD_STEP).ceil().max(0.0) as u32;
        let push = |step, last| SpreadPush { volume: 0, step, first, slope, last };
        let pushes = (0..steps).map(|step| push(step, 0)).chain((steps > 0).then(|| push(steps, 1)));
        let groups = Groups::of(&kernels.spread, self.plan.grid.len() as u32);
        recorder.pass("eikonal/spread")?.dispatch_in_turn(&kernels.spread, &[&self.bindings], pushes, groups)?;
        Ok(())
    }

    /// Light of all cells, in the volume's [`unit`](Self::unit); less than 0 where it is not known.
    pub fn read_light(&self) -> Result<Vec<f32>, GpuError> {
        self.lights.read(self.plan.grid.len())
    }

    /// How well a recorded wave has settled.
    pub fn check(&self, device: &Device, kernels: &Kernels) -> Result<Settled, GpuError> {
        kernels.solver.check(device, &self.bindings, &self.plan.shared.grid, self.plan.foot, &self.options.solver)
    }

    /// Optical paths from the light, metres times index (with an infinite index: metres from the surface); infinite where no
    /// wave came, NaN outside of the medium. And which values were given, not found.
    pub fn read(&self) -> Result<(Vec<f64>, Vec<bool>), GpuError> {
        let values: Vec<f32> = self.values.read(self.plan.grid.len())?;
        let path = |value: f32| match value.abs() {
            OUTSIDE => f64::NAN,
            UNKNOWN => f64::INFINITY,
            value => f64::from(value) + self.plan.offset,
        };
        let given = values.iter().map(|value| value.is_sign_negative()).collect();
        Ok((values.into_iter().map(path).collect(), given))
    }
}
