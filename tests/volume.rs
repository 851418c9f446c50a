//! Media that scatter: light that comes straight from lamps, scattered once towards the camera, against f64 quadrature and
//! closed forms.

mod air;
mod common;

use std::path::Path;
use std::process::ExitCode;

use air::{Air, rays};
use common::{Case, Request, layer};
use glam::{DVec3, Vec3};
use nephroid::gpu::Capability;
use nephroid::random;
use nephroid::render::{Picture, RenderSettings};
use nephroid::scene::{self, Bounds, DensityGrid, Scene};
use nephroid::technique::TechniqueKind;

/// One pixel of 256 places a stretch, over the brightest one. 1e-2 at worst; a missing leg or factor is far above it.
const PIXEL: f64 = 2e-2;
/// Of the picture's mean, in which noise cancels: 1e-3 at worst.
const MEAN: f64 = 2e-3;
/// Rounding of f32.
const CLOSED_FORM: f64 = 1e-4;
/// Tiers see the same surfaces but for single pixels.
const TIERS: f64 = 1e-3;

const SIZE: (u32, u32) = (12, 9);

fn main() -> ExitCode {
    common::run(&[
        Case { name: "lamps_in_fog_are_the_quadrature", needs: &[], disable: "", run: lamps },
        Case { name: "spots_light_their_cone_of_fog", needs: &[], disable: "", run: spots },
        Case { name: "shadows_reach_through_fog", needs: &[], disable: "", run: shadow },
    ])
}

fn parse(text: &str) -> Scene {
    scene::parse(text, Path::new("test.toml")).unwrap()
}

/// A black wall across the view at z = -5.
const ROOM: &str = r#"
[film]
volume_samples = 256
[[camera]]
name = "c"
position = [0.3, 0.2, 5]
target = [0, 0, 0]
fov_y = 40
medium = "fog"
[[material]]
name = "wall"
kind = "diffuse"
albedo = 0
[[object]]
name = "wall"
shape = "plane"
centre = [0, 0, 0]
size = [100, 100]
material = "wall"
transform = { rotate = [90, 0, 0], translate = [0, 0, -5] }
"#;

fn fog(absorption: &str, scattering: &str, asymmetry: f64) -> String {
    format!(
        "[[medium]]\nname = \"fog\"\nindex = 1.0001\nabsorption = {absorption}\nscattering = {scattering}\nasymmetry = \
         {asymmetry}\n"
    )
}

/// One sample without a technique, whose places in the pixels are known.
fn render(request: &Request, scene: Scene, change: impl FnOnce(&mut RenderSettings)) -> Picture {
    request.render(scene, |settings| {
        settings.technique = TechniqueKind::None;
        settings.samples = Some(1);
        settings.size = Some(SIZE);
        change(settings);
    })
}

/// What each ray shows of the room's fog, `lit` from each light.
fn expected(scene: &Scene, lit: impl Fn(usize, DVec3) -> bool) -> Vec<[f64; 3]> {
    let camera = &scene.cameras[0];
    let from = camera.position.as_dvec3();
    let air = Air::of(scene, camera.medium);
    let see = |direction: DVec3| {
        let length = (-5.0 - from.z) / direction.z;
        let each = scene
            .lights
            .iter()
            .enumerate()
            .map(|(k, light)| air.light((from, direction, length), light, |at| lit(k, at)));
        each.fold([0.0; 3], |sum, light| std::array::from_fn(|c| sum[c] + light[c]))
    };
    rays(camera, SIZE).into_iter().map(see).collect()
}

