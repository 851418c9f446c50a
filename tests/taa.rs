//! Temporal anti-aliasing: what stands still converges, what moves takes its history along, what has gone leaves nothing,
//! and a frame is the same however it is come to.

mod common;

use std::path::Path;
use std::process::ExitCode;

use common::{Case, Request, assert_valid, layer};
use glam::Vec3;
use nephroid::display::{Display, Look};
use nephroid::render::{RenderSettings, Renderer};
use nephroid::scene::{self, Camera, Scene, ToneCurve};
use nephroid::taa::{History, TaaSettings};
use nephroid::technique::TechniqueKind;

/// Of a picture.
const WINDOW: u32 = 8;
const SIZE: (u32, u32) = (40, 30);

fn main() -> ExitCode {
    common::run(&[
        Case { name: "still_frames_converge_and_keep_the_light", needs: &[], disable: "", run: still },
        Case { name: "all_techniques_are_treated_alike", needs: &[], disable: "", run: techniques },
        Case { name: "a_camera_that_pans_sees_less_noise", needs: &[], disable: "", run: pan },
        Case { name: "an_object_that_moves_leaves_no_trail", needs: &[], disable: "", run: trail },
        Case { name: "a_lamp_that_dims_leaves_no_trail", needs: &[], disable: "", run: dims },
        Case { name: "a_frame_is_the_same_however_it_is_come_to", needs: &[], disable: "", run: contract },
        Case { name: "shown_pictures_are_a_history", needs: &[], disable: "", run: shown },
    ])
}

/// Slabs on a floor in the light of a lamp with a sharp cone, of which edges and shadows are finer than pixels; `%more` is
/// filled in.
const SCENE: &str = r#"
[animation]
fps = 10
[film]
background = [0.1, 0.2, 0.4]
[[camera]]
name = "eye"
position = [0, 2, 3]
target = [0, 0, 0]
fov_y = 50
%camera
[[material]]
name = "grey"
kind = "diffuse"
albedo = [0.3, 0.35, 0.4]
[[material]]
name = "white"
kind = "diffuse"
albedo = [0.9, 0.8, 0.7]
[[object]]
name = "floor"
shape = "plane"
size = [8, 5]
material = "grey"
[[light]]
name = "lamp"
kind = "point"
position = [0.5, 3, 0.5]
intensity = 10
%lamp
"#;

fn slabs() -> String {
    let slab = |i: i32| {
        let x = 0.3 * f64::from(i);
        format!(
            "[[object]]\nname = \"slab {i}\"\nshape = \"box\"\ncentre = [{x}, 0.15, 0]\nsize = [0.07, 0.3, 2]\nmaterial = \"white\"\n"
        )
    };
    (-5..=5).map(slab).collect()
}

fn parse(camera: &str, lamp: &str, more: &str) -> Scene {
    let text = SCENE.replace("%camera", camera).replace("%lamp", lamp) + more;
    scene::parse(&text, Path::new("test.toml")).unwrap()
}

fn settings(request: &Request, frames: Option<u32>) -> RenderSettings {
    RenderSettings {
        device: request.device.clone(),
        trace: "bvh".parse().unwrap(),
        technique: TechniqueKind::None,
        size: Some(SIZE),
        samples: Some(1),
        taa: frames.map(|frames| TaaSettings { frames, history: History::Numbered }),
        ..Default::default()
    }
}

/// What a frame shows: the picture, and what its own samples alone make.
struct Shown {
    picture: Vec<Vec3>,
    own: Vec<Vec3>,
}

fn show(renderer: &mut Renderer) -> Shown {
    for _ in 0..renderer.samples() {
        renderer.sample().unwrap();
    }
    let image = renderer.finish().unwrap().image;
    let pixels = |name: &str| layer(&image, name).into_iter().map(Vec3::from).collect::<Vec<_>>();
    let own = pixels("refracted").iter().zip(pixels("reflected")).map(|(a, b)| *a + b).collect();
    Shown { picture: pixels("final"), own }
}

