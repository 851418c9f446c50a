//! Light of given beams on surfaces, against f64 and closed forms.

mod beams;
mod common;

use std::path::Path;
use std::process::ExitCode;

use beams::stage::{FLOOR, Stage, counter, in_smoke, many_beams, parse, position};
use beams::{Edge, beam, beam_to_floor, oracle};
use common::pool::flat_water_irradiance;
use common::{Case, Request};
use glam::{DVec3, dvec3};
use nephroid::frame::{Sampling, VisiblePoint};
use nephroid::scene;
use nephroid::technique::beams::accumulate::{Area, Options, Shadows};
use nephroid::technique::beams::beam::{Beam, EMPTY, STRADDLES};

fn main() -> ExitCode {
    common::run(&[
        Case { name: "surfaces_are_lit_as_in_f64", needs: &[], disable: "", run: surfaces },
        Case { name: "a_beam_lands_with_all_its_flux", needs: &[], disable: "", run: flux },
        Case { name: "flat_water_is_the_closed_form", needs: &[], disable: "", run: flat_water },
        Case { name: "shadows_fall", needs: &[], disable: "", run: shadows },
        Case { name: "degenerate_beams_are_dark_or_finite", needs: &[], disable: "", run: degenerate },
        Case { name: "adaptive_rounds_and_equal_bits", needs: &[], disable: "", run: adaptive },
    ])
}

/// Against f64, where f32 has positions of metres and beams of centimetres.
const ROUNDING: f64 = 2e-4;

/// How near a beam's side a point may be for f32 and f64 to put it on different sides.
const SIDE: f64 = 1e-4;

/// The oracle's sum at a point; `None` where f32 may see it on the other side of a beam's side.
fn expected(beams: &[Beam], point: &VisiblePoint, extinction: f64, options: &Options) -> Option<f64> {
    let at = position(point);
    let mut sum = 0.0;
    for beam in beams {
        let near = oracle::place(beam, at).is_some_and(|place| place.depth().abs() < SIDE && place.distance > 0.0);
        if near {
            return None;
        }
        let angle = f64::from(options.light_angle);
        let smooth = options.area == Area::Vertex;
        sum += f64::from(beam.flux[0]) * oracle::irradiance(beam, at, DVec3::Y, extinction, angle, smooth);
    }
    Some(sum)
}

/// Compares every point with the oracle; returns how many were compared.
fn compare(found: &[(VisiblePoint, [f32; 4])], beams: &[Beam], extinction: f64, options: &Options) -> usize {
    let mut compared = 0;
    for (point, irradiance) in found {
        let Some(sum) = expected(beams, point, extinction, options) else { continue };
        let difference = (f64::from(irradiance[0]) - sum).abs();
        assert!(difference <= ROUNDING * sum, "{:?}: {} instead of {sum}", point.position, irradiance[0]);
        compared += usize::from(sum > 0.0);
    }
    compared
}

fn surfaces(request: &Request) {
    let beams = many_beams();
    let mut stage = Stage::new(request, parse(FLOOR), (61, 45), Sampling::Uniform);
    for (area, shadows) in [(Area::Vertex, Shadows::Points), (Area::Beam, Shadows::Edges)] {
        let options = Options { area, shadows, ..Default::default() };
        let accumulator = stage.accumulator(&beams, options);
        let found = stage.sample(&accumulator, 0);
        let compared = compare(&found, &beams, 0.0, &options);
        println!("{compared} of {} points compared; {:?}", found.len(), accumulator.counters().unwrap());
        assert!(compared > 61 * 45 / 2, "{compared} points compared");
        assert_eq!(counter(&accumulator, "beam_shadow_rays") > 0.0, shadows == Shadows::Points);
        // Most of the work that all pairs would be is not done: 3007 beams at 61 x 45 points.
        assert!(counter(&accumulator, "beam_tests") < 0.1 * 3007.0 * 61.0 * 45.0);
    }

    // What is absorbed on the way.
    let beams: Vec<Beam> = beams.into_iter().map(|beam| Beam { medium: 1, ..beam }).collect();
    let mut stage = Stage::new(request, parse(&in_smoke("absorption = 0.7")), (61, 45), Sampling::Uniform);
    let accumulator = stage.accumulator(&beams, Options::default());
    let found = stage.sample(&accumulator, 0);
    assert!(compare(&found, &beams, 0.7, &Options::default()) > 61 * 45 / 2);
}

