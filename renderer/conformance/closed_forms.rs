//! What is known in closed form of the light in `scenes/flat_water.toml`.

use glam::DVec3;

/// Light of the lamp where flat water has refracted it once: 100 W/sr at (1.5, 6, -1), water below y = 0, index 1.33.
pub struct RefractedLight {
    /// The way that it goes.
    pub direction: DVec3,
    /// W/m2 across that direction, before the water takes some.
    pub fluence: f64,
    /// Metres in the water.
    pub in_water: f64,
}

/// What a ring of directions carries, over the ring it falls on, by Snell's law solved for the point.
pub fn refracted_light(at: DVec3) -> RefractedLight {
    let (intensity, height, depth, n) = (100.0, 6.0, -at.y, 1.33);
    let across = DVec3::new(at.x - 1.5, 0.0, at.z + 1.0);
    let r = across.length();
    let landing = |angle: f64| height * angle.tan() + depth * (angle.sin() / n).asin().tan();
    let (mut low, mut high) = (0.0, 1.5);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if landing(middle) < r { low = middle } else { high = middle }
    }
    let angle: f64 = 0.5 * (low + high);
    let (c1, s1) = (angle.cos(), angle.sin());
    let c2 = (1.0 - (s1 / n).powi(2)).sqrt();
    let perpendicular = ((c1 - n * c2) / (c1 + n * c2)).powi(2);
    let parallel = ((n * c1 - c2) / (n * c1 + c2)).powi(2);
    let transmitted = 1.0 - 0.5 * (perpendicular + parallel);
    let slope = height / (c1 * c1) + depth / (c2 * c2) * c1 / (n * c2);
    let ring = if r < 1e-9 { 1.0 / slope } else { s1 / r };
    RefractedLight {
        direction: across.normalize_or_zero() * (s1 / n) - DVec3::Y * c2,
        fluence: intensity * transmitted * ring / slope / c2,
        in_water: depth / c2,
    }
}

/// Irradiance on the floor of `flat_water.toml` at (x, z), W/m2, 2 m below the surface.
pub fn flat_water_irradiance(x: f64, z: f64) -> f64 {
    let light = refracted_light(DVec3::new(x, -2.0, z));
    -light.direction.y * light.fluence
}

/// The way along which camera `under` of the pools looks through a pixel of a film of that size, not normalised. Whole
/// numbers are pixel centres.
pub fn under_direction(column: f64, row: f64, width: f64, height: f64) -> DVec3 {
    let forward = DVec3::new(0.0, -1.4, -3.5).normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let up = right.cross(forward);
    let half = 30f64.to_radians().tan();
    forward
        + right * half * (width / height) * (2.0 * (column + 0.5) / width - 1.0)
        + up * half * (1.0 - 2.0 * (row + 0.5) / height)
}

/// Where the camera `under` of the pools looks through a pixel of a film of that size: x and z on the floor.
pub fn floor_point(column: f64, row: f64, width: f64, height: f64) -> Option<(f64, f64)> {
    let way = under_direction(column, row, width, height);
    let t = -1.4 / way.y;
    let (x, z) = (t * way.x, 3.5 + t * way.z);
    // Away from the walls, over whose edge the first radii reach, and near enough that a pixel is small on the floor.
    (way.y < 0.0 && x.abs() < 4.5 && z > -2.5).then_some((x, z))
}