fn frame(renderer: &mut Renderer, frame: u32) -> Shown {
    renderer.go_to(frame).unwrap();
    show(renderer)
}

/// The last of a window of frames, and the mean of all their own samples.
fn row(renderer: &mut Renderer) -> (Shown, Vec<Vec3>) {
    let mut frames: Vec<Shown> = (0..WINDOW).map(|number| frame(renderer, number)).collect();
    assert_valid(renderer.device());
    let mean = |pixel: usize| frames.iter().map(|frame| frame.own[pixel]).sum::<Vec3>() / WINDOW as f32;
    let all = (0..frames[0].own.len()).map(mean).collect();
    (frames.remove(WINDOW as usize - 1), all)
}

/// The frame by many samples.
fn truth(request: &Request, scene: &Scene, frame: u32) -> Vec<Vec3> {
    let settings = RenderSettings { samples: Some(64), seed: 7, frame, ..settings(request, None) };
    show(&mut request.renderer(scene.clone(), &settings)).picture
}

fn mean(picture: &[Vec3]) -> f32 {
    picture.iter().map(|p| p.element_sum() / 3.0).sum::<f32>() / picture.len() as f32
}

/// RMS over the truth's mean.
fn error(found: &[Vec3], truth: &[Vec3]) -> f32 {
    let squares: f32 = found.iter().zip(truth).map(|(a, b)| (*a - *b).length_squared() / 3.0).sum();
    (squares / found.len() as f32).sqrt() / mean(truth)
}

/// Of frames' light, what may be lost or gained: clipping takes some of what is bright and rare.
const ENERGY: f32 = 0.01;
/// Of one frame's error, what eight leave: the root of eighths is 0.35, and clipping adds to it.
const STILL: f32 = 0.6;

fn still(request: &Request) {
    let scene = parse("", "", &slabs());
    let truth = truth(request, &scene, 0);
    let mut renderer = request.renderer(scene, &settings(request, Some(WINDOW)));
    let (mut left, mut own, mut light) = (0.0, 0.0, 0.0);
    let frames = WINDOW..3 * WINDOW;
    for number in frames.clone() {
        let shown = frame(&mut renderer, number);
        left += error(&shown.picture, &truth);
        own += error(&shown.own, &truth);
        light += mean(&shown.picture) / frames.len() as f32;
    }
    assert_valid(renderer.device());
    assert!(left < STILL * own, "{left} of {own} is left");
    let energy = light / mean(&truth);
    assert!((energy - 1.0).abs() < ENERGY, "energy {energy}");
}

/// A ball of glass over the floor.
const GLASS: &str = r#"
[[medium]]
name = "glass"
index = 1.5
[[material]]
name = "glass"
kind = "dielectric"
back = "glass"
[[object]]
name = "ball"
shape = "sphere"
centre = [0, 0.7, 0]
radius = 0.5
segments = 16
material = "glass"
"#;

/// As [`ENERGY`], of few frames with spots of light in them, and as [`STILL`].
const ENERGY_OF_TECHNIQUES: f32 = 0.03;
const STILL_OF_TECHNIQUES: f32 = 0.75;

/// Against the mean of all frames that the picture is made of.
fn techniques(request: &Request) {
    let scene = parse("", "", GLASS);
    for (technique, set) in [
        (TechniqueKind::Reference, "reference.photons=20000"),
        (TechniqueKind::Mnee, "mnee.rest=off"),
        (TechniqueKind::Beams, "beams.grid=16"),
        (TechniqueKind::Photons, "photons.photons=20000"),
    ] {
        let settings = RenderSettings { technique, set: vec![set.to_string()], ..settings(request, Some(WINDOW)) };
        let mut renderer = request.renderer(scene.clone(), &settings);
        let (last, all) = row(&mut renderer);
        let (left, own) = (error(&last.picture, &all), error(&last.own, &all));
        assert!(left < STILL_OF_TECHNIQUES * own, "{}: {left} of {own} is left", technique.name());
        let energy = mean(&last.picture) / mean(&all);
        assert!((energy - 1.0).abs() < ENERGY_OF_TECHNIQUES, "{}: energy {energy}", technique.name());
    }
}