/// Holds the pixels against `expected`; `what` is printed.
fn check(picture: &Picture, expected: &[[f64; 3]], what: &str) {
    let found = layer(&picture.image, "volume");
    let most = expected.iter().flatten().fold(0.0, |a: f64, &b| a.max(b));
    let differences = found.iter().zip(expected).flat_map(|(a, b)| (0..3).map(move |c| f64::from(a[c]) - b[c]));
    let worst = differences.map(f64::abs).fold(0.0, f64::max) / most;
    let sum =
        |c: usize| found.iter().map(|p| f64::from(p[c])).sum::<f64>() / expected.iter().map(|p| p[c]).sum::<f64>();
    let means = [0, 1, 2].map(sum);
    println!("{what}: worst {worst:.1e}, means {means:.5?}");
    assert!(most > 0.0 && worst < PIXEL, "{what}: {worst}");
    assert!(means.iter().all(|mean| (mean - 1.0).abs() < MEAN), "{what}: {means:?}");
    assert!(picture.stats.warnings.is_empty(), "{what}: {:?}", picture.stats.warnings);
}

const LAMPS: &str = r#"
[[light]]
name = "near"
kind = "point"
position = [0.8, 0.5, 1]
intensity = [3, 2, 1]
medium = "fog"
[[light]]
name = "behind"
kind = "point"
position = [-1, 1, 7]
intensity = [0, 5, 9]
medium = "fog"
"#;

fn lamps(request: &Request) {
    for (absorption, scattering, asymmetry) in [
        ("0", "0.05", 0.0),
        ("[0.02, 0.1, 0.3]", "[0.1, 0.05, 0.2]", 0.7),
        ("0.2", "[3, 1, 0.3]", -0.5),
        ("0", "20", 0.3),
    ] {
        let scene = parse(&format!("{ROOM}{}{LAMPS}", fog(absorption, scattering, asymmetry)));
        let expected = expected(&scene, |_, _| true);
        let what = format!("absorption {absorption}, scattering {scattering}, g {asymmetry}");
        check(&render(request, scene, |_| {}), &expected, &what);
    }
}

/// A spot light at each of several places, some of whose cones hold the camera or point away from it.
fn spots(request: &Request) {
    for (position, target, outer) in [
        ("[2, 3, 0]", "[0, 0, 0]", 15),
        ("[0, 0.5, 6]", "[0, 0, 0]", 40),
        ("[0.1, 0, -4]", "[0.3, 0.2, 5]", 30),
        ("[-3, 0, 2]", "[0, 0, 2]", 90),
        ("[1, 1, 1]", "[4, 4, 1]", 60),
    ] {
        let spot = format!(
            "[[light]]\nname = \"s\"\nkind = \"spot\"\nposition = {position}\ntarget = {target}\nintensity = [1, 2, 3]\n\
             outer = {outer}\ninner = {}\nmedium = \"fog\"\n",
            outer / 2
        );
        let scene = parse(&format!("{ROOM}{}{spot}", fog("0.05", "0.1", 0.4)));
        let expected = expected(&scene, |_, _| true);
        check(&render(request, scene, |_| {}), &expected, &format!("spot at {position}"));
    }
}

/// A black board between the near lamp and some of the view.
fn shadow(request: &Request) {
    let board = "[[object]]\nname = \"board\"\nshape = \"plane\"\nsize = [0.6, 0.6]\nmaterial = \"wall\"\n\
                 transform = { rotate = [0, 0, 90], translate = [0.6, 0.9, 0.9] }\n";
    let scene = parse(&format!("{ROOM}{board}{}{LAMPS}", fog("0.05", "0.1", 0.0)));
    // Rays from the camera pass below it; what it hides is where the way to the lamp passes x = 0.6 within its edges.
    let lamps: Vec<DVec3> = vec![DVec3::new(0.8, 0.5, 1.0), DVec3::new(-1.0, 1.0, 7.0)];
    let lit = |k: usize, at: DVec3| {
        let way = lamps[k] - at;
        let t = (0.6 - at.x) / way.x;
        let there = at + t * way;
        !((0.0..1.0).contains(&t) && (there.y - 0.9).abs() < 0.3 && (there.z - 0.9).abs() < 0.3)
    };
    let expected = expected(&scene, lit);
    check(&render(request, scene, |_| {}), &expected, "a board");
}
