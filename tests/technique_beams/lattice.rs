//! What beams are cut from, and how much light goes into it.

use std::collections::HashMap;
use std::path::Path;

use nephroid::frame::Sampling;
use nephroid::light_view::LightView;
use nephroid::scene::{self, Emitter, Scene};
use nephroid::technique::beams::generate::Generator;
use nephroid::technique::beams::inspect::Leaf;

use crate::beams::stage::Stage;
use crate::common::{Request, slide};
use crate::{load, pool};

const GRID: u32 = 6;
const LEVELS: u32 = 4;
/// Of a cell's light: leaves are f32, a few hundred in a cell, and made to add up.
const ADDS_UP: f64 = 1e-5;
/// The light of a cell is an integral over 32 x 32 points, summed in f32.
const QUADRATURE: f64 = 1e-4;

/// Water and a ball of glass under one light, seen from above.
fn lit(light: &str) -> String {
    format!(
        r#"
[[camera]]
name = "c"
position = [0, 5, 4]
target = [0, 0, 0]
fov_y = 60
[[medium]]
name = "water"
index = 1.33
[[medium]]
name = "glass"
index = 1.5
[[material]]
name = "surface"
kind = "dielectric"
back = "water"
[[material]]
name = "ball"
kind = "dielectric"
back = "glass"
[[material]]
name = "white"
kind = "diffuse"
albedo = 1
[[object]]
name = "w"
shape = "plane"
size = [4, 4]
material = "surface"
[[object]]
name = "b"
shape = "sphere"
centre = [0.5, 1, 0]
radius = 0.5
segments = 32
material = "ball"
[[object]]
name = "f"
shape = "plane"
centre = [0, -1, 0]
size = [40, 40]
material = "white"
[[light]]
name = "l"
{light}
"#
    )
}

const POINT: &str = "kind = \"point\"\nposition = [0.3, 3, 0.2]\nintensity = [1, 2, 3]";
/// So near to the water that it sees it on the faces of a cube.
const LOW: &str = "kind = \"point\"\nposition = [0.3, 0.3, 0.2]\nintensity = [1, 2, 3]";
const SUN: &str = "kind = \"directional\"\ndirection = [0.3, -1, 0.2]\nirradiance = [1, 2, 3]";
const SPOT: &str = "kind = \"spot\"\nposition = [0, 4, 0]\ntarget = [0.2, 0, 0]\nintensity = 2\ninner = 10\nouter = 20";
const SLIDE: &str = "kind = \"spot\"\nposition = [0, 3, 0]\ntarget = [0, 0, 0]\nintensity = 2\nouter = 33\nimage = \"i.png\"\nup = [0, 0, -1]";

fn parse(text: &str) -> Scene {
    scene::parse(text, Path::new("test.toml")).unwrap()
}

/// Views and generator after a set of beams, as on the coarse grid without jitter.
fn made(request: &Request, scene: Scene, set: &[&str]) -> (Vec<LightView>, Generator) {
    let (grid, levels) = (format!("beams.grid={GRID}"), format!("beams.levels={LEVELS}"));
    let own = [&grid[..], &levels, "beams.bounces=2", "beams.vertices=65536", "beams.least_level=1"];
    Stage::new(request, scene, (16, 12), Sampling::Uniform).generate(&[&own[..], set].concat())
}

/// Chart coordinates of the corners of a cell, of a lattice that has not moved; its last cells are beyond the view.
fn rectangle(view: &LightView, cell: u32) -> [[f64; 2]; 2] {
    let at = [cell % GRID, cell / GRID % GRID];
    [0, 1].map(|axis: usize| {
        let lower = f64::from(view.lower[axis]);
        let size = (f64::from(view.upper[axis]) - lower) / f64::from(GRID);
        [0, 1].map(|end| (lower + f64::from(at[axis] + end) * size).min(view.upper[axis].into()))
    })
}

/// Of a rectangle at distance 1, sr: the integral of (1 + u2 + v2)^-3/2.
fn solid_angle([u, v]: [[f64; 2]; 2]) -> f64 {
    let corner = |u: f64, v: f64| (u * v / (1.0 + u * u + v * v).sqrt()).atan();
    corner(u[1], v[1]) - corner(u[0], v[1]) - corner(u[1], v[0]) + corner(u[0], v[0])
}

/// W in all of the cone of a spot light whose edge is a smoothstep in the cosine: full within, half of what is between.
fn cone_light(intensity: f64, inner: f64, outer: f64) -> f64 {
    let (inside, outside) = (inner.to_radians().cos(), outer.to_radians().cos());
    2.0 * std::f64::consts::PI * intensity * (1.0 - inside + 0.5 * (inside - outside))
}

fn total(fluxes: &[[f64; 3]], channel: usize) -> f64 {
    fluxes.iter().map(|flux| flux[channel]).sum()
}