/// As [`STILL`], with every frame looked up between its pixels.
const PAN: f32 = 0.7;

fn pan(request: &Request) {
    let camera = "interpolation = \"linear\"\nkeys = [{ time = 0 }, { time = 2, position = [1, 2.2, 3], target = [1.3, 0, 0.2] }]";
    let scene = parse(camera, "", &slabs());
    let mut renderer = request.renderer(scene.clone(), &settings(request, Some(WINDOW)));
    for number in [10, 15] {
        let truth = truth(request, &scene, number);
        let shown = frame(&mut renderer, number);
        let (left, own) = (error(&shown.picture, &truth), error(&shown.own, &truth));
        assert!(left < PAN * own, "frame {number}: {left} of {own} is left");
        let energy = mean(&shown.picture) / mean(&truth);
        assert!((energy - 1.0).abs() < 2.0 * ENERGY, "frame {number}: energy {energy}");
    }
    assert_valid(renderer.device());
}

/// Of a pixel's light, by which a place that has come to light may differ from what is there.
const TRAIL: f32 = 0.03;

/// A white box and its shadow cross the dark floor by some 3 pixels a frame.
fn trail(request: &Request) {
    let white = "[[object]]\nname = \"box\"\nshape = \"box\"\ncentre = [-1.5, 0.3, 0]\nsize = [0.5, 0.02, 0.5]\n\
                 material = \"white\"\ninterpolation = \"linear\"\nkeys = [{ time = 0 }, { time = 2, translate = [5, 0, 0] }]\n";
    // From far away, the lamp lights the floor evenly.
    let far = SCENE.replace("position = [0.5, 3, 0.5]\nintensity = 10", "position = [5, 30, 5]\nintensity = 1000");
    let text = far.replace("%camera", "").replace("%lamp", "") + white;
    let scene = scene::parse(&text, Path::new("test.toml")).unwrap();
    let mut renderer = request.renderer(scene.clone(), &settings(request, Some(WINDOW)));
    let number = 10;
    let [before, now] = [number - 4, number].map(|number| truth(request, &scene, number));
    let shown = frame(&mut renderer, number);
    assert_valid(renderer.device());
    let off = |a: Vec3, b: Vec3| (a - b).abs().max_element() / b.max_element();
    // By hue: the box is reddish, the floor bluish. In the shadow there is none.
    let bare = |picture: &[Vec3], pixel: usize| picture[pixel].x / picture[pixel].z < 0.76;
    let (mut uncovered, mut worst) = (0, 0.0f32);
    for (pixel, found) in shown.picture.iter().enumerate() {
        let even = off(shown.own[pixel], now[pixel]) < TRAIL / 3.0;
        if even && bare(&now, pixel) && !bare(&before, pixel) {
            uncovered += 1;
            worst = worst.max(off(*found, now[pixel]));
        }
    }
    assert!(uncovered > 10, "only {uncovered} pixels were uncovered");
    assert!(worst < TRAIL, "{worst} of the light is a trail");
}

/// Of the light that is left when half of it has gone at once, what the picture may have too much: by the number of frames
/// since, of which the first are too few to tell light that has gone from noise.
const LAG: [(u32, f32); 3] = [(0, 0.15), (1, 0.12), (4, 0.03)];

fn dims(request: &Request) {
    let lamp = "interpolation = \"step\"\nkeys = [{ time = 0 }, { time = 1, intensity = 5 }]";
    let scene = parse("", lamp, &slabs());
    let mut renderer = request.renderer(scene.clone(), &settings(request, Some(WINDOW)));
    for (since, lag) in LAG {
        let number = 10 + since;
        let truth = truth(request, &scene, number);
        let ratio = mean(&frame(&mut renderer, number).picture) / mean(&truth);
        assert!((ratio - 1.0).abs() < lag, "frame {number}: {ratio} of the light");
    }
    assert_valid(renderer.device());
}

