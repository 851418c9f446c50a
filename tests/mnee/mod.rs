//! Asks the technique about points of one's own choosing, and holds its answers against the oracle.
#![allow(dead_code, reason = "each test binary uses its part")]

use glam::{Affine3A, DVec3, Vec3};
use nephroid::frame::{Frame, Sampling, VisiblePoint};
use nephroid::gpu::{Binding, Buffer, Recorder};
use nephroid::gpu_scene::GpuScene;
use nephroid::scene::{
    Camera, Emitter, FilmSettings, Instance, Light, Material, Medium, Mesh, Scene, Surface, ToneCurve,
};
use nephroid::technique::{self, Context, CounterEntry, Settings, TechniqueKind};
use nephroid::trace::{self, TraceChoice};
use nephroid::view::{Band, View};

use crate::common::{Request, assert_valid};
use crate::oracle;

/// Indices of the two media.
pub const AIR: usize = 0;
pub const WATER: usize = 1;
pub const WATER_INDEX: f64 = 1.33;

/// Water with `waves` as its surface over a floor at `depth` that is `size` metres wide, all of it white.
pub fn pool(waves: Mesh, depth: f32, size: f32, lights: Vec<Light>) -> Scene {
    let medium = |name: &str, index| Medium {
        name: name.to_string(),
        index,
        absorption: Vec3::ZERO,
        scattering: Vec3::ZERO,
        asymmetry: 0.0,
        density: None,
    };
    let material = |name: &str, surface| Material { name: name.to_string(), surface };
    let floor = nephroid::scene::shapes::plane(
        "floor",
        DVec3::new(0.0, f64::from(-depth), 0.0),
        glam::DVec2::splat(size.into()),
        [1, 1],
    );
    let instance =
        |name: &str, mesh, material| Instance { name: name.to_string(), mesh, material, transform: Affine3A::IDENTITY };
    Scene {
        path: "test".into(),
        film: FilmSettings {
            width: 1,
            height: 1,
            samples: 1,
            exposure: 0.0,
            tone_curve: ToneCurve::Linear,
            background: Vec3::ZERO,
            volume_samples: 1,
        },
        cameras: vec![Camera {
            name: "any".to_string(),
            position: Vec3::new(0.0, -0.5 * depth, 0.0),
            target: Vec3::NEG_Y * depth,
            up: Vec3::Z,
            fov_y: 60.0,
            medium: WATER,
        }],
        meshes: vec![floor, waves],
        instances: vec![instance("floor", 0, 0), instance("water", 1, 1)],
        materials: vec![
            material("floor", Surface::Diffuse { albedo: Vec3::ONE, texture: None }),
            material("water", Surface::Dielectric { front: AIR, back: WATER }),
        ],
        textures: Vec::new(),
        densities: Vec::new(),
        media: vec![medium("air", 1.0), medium("water", WATER_INDEX as f32)],
        lights,
        animation: Default::default(),
        settings: Vec::new(),
        warnings: Vec::new(),
    }
}

pub fn lamp(position: Vec3) -> Light {
    Light { name: "lamp".to_string(), emitter: Emitter::Point { position, intensity: Vec3::ONE }, medium: AIR }
}

pub fn sun(direction: Vec3) -> Light {
    let direction = direction.normalize();
    Light { name: "sun".to_string(), emitter: Emitter::Directional { direction, irradiance: Vec3::ONE }, medium: AIR }
}

/// A point to be asked about: where, the normal there, and the medium that it is seen in.
#[derive(Debug, Clone, Copy)]
pub struct Receiver {
    pub position: Vec3,
    pub normal: Vec3,
    pub medium: usize,
}

/// What the technique says.
pub struct Answers {
    /// Of the receivers, W/m2, mean channel.
    pub irradiances: Vec<f32>,
    pub counters: Vec<CounterEntry>,
}

impl Answers {
    pub fn count(&self, name: &str) -> f64 {
        self.counters.iter().find(|entry| entry.name == name).unwrap().value
    }
}

