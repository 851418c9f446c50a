//! Adaptive sampling: samples go where pixels vary, all of the budget and no more, and means stay unbiased.

mod common;

use std::path::Path;
use std::process::ExitCode;

use common::text::FLOOR;
use common::{Case, Request, assert_valid, layer};
use nephroid::film::{self, SampleCounts};
use nephroid::frame::{Frame, Sampling};
use nephroid::gpu::{Device, Kernel, Recorder};
use nephroid::gpu_scene::GpuScene;
use nephroid::image::LayeredImage;
use nephroid::scene::{self, Scene};
use nephroid::trace::{self, TraceChoice};
use nephroid::view::{Band, View};

/// Pixels each way: enough that the mean over a quarter of them has a standard error of about 4 %.
const SIDE: u32 = 128;
/// Of the estimate's own standard error. Counts chosen from a pixel's own pilot are off by half a dozen of them and more.
const SIGMAS: f64 = 4.0;
/// Rounding of f32 over a path and a sum of a few samples.
const CLOSED_FORM: f32 = 1e-4;

fn main() -> ExitCode {
    common::run(&[
        Case { name: "spikes_keep_their_mean", needs: &[], disable: "", run: unbiased },
        Case { name: "the_budget_goes_where_pixels_vary", needs: &[], disable: "", run: budget },
        Case { name: "every_layer_is_a_mean_over_the_pixels_own_samples", needs: &[], disable: "", run: layers },
        Case { name: "equal_seeds_give_equal_bits_adaptively", needs: &[], disable: "", run: equal_bits },
    ])
}

/// The floor, lit, and close enough to show nothing else.
fn floor() -> Scene {
    let sun = "[[light]]\nname = \"sun\"\nkind = \"directional\"\ndirection = [0, -1, 0]\nirradiance = [1, 2, 3]\n";
    let text = format!("{}{sun}", FLOOR.replace("fov_y = 60", "fov_y = 1"));
    scene::parse(&text, Path::new("test.toml")).unwrap()
}

/// A picture of `selftest/spikes` and how many samples each pixel got.
struct Rendered {
    image: LayeredImage,
    counts: SampleCounts,
    noise: f32,
}

impl Rendered {
    /// Caustic irradiance of the columns that hold the same: 0 spikes, 1 steps, 2 and 3 nothing.
    fn columns(&self, kind: usize) -> Vec<f64> {
        let pixels = layer(&self.image, "caustic");
        pixels
            .iter()
            .enumerate()
            .filter(|(p, _)| p % SIDE as usize / 8 % 4 == kind)
            .map(|(_, v)| f64::from(v[0]))
            .collect()
    }

    fn mean_count(&self, kind: usize) -> f64 {
        let of_kind = (0..(SIDE * SIDE) as usize).filter(|p| p % SIDE as usize / 8 % 4 == kind);
        of_kind.map(|p| f64::from(self.counts.of(p))).sum::<f64>() * 4.0 / f64::from(SIDE * SIDE)
    }
}

/// `rounds` of `samples` samples a pixel.
fn spikes(request: &Request, samples: u32, rounds: u32, seed: u32) -> Rendered {
    let scene = floor();
    let device: Device = request.open();
    let gpu_scene = GpuScene::new(&device, &scene).unwrap();
    let (tracer, _) = trace::choose(&device, &scene, &gpu_scene, TraceChoice::Bvh).unwrap();
    let view = View {
        seed,
        lights: 1,
        ..View::new(&scene.cameras[0], &scene.film, (SIDE, SIDE), Band { first: 0, count: SIDE })
    };
    let mut frame = Frame::new(&device, &gpu_scene, &tracer, &view, Sampling::Adaptive { samples }).unwrap();
    let kernel = Kernel::new(&device, "selftest/spikes", "").unwrap();
    for index in 0..rounds {
        let mut recorder = Recorder::new(&device).unwrap();
        frame.record(&mut recorder, index).unwrap();
        let mut pass = recorder.pass("selftest/spikes").unwrap();
        pass.dispatch(&kernel, &[&frame.bindings], &(), frame.slots()).unwrap();
        drop(pass);
        frame.record_caustic(&mut recorder, index).unwrap();
        recorder.submit().unwrap();
    }
    let counts = frame.sample_counts(rounds);
    let rows = frame.film.read(&counts).unwrap();
    let noise = frame.film.noise(&counts, |samples| Some(samples / 2)).unwrap().unwrap();
    assert_valid(&device);
    Rendered { image: film::assemble(SIDE as usize, SIDE as usize, &[rows]), counts, noise }
}

