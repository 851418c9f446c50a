//! No light, odd settings, other scales, and media.

use std::path::Path;

use nephroid::render::Picture;
use nephroid::scene::{self, Scene};

use crate::common::{Request, layer};
use crate::flat::{even_scene, mirror_scene};
use crate::{assert_finite, assert_sound, changed, counter, pool, render, sum, watts};

const LAMP: &str = "kind = \"point\"\nposition = [1.5, 6, -1]\nintensity = 100";
const WATER: &str = "kind = \"dielectric\"\nfront = \"air\"\nback = \"water\"";

fn told(picture: &Picture, what: &str) -> bool {
    picture.stats.warnings.iter().any(|warning| warning.contains(what))
}

pub fn nothing(request: &Request) {
    let spot = "kind = \"spot\"\nposition = [1.5, 6, -1]\ntarget = [1.5, 9, -1]\nouter = 30\nintensity = 100";
    let dark = LAMP.replace("intensity = 100", "intensity = 0");
    for (what, scene) in [
        ("a spot that looks away", changed("flat_water.toml", &[(LAMP, spot)])),
        ("a lamp that is off", changed("flat_water.toml", &[(LAMP, &dark)])),
        ("no water", changed("flat_water.toml", &[(WATER, "kind = \"diffuse\"\nalbedo = 0.5")])),
    ] {
        let picture = render(request, scene, &[], |_| {});
        assert_sound(&picture);
        assert_eq!(sum(&layer(&picture.image, "caustic")), 0.0, "{what}");
        assert!(told(&picture, "no light reaches a specular object"), "{what}: {:?}", picture.stats.warnings);
    }
    // Nothing but water.
    let text = std::fs::read_to_string("scenes/flat_water.toml").unwrap();
    let objects =
        text.find("[[object]]\nname = \"floor\"").unwrap()..text.find("[[object]]\nname = \"water\"").unwrap();
    let bare = format!("{}{}", &text[..objects.start], &text[objects.end..]);
    let scene = scene::parse(&bare, Path::new("scenes/flat_water.toml")).unwrap();
    for rescue in ["photons.rescue=off", "photons.rescue=rays"] {
        let picture = render(request, scene.clone(), &[rescue], |_| {});
        assert_sound(&picture);
        assert_eq!(sum(&layer(&picture.image, "caustic")), 0.0, "{rescue}");
        assert_eq!(watts(&picture, "landed"), 0.0, "{rescue}");
    }
    // The lamp in the water, and a camera that has all of it in its back.
    let under = LAMP.replace("6, -1]", "-0.5, -1]").replace("intensity = 100", "intensity = 100\nmedium = \"water\"");
    let away = "position = [0, -0.6, 3.5]\ntarget = [0, -0.7, 9]";
    for (what, scene, there) in [
        ("a lamp in the water", changed("flat_water.toml", &[(LAMP, &under)]), "landed"),
        (
            "behind the camera",
            changed("flat_water.toml", &[("position = [0, -0.6, 3.5]\ntarget = [0, -2, 0]", away)]),
            "hidden",
        ),
    ] {
        let picture = render(request, scene, &["photons.rescue=rays"], |_| {});
        assert_sound(&picture);
        println!("{what}: {:?}", picture.stats.ledger);
        assert!(watts(&picture, there) > 0.0, "{what}: nothing {there}");
        assert!(sum(&layer(&picture.image, "caustic")) > 0.0, "{what}: dark");
    }
}

pub fn settings(request: &Request) {
    let light = |set: &[&str], size: (u32, u32)| {
        let picture = render(request, pool(), &[set, &["photons.rescue=rays"]].concat(), |s| s.size = Some(size));
        println!("{set:?}, {size:?}: {:?}", picture.stats.ledger);
        assert_finite(&picture);
        assert!(watts(&picture, "landed") > 0.0, "{set:?}");
        picture
    };
    let mean = |picture: &Picture| {
        let pixels = layer(&picture.image, "caustic");
        sum(&pixels) / pixels.len() as f64
    };
    let expected = mean(&light(&[], (24, 18)));
    for set in [
        &["photons.resolution=16"][..],
        &["photons.margin=0"],
        &["photons.margin=1"],
        &["photons.thickness=0.5"],
        &["photons.cube=64"],
        &["photons.photons=64"],
    ] {
        let picture = light(set, (24, 18));
        assert_sound(&picture);
        let ratio = mean(&picture) / expected;
        println!("{set:?}: {ratio} of the light");
        let bound = match set[0] {
            // Eight by eight of them, over all of the water.
            "photons.photons=64" => 0.6,
            // Texels of 0.75 m, as thick as wide: light that passes over the walls ends in them.
            "photons.resolution=16" => 0.25,
            _ => COARSE,
        };
        assert!((ratio - 1.0).abs() < bound, "{set:?}: {ratio} of the light");
    }
    assert_sound(&light(&[], (1, 1)));
    assert_sound(&light(&["photons.resolution=16"], (1, 37)));
    // So few steps end marches before they are over, and that is said.
    let cut = light(&["photons.steps=16", "photons.march=linear"], (24, 18));
    assert!(counter(&cut, "marches_cut") > 0.0);
    assert!(told(&cut, "photons.steps"), "{:?}", cut.stats.warnings);
}

