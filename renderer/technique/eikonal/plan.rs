//! What the host works out of a volume before the device fills it.

use super::Grid;
use super::device::{EikonalGrid, EikonalSource, EikonalVolume, FacetPush};
use super::path::Source;
use super::surface::RefractingSurface;
use super::volume::VolumeOptions;
use crate::scene::{Emitter, Light, MediumId, Scene};

/// Cells below the surface that are given: differences of second order reach as far, and so does what goes on beyond sides.
const BAND: u32 = 2;
/// Components of the light's mean way below which it comes in by neither of two sides.
const UPRIGHT: f32 = 0.02;

/// All of a volume that the host works out.
pub(super) struct Plan {
    pub grid: Grid,
    /// The column from which light spreads, of the planes' columns.
    pub foot: [i32; 2],
    pub shared: EikonalVolume,
    pub source: Source,
    /// What the kernels' values lack, metres times index.
    pub offset: f64,
    pub facets: Vec<FacetPush>,
    pub dissipation: Option<Dissipation>,
}

/// Where light begins to spread in planes and how fast, as `kernels/technique/eikonal/spread.comp.glsl` wants it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dissipation {
    /// Plane, cells.
    pub first: f32,
    /// Cells across, a plane.
    pub slope: f32,
}

impl Plan {
    pub fn new(scene: &Scene, light: usize, options: &VolumeOptions) -> Option<Self> {
        let light = &scene.lights[light];
        let surface = RefractingSurface::of(scene, light)?;
        let index = |medium: MediumId| if options.infinite { 1.0 } else { f64::from(scene.media[medium].index) };
        let source = source_of(light, index(light.medium), options.infinite);
        let way = surface.mean_way(&source, index(surface.wave_medium));
        let grid = match options.grid {
            Some(grid) => grid,
            None => surface.grid(scene, way, options.resolution)?,
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
        let dissipation = options.spread.filter(|_| options.wave.is_none()).map(|spread| {
            let along = planes.axes[2] as usize;
            let bend = 1.0 - source.index() / index(surface.wave_medium);
            let (slope, turn) = surface.roughness(scene);
            // Light turns by that part of what the surface turns; strong hollows turn twice as much as the mean.
            let depth =
                if spread.threshold > 0.0 { spread.threshold } else { 1.0 / (2.0 * bend.abs() * turn).max(1e-6) };
            let way = surface.level(along) - grid.lower[along];
            let level = if planes.backward != 0 { grid.cell * f64::from(planes.cells[2]) - way } else { way };
            let slope = if spread.slope > 0.0 { spread.slope } else { bend.abs() * slope };
            Dissipation { first: ((level + depth) / grid.cell - 0.5) as f32, slope: slope.min(1.0) as f32 }
        });
        Some(Plan { grid, foot, shared, source, offset, facets: facets.collect(), dissipation })
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
