//! The shared part of the frame: visibility, the walk through specular surfaces, direct light.

mod common;

use std::path::Path;
use std::process::ExitCode;

use common::text::FLOOR;
use common::{Case, Request, assert_valid, layer};
use nephroid::display::{Display, Look};
use nephroid::film::{self, SampleCounts};
use nephroid::frame::{Frame, Sampling};
use nephroid::gpu::{Bindings, Buffer, Capability, Kernel, Recorder};
use nephroid::gpu_scene::GpuScene;
use nephroid::image::{FINAL_LAYER, LayeredImage, tone};
use nephroid::random;
use nephroid::render::{RenderSettings, Renderer};
use nephroid::scene::{self, Scene, ToneCurve};
use nephroid::technique::TechniqueKind;
use nephroid::trace::{self, TraceChoice};
use nephroid::view::{Band, View};

/// Rounding of f32 over a path of a few surfaces; a wrong cosine or factor is far above it.
const CLOSED_FORM: f32 = 1e-4;
/// Tiers see the same surfaces; they may disagree on single pixels whose centre meets an edge.
const TIERS: f64 = 1e-3;

fn main() -> ExitCode {
    common::run(&[
        Case { name: "direct_light_is_the_closed_form", needs: &[], disable: "", run: direct_light },
        Case { name: "direct_light_is_absorbed_on_both_legs", needs: &[], disable: "", run: absorption },
        Case { name: "a_wall_of_water_shows_n_squared_and_fresnel", needs: &[], disable: "", run: n_squared },
        Case { name: "total_reflection_and_mirrors_lose_nothing", needs: &[], disable: "", run: total_reflection },
        Case { name: "a_rough_mirror_in_a_furnace_is_white", needs: &[], disable: "", run: rough_furnace },
        Case { name: "a_textured_plane_shows_its_texture", needs: &[], disable: "", run: texture },
        Case { name: "specular_surfaces_block_direct_light", needs: &[], disable: "", run: blocked },
        Case {
            name: "raster_and_rays_see_the_same",
            needs: &[Capability::PreciseRaster],
            disable: "",
            run: raster_and_rays,
        },
        Case { name: "back_ends_give_the_same_picture", needs: &[], disable: "", run: back_ends },
        Case { name: "devices_give_the_same_picture", needs: &[], disable: "", run: devices },
        Case { name: "caustic_samples_make_a_mean", needs: &[], disable: "", run: caustic_mean },
        Case { name: "random_numbers_are_the_hosts", needs: &[], disable: "", run: random_numbers },
        Case { name: "a_screen_shows_what_a_png_holds", needs: &[], disable: "", run: display },
        Case { name: "equal_seeds_give_equal_bits", needs: &[], disable: "", run: equal_bits },
    ])
}

fn parse(text: &str) -> Scene {
    scene::parse(text, Path::new("test.toml")).unwrap()
}

/// Without a technique and with few samples, unless `change` says otherwise.
fn render(request: &Request, scene: Scene, change: impl FnOnce(&mut RenderSettings)) -> LayeredImage {
    let picture = request.render(scene, |settings| {
        settings.technique = TechniqueKind::None;
        settings.samples = Some(4);
        change(settings);
    });
    picture.image
}

/// RMS difference over the RMS of `truth`.
fn relative(test: &[[f32; 3]], truth: &[[f32; 3]]) -> f64 {
    let square = |a: &[f32; 3], b: &[f32; 3]| (0..3).map(|c| f64::from(a[c] - b[c]).powi(2)).sum::<f64>();
    let error: f64 = test.iter().zip(truth).map(|(a, b)| square(a, b)).sum();
    let size: f64 = truth.iter().map(|b| square(b, &[0.0; 3])).sum();
    (error / size.max(1e-300)).sqrt()
}

/// Water on the floor, with a lamp in it and one above: one's light is direct, the other's caustic.
const WATER: &str = r#"
[[medium]]
name = "water"
index = 1.33
[[material]]
name = "surface"
kind = "dielectric"
front = "air"
back = "water"
[[object]]
name = "surface"
shape = "plane"
centre = [0, 0.4, 0]
size = [100, 100]
material = "surface"
[[light]]
name = "below"
kind = "point"
position = [2, 0.3, 1]
intensity = [3, 1, 0.2]
medium = "water"
[[light]]
name = "above"
kind = "point"
position = [-1.5, 0.7, -0.5]
intensity = [0.6, 1, 2]
"#;

