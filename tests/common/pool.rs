//! What is known of the pools in closed form.

use std::f64::consts::PI;
use std::path::Path;

use glam::{DVec3, Vec3};
use nephroid::conformance::closed_forms::under_direction;
#[allow(unused_imports, reason = "each test binary uses its part")]
pub use nephroid::conformance::closed_forms::{flat_water_irradiance, floor_point, refracted_light};
use nephroid::scene::{self, Scene};

/// A shipped scene whose water has 64 x 64 quads and not 256 x 256, so that it is quick.
pub fn coarse(name: &str) -> Scene {
    let path = Path::new("scenes").join(name);
    let text = std::fs::read_to_string(&path).unwrap();
    scene::parse(&text.replace("quads = [256, 256]", "quads = [64, 64]"), &path).unwrap()
}

/// Where a ray of camera `under` through a pixel, as in [`floor_point`], runs in the water before it meets floor or wall:
/// origin, unit direction, metres. `None` where it meets the water's surface first.
pub fn first_water_stretch(column: f64, row: f64, width: f64, height: f64) -> Option<(DVec3, DVec3, f64)> {
    let origin = DVec3::new(0.0, -0.6, 3.5);
    let way = under_direction(column, row, width, height).normalize();
    let to = |plane: f64, axis: usize| (plane - origin[axis]) / way[axis];
    let walls = to(5f64.copysign(way.x), 0).min(to(5f64.copysign(way.z), 2));
    let vertical = to(if way.y < 0.0 { -2.0 } else { 0.0 }, 1);
    (way.y < 0.0 || walls < vertical).then_some((origin, way, walls.min(vertical)))
}

/// Radiance towards the camera of the light that was refracted once at flat water and scattered once, along a stretch in
/// the water of `flat_water.toml`, W/(m2 sr). `medium`: absorption and scattering, 1/m, and Henyey-Greenstein's g.
pub fn flat_water_inscatter(origin: DVec3, direction: DVec3, length: f64, medium: (f64, f64, f64)) -> f64 {
    let (absorption, scattering, g) = medium;
    let extinction = absorption + scattering;
    let integrand = |s: f64| {
        let at = origin + s * direction;
        let light = refracted_light(at);
        let cosine = -light.direction.dot(direction);
        let phase = (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cosine).powf(1.5));
        scattering * phase * light.fluence * (-extinction * (light.in_water + s)).exp()
    };
    // Simpson's rule: the integrand is smooth, and 64 intervals are good to 1e-6.
    let intervals = 64;
    let weight = |i: usize| if i == 0 || i == intervals { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
    let sum: f64 = (0..=intervals).map(|i| weight(i) * integrand(length * i as f64 / intervals as f64)).sum();
    sum * length / (3.0 * intervals as f64)
}

/// Which pixels of `flat_water.toml` seen from under water.
#[derive(Clone, Copy, PartialEq)]
pub enum FlatPart {
    /// Those that see floor or walls.
    Walls,
    /// Those that see the surface, and in it what it reflects.
    Surface,
}

/// `flat_water.toml` with water that absorbs 0.02 and scatters 0.08 of light a metre.
pub fn turbid_flat_pool(asymmetry: f32) -> Scene {
    let mut scene = scene::load(Path::new("scenes/flat_water.toml")).unwrap();
    let water = scene.media.iter_mut().find(|m| m.name == "water").unwrap();
    water.absorption = Vec3::splat(0.02);
    water.scattering = Vec3::splat(0.08);
    water.asymmetry = asymmetry;
    scene
}

/// Of light that meets flat water from below, the part that stays in it.
fn reflectance_from_below(cosine: f64) -> f64 {
    let sine2 = 1.33f64.powi(2) * (1.0 - cosine * cosine);
    if sine2 >= 1.0 {
        return 1.0;
    }
    let above = (1.0 - sine2).sqrt();
    let perpendicular = ((1.33 * cosine - above) / (1.33 * cosine + above)).powi(2);
    let parallel = ((cosine - 1.33 * above) / (cosine + 1.33 * above)).powi(2);
    0.5 * (perpendicular + parallel)
}

/// What a pixel that sees the surface of [`turbid_flat_pool`] shows: the stretch to it, and the one that it reflects.
fn flat_surface_inscatter(origin: DVec3, way: DVec3, medium: (f64, f64, f64)) -> f64 {
    let length = -origin.y / way.y;
    let up = flat_water_inscatter(origin, way, length, medium);
    let (met, down) = (origin + length * way, DVec3::new(way.x, -way.y, way.z));
    let to = |plane: f64, axis: usize| (plane - met[axis]) / down[axis];
    let rest = to(5f64.copysign(down.x), 0).min(to(5f64.copysign(down.z), 2)).min(to(-2.0, 1));
    let reflected = flat_water_inscatter(met, down, rest, medium);
    up + reflectance_from_below(way.y) * (-(medium.0 + medium.1) * length).exp() * reflected
}

/// Energy ratio and relative RMSE of a picture of [`turbid_flat_pool`] through camera `under`, over a part of the pixels.
pub fn against_flat_water(found: &[[f32; 3]], size: (u32, u32), asymmetry: f64, part: FlatPart) -> (f64, f64) {
    let medium = (0.02, 0.08, asymmetry);
    let (width, height) = (f64::from(size.0), f64::from(size.1));
    let (mut sum, mut expected_sum, mut squares, mut count) = (0.0, 0.0, 0.0, 0);
    for (index, value) in found.iter().enumerate() {
        let (column, row) = ((index as u32 % size.0) as f64, (index as u32 / size.0) as f64);
        let walls = first_water_stretch(column, row, width, height);
        let expected = match (walls, part) {
            (Some((origin, way, length)), FlatPart::Walls) => flat_water_inscatter(origin, way, length, medium),
            (None, FlatPart::Surface) => {
                let way = under_direction(column, row, width, height).normalize();
                flat_surface_inscatter(DVec3::new(0.0, -0.6, 3.5), way, medium)
            }
            _ => continue,
        };
        let value = f64::from(value[1]);
        sum += value;
        expected_sum += expected;
        squares += (value - expected).powi(2);
        count += 1;
    }
    let mean = expected_sum / f64::from(count);
    (sum / expected_sum, (squares / f64::from(count)).sqrt() / mean)
}
