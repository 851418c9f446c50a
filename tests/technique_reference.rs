//! The reference against closed forms, a truth made elsewhere, and itself.

mod common;

use std::path::Path;
use std::process::ExitCode;

use common::measure::watts;
use common::pool::{flat_water_irradiance, floor_point};
use common::text::pane;
use common::truth::Truth;
use common::{Case, Request, layer, slide};
use nephroid::render::Picture;
use nephroid::scene::{self, Scene};

fn main() -> ExitCode {
    common::run(&[
        Case { name: "flat_water_is_the_closed_form", needs: &[], disable: "", run: flat_water },
        Case { name: "waves_are_the_truth", needs: &[], disable: "", run: waves },
        Case { name: "light_is_accounted_for", needs: &[], disable: "", run: ledger },
        Case { name: "path_classes_part_the_light", needs: &[], disable: "", run: path_classes },
        Case { name: "fresnel_by_chance_and_by_splitting_agree", needs: &[], disable: "", run: fresnel },
        Case { name: "tiers_agree_within_noise", needs: &[], disable: "", run: tiers },
        Case { name: "a_directional_light_keeps_its_flux", needs: &[], disable: "", run: directional },
        Case { name: "photons_carry_the_image_of_their_light", needs: &[], disable: "", run: projected },
    ])
}

fn load(name: &str) -> Scene {
    scene::load(&Path::new("scenes").join(name)).unwrap()
}

fn flat_water(request: &Request) {
    // The closed form itself, against figures worked out elsewhere.
    for (x, z, expected) in
        [(1.5, -1.0, 1.740_371_61), (0.0, 0.0, 1.615_006_24), (-3.0, 2.0, 0.979_295_80), (4.0, 4.0, 0.947_540_34)]
    {
        assert!((flat_water_irradiance(x, z) / expected - 1.0).abs() < 1e-7);
    }
    let (width, height) = (48usize, 36usize);
    let picture = request.render(load("flat_water.toml"), |s| {
        s.size = Some((width as u32, height as u32));
        s.samples = Some(16);
        // The light is smooth: a third of a metre holds a thousand photons and blurs nothing.
        s.set =
            ["reference.photons=400000", "reference.reuse=8", "reference.neighbours=1000"].map(String::from).to_vec();
    });
    let irradiance = layer(&picture.image, "caustic");
    let (mut sum, mut expected_sum, mut squares, mut worst) = (0.0, 0.0, 0.0, 0.0f64);
    let mut count = 0;
    for row in 0..height {
        for column in 0..width {
            let Some((x, z)) = floor_point(column as f64, row as f64, width as f64, height as f64) else { continue };
            let (found, expected) = (f64::from(irradiance[row * width + column][1]), flat_water_irradiance(x, z));
            sum += found;
            expected_sum += expected;
            let error = found / expected - 1.0;
            squares += error * error;
            worst = worst.max(error.abs());
            count += 1;
        }
    }
    let (energy, rms) = (sum / expected_sum, (squares / f64::from(count)).sqrt());
    println!("{count} floor pixels: energy {energy:.5}, RMS error {rms:.4}, worst {worst:.4}");
    assert!(count > 500);
    // Asked for is 0.2 %; hundreds of pixels average what a single one may be off.
    assert!((energy - 1.0).abs() < 0.002, "energy {energy}");
    assert!(rms < 0.01, "RMS error {rms}");
}

fn waves(request: &Request) {
    let truth = Truth::of_pool("under", 2);
    let picture = request.render(load("pool.toml"), |s| {
        s.camera = Some("under".to_string());
        s.size = Some(truth.size);
        s.samples = Some(16);
        s.set = ["reference.photons=400000", "reference.reuse=4", "reference.neighbours=4"].map(String::from).to_vec();
    });
    let (energy, rel_rmse) = truth.against(&layer(&picture.image, "final"));
    println!("relRMSE {rel_rmse:.4}, energy {energy:.5}, estimated noise {:?}", picture.stats.noise);
    // What four sets leave, mostly the blur of the first radii: 7.8 %. A shifted pixel or a wrong index gives over 35 %.
    assert!(rel_rmse < 0.09, "relRMSE {rel_rmse}");
    assert!((energy - 1.0).abs() < 0.005, "energy {energy}");
}