fn flux(request: &Request) {
    // Each pixel covers the same of the floor: half the picture is 4 tan(30 degrees) high there.
    let (width, height, samples) = (64u32, 48u32, 16u32);
    let pixel = (2.0 * 4.0 * 30f64.to_radians().tan() / f64::from(height)).powi(2);
    let mut stage = Stage::new(request, parse(FLOOR), (width, height), Sampling::Uniform);
    for (index, mut one) in many_beams().into_iter().take(7).enumerate() {
        // Corners that are bright and dark by turns: what one gains the others lose.
        for (corner, flux) in one.corners.iter_mut().zip([1.0, 4.0, 0.5]) {
            corner.flux = flux;
        }
        let accumulator = stage.accumulator(&[one], Options::default());
        let mut sum = 0.0;
        for sample in 0..samples {
            let found = stage.sample(&accumulator, sample);
            sum += found.iter().map(|(_, e)| f64::from(e[0]) * pixel).sum::<f64>() / f64::from(samples);
        }
        let ratio = sum / f64::from(one.flux[0]);
        println!("beam {index}: {ratio:.4} of its flux");
        // The border of a triangle some twenty pixels wide, at sixteen points a pixel.
        assert!((ratio - 1.0).abs() < 0.01, "beam {index}: {ratio}");
    }
}

/// Refracts the lamp of `flat_water.toml` at the water above (x, z): the edge from there to the floor at y = -2.
fn refracted_edge(x: f64, z: f64) -> (Edge, f64) {
    let lamp = dvec3(1.5, 6.0, -1.0);
    let ray = |x: f64, z: f64| {
        let start = dvec3(x, 0.0, z);
        let before = (start - lamp).normalize();
        let across = dvec3(before.x, 0.0, before.z) / 1.33;
        (start, across - DVec3::Y * (1.0 - across.length_squared()).sqrt())
    };
    let transmitted = {
        let (start, way) = ray(x, z);
        let (c1, c2) = (-(start - lamp).normalize().y, -way.y);
        let perpendicular = ((c1 - 1.33 * c2) / (c1 + 1.33 * c2)).powi(2);
        let parallel = ((1.33 * c1 - c2) / (1.33 * c1 + c2)).powi(2);
        1.0 - 0.5 * (perpendicular + parallel)
    };
    let flux_through = {
        // 100 W/sr through a square metre of the water here.
        let way = dvec3(x, 0.0, z) - lamp;
        100.0 * 6.0 / way.length().powi(3) * transmitted
    };
    let (start, way) = ray(x, z);
    // What a square of the water spreads out to, across the way; quadratic in the length, so three lengths tell it.
    let small = 1e-3;
    let area = |l: f64| {
        let at = |dx: f64, dz: f64| {
            let (s, w) = ray(x + dx, z + dz);
            s + w * ((start + way * l - s).dot(way) / w.dot(way))
        };
        let (u, v) = (at(small, 0.0) - at(-small, 0.0), at(0.0, -small) - at(0.0, small));
        u.cross(v).dot(way).abs() / (4.0 * small * small)
    };
    let (a0, a1, a2) = (area(0.0), area(1.0), area(2.0));
    let square = 0.5 * (a2 - 2.0 * a1 + a0);
    let edge = Edge { start, way, length: 2.0 / -way.y, area: [a0, a1 - a0 - square, square], flux: flux_through };
    (edge, flux_through)
}

/// Beams through a grid of `cells` x `cells` squares of the water.
fn flat_water_beams(cells: u32) -> Vec<Beam> {
    let at = |i: u32| -5.0 + 10.0 * f64::from(i) / f64::from(cells);
    let side = 10.0 / f64::from(cells);
    let mut all = Vec::new();
    for row in 0..cells {
        for column in 0..cells {
            let corner = |dx: u32, dz: u32| refracted_edge(at(column + dx), at(row + dz));
            let (a, b, c, d) = (corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1));
            for three in [[a, b, c], [a, c, d]] {
                // The flux over a triangle, by the mean of its corners.
                let flux = three.iter().map(|(_, flux)| flux).sum::<f64>() / 3.0 * 0.5 * side * side;
                all.push(beam(three.map(|(edge, _)| edge), flux, 1));
            }
        }
    }
    all
}

/// Of the union of beams 0.16 m wide against the closed form: what the mean of three corners is off for a square's flux.
const FLAT_WATER: f64 = 2e-3;

fn flat_water(request: &Request) {
    let beams = flat_water_beams(64);
    let scene = scene::load(Path::new("scenes/flat_water.toml")).unwrap();
    let mut stage = Stage::new(request, scene, (60, 45), Sampling::Uniform);
    let accumulator = stage.accumulator(&beams, Options::default());
    let (mut worst, mut compared): (f64, _) = (0.0, 0);
    for (point, irradiance) in stage.sample(&accumulator, 0) {
        let p = position(&point);
        if (p.y + 2.0).abs() > 1e-3 || p.x.abs() > 4.5 || p.z.abs() > 4.5 {
            continue;
        }
        worst = worst.max((f64::from(irradiance[0]) / flat_water_irradiance(p.x, p.z) - 1.0).abs());
        compared += 1;
    }
    println!("{compared} points, worst {worst:.2e}; {:?}", accumulator.counters().unwrap());
    assert!(compared > 500, "{compared} points on the floor");
    assert!(worst < FLAT_WATER, "{worst}");
}

