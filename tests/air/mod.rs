//! A room of fog, and light that media scatter once by quadrature in f64.
#![allow(dead_code, reason = "each test binary uses its part")]

use std::path::Path;

use glam::DVec3;
use nephroid::random;
use nephroid::render::{Picture, RenderSettings};
use nephroid::scene::{self, Camera, DensityGrid, Emitter, Light, Medium, Scene};
use nephroid::technique::TechniqueKind;

use crate::common::Request;

/// Pixels.
pub const SIZE: (u32, u32) = (12, 9);

pub fn parse(text: &str) -> Scene {
    scene::parse(text, Path::new("test.toml")).unwrap()
}

/// A black wall across the view at z = -5.
pub const ROOM: &str = r#"
[film]
volume_samples = 256
[[camera]]
name = "c"
position = [0.3, 0.2, 5]
target = [0, 0, 0]
fov_y = 40
medium = "fog"
[[material]]
name = "wall"
kind = "diffuse"
albedo = 0
[[object]]
name = "wall"
shape = "plane"
centre = [0, 0, 0]
size = [100, 100]
material = "wall"
transform = { rotate = [90, 0, 0], translate = [0, 0, -5] }
"#;

pub fn fog(absorption: &str, scattering: &str, asymmetry: f64) -> String {
    format!(
        "[[medium]]\nname = \"fog\"\nindex = 1.0001\nabsorption = {absorption}\nscattering = {scattering}\nasymmetry = \
         {asymmetry}\n"
    )
}

/// One sample without a technique, whose places in the pixels are known.
pub fn render(request: &Request, scene: Scene, change: impl FnOnce(&mut RenderSettings)) -> Picture {
    request.render(scene, |settings| {
        settings.technique = TechniqueKind::None;
        settings.samples = Some(1);
        settings.size = Some(SIZE);
        change(settings);
    })
}

/// One in sight, one behind the camera.
pub const LAMPS: &str = r#"
[[light]]
name = "near"
kind = "point"
position = [0.8, 0.5, 1]
intensity = [3, 2, 1]
medium = "fog"
[[light]]
name = "behind"
kind = "point"
position = [-1, 1, 7]
intensity = [0, 5, 9]
medium = "fog"
"#;

/// Steps along a ray to the camera, without and with a grid: light varies over tenths of a metre on rays of some ten.
const STEPS: [u32; 2] = [4000, 1500];
/// Steps along a ray to a lamp, through a grid of some ten cells.
const STEPS_TO_LIGHT: u32 = 200;

/// What a ray runs through.
pub struct Air<'a> {
    pub medium: &'a Medium,
    pub grid: Option<&'a DensityGrid>,
}

impl<'a> Air<'a> {
    pub fn of(scene: &'a Scene, medium: usize) -> Self {
        let medium = &scene.media[medium];
        Air { medium, grid: medium.density.map(|grid| &scene.densities[grid]) }
    }

    pub fn density(&self, at: DVec3) -> f64 {
        let Some(grid) = self.grid else { return 1.0 };
        let (low, high) = (grid.bounds.min.as_dvec3(), grid.bounds.max.as_dvec3());
        let points = glam::UVec3::from(grid.points);
        let place = (at - low) / (high - low) * (points - 1).as_dvec3();
        if place.min_element() < 0.0 || (place - (points - 1).as_dvec3()).max_element() > 0.0 {
            return 0.0;
        }
        let cell = place.as_uvec3().min(points - 2);
        let part = place - cell.as_dvec3();
        let mut sum = 0.0;
        for corner in 0..8u32 {
            let step = glam::UVec3::new(corner & 1, corner >> 1 & 1, corner >> 2);
            let weight = DVec3::select(step.cmpeq(glam::UVec3::ONE), part, 1.0 - part);
            let [x, y, z] = (cell + step).to_array();
            let value = grid.values[((z * points.y + y) * points.x + x) as usize];
            sum += weight.element_product() * f64::from(value);
        }
        sum
    }

    /// Density over `length` metres of a ray, by the midpoint rule.
    pub fn depth(&self, from: DVec3, direction: DVec3, length: f64, steps: u32) -> f64 {
        if self.grid.is_none() {
            return length;
        }
        let step = length / f64::from(steps);
        (0..steps).map(|i| self.density(from + (f64::from(i) + 0.5) * step * direction) * step).sum()
    }