/// A floor whose light falls off from far above what a screen shows to almost nothing, in three colours.
fn display(request: &Request) {
    let scene = parse(&format!("{FLOOR}{WATER}"));
    let settings = RenderSettings {
        device: request.device.clone(),
        technique: TechniqueKind::Mnee,
        size: Some((32, 24)),
        samples: Some(3),
        ..Default::default()
    };
    let mut renderer = Renderer::new(scene, &settings).unwrap();
    for _ in 0..3 {
        renderer.sample().unwrap();
    }
    let mut display = Display::new(renderer.device()).unwrap();
    let image = renderer.finish().unwrap().image;
    let truth = layer(&image, FINAL_LAYER);
    let lit = layer(&image, "caustic").iter().filter(|p| p[2] > 0.01).count();
    assert!(lit > 9, "{lit} pixels have caustic light");
    for (tone_curve, exposure) in [(ToneCurve::Linear, 0.0), (ToneCurve::Reinhard, 1.5)] {
        let shown = renderer.display(&mut display, Look { exposure, tone_curve }).unwrap();
        let png = tone::display(&truth, exposure, tone::curve(tone_curve));
        let (dark, bright) = (png.iter().filter(|p| p[0] < 64).count(), png.iter().filter(|p| p[0] > 192).count());
        assert!(dark > 9 && bright > 9 && shown.len() == png.len(), "{dark} {bright}");
        for (shown, png) in shown.iter().zip(&png) {
            // A device's pow may round the other way.
            assert!((0..3).all(|c| shown[c].abs_diff(png[c]) <= 1) && shown[3] == 255, "{shown:?} {png:?}");
        }
    }
    assert_valid(renderer.device());
}

/// A pixel so small that its centre stands for it.
fn tiny(settings: &mut RenderSettings) {
    settings.size = Some((1, 1));
}

fn direct_light(request: &Request) {
    // (light, irradiance below the camera): I cos / d^2, the spot's fall-off, E cos.
    let half_way = 0.5f32; // smoothstep at the middle of its range
    let cases = [
        ("kind = \"point\"\nposition = [3, 4, 0]\nintensity = [25, 50, 100]".to_string(), [1.0, 2.0, 4.0], 0.8),
        (
            {
                let (outer, inner) = (60f32, 20f32);
                let middle = (outer.to_radians().cos() + inner.to_radians().cos()) / 2.0;
                // The point below the camera lies where the cosine to the axis is half way between the two.
                let angle = middle.acos();
                format!(
                    "kind = \"spot\"\nposition = [0, 4, 0]\ntarget = [{}, 0, 0]\nintensity = 16\nouter = {outer}\n\
                     inner = {inner}",
                    4.0 * angle.tan()
                )
            },
            [half_way; 3],
            1.0,
        ),
        ("kind = \"directional\"\ndirection = [3, -4, 0]\nirradiance = [1, 2, 3]".to_string(), [1.0, 2.0, 3.0], 0.8),
    ];
    for (light, irradiance, cosine) in cases {
        let scene = parse(&format!("{FLOOR}\n[[light]]\nname = \"l\"\n{light}\n"));
        // A tenth of a degree: the light hardly varies over it.
        let mut scene = scene;
        scene.cameras[0].fov_y = 0.1;
        let found = layer(&render(request, scene, tiny), "direct")[0];
        for c in 0..3 {
            let expected = irradiance[c] * cosine * 0.5 / std::f32::consts::PI;
            let error = (found[c] / expected - 1.0).abs();
            // The field of view is 7 mm wide on the floor.
            assert!(error < 2e-3, "{light}: {} instead of {expected}", found[c]);
        }
    }
}

