//! Light of given beams on surfaces, against f64 and closed forms.

mod beams;
mod common;

use std::path::Path;
use std::process::ExitCode;

use beams::{Edge, Numbers, beam, beam_to_floor, oracle};
use common::pool::flat_water_irradiance;
use common::{Case, Request, assert_valid};
use glam::{DVec3, dvec3};
use nephroid::frame::{Frame, Sampling, VisiblePoint};
use nephroid::gpu::{Binding, Buffer, Device, Recorder};
use nephroid::gpu_scene::GpuScene;
use nephroid::scene::{self, Scene};
use nephroid::technique::Context;
use nephroid::technique::beams::accumulate::{Accumulator, Area, BeamBuffers, Options, Shadows};
use nephroid::technique::beams::beam::{Beam, BeamHeader, EMPTY, STRADDLES};
use nephroid::trace::{self, TraceChoice, Tracer};
use nephroid::view::{Band, View};

fn main() -> ExitCode {
    common::run(&[
        Case { name: "surfaces_are_lit_as_in_f64", needs: &[], disable: "", run: surfaces },
        Case { name: "a_beam_lands_with_all_its_flux", needs: &[], disable: "", run: flux },
        Case { name: "flat_water_is_the_closed_form", needs: &[], disable: "", run: flat_water },
        Case { name: "shadows_fall", needs: &[], disable: "", run: shadows },
        Case { name: "degenerate_beams_are_dark_or_finite", needs: &[], disable: "", run: degenerate },
        Case { name: "adaptive_rounds_and_equal_bits", needs: &[], disable: "", run: adaptive },
    ])
}

/// Against f64, where f32 has positions of metres and beams of centimetres.
const ROUNDING: f64 = 2e-4;

/// How near a beam's side a point may be for f32 and f64 to put it on different sides.
const SIDE: f64 = 1e-4;

/// Lit by nothing but beams: a floor at y = 0 seen from above.
const FLOOR: &str = r#"
[[camera]]
name = "down"
position = [0, 4, 0]
target = [0, 0, 0]
up = [0, 0, -1]
fov_y = 60
[[material]]
name = "floor"
kind = "diffuse"
albedo = 0.5
[[object]]
name = "floor"
shape = "plane"
centre = [0, 0, 0]
size = [100, 100]
material = "floor"
"#;

fn parse(text: &str) -> Scene {
    scene::parse(text, Path::new("test.toml")).unwrap()
}

/// The floor in a medium of its own, number 1.
fn in_smoke(coefficients: &str) -> String {
    let camera = FLOOR.replace("fov_y = 60", "fov_y = 60\nmedium = \"smoke\"");
    format!("[[medium]]\nname = \"smoke\"\nindex = 1\n{coefficients}\n{camera}")
}

/// A frame and all it stands on.
struct Stage {
    device: Device,
    scene: Scene,
    tracer: Tracer,
    frame: Frame,
}

impl Stage {
    fn new(request: &Request, scene: Scene, size: (u32, u32), sampling: Sampling) -> Self {
        let device = request.open();
        let gpu_scene = GpuScene::new(&device, &scene).unwrap();
        let (tracer, _) = trace::choose(&device, &scene, &gpu_scene, TraceChoice::Bvh).unwrap();
        let view = View::new(&scene.cameras[0], &scene.film, size, Band { first: 0, count: size.1 }).of(&scene);
        let frame = Frame::new(&device, &gpu_scene, &tracer, &view, sampling).unwrap();
        Stage { device, scene, tracer, frame }
    }