/// Irradiance at each receiver by the technique `mnee` with `set`, as in `--set`.
pub fn ask(request: &Request, scene: &Scene, receivers: &[Receiver], trace: &str, set: &[&str]) -> Answers {
    let device = request.open();
    let gpu_scene = GpuScene::new(&device, scene).unwrap();
    let choice: TraceChoice = trace.parse().unwrap();
    let (tracer, _) = trace::choose(&device, scene, &gpu_scene, choice).unwrap();
    let width = 256.min(receivers.len() as u32);
    let rows = (receivers.len() as u32).div_ceil(width);
    let band = Band { first: 0, count: rows };
    let view =
        View { lights: scene.lights.len() as u32, ..View::new(&scene.cameras[0], &scene.film, (width, rows), band) };
    let frame = Frame::new(&device, &gpu_scene, &tracer, &view, Sampling::Uniform).unwrap();
    let context = Context { device: &device, scene, tracer: &tracer, frame: &frame, seed: 0 };
    let set: Vec<String> = set.iter().map(|item| item.to_string()).collect();
    let settings = Settings::parse(TechniqueKind::Mnee, &set).unwrap();
    let mut technique = technique::create(TechniqueKind::Mnee, &settings, &context).unwrap().unwrap();
    let mut points = vec![nowhere(); frame.slots() as usize];
    for (point, receiver) in points.iter_mut().zip(receivers) {
        *point = VisiblePoint {
            position: receiver.position.to_array(),
            instance: 0,
            normal: pack(receiver.normal),
            geometric: pack(receiver.normal),
            medium: receiver.medium as u32,
            ..nowhere()
        };
    }
    buffer(&frame, "VisiblePoints").upload(bytemuck::cast_slice(&points)).unwrap();
    let mut recorder = Recorder::new(&device).unwrap();
    technique.record(&frame, &mut recorder, 0).unwrap();
    recorder.submit().unwrap();
    let values: Vec<[f32; 4]> = buffer(&frame, "SampleIrradiance").read(receivers.len()).unwrap();
    let counters = technique.counters().unwrap();
    assert_valid(&device);
    Answers { irradiances: values.iter().map(|v| (v[0] + v[1] + v[2]) / 3.0).collect(), counters }
}

fn buffer(frame: &Frame, name: &str) -> Buffer {
    match frame.bindings.get(name) {
        Some(Binding::Buffer(buffer)) => buffer.clone(),
        _ => panic!("no buffer {name}"),
    }
}

fn nowhere() -> VisiblePoint {
    VisiblePoint { position: [0.0; 3], instance: u32::MAX, normal: 0, geometric: 0, footprint: 0.0, medium: 0 }
}

/// As `pack_direction` in `kernels/shared/math.glsl`.
fn pack(n: Vec3) -> u32 {
    let mut p = n.truncate() / n.abs().element_sum();
    if n.z < 0.0 {
        p = (glam::Vec2::ONE - glam::Vec2::new(p.y, p.x).abs())
            * glam::Vec2::new(if p.x < 0.0 { -1.0 } else { 1.0 }, if p.y < 0.0 { -1.0 } else { 1.0 });
    }
    let snorm = |x: f32| (x.clamp(-1.0, 1.0) * 32767.0).round() as i16 as u16 as u32;
    snorm(p.x) | snorm(p.y) << 16
}

/// What the oracle says about one receiver: the irradiance of each path that nothing of the water blocks, W/m2.
pub fn oracle_irradiances(water: &oracle::Surface, receiver: &Receiver, light: &Light, absorption: f64) -> Vec<f64> {
    let from = match light.emitter {
        Emitter::Directional { direction, .. } => oracle::Light::Directional(direction.as_dvec3().normalize()),
        Emitter::Point { position, .. } | Emitter::Spot { position, .. } => oracle::Light::Point(position.as_dvec3()),
    };
    let index = |medium| if medium == WATER { f64::from(WATER_INDEX as f32) } else { 1.0 };
    let query = oracle::Query {
        point: receiver.position.as_dvec3(),
        point_index: index(receiver.medium),
        light: from,
        light_index: index(light.medium),
    };
    let irradiance = |path: &oracle::Path| {
        let cosine = -path.to_point.dot(receiver.normal.as_dvec3());
        let end = path.point + path.to_light * if path.light_leg.is_finite() { path.light_leg } else { BEYOND };
        let free = water.crossings(path.point, end, path.triangle) == 0
            && water.crossings(query.point, path.point, path.triangle) == 0;
        let in_water = if receiver.medium == WATER { path.point_leg } else { path.light_leg };
        let right_way = path.light_in_front == (light.medium == AIR);
        let carried = path.transmittance * cosine / path.r * (-absorption * in_water).exp();
        (free && right_way && cosine > 0.0).then_some(carried)
    };
    oracle::all_paths(water, &query).iter().filter_map(irradiance).collect()
}

/// Metres: past every surface of the tests.
const BEYOND: f64 = 1e3;
