//! The low-pass filter on surfaces: what is even stays, no light is lost, and none goes where another surface is.

use glam::{DVec3, Vec3, dvec3};
use nephroid::frame::{Sampling, VisiblePoint};
use nephroid::scene::Scene;
use nephroid::technique::beams::accumulate::{Area, Options, Tier};
use nephroid::technique::beams::beam::Beam;
use nephroid::view::Band;

use crate::beams::beam_to_floor;
use crate::beams::stage::{FLOOR, Stage, many_beams, parse, position};
use crate::common::Request;

const SIZE: (u32, u32) = (61, 45);

/// Pixels.
const SIGMA: f32 = 2.5;

/// Light at points, of each beam's own area, so that beams' sides are sharp.
const SHARP: Options = Options { footprints: false, area: Area::Beam, ..Options::DEFAULT };
const FILTERED: Options = Options { filter: SIGMA, ..SHARP };

/// Each slot's point and what it gets, dark where it sees none.
type Slots = Vec<(VisiblePoint, f64)>;

fn slots(stage: &mut Stage, beams: &[Beam], options: Options) -> Slots {
    let accumulator = stage.accumulator(beams, options);
    stage.sample(&accumulator, 0);
    let found: Vec<[f32; 4]> = stage.read("SampleIrradiance", 1);
    let points: Vec<VisiblePoint> = stage.read("VisiblePoints", 1);
    let value = |point: &VisiblePoint, found: [f32; 4]| if point.instance == u32::MAX { 0.0 } else { found[0].into() };
    points.into_iter().zip(found).map(|(point, found)| (point, value(&point, found))).collect()
}

fn stage(request: &Request, scene: Scene) -> Stage {
    Stage::new(request, scene, SIZE, Sampling::Uniform)
}

/// The floor from the side: its pixels cover from 1 to some 40 times the same area.
fn slanted() -> String {
    FLOOR
        .replace("position = [0, 4, 0]", "position = [0, 2, 2.5]")
        .replace("up = [0, 0, -1]\nfov_y = 60", "up = [0, 1, 0]\nfov_y = 50")
}

/// Light straight down on the triangle between points of the floor.
fn down_on(corners: [(f64, f64); 3]) -> Beam {
    beam_to_floor(corners.map(|(x, z)| dvec3(x, 3.0, z)), [DVec3::NEG_Y; 3], 1.0, 0.0)
}

/// All that is left of the plane x = `end`.
fn left_of(end: f64) -> [Beam; 2] {
    let (low, high) = ((-50.0, -50.0), (end, 50.0));
    [down_on([low, (end, -50.0), (low.0, high.1)]), down_on([(end, -50.0), high, (low.0, high.1)])]
}

/// What f32 makes of an even light, over it.
const ROUNDING: f64 = 1e-5;

/// The floor's plane through a pixel's four corners, and at its middle by its neighbours: what areas are off.
const AREAS: f64 = 5e-4;

pub fn flat_and_flux(request: &Request) {
    let even = |slots: &Slots| {
        let lit: Vec<f64> = slots.iter().filter(|(point, _)| point.instance != u32::MAX).map(|(_, e)| *e).collect();
        assert_eq!(lit.len(), (SIZE.0 * SIZE.1) as usize);
        lit.iter().map(|e| (e / lit[0] - 1.0).abs()).fold(0.0, f64::max)
    };
    let everywhere = [down_on([(-60.0, 20.0), (60.0, 20.0), (0.0, -90.0)])];
    let mut stage = stage(request, parse(&slanted()));
    for filter in [0.3, SIGMA, 16.0] {
        let worst = even(&slots(&mut stage, &everywhere, Options { filter, ..SHARP }));
        println!("{filter} pixels: even light changes by {worst:.1e}");
        assert!(worst < ROUNDING, "{filter} pixels: {worst}");
    }

    // Light in the middle of the picture, on pixels that cover less than their neighbours and more.
    let spots = [(0.0, 1.0), (-0.5, 0.0), (0.7, -0.9), (0.2, -2.0)]
        .map(|(x, z)| down_on([(x - 0.2, z - 0.2), (x + 0.2, z - 0.1), (x, z + 0.2)]));
    // What a pixel covers of a plane goes with the cube of its depth.
    let eye = dvec3(0.0, 2.0, 2.5);
    let forward = (-eye).normalize();
    let area = |at: DVec3| (at - eye).dot(forward).powi(3);
    let flux = |slots: &Slots| slots.iter().map(|(point, e)| e * area(position(point))).sum::<f64>();
    let [sharp, filtered] = [SHARP, FILTERED].map(|options| slots(&mut stage, &spots, options));
    let ratio = flux(&filtered) / flux(&sharp);
    println!("{ratio} of the flux on a slanted floor");
    assert!((ratio - 1.0).abs() < AREAS, "{ratio}");
    let most = |slots: &Slots| slots.iter().map(|(_, e)| *e).fold(0.0, f64::max);
    assert!(most(&filtered) < 0.8 * most(&sharp) && filtered.iter().all(|(_, e)| *e >= 0.0));
}