fn absorption(request: &Request) {
    let scene = |absorption: &str| {
        let medium = format!("[[medium]]\nname = \"ink\"\nindex = 1.33\nabsorption = {absorption}\n");
        let light =
            "[[light]]\nname = \"l\"\nkind = \"point\"\nposition = [3, 4, 0]\nintensity = 100\nmedium = \"ink\"\n";
        let text = format!("{FLOOR}{medium}{light}").replace("fov_y = 60", "fov_y = 0.1\nmedium = \"ink\"");
        parse(&text)
    };
    let clear = layer(&render(request, scene("0"), tiny), "direct")[0];
    let inky = layer(&render(request, scene("[0.1, 0.2, 0.4]"), tiny), "direct")[0];
    for (c, sigma) in [0.1f32, 0.2, 0.4].into_iter().enumerate() {
        let expected = (-sigma * (4.0 + 5.0)).exp();
        let error = (inky[c] / clear[c] / expected - 1.0).abs();
        assert!(error < CLOSED_FORM, "channel {c}: {} instead of {expected}", inky[c] / clear[c]);
    }
}

const WINDOW: &str = r#"
[film]
background = 1
[[camera]]
name = "c"
position = [0, -1, 0]
target = [0, 0, 0]
up = [0, 0, -1]
fov_y = 0.1
medium = "water"
[[medium]]
name = "water"
index = 1.33
[[material]]
name = "surface"
kind = "dielectric"
back = "water"
[[object]]
name = "surface"
shape = "plane"
centre = [0, 0, 0]
size = [1000, 1000]
material = "surface"
"#;

fn n_squared(request: &Request) {
    // Straight up from the water into a sky of radiance 1: T n^2 refracted, and what is reflected leaves downwards
    // into the sky below (there is no floor): F.
    let image = render(request, parse(WINDOW), tiny);
    let reflectance = (0.33f32 / 2.33).powi(2);
    let refracted = layer(&image, "refracted")[0][0];
    let reflected = layer(&image, "reflected")[0][0];
    assert!((refracted / ((1.0 - reflectance) * 1.33 * 1.33) - 1.0).abs() < CLOSED_FORM, "refracted {refracted}");
    assert!((reflected / reflectance - 1.0).abs() < 1e-3, "reflected {reflected}");
    assert!((layer(&image, "final")[0][0] - refracted - reflected).abs() < 1e-6);
}

fn total_reflection(request: &Request) {
    // 60 degrees from the vertical is past the critical 48.75: everything is reflected into the sky below.
    let steep = WINDOW.replace("target = [0, 0, 0]", "target = [1.7320508, 0, 0]");
    let image = render(request, parse(&steep), tiny);
    assert!((layer(&image, "refracted")[0][0] - 1.0).abs() < CLOSED_FORM, "the first layer holds the total reflection");
    assert_eq!(layer(&image, "reflected")[0][0], 0.0, "and is not split");

    let mirror = WINDOW.replace("kind = \"dielectric\"\nback = \"water\"", "kind = \"mirror\"\nreflectance = 0.7");
    let image = render(request, parse(&mirror), tiny);
    assert!((layer(&image, "final")[0][0] - 0.7).abs() < CLOSED_FORM);
}

fn rough_furnace(request: &Request) {
    // In a white furnace a white rough mirror reflects what single-scattering GGX does: at most 1, and nearly 1 where
    // it is nearly smooth.
    let rough = |roughness: f32| {
        let kind = format!("kind = \"rough\"\nroughness = {roughness}");
        let text = WINDOW.replace("kind = \"dielectric\"\nback = \"water\"", &kind);
        layer(
            &render(request, parse(&text), |s| {
                s.size = Some((16, 16));
                s.samples = Some(16);
            }),
            "final",
        )
        .iter()
        .map(|p| f64::from(p[0]))
        .sum::<f64>()
            / 256.0
    };
    let (smooth, rougher) = (rough(0.1), rough(0.9));
    assert!((smooth - 1.0).abs() < 1e-3, "nearly smooth: {smooth}");
    // Directional albedo of GGX at alpha 0.81 and normal incidence without multiple scattering, by quadrature: 0.846.
    assert!((rougher - quadrature_ggx(0.81)).abs() < 0.01, "rough: {rougher} against {}", quadrature_ggx(0.81));
}

