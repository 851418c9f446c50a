//! The light of a beam in f64, from its record: barycentrics by two linear equations instead of areas.

use glam::{DMat2, DVec2, DVec3};
use nephroid::technique::beams::beam::Beam;

/// Where a point lies in a beam.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    pub y: f64,
    pub weights: [f64; 3],
    /// m2, without sign.
    pub area: f64,
    /// Its component along the beam's normal is 1.
    pub way: DVec3,
    /// m along the light's way since it left the surface.
    pub distance: f64,
    /// y of the end between the edges' ends.
    pub end: f64,
}

impl Place {
    /// How far inside: the smallest weight.
    pub fn depth(&self) -> f64 {
        self.weights.iter().copied().fold(f64::INFINITY, f64::min)
    }
}

fn vec(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

/// Of any point with a definite place, inside or not.
pub fn place(beam: &Beam, point: DVec3) -> Option<Place> {
    let normal = vec(beam.normal);
    let y = normal.dot(point - vec(beam.corners[0].origin));
    let (u, v) = normal.any_orthonormal_pair();
    let flat = |p: DVec3| DVec2::new(p.dot(u), p.dot(v));
    let corners = beam.corners.map(|c| flat(vec(c.origin) + y * vec(c.way) - point));
    let sides = DMat2::from_cols(corners[1] - corners[0], corners[2] - corners[0]);
    let twice = sides.determinant();
    if twice == 0.0 || !twice.is_finite() {
        return None;
    }
    let solved = sides.inverse() * -corners[0];
    let weights = [1.0 - solved.x - solved.y, solved.x, solved.y];
    let mixed = |of: [f64; 3]| weights[0] * of[0] + weights[1] * of[1] + weights[2] * of[2];
    let ways = beam.corners.map(|c| vec(c.way));
    let way = weights[0] * ways[0] + weights[1] * ways[1] + weights[2] * ways[2];
    let distance = (y - mixed(beam.corners.map(|c| f64::from(c.start)))) * way.length();
    let end = mixed(beam.corners.map(|c| f64::from(c.end)));
    Some(Place { y, weights, area: 0.5 * twice.abs(), way, distance, end })
}

/// Flux density across the beam's planes, 1/m2 of its flux.
pub fn density(beam: &Beam, place: &Place, light_angle: f64, smooth: bool) -> f64 {
    let least = |l: f64| (light_angle * l).powi(2);
    let round_corner = beam.corners.map(|c| {
        let l = (place.y - f64::from(c.start)).max(0.0) * vec(c.way).length();
        let area = f64::from(c.area[0]) + l * f64::from(c.area[1]) + l * l * f64::from(c.area[2]);
        f64::from(c.flux) / area.abs().max(least(l)).max(1e-20)
    });
    let even = round_corner.iter().sum::<f64>() / 3.0;
    let mixed: f64 = (0..3).map(|i| place.weights[i] * round_corner[i]).sum();
    (if smooth { mixed / even } else { 1.0 }) / place.area.max(least(place.distance)).max(1e-20)
}

/// W/m2 on a surface with this normal, by a beam of 1 W where `extinction` (1/m) is on the way; nothing outside.
pub fn irradiance(beam: &Beam, point: DVec3, normal: DVec3, extinction: f64, light_angle: f64, smooth: bool) -> f64 {
    let Some(place) = place(beam, point) else { return 0.0 };
    let cosine = -place.way.normalize().dot(normal);
    if place.depth() < 0.0 || place.distance <= 0.0 || cosine <= 0.0 {
        return 0.0;
    }
    let across = place.way.normalize().dot(vec(beam.normal));
    density(beam, &place, light_angle, smooth) * cosine / across * (-extinction * place.distance).exp()
}
