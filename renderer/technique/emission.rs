//! Where a light has to send photons so that everything specular is reached and little else.
//!
//! Each light looks at the specular triangles through charts: six faces of a cube around a point or spot light, one
//! plane across a directional light. The triangles are drawn conservatively into a fine bitmap over each chart, whose
//! bits are then merged into about as many cells as asked for. All of it in f64, on the host.

pub(crate) mod chart;
pub(crate) mod grid;
mod spot;
#[cfg(test)]
mod tests;

use std::f64::consts::FRAC_PI_2;

use glam::{Affine3A, DAffine3, DVec2, DVec3, Vec3};

use crate::scene::{Emitter, Scene};
use chart::Projector;
use grid::{Grid, Rectangle};
use spot::SpotPattern;

crate::gpu_struct! {
    /// One patch of directions (point, spot) or of a plane (directional) through which photons leave a light.
    ///
    /// `face` 0 to 5 is a side of the cube around a point or spot light: +x, -x, +y, -y, +z, -z. A photon leaves along
    /// normalize(A + u U + v V), where A is the outward axis of the face and A, U, V are right-handed (U x V = A):
    ///
    /// | face | 0  | 1  | 2  | 3  | 4  | 5  |
    /// |------|----|----|----|----|----|----|
    /// | A    | +x | -x | +y | -y | +z | -z |
    /// | U    | +y | +z | +z | +x | +x | +y |
    /// | V    | +z | +y | +x | +z | +y | +x |
    ///
    /// u and v lie in [-1, 1]; du dv covers du dv / (1 + u^2 + v^2)^1.5 sr. With axes numbered from 0 and taken modulo
    /// 3, A is along i = face / 2 and U along i + 1 on even faces, i + 2 on odd ones; V is the third.
    ///
    /// `face` 6 is the plane across a directional light of direction d. A photon starts at u U + v V + `offset` d,
    /// where u and v are metres and, with s = 1 where d.z >= 0 and -1 elsewhere, and a = -1 / (s + d.z),
    ///
    /// U = (1 + s a d.x^2, s a d.x d.y, -s d.x), V = (a d.x d.y, s + a d.y^2, -d.y), so that U x V = d.
    pub struct EmissionCell {
        /// Least u and v.
        pub lower: [f32; 2],
        /// Extent along u and v, positive.
        pub size: [f32; 2],
        /// Index into [`Scene::lights`].
        pub light: u32,
        /// 0 to 5: cube face; 6: plane.
        pub face: u32,
        /// Metres along the light's direction, upstream of the whole scene; 0 unless `face` is 6.
        pub offset: f32,
        pub padding0: u32,
    }
}

/// The cells of all lights.
#[derive(Debug, Clone, PartialEq)]
pub struct Emission {
    /// By light, then by face, then along a Hilbert curve: neighbours in memory are neighbours in direction. Cells
    /// do not overlap, and those of one light are of nearly equal size in u and v.
    pub cells: Vec<EmissionCell>,
    /// W leaving through the cells, one a light; zero for a light without cells.
    pub flux: Vec<Vec3>,
}

/// Cells of a light that has any, where the number asked for would give it fewer.
const LEAST_CELLS: f64 = 16.0;
/// Bits over all charts of a light: enough for 4096 cells of 10 by 10 bits where one bit in ten is set, and only 512
/// KiB, which a second-level cache holds.
const FINE_CELLS: f64 = 4_194_304.0;
/// Bits along one side of a chart.
const FINE_SIDE: f64 = 65_536.0;
/// Of the largest coordinate at hand (1 on a cube face): eight times the rounding of f32, in which rays are traced.
pub(crate) const ROUNDING: f64 = 1e-6;
/// Of the scene's diagonal: how far upstream of it the photons of a directional light start.
pub(crate) const UPSTREAM: f64 = 1e-3;

/// Covers what the lights of `scene` have to light with about `target_cells` cells.
///
/// Every straight line from a light to a specular triangle passes through a cell, save those outside a spot light's
/// cone. Cells are shared among lights by flux. Without specular objects, or for a light that gives none of them any
/// light, there are no cells.
pub fn emission(scene: &Scene, target_cells: usize) -> Emission {
    let targets = specular_targets(scene);
    let bounds = Bounds::of(scene);
    let footprints: Vec<_> =
        scene.lights.iter().map(|light| Footprint::new(&light.emitter, scene, &targets, &bounds)).collect();
    let even = target_cells as f64 / scene.lights.len().max(1) as f64;
    let flux: Vec<f64> = footprints.iter().map(|footprint| total(footprint.cells(even).1)).collect();
    let all: f64 = flux.iter().sum();

    let mut emission = Emission { cells: Vec::new(), flux: vec![Vec3::ZERO; scene.lights.len()] };
    for (light, footprint) in footprints.iter().enumerate() {
        if flux[light] > 0.0 {
            let share = target_cells as f64 * flux[light] / all;
            let (cells, flux) = footprint.cells(share.max(LEAST_CELLS));
            emission.flux[light] = flux.as_vec3();
            emission.cells.extend(cells.into_iter().map(|cell| EmissionCell { light: light as u32, ..cell }));
        }
    }
    emission
}