    /// With room for some more beams than there are.
    fn accumulator(&self, beams: &[Beam], options: Options) -> Accumulator {
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

    /// Each slot's point and its irradiance, in sample `index`.
    fn sample(&mut self, accumulator: &Accumulator, index: u32) -> Vec<(VisiblePoint, [f32; 4])> {
        let mut recorder = Recorder::new(&self.device).unwrap();
        self.frame.record(&mut recorder, index).unwrap();
        accumulator.record(&self.frame, &mut recorder, true).unwrap();
        recorder.submit().unwrap();
        let Some(Binding::Buffer(points)) = self.frame.bindings.get("VisiblePoints") else { unreachable!() };
        let slots = self.frame.slots() as usize;
        let points: Vec<VisiblePoint> = points.read(slots).unwrap();
        let found: Vec<[f32; 4]> = self.frame.film.sample_irradiance().read(slots).unwrap();
        assert_valid(&self.device);
        points.into_iter().zip(found).filter(|(point, _)| point.instance != u32::MAX).collect()
    }
}

fn position(point: &VisiblePoint) -> DVec3 {
    DVec3::from_array(point.position.map(f64::from))
}

fn counter(accumulator: &Accumulator, name: &str) -> f64 {
    accumulator.counters().unwrap().iter().find(|entry| entry.name == name).unwrap().value
}

/// Beams of every kind to the floor: parallel, spread out, through a focus on a line or a point, twisted, grazing, and a
/// crowd of small ones.
fn many_beams() -> Vec<Beam> {
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
    for _ in 0..3000 {
        let at = dvec3(numbers.between(-2.5, 2.5), 0.0, numbers.between(-2.0, 2.0));
        let mut corner = || {
            let start = at + dvec3(numbers.between(-0.1, 0.1), numbers.between(1.4, 1.6), numbers.between(-0.1, 0.1));
            let way = dvec3(numbers.between(-0.1, 0.1), -1.0, numbers.between(-0.1, 0.1)).normalize();
            let area = [numbers.between(0.5, 2.0), numbers.between(-1.0, 1.0), numbers.between(-1.0, 1.0)];
            Edge { area, flux: numbers.between(0.5, 2.0), ..Edge::plain(start, way, -start.y / way.y) }
        };
        all.push(beam([corner(), corner(), corner()], 0.01, 0));
    }
    all
}

/// The oracle's sum at a point; `None` where f32 may see it on the other side of a beam's side.
fn expected(beams: &[Beam], point: &VisiblePoint, extinction: f64, options: &Options) -> Option<f64> {
    let at = position(point);
    let mut sum = 0.0;
    for beam in beams {
        let near = oracle::place(beam, at).is_some_and(|place| place.depth().abs() < SIDE && place.distance > 0.0);
        if near {
            return None;
        }
        let angle = f64::from(options.light_angle);
        let smooth = options.area == Area::Vertex;
        sum += f64::from(beam.flux[0]) * oracle::irradiance(beam, at, DVec3::Y, extinction, angle, smooth);
    }
    Some(sum)
}

/// Compares every point with the oracle; returns how many were compared.
fn compare(found: &[(VisiblePoint, [f32; 4])], beams: &[Beam], extinction: f64, options: &Options) -> usize {
    let mut compared = 0;
    for (point, irradiance) in found {
        let Some(sum) = expected(beams, point, extinction, options) else { continue };
        let difference = (f64::from(irradiance[0]) - sum).abs();
        assert!(difference <= ROUNDING * sum, "{:?}: {} instead of {sum}", point.position, irradiance[0]);
        compared += usize::from(sum > 0.0);
    }
    compared
}

fn surfaces(request: &Request) {
    let beams = many_beams();
    let mut stage = Stage::new(request, parse(FLOOR), (61, 45), Sampling::Uniform);
    for (area, shadows) in [(Area::Vertex, Shadows::Points), (Area::Beam, Shadows::Edges)] {
        let options = Options { area, shadows, ..Default::default() };
        let accumulator = stage.accumulator(&beams, options);
        let found = stage.sample(&accumulator, 0);
        let compared = compare(&found, &beams, 0.0, &options);
        println!("{compared} of {} points compared; {:?}", found.len(), accumulator.counters().unwrap());
        assert!(compared > 61 * 45 / 2, "{compared} points compared");
        assert_eq!(counter(&accumulator, "beam_shadow_rays") > 0.0, shadows == Shadows::Points);
        // Most of the work that all pairs would be is not done: 3007 beams at 61 x 45 points.
        assert!(counter(&accumulator, "beam_tests") < 0.1 * 3007.0 * 61.0 * 45.0);
    }

    // What is absorbed on the way.
    let beams: Vec<Beam> = beams.into_iter().map(|beam| Beam { medium: 1, ..beam }).collect();
    let mut stage = Stage::new(request, parse(&in_smoke("absorption = 0.7")), (61, 45), Sampling::Uniform);
    let accumulator = stage.accumulator(&beams, Options::default());
    let found = stage.sample(&accumulator, 0);
    assert!(compare(&found, &beams, 0.7, &Options::default()) > 61 * 45 / 2);
}

fn flux(request: &Request) {
    // Each pixel covers the same of the floor: half the picture is 4 tan(30 degrees) high there.
    let (width, height, samples) = (64u32, 48u32, 16u32);
    let pixel = (2.0 * 4.0 * 30f64.to_radians().tan() / f64::from(height)).powi(2);
    let mut stage = Stage::new(request, parse(FLOOR), (width, height), Sampling::Uniform);
    for (index, mut one) in many_beams().into_iter().take(7).enumerate() {
        // Corners that are bright and dark by turns: what one gains the others lose.
        for (corner, flux) in one.corners.iter_mut().zip([1.0, 4.0, 0.5]) {
            corner.flux = flux;
        }
        let accumulator = stage.accumulator(&[one], Options::default());
        let mut sum = 0.0;
        for sample in 0..samples {
            let found = stage.sample(&accumulator, sample);
            sum += found.iter().map(|(_, e)| f64::from(e[0]) * pixel).sum::<f64>() / f64::from(samples);
        }
        let ratio = sum / f64::from(one.flux[0]);
        println!("beam {index}: {ratio:.4} of its flux");
        // The border of a triangle some twenty pixels wide, at sixteen points a pixel.
        assert!((ratio - 1.0).abs() < 0.01, "beam {index}: {ratio}");
    }
}

/// Refracts the lamp of `flat_water.toml` at the water above (x, z): the edge from there to the floor at y = -2.
fn refracted_edge(x: f64, z: f64) -> (Edge, f64) {
    let lamp = dvec3(1.5, 6.0, -1.0);
    let ray = |x: f64, z: f64| {
        let start = dvec3(x, 0.0, z);
        let before = (start - lamp).normalize();
        let across = dvec3(before.x, 0.0, before.z) / 1.33;
        (start, across - DVec3::Y * (1.0 - across.length_squared()).sqrt())
    };
    let transmitted = {
        let (start, way) = ray(x, z);
        let (c1, c2) = (-(start - lamp).normalize().y, -way.y);
        let perpendicular = ((c1 - 1.33 * c2) / (c1 + 1.33 * c2)).powi(2);
        let parallel = ((1.33 * c1 - c2) / (1.33 * c1 + c2)).powi(2);
        1.0 - 0.5 * (perpendicular + parallel)
    };
    let flux_through = {
        // 100 W/sr through a square metre of the water here.
        let way = dvec3(x, 0.0, z) - lamp;
        100.0 * 6.0 / way.length().powi(3) * transmitted
    };
    let (start, way) = ray(x, z);
    // What a square of the water spreads out to, across the way; quadratic in the length, so three lengths tell it.
    let small = 1e-3;
    let area = |l: f64| {
        let at = |dx: f64, dz: f64| {
            let (s, w) = ray(x + dx, z + dz);
            s + w * ((start + way * l - s).dot(way) / w.dot(way))
        };
        let (u, v) = (at(small, 0.0) - at(-small, 0.0), at(0.0, -small) - at(0.0, small));
        u.cross(v).dot(way).abs() / (4.0 * small * small)
    };
    let (a0, a1, a2) = (area(0.0), area(1.0), area(2.0));
    let square = 0.5 * (a2 - 2.0 * a1 + a0);
    let edge = Edge { start, way, length: 2.0 / -way.y, area: [a0, a1 - a0 - square, square], flux: flux_through };
    (edge, flux_through)
}

/// Beams through a grid of `cells` x `cells` squares of the water.
fn flat_water_beams(cells: u32) -> Vec<Beam> {
    let at = |i: u32| -5.0 + 10.0 * f64::from(i) / f64::from(cells);
    let side = 10.0 / f64::from(cells);
    let mut all = Vec::new();
    for row in 0..cells {
        for column in 0..cells {
            let corner = |dx: u32, dz: u32| refracted_edge(at(column + dx), at(row + dz));
            let (a, b, c, d) = (corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1));
            for three in [[a, b, c], [a, c, d]] {
                // The flux over a triangle, by the mean of its corners.
                let flux = three.iter().map(|(_, flux)| flux).sum::<f64>() / 3.0 * 0.5 * side * side;
                all.push(beam(three.map(|(edge, _)| edge), flux, 1));
            }
        }
    }
    all
}

