//! What lights send out, through light views and on walls; spot lights that project an image among them.

mod common;

use std::f64::consts::TAU;
use std::process::ExitCode;

use common::slide::parse;
use common::{Case, Request, assert_valid, layer};
use nephroid::gpu::{Bindings, Buffer, Kernel, Recorder};
use nephroid::gpu_scene::GpuScene;
use nephroid::light_view::{LightViewTier, LightViews};
use nephroid::technique::TechniqueKind;
use nephroid::technique::emission::emission;
use nephroid::trace::{Backend, Tracer};

fn main() -> ExitCode {
    common::run(&[
        Case { name: "power_over_the_lattice_is_the_flux", needs: &[], disable: "", run: flux },
        Case { name: "a_wall_shows_the_image", needs: &[], disable: "", run: wall },
    ])
}

/// Lattice points along a side: the midpoint rule is then good to [`MIDPOINT`].
const RESOLUTION: u32 = 257;
/// Relative; the borders within an image are the worst of it.
const MIDPOINT: f64 = 1e-4;
/// Relative: emission cells reach past what they cover by a fine cell.
const CELLS: f64 = 2e-3;
/// Relative: half a texel in 64 is grey where white ends.
const HALF: f64 = 0.02;

/// Water far wider than the cone, 2 m below the light.
const WATER: &str = r#"
[[camera]]
name = "c"
position = [0, 1, 4]
target = [0, 0, 0]
[[medium]]
name = "water"
index = 1.33
[[material]]
name = "surface"
kind = "dielectric"
back = "water"
[[object]]
name = "w"
shape = "plane"
size = [40, 30]
material = "surface"
"#;

fn flux(request: &Request) {
    // Of a smoothstep in the cosine, half the cosines between the two angles count.
    let cone = |inner: f64, outer: f64| {
        let [inner, outer] = [inner, outer].map(|angle: f64| angle.to_radians().cos());
        TAU * (1.0 - 0.5 * (inner + outer))
    };
    let spot = "kind = \"spot\"\nposition = [0, 2, 0]\ntarget = [0.3, 0, 0.1]\nintensity = [1, 2, 3]";
    // Of the plane seen from 20 m above its middle, sr.
    let whole = 4.0 * (20.0 * 15.0 / (20.0 * (400.0f64 + 400.0 + 225.0).sqrt())).atan();
    let cases = [
        (format!("{spot}\nouter = 50\ninner = 20"), [1.0, 2.0, 3.0].map(|i| i * cone(20.0, 50.0))),
        // Half of the cone is white, a quarter green.
        (
            format!("{spot}\nouter = 50\ninner = 20\nimage = \"i.png\"\nup = [0, 0, -1]"),
            [0.5, 1.5, 1.5].map(|i| i * cone(20.0, 50.0)),
        ),
        ("kind = \"directional\"\ndirection = [0, -1, 0]\nirradiance = [1, 2, 3]".into(), [1200.0, 2400.0, 3600.0]),
        ("kind = \"point\"\nposition = [0, 20, 0]\nintensity = [1, 2, 3]".into(), [1.0, 2.0, 3.0].map(|i| i * whole)),
    ];
    let device = request.open();
    let kernel = Kernel::new(&device, "selftest/light_power", "").unwrap();
    for (light, expected) in cases {
        let scene = parse(&format!("{WATER}[[light]]\nname = \"l\"\n{light}\n"));
        let gpu_scene = GpuScene::new(&device, &scene).unwrap();
        let tracer = Tracer::new(&device, &scene, &gpu_scene, Backend::Bvh2).unwrap();
        let views = LightViews::new(&device, &scene, &tracer, RESOLUTION, LightViewTier::Rays).unwrap();
        let cells = (RESOLUTION - 1).pow(2);
        let mut found = [0.0; 3];
        for view in 0..views.views().len() as u32 {
            let powers = Buffer::new(&device, "powers", u64::from(cells) * 16).unwrap();
            let own = Bindings::new().buffer("Powers", &powers);
            let mut recorder = Recorder::new(&device).unwrap();
            let all = [&gpu_scene.bindings, views.bindings(), &own];
            recorder.pass("selftest/light_power").unwrap().dispatch(&kernel, &all, &view, cells).unwrap();
            recorder.submit().unwrap();
            for power in powers.read::<[f32; 4]>(cells as usize).unwrap() {
                (0..3).for_each(|channel| found[channel] += f64::from(power[channel]));
            }
        }
        let host = emission(&scene, 4096).flux[0];
        println!("{light}: {found:?} W over the lattice, {host} W of cells, {expected:?} W expected");
        for channel in 0..3 {
            assert!((found[channel] / expected[channel] - 1.0).abs() < MIDPOINT, "{light} channel {channel}");
            assert!((f64::from(host[channel]) / expected[channel] - 1.0).abs() < CELLS, "{light} cells {channel}");
        }
    }
    // Water under the image's left half alone.
    let half = WATER.replace("size = [40, 30]", "size = [40, 30]\ncentre = [-20, 0, 0]");
    let slide = "outer = 50\ninner = 20\nimage = \"i.png\"\nup = [0, 0, -1]";
    let straight = spot.replace("[0.3, 0, 0.1]", "[0, 0, 0]");
    let host = emission(&parse(&format!("{half}[[light]]\nname = \"l\"\n{straight}\n{slide}\n")), 4096).flux[0];
    for channel in 0..3 {
        let expected = 0.5 * (channel + 1) as f64 * cone(20.0, 50.0);
        let ratio = f64::from(host[channel]) / expected;
        println!("the image's left half, channel {channel}: {ratio} of what is white");
        assert!((ratio - 1.0).abs() < HALF, "channel {channel}: {ratio}");
    }
    assert_valid(&device);
}

