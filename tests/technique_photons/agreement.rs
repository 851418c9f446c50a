//! Ways to the same picture, and what moves it.

use nephroid::frame::{Frame, Sampling, VisiblePoint};
use nephroid::gpu::{Binding, Recorder};
use nephroid::gpu_scene::GpuScene;
use nephroid::render::{Picture, RenderSettings};
use nephroid::technique::photons::Photons;
use nephroid::technique::{Context, Settings, Technique, TechniqueKind};
use nephroid::trace::{self, TraceChoice};
use nephroid::view::{Band, View};

use crate::common::sequence::{self, bits};
use crate::common::{Request, assert_valid, layer};
use crate::{assert_sound, counter, difference, load, pool, render, sum, watts};

/// RMS difference over the mean: a triangle's edge that another way sees elsewhere by rounding.
const TIERS: f64 = 0.02;
/// Of the light that lands.
const LANDED: f64 = 1e-4;

fn assert_same(what: &str, picture: &Picture, truth: &Picture) {
    let [found, expected] = [picture, truth].map(|picture| layer(&picture.image, "caustic"));
    let error = difference(&found, &expected);
    let landed = watts(picture, "landed") / watts(truth, "landed") - 1.0;
    println!("{what}: {error:.1e}, landed {landed:.1e} more");
    assert!(error < TIERS, "{what}: the picture differs by {error}");
    assert!(landed.abs() < LANDED, "{what}: {landed} more lands");
}

pub fn tiers(request: &Request) {
    for rescue in ["off", "rays"] {
        let set = [&format!("photons.rescue={rescue}")[..]];
        let picture = |change: &dyn Fn(&mut RenderSettings)| {
            let picture = render(request, load("cornell_flooded.toml"), &set, change);
            assert_sound(&picture);
            picture
        };
        let truth = picture(&|_| {});
        assert!(sum(&layer(&truth.image, "caustic")) > 0.0);
        for disable in ["precise-raster", "graphics"] {
            let other = picture(&|s| s.device = request.without(disable));
            assert_same(&format!("rescue {rescue}, without {disable}"), &other, &truth);
        }
        // Those that a device lacks are tested where they are there.
        let ray_query = request.info.capabilities.has(nephroid::gpu::Capability::RayQuery);
        for trace in if ray_query { &["cwbvh", "ray-query"][..] } else { &["cwbvh"] } {
            let other = picture(&|s| s.trace = trace.parse().unwrap());
            assert_same(&format!("rescue {rescue}, by {trace}"), &other, &truth);
        }
    }
}

/// Photons of the pool's first set that hit something in the light's view and in the camera's: the same on lavapipe and on SwiftShader.
const HITS: [f64; 2] = [11_308.0, 192.0];
/// What rounding may turn: a photon that passes by an edge.
const TURNED: f64 = 2e-4;

pub fn drivers(request: &Request) {
    for disable in ["", "graphics"] {
        let picture = render(request, pool(), &[], |s| s.device = request.without(disable));
        for (name, expected) in ["light_hits", "camera_hits"].into_iter().zip(HITS) {
            let found = counter(&picture, name);
            println!("without \"{disable}\": {found} {name}");
            let traced = counter(&picture, "photons_traced");
            assert!((found - expected).abs() < TURNED * traced, "{found} {name}, not {expected}");
        }
    }
}

pub fn equal_bits(request: &Request) {
    let picture = |set: &[&str], seed: u32| {
        let set = [&["photons.rescue=rays"], set].concat();
        render(request, load("cornell_flooded.toml"), &set, |s| {
            s.seed = seed;
            s.samples = Some(3);
        })
    };
    let first = picture(&[], 7);
    assert!(bits(&first) == bits(&picture(&[], 7)), "equal seeds gave different bits");
    let other = picture(&[], 8);
    assert!(bits(&first) != bits(&other), "the seed has no effect");
    assert!(watts(&first, "landed") != watts(&other, "landed"), "the seed does not move photons");
    // Sums are of integers: in which order photons are followed changes nothing.
    assert!(bits(&first) == bits(&picture(&["photons.order=shuffled"], 7)), "the order changes the picture");
    // Three samples of one set have its ledger.
    let reused = picture(&["photons.reuse=4"], 7);
    let traced = counter(&first, "photons_traced") / counter(&reused, "photons_traced");
    assert!((traced / 3.0 - 1.0).abs() < 0.02, "{traced} times the photons without reuse");
    assert!((watts(&reused, "emitted") / watts(&first, "emitted") - 1.0).abs() < 1e-3);
}

