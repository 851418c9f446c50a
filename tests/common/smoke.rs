//! A box of smoke under a pane of glass, and what it scatters, by quadrature.

use std::f64::consts::PI;
use std::path::Path;

use glam::DVec3;
use nephroid::scene::{self, Bounds, DensityGrid, Scene};

use super::text;

/// From the side; the smoke's medium is all around the pane, but has density in a box only.
const CAMERA: &str = "position = [0, 0.4, 4]\ntarget = [0, 0.45, 0]\nfov_y = 16";
const SMOKE: &str = r#"
[[medium]]
name = "smoke"
index = 1
absorption = [0.5, 0.1, 0]
scattering = [0.5, 1, 2]
asymmetry = 0.5
"#;

/// Of all rows, the part in whose pixels the pane is seen: it begins 0.95 m up, 3 m away and more.
const PANE_PART: usize = 6;

/// Where the smoke is, and its density at 5 x 5 x 5 points: none on the box's faces, so that it begins without a step.
const SMOKE_LOWER: DVec3 = DVec3::new(-0.8, 0.1, -0.6);
const SMOKE_UPPER: DVec3 = DVec3::new(0.8, 0.9, 0.6);

fn smoke_value(x: usize, y: usize, z: usize) -> f64 {
    let inside = [x, y, z].iter().all(|&i| (1..4).contains(&i));
    if inside { [3.0, 0.5, 1.0, 2.0, 0.0][(x + 2 * y + 3 * z) % 5] } else { 0.0 }
}

fn smoke_density(at: DVec3) -> f64 {
    let place = (at - SMOKE_LOWER) / (SMOKE_UPPER - SMOKE_LOWER) * 4.0;
    if place.min_element() < 0.0 || place.max_element() > 4.0 {
        return 0.0;
    }
    let low = place.floor().min(DVec3::splat(3.0));
    let part = place - low;
    let corner = |dx: usize, dy: usize, dz: usize| {
        let weight = |d: usize, p: f64| if d == 1 { p } else { 1.0 - p };
        weight(dx, part.x)
            * weight(dy, part.y)
            * weight(dz, part.z)
            * smoke_value(low.x as usize + dx, low.y as usize + dy, low.z as usize + dz)
    };
    (0..8).map(|i| corner(i & 1, (i >> 1) & 1, i >> 2)).sum()
}

/// Radiance of the smoke along a ray, by the midpoint rule: what comes straight down is scattered once.
fn smoke_radiance(origin: DVec3, direction: DVec3, sun: f64, (absorption, scattering, g): (f64, f64, f64)) -> f64 {
    let extinction = absorption + scattering;
    let cosine = -DVec3::NEG_Y.dot(direction);
    let phase = (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cosine).powf(1.5));
    // The smoke is 3.4 to 4.6 m ahead; steps of 1 cm are exact to some 1e-4.
    let (first, step, steps) = (3.2, 0.01, 160);
    let (mut sum, mut depth) = (0.0, 0.0);
    for i in 0..steps {
        let at = origin + (first + (f64::from(i) + 0.5) * step) * direction;
        let density = smoke_density(at);
        if density == 0.0 {
            continue;
        }
        let above = (SMOKE_UPPER.y - at.y) / 60.0;
        let column = |j: i32| smoke_density(at + DVec3::Y * above * (f64::from(j) + 0.5));
        let over: f64 = (0..60).map(column).sum::<f64>() * above;
        let seen = depth + 0.5 * density * step;
        sum += scattering * density * phase * sun * (-extinction * (over + seen)).exp() * step;
        depth += density * step;
    }
    sum
}

/// The scene, smoke included.
pub fn pane() -> Scene {
    let mut scene = scene::parse(&text::pane(CAMERA, "smoke", SMOKE), Path::new("test.toml")).unwrap();
    let indices = || (0..125).map(|i| (i % 5, i / 5 % 5, i / 25));
    scene.densities.push(DensityGrid {
        bounds: Bounds { min: SMOKE_LOWER.as_vec3(), max: SMOKE_UPPER.as_vec3() },
        points: [5; 3],
        values: indices().map(|(x, y, z)| smoke_value(x, y, z) as f32).collect(),
    });
    scene.media.iter_mut().find(|m| m.name == "smoke").unwrap().density = Some(0);
    scene
}

/// Energy ratio and relative RMSE of a picture of [`pane`], a channel; `through`: what of the sun's light the pane lets
/// through.
pub fn against_pane(found: &[[f32; 3]], (width, height): (u32, u32), through: f64) -> [(f64, f64); 3] {
    let (width, height) = (width as usize, height as usize);
    let (origin, target) = (DVec3::new(0.0, 0.4, 4.0), DVec3::new(0.0, 0.45, 0.0));
    let forward = (target - origin).normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let up = right.cross(forward);
    let half = 8f64.to_radians().tan();
    let channel = |c: usize, sun: f64, medium: (f64, f64, f64)| {
        let (mut sum, mut expected_sum, mut squares) = (0.0, 0.0, 0.0);
        // Rows above see the smoke in the pane too.
        let below = height / PANE_PART * width..found.len();
        for index in below.clone() {
            let (row, column) = ((index / width) as f64, (index % width) as f64);
            // A pixel is small where a cell of the grid is 20 cm: four places stand for it.
            let places = [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)].map(|(x, y)| {
                let across = 2.0 * (column + x) / width as f64 - 1.0;
                let along = 1.0 - 2.0 * (row + y) / height as f64;
                let way = forward + right * half * across * (width as f64 / height as f64) + up * half * along;
                smoke_radiance(origin, way.normalize(), sun * through, medium)
            });
            let expected = places.iter().sum::<f64>() / 4.0;
            let value = f64::from(found[index][c]);
            sum += value;
            expected_sum += expected;
            squares += (value - expected).powi(2);
        }
        let count = below.len() as f64;
        (sum / expected_sum, (squares / count).sqrt() / (expected_sum / count))
    };
    [channel(0, 1.0, (0.5, 0.5, 0.5)), channel(1, 2.0, (0.1, 1.0, 0.5)), channel(2, 3.0, (0.0, 2.0, 0.5))]
}