/// A wall at z = 0 that a light at z = 4 shines on, seen by a camera at the light: 6 m by 6 m in 60 x 60 pixels.
const WALL: &str = r#"
[[camera]]
name = "c"
position = [0, 0, 3]
target = [0, 0, 0]
fov_y = 90
[[material]]
name = "white"
kind = "diffuse"
albedo = 1
[[object]]
name = "wall"
shape = "box"
size = [20, 20, 1]
centre = [0, 0, -0.5]
material = "white"
[[light]]
name = "l"
kind = "spot"
position = [0, 0, 4]
target = [0, 0, 0]
intensity = 1
outer = 30
image = "i.png"
"#;

fn wall(request: &Request) {
    let picture = |text: &str| {
        let picture = request.render(parse(text), |s| {
            s.technique = TechniqueKind::None;
            s.size = Some((60, 60));
            s.samples = Some(1);
        });
        layer(&picture.image, "direct")
    };
    let upright = picture(WALL);
    let plain = picture(&WALL.replace("image = \"i.png\"\n", ""));
    let turned = picture(&WALL.replace("image = \"i.png\"", "image = \"i.png\"\nup = [-1, 0, 0]"));
    // tan(30 degrees) times 4 m: the cone's edge on the wall.
    let radius = 4.0 / 3f64.sqrt();
    let (mut lit, mut dark) = (0, 0);
    for row in 0..60 {
        for column in 0..60 {
            let (x, y) = ((f64::from(column) + 0.5) / 10.0 - 3.0, 3.0 - (f64::from(row) + 0.5) / 10.0);
            // Half a pixel of jitter, and the blur of a texel of the image, 7 cm.
            if (x.hypot(y) - radius).abs() < 0.12 || x.abs() < 0.12 || y.abs() < 0.12 {
                continue;
            }
            let pixel = (row * 60 + column) as usize;
            let colour = |right: f64, up: f64| match (right < 0.0, up > 0.0) {
                _ if x.hypot(y) > radius => [0.0; 3],
                (true, _) => [1.0; 3],
                (false, true) => [0.0; 3],
                (false, false) => [0.0, 1.0, 0.0],
            };
            // Up is -x: right is then direction x up = -z x -x = y.
            for (found, expected) in [(upright[pixel], colour(x, y)), (turned[pixel], colour(y, -x))] {
                for channel in 0..3 {
                    let expected = expected[channel] * plain[pixel][channel];
                    assert!((found[channel] - expected).abs() < 1e-3 * plain[1830][1], "({x}, {y}): {found:?}");
                }
                lit += usize::from(found[1] > 0.0);
                dark += usize::from(found[1] == 0.0);
            }
        }
    }
    assert!(lit > 1000 && dark > 1000, "{lit} {dark}");
}