fn unbiased(request: &Request) {
    // Every pixel is a trial of its own, since every pixel has its own sequence. Two samples of pilot see a spike in
    // every thirtieth pixel that has one, so what they saw decides nearly everything. Also when stopped half way.
    for (samples, rounds) in [(8, 8), (8, 5)] {
        let rendered = spikes(request, samples, rounds, 1);
        for kind in [0, 1] {
            let values = rendered.columns(kind);
            let count = values.len() as f64;
            let mean = values.iter().sum::<f64>() / count;
            let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count;
            let error = (variance / count).sqrt();
            println!("{rounds} of {samples} samples, kind {kind}: {mean:.4} +- {error:.4}");
            assert!((mean - 1.0).abs() < SIGMAS * error, "kind {kind}: mean {mean}, standard error {error}");
        }
        assert!(rendered.columns(2).iter().all(|v| (v - 1.0).abs() < 1e-6), "even pixels are exact");
    }
}

fn budget(request: &Request) {
    let rendered = spikes(request, 16, 16, 3);
    let [spike, step, even] = [0, 1, 3].map(|kind| rendered.mean_count(kind));
    println!("samples of spikes {spike:.1}, steps {step:.1}, even {even:.1}");
    let total: u64 = (0..(SIDE * SIDE) as usize).map(|p| u64::from(rendered.counts.of(p))).sum();
    assert_eq!(total, u64::from(16 * SIDE * SIDE));
    // A spike's standard deviation is eight times a step's. Pixels that need no more than the pilot get no more.
    assert!(spike > 3.0 * step && step < 1.5 * even, "spikes {spike}, steps {step}, even {even}");
    // The halves of stratified samples tell more noise than there is, and here two halves of rare spikes about as much.
    let square = |kind: usize| rendered.columns(kind).iter().map(|v| (v - 1.0).powi(2)).sum::<f64>();
    let error = ((0..4).map(square).sum::<f64>() / f64::from(SIDE * SIDE)).sqrt();
    let ratio = f64::from(rendered.noise) / error;
    println!("noise {:.4}, true error {error:.4}", rendered.noise);
    assert!((0.9..1.6).contains(&ratio), "noise {} against {error}", rendered.noise);
}

fn layers(request: &Request) {
    let Rendered { image, .. } = spikes(request, 6, 6, 2);
    let expect = |name: &str, expected: [f32; 3]| {
        for value in layer(&image, name) {
            for c in 0..3 {
                let error = (value[c] - expected[c]).abs();
                assert!(error <= CLOSED_FORM * expected[c].max(1.0), "{name}: {value:?} instead of {expected:?}");
            }
        }
    };
    expect("direct", [1.0, 2.0, 3.0].map(|e| e * 0.5 / std::f32::consts::PI));
    expect("albedo", [0.5; 3]);
    expect("reflected", [0.0; 3]);
    let normal = &image.layer("normal").unwrap().channels;
    for (channel, expected) in normal.iter().zip([0.0, 1.0, 0.0]) {
        assert!(channel.samples.iter().all(|v| (v - expected).abs() < CLOSED_FORM), "normal {}", channel.name);
    }
    let (caustic, refracted) = (layer(&image, "caustic"), layer(&image, "refracted"));
    for (irradiance, radiance) in caustic.iter().zip(&refracted) {
        let expected = (irradiance[0] + 1.0) * 0.5 / std::f32::consts::PI;
        assert!((radiance[0] - expected).abs() <= CLOSED_FORM * expected, "{} instead of {expected}", radiance[0]);
    }
}

fn equal_bits(request: &Request) {
    let bits = |seed| -> Vec<u32> {
        let pixels = layer(&spikes(request, 6, 6, seed).image, "caustic");
        pixels.into_iter().flatten().map(f32::to_bits).collect()
    };
    let first = bits(7);
    assert!(first == bits(7), "equal seeds gave different bits");
    assert!(first != bits(8), "the seed has no effect");
}