/// A small render of which only the ledger is of interest.
fn ledger_of(request: &Request, scene: &str, photons: u32, set: &[&str]) -> Picture {
    request.render(load(scene), |s| {
        s.size = Some((8, 6));
        s.samples = Some(2);
        s.set = set.iter().map(|s| s.to_string()).collect();
        s.set.push(format!("reference.photons={photons}"));
    })
}

fn ledger(request: &Request) {
    for scene in ["pool.toml", "glass_sphere.toml", "cornell_flooded.toml", "cup.toml", "lagoon.toml"] {
        for fresnel in ["reference.fresnel=chance", "reference.fresnel=split"] {
            let picture = ledger_of(request, scene, 100_000, &[fresnel]);
            let emitted = watts(&picture, "emitted");
            let booked: f64 = picture.stats.ledger.iter().skip(1).map(|e| e.watts).sum();
            println!("{scene} {fresnel}: {:?}", picture.stats.ledger);
            assert!(watts(&picture, "landed") > 0.0);
            // The flux of a pass is an integral over the cells by some 50 points each: exact to a few in 1e4.
            assert!((booked / emitted - 1.0).abs() < 1e-3, "{scene} {fresnel}: {booked} of {emitted} W");
            assert_eq!(watts(&picture, "non_finite"), 0.0);
            assert!(watts(&picture, "given_up") < 1e-3 * emitted, "{scene}");
            assert!(watts(&picture, "wrong_side") < 0.02 * emitted, "{scene}");
        }
    }
}

fn path_classes(request: &Request) {
    let landed = |paths: &str| {
        let picture = ledger_of(request, "cornell_flooded.toml", 20_000, &[&format!("reference.paths={paths}")]);
        watts(&picture, "landed")
    };
    let all = landed("all");
    let parts = landed("refracted") + landed("reflected") + landed("mixed");
    // The same photons each time: only the rounding of the ledger is left.
    assert!((parts / all - 1.0).abs() < 1e-5, "{parts} of {all}");
    assert!(landed("refracted-once") <= landed("refracted") && landed("refracted-once") > 0.0);
}

fn fresnel(request: &Request) {
    let landed = |mode: &str| {
        let picture = ledger_of(request, "pool.toml", 100_000, &[&format!("reference.fresnel={mode}")]);
        watts(&picture, "landed")
    };
    let (chance, split) = (landed("chance"), landed("split"));
    // 200000 photons of which one in twenty is reflected: 0.05 % standard deviation.
    assert!((chance / split - 1.0).abs() < 0.003, "{chance} against {split}");
}

fn tiers(request: &Request) {
    let picture = |disable: &str, trace: &str| {
        let picture = request.render(load("pool.toml"), |s| {
            s.device = request.without(disable);
            s.trace = trace.parse().unwrap();
            s.camera = Some("under".to_string());
            s.size = Some((48, 36));
            s.samples = Some(2);
            s.set = vec!["reference.photons=30000".to_string()];
        });
        layer(&picture.image, "final")
    };
    let first = picture("", "cwbvh");
    for (disable, trace) in [("graphics", "cwbvh"), ("graphics", "bvh2")] {
        let other = picture(disable, trace);
        let sum = |image: &[[f32; 3]]| image.iter().map(|p| f64::from(p[1])).sum::<f64>();
        let squares: f64 = first.iter().zip(&other).map(|(a, b)| f64::from(a[1] - b[1]).powi(2)).sum();
        let difference = (squares / first.len() as f64).sqrt() / (sum(&first) / first.len() as f64);
        println!("{disable} {trace}: {difference:.2e}");
        // The same photons and points but for rounding: far below the noise of so few photons, about 20 %.
        assert!(difference < 0.02, "{disable} {trace}: {difference}");
    }
}