/// The second moments of a layer's light, in pixels^2.
fn spread(slots: &Slots, layer: usize) -> [f64; 2] {
    let pixels = (SIZE.0 * SIZE.1) as usize;
    let lit: Vec<(f64, f64, f64)> = (0..pixels)
        .map(|place| (place as u32 % SIZE.0, place as u32 / SIZE.0, slots[layer * pixels + place].1))
        .map(|(x, y, e)| (f64::from(x), f64::from(y), e))
        .collect();
    let total: f64 = lit.iter().map(|(_, _, e)| e).sum();
    assert!(total > 0.0, "no light in layer {layer}");
    let mean = |value: &dyn Fn(f64, f64) -> f64| lit.iter().map(|&(x, y, e)| e * value(x, y)).sum::<f64>() / total;
    let (x, y) = (mean(&|x, _| x), mean(&|_, y| y));
    [mean(&|at, _| (at - x).powi(2)), mean(&|_, at| (at - y).powi(2))]
}

/// A clear pane under the camera that shows it a ceiling, in its second layer.
const MIRRORED: &str = r#"
[[medium]]
name = "glass"
index = 1.5
[[material]]
name = "pane"
kind = "dielectric"
front = "air"
back = "glass"
[[object]]
name = "pane"
shape = "plane"
centre = [0, 1, 0]
size = [20, 20]
material = "pane"
[[object]]
name = "ceiling"
shape = "plane"
centre = [0, 6, 0]
size = [100, 100]
material = "floor"
"#;

/// Areas of pixels that look straight down differ by less than rounding.
const MOMENTS: f64 = 1e-3;

pub fn width(request: &Request) {
    // A Gaussian that ends at three standard deviations.
    let weight = |k: i32| (-0.5 * (f64::from(k) / f64::from(SIGMA)).powi(2)).exp();
    let all = || -8..=8;
    let expected = all().map(|k| f64::from(k * k) * weight(k)).sum::<f64>() / all().map(weight).sum::<f64>();
    let ceiling = {
        let corners = [dvec3(-0.3, 5.0, -0.2), dvec3(0.1, 5.0, -0.3), dvec3(0.2, 5.0, 0.3)];
        beam_to_floor(corners, [DVec3::Y; 3], 1.0, 6.0)
    };
    let floor = down_on([(-0.2, -0.2), (0.2, -0.1), (0.0, 0.2)]);
    let mirrored = parse(&format!("{FLOOR}{MIRRORED}"));
    for (layer, scene, beam) in [(0, parse(FLOOR), floor), (1, mirrored, ceiling)] {
        let mut stage = stage(request, scene);
        let [sharp, filtered] = [SHARP, FILTERED].map(|options| spread(&slots(&mut stage, &[beam], options), layer));
        for axis in 0..2 {
            let more = filtered[axis] - sharp[axis];
            println!("layer {layer}: {:.4} and {more:.4} pixels^2, {expected:.4} expected", sharp[axis]);
            assert!((more / expected - 1.0).abs() < MOMENTS, "layer {layer}: {more}, not {expected}");
        }
    }
}

/// The floor in two instances that meet at x = 0.
fn two_floors() -> Scene {
    let half = |name: &str, x: &str| {
        FLOOR[FLOOR.find("[[object]]").unwrap()..]
            .replace("name = \"floor\"", &format!("name = \"{name}\""))
            .replace("centre = [0, 0, 0]\nsize = [100, 100]", &format!("centre = [{x}, 0, 0]\nsize = [50, 100]"))
    };
    let head = &FLOOR[..FLOOR.find("[[object]]").unwrap()];
    parse(&format!("{head}{}{}", half("left", "-25"), half("right", "25")))
}

/// The floor with a step at x = 0, in one mesh: on the right it is lower by 0.15 m, two pixels.
fn step() -> Scene {
    let mut scene = two_floors();
    let right = scene.instances.pop().unwrap();
    let other = scene.meshes[right.mesh].clone();
    let back = scene.instances[0].transform.inverse() * right.transform;
    let mesh = &mut scene.meshes[scene.instances[0].mesh];
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(other.positions.iter().map(|&p| back.transform_point3(p) - 0.15 * Vec3::Y));
    mesh.normals.extend(other.normals);
    mesh.uvs.extend(other.uvs);
    mesh.triangles.extend(other.triangles.iter().map(|triangle| triangle.map(|corner| corner + first)));
    scene
}

fn with_box(centre: &str, size: &str, camera: &str) -> Scene {
    let object = format!(
        "[[object]]\nname = \"box\"\nshape = \"box\"\ncentre = {centre}\nsize = {size}\nmaterial = \"floor\"\n"
    );
    parse(&format!("{}{object}", FLOOR.replace("position = [0, 4, 0]", &format!("position = {camera}"))))
}

