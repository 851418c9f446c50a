//! One light's volume: where it is, what is given next to the surface, and what the wave makes of it.

use glam::{DVec3, Vec3};

use super::Grid;
use super::device::{EikonalGrid, EikonalPush, EikonalSource, EikonalVolume, FacetPush, OUTSIDE, UNKNOWN};
use super::path::Source;
use super::solver::{BLOCK, Settled, Solver, SolverOptions};
use crate::gpu::{Bindings, Buffer, Device, GpuError, Kernel, Recorder};
use crate::scene::{Bounds, Emitter, Light, MediumId, Scene, Surface};

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

/// Cells beyond what is to be lit and above the surface, on each side: look-ups and differences want neighbours.
const MARGIN: f64 = 2.0;
/// Cells below the surface that are given: differences of second order reach as far, and so does what goes on beyond sides.
const BAND: u32 = 2;
/// Components of the light's mean way below which it comes in by neither of two sides.
const UPRIGHT: f32 = 0.02;

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

pub struct Volume {
    pub grid: Grid,
    /// The column from which light spreads, of the planes' columns.
    pub foot: [i32; 2],
    pub bindings: Bindings,
    options: VolumeOptions,
    shared: EikonalVolume,
    values: Buffer,
    asked: Buffer,
    lights: Buffer,
    /// What the kernels' values lack, metres times index.
    offset: f64,
    facets: Vec<FacetPush>,
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
        let light = &scene.lights[light];
        let Some(surface) = RefractingSurface::of(scene, light) else { return Ok(None) };
        let index = |medium: MediumId| if options.infinite { 1.0 } else { f64::from(scene.media[medium].index) };
        let source = match &light.emitter {
            _ if options.infinite => Source::Surface,
            Emitter::Point { position, .. } | Emitter::Spot { position, .. } => {
                Source::Point { position: position.as_dvec3(), index: index(light.medium) }
            }
            Emitter::Directional { direction, .. } => {
                Source::Directional { direction: direction.as_dvec3().normalize(), index: index(light.medium) }
            }
        };
        let way = surface.mean_way(&source, index(surface.wave_medium));
        let Some(grid) = options.grid.or_else(|| surface.grid(scene, way, options.resolution)) else { return Ok(None) };
        let planes = EikonalGrid::new(&grid, way, index(surface.wave_medium));
        let (shared_source, offset) = EikonalSource::new(&source, &grid);
        let shared = EikonalVolume {
            grid: planes,
            source: shared_source,
            light_medium: light.medium as u32,
            wave_medium: surface.wave_medium as u32,
            band: BAND,
            padding0: 0,
        };
        let values = Buffer::new(device, "eikonal values", 4 * grid.len() as u64)?;
        let volumes = Buffer::from_slice(device, "eikonal volumes", &[shared])?;
        let columns = planes.cells[0] * planes.cells[1];
        let tops = Buffer::new(device, "eikonal tops", 4 * u64::from(columns))?;
        let sides = 2 * u64::from(planes.cells[0] + planes.cells[1]) * u64::from(planes.cells[2]);
        let sides = Buffer::new(device, "eikonal sides", 4 * sides)?;
        let blocks = u64::from(columns) * u64::from(planes.cells[2].div_ceil(BLOCK));
        let lights = Buffer::new(device, "eikonal lights", 4 * grid.len() as u64)?;
        let asked = Buffer::new(device, "eikonal asked", 4 * blocks)?;
        let foot = match source {
            Source::Point { position, .. } => planes.column(&grid, position),
            _ => [0, 1].map(|i| match way[planes.axes[i] as usize] {
                w if w > UPRIGHT => 0,
                w if w < -UPRIGHT => planes.cells[i] as i32 - 1,
                _ => planes.cells[i] as i32 / 2,
            }),
        };
        let facets = surface.instances.iter().map(|&instance| {
            let triangles = scene.meshes[scene.instances[instance].mesh].triangles.len() as u32;
            let parts = (columns / triangles.max(1)).clamp(1, 4096);
            FacetPush { volume: 0, instance: instance as u32, triangles, parts }
        });
        Ok(Some(Volume {
            foot,
            bindings: Bindings::new()
                .buffer("EikonalVolumes", &volumes)
                .buffer("EikonalValues", &values)
                .buffer("EikonalTops", &tops)
                .buffer("EikonalSides", &sides)
                .buffer("EikonalAsked", &asked)
                .buffer("EikonalLights", &lights),
            options: options.clone(),
            shared,
            values,
            asked,
            lights,
            offset,
            facets: facets.collect(),
            grid,
        }))
    }

    /// Records the way from the scene's triangles, as they are then, to values in all cells.
    pub fn record(&self, recorder: &mut Recorder, scene: &Bindings, kernels: &Kernels) -> Result<(), GpuError> {
        self.record_given(recorder, scene, kernels)?;
        self.record_wave(recorder, kernels)?;
        self.record_light(recorder, scene, kernels)?;
        self.record_open(recorder, kernels)
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

    /// Records the light that goes along a recorded wave whose marks are still there.
    pub fn record_light(&self, recorder: &mut Recorder, scene: &Bindings, kernels: &Kernels) -> Result<(), GpuError> {
        self.record_light_below(recorder, scene, kernels)?;
        kernels.solver.record_flow(recorder, &self.bindings, &self.shared.grid, self.foot, &self.options.solver)
    }

    /// Records the light just below the surface in cells that are given; there is none in others yet.
    pub(super) fn record_light_below(
        &self,
        recorder: &mut Recorder,
        scene: &Bindings,
        kernels: &Kernels,
    ) -> Result<(), GpuError> {
        let bindings = [scene, &self.bindings];
        recorder.pass("eikonal/clear_light")?.fill(&self.lights, 0).fill(&self.asked, 1);
        let mut pass = recorder.pass("eikonal/light")?;
        for facets in &self.facets {
            pass.dispatch(&kernels.light, &bindings, facets, facets.triangles * facets.parts)?;
        }
        Ok(())
    }

    /// Records the end: marks are taken off what was given.
    pub(super) fn record_open(&self, recorder: &mut Recorder, kernels: &Kernels) -> Result<(), GpuError> {
        let push = EikonalPush { volume: 0 };
        let cells = self.grid.len() as u32;
        recorder.pass("eikonal/open")?.dispatch(&kernels.open, &[&self.bindings], &push, cells)?;
        Ok(())
    }

    /// Grid and light as kernels see them.
    pub(super) fn shared(&self) -> &EikonalVolume {
        &self.shared
    }

    /// Irradiance across the light's way over what the light sends there: over W/sr, in 1/m2, or over W/m2. Media take nothing.
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

/// The surface through which a light gets into another medium.
struct RefractingSurface {
    wave_medium: MediumId,
    instances: Vec<usize>,
    bounds: Bounds,
    /// Unit, on the light's side, mean by area over what faces the light.
    normal: Vec3,
}

impl RefractingSurface {
    /// Of all media that border on the light's, the one with the largest surface.
    fn of(scene: &Scene, light: &Light) -> Option<Self> {
        let beyond = |instance: &usize| match scene.materials[scene.instances[*instance].material].surface {
            Surface::Dielectric { front, back } if front == light.medium && back != front => Some((back, 1.0)),
            Surface::Dielectric { front, back } if back == light.medium && back != front => Some((front, -1.0)),
            _ => None,
        };
        let borders: Vec<(usize, MediumId, f32)> =
            (0..scene.instances.len()).filter_map(|i| beyond(&i).map(|(medium, side)| (i, medium, side))).collect();
        let area = |medium: MediumId| -> f32 {
            borders.iter().filter(|b| b.1 == medium).map(|b| scene.area(&scene.instances[b.0])).sum()
        };
        let wave_medium = borders.iter().map(|b| b.1).max_by(|&a, &b| area(a).total_cmp(&area(b)))?;
        let mut found =
            RefractingSurface { wave_medium, instances: Vec::new(), bounds: Bounds::EMPTY, normal: Vec3::ZERO };
        for &(index, _, side) in borders.iter().filter(|b| b.1 == wave_medium) {
            found.instances.push(index);
            found.include(scene, index, side, light);
        }
        found.normal = found.normal.try_normalize()?;
        Some(found)
    }

    fn include(&mut self, scene: &Scene, instance: usize, side: f32, light: &Light) {
        let instance = &scene.instances[instance];
        let mesh = &scene.meshes[instance.mesh];
        let side = if instance.transform.matrix3.determinant() < 0.0 { -side } else { side };
        let corners = |triangle: &[u32; 3]| {
            triangle.map(|corner| instance.transform.transform_point3(mesh.positions[corner as usize]))
        };
        for [a, b, c] in mesh.triangles.iter().map(corners) {
            [a, b, c].into_iter().for_each(|corner| self.bounds.include(corner));
            let facing = side * (b - a).cross(c - a);
            let towards = match &light.emitter {
                Emitter::Point { position, .. } | Emitter::Spot { position, .. } => *position - (a + b + c) / 3.0,
                Emitter::Directional { direction, .. } => -*direction,
            };
            if facing.dot(towards) > 0.0 {
                self.normal += facing;
            }
        }
    }

    /// Which way the wave goes, on the whole; not zero.
    fn mean_way(&self, source: &Source, index: f64) -> Vec3 {
        let normal = self.normal.as_dvec3();
        let middle = 0.5 * (self.bounds.min + self.bounds.max).as_dvec3();
        let (light, above) = match *source {
            Source::Point { position, index } => ((middle - position).normalize_or(-normal), index),
            Source::Directional { direction, index } => (direction, index),
            Source::Surface => (-normal, 0.0),
        };
        let across = (light - normal * normal.dot(light)) * (above / index);
        let ahead = (1.0 - across.length_squared()).max(1e-4).sqrt();
        (across - ahead * normal).as_vec3()
    }

    /// Cells over what is to be lit below the surface. `None` where there is nothing.
    fn grid(&self, scene: &Scene, way: Vec3, resolution: u32) -> Option<Grid> {
        let mut lit = Bounds::EMPTY;
        for instance in scene.instances.iter().filter(|i| !scene.materials[i.material].surface.is_specular()) {
            let positions = &scene.meshes[instance.mesh].positions;
            positions.iter().for_each(|&position| lit.include(instance.transform.transform_point3(position)));
        }
        let along = way.abs().max_position();
        let (mut lower, mut upper) = (lit.min.max(self.bounds.min), lit.max.min(self.bounds.max));
        // Along the light's way, from where it first meets the surface to the last thing that it lights.
        if way[along] < 0.0 {
            (lower[along], upper[along]) = (lit.min[along].min(self.bounds.min[along]), self.bounds.max[along]);
        } else {
            (lower[along], upper[along]) = (self.bounds.min[along], lit.max[along].max(self.bounds.max[along]));
        }
        if !(upper.cmpgt(lower).all() && lower.is_finite() && upper.is_finite()) {
            return None;
        }
        let longest = f64::from((upper - lower).max_element());
        let cell = longest / (f64::from(resolution) - 2.0 * MARGIN).max(1.0);
        let margin = Vec3::splat((MARGIN * cell) as f32);
        // Across the light's way the surface's own extent is the end: beyond it nothing is known.
        let (mut least, mut most) = (self.bounds.min, self.bounds.max);
        (least[along], most[along]) = (f32::NEG_INFINITY, f32::INFINITY);
        let lower = (lower - margin).max(least).as_dvec3();
        let upper = (upper + margin).min(most).as_dvec3();
        let cells = ((upper - lower) / cell + 1e-3).floor().max(DVec3::ONE);
        let left = upper - lower - cells * cell;
        Some(Grid { lower: lower + 0.5 * left, cell, cells: cells.as_uvec3().to_array() })
    }
}
