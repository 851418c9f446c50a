//! Scenes, random numbers and rays for cases and tests of tracing, and an oracle in f64 that tries every triangle.

use glam::{Affine3A, DAffine3, DVec2, DVec3, Vec3};

use crate::gpu_scene::{MASK_DIFFUSE, MASK_SPECULAR};
use crate::scene::height_field::{HeightField, Wave};
use crate::scene::{FilmSettings, Instance, Material, Mesh, Scene, Surface, ToneCurve};
use crate::trace::{NO_INSTANCE, ProbeHit, Ray};

/// Instances of every kind.
pub const ANY_MASK: u32 = 0xff;

/// Repeatable numbers: the generator splitmix64.
pub struct Random(pub u64);

impl Random {
    /// Any 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1u32 << 24) as f32
    }

    /// In [0, `end`).
    pub fn below(&mut self, end: usize) -> usize {
        (self.bits() % end as u64) as usize
    }

    /// In [-1, 1]^3.
    pub fn cube(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    /// Of length 1; not evenly spread.
    pub fn direction(&mut self) -> Vec3 {
        self.cube().normalize_or(Vec3::X)
    }
}

/// A mesh whose normals are of no interest.
pub fn mesh(name: &str, positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    let count = positions.len();
    Mesh {
        name: name.to_string(),
        positions,
        normals: vec![Vec3::Y; count],
        uvs: vec![Default::default(); count],
        triangles,
    }
}

