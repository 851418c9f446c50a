//! Media that scatter: light that comes straight from lamps, scattered once towards the camera, against f64 quadrature and
//! closed forms.

mod air;
mod common;

use std::process::ExitCode;

use air::{Air, LAMPS, ROOM, SIZE, fog, parse, rays, render};
use common::{Case, Request, layer};
use glam::{DVec3, Vec3};
use nephroid::random;
use nephroid::render::Picture;
use nephroid::scene::{Bounds, DensityGrid, Scene};

/// One pixel of 256 places a stretch, over the brightest one. 1e-2 at worst; a missing leg or factor is far above it.
const PIXEL: f64 = 2e-2;
/// Of the picture's mean, in which noise cancels: 1e-3 at worst.
const MEAN: f64 = 2e-3;
/// Rounding of f32.
const CLOSED_FORM: f64 = 1e-4;
fn main() -> ExitCode {
    common::run(&[
        Case { name: "lamps_in_fog_are_the_quadrature", needs: &[], disable: "", run: lamps },
        Case { name: "spots_light_their_cone_of_fog", needs: &[], disable: "", run: spots },
        Case { name: "shadows_reach_through_fog", needs: &[], disable: "", run: shadow },
        Case { name: "smoke_is_the_quadrature", needs: &[], disable: "", run: smoke },
        Case { name: "optical_depth_is_exact", needs: &[], disable: "", run: optical_depth },
        Case { name: "the_sun_in_an_even_box_is_the_closed_form", needs: &[], disable: "", run: sun },
        Case { name: "fog_over_and_under_water_is_seen_through_it", needs: &[], disable: "", run: water },
        Case { name: "no_scattering_and_no_density_cost_and_give_nothing", needs: &[], disable: "", run: nothing },
        Case { name: "too_many_stretches_are_told", needs: &[], disable: "", run: many_stretches },
    ])
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

/// A grid of 5 x 4 x 6 points of density 0 to 3, in no order, some of them empty.
fn cloud() -> DensityGrid {
    let value = |k: u32| 3.0 * (random::sample_2d(k, 11)[0] - 0.3).max(0.0);
    DensityGrid {
        bounds: Bounds { min: Vec3::new(-1.5, -1.0, -2.0), max: Vec3::new(1.5, 1.5, 2.0) },
        points: [5, 4, 6],
        values: (0..120).map(value).collect(),
    }
}

/// The room with `grid` for the fog's density.
fn with_grid(text: &str, grid: DensityGrid) -> Scene {
    let mut scene = parse(text);
    scene.media[1].density = Some(0);
    scene.densities = vec![grid];
    // Of suns in what had no end before.
    scene.warnings.clear();
    scene
}

fn smoke(request: &Request) {
    let sun = "[[light]]\nname = \"sun\"\nkind = \"directional\"\ndirection = [1, -3, -1]\nirradiance = [1, 2, 3]\n\
               medium = \"fog\"\n";
    for (what, lights) in [("lamps in and by smoke", LAMPS), ("sun on smoke", sun)] {
        let scene = with_grid(&format!("{ROOM}{}{lights}", fog("[0.1, 0.4, 1]", "[1, 0.5, 2]", 0.5)), cloud());
        let expected = expected(&scene, |_, _| true);
        check(&render(request, scene, |_| {}), &expected, what);
    }
}

/// What a grid leaves of the background, whose radiance is 1.
fn background(request: &Request, grid: DensityGrid, absorption: f32) -> (Vec<f64>, Vec<DVec3>, Scene) {
    // The only surface is out of sight.
    let text =
        ROOM.replace("translate = [0, 0, -5]", "translate = [0, 0, 9]").replace("[film]", "[film]\nbackground = 1");
    let scene = with_grid(&format!("{text}{}", fog(&absorption.to_string(), "0", 0.0)), grid);
    let found = layer(&render(request, scene.clone(), |_| {}).image, "direct");
    (found.iter().map(|p| f64::from(p[0])).collect(), rays(&scene.cameras[0], SIZE), scene)
}

fn optical_depth(request: &Request) {
    let check = |grid: DensityGrid, depth: &dyn Fn(&Air, DVec3, DVec3) -> f64| {
        let (found, rays, scene) = background(request, grid, 0.4);
        let air = Air::of(&scene, 1);
        let from = scene.cameras[0].position.as_dvec3();
        let expected = rays.iter().map(|&ray| air.left(0, depth(&air, from, ray)));
        let worst = found.iter().zip(expected).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
        let thickest = found.iter().copied().fold(1.0, f64::min);
        println!("worst {worst:.1e}, down to {thickest:.2e}");
        assert!(worst < CLOSED_FORM && thickest < 0.4, "{worst} {thickest}");
    };
    // A ramp along z: its mean over the stretch in the box, which all rays enter and leave by the faces across z.
    let bounds = Bounds { min: Vec3::new(-9.0, -9.0, -2.0), max: Vec3::new(9.0, 9.0, 2.0) };
    let ramp = DensityGrid { bounds, points: [3, 3, 7], values: (0..63).map(|k| 0.3 * (k / 9) as f32).collect() };
    check(ramp, &|_, _, ray| 4.0 / ray.z.abs() * 0.5 * (0.3 * 6.0));
    check(cloud(), &|air, from, ray| air.depth(from, ray, 12.0, 200_000));
}

/// A box of even density from -1 to 1 each way, of `density`.
fn even_box(density: f32) -> DensityGrid {
    let bounds = Bounds { min: Vec3::NEG_ONE, max: Vec3::ONE };
    DensityGrid { bounds, points: [2, 3, 4], values: vec![density; 24] }
}

fn sun(request: &Request) {
    let one = "position = [0, 0, 5]\ntarget = [0, 0, 0]\nfov_y = 0.1";
    let room = ROOM.replace("position = [0.3, 0.2, 5]\ntarget = [0, 0, 0]\nfov_y = 40", one);
    assert!(room.contains(one));
    let scattering = 0.5;
    let (absorption, phase) = (0.25, 1.0 / (4.0 * std::f64::consts::PI));
    // From above: a metre of smoke before each point. From behind the camera: as much as the camera looks through; what
    // a thick box returns is its albedo's. 1e5 is thick by 1e5 metres.
    for (direction, density) in [("[0, -1, 0]", 0.8), ("[0, -1, 0]", 6.0), ("[0, 0, -1]", 1.0), ("[0, 0, -1]", 1e5)] {
        let sun = format!(
            "[[light]]\nname = \"sun\"\nkind = \"directional\"\ndirection = {direction}\nirradiance = 2\nmedium = \"fog\"\n"
        );
        let scene = with_grid(
            &format!("{room}{}{sun}", fog(&absorption.to_string(), &scattering.to_string(), 0.0)),
            even_box(density),
        );
        let lost = (absorption + scattering) * f64::from(density);
        let back = 2.0 * scattering * f64::from(density) * phase;
        let expected = |ray: DVec3| {
            // The picture is 9 mm high there, and a metre of the thickest smoke leaves 1 %.
            let above = 1.0 - 5.0 * ray.y / ray.z.abs();
            [if direction == "[0, -1, 0]" {
                back * (-lost * above).exp() * (1.0 - (-2.0 * lost).exp()) / lost
            } else {
                back * (1.0 - (-4.0 * lost).exp()) / (2.0 * lost)
            }; 3]
        };
        let expected: Vec<_> = rays(&scene.cameras[0], (4, 4)).into_iter().map(expected).collect();
        let picture = render(request, scene, |s| s.size = Some((4, 4)));
        check(&picture, &expected, &format!("sun along {direction}, density {density}"));
    }
}

/// The camera looks down at flat water from fog, and up at it from murky water.
fn water(request: &Request) {
    let scene = |camera: &str, air: &str, water: &str| {
        parse(&format!(
            "[film]\nvolume_samples = 256\n[[camera]]\nname = \"c\"\n{camera}\nup = [0, 0, -1]\nfov_y = 0.1\n\
             [[medium]]\nname = \"fog\"\nindex = 1\n{air}\n[[medium]]\nname = \"water\"\nindex = 1.33\n{water}\n\
             [[material]]\nname = \"surface\"\nkind = \"dielectric\"\nfront = \"fog\"\nback = \"water\"\n\
             [[material]]\nname = \"black\"\nkind = \"diffuse\"\nalbedo = 0\n\
             [[object]]\nname = \"surface\"\nshape = \"plane\"\nsize = [100, 100]\nmaterial = \"surface\"\n\
             [[object]]\nname = \"floor\"\nshape = \"plane\"\ncentre = [0, -3, 0]\nsize = [100, 100]\nmaterial = \"black\"\n\
             [[object]]\nname = \"roof\"\nshape = \"plane\"\ncentre = [0, 6, 0]\nsize = [100, 100]\nmaterial = \"black\"\n\
             [[light]]\nname = \"high\"\nkind = \"point\"\nposition = [1, 3, 0]\nintensity = 4\nmedium = \"fog\"\n\
             [[light]]\nname = \"deep\"\nkind = \"point\"\nposition = [1.2, -1, 0.4]\nintensity = 5\nmedium = \"water\"\n"
        ))
    };
    let (thin, murky) = ("absorption = 0.05\nscattering = 0.1", "absorption = 0.1\nscattering = 0.4\nasymmetry = 0.8");
    let above = "position = [0, 2, 0]\ntarget = [0, 0, 0]\nmedium = \"fog\"";
    let below = "position = [0, -2, 0]\ntarget = [0, 0, 0]\nmedium = \"water\"";
    let reflectance = (0.33f64 / 2.33).powi(2);
    let n2 = 1.33f64.powi(2);
    for (camera, own, squared) in [(above, 1usize, 1.0 / n2), (below, 2, n2)] {
        let scene = scene(camera, thin, murky);
        let other = 3 - own;
        let from = scene.cameras[0].position.as_dvec3();
        let (ahead, back) = (-from.normalize(), from.normalize());
        let (beyond, behind) = if own == 1 { (3.0, 6.0) } else { (6.0, 3.0) };
        let [here, there] = [own, other].map(|medium| Air::of(&scene, medium));
        let lamp = |medium: usize| &scene.lights[medium - 1];
        let before = here.light((from, ahead, 2.0), lamp(own), |_| true)[0];
        let through = there.light((DVec3::ZERO, ahead, beyond), lamp(other), |_| true)[0];
        let reflected = here.light((DVec3::ZERO, back, behind), lamp(own), |_| true)[0];
        let left = here.left(0, 2.0);
        let expected = before + left * ((1.0 - reflectance) * squared * through + reflectance * reflected);
        let picture = render(request, scene.clone(), |s| s.size = Some((4, 4)));
        check(&picture, &vec![[expected; 3]; 16], &format!("medium {own}"));
        // The two layers: before the surface and through it, and what it reflects.
        for (name, expected) in [
            ("refracted", before + left * (1.0 - reflectance) * squared * through),
            ("reflected", left * reflectance * reflected),
        ] {
            let found = f64::from(layer(&picture.image, name)[5][0]);
            assert!((found / expected - 1.0).abs() < PIXEL, "{name}: {found} instead of {expected}");
        }
    }
}

fn nothing(request: &Request) {
    let has_pass = |picture: &Picture| picture.stats.passes.iter().any(|pass| pass.name == "frame/volume");
    let clear = render(request, parse(&format!("{ROOM}{}{LAMPS}", fog("0.2", "0", 0.0))), |_| {});
    assert!(clear.image.layer("volume").is_none() && clear.image.layer("caustic_volume").is_none());
    assert!(!has_pass(&clear), "nothing scatters");
    let dark = render(request, parse(&format!("{ROOM}{}", fog("0", "1", 0.0))), |_| {});
    assert!(!has_pass(&dark) && layer(&dark.image, "volume").iter().flatten().all(|&v| v == 0.0), "there is no lamp");
    // An empty grid, and fog in which no lamp reaches anything: nothing. A box as dense as can be sends back what its
    // albedo does, and no number that is none.
    let empty = with_grid(&format!("{ROOM}{}{LAMPS}", fog("1", "1", 0.0)), even_box(0.0));
    let dense = parse(&format!("{ROOM}{}{LAMPS}", fog("1e9", "1e9", 0.9)));
    let thick = with_grid(&format!("{ROOM}{}{LAMPS}", fog("1e9", "1e9", 0.0)), even_box(1e9));
    for (scene, most) in [(empty, 0.0), (dense, 0.0), (thick, 1.0)] {
        let picture = render(request, scene, |_| {});
        assert!(has_pass(&picture) && picture.stats.warnings.is_empty(), "{:?}", picture.stats.warnings);
        assert!(layer(&picture.image, "volume").iter().flatten().all(|v| (0.0..=most).contains(v)));
    }
}

fn many_stretches(request: &Request) {
    // Panes of glass across the view; fog before, between and behind them.
    let mut text = format!("{ROOM}{}{LAMPS}", fog("0", "0.1", 0.0));
    text += "[[medium]]\nname = \"glass\"\nindex = 1.5\n[[material]]\nname = \"glass\"\nkind = \"dielectric\"\n\
             front = \"fog\"\nback = \"glass\"\n";
    let pane = |z: f64| {
        format!(
            "[[object]]\nname = \"{z}\"\nshape = \"box\"\ncentre = [0, 0, {z}]\nsize = [50, 50, 0.1]\nmaterial = \"glass\"\n"
        )
    };
    let few = parse(&format!("{text}{}", pane(3.0)));
    assert!(render(request, few, |_| {}).stats.warnings.is_empty());
    let many = parse(&(0..5).fold(text, |text, k| text + &pane(3.0 - f64::from(k))));
    let warnings = render(request, many, |_| {}).stats.warnings;
    assert!(warnings.iter().any(|w| w.contains("more than 4 stretches")), "{warnings:?}");
}