    fn extinction(&self, channel: usize) -> f64 {
        f64::from(self.medium.absorption[channel]) + f64::from(self.medium.scattering[channel])
    }

    pub fn left(&self, channel: usize, depth: f64) -> f64 {
        (-self.extinction(channel) * depth).exp()
    }

    /// Radiance that comes back along the ray from `light`, where `lit` says whether it reaches a point.
    pub fn light(
        &self,
        (from, direction, length): (DVec3, DVec3, f64),
        light: &Light,
        lit: impl Fn(DVec3) -> bool,
    ) -> [f64; 3] {
        let steps = STEPS[usize::from(self.grid.is_some())];
        let step = length / f64::from(steps);
        let mut depth = 0.0;
        let mut sum = [0.0; 3];
        for i in 0..steps {
            let point = from + (f64::from(i) + 0.5) * step * direction;
            let density = self.density(point);
            depth += 0.5 * density * step;
            let lamp = lamp(light, point);
            if density > 0.0 && lamp.irradiance.max_element() > 0.0 && lit(point) {
                let through = depth + self.depth(point, lamp.way, lamp.distance, STEPS_TO_LIGHT);
                let scattered = density * self.phase(lamp.way.dot(direction)) * step;
                for (channel, sum) in sum.iter_mut().enumerate() {
                    let scattering = f64::from(self.medium.scattering[channel]);
                    *sum += scattering * scattered * lamp.irradiance[channel] * self.left(channel, through);
                }
            }
            depth += 0.5 * density * step;
        }
        sum
    }

    /// Henyey and Greenstein's, 1/sr.
    fn phase(&self, cosine: f64) -> f64 {
        let g = f64::from(self.medium.asymmetry);
        (1.0 - g * g) / (4.0 * std::f64::consts::PI * (1.0 + g * g - 2.0 * g * cosine).powf(1.5))
    }
}

struct Lamp {
    way: DVec3,
    /// For directional lights as far as the grids of these tests reach.
    distance: f64,
    irradiance: DVec3,
}

fn lamp(light: &Light, point: DVec3) -> Lamp {
    let from = |position: glam::Vec3, intensity: glam::Vec3| {
        let way = position.as_dvec3() - point;
        let distance = way.length();
        Lamp { way: way / distance, distance, irradiance: intensity.as_dvec3() / (distance * distance) }
    };
    match light.emitter {
        Emitter::Point { position, intensity } => from(position, intensity),
        Emitter::Spot { position, direction, intensity, inner, outer, .. } => {
            let lamp = from(position, intensity);
            let cosine = -lamp.way.dot(direction.as_dvec3());
            let (inner, outer) = (f64::from(inner).cos(), f64::from(outer).cos());
            let x = ((cosine - outer) / (inner - outer)).clamp(0.0, 1.0);
            Lamp { irradiance: lamp.irradiance * (x * x * (3.0 - 2.0 * x)), ..lamp }
        }
        Emitter::Directional { direction, irradiance } => {
            Lamp { way: -direction.as_dvec3(), distance: 5.0, irradiance: irradiance.as_dvec3() }
        }
    }
}

/// Unit directions of the camera's rays, row by row, through the points of the pixels that the first sample of a render
/// with seed 0 has.
pub fn rays(camera: &Camera, (width, height): (u32, u32)) -> Vec<DVec3> {
    let [jitter_x, jitter_y] = random::sample_2d(0, 0).map(f64::from);
    let forward = (camera.target.as_dvec3() - camera.position.as_dvec3()).normalize();
    let right = forward.cross(camera.up.as_dvec3()).normalize();
    let up = right.cross(forward);
    let half = (f64::from(camera.fov_y).to_radians() * 0.5).tan();
    let aspect = f64::from(width) / f64::from(height);
    let ray = |pixel: u32| {
        let x = 2.0 * (f64::from(pixel % width) + jitter_x) / f64::from(width) - 1.0;
        let y = 1.0 - 2.0 * (f64::from(pixel / width) + jitter_y) / f64::from(height);
        (forward + right * half * aspect * x + up * half * y).normalize()
    };
    (0..width * height).map(ray).collect()
}
