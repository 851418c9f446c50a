//! A frame that beams made on the host light, and such beams.

use std::path::Path;

use glam::{DVec3, dvec3};
use nephroid::frame::{Frame, Sampling, VisiblePoint};
use nephroid::gpu::{Binding, Buffer, Device, Recorder};
use nephroid::gpu_scene::GpuScene;
use nephroid::light_view::{LightView, LightViewTier, LightViews};
use nephroid::scene::{self, Scene};
use nephroid::technique::beams::accumulate::{Accumulator, BeamBuffers, Options};
use nephroid::technique::beams::beam::{Beam, BeamHeader};
use nephroid::technique::beams::generate::Generator;
use nephroid::technique::{Context, Settings, TechniqueKind};
use nephroid::trace::{self, TraceChoice, Tracer};
use nephroid::view::{Band, View};

use super::{Edge, Numbers, beam, beam_to_floor};
use crate::common::{Request, assert_valid};

/// Lit by nothing but beams: a floor at y = 0 seen from above.
pub use crate::common::text::FLOOR;

pub fn parse(text: &str) -> Scene {
    scene::parse(text, Path::new("test.toml")).unwrap()
}

/// The floor in a medium of its own, number 1.
pub fn in_smoke(coefficients: &str) -> String {
    let camera = FLOOR.replace("fov_y = 60", "fov_y = 60\nmedium = \"smoke\"");
    format!("[[medium]]\nname = \"smoke\"\nindex = 1\n{coefficients}\n{camera}")
}

/// A frame and all it stands on.
pub struct Stage {
    pub device: Device,
    scene: Scene,
    tracer: Tracer,
    pub frame: Frame,
}

impl Stage {
    pub fn new(request: &Request, scene: Scene, size: (u32, u32), sampling: Sampling) -> Self {
        Self::on(request.open(), scene, size, sampling)
    }

    pub fn on(device: Device, scene: Scene, size: (u32, u32), sampling: Sampling) -> Self {
        Self::with(device, scene, size, Band { first: 0, count: size.1 }, sampling)
    }

    /// Of some rows of a picture of `size`.
    pub fn of_band(request: &Request, scene: Scene, size: (u32, u32), band: Band) -> Self {
        Self::with(request.open(), scene, size, band, Sampling::Uniform)
    }

    fn with(device: Device, scene: Scene, size: (u32, u32), band: Band, sampling: Sampling) -> Self {
        let gpu_scene = GpuScene::new(&device, &scene).unwrap();
        let (tracer, _) = trace::choose(&device, &scene, &gpu_scene, TraceChoice::Bvh).unwrap();
        let view = View::new(&scene.cameras[0], &scene.film, size, band).of(&scene);
        let frame = Frame::new(&device, &gpu_scene, &tracer, &view, sampling).unwrap();
        Stage { device, scene, tracer, frame }
    }

    /// With room for some more beams than there are.
    pub fn accumulator(&self, beams: &[Beam], options: Options) -> Accumulator {
        let mut stored = beams.to_vec();
        stored.resize(beams.len() + 77, bytemuck::Zeroable::zeroed());
        let header = BeamHeader { count: beams.len() as u32, padding0: 0, padding1: 0, padding2: 0 };
        let buffers = BeamBuffers {
            beams: Buffer::from_slice(&self.device, "beams", &stored).unwrap(),
            header: Buffer::from_slice(&self.device, "beam header", &[header]).unwrap(),
            capacity: stored.len() as u32,
        };
        let Stage { device, scene, tracer, frame } = self;
        Accumulator::with_options(options, &Context { device, scene, tracer, frame, seed: 0 }, &buffers).unwrap()
    }

    /// The scene's light views, and a generator that has made the first set of beams.
    pub fn generate(&self, set: &[&str]) -> (Vec<LightView>, Generator) {
        let items: Vec<String> = set.iter().map(|item| item.to_string()).collect();
        let settings = Settings::parse(TechniqueKind::Beams, &items).unwrap();
        let Stage { device, scene, tracer, frame } = self;
        let views = LightViews::new(device, scene, tracer, 2, LightViewTier::Rays).unwrap();
        let context = Context { device, scene, tracer, frame, seed: 0 };
        let generator = Generator::new(&settings, &context, &views).unwrap();
        let mut recorder = Recorder::new(device).unwrap();
        generator.record(frame, &mut recorder, 0).unwrap();
        recorder.submit().unwrap();
        assert_valid(device);
        (views.views().to_vec(), generator)
    }

