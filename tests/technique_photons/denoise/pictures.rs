//! The filter in pictures of the pool, against the mean of many unfiltered sets.

use std::sync::OnceLock;

use nephroid::render::{RenderSettings, Renderer};
use nephroid::technique::TechniqueKind;

use crate::common::pool::coarse;
use crate::common::{Request, assert_valid, layer};

const TRUTH_SAMPLES: u32 = 32;
/// Of the light of one set, unfiltered.
const ENERGY: f64 = 0.01;
/// Of a set's noise, what is left by the filter in space, and after 8 frames.
const SPATIAL: f64 = 0.8;
const TEMPORAL: f64 = 0.5;
/// Flux is kept, but pixels show it in parts that differ: one set's energy in so small a picture is off by 3 %.
const SAMPLES: u32 = 4;
const FRAMES: u32 = 8;

fn renderer(request: &Request, samples: u32, seed: u32, set: &[&str]) -> Renderer {
    // The same photons with and without a filter.
    let common = ["photons=5000", "resolution=128", "points=jittered"];
    let settings = RenderSettings {
        device: request.device.clone(),
        trace: "bvh".parse().unwrap(),
        technique: TechniqueKind::Photons,
        camera: Some("under".to_string()),
        size: Some((48, 36)),
        samples: Some(samples),
        seed,
        set: common.iter().chain(set).map(|item| format!("photons.{item}")).collect(),
        ..Default::default()
    };
    request.renderer(coarse("pool.toml"), &settings)
}

/// The light of all samples, pixel by pixel.
fn light(renderer: &mut Renderer) -> Vec<f64> {
    while renderer.done() < renderer.samples() {
        renderer.sample().unwrap();
    }
    let picture = renderer.finish().unwrap();
    assert_valid(renderer.device());
    layer(&picture.image, "refracted").into_iter().map(|pixel| pixel[1].into()).collect()
}

fn mean(light: &[f64]) -> f64 {
    light.iter().sum::<f64>() / light.len() as f64
}

fn error(found: &[f64], truth: &[f64]) -> f64 {
    let squares: f64 = found.iter().zip(truth).map(|(a, b)| (a - b).powi(2)).sum();
    (squares / found.len() as f64).sqrt() / mean(truth)
}

/// Many unfiltered sets, found once a device: each has a process of its own.
fn truth(request: &Request) -> &'static [f64] {
    static TRUTH: OnceLock<Vec<f64>> = OnceLock::new();
    TRUTH.get_or_init(|| light(&mut renderer(request, TRUTH_SAMPLES, 9, &[])))
}

pub fn noise(request: &Request) {
    let truth = truth(request);
    let raw = light(&mut renderer(request, SAMPLES, 0, &[]));
    let spatial = light(&mut renderer(request, SAMPLES, 0, &["denoise=spatial"]));
    let ratio = mean(&spatial) / mean(&raw);
    assert!((ratio - 1.0).abs() < ENERGY, "energy {ratio}");
    let [raw, spatial] = [raw, spatial].map(|light| error(&light, truth));
    assert!(spatial < SPATIAL * raw, "{spatial} of {raw} are left");
}

pub fn frames(request: &Request) {
    let truth = truth(request);
    let sequence = || {
        let mut renderer = renderer(request, 1, 0, &["denoise=temporal", "alpha=0.02"]);
        let frame = |_| {
            renderer.restart().unwrap();
            light(&mut renderer)
        };
        (0..FRAMES).map(frame).collect::<Vec<_>>()
    };
    let found = sequence();
    assert_eq!(found, sequence(), "equal sequences give equal bits");
    let last = &found[FRAMES as usize - 1];
    let raw = error(&light(&mut renderer(request, 1, 0, &[])), truth);
    let ratio = mean(last) / mean(truth);
    assert!((ratio - 1.0).abs() < 2.0 * ENERGY, "energy {ratio}");
    assert!(error(last, truth) < TEMPORAL * raw, "{} of {raw} are left", error(last, truth));
}