/// Of views of few texels, and of places that they do not show, in the mean over the picture.
const COARSE: f64 = 0.05;

/// Everything `times` as large, and the lamp by its square, so that irradiance stays.
fn scaled(times: f32) -> Scene {
    let waves = ("motion = { kind = \"waves\", depth = 2 }\n", "");
    let mut scene = changed("pool.toml", &[("[256, 256]", "[64, 64]"), waves]);
    for mesh in &mut scene.meshes {
        mesh.positions.iter_mut().for_each(|p| *p *= times);
    }
    for camera in &mut scene.cameras {
        camera.position *= times;
        camera.target *= times;
    }
    for light in &mut scene.lights {
        if let scene::Emitter::Point { position, intensity } = &mut light.emitter {
            *position *= times;
            *intensity *= times * times;
        }
    }
    scene
}

/// By how much pictures of another scale differ: rounding, and where cubes lie.
const SCALE: f64 = 0.05;

pub fn scales(request: &Request) {
    let picture = |times: f32| {
        let picture = render(request, scaled(times), &["photons.rescue=rays"], |_| {});
        assert_sound(&picture);
        (sum(&layer(&picture.image, "caustic")), watts(&picture, "landed") / watts(&picture, "emitted"))
    };
    let (light, landed) = picture(1.0);
    for times in [1e-3, 1e3] {
        let (other, part) = picture(times);
        println!("{times} times as large: {} of the light, {part} of it lands, {landed} before", other / light);
        assert!((other / light - 1.0).abs() < SCALE, "{times} times as large: {} of the light", other / light);
        assert!((part - landed).abs() < 0.01, "{times} times as large: {part} lands, not {landed}");
    }
}

pub fn media(request: &Request) {
    // Rough mirrors to the cut-off, and beyond it, and how light tends to what a smooth one sends.
    let light = |roughness: &str| {
        let mut scene = mirror_scene(0.9);
        if !roughness.is_empty() {
            let text = format!("kind = \"rough\"\nroughness = {roughness}\n");
            let path = Path::new("test.toml");
            scene = scene::parse(
                &crate::flat::MIRROR.replace("kind = \"mirror\"", &text).replace("REFLECTANCE", "0.9"),
                path,
            )
            .unwrap();
        }
        let picture = render(request, scene, &["photons.rescue=rays"], |s| s.samples = Some(2));
        assert_sound(&picture);
        println!("roughness {roughness}: {:?}", picture.stats.ledger);
        (sum(&layer(&picture.image, "caustic")), watts(&picture, "rough"))
    };
    let (smooth, _) = light("");
    let (silky, none) = light("0.05");
    assert_eq!(none, 0.0);
    assert!((silky / smooth - 1.0).abs() < 0.03, "{} of a smooth mirror's light", silky / smooth);
    assert!(light("0.29").0 > 0.2 * smooth);
    let (dark, rough) = light("0.31");
    assert_eq!(dark, 0.0, "rougher than the cut-off, and it shines");
    assert!(rough > 0.0);

    // 1.5 m and more of water, straight down.
    let mut scene = even_scene(90.0);
    let clear = sum(&layer(&render(request, scene.clone(), &[], |_| {}).image, "caustic"));
    let water = scene.media.iter().position(|m| m.name == "water").unwrap();
    scene.media[water].absorption = glam::Vec3::splat(0.2);
    scene.media[water].scattering = glam::Vec3::splat(0.1);
    let picture = render(request, scene, &["photons.rescue=rays"], |_| {});
    assert_sound(&picture);
    let left = sum(&layer(&picture.image, "caustic")) / clear;
    let expected = (-0.6f64).exp();
    println!("{left} of the light is left, {expected} expected");
    assert!((left / expected - 1.0).abs() < 0.01, "{left} of the light is left, not {expected}");
    assert!((watts(&picture, "absorbed") / watts(&picture, "scattered") / 2.0 - 1.0).abs() < 0.01);
    let thick = changed("cornell_flooded.toml", &[("index = 2.4", "index = 2.4\nabsorption = 10000")]);
    let picture = render(request, thick, &["photons.rescue=rays"], |_| {});
    assert_sound(&picture);
    let part = watts(&picture, "absorbed") / watts(&picture, "emitted");
    assert!(part > 0.5, "{part} of the light is absorbed");
}
