//! What given beams scatter towards the camera, against f64.

mod beams;
mod common;

use std::process::ExitCode;

use beams::oracle::{self, Fog, ViewRay};
use beams::stage::{CROWD, Stage, counter, in_smoke, many_beams, parse};
use common::{Case, Request};
use glam::DVec3;
use nephroid::frame::{Sampling, ViewSegment};
use nephroid::technique::beams::accumulate::{Accumulator, Integral, Interval, Options};
use nephroid::technique::beams::beam::Beam;

fn main() -> ExitCode {
    common::run(&[
        Case { name: "media_scatter_as_in_f64", needs: &[], disable: "", run: one_by_one },
        Case { name: "a_crowd_of_beams_adds_up", needs: &[], disable: "", run: crowd },
        Case { name: "other_integrals_agree", needs: &[], disable: "", run: integrals },
        Case { name: "extreme_media_are_finite", needs: &[], disable: "", run: extremes },
    ])
}

/// Of a beam's light along a ray through the middle of it; two points a step leave this.
const EXACT: f64 = 5e-4;

const FOG: Fog = Fog { scattering: 0.3, extinction: 0.5, asymmetry: 0.6 };

fn fog_scene() -> String {
    in_smoke("absorption = 0.2\nscattering = 0.3\nasymmetry = 0.6")
        .replace("position = [0, 4, 0]\ntarget = [0, 0, 0]", "position = [0.3, 1.2, 4]\ntarget = [0, 0.9, 0]")
        .replace("up = [0, 0, -1]", "up = [0, 1, 0]")
}

/// Each slot's first stretch and what it should show of `beams`: radiance per W times flux.
fn rays(stage: &Stage) -> Vec<(usize, ViewRay)> {
    let segments: Vec<ViewSegment> = stage.read("ViewSegments", 4);
    let there = |segment: &&(usize, ViewSegment)| segment.1.throughput_b_medium >> 16 != 0xffff;
    let slots = stage.frame.slots() as usize;
    let all: Vec<(usize, ViewSegment)> = segments.into_iter().take(slots).enumerate().collect();
    let ray = |&(slot, segment): &(usize, ViewSegment)| {
        let origin = DVec3::from_array(segment.origin.map(f64::from));
        let way = DVec3::from_array(segment.end.map(f64::from)) - origin;
        (slot, ViewRay { origin, direction: way.normalize(), length: way.length() })
    };
    all.iter().filter(there).map(ray).collect()
}

fn in_fog(beams: Vec<Beam>) -> Vec<Beam> {
    beams.into_iter().map(|beam| Beam { medium: 1, ..beam }).collect()
}

/// What a sample's slots show.
fn volume(stage: &mut Stage, accumulator: &Accumulator) -> Vec<[f32; 4]> {
    stage.sample(accumulator, 0);
    stage.read("SampleVolume", 1)
}

fn one_by_one(request: &Request) {
    let mut stage = Stage::new(request, parse(&fog_scene()), (24, 18), Sampling::Uniform);
    let options = Options::default();
    for (index, beam) in in_fog(many_beams()).into_iter().take(7).enumerate() {
        let accumulator = stage.accumulator(&[beam], options);
        let found = volume(&mut stage, &accumulator);
        let (mut compared, mut left_out, mut worst) = (0, 0, 0.0f64);
        let mut brightest = 0.0f64;
        let mut pairs = Vec::new();
        for (slot, ray) in rays(&stage) {
            let Some(expected) = oracle::inscattered(&beam, &ray, &FOG, f64::from(options.light_angle)) else {
                left_out += 1;
                continue;
            };
            let expected = expected * f64::from(beam.flux[0]);
            brightest = brightest.max(expected);
            compared += usize::from(expected > 0.0);
            pairs.push((f64::from(found[slot][0]), expected));
        }
        for (found, expected) in pairs {
            // Grazed corners are short, and end where f32 says.
            worst = worst.max((found - expected).abs() / expected.max(0.02 * brightest));
        }
        println!("beam {index}: {compared} rays compared, {left_out} left out, worst {worst:.2e}");
        assert!(worst < EXACT, "beam {index}: {worst}");
        assert!(compared > if index < 6 { 20 } else { 5 }, "beam {index}: {compared}");
        assert!(left_out < 40, "{left_out} rays left out");
    }
}