/// Triangles of all sizes in [-1, 1]^3.
pub fn soup(random: &mut Random, triangles: u32) -> Mesh {
    let mut positions = Vec::new();
    for _ in 0..triangles {
        let (centre, size) = (random.cube(), random.unit() * random.unit());
        positions.extend([0; 3].map(|_| centre + size * random.cube()));
    }
    mesh("soup", positions, (0..triangles).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

/// Waves over 12 m x 12 m.
pub fn water(quads: u32, phase: f64) -> Mesh {
    let waves = [(0.6, 0.02, 0.84), (0.95, 0.03, 3.01), (1.9, 0.05, 0.7), (3.0, 0.08, 1.89)]
        .map(|(wavelength, amplitude, direction)| Wave { wavelength, amplitude, direction, phase });
    HeightField {
        x: [-6.0, 6.0],
        z: [-6.0, 6.0],
        quads: [quads, quads],
        base: 0.0,
        waves: waves.to_vec(),
        bumps: Vec::new(),
        relief: None,
    }
    .mesh("water")
}

/// Instances of meshes; every second one is specular.
pub fn scene(meshes: Vec<Mesh>, instances: &[(usize, Affine3A)]) -> Scene {
    let material = |name: &str, surface| Material { name: name.to_string(), surface };
    Scene {
        path: Default::default(),
        film: FilmSettings {
            width: 1,
            height: 1,
            samples: 1,
            exposure: 0.0,
            tone_curve: ToneCurve::Linear,
            background: Vec3::ZERO,
            volume_samples: 1,
        },
        cameras: Vec::new(),
        meshes,
        instances: instances
            .iter()
            .enumerate()
            .map(|(i, &(mesh, transform))| Instance { name: format!("{i}"), mesh, material: i % 2, transform })
            .collect(),
        materials: vec![
            material("diffuse", Surface::Diffuse { albedo: Vec3::ONE, texture: None }),
            material("mirror", Surface::Mirror { reflectance: Vec3::ONE }),
        ],
        textures: Vec::new(),
        densities: Vec::new(),
        media: Vec::new(),
        lights: Vec::new(),
        animation: Default::default(),
        settings: Vec::new(),
        warnings: Vec::new(),
    }
}

/// A ray without an end.
pub fn ray(origin: Vec3, direction: Vec3) -> Ray {
    Ray { origin: origin.to_array(), t_min: 0.0, direction: direction.to_array(), t_max: f32::INFINITY }
}

/// Rays at the box `low` to `high` from all around and from inside, of all lengths.
pub fn random_rays(random: &mut Random, count: usize, centre: Vec3, radius: f32) -> Vec<Ray> {
    (0..count)
        .map(|_| {
            let origin = centre + radius * 2.0 * random.unit() * random.direction();
            let target = centre + 0.7 * radius * random.cube();
            let length = (8.0 * random.unit() - 4.0).exp2();
            ray(origin, (target - origin).normalize_or(Vec3::Y) * length)
        })
        .collect()
}

/// A triangle that a ray meets.
#[derive(Debug, Clone, Copy)]
pub struct Meeting {
    pub t: f64,
    pub barycentrics: DVec2,
    /// The least of the three weights: below zero outside of the triangle.
    pub inside: f64,
}

/// The scene's triangles in world space and f64.
pub struct Oracle {
    /// By instance and primitive.
    triangles: Vec<Vec<[DVec3; 3]>>,
    masks: Vec<u32>,
}

impl Oracle {
    /// The triangles of `scene`, moved by the instances' own transforms.
    pub fn new(scene: &Scene) -> Self {
        let world = |instance: &Instance| {
            let mesh = &scene.meshes[instance.mesh];
            let transform = DAffine3 {
                matrix3: glam::Mat3::from(instance.transform.matrix3).as_dmat3(),
                translation: instance.transform.translation.as_dvec3(),
            };
            let corner = |i: u32| transform.transform_point3(mesh.positions[i as usize].as_dvec3());
            mesh.triangles.iter().map(|t| t.map(corner)).collect()
        };
        let mask = |instance: &Instance| match scene.materials[instance.material].surface.is_specular() {
            true => MASK_SPECULAR,
            false => MASK_DIFFUSE,
        };
        Oracle {
            triangles: scene.instances.iter().map(world).collect(),
            masks: scene.instances.iter().map(mask).collect(),
        }
    }

    /// Where the ray meets the triangle's plane; `None` if it is parallel to it.
    pub fn meet(&self, ray: &Ray, instance: u32, primitive: u32) -> Option<Meeting> {
        let [a, b, c] = self.triangles[instance as usize][primitive as usize];
        let (origin, direction) = (Vec3::from(ray.origin).as_dvec3(), Vec3::from(ray.direction).as_dvec3());
        let normal = (b - a).cross(c - a);
        let slope = normal.dot(direction);
        if slope.abs() <= 1e-12 * normal.length() * direction.length() {
            return None;
        }
        let t = normal.dot(a - origin) / slope;
        let point = origin + t * direction;
        let area = normal.length_squared();
        let beta = (point - a).cross(c - a).dot(normal) / area;
        let gamma = (b - a).cross(point - a).dot(normal) / area;
        Some(Meeting { t, barycentrics: DVec2::new(beta, gamma), inside: beta.min(gamma).min(1.0 - beta - gamma) })
    }

    /// The closest hit among instances of the mask, by brute force.
    pub fn closest(&self, ray: &Ray, mask: u32) -> Option<(u32, u32, Meeting)> {
        let mut best: Option<(u32, u32, Meeting)> = None;
        for (instance, triangles) in self.triangles.iter().enumerate() {
            if self.masks[instance] & mask == 0 {
                continue;
            }
            for primitive in 0..triangles.len() {
                let (instance, primitive) = (instance as u32, primitive as u32);
                let Some(found) = self.meet(ray, instance, primitive) else { continue };
                let within = found.t > f64::from(ray.t_min) && found.t < f64::from(ray.t_max);
                if within && found.inside >= 0.0 && best.is_none_or(|(_, _, b)| found.t < b.t) {
                    best = Some((instance, primitive, found));
                }
            }
        }
        best
    }

    /// The mask of an instance.
    pub fn mask(&self, instance: u32) -> u32 {
        self.masks[instance as usize]
    }
}

/// Whether anything was hit.
pub fn is_hit(hit: &ProbeHit) -> bool {
    hit.instance != NO_INSTANCE
}
