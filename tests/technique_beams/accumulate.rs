//! Light of given beams on surfaces, against f64 and closed forms.

use std::path::Path;

use crate::beams::flat_water::flat_water_beams;
use crate::beams::stage::{FLOOR, Stage, counter, in_smoke, many_beams, parse, position};
use crate::beams::{beam_to_floor, oracle};
use crate::common::Request;
use crate::common::pool::flat_water_irradiance;
use glam::{DVec3, dvec3};
use nephroid::frame::{Sampling, VisiblePoint};
use nephroid::scene;
use nephroid::technique::beams::accumulate::{Area, Options, Shadows};
use nephroid::technique::beams::beam::{Beam, EMPTY, STRADDLES};

/// Light at points, not on what pixels cover.
const POINTS: Options = Options { footprints: false, ..Options::DEFAULT };

/// Against f64, where f32 has positions of metres and beams of centimetres.
const ROUNDING: f64 = 2e-4;

/// How near a beam's side a point may be for f32 and f64 to put it on different sides.
const SIDE: f64 = 1e-4;

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

pub fn surfaces(request: &Request) {
    let beams = many_beams();
    let mut stage = Stage::new(request, parse(FLOOR), (61, 45), Sampling::Uniform);
    for (area, shadows) in [(Area::Vertex, Shadows::Points), (Area::Beam, Shadows::Edges)] {
        let options = Options { area, shadows, ..POINTS };
        let accumulator = stage.accumulator(&beams, options);
        let found = stage.sample(&accumulator, 0);
        let compared = compare(&found, &beams, 0.0, &options);
        println!("{compared} of {} points compared; {:?}", found.len(), accumulator.counters().unwrap());
        assert!(compared > 61 * 45 / 3, "{compared} points compared");
        assert_eq!(counter(&accumulator, "beam_shadow_rays") > 0.0, shadows == Shadows::Points);
        // Most of the work that all pairs would be is not done.
        assert!(counter(&accumulator, "beam_tests") < 0.1 * (beams.len() * 61 * 45) as f64);
    }

    // What is absorbed on the way.
    let beams: Vec<Beam> = beams.into_iter().map(|beam| Beam { medium: 1, ..beam }).collect();
    let mut stage = Stage::new(request, parse(&in_smoke("absorption = 0.7")), (61, 45), Sampling::Uniform);
    let accumulator = stage.accumulator(&beams, POINTS);
    let found = stage.sample(&accumulator, 0);
    assert!(compare(&found, &beams, 0.7, &POINTS) > 61 * 45 / 3);
}

pub fn flux(request: &Request) {
    // Each pixel covers the same of the floor: half the picture is 4 tan(30 degrees) high there. More tiles than are gathered
    // at once.
    let (width, height, samples) = (256u32, 192u32, 2u32);
    let pixel = (2.0 * 4.0 * 30f64.to_radians().tan() / f64::from(height)).powi(2);
    let mut stage = Stage::new(request, parse(FLOOR), (width, height), Sampling::Uniform);
    for (index, mut one) in many_beams().into_iter().take(7).enumerate() {
        // Corners that are bright and dark by turns: what one gains the others lose.
        let middle = one.corners.map(|c| {
            DVec3::from_array(c.origin.map(f64::from)) + f64::from(c.end) * DVec3::from_array(c.way.map(f64::from))
        });
        let area = oracle::place(&one, middle.iter().sum::<DVec3>() / 3.0).unwrap().area as f32;
        for (corner, part) in one.corners.iter_mut().zip([1.0, 1.6, 0.7]) {
            (corner.area, corner.flux) = ([area, 0.0, 0.0], part * one.flux[0]);
        }
        let accumulator = stage.accumulator(&[one], POINTS);
        let mut sum = 0.0;
        for sample in 0..samples {
            let found = stage.sample(&accumulator, sample);
            sum += found.iter().map(|(_, e)| f64::from(e[0]) * pixel).sum::<f64>() / f64::from(samples);
        }
        let ratio = sum / f64::from(one.flux[0]);
        println!("beam {index}: {ratio:.4} of its flux");
        // The border of a triangle some eighty pixels wide, at two points a pixel.
        assert!((ratio - 1.0).abs() < 0.01, "beam {index}: {ratio}");
    }
}

/// Of the union of beams 0.16 m wide against the closed form: what the mean of three corners is off for a square's flux.
const FLAT_WATER: f64 = 2e-3;

pub fn flat_water(request: &Request) {
    let beams = flat_water_beams(64);
    let scene = scene::load(Path::new("scenes/flat_water.toml")).unwrap();
    let mut stage = Stage::new(request, scene, (60, 45), Sampling::Uniform);
    let accumulator = stage.accumulator(&beams, POINTS);
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

pub fn shadows(request: &Request) {
    let corners = [dvec3(-4.0, 2.0, -3.0), dvec3(5.0, 2.0, -3.0), dvec3(0.0, 2.0, 5.0)];
    // Light comes from the right, so that the shadow shows beside the plate: from x = -0.25 to 0.
    let mut one = beam_to_floor(corners, [dvec3(-1.0, -2.0, 0.0); 3], 1.0, 0.0);
    let mut stage = Stage::new(request, parse(&format!("{FLOOR}{PLATE}")), (60, 45), Sampling::Uniform);
    let under = |p: DVec3| p.x > -0.24 && p.x < 0.0 && p.z.abs() < 0.29 && p.y < 0.4;
    for (flags, shadows, dark) in
        [(0, Shadows::Points, true), (0, Shadows::Edges, false), (STRADDLES, Shadows::Edges, true)]
    {
        one.flags = flags;
        let accumulator = stage.accumulator(&[one], Options { shadows, ..POINTS });
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

pub fn degenerate(request: &Request) {
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
    let accumulator = stage.accumulator(&all, POINTS);
    let found = stage.sample(&accumulator, 0);
    assert!(found.iter().all(|(_, e)| e.iter().all(|v| v.is_finite())));
    let lit = compare(&found, &[good], 0.0, &POINTS);
    assert!(lit > 100, "{lit} points in the one good beam");
    // The beam of infinite flux at every point inside, and two that have no box.
    assert!(counter(&accumulator, "beam_fragments_non_finite") >= 2.0 + lit as f64);

    // Light that is all absorbed.
    let mut stage = Stage::new(request, parse(&in_smoke("absorption = 1e9")), (60, 45), Sampling::Uniform);
    let accumulator = stage.accumulator(&[Beam { medium: 1, ..good }], POINTS);
    assert!(stage.sample(&accumulator, 0).iter().all(|(_, e)| e[0] == 0.0));
    assert_eq!(counter(&accumulator, "beam_fragments_non_finite"), 0.0);
}

pub fn adaptive(request: &Request) {
    let beams = many_beams();
    let mut stage = Stage::new(request, parse(FLOOR), (61, 45), Sampling::Adaptive { samples: 4 });
    let accumulator = stage.accumulator(&beams, POINTS);
    let found = stage.sample(&accumulator, 0);
    assert!(compare(&found, &beams, 0.0, &POINTS) > 61 * 45 / 3);
    let again = stage.sample(&stage.accumulator(&beams, POINTS), 0);
    let bits = |all: &[(VisiblePoint, [f32; 4])]| all.iter().map(|(_, e)| e.map(f32::to_bits)).collect::<Vec<_>>();
    assert!(bits(&found) == bits(&again), "the same beams gave different bits");
}