fn directional(request: &Request) {
    let camera = "position = [0, 0.5, 0]\ntarget = [0, 0, 0]\nup = [0, 0, -1]\nfov_y = 60";
    let scene = scene::parse(&pane(camera, "air", ""), Path::new("test.toml")).unwrap();
    let picture = request.render(scene, |s| {
        s.size = Some((16, 12));
        s.samples = Some(8);
        s.set = vec!["reference.photons=100000".to_string()];
    });
    // Two faces, all orders of inner reflections: (1 - R) / (1 + R) with R = 0.04.
    let expected = 0.96 / 1.04;
    for (channel, irradiance) in [1.0f64, 2.0, 3.0].into_iter().enumerate() {
        let mean = layer(&picture.image, "caustic").iter().map(|p| f64::from(p[channel])).sum::<f64>() / 192.0;
        println!("channel {channel}: {mean}");
        assert!((mean / (irradiance * expected) - 1.0).abs() < 0.005, "channel {channel}: {mean}");
    }
}

/// A light above water, and a camera in it that looks down on the floor: the image's left, white, is its left.
const SLIDE: &str = r#"
[[camera]]
name = "c"
position = [0, -0.05, 0]
target = [0, -1, 0]
up = [0, 0, -1]
medium = "water"
fov_y = 60
[[medium]]
name = "water"
index = 1.33
[[material]]
name = "surface"
kind = "dielectric"
back = "water"
[[material]]
name = "white"
kind = "diffuse"
albedo = 1
[[object]]
name = "w"
shape = "plane"
size = [40, 30]
material = "surface"
[[object]]
name = "f"
shape = "plane"
centre = [0, -1, 0]
size = [40, 30]
material = "white"
[[light]]
name = "l"
kind = "spot"
position = [0, 2, 0]
target = [0, 0, 0]
intensity = 1
outer = 40
image = "i.png"
up = [0, 0, -1]
"#;

fn projected(request: &Request) {
    let render = |text: &str| -> Picture {
        request.render(slide::parse(text), |s| {
            s.size = Some((24, 24));
            s.samples = Some(4);
            s.set = vec!["reference.photons=100000".to_string()];
        })
    };
    let watts = |picture: &Picture, name: &str| picture.stats.ledger.iter().find(|e| e.name == name).unwrap().watts;
    let (with, without) = (render(SLIDE), render(&SLIDE.replace("image = \"i.png\"\nup = [0, 0, -1]\n", "")));
    // Half of the light is white, a quarter of it green, and of that a third counts in the mean of the channels.
    let part = 0.5 + 0.25 / 3.0;
    for name in ["emitted", "landed"] {
        let ratio = watts(&with, name) / watts(&without, name);
        println!("{name}: {ratio} of the light without an image, {part} expected");
        assert!((ratio / part - 1.0).abs() < 5e-3, "{name}: {ratio}");
    }
    let [with, without] = [with, without].map(|picture| layer(&picture.image, "caustic"));
    let mean = |pixels: &[[f32; 3]], columns: std::ops::Range<usize>, rows: std::ops::Range<usize>, channel: usize| {
        let of_row = |row: usize| columns.clone().map(move |column| (row, column));
        let all: Vec<f32> = rows.clone().flat_map(of_row).map(|(r, c)| pixels[24 * r + c][channel]).collect();
        f64::from(all.iter().sum::<f32>()) / all.len() as f64
    };
    // Left, right above, right below, a pixel or two from the borders, whose blur is the estimate's.
    for (columns, rows, expected) in
        [(0..9, 0..24, [1.0f64, 1.0, 1.0]), (15..24, 0..9, [0.0, 0.0, 0.0]), (15..24, 15..24, [0.0, 1.0, 0.0])]
    {
        for (channel, expected) in expected.into_iter().enumerate() {
            let whole = mean(&without, columns.clone(), rows.clone(), 1);
            let ratio = mean(&with, columns.clone(), rows.clone(), channel) / whole;
            println!("columns {columns:?} rows {rows:?} channel {channel}: {ratio}");
            assert!((ratio - expected).abs() < 0.03, "columns {columns:?} rows {rows:?}: {ratio}");
        }
    }
}