fn contract(request: &Request) {
    const FRAME: u32 = 6;
    let camera = "keys = [{ time = 0 }, { time = 1, position = [0.6, 2.2, 3] }]";
    let scene = parse(camera, "", GLASS);
    let set = vec!["reference.photons=5000".to_string()];
    let settings =
        RenderSettings { technique: TechniqueKind::Reference, samples: Some(2), set, ..settings(request, Some(3)) };
    let alone = frame(&mut request.renderer(scene.clone(), &settings), FRAME);
    assert_ne!(alone.picture, alone.own, "there is nothing of other frames in it");
    let mut again = request.renderer(scene.clone(), &RenderSettings { frame: FRAME, ..settings.clone() });
    assert!(show(&mut again).picture == alone.picture, "a frame that is begun with");
    let mut row = request.renderer(scene, &settings);
    // In a row, again, in a part of it, by a jump from behind, over frames that were left out, and after frames that were
    // stopped.
    for frames in [&[3, 4, 5, FRAME][..], &[FRAME], &[4, FRAME], &[9, FRAME], &[0, 3, FRAME], &[5, FRAME]] {
        for &number in &frames[..frames.len() - 1] {
            row.go_to(number).unwrap();
            let stopped = frames.len() == 3;
            for _ in 0..if stopped { 1 } else { 2 } {
                row.sample().unwrap();
            }
        }
        assert!(frame(&mut row, FRAME).picture == alone.picture, "after {frames:?}");
    }
    row.restart().unwrap();
    assert!(show(&mut row).picture == alone.picture, "after a restart");
    assert_valid(row.device());
}

/// Steps of 255 that a picture with a history of few samples may be off one without, once it has many.
const STEPS: i32 = 4;

/// As a window shows it while its camera is moved by hand.
fn shown(request: &Request) {
    let scene = parse("", "", &slabs());
    let history = TaaSettings { frames: WINDOW, history: History::Shown };
    let eye = |step: u32| {
        let away = Vec3::new(0.03, 0.01, 0.0) * step as f32;
        let camera = &scene.cameras[0];
        Camera { position: camera.position + away, target: camera.target + away, ..camera.clone() }
    };
    let look = Look { exposure: 0.0, tone_curve: ToneCurve::Linear };
    let settings = |taa| RenderSettings { taa, ..settings(request, None) };
    let device = request.open();
    let mut display = Display::new(&device).unwrap();
    let mut picture = |renderer: &Renderer| renderer.display(&mut display, look).unwrap();
    let mut with = request.renderer(scene.clone(), &settings(Some(history)));
    let mut without = request.renderer(scene.clone(), &settings(None));
    for step in 0..12 {
        with.set_camera(eye(step)).unwrap();
        with.sample().unwrap();
    }
    without.set_camera(eye(11)).unwrap();
    without.sample().unwrap();
    let [moving, alone] = [&with, &without].map(&mut picture);
    // The film's own layers have nothing of it.
    let image = with.finish().unwrap().image;
    let parts = layer(&image, "refracted").into_iter().zip(layer(&image, "reflected"));
    assert!(layer(&image, "final").into_iter().eq(parts.map(|(a, b)| (Vec3::from(a) + Vec3::from(b)).to_array())));
    for _ in 0..255 {
        with.sample().unwrap();
        without.sample().unwrap();
    }
    let [rested, truth] = [&with, &without].map(&mut picture);
    assert_valid(&device);
    let bytes = |picture: &[[u8; 4]]| -> Vec<i32> { picture.iter().flatten().map(|&v| v.into()).collect() };
    let [moving, alone, rested, truth] = [moving, alone, rested, truth].map(|picture| bytes(&picture));
    let error = |found: &[i32]| found.iter().zip(&truth).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>().sqrt();
    assert!(error(&moving) < f64::from(PAN) * error(&alone), "{} of {} is left", error(&moving), error(&alone));
    let worst = rested.iter().zip(&truth).map(|(a, b)| (a - b).abs()).max().unwrap();
    assert!(worst <= STEPS, "{worst} steps are left of the history");
}
