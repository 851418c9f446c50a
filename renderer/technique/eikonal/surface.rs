//! The surface through which a light gets into another medium, and the box of cells behind it.

use glam::{DVec3, Vec3};

use super::Grid;
use super::path::Source;
use crate::scene::{Bounds, Emitter, Light, MediumId, Scene, Surface};

/// Cells beyond what is to be lit and above the surface, on each side: look-ups and differences want neighbours.
const MARGIN: f64 = 2.0;

/// All instances that part a light's medium from one other.
pub(super) struct RefractingSurface {
    pub wave_medium: MediumId,
    pub instances: Vec<usize>,
    bounds: Bounds,
    /// Unit, on the light's side, mean by area over what faces the light.
    normal: Vec3,
}

impl RefractingSurface {
    /// Of all media that border on the light's, the one with the largest surface.
    pub fn of(scene: &Scene, light: &Light) -> Option<Self> {
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
    pub fn mean_way(&self, source: &Source, index: f64) -> Vec3 {
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

    /// Root mean squares over the surface of its slope against its mean plane, and of how much it turns along a line, 1/m.
    pub fn roughness(&self, scene: &Scene) -> (f64, f64) {
        let (mut slope, mut turn, mut total) = (0.0, 0.0, 0.0);
        for instance in self.instances.iter().map(|&index| &scene.instances[index]) {
            let mesh = &scene.meshes[instance.mesh];
            let to_normal = instance.transform.matrix3.inverse().transpose();
            for triangle in &mesh.triangles {
                let at = triangle.map(|corner| instance.transform.transform_point3(mesh.positions[corner as usize]));
                let normal = triangle.map(|corner| (to_normal * mesh.normals[corner as usize]).normalize_or_zero());
                let area = f64::from((at[1] - at[0]).cross(at[2] - at[0]).length());
                let cosines = normal.map(|n| f64::from(n.dot(self.normal).abs()).clamp(0.1, 1.0));
                let edges = [(0, 1), (1, 2), (2, 0)];
                let turns = edges.map(|(a, b)| {
                    f64::from((normal[a] - normal[b]).length_squared() / (at[a] - at[b]).length_squared().max(1e-20))
                });
                slope += area * cosines.iter().map(|c| 1.0 / (c * c) - 1.0).sum::<f64>() / 3.0;
                turn += area * turns.iter().sum::<f64>() / 3.0;
                total += area;
            }
        }
        if total > 0.0 { ((slope / total).sqrt(), (turn / total).sqrt()) } else { (0.0, 0.0) }
    }

    /// Of the middle of its extent, the coordinate along an axis of the world, m.
    pub fn level(&self, axis: usize) -> f64 {
        f64::from(0.5 * (self.bounds.min[axis] + self.bounds.max[axis]))
    }

    /// Cells over what is to be lit below the surface, `resolution` along the longest side; `None` where there is nothing.
    pub fn grid(&self, scene: &Scene, way: Vec3, resolution: u32) -> Option<Grid> {
        let lit = scene.bounds_of(|instance| !scene.materials[instance.material].surface.is_specular());
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
        // Waves change this from frame to frame. A frame has the cells that are its own, and yet they stay where they are: in
        // steps, and counted from the end that is lit.
        let step = (upper - lower).max_element().log2().floor().exp2() * STEP;
        (lower[along], upper[along]) = ((lower[along] / step).floor() * step, (upper[along] / step).ceil() * step);
        // Across the light's way the surface's own extent is the end: beyond it nothing is known.
        let (mut least, mut most) = (self.bounds.min, self.bounds.max);
        (least[along], most[along]) = (f32::NEG_INFINITY, f32::INFINITY);
        let widened = |cell: f64| {
            let margin = Vec3::splat((MARGIN * cell) as f32);
            ((lower - margin).max(least).as_dvec3(), (upper + margin).min(most).as_dvec3())
        };
        let longest = f64::from((upper - lower).max_element());
        let (least, most) = widened(longest / (f64::from(resolution) - 2.0 * MARGIN).max(1.0));
        // There may have been no room for the margins.
        let cell = (most - least).max_element() / f64::from(resolution);
        let (lower, upper) = widened(cell);
        let mut cells = ((upper - lower) / cell + SLACK).floor().max(DVec3::ONE);
        cells[along] = ((upper - lower)[along] / cell - SLACK).ceil().max(1.0);
        let left = upper - lower - cells * cell;
        let mut first = lower + 0.5 * left;
        first[along] = if way[along] < 0.0 { lower[along] } else { lower[along] + left[along] };
        Some(Grid { lower: first, cell, cells: cells.as_uvec3().to_array() })
    }
}

/// Of the longest side, rounded down to a power of two: what the extent along the light's way is a multiple of.
const STEP: f32 = 1.0 / 64.0;
/// Of a cell, by which a box may be short of whole ones.
const SLACK: f64 = 1e-3;
