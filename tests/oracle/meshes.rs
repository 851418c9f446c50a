//! Repeatable random surfaces, and questions about them.
//!
//! Everything is rounded to f32 before it is handed out, so that a device gets exactly what the oracle was asked.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use nephroid::scene::Mesh;
use nephroid::scene::height_field::{HeightField, Wave};
use nephroid::scene::shapes::{self, Vertex, grid};

use super::spread::refract;
use super::{Light, Query, Surface};

pub const AIR: f64 = 1.0;
pub const WATER: f64 = 1.33;
const WAVES: usize = 8;

/// Repeatable numbers: the generator splitmix64.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub fn below(&mut self, end: usize) -> usize {
        (self.unit() * end as f64) as usize
    }

    /// Uniform on the sphere.
    pub fn direction(&mut self) -> DVec3 {
        let y = self.between(-1.0, 1.0);
        let (sin, cos) = (TAU * self.unit()).sin_cos();
        let radius = (1.0 - y * y).sqrt();
        DVec3::new(radius * cos, y, radius * sin)
    }

    /// Uniform over a triangle, barycentrics.
    pub fn barycentrics(&mut self) -> DVec2 {
        let root = self.unit().sqrt();
        let share = self.unit();
        DVec2::new(root * (1.0 - share), root * share)
    }
}

/// Waves around y = 0 over `size` x `size` metres around the origin; the steepest vertex has the slope `slope`.
pub fn height_field(seed: u64, quads: u32, size: f64, slope: f64) -> Mesh {
    let random = &mut Random::new(seed);
    let mut waves: Vec<Wave> = (0..WAVES)
        .map(|_| {
            let wavelength = size * 0.5 * 0.12f64.powf(random.unit());
            let [direction, phase] = [TAU * random.unit(), TAU * random.unit()];
            Wave { wavelength, amplitude: wavelength, direction, phase }
        })
        .collect();
    let sides = [-0.5 * size, 0.5 * size];
    let field = |waves: &[Wave]| HeightField {
        x: sides,
        z: sides,
        quads: [quads, quads],
        base: 0.0,
        waves: waves.to_vec(),
        bumps: Vec::new(),
        relief: None,
    };
    let first = field(&waves);
    let at = |i: u32| sides[0] + size * f64::from(i) / f64::from(quads);
    let slopes = (0..=quads).flat_map(|row| (0..=quads).map(move |column| (column, row)));
    let steepest = slopes.map(|(x, z)| first.slope(at(x), at(z)).length()).fold(0.0, f64::max);
    waves.iter_mut().for_each(|wave| wave.amplitude *= slope / steepest);
    field(&waves).mesh("random waves")
}

/// A quarter of a tube along z, two metres long and one in radius, waves on it; it faces outward and is no height field.
pub fn curved_patch(seed: u64, quads: u32, slope: f64) -> Mesh {
    let random = &mut Random::new(seed);
    let waves: Vec<(DVec2, f64)> = (0..WAVES)
        .map(|_| {
            let k = TAU / random.between(0.3, 1.5);
            (k * DVec2::from_angle(TAU * random.unit()), TAU * random.unit())
        })
        .collect();
    grid("waves on a tube", quads, quads, |column, row| {
        let part = DVec2::new(f64::from(column), f64::from(row)) / f64::from(quads);
        let at = DVec2::new(1.6, 2.0) * (part - 0.5);
        let (mut radius, mut change) = (1.0, DVec2::ZERO);
        for (k, phase) in &waves {
            let (sin, cos) = (k.dot(at) + phase).sin_cos();
            let slope = slope / WAVES as f64;
            radius += slope / k.length() * sin;
            change += slope * cos * k.normalize();
        }
        let (sin, cos) = at.x.sin_cos();
        let (outward, round) = (DVec3::new(sin, cos, 0.0), DVec3::new(cos, -sin, 0.0));
        let along_x = change.x * outward + radius * round;
        let along_z = change.y * outward + DVec3::Z;
        Vertex { position: radius * outward + at.y * DVec3::Z, normal: along_z.cross(along_x).normalize(), uv: part }
    })
}

/// A ball of radius 1.
pub fn sphere(segments: u32) -> Mesh {
    shapes::sphere("ball", DVec3::ZERO, 1.0, segments)
}

/// A ball with bumps, closed, with exact normals.
pub fn lumpy_sphere(seed: u64, segments: u32, slope: f64) -> Mesh {
    let random = &mut Random::new(seed);
    let waves: Vec<(DVec3, f64)> =
        (0..WAVES).map(|_| (random.between(3.0, 9.0) * random.direction(), TAU * random.unit())).collect();
    let mut mesh = sphere(segments);
    mesh.name = "lumpy ball".to_string();
    let Mesh { positions, normals, .. } = &mut mesh;
    for (position, normal) in positions.iter_mut().zip(normals) {
        let outward = position.as_dvec3().normalize();
        let (mut radius, mut change) = (1.0, DVec3::ZERO);
        for (k, phase) in &waves {
            let (sin, cos) = (k.dot(outward) + phase).sin_cos();
            let slope = slope / WAVES as f64;
            radius += slope / k.length() * sin;
            change += slope * cos * k.normalize();
        }
        let change = change - change.dot(outward) * outward;
        *position = (radius * outward).as_vec3();
        *normal = (radius * outward - change).normalize().as_vec3();
    }
    mesh
}