/// Each cell's leaves against the cell.
fn assert_adds_up(what: &str, leaves: &[Leaf], cells: &[[f64; 3]]) {
    let mut sums = vec![[0.0; 3]; cells.len()];
    for leaf in leaves {
        (0..3).for_each(|c| sums[leaf.cell as usize][c] += leaf.flux[c]);
    }
    let largest = cells.iter().flatten().copied().fold(0.0, f64::max);
    let mut worst = 0.0f64;
    for (cell, (sum, flux)) in sums.iter().zip(cells).enumerate() {
        for c in 0..3 {
            // Cells that the light barely touches may have none at any corner.
            let error = (sum[c] - flux[c]).abs() / flux[c].max(1e-3 * largest);
            assert!(error < ADDS_UP, "{what}, cell {cell}: leaves {sum:?}, cell {flux:?}");
            worst = worst.max(error);
        }
    }
    println!("{what}: {} leaves in {} cells are off by {worst:.1e} at the most", leaves.len(), cells.len());
}

pub fn light(request: &Request) {
    for (what, text) in [("point", POINT), ("cube", LOW), ("sun", SUN)] {
        let scene = parse(&lit(text));
        let emitter = scene.lights[0].emitter.clone();
        let (views, generator) = made(request, scene, &["beams.jitter=off"]);
        let cells = generator.cell_flux().unwrap();
        assert_adds_up(what, &generator.leaves().unwrap(), &cells);
        let mut worst = 0.0f64;
        for (cell, flux) in cells.iter().enumerate() {
            let area = rectangle(&views[cell / (GRID * GRID) as usize], cell as u32);
            let (measure, strength) = match &emitter {
                Emitter::Directional { irradiance, .. } => {
                    ((area[0][1] - area[0][0]) * (area[1][1] - area[1][0]), irradiance)
                }
                Emitter::Point { intensity, .. } | Emitter::Spot { intensity, .. } => (solid_angle(area), intensity),
            };
            for c in 0..3 {
                let expected = measure * f64::from(strength[c]);
                let error = (flux[c] - expected).abs() / expected.max(1e-6);
                assert!(error < QUADRATURE, "{what}, cell {cell}: {flux:?} W in {measure} sr or m2");
                worst = worst.max(error);
            }
        }
        if what == "cube" {
            // All round, once.
            let expected = 2.0 * 4.0 * std::f64::consts::PI;
            let found = total(&cells, 1);
            assert!(found < (1.0 + QUADRATURE) * expected && found > 0.5 * expected, "{found} of {expected} W");
        }
        println!("{what}: cells are off by {worst:.1e} at the most");
        let (_, moved) = made(request, parse(&lit(text)), &[]);
        assert_adds_up("moved by jitter", &moved.leaves().unwrap(), &moved.cell_flux().unwrap());
    }
    let (_, generator) = made(request, parse(&lit(SPOT)), &[]);
    let cells = generator.cell_flux().unwrap();
    assert_adds_up("spot", &generator.leaves().unwrap(), &cells);
    let (found, expected) = (total(&cells, 0), cone_light(2.0, 10.0, 20.0));
    println!("spot: {found} W, {expected} expected");
    assert!((found / expected - 1.0).abs() < 2e-3, "spot: {found} W, {expected} expected");
    let (_, generator) = made(request, slide::parse(&lit(SLIDE)), &[]);
    let cells = generator.cell_flux().unwrap();
    assert_adds_up("slide", &generator.leaves().unwrap(), &cells);
    let [red, green] = [0, 1].map(|channel| total(&cells, channel));
    println!("slide: {red} W of red, {green} of green");
    // Half of the image is white, and a quarter green.
    assert!((green / red - 1.5).abs() < 0.02, "slide: {red} W of red, {green} of green");
}

/// Asks that the leaves of each view cover its lattice once, edge to edge; returns how many there are.
fn assert_tiles(what: &str, views: usize, leaves: &[Leaf]) -> usize {
    let side = i64::from(GRID << LEVELS);
    let mut areas = vec![0i64; views];
    let mut edges: HashMap<(u32, [u32; 2], [u32; 2]), u32> = HashMap::new();
    for leaf in leaves {
        let [a, b, c] = leaf.corners.map(|corner| corner.map(i64::from));
        let twice = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        assert!(twice > 0, "{what}: {leaf:?} turns the wrong way");
        areas[leaf.view as usize] += twice;
        let centre = [0, 1].map(|axis: usize| ((a[axis] + b[axis] + c[axis]) / 3) >> LEVELS);
        assert_eq!(i64::from(leaf.cell % (GRID * GRID)), centre[1] * i64::from(GRID) + centre[0], "{what}: {leaf:?}");
        for k in 0..3 {
            *edges.entry((leaf.view, leaf.corners[k], leaf.corners[(k + 1) % 3])).or_default() += 1;
        }
    }
    assert!(areas.iter().all(|&area| area == 2 * side * side), "{what}: areas {areas:?}, twice {}", side * side);
    for (&(view, from, to), &count) in &edges {
        assert_eq!(count, 1, "{what}: an edge from {from:?} to {to:?} has two leaves on one side");
        let on_border = (0..2).any(|k| from[k] == to[k] && (from[k] == 0 || i64::from(from[k]) == side));
        let across = edges.contains_key(&(view, to, from));
        assert!(across != on_border, "{what}: the edge from {from:?} to {to:?} has a vertex on its other side");
    }
    println!("{what}: {} leaves, {} edges", leaves.len(), edges.len());
    leaves.len()
}

