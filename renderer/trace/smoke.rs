//! A few rays at one triangle by ray query, before anything relies on them: some drivers claim what they cannot do.

use glam::{Affine3A, Vec2, Vec3};

use super::{Backend, NO_INSTANCE, Probe, ProbeHit, Ray, TraceError, Tracer};
use crate::gpu::Device;
use crate::gpu_scene::{GpuScene, MASK_DIFFUSE, MASK_SPECULAR};
use crate::scene::{FilmSettings, Instance, Material, Mesh, Scene, Surface, ToneCurve};

/// A driver's t and barycentrics may be off by some roundings.
const TOLERANCE: f32 = 1e-5;

/// Traces a few rays at one triangle by ray query; the error says what went wrong.
pub(crate) fn smoke_test(device: &Device) -> Result<(), String> {
    let rays = [ray([0.25, 0.5, 3.0], 10.0), ray([2.0, 0.5, 3.0], 10.0), ray([0.25, 0.5, 3.0], 2.5)];
    let (seen, masked) = trace(device, &rays).map_err(|e| e.to_string())?;
    match seen.as_slice() {
        [hit, past, short] => {
            if hit.instance != 1 || hit.primitive != 1 {
                return Err(format!("a ray hit instance {} and triangle {}", hit.instance, hit.primitive));
            }
            // The triangle (0, 0), (1, 0), (0, 1) lies in the plane z = 0.
            let found = [hit.t, hit.barycentrics[0], hit.barycentrics[1]];
            if found.iter().zip([3.0, 0.25, 0.5]).any(|(a, b)| (a - b).abs() > TOLERANCE) {
                return Err(format!("a ray's t and barycentrics came out as {found:?} instead of [3.0, 0.25, 0.5]"));
            }
            if past.instance != NO_INSTANCE || short.instance != NO_INSTANCE {
                return Err("a ray hit what is not there".to_string());
            }
        }
        _ => return Err("hits are missing".to_string()),
    }
    if masked.iter().any(|hit| hit.instance != NO_INSTANCE) {
        return Err("the instance mask was ignored".to_string());
    }
    Ok(())
}

/// Hits of the instance's own mask, and of the other.
fn trace(device: &Device, rays: &[Ray]) -> Result<(Vec<ProbeHit>, Vec<ProbeHit>), TraceError> {
    let scene = scene();
    let gpu_scene = GpuScene::new(device, &scene)?;
    let tracer = Tracer::new(device, &scene, &gpu_scene, Backend::RayQuery)?;
    let probe = Probe::new(device, &tracer, rays)?;
    probe.run(&tracer, &gpu_scene, MASK_DIFFUSE, false)?;
    let seen = probe.hits()?;
    probe.run(&tracer, &gpu_scene, MASK_SPECULAR, false)?;
    Ok((seen, probe.hits()?))
}

fn ray(origin: [f32; 3], t_max: f32) -> Ray {
    Ray { origin, t_min: 0.0, direction: [0.0, 0.0, -1.0], t_max }
}

/// Two triangles side by side, twice: far off, and around the origin.
fn scene() -> Scene {
    let positions = vec![
        Vec3::new(10.0, 0.0, 0.0),
        Vec3::new(11.0, 0.0, 0.0),
        Vec3::new(10.0, 1.0, 0.0),
        Vec3::ZERO,
        Vec3::X,
        Vec3::Y,
    ];
    let mesh = Mesh {
        name: "triangles".to_string(),
        normals: vec![Vec3::Z; positions.len()],
        uvs: vec![Vec2::ZERO; positions.len()],
        positions,
        triangles: vec![[0, 1, 2], [3, 4, 5]],
    };
    let instance = |offset: Vec3| Instance {
        name: "triangles".to_string(),
        mesh: 0,
        material: 0,
        transform: Affine3A::from_translation(offset),
    };
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
        meshes: vec![mesh],
        instances: vec![instance(Vec3::new(0.0, 50.0, 0.0)), instance(Vec3::ZERO)],
        materials: vec![Material {
            name: "triangles".to_string(),
            surface: Surface::Diffuse { albedo: Vec3::ONE, texture: None },
        }],
        textures: Vec::new(),
        densities: Vec::new(),
        media: Vec::new(),
        lights: Vec::new(),
        animation: Default::default(),
        settings: Vec::new(),
        warnings: Vec::new(),
    }
}