fn total(flux: DVec3) -> f64 {
    flux.element_sum()
}

/// A specular instance in world space.
pub(crate) struct Target<'a> {
    positions: Vec<DVec3>,
    triangles: &'a [[u32; 3]],
}

pub(crate) fn specular_targets(scene: &Scene) -> Vec<Target<'_>> {
    let specular = scene.instances.iter().filter(|i| scene.materials[i.material].surface.is_specular());
    specular
        .map(|instance| {
            let mesh = &scene.meshes[instance.mesh];
            let to_world = in_f64(instance.transform);
            let positions = mesh.positions.iter().map(|p| to_world.transform_point3(p.as_dvec3())).collect();
            Target { positions, triangles: &mesh.triangles }
        })
        .collect()
}

fn in_f64(transform: Affine3A) -> DAffine3 {
    let [x, y, z] = [transform.x_axis, transform.y_axis, transform.z_axis].map(|axis| axis.as_dvec3());
    DAffine3::from_cols(x, y, z, transform.translation.as_dvec3())
}

pub(crate) fn triangles<'a>(targets: &'a [Target]) -> impl Iterator<Item = [DVec3; 3]> + 'a {
    let of_one = |target: &'a Target| {
        target.triangles.iter().map(|triangle| triangle.map(|vertex| target.positions[vertex as usize]))
    };
    targets.iter().flat_map(of_one)
}

/// World-space box of all instances.
pub(crate) struct Bounds {
    pub min: DVec3,
    pub max: DVec3,
}

impl Bounds {
    pub fn of(scene: &Scene) -> Self {
        let mut bounds = Bounds { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
        for instance in &scene.instances {
            let to_world = in_f64(instance.transform);
            for position in &scene.meshes[instance.mesh].positions {
                let position = to_world.transform_point3(position.as_dvec3());
                bounds.min = bounds.min.min(position);
                bounds.max = bounds.max.max(position);
            }
        }
        bounds
    }

    /// Metres, the largest coordinate in magnitude.
    pub fn reach(&self) -> f64 {
        self.min.abs().max(self.max.abs()).max_element()
    }

    /// Least p . `direction` of all points in the box.
    pub fn least_along(&self, direction: DVec3) -> f64 {
        (self.min * direction).min(self.max * direction).element_sum()
    }

    pub fn diagonal(&self) -> f64 {
        (self.max - self.min).length()
    }
}

/// What a light emits into the specular triangles: one fine bitmap for each chart that shows any.
struct Footprint<'a> {
    emitter: &'a Emitter,
    /// Of a spot light.
    pattern: Option<SpotPattern>,
    offset: f64,
    grids: Vec<Grid>,
}

impl<'a> Footprint<'a> {
    fn new(emitter: &'a Emitter, scene: &Scene, targets: &[Target], bounds: &Bounds) -> Self {
        let pattern = SpotPattern::of(emitter, &scene.textures);
        let nothing = Footprint { emitter, pattern, offset: 0.0, grids: Vec::new() };
        if targets.is_empty() {
            return nothing;
        }
        // Metres by which rounding may move a point of the scene or the light.
        let blur = ROUNDING * bounds.reach();
        match *emitter {
            Emitter::Point { position, .. } => {
                let position = position.as_dvec3();
                let touch = blur.max(ROUNDING * position.abs().max_element());
                let grids = draw(Projector::point(position, touch, ROUNDING), targets, ROUNDING, Some(1.0));
                Footprint { grids, ..nothing }
            }
            Emitter::Spot { position, direction, outer, .. } => {
                let position = position.as_dvec3();
                let touch = blur.max(ROUNDING * position.abs().max_element());
                let half_angle = (f64::from(outer) + ROUNDING).min(FRAC_PI_2);
                let projector = Projector::spot(position, direction.as_dvec3(), half_angle, touch, ROUNDING);
                Footprint { grids: draw(projector, targets, ROUNDING, Some(1.0)), ..nothing }
            }
            Emitter::Directional { direction, .. } => {
                let direction = direction.as_dvec3();
                let offset = bounds.least_along(direction) - UPSTREAM * bounds.diagonal() - blur;
                Footprint { offset, grids: draw(Projector::directional(direction), targets, blur, None), ..nothing }
            }
        }
    }