/// Whether a point is beyond the border of the light.
type Dark = fn(DVec3) -> bool;

/// Light up to a border beyond which is another surface, all of which stays dark to the last bit.
pub fn leaks(request: &Request) {
    // The step's foot is hidden from the light that falls on its upper part alone: beams end there.
    let scenes: [(&str, Scene, f64, Dark); 4] = [
        ("two floors that meet", two_floors(), 0.0, |at| at.x > 0.0),
        ("a step", step(), 0.0, |at| at.y < -0.1),
        ("a box's side", with_box("[-1, 0.5, 0]", "[2, 1, 20]", "[2, 4, 0]"), 0.001, |at| at.y > 0.02 && at.y < 0.98),
        ("behind a thin wall", with_box("[0.05, 0.1, 0]", "[0.15, 0.2, 20]", "[0, 4, 0]"), 0.05, |at| {
            at.y < 0.01 && at.x > 0.12
        }),
    ];
    for (what, scene, end, dark) in scenes {
        let beams = left_of(end);
        let mut stage = stage(request, scene);
        let [sharp, filtered] = [SHARP, FILTERED].map(|options| slots(&mut stage, &beams, options));
        let (mut in_dark, mut changed) = (0, 0);
        for ((point, before), (_, after)) in sharp.iter().zip(&filtered).filter(|(a, _)| a.0.instance != u32::MAX) {
            if dark(position(point)) {
                assert_eq!((*before, *after), (0.0, 0.0), "{what}: light at {}", position(point));
                in_dark += 1;
            }
            changed += usize::from(before != after);
        }
        println!("{what}: {in_dark} points in the dark, {changed} changed");
        assert!(in_dark > 100, "{what}: {in_dark} points in the dark");
    }
}

/// What a picture's border does to areas beside it.
const BORDER: f64 = 1e-5;

pub fn bands(request: &Request) {
    let beams = many_beams();
    let scene = || parse(&slanted());
    let whole = slots(&mut stage(request, scene()), &beams, FILTERED);
    let everywhere = [down_on([(-60.0, 20.0), (60.0, 20.0), (0.0, -90.0)])];
    let radius = (3.0 * SIGMA).ceil() as u32;
    for band in [Band { first: 0, count: 20 }, Band { first: 20, count: SIZE.1 - 20 }] {
        let mut stage = Stage::of_band(request, scene(), SIZE, band);
        let part = slots(&mut stage, &beams, FILTERED);
        let mut compared = 0;
        for row in 0..band.count {
            let picture_row = band.first + row;
            // The row beside the border has an area of one side, too.
            if picture_row.abs_diff(20) <= radius + 1 {
                continue;
            }
            for x in 0..SIZE.0 {
                let found = part[(row * SIZE.0 + x) as usize].1;
                let expected = whole[(picture_row * SIZE.0 + x) as usize].1;
                assert!((found - expected).abs() <= BORDER * expected, "row {picture_row}: {found}, not {expected}");
                compared += usize::from(expected > 0.0);
            }
        }
        assert!(compared > 100, "{compared} pixels");
        // Rows that are missing take no light.
        let even = slots(&mut stage, &everywhere, FILTERED);
        let pixels = (SIZE.0 * band.count) as usize;
        assert!(even[..pixels].iter().all(|(_, e)| (e / even[0].1 - 1.0).abs() < ROUNDING));
    }
}

pub fn equal_bits(request: &Request) {
    let beams = many_beams();
    let bits = |slots: Slots| slots.into_iter().map(|(_, e)| e.to_bits()).collect::<Vec<_>>();
    let picture = |options: Options| bits(slots(&mut stage(request, parse(&slanted())), &beams, options));
    let first = picture(FILTERED);
    assert!(first == picture(FILTERED), "the same beams gave different bits");
    assert!(first != picture(SHARP), "the filter has no effect");
    // Slots of an adaptive round are not pixels: there is no filter.
    let adaptive = |options: Options| {
        let mut stage = Stage::new(request, parse(&slanted()), SIZE, Sampling::Adaptive { samples: 4 });
        bits(slots(&mut stage, &beams, options))
    };
    assert!(adaptive(FILTERED) == adaptive(SHARP), "a round's slots are filtered");
    // It comes after hulls as after tiles.
    let drawn = Options { tier: Some(Tier::Vertices), ..FILTERED };
    let by_hulls = slots(&mut stage(request, parse(&slanted())), &beams, drawn);
    let by_tiles = slots(&mut stage(request, parse(&slanted())), &beams, FILTERED);
    let squares: f64 = by_hulls.iter().zip(&by_tiles).map(|(a, b)| (a.1 - b.1).powi(2)).sum();
    let error = (squares / by_tiles.iter().map(|(_, e)| e * e).sum::<f64>()).sqrt();
    println!("tiers differ by {error:.1e}");
    assert!(error < TIERS, "{error}");
}

/// Orders of sums; as `technique_beams_tiers` has it.
const TIERS: f64 = 1e-3;