/// Directional albedo of the white GGX mirror at normal incidence, height-correlated Smith, by the midpoint rule over
/// the microfacet's angle.
fn quadrature_ggx(alpha: f64) -> f64 {
    let smith = |c: f64| 2.0 / (1.0 + (1.0 + alpha * alpha * (1.0 / (c * c) - 1.0)).sqrt());
    let steps = 100_000;
    (0..steps)
        .map(|i| {
            let theta = (f64::from(i) + 0.5) / f64::from(steps) * std::f64::consts::FRAC_PI_4; // beyond, light goes down
            let c = theta.cos();
            let d = alpha * alpha / (std::f64::consts::PI * (c * c * (alpha * alpha - 1.0) + 1.0).powi(2));
            let out = (2.0 * theta).cos();
            let (a, b) = (1.0, smith(out));
            let masking = a * b / (a + b - a * b);
            // Integral of D G / (4 cos_view cos_light) cos_light d(light), with d(light) = 4 c d(half way).
            d * masking * c * 2.0 * std::f64::consts::PI * theta.sin() * std::f64::consts::FRAC_PI_4 / f64::from(steps)
        })
        .sum()
}

fn texture(request: &Request) {
    let folder = tempfile::tempdir().unwrap();
    // Left half sRGB 255, right half sRGB 128 (linear 0.2159), green.
    let picture = image::RgbImage::from_fn(64, 64, |x, _| image::Rgb([0, if x < 32 { 255 } else { 128 }, 0]));
    picture.save(folder.path().join("t.png")).unwrap();
    let text = format!(
        "{}\n[[light]]\nname = \"sun\"\nkind = \"directional\"\ndirection = [0, -1, 0]\nirradiance = 1\n",
        FLOOR.replace("albedo = 0.5", "albedo = 0.5\ntexture = \"t.png\"").replace("[100, 100]", "[4, 4]")
    );
    let scene = scene::parse(&text, &folder.path().join("scene.toml")).unwrap();
    let image = render(request, scene, |s| s.size = Some((40, 30)));
    let albedo = layer(&image, "albedo");
    // The floor covers x from -2 to 2 of the 6.16 m that the picture is wide: pixels 7 to 33.
    let (left, right) = (albedo[15 * 40 + 12], albedo[15 * 40 + 28]);
    assert!((left[1] - 0.5).abs() < 2e-3 && left[0] == 0.0, "{left:?}");
    assert!((right[1] - 0.5 * 0.2159).abs() < 2e-3, "{right:?}");
}

fn blocked(request: &Request) {
    let scene = scene::load(Path::new("scenes/flat_water.toml")).unwrap();
    let image = render(request, scene, |s| s.size = Some((40, 30)));
    // All that the camera in the water sees is below the surface, where no light comes but through it.
    assert!(layer(&image, "direct").iter().flatten().all(|&v| v == 0.0));
}

/// Pool from both cameras, small.
fn pool(request: &Request, camera: &str, disable: &str, trace: &str) -> LayeredImage {
    let scene = scene::load(Path::new("scenes/pool.toml")).unwrap();
    render(request, scene, |s| {
        s.device = request.without(disable);
        s.trace = trace.parse().unwrap();
        s.camera = Some(camera.to_string());
        s.size = Some((96, 72));
    })
}

fn assert_same_layers(a: &LayeredImage, b: &LayeredImage, what: &str) {
    for name in ["direct", "albedo"] {
        let difference = relative(&layer(a, name), &layer(b, name));
        println!("{what} {name}: {difference:.2e}");
        assert!(difference < TIERS, "{what} {name}: {difference}");
    }
    for name in ["normal", "depth"] {
        let channels = |image: &LayeredImage| -> Vec<[f32; 3]> {
            let samples = image.layer(name).unwrap().channels.iter().flat_map(|c| c.samples.clone());
            samples.map(|s| [s; 3]).collect()
        };
        let difference = relative(&channels(a), &channels(b));
        println!("{what} {name}: {difference:.2e}");
        assert!(difference < TIERS, "{what} {name}: {difference}");
    }
}

fn raster_and_rays(request: &Request) {
    for camera in ["under", "above"] {
        let raster = pool(request, camera, "", "bvh");
        let rays = pool(request, camera, "graphics", "bvh");
        assert_same_layers(&raster, &rays, &format!("raster against rays, {camera}"));
    }
}

fn back_ends(request: &Request) {
    let truth = pool(request, "above", "graphics", "cwbvh");
    assert_same_layers(&pool(request, "above", "graphics", "bvh2"), &truth, "bvh2 against cwbvh");
    if request.info.capabilities.has(Capability::RayQuery) {
        assert_same_layers(&pool(request, "above", "graphics", "ray-query"), &truth, "ray query against cwbvh");
    } else {
        println!("ray query is left out: the driver lacks ray-query");
    }
}