pub fn frame_alone(request: &Request) {
    let settings = RenderSettings {
        device: request.device.clone(),
        trace: "bvh".parse().unwrap(),
        technique: TechniqueKind::Photons,
        camera: Some("under".to_string()),
        size: Some((24, 18)),
        samples: Some(2),
        set: ["photons.photons=20000", "photons.resolution=128", "photons.rescue=rays"].map(String::from).to_vec(),
        ..Default::default()
    };
    let [first, alone] = sequence::frame_alone(request, pool, &settings);
    let moved = difference(&layer(&first.image, "caustic"), &layer(&alone.image, "caustic"));
    assert!(moved > 0.1, "five frames moved the light by {moved}");
}

/// Each slot's light in the second sample of some rows of a picture.
fn light_of(request: &Request, size: (u32, u32), band: Band) -> Vec<[f32; 4]> {
    let (device, scene) = (request.open(), load("cornell_flooded.toml"));
    let gpu_scene = GpuScene::new(&device, &scene).unwrap();
    let (tracer, _) = trace::choose(&device, &scene, &gpu_scene, TraceChoice::Bvh).unwrap();
    let view = View::new(&scene.cameras[0], &scene.film, size, band).of(&scene);
    let mut frame = Frame::new(&device, &gpu_scene, &tracer, &view, Sampling::Uniform).unwrap();
    let set = ["photons.photons=20000", "photons.resolution=128", "photons.rescue=rays"].map(String::from);
    let settings = Settings::parse(TechniqueKind::Photons, &set).unwrap();
    let mut photons =
        Photons::new(&settings, &Context { device: &device, scene: &scene, tracer: &tracer, frame: &frame, seed: 3 })
            .unwrap();
    for index in 0..2 {
        let mut recorder = Recorder::new(&device).unwrap();
        frame.record(&mut recorder, index).unwrap();
        photons.record(&frame, &mut recorder, index).unwrap();
        recorder.submit().unwrap();
    }
    assert_valid(&device);
    let buffer = |block: &str| match frame.bindings.get(block) {
        Some(Binding::Buffer(buffer)) => buffer.clone(),
        _ => panic!("no buffer {block}"),
    };
    let slots = frame.slots() as usize;
    let points: Vec<VisiblePoint> = buffer("VisiblePoints").read(slots).unwrap();
    let light: Vec<[f32; 4]> = buffer("SampleIrradiance").read(slots).unwrap();
    // What a slot without a point has is nobody's.
    points.iter().zip(light).map(|(point, light)| if point.instance == u32::MAX { [0.0; 4] } else { light }).collect()
}

pub fn bands(request: &Request) {
    let size = (24, 18);
    let whole = light_of(request, size, Band { first: 0, count: 18 });
    assert!(whole.iter().any(|light| light[1] > 0.0));
    let [upper, lower] = [Band { first: 0, count: 7 }, Band { first: 7, count: 11 }];
    let parts = [upper, lower].map(|band| light_of(request, size, band));
    // Slots are by layer, then by row.
    for layer in 0..2 {
        for row in 0..18usize {
            let (part, first, count) = if row < 7 { (&parts[0], 0, 7) } else { (&parts[1], 7, 11) };
            let at = 24 * (layer * 18 + row);
            let in_part = 24 * (layer * count + row - first);
            assert_eq!(whole[at..at + 24], part[in_part..in_part + 24], "layer {layer}, row {row}");
        }
    }
}

pub fn adaptive(request: &Request) {
    let picture = |adaptive: bool| {
        let picture = render(request, load("cornell_flooded.toml"), &["photons.rescue=rays"], |s| {
            s.samples = Some(8);
            s.adaptive = adaptive;
        });
        assert_sound(&picture);
        picture
    };
    let [uniform, adaptive] = [false, true].map(picture);
    assert!(adaptive.stats.adaptive.is_some());
    let [expected, found] = [&uniform, &adaptive].map(|picture| layer(&picture.image, "caustic"));
    let ratio = sum(&found) / sum(&expected);
    println!("adaptive: {ratio} of the light, difference {:.2e}", difference(&found, &expected));
    // The same light from the same photons, in other samples of pixels.
    assert!((ratio - 1.0).abs() < 0.03, "{ratio} of the light");
}
