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
    /// The same, negative where the beam has turned over.
    pub signed: f64,
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
    Some(Place { y, weights, area: 0.5 * twice.abs(), signed: 0.5 * twice, way, distance, end })
}

/// Of a corner's irradiance to the beam's, and the other way: beyond, areas of both signs have cancelled at a fold.
const MOST_CONTRAST: f64 = 3.0;

/// Flux density across the beam's planes, 1/m2 of its flux.
pub fn density(beam: &Beam, place: &Place, light_angle: f64, smooth: bool) -> f64 {
    let least = |l: f64| (light_angle * l).powi(2);
    let own = beam.flux.iter().map(|&flux| f64::from(flux)).sum::<f64>() / 3.0 / place.signed;
    let round_corner = beam.corners.map(|c| {
        let l = (place.y - f64::from(c.start)).max(0.0) * vec(c.way).length();
        let area = f64::from(c.area[0]) + l * f64::from(c.area[1]) + l * l * f64::from(c.area[2]);
        let ratio = f64::from(c.flux) / area / own;
        if ratio > 1.0 / MOST_CONTRAST && ratio < MOST_CONTRAST { ratio } else { 1.0 }
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

/// A view ray in a medium.
#[derive(Debug, Clone, Copy)]
pub struct ViewRay {
    pub origin: DVec3,
    /// Unit, away from the eye.
    pub direction: DVec3,
    /// m.
    pub length: f64,
}

/// A medium of which the coefficients are 1/m.
#[derive(Debug, Clone, Copy)]
pub struct Fog {
    pub scattering: f64,
    pub extinction: f64,
    /// Of Henyey and Greenstein.
    pub asymmetry: f64,
}

/// Between the planes through its starts and through its ends, and inside.
fn is_in(beam: &Beam, point: DVec3) -> bool {
    let side = |pick: fn(&nephroid::technique::beams::beam::BeamCorner) -> f32| {
        let [a, b, c] = beam.corners.map(|corner| vec(corner.origin) + f64::from(pick(&corner)) * vec(corner.way));
        let normal = (b - a).cross(c - a);
        normal.dot(point - a) * normal.dot(vec(beam.normal)).signum()
    };
    let of = |pick: fn(f64, f64) -> f64, ys: [f32; 3]| ys.map(f64::from).into_iter().reduce(pick).unwrap_or_default();
    let range = of(f64::min, beam.corners.map(|c| c.start))..=of(f64::max, beam.corners.map(|c| c.end));
    place(beam, point).is_some_and(|place| place.depth() >= 0.0 && range.contains(&place.y))
        && side(|c| c.start) >= 0.0
        && side(|c| c.end) <= 0.0
}

/// Radiance per W at the ray's origin; `None` where the beam is cut too near its focus for a quadrature.
pub fn inscattered(beam: &Beam, ray: &ViewRay, fog: &Fog, light_angle: f64) -> Option<f64> {
    const LOOKS: usize = 1000;
    const STEPS: usize = 200;
    // Looked for within the ball round the beam.
    let ends = beam.corners.map(|c| [c.start, c.end].map(|y| vec(c.origin) + f64::from(y) * vec(c.way)));
    let middle = ends.iter().flatten().sum::<DVec3>() / 6.0;
    let radius = 1.1 * ends.iter().flatten().map(|p| p.distance(middle)).fold(0.0, f64::max);
    let nearest = (middle - ray.origin).dot(ray.direction);
    let half = (radius * radius - (ray.origin + nearest * ray.direction).distance_squared(middle)).max(0.0).sqrt();
    let first = (nearest - half).max(0.0);
    let last = (nearest + half).min(ray.length);
    if half == 0.0 || last <= first {
        return Some(0.0);
    }
    let at = |t: f64| ray.origin + t * ray.direction;
    let step = (last - first) / LOOKS as f64;
    let border = |mut low: f64, mut high: f64| {
        let inside = is_in(beam, at(low));
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if is_in(beam, at(middle)) == inside { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    };
    let mut borders = Vec::new();
    let mut was = is_in(beam, at(first));
    if was {
        borders.push(first);
    }
    for look in 0..LOOKS {
        let t = first + look as f64 * step;
        let is = is_in(beam, at(t + step));
        if is != was {
            borders.push(border(t, t + step));
        }
        was = is;
    }
    if was {
        borders.push(last);
    }
    let mut sum = 0.0;
    for pair in borders.chunks(2) {
        let size = (pair[1] - pair[0]) / STEPS as f64;
        let (mut least, mut most) = (f64::INFINITY, 0.0f64);
        for index in 0..STEPS {
            let t = pair[0] + (index as f64 + 0.5) * size;
            let place = place(beam, at(t))?;
            if place.area < 3.0 * (light_angle * place.distance).powi(2) {
                return None;
            }
            (least, most) = (least.min(place.area), most.max(place.area));
            let light = place.way.normalize();
            let g = fog.asymmetry;
            let cosine = -light.dot(ray.direction);
            let phase = (1.0 - g * g) / (4.0 * std::f64::consts::PI * (1.0 + g * g - 2.0 * g * cosine).powf(1.5));
            let fluence = density(beam, &place, light_angle, true) / light.dot(vec(beam.normal));
            sum += fog.scattering * phase * fluence * (-fog.extinction * (t + place.distance)).exp() * size;
        }
        if most > 100.0 * least {
            return None;
        }
    }
    Some(sum)
}