/// Of the union of beams 0.16 m wide against the closed form: what the mean of three corners is off for a square's flux.
const FLAT_WATER: f64 = 2e-3;

fn flat_water(request: &Request) {
    let beams = flat_water_beams(64);
    let scene = scene::load(Path::new("scenes/flat_water.toml")).unwrap();
    let mut stage = Stage::new(request, scene, (60, 45), Sampling::Uniform);
    let accumulator = stage.accumulator(&beams, Options::default());
    let (mut worst, mut compared): (f64, _) = (0.0, 0);
    for (point, irradiance) in stage.sample(&accumulator, 0) {
        let p = position(&point);
        if (p.y + 2.0).abs() > 1e-3 || p.x.abs() > 4.5 || p.z.abs() > 4.5 {
            continue;
        }
        worst = worst.max((f64::from(irradiance[0]) / flat_water_irradiance(p.x, p.z) - 1.0).abs());
        compared += 1;
    }
    println!("{compared} points, worst {worst:.2e}; {:?}", accumulator.counters().unwrap());
    assert!(compared > 500, "{compared} points on the floor");
    assert!(worst < FLAT_WATER, "{worst}");
}

/// A plate half a metre above the floor, at x from 0 to 1.
const PLATE: &str = r#"
[[object]]
name = "plate"
shape = "plane"
centre = [0.5, 0.5, 0]
size = [1, 0.6]
material = "floor"
"#;