    /// Each slot's point and its irradiance, in sample `index`.
    pub fn sample(&mut self, accumulator: &Accumulator, index: u32) -> Vec<(VisiblePoint, [f32; 4])> {
        let mut recorder = Recorder::new(&self.device).unwrap();
        self.frame.record(&mut recorder, index).unwrap();
        accumulator.record(&self.frame, &mut recorder, true).unwrap();
        recorder.submit().unwrap();
        let points: Vec<VisiblePoint> = self.read("VisiblePoints", 1);
        let found: Vec<[f32; 4]> = self.read("SampleIrradiance", 1);
        assert_valid(&self.device);
        points.into_iter().zip(found).filter(|(point, _)| point.instance != u32::MAX).collect()
    }

    /// What the frame has so many of a slot under that name.
    pub fn read<T: bytemuck::Pod>(&self, block: &str, each: usize) -> Vec<T> {
        let Some(Binding::Buffer(buffer)) = self.frame.bindings.get(block) else { panic!("no buffer {block}") };
        buffer.read(each * self.frame.slots() as usize).unwrap()
    }
}

/// Of the visible point.
pub fn position(point: &VisiblePoint) -> DVec3 {
    DVec3::from_array(point.position.map(f64::from))
}

pub fn counter(accumulator: &Accumulator, name: &str) -> f64 {
    accumulator.counters().unwrap().iter().find(|entry| entry.name == name).unwrap().value
}

/// Small beams of `many_beams`, which come after seven large ones.
pub const CROWD: usize = 1000;

/// Beams of every kind to the floor: parallel, spread out, through a focus on a line or a point, twisted, grazing, and a
/// crowd of small ones.
pub fn many_beams() -> Vec<Beam> {
    let triangle = |size: f64, height: f64| {
        [dvec3(-1.0, 0.0, -1.0), dvec3(1.2, 0.0, -0.8), dvec3(0.1, 0.0, 1.1)]
            .map(|p| p * size + dvec3(0.0, height, 0.0))
    };
    let high = triangle(0.8, 2.0);
    let towards = |points: [DVec3; 3], focus: DVec3| points.map(|p| focus - p);
    let down = DVec3::NEG_Y;
    let mut all = vec![
        beam_to_floor(high, [down, down, down], 1.0, 0.0),
        beam_to_floor(high, high.map(|p| p - dvec3(0.0, 5.0, 0.0)), 2.0, 0.0),
        beam_to_floor(high, towards(high, dvec3(0.0, -2.0, 0.0)), 3.0, 0.0),
        // Through a point, and on to the floor with its corners changed over.
        beam_to_floor(high, towards(high, dvec3(0.2, 1.2, 0.0)), 4.0, 0.0),
        // Through a line.
        beam_to_floor(high, high.map(|p| dvec3(-p.x, -1.0, 0.3)), 5.0, 0.0),
        beam_to_floor(high, high.map(|p| dvec3(0.3 * p.z, -1.0, -0.3 * p.x)), 6.0, 0.0),
        // 80 degrees from the vertical.
        beam_to_floor(triangle(0.3, 0.4), [dvec3(1.0, -0.176, 0.0); 3], 7.0, 0.0),
    ];
    let mut numbers = Numbers(1);
    for _ in 0..CROWD {
        let at = dvec3(numbers.between(-2.5, 2.5), 0.0, numbers.between(-2.0, 2.0));
        let turn = numbers.between(0.0, 6.0);
        let mut corner = |index: u32| {
            let angle = turn + f64::from(index) * 2.1;
            let round = numbers.between(0.08, 0.12) * dvec3(angle.cos(), 0.0, angle.sin());
            let start = at + round + DVec3::Y * numbers.between(1.48, 1.52);
            let way = dvec3(numbers.between(-0.02, 0.02), -1.0, numbers.between(-0.02, 0.02)).normalize();
            // About what the beam's own area is.
            let area = [0.013 * numbers.between(0.8, 1.3), 0.002 * numbers.between(-1.0, 1.0), 0.0];
            Edge { area, flux: 0.01 * numbers.between(0.7, 1.5), ..Edge::plain(start, way, -start.y / way.y) }
        };
        all.push(beam([corner(0), corner(1), corner(2)], 0.01, 0));
    }
    all
}