fn devices(request: &Request) {
    // Each device against the first, both without graphics and ray queries.
    let mut first = Request { info: request.info.clone(), device: request.device.clone() };
    first.device.device = Some("0".to_string());
    for camera in ["under", "above"] {
        let here = pool(request, camera, "graphics", "cwbvh");
        assert_same_layers(&here, &pool(&first, camera, "graphics", "cwbvh"), &format!("device 0, {camera}"));
    }
}

fn caustic_mean(request: &Request) {
    // Four samples of a constant irradiance, the third not a number: the mean of 1, 2, 0 and 4.
    let found = [1.0f32, 2.0, f32::NAN, 4.0];
    let mean = found.iter().filter(|e| e.is_finite()).sum::<f32>() / 4.0;
    let scene = parse(FLOOR);
    let device = request.open();
    let gpu_scene = GpuScene::new(&device, &scene).unwrap();
    let (tracer, _) = trace::choose(&device, &scene, &gpu_scene, TraceChoice::Bvh).unwrap();
    let band = Band { first: 0, count: 3 };
    let view = View::new(&scene.cameras[0], &scene.film, (4, 3), band);
    let mut frame = Frame::new(&device, &gpu_scene, &tracer, &view, Sampling::Uniform).unwrap();
    for (index, value) in (0u32..).zip(found) {
        let mut recorder = Recorder::new(&device).unwrap();
        frame.record(&mut recorder, index).unwrap();
        recorder.pass("test/irradiance").unwrap().fill(frame.film.sample_irradiance(), value.to_bits());
        frame.record_caustic(&mut recorder, index).unwrap();
        recorder.submit().unwrap();
    }
    let image = film::assemble(4, 3, &[frame.film.read(&SampleCounts::Same(4)).unwrap()]);
    // No lights: radiance is the caustic's alone, and only the first layer has points.
    for (layer_name, expected) in
        [("caustic", mean), ("refracted", mean * 0.5 / std::f32::consts::PI), ("reflected", 0.0)]
    {
        for value in layer(&image, layer_name).into_iter().flatten() {
            assert!((value - expected).abs() <= CLOSED_FORM * expected, "{layer_name}: {value} instead of {expected}");
        }
    }
    assert_eq!(frame.film.counters().unwrap().non_finite, 12, "one a pixel, in the layer that has points");
    // Odd samples: 2 and 4, mean 3; even: 1 and 0, mean 1/2. Half their difference over the mean of all.
    let noise = frame.film.noise(&SampleCounts::Same(4), |n| Some(n / 2)).unwrap().unwrap();
    assert!((noise - (3.0 - 0.5) / 2.0 / mean).abs() < CLOSED_FORM, "{noise}");
    assert_valid(&device);
}

fn random_numbers(request: &Request) {
    let (seed, count) = (99u32, 1u32 << 16);
    let device = request.open();
    let kernel = Kernel::new(&device, "selftest/random", "").unwrap();
    let points = Buffer::new(&device, "points", u64::from(count) * 8).unwrap();
    let mut recorder = Recorder::new(&device).unwrap();
    let bindings = Bindings::new().buffer("Points", &points);
    recorder.pass("selftest/random").unwrap().dispatch(&kernel, &[&bindings], &[seed, count], count).unwrap();
    recorder.submit().unwrap();
    let found: Vec<[f32; 2]> = points.read(count as usize).unwrap();
    for (index, point) in (0..count).zip(found) {
        assert_eq!(point, random::sample_2d(index, random::combine(seed, index / 256)), "point {index}");
    }
    assert_valid(&device);
}

fn equal_bits(request: &Request) {
    let bits = |seed: u32| -> Vec<u32> {
        let scene = scene::load(Path::new("scenes/pool.toml")).unwrap();
        let image = render(request, scene, |s| {
            s.camera = Some("above".to_string());
            s.size = Some((40, 30));
            s.technique = TechniqueKind::Reference;
            s.set = vec!["reference.photons=20000".to_string()];
            s.seed = seed;
        });
        image.layers.iter().flat_map(|l| &l.channels).flat_map(|c| &c.samples).map(|s| s.to_bits()).collect()
    };
    let first = bits(7);
    assert!(first == bits(7), "equal seeds gave different bits");
    assert!(first != bits(8), "the seed has no effect");
}