fn shadows(request: &Request) {
    let corners = [dvec3(-4.0, 2.0, -3.0), dvec3(5.0, 2.0, -3.0), dvec3(0.0, 2.0, 5.0)];
    // Light comes from the right, so that the shadow shows beside the plate: from x = -0.25 to 0.
    let mut one = beam_to_floor(corners, [dvec3(-1.0, -2.0, 0.0); 3], 1.0, 0.0);
    let mut stage = Stage::new(request, parse(&format!("{FLOOR}{PLATE}")), (60, 45), Sampling::Uniform);
    let under = |p: DVec3| p.x > -0.24 && p.x < 0.0 && p.z.abs() < 0.29 && p.y < 0.4;
    for (flags, shadows, dark) in
        [(0, Shadows::Points, true), (0, Shadows::Edges, false), (STRADDLES, Shadows::Edges, true)]
    {
        one.flags = flags;
        let accumulator = stage.accumulator(&[one], Options { shadows, ..Default::default() });
        let found = stage.sample(&accumulator, 0);
        let mut counts = [0; 2];
        for (point, irradiance) in &found {
            let at = position(point);
            if under(at) {
                counts[0] += 1;
                assert_eq!(irradiance[0] > 0.0, !dark, "{at}, {shadows:?}, flags {flags}");
            } else if at.y > 0.4 {
                counts[1] += 1;
                assert!(irradiance[0] > 0.0, "the plate is lit at {at}, {shadows:?}, flags {flags}");
            }
        }
        println!("{counts:?} points under and on the plate");
        assert!(counts[0] > 0 && counts[1] > 20, "{counts:?}");
    }
}

fn degenerate(request: &Request) {
    let good = many_beams().swap_remove(0);
    let mut all = vec![good];
    // No area at all, a line, all of it in one point of the floor, an empty slot, and numbers that are none.
    let point = dvec3(0.1, 2.0, 0.1);
    all.push(beam_to_floor([point; 3], [DVec3::NEG_Y; 3], 1.0, 0.0));
    all.push(beam_to_floor([point, point + DVec3::X, point + 2.0 * DVec3::X], [DVec3::NEG_Y; 3], 1.0, 0.0));
    let corners = [dvec3(-1.0, 2.0, -1.0), dvec3(1.0, 2.0, -1.0), dvec3(0.0, 2.0, 1.0)];
    all.push(beam_to_floor(corners, corners.map(|p| -p), 1.0, 0.0));
    all.push(Beam { flags: EMPTY, flux: [f32::NAN; 3], ..good });
    all.push(Beam { flux: [f32::INFINITY; 3], ..good });
    let mut broken = good;
    broken.corners[1].way[0] = f32::NAN;
    all.push(broken);
    let mut endless = good;
    endless.corners[2].end = f32::INFINITY;
    all.push(endless);
    let mut stage = Stage::new(request, parse(FLOOR), (60, 45), Sampling::Uniform);
    let accumulator = stage.accumulator(&all, Options::default());
    let found = stage.sample(&accumulator, 0);
    assert!(found.iter().all(|(_, e)| e.iter().all(|v| v.is_finite())));
    let lit = compare(&found, &[good], 0.0, &Options::default());
    assert!(lit > 100, "{lit} points in the one good beam");
    // The beam of infinite flux at every point inside, and two that have no box.
    assert!(counter(&accumulator, "beam_fragments_non_finite") >= 2.0 + lit as f64);

    // Light that is all absorbed.
    let mut stage = Stage::new(request, parse(&in_smoke("absorption = 1e9")), (60, 45), Sampling::Uniform);
    let accumulator = stage.accumulator(&[Beam { medium: 1, ..good }], Options::default());
    assert!(stage.sample(&accumulator, 0).iter().all(|(_, e)| e[0] == 0.0));
    assert_eq!(counter(&accumulator, "beam_fragments_non_finite"), 0.0);
}

fn adaptive(request: &Request) {
    let beams = many_beams();
    let mut stage = Stage::new(request, parse(FLOOR), (61, 45), Sampling::Adaptive { samples: 4 });
    let accumulator = stage.accumulator(&beams, Options::default());
    let found = stage.sample(&accumulator, 0);
    assert!(compare(&found, &beams, 0.0, &Options::default()) > 61 * 45 / 2);
    let again = stage.sample(&stage.accumulator(&beams, Options::default()), 0);
    let bits = |all: &[(VisiblePoint, [f32; 4])]| all.iter().map(|(_, e)| e.map(f32::to_bits)).collect::<Vec<_>>();
    assert!(bits(&found) == bits(&again), "the same beams gave different bits");
}
