//! Questions, and all their answers.

use glam::{DVec2, DVec3};

use super::spread::{fresnel_transmittance, light_side};
use super::{Patch, Surface, roots};

/// Roots closer than this part of their triangle's longest edge are one root, found from both sides of an edge.
const SAME: f64 = 1e-8;

#[derive(Debug, Clone, Copy)]
pub enum Light {
    /// Where it is.
    Point(DVec3),
    /// The unit direction in which light travels.
    Directional(DVec3),
}

/// Which paths lead from the light to the point through one refraction? The indices must differ.
#[derive(Debug, Clone, Copy)]
pub struct Query {
    pub point: DVec3,
    /// Refractive index around the point.
    pub point_index: f64,
    pub light: Light,
    /// Refractive index around the light.
    pub light_index: f64,
}

/// One refracted path. Whether anything stands in its way is not asked; [`Surface::crossings`] tells.
#[derive(Debug, Clone, Copy)]
pub struct Path {
    pub triangle: usize,
    /// Weights of the triangle's second and third corner.
    pub barycentrics: [f64; 2],
    /// Where it crosses the surface.
    pub point: DVec3,
    /// From the crossing to the query's point, unit.
    pub to_point: DVec3,
    /// From the crossing to the light, unit.
    pub to_light: DVec3,
    /// Metres from the crossing to the query's point.
    pub point_leg: f64,
    /// Metres from the crossing to the light; infinite where it is directional.
    pub light_leg: f64,
    /// R: area across the path at the point, over solid angle at a point light (m2/sr) or over area across a
    /// directional light's rays. Irradiance is `transmittance * cosine / r` times intensity or irradiance of the light.
    pub r: f64,
    /// 1, or -1 where a focus lies between surface and point, so that neighbouring rays arrive mirrored.
    pub orientation: f64,
    /// Unpolarised Fresnel transmittance, at the shading normal.
    pub transmittance: f64,
    /// Whether the light is on the side of the triangle's front face.
    pub light_in_front: bool,
}

impl Query {
    /// The same question with point and light exchanged; point lights only.
    pub fn reversed(&self) -> Self {
        let Light::Point(light) = self.light else { panic!("a directional light is no point") };
        Self {
            point: light,
            point_index: self.light_index,
            light: Light::Point(self.point),
            light_index: self.point_index,
        }
    }

    /// Unit direction from `at` to the light, and the distance.
    pub fn toward_light(&self, at: DVec3) -> (DVec3, f64) {
        match self.light {
            Light::Point(position) => ((position - at).normalize(), position.distance(at)),
            Light::Directional(direction) => (-direction, f64::INFINITY),
        }
    }

    /// Unit direction from `at` to the point, and the distance.
    pub fn toward_point(&self, at: DVec3) -> (DVec3, f64) {
        ((self.point - at).normalize(), self.point.distance(at))
    }

    /// The generalised half vector of Walter et al. 2009, parallel to the normal where light is refracted (not unit).
    pub fn half(&self, at: DVec3) -> DVec3 {
        self.point_index * self.toward_point(at).0 + self.light_index * self.toward_light(at).0
    }
}

/// Every path, in no particular order.
///
/// Point and light must be on opposite sides of both the triangle and the shading normal; which of them is in front is
/// not asked, so a caller with media on fixed sides drops paths by [`Path::light_in_front`]. Roots that are closer than
/// 1e-8 of an edge are reported as one. Closer to a fold than pairs of roots 1e-6 of an edge apart, one or both may be
/// left out.
pub fn all_paths(surface: &Surface, query: &Query) -> Vec<Path> {
    let mut paths: Vec<Path> = Vec::new();
    for triangle in surface.candidates(|centre, radius, normal, turn| may_refract(query, centre, radius, normal, turn))
    {
        let patch = surface.patch(triangle);
        let same = SAME * patch.edges[0].length().max(patch.edges[1].length());
        for at in roots::find(&patch, query) {
            if let Some(path) = path_at(&patch, query, triangle, at)
                && paths.iter().all(|other| other.point.distance(path.point) > same)
            {
                paths.push(path);
            }
        }
    }
    paths
}

/// Whether the half vector of any point in a ball can be parallel to any normal in a ball of normals.
fn may_refract(query: &Query, centre: DVec3, radius: f64, normal: DVec3, normal_radius: f64) -> bool {
    // w = x / |x| turns by at most |step| / (distance that is left), and two unit vectors differ by at most 2.
    let sway = |distance: f64| if distance > radius { (radius / (distance - radius)).min(2.0) } else { 2.0 };
    let (_, point_leg) = query.toward_point(centre);
    let (_, light_leg) = query.toward_light(centre);
    let half = query.half(centre);
    let half_radius = query.point_index * sway(point_leg)
        + if light_leg.is_finite() { query.light_index * sway(light_leg) } else { 0.0 };
    let (half_size, normal_size) = (half.length(), normal.length());
    if half_radius >= half_size || normal_radius >= normal_size {
        return true;
    }
    let spread = (half_radius / half_size).asin() + (normal_radius / normal_size).asin();
    let angle = (half.cross(normal).length()).atan2(half.dot(normal).abs());
    angle <= spread + 1e-9
}

fn path_at(patch: &Patch, query: &Query, triangle: usize, at: DVec2) -> Option<Path> {
    let point = patch.position(at);
    let shading = patch.normal(at).normalize();
    let (to_point, point_leg) = query.toward_point(point);
    let (to_light, light_leg) = query.toward_light(point);
    let opposite = |n: DVec3| to_point.dot(n) * to_light.dot(n) < 0.0;
    if !opposite(shading) || !opposite(patch.geometric) {
        return None;
    }
    let r = light_side(patch, query, at);
    Some(Path {
        triangle,
        barycentrics: at.to_array(),
        point,
        to_point,
        to_light,
        point_leg,
        light_leg,
        r: r.abs(),
        orientation: r.signum(),
        transmittance: fresnel_transmittance(to_light.dot(shading).abs(), query.light_index / query.point_index),
        light_in_front: to_light.dot(patch.geometric) > 0.0,
    })
}