pub fn tiles(request: &Request) {
    let coarse = (2 * GRID * GRID) as usize;
    let scenes: [(&str, Scene); 5] = [
        ("ball", load("glass_sphere.toml")),
        ("waves", pool()),
        ("slide", slide::parse(&lit(SLIDE))),
        ("point", parse(&lit(POINT))),
        ("cube", parse(&lit(LOW))),
    ];
    for (what, scene) in scenes {
        let (views, generator) = made(request, scene, &["beams.least_level=0", "beams.energy=0"]);
        let count = assert_tiles(what, views.len(), &generator.leaves().unwrap());
        assert!(count > 3 * coarse * views.len(), "{what}: only {count} leaves");
    }
    // As coarse and as fine as can be.
    let all_off = ["surface", "energy", "light", "deviation"].map(|rule| format!("beams.split_{rule}=off"));
    let all_off: Vec<&str> = all_off.iter().map(String::as_str).collect();
    for (level, expected) in [("0", coarse), ("2", coarse << 4), ("4", coarse << 8)] {
        let least = format!("beams.least_level={level}");
        let (_, generator) = made(request, pool(), &[&all_off[..], &[&least]].concat());
        assert_eq!(assert_tiles("even", 1, &generator.leaves().unwrap()), expected, "level {level}");
    }
}

pub fn rules(request: &Request) {
    // Every cell is split once: what bends is told by middles that are there.
    let leaves = |scene: Scene, set: &[&str]| {
        let set = [&["beams.energy=0"][..], set].concat();
        made(request, scene, &set).1.leaves().unwrap()
    };
    let all = ["surface", "energy", "light", "deviation"];
    // Alone, since where one rule splits another may as well.
    let alone = |rule: &str| -> Vec<String> {
        all.iter().filter(|r| **r != rule).map(|r| format!("beams.split_{r}=off")).collect()
    };
    let with = |make: &dyn Fn() -> Scene, rule: &str| {
        let others = alone(rule);
        let mut set: Vec<&str> = others.iter().map(String::as_str).collect();
        let on = leaves(make(), &set);
        let off = format!("beams.split_{rule}=off");
        set.push(&off);
        (on, leaves(make(), &set).len())
    };
    let ball = || load("glass_sphere.toml");
    let cone = || parse(&lit(SPOT));
    let image = || slide::parse(&lit(SLIDE));
    let scenes: [(&str, &dyn Fn() -> Scene); 5] =
        [("surface", &ball), ("energy", &ball), ("deviation", &pool), ("light", &cone), ("light", &image)];
    for (rule, make) in scenes {
        let (on, off) = with(make, rule);
        println!("{rule}: {} leaves, {off} without", on.len());
        assert_eq!(off, (8 * GRID * GRID) as usize, "{rule} is not the only rule");
        assert!(on.len() > 2 * off, "{rule}: {} leaves, {off} without", on.len());
    }
    // The camera's rule holds the others back.
    let near = leaves(pool(), &["beams.pixels=0"]).len();
    let held = leaves(pool(), &["beams.pixels=4"]).len();
    let free = leaves(pool(), &["beams.pixels=4", "beams.split_camera=off"]).len();
    println!("camera: {held} leaves of beams wider than 4 pixels, {near} of any, {free} without the rule");
    assert!(held < near && near == free);
    small_leaves_lie_on_the_cone(request);
}

/// Where the light's own pattern is all that splits, leaves are small on the cone's edge and nowhere else.
fn small_leaves_lie_on_the_cone(request: &Request) {
    let set = ["surface", "energy", "deviation", "camera"].map(|rule| format!("beams.split_{rule}=off"));
    let mut set: Vec<&str> = set.iter().map(String::as_str).collect();
    set.extend(["beams.least_level=0", "beams.jitter=off"]);
    let hard = SPOT.replace("inner = 10", "inner = 20");
    let (views, generator) = made(request, parse(&lit(&hard)), &set);
    let view = &views[0];
    let size = [0, 1].map(|k: usize| f64::from(view.upper[k] - view.lower[k]) / f64::from(GRID << LEVELS));
    let edge = 20f64.to_radians().tan();
    let radius = |corner: [u32; 2]| {
        let at = [0, 1].map(|k: usize| f64::from(view.lower[k]) + f64::from(corner[k]) * size[k]);
        at[0].hypot(at[1])
    };
    let mut smallest = 0;
    for leaf in generator.leaves().unwrap() {
        let [a, b, c] = leaf.corners.map(|corner| corner.map(i64::from));
        let twice = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        if twice > 1 {
            continue;
        }
        // A leaf's hypotenuse, or its parent's, is across the edge.
        let near = leaf.corners.iter().any(|&corner| (radius(corner) - edge).abs() < 3.0 * size[0].hypot(size[1]));
        assert!(near, "{leaf:?} is far from the cone's edge");
        smallest += 1;
    }
    println!("{smallest} smallest leaves on the cone's edge");
    assert!(smallest > 50);
}
