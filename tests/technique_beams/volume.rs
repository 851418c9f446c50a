//! What beams scatter towards the camera, against f64: given ones, and those that lights send.

use crate::beams::oracle::{self, Fog, ViewRay};
use crate::beams::stage::{CROWD, Stage, counter, in_smoke, many_beams, parse};
use crate::common::pool::{FlatPart, against_flat_water, turbid_flat_pool};
use crate::common::smoke::{against_pane, pane};
use crate::common::{Request, layer};
use glam::DVec3;
use nephroid::frame::{Sampling, ViewSegment};
use nephroid::scene::Scene;
use nephroid::technique::TechniqueKind;
use nephroid::technique::beams::accumulate::{Accumulator, Integral, Interval, Options};
use nephroid::technique::beams::beam::Beam;

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

pub fn one_by_one(request: &Request) {
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

pub fn crowd(request: &Request) {
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

pub fn integrals(request: &Request) {
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

pub fn extremes(request: &Request) {
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

/// The layer `caustic_volume` by one set of beams.
fn caustic_volume(request: &Request, scene: Scene, size: (u32, u32), set: &str) -> Vec<[f32; 3]> {
    let picture = request.render(scene, |s| {
        s.technique = TechniqueKind::Beams;
        // A pixel's mean is compared.
        (s.size, s.samples) = (Some(size), Some(4));
        s.set = format!("beams.jitter=off beams.reuse=4 {set}").split(' ').map(String::from).collect();
    });
    layer(&picture.image, "caustic_volume")
}

/// Of the flat pool's light, by beams a thirtieth as wide as what the lamp sees; a pixel, looked at in four places, may be
/// twice as far off.
const FLAT: f64 = 0.02;

pub fn flat_water(request: &Request) {
    let size = (24, 18);
    for asymmetry in [0.0, 0.7] {
        let found = caustic_volume(request, turbid_flat_pool(asymmetry as f32), size, "beams.levels=1 beams.bounces=1");
        for (part, name) in [(FlatPart::Walls, "walls"), (FlatPart::Surface, "surface")] {
            let (energy, rel_rmse) = against_flat_water(&found, size, asymmetry, part);
            println!("g {asymmetry}, {name}: energy {energy:.5}, relRMSE {rel_rmse:.4}");
            assert!((energy - 1.0).abs() < FLAT, "g {asymmetry}, {name}: energy {energy}");
            assert!(rel_rmse < 2.0 * FLAT, "g {asymmetry}, {name}: relRMSE {rel_rmse}");
        }
    }
}

/// Of the smoke: nothing but the pane's rim, which beams straddle, is not exact; pixels as above.
const SMOKE: f64 = 0.02;

pub fn smoke(request: &Request) {
    let size = (16, 12);
    let found = caustic_volume(request, pane(), size, "beams.levels=1 beams.bounces=2");
    // Through the pane without a reflection in it: (1 - R)^2 with R = 0.04.
    for (channel, (energy, rel_rmse)) in against_pane(&found, size, 0.96 * 0.96).into_iter().enumerate() {
        println!("channel {channel}: energy {energy:.5}, relRMSE {rel_rmse:.4}");
        assert!((energy - 1.0).abs() < SMOKE, "channel {channel}: energy {energy}");
        assert!(rel_rmse < 2.0 * SMOKE, "channel {channel}: relRMSE {rel_rmse}");
    }
}

/// What a level more, of light that is not focused, may change a pixel by.
const LEVEL: f64 = 0.04;

pub fn levels(request: &Request) {
    let picture = |levels: u32| {
        let set = format!("beams.levels={levels} beams.least_level={levels} beams.bounces=1");
        caustic_volume(request, turbid_flat_pool(0.5), (8, 6), &set)
    };
    let (coarse, fine) = (picture(0), picture(1));
    let worst = coarse.iter().zip(&fine).map(|(a, b)| f64::from((a[1] / b[1] - 1.0).abs())).fold(0.0, f64::max);
    println!("{worst:.2e}");
    assert!(worst < LEVEL && worst > 0.0, "{worst}");
}

/// Water through which all light comes, or none, and with nothing in it.
pub fn strengths(request: &Request) {
    let sum = |factor: f32| {
        let mut scene = turbid_flat_pool(0.0);
        scene
            .media
            .iter_mut()
            .for_each(|m| (m.absorption, m.scattering) = (m.absorption * factor, m.scattering * factor));
        let found = caustic_volume(request, scene, (8, 6), "beams.levels=0 beams.least_level=0 beams.bounces=1");
        assert!(found.iter().flatten().all(|v| v.is_finite() && *v >= 0.0), "times {factor}");
        found.iter().map(|v| f64::from(v[1])).sum::<f64>()
    };
    // The lamp's light comes 2 m and more through the water: at 10^9 a metre, none does.
    assert_eq!(sum(1e10), 0.0);
    // Where nothing is lost, radiance goes with what is scattered.
    let (thin, thinner) = (sum(1e-4), sum(1e-5));
    println!("{thin:e}, {thinner:e}");
    assert!((thin / thinner / 10.0 - 1.0).abs() < 1e-3, "{thin} to {thinner}");
    assert!(thinner > 0.0);
}