    /// About `target` cells, and the flux through them in W.
    fn cells(&self, target: f64) -> (Vec<EmissionCell>, DVec3) {
        let coarseness = grid::coarseness(&self.grids, target);
        let mut cells = Vec::new();
        for grid in &self.grids {
            let blocks = grid.blocks_in_order(coarseness);
            cells.extend(blocks.into_iter().map(|block| self.cell(grid.face, block)));
        }
        let points = self.pattern.as_ref().map_or(0.0, SpotPattern::points);
        let steps = (points / cells.len().max(1) as f64).sqrt().clamp(4.0, 64.0) as u32;
        let flux = cells.iter().map(|cell| self.flux(cell, steps)).sum();
        (cells, flux)
    }

    /// Neighbours share the rounded edge between them, so that no light is lost there.
    fn cell(&self, face: usize, block: Rectangle) -> EmissionCell {
        let [lower, upper] = [block.lower.as_vec2(), block.upper.as_vec2()];
        EmissionCell {
            lower: lower.to_array(),
            size: (upper - lower).to_array(),
            light: 0,
            face: face as u32,
            offset: self.offset as f32,
            padding0: 0,
        }
    }

    /// W through one cell; a spot light's pattern is taken at `steps`^2 points of it.
    fn flux(&self, cell: &EmissionCell, steps: u32) -> DVec3 {
        let [lower, size] = [cell.lower, cell.size].map(|pair| DVec2::from(pair.map(f64::from)));
        match *self.emitter {
            Emitter::Point { intensity, .. } => intensity.as_dvec3() * solid_angle(lower, size),
            Emitter::Directional { irradiance, .. } => irradiance.as_dvec3() * size.element_product(),
            Emitter::Spot { intensity, .. } => {
                let pattern = self.pattern.as_ref();
                let solid_angle = |p: &SpotPattern| p.solid_angle(cell.face as usize, lower, size, steps);
                intensity.as_dvec3() * pattern.map_or(DVec3::ZERO, solid_angle)
            }
        }
    }
}

/// Fits bitmaps around what each chart shows and draws it, in two passes over the triangles. Both widen everything by
/// `margin`, within +-`limit` where there is one.
fn draw(mut projector: Projector, targets: &[Target], margin: f64, limit: Option<f64>) -> Vec<Grid> {
    let mut shown = [Rectangle::EMPTY; chart::FACES];
    for triangle in triangles(targets) {
        projector.project(triangle, |face, polygon| {
            polygon.iter().for_each(|&point| shown[face].include(point));
        });
    }
    let fitted = shown.map(|area| (!area.is_empty()).then(|| area.widened(margin, limit)));
    let step = fine_step(fitted.iter().flatten(), margin);
    let mut grids: [Option<Grid>; chart::FACES] =
        std::array::from_fn(|face| fitted[face].map(|area| Grid::new(face, area, step)));
    for triangle in triangles(targets) {
        projector.project(triangle, |face, polygon| {
            if let Some(grid) = &mut grids[face] {
                grid.mark(polygon, margin);
            }
        });
    }
    grids.into_iter().flatten().collect()
}

/// Side of a fine cell. Cells below the `margin` would be no tighter.
fn fine_step<'a>(areas: impl Iterator<Item = &'a Rectangle> + Clone, margin: f64) -> f64 {
    let area: f64 = areas.clone().map(|area| area.extent().element_product()).sum();
    let longest = areas.map(|area| area.extent().max_element()).fold(0.0, f64::max);
    (area / FINE_CELLS).sqrt().max(longest / FINE_SIDE).max(margin).max(f64::MIN_POSITIVE)
}

/// Steradians of the rectangle at distance 1: of the two triangles that its diagonal makes, after van Oosterom and
/// Strackee 1983. A difference of arctangents at its corners would cancel for small ones.
pub(crate) fn solid_angle(lower: DVec2, size: DVec2) -> f64 {
    let upper = lower + size;
    let [a, c] = [lower, upper].map(|corner| corner.extend(1.0));
    let [b, d] = [DVec3::new(upper.x, lower.y, 1.0), DVec3::new(lower.x, upper.y, 1.0)];
    let triangle = |b: DVec3| {
        let [la, lb, lc] = [a, b, c].map(DVec3::length);
        let cosines = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        2.0 * size.element_product().atan2(cosines)
    };
    triangle(b) + triangle(d)
}
