use std::path::Path;

use glam::{DVec2, DVec3, Vec2, Vec3};

use super::light_views;
use super::views::COS_AIMED;
use crate::scene::{Emitter, Scene, parse};
use crate::technique::emission::{emission, solid_angle, specular_targets, triangles};

/// Points on specular triangles that each light looks at.
const POINTS: usize = 20_000;
/// Relative: sums of thousands of cells in f32 against one closed form.
const ROUNDED: f64 = 1e-5;

const SCENE: &str = r#"
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
[[material]]
name = "white"
kind = "diffuse"
albedo = 0.5
"#;

const BALL: &str = "[[object]]\nname = \"b\"\nshape = \"sphere\"\nradius = 0.5\nmaterial = \"surface\"\n";
const WATER: &str = "[[object]]\nname = \"w\"\nshape = \"plane\"\ncentre = [0.3, -1, 0]\nsize = [6, 5]\nsubdivisions = [7, 5]\nmaterial = \"surface\"\n";
const FLOOR: &str = "[[object]]\nname = \"f\"\nshape = \"plane\"\nsize = [9, 9]\nmaterial = \"white\"\n";

fn scene(objects: &[&str], light: &str) -> Scene {
    let text = format!("{SCENE}{}[[light]]\nname = \"l\"\n{light}\n", objects.concat());
    parse(&text, Path::new("test.toml")).unwrap()
}

fn point(position: [f64; 3]) -> String {
    format!("kind = \"point\"\nposition = {position:?}\nintensity = 1")
}

fn spot(position: [f64; 3], target: [f64; 3], outer: f64) -> String {
    format!("kind = \"spot\"\nposition = {position:?}\ntarget = {target:?}\nintensity = 1\nouter = {outer:?}")
}

fn sun(direction: [f64; 3]) -> String {
    format!("kind = \"directional\"\ndirection = {direction:?}\nirradiance = 1")
}

/// Lights far and near, above water and on it, inside of the ball, aimed past and at what there is.
fn scenes() -> Vec<(Scene, usize)> {
    vec![
        (scene(&[BALL], &point([0.0, 3.0, 0.0])), 1),
        (scene(&[BALL], &point([120.0, 300.0, -70.0])), 1),
        (scene(&[BALL, WATER], &point([1.0, 2.5, 0.4])), 1),
        (scene(&[WATER], &point([0.1, -0.4, 0.2])), 5),
        (scene(&[WATER], &point([0.1, -1.0, 0.2])), 6),
        (scene(&[BALL], &point([0.1, 0.2, 0.0])), 6),
        (scene(&[BALL, WATER], &spot([1.0, 2.0, 1.0], [0.0, 0.0, 0.0], 25.0)), 1),
        (scene(&[BALL, WATER], &spot([0.0, 0.2, 0.0], [0.0, -1.0, 0.0], 90.0)), 5),
        (scene(&[BALL], &spot([0.0, 2.0, 0.0], [0.0, 4.0, 0.0], 40.0)), 0),
        (scene(&[BALL, WATER], &sun([0.3, -1.0, 0.2])), 1),
        (scene(&[WATER], &sun([1.0, 0.0, 0.0])), 1),
        (scene(&[BALL, WATER], &sun([1.0, 0.02, 0.3])), 1),
        (scene(&[FLOOR], &sun([0.3, -1.0, 0.2])), 0),
        (scene(&[BALL], &point([0.0, 3.0, 0.0]).replace("intensity = 1", "intensity = 0")), 0),
    ]
}

/// Uniform in [0, 1): the fractional parts of multiples of irrational numbers.
fn noise(index: usize) -> [f64; 3] {
    [0.754_877_666_246_692_8, 0.569_840_290_998_053_2, 0.618_033_988_749_894_9]
        .map(|step| (index as f64 * step).fract())
}

fn points(scene: &Scene) -> Vec<DVec3> {
    let targets = specular_targets(scene);
    let triangles: Vec<_> = triangles(&targets).collect();
    let pick = |index: usize| {
        let [u, v, which] = noise(index);
        let [a, b, c] = triangles[(which * triangles.len() as f64) as usize];
        // Corners and edges as well as insides.
        let [u, v] = [u, v].map(|x| (1.4 * x - 0.2).clamp(0.0, 1.0));
        let [u, v] = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
        a + u * (b - a) + v * (c - a)
    };
    if triangles.is_empty() { Vec::new() } else { (0..POINTS).map(pick).collect() }
}

#[test]
fn every_line_from_a_light_to_a_specular_point_runs_through_a_view() {
    for (number, (scene, expected)) in scenes().iter().enumerate() {
        let views = light_views(scene, 17);
        assert_eq!(views.len(), *expected, "scene {number}");
        let mut tight = false;
        for point in points(scene) {
            let light = &scene.lights[0].emitter;
            if let Emitter::Spot { position, direction, outer, .. } = light {
                let way = (point - position.as_dvec3()).normalize();
                if way.dot(direction.as_dvec3()) < f64::from(*outer).cos() {
                    continue;
                }
            }
            if matches!(light, Emitter::Point { intensity, .. } if *intensity == Vec3::ZERO) {
                continue;
            }
            let seen = views.iter().any(|view| {
                let [right, up, forward, origin] = [view.right, view.up, view.forward, view.origin].map(Vec3::from);
                // As kernels do it, in f32.
                let way = point.as_vec3() - origin;
                let (across, ahead) = (Vec2::new(way.dot(right), way.dot(up)), way.dot(forward));
                let at = if view.perspective == 1 { across / ahead } else { across };
                let [lower, upper] = [view.lower, view.upper].map(Vec2::from);
                let place = (at - lower) / (upper - lower);
                tight |= place.min_element() < 0.1;
                ahead > 0.0 && ahead <= view.reach && at.cmpge(lower).all() && at.cmple(upper).all()
            });
            assert!(seen, "scene {number}: {point} is not seen");
        }
        assert!(tight || *expected == 0, "scene {number}: the rectangle is far wider than what it shows");
    }
}

#[test]
fn axes_are_orthonormal_and_right_handed() {
    for (scene, _) in scenes() {
        for view in light_views(&scene, 17) {
            let [right, up, forward] = [view.right, view.up, view.forward].map(Vec3::from);
            assert!((right.cross(up) - forward).length() < 1e-6, "{view:?}");
            assert!((right.length() - 1.0).abs() < 1e-6 && right.dot(up).abs() < 1e-6, "{view:?}");
            // What is aimed sees no farther than a chart can hold.
            let farthest = f64::from(Vec2::from(view.lower).abs().max(Vec2::from(view.upper).abs()).max_element());
            assert!(view.perspective == 0 || farthest < 1.01 / COS_AIMED, "{view:?}");
        }
    }
}

#[test]
fn views_hold_the_flux_of_the_emission_cells() {
    for (number, (scene, expected)) in scenes().iter().enumerate() {
        let views = light_views(scene, 17);
        let size = |view: &super::LightView| {
            let [lower, upper] = [view.lower, view.upper].map(|p| DVec2::from(p.map(f64::from)));
            (lower, upper - lower)
        };
        let rectangles: f64 = views
            .iter()
            .map(|view| match size(view) {
                (lower, size) if view.perspective == 1 => solid_angle(lower, size),
                (_, size) => size.element_product(),
            })
            .sum();
        let cells = f64::from(emission(scene, 4096).flux[0].x);
        assert!(cells <= rectangles * (1.0 + ROUNDED), "scene {number}: {cells} W of cells in {rectangles} W");
        assert!((cells > 0.0) == (*expected > 0), "scene {number}");
    }
}