fn crowd(request: &Request) {
    let beams = in_fog(many_beams().split_off(7));
    let mut stage = Stage::new(request, parse(&fog_scene()), (24, 18), Sampling::Uniform);
    let accumulator = stage.accumulator(&beams, Options::default());
    let found = volume(&mut stage, &accumulator);
    let angle = f64::from(Options::default().light_angle);
    let mut compared = 0;
    for (slot, ray) in rays(&stage).into_iter().step_by(41) {
        let parts: Option<Vec<f64>> =
            beams.iter().map(|b| Some(oracle::inscattered(b, &ray, &FOG, angle)? * 0.01)).collect();
        let Some(parts) = parts else { continue };
        let expected: f64 = parts.iter().sum();
        let error = (f64::from(found[slot][0]) - expected).abs() / expected.max(1e-6);
        assert!(error < 5.0 * EXACT, "slot {slot}: {} instead of {expected}", found[slot][0]);
        compared += usize::from(expected > 0.0);
    }
    println!("{compared} rays compared; {:?}", accumulator.counters().unwrap());
    assert!(compared >= 5, "{compared} rays compared");
    // Of all beams, in no order, times 432 rays in tiles of a third of the picture.
    assert!(counter(&accumulator, "beam_tests") < 0.6 * CROWD as f64 * 432.0);
}

fn integrals(request: &Request) {
    // Without a focus, whose beams a plane does not cut in a triangle.
    let mut beams = in_fog(many_beams());
    beams.swap(3, 5);
    beams.truncate(4);
    let mut stage = Stage::new(request, parse(&fog_scene()), (24, 18), Sampling::Uniform);
    let mut picture = |options: Options| {
        let accumulator = stage.accumulator(&beams, options);
        volume(&mut stage, &accumulator)
    };
    let closed = picture(Options::default());
    let norm: f64 = closed.iter().map(|v| f64::from(v[0]).powi(2)).sum::<f64>().sqrt();
    let mut difference = |options: Options| {
        let other = picture(options);
        let squares: f64 = other.iter().zip(&closed).map(|(a, b)| f64::from(a[0] - b[0]).powi(2)).sum();
        squares.sqrt() / norm
    };
    let adaptive = difference(Options { integral: Integral::Adaptive, ..Default::default() });
    let midpoint = difference(Options { integral: Integral::Midpoint, ..Default::default() });
    let plane = difference(Options { interval: Interval::ScanPlane, ..Default::default() });
    println!("adaptive {adaptive:.2e}, midpoint {midpoint:.2e}, scan plane {plane:.2e}");
    // The adaptive integral leaves its last change, the others what they leave out: they must differ.
    assert!(adaptive < 5e-3, "{adaptive}");
    assert!(midpoint > adaptive && midpoint < 0.3, "{midpoint}");
    assert!(plane > adaptive && plane < 0.5, "{plane}");
}

fn extremes(request: &Request) {
    let beams = in_fog(many_beams());
    for (coefficients, dark) in
        [("absorption = 1e9\nscattering = 1e9", true), ("scattering = 1e-9", false), ("scattering = 3", false)]
    {
        let scene = fog_scene().replace("absorption = 0.2\nscattering = 0.3", coefficients);
        let mut stage = Stage::new(request, parse(&scene), (24, 18), Sampling::Uniform);
        let accumulator = stage.accumulator(&beams, Options::default());
        let found = volume(&mut stage, &accumulator);
        assert!(found.iter().flatten().all(|v| v.is_finite() && *v >= 0.0), "{coefficients}");
        let sum: f32 = found.iter().map(|v| v[0]).sum();
        println!("{coefficients:?}: sum {sum:e}");
        assert_eq!(counter(&accumulator, "beam_fragments_non_finite"), 0.0, "{coefficients}");
        assert_eq!(sum == 0.0, dark, "{coefficients}: {sum}");
    }
}