/// One triangle about a metre wide, facing upward, its corners' normals leaning off its own by up to `tilt` (tangent).
pub fn triangle(seed: u64, tilt: f64) -> Mesh {
    let random = &mut Random::new(seed);
    let turn = TAU * random.unit();
    let positions = [0.0, -1.0, -2.0].map(|third| {
        let (sin, cos) = (turn + TAU / 3.0 * third + random.between(-0.5, 0.5)).sin_cos();
        random.between(0.3, 0.8) * DVec3::new(cos, random.between(-0.2, 0.2), sin)
    });
    let [a, b, c] = positions;
    let front = (b - a).cross(c - a).normalize();
    let normals = [(); 3].map(|()| (front + tilt * random.unit() * random.direction()).normalize());
    Mesh {
        name: "triangle".to_string(),
        positions: positions.map(|p| p.as_vec3()).to_vec(),
        normals: normals.map(|n| n.as_vec3()).to_vec(),
        uvs: vec![Default::default(); 3],
        triangles: vec![[0, 1, 2]],
    }
}

/// A path that exists: a query, and the triangle and barycentrics where its light crosses.
pub struct Planted {
    pub query: Query,
    pub triangle: usize,
    pub barycentrics: DVec2,
}

/// A path through a random place of the surface.
pub fn planted(random: &mut Random, surface: &Surface) -> Planted {
    loop {
        let (triangle, barycentrics) = (random.below(surface.triangles.len()), random.barycentrics());
        if let Some(query) = planted_at(random, surface, triangle, barycentrics) {
            return Planted { query, triangle, barycentrics };
        }
    }
}

/// Water behind the surface, air in front, and a ray of light sent through a place. Every fourth ray comes in within six
/// degrees of the shading normal's horizon; every third light is directional. `None` where the face would have the ray
/// on other sides than the shading normal has it.
pub fn planted_at(random: &mut Random, surface: &Surface, triangle: usize, barycentrics: DVec2) -> Option<Query> {
    let [low, high] = surface.bounds();
    let size = (high - low).max_element();
    let patch = surface.patch(triangle);
    let crossing = patch.position(barycentrics);
    let normal = patch.normal(barycentrics).normalize();
    let side = normal.cross(random.direction()).normalize();
    let cosine = if random.below(4) == 0 { random.between(0.01, 0.1) } else { random.between(0.1, 1.0) };
    let to_light = cosine * normal + (1.0 - cosine * cosine).sqrt() * side;
    let to_point = refract(-to_light, normal, AIR / WATER)?;
    let point = crossing + size * 0.05 * 60f64.powf(random.unit()) * to_point;
    let light = match random.below(3) {
        0 => Light::Directional(-to_light),
        _ => Light::Point(crossing + size * 0.1 * 50f64.powf(random.unit()) * to_light),
    };
    let through = to_light.dot(patch.geometric) > 0.005 && to_point.dot(patch.geometric) < -0.005;
    through.then_some(Query { point, point_index: WATER, light, light_index: AIR })
}

/// Points in water behind the surface and lights in air before it, all f32: every second one has a path planted, in the
/// others both are put without regard to paths.
pub fn queries(seed: u64, surface: &Surface, count: usize) -> Vec<Query> {
    let random = &mut Random::new(seed);
    let query = |i| if i % 2 == 0 { planted(random, surface).query } else { unplanned(random, surface) };
    (0..count).map(query).map(rounded).collect()
}

/// A point behind a random place and a light in front of another, every fourth light low.
fn unplanned(random: &mut Random, surface: &Surface) -> Query {
    let [low, high] = surface.bounds();
    let size = (high - low).max_element();
    let mut place = || {
        let patch = surface.patch(random.below(surface.triangles.len()));
        let at = random.barycentrics();
        (patch.position(at), patch.geometric)
    };
    let ((behind, face), (before, front)) = (place(), place());
    let point = behind - size * 0.05 * 20f64.powf(random.unit()) * face;
    let height = if random.below(4) == 0 { random.between(0.05, 0.2) } else { random.between(0.2, 1.0) };
    let side = front.cross(random.direction()).normalize();
    let to_light = height * front + (1.0 - height * height).sqrt() * side;
    let light = match random.below(3) {
        0 => Light::Directional(-to_light),
        _ => Light::Point(before + size * 0.2 * 20f64.powf(random.unit()) * to_light),
    };
    Query { point, point_index: WATER, light, light_index: AIR }
}

/// A direction stays unit only to f32; the oracle takes it as normalised again.
fn rounded(query: Query) -> Query {
    let exact = |v: DVec3| v.as_vec3().as_dvec3();
    let light = match query.light {
        Light::Point(position) => Light::Point(exact(position)),
        Light::Directional(direction) => Light::Directional(exact(direction).normalize()),
    };
    Query { point: exact(query.point), light, ..query }
}