/// A plate half a metre above the floor, at x from 0 to 1.
const PLATE: &str = r#"
[[object]]
name = "plate"
shape = "plane"
centre = [0.5, 0.5, 0]
size = [1, 0.6]
material = "floor"
"#;

fn shadows(request: &Request) {
    let corners = [dvec3(-4.0, 2.0, -3.0), dvec3(5.0, 2.0, -3.0), dvec3(0.0, 2.0, 5.0)];
    // Light comes from the right, so that the shadow shows beside the plate: from x = -0.25 to 0.
    let mut one = beam_to_floor(corners, [dvec3(-1.0, -2.0, 0.0); 3], 1.0, 0.0);
    let mut stage = Stage::new(request, parse(&format!("{FLOOR}{PLATE}")), (60, 45), Sampling::Uniform);
    let under = |p: DVec3| p.x > -0.24 && p.x < 0.0 && p.z.abs() < 0.29 && p.y < 0.4;
    for (flags, shadows, dark) in
        [(0, Shadows::Points, true), (0, Shadows::Edges, false), (STRADDLES, Shadows::Edges, true)]
    {
        one.flags = flags;
        let accumulator = stage.accumulator(&[one], Options { shadows, ..Default::default() });
        let found = stage.sample(&accumulator, 0);
        let mut counts = [0; 2];
        for (point, irradiance) in &found {
            let at = position(point);
            if under(at) {
                counts[0] += 1;
                assert_eq!(irradiance[0] > 0.0, !dark, "{at}, {shadows:?}, flags {flags}");
            } else if at.y > 0.4 {
                counts[1] += 1;
                assert!(irradiance[0] > 0.0, "the plate is lit at {at}, {shadows:?}, flags {flags}");
            }
        }
        println!("{counts:?} points under and on the plate");
        assert!(counts[0] > 0 && counts[1] > 20, "{counts:?}");
    }
}

fn degenerate(request: &Request) {
    let good = many_beams().swap_remove(0);
    let mut all = vec![good];
    // No area at all, a line, all of it in one point of the floor, an empty slot, and numbers that are none.
    let point = dvec3(0.1, 2.0, 0.1);
    all.push(beam_to_floor([point; 3], [DVec3::NEG_Y; 3], 1.0, 0.0));
    all.push(beam_to_floor([point, point + DVec3::X, point + 2.0 * DVec3::X], [DVec3::NEG_Y; 3], 1.0, 0.0));
    let corners = [dvec3(-1.0, 2.0, -1.0), dvec3(1.0, 2.0, -1.0), dvec3(0.0, 2.0, 1.0)];
    all.push(beam_to_floor(corners, corners.map(|p| -p), 1.0, 0.0));
    all.push(Beam { flags: EMPTY, flux: [f32::NAN; 3], ..good });
    all.push(Beam { flux: [f32::INFINITY; 3], ..good });
    let mut broken = good;
    broken.corners[1].way[0] = f32::NAN;
    all.push(broken);
    let mut endless = good;
    endless.corners[2].end = f32::INFINITY;
    all.push(endless);
    let mut stage = Stage::new(request, parse(FLOOR), (60, 45), Sampling::Uniform);
    let accumulator = stage.accumulator(&all, Options::default());
    let found = stage.sample(&accumulator, 0);
    assert!(found.iter().all(|(_, e)| e.iter().all(|v| v.is_finite())));
    let lit = compare(&found, &[good], 0.0, &Options::default());
    assert!(lit > 100, "{lit} points in the one good beam");
    // The beam of infinite flux at every point inside, and two that have no box.
    assert!(counter(&accumulator, "beam_fragments_non_finite") >= 2.0 + lit as f64);

    // Light that is all absorbed.
    let mut stage = Stage::new(request, parse(&in_smoke("absorption = 1e9")), (60, 45), Sampling::Uniform);
    let accumulator = stage.accumulator(&[Beam { medium: 1, ..good }], Options::default());
    assert!(stage.sample(&accumulator, 0).iter().all(|(_, e)| e[0] == 0.0));
    assert_eq!(counter(&accumulator, "beam_fragments_non_finite"), 0.0);
}

fn adaptive(request: &Request) {
    let beams = many_beams();
    let mut stage = Stage::new(request, parse(FLOOR), (61, 45), Sampling::Adaptive { samples: 4 });
    let accumulator = stage.accumulator(&beams, Options::default());
    let found = stage.sample(&accumulator, 0);
    assert!(compare(&found, &beams, 0.0, &Options::default()) > 61 * 45 / 2);
    let again = stage.sample(&stage.accumulator(&beams, Options::default()), 0);
    let bits = |all: &[(VisiblePoint, [f32; 4])]| all.iter().map(|(_, e)| e.map(f32::to_bits)).collect::<Vec<_>>();
    assert!(bits(&found) == bits(&again), "the same beams gave different bits");
}
