//! Pictures against closed forms, a truth made elsewhere, and the reference.

use std::f64::consts::PI;
use std::path::Path;

use glam::DVec3;
use nephroid::render::Picture;
use nephroid::scene::{self, Scene};
use nephroid::technique::TechniqueKind;

use crate::common::pool::{first_water_stretch, flat_water_inscatter, flat_water_irradiance, floor_point};
use crate::common::truth::Truth;
use crate::common::{Request, layer};
use crate::{assert_sound, load, render, sum};

/// Sums and squares of values found against those expected.
#[derive(Default)]
struct Compared {
    count: f64,
    found: f64,
    expected: f64,
    squares: f64,
}

impl Compared {
    fn add(&mut self, found: f64, expected: f64) {
        self.count += 1.0;
        self.found += found;
        self.expected += expected;
        self.squares += (found - expected).powi(2);
    }

    fn energy(&self) -> f64 {
        self.found / self.expected
    }

    /// Over the mean.
    fn rel_rmse(&self) -> f64 {
        (self.squares * self.count).sqrt() / self.expected
    }

    /// Asks for an energy within `bound`, and an RMS error within twice that.
    fn check(&self, what: &str, bound: f64) {
        let (energy, rel_rmse) = (self.energy(), self.rel_rmse());
        println!("{what}: energy {energy:.5}, relRMSE {rel_rmse:.5}");
        assert!((energy - 1.0).abs() < bound, "{what}: energy {energy}");
        assert!(rel_rmse < 2.0 * bound, "{what}: relRMSE {rel_rmse}");
    }
}

/// Of flat water, whose light is smooth: what triangles between rays leave of it.
const SMOOTH: f64 = 0.002;
/// The same along views in the water.
const SMOOTH_VOLUME: f64 = 0.005;

/// The pool with flat water that absorbs 0.02 and scatters 0.08 of light a metre.
fn turbid() -> Scene {
    let path = Path::new("scenes/flat_water.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let water = "index = 1.33\nabsorption = 0.02\nscattering = 0.08\nasymmetry = 0.7";
    scene::parse(&text.replace("index = 1.33", water), path).unwrap()
}

/// The same for both, of the flat pools: light refracted once is all that closed forms have.
const FLAT: [&str; 6] = [
    "beams.grid=8",
    "beams.levels=3",
    "beams.least_level=3",
    "beams.bounces=1",
    "beams.jitter=off",
    "beams.vertices=65536",
];

pub fn flat_water(request: &Request) {
    let (width, height) = (48.0, 36.0);
    let pixels = || (0..36).flat_map(|row| (0..48).map(move |column| (row, column)));
    let picture = render(request, load("flat_water.toml"), &FLAT, |s| s.size = Some((48, 36)));
    assert_sound(&picture);
    let found = layer(&picture.image, "caustic");
    let mut compared = Compared::default();
    for (row, column) in pixels() {
        let Some((x, z)) = floor_point(f64::from(column), f64::from(row), width, height) else { continue };
        compared.add(found[(48 * row + column) as usize][1].into(), flat_water_irradiance(x, z));
    }
    compared.check("floor", SMOOTH);

    // Rays are points of their pixels, and g makes the water's light differ by some per cent from pixel to pixel.
    let picture = render(request, turbid(), &FLAT, |s| {
        s.size = Some((48, 36));
        s.samples = Some(16);
    });
    assert_sound(&picture);
    let found = layer(&picture.image, "caustic_volume");
    let mut compared = Compared::default();
    for (row, column) in pixels() {
        let (x, y) = (f64::from(column), f64::from(row));
        let Some((origin, direction, length)) = first_water_stretch(x, y, width, height) else { continue };
        let expected = flat_water_inscatter(origin, direction, length, (0.02, 0.08, 0.7));
        compared.add(found[(48 * row + column) as usize][1].into(), expected);
    }
    compared.check("water", SMOOTH_VOLUME);
    from_above(request);
}

/// A camera of the pools.
struct Eye {
    position: DVec3,
    target: DVec3,
    fov_y: f64,
}

impl Eye {
    /// The unit way through the middle of a pixel of a film of 48 x 36.
    fn way(&self, column: i32, row: i32) -> DVec3 {
        let forward = (self.target - self.position).normalize();
        let right = forward.cross(DVec3::Y).normalize();
        let half = (0.5 * self.fov_y).to_radians().tan();
        let x = half * (4.0 / 3.0) * ((2.0 * f64::from(column) + 1.0) / 48.0 - 1.0);
        let y = half * (1.0 - (2.0 * f64::from(row) + 1.0) / 36.0);
        (forward + x * right + y * right.cross(forward)).normalize()
    }

    fn picture(&self, request: &Request, technique: TechniqueKind) -> Picture {
        let mut scene = load("flat_water.toml");
        let above = scene.cameras.iter_mut().find(|camera| camera.name == "above").unwrap();
        above.position = self.position.as_vec3();
        above.target = self.target.as_vec3();
        above.fov_y = self.fov_y as f32;
        let set: &[&str] = if technique == TechniqueKind::Beams { &FLAT } else { &[] };
        let picture = render(request, scene, set, |s| {
            s.technique = technique;
            s.camera = Some("above".to_string());
            s.size = Some((48, 36));
        });
        assert_sound(&picture);
        picture
    }
}

const WATER: f64 = 1.33;

/// What flat water reflects of unpolarised light that comes from the air.
fn reflectance(cosine: f64) -> f64 {
    let beyond = (1.0 - (1.0 - cosine * cosine) / (WATER * WATER)).sqrt();
    let across = (cosine - WATER * beyond) / (cosine + WATER * beyond);
    let along = (WATER * cosine - beyond) / (WATER * cosine + beyond);
    0.5 * (across * across + along * along)
}

/// Of what the water reflects onto the wall: beams are as wide as where it comes from is far from the wall. 1.2 % on lavapipe.
const MIRRORED: f64 = 0.03;

/// From the air: the floor through the water, in one layer, and in the other what the water reflects, twice: light of the
/// lamp on a wall, and the wall.
fn from_above(request: &Request) {
    let eye = Eye { position: DVec3::new(0.0, 5.0, 5.0), target: DVec3::new(0.0, -2.0, 0.0), fov_y: 50.0 };
    let refracted = layer(&eye.picture(request, TechniqueKind::Beams).image, "refracted");
    let mut compared = Compared::default();
    for (row, column) in (0..36).flat_map(|row| (0..48).map(move |column| (row, column))) {
        let way = eye.way(column, row);
        let at = eye.position - way * (eye.position.y / way.y);
        let below = DVec3::new(way.x, 0.0, way.z) / WATER;
        let floor = at + below * (2.0 / (1.0 - below.length_squared()).sqrt());
        if floor.x.abs() > 4.5 || floor.z.abs() > 4.5 {
            continue;
        }
        let passed = (1.0 - reflectance(-way.y)) / (WATER * WATER);
        let expected = passed * 0.8 / PI * flat_water_irradiance(floor.x, floor.z);
        compared.add(refracted[(48 * row + column) as usize][1].into(), expected);
    }
    compared.check("floor from above", SMOOTH);
    assert!(compared.count > 500.0);

    let eye = Eye { position: DVec3::new(0.0, 1.5, 3.0), target: DVec3::new(0.0, 0.0, -3.6), fov_y: 2.0 };
    let reflected = layer(&eye.picture(request, TechniqueKind::Beams).image, "reflected");
    // The lamp's own light is fifty times as bright.
    let direct = layer(&eye.picture(request, TechniqueKind::None).image, "reflected");
    let [mut compared, mut mirrored] = [Compared::default(), Compared::default()];
    for (row, column) in (0..36).flat_map(|row| (0..48).map(move |column| (row, column))) {
        let way = eye.way(column, row);
        // As if the eye were under the water, and so the lamp.
        let wall = DVec3::new(1.0, -1.0, 1.0) * eye.position + DVec3::new(1.0, -1.0, 1.0) * way * (-8.0 / way.z);
        assert!((0.0..0.5).contains(&wall.y), "{wall} is not on the wall");
        // Light of where water and wall meet comes in beams that have an edge behind the wall.
        if wall.y < 0.02 {
            continue;
        }
        let [lamp, image] = [6.0, -6.0].map(|height| DVec3::new(1.5, height, -1.0) - wall);
        let [from_lamp, from_image] = [lamp, image].map(|to| 100.0 * to.z / to.length().powi(3));
        let seen = reflectance(-way.y) * 0.6 / PI;
        let caustic = seen * reflectance(-image.y / image.length()) * from_image;
        let at = (48 * row + column) as usize;
        compared.add(reflected[at][1].into(), seen * from_lamp + caustic);
        // Lower, it comes from squares of the water that reach to the wall.
        if wall.y > 0.35 {
            mirrored.add((reflected[at][1] - direct[at][1]).into(), caustic);
        }
    }
    compared.check("wall in the water", SMOOTH);
    mirrored.check("light from the water on it", MIRRORED);
}

pub fn waves(request: &Request) {
    let truth = Truth::of_pool("under", 1);
    let mut last = f64::INFINITY;
    for levels in [3, 4, 5] {
        let levels_set = format!("beams.levels={levels}");
        let set = [&levels_set[..], "beams.grid=16", "beams.bounces=1", "beams.jitter=off", "beams.vertices=524288"];
        let picture = render(request, load("pool.toml"), &set, |s| s.size = Some(truth.size));
        assert_sound(&picture);
        let (energy, rel_rmse) = truth.against(&layer(&picture.image, "final"));
        println!("{levels} levels: relRMSE {rel_rmse:.4}, energy {energy:.5}");
        assert!((energy - 1.0).abs() < 0.01, "{levels} levels: energy {energy}");
        assert!(rel_rmse < last, "{levels} levels: relRMSE {rel_rmse} after {last}");
        last = rel_rmse;
    }
    assert!(last < FINEST, "relRMSE {last}");
}

/// Of the waves at five levels: half of what a pixel's shift leaves.
const FINEST: f64 = 0.12;

pub fn glass_sphere(request: &Request) {
    // Higher over the table than in the scene, so that the light is past its focus, and seen beside the ball.
    let text = std::fs::read_to_string("scenes/glass_sphere.toml").unwrap();
    let changed = text
        .replace("centre = [0, 1.2, 0]", "centre = [0, 2, 0]")
        .replace("position = [0.5, 3.2, 6]", "position = [-3.2, 1.5, -1.4]")
        .replace("target = [-0.4, 0.5, 0]", "target = [-1.46, 0, -0.62]")
        .replace("target = [-0.3, 0.6, -0.1]", "target = [0, 2, 0]");
    let scene = || scene::parse(&changed, Path::new("scenes/glass_sphere.toml")).unwrap();
    let size = Some((32, 24));
    let reference = request.render(scene(), |s| {
        s.technique = TechniqueKind::Reference;
        s.size = size;
        s.samples = Some(16);
        s.set = ["reference.photons=200000", "reference.reuse=4"].map(String::from).to_vec();
    });
    let expected = layer(&reference.image, "caustic");
    let beams = |bounces: u32| {
        let bounces = format!("beams.bounces={bounces}");
        let set = ["beams.grid=12", "beams.levels=4", "beams.reuse=1", &bounces];
        let picture = render(request, scene(), &set, |s| {
            s.size = size;
            s.samples = Some(4);
        });
        assert_sound(&picture);
        layer(&picture.image, "caustic")
    };
    let mut compared = Compared::default();
    for (found, expected) in beams(3).iter().zip(&expected) {
        compared.add(found[1].into(), expected[1].into());
    }
    let (energy, rel_rmse) = (compared.energy(), compared.rel_rmse());
    println!("ball: energy {energy:.4}, relRMSE {rel_rmse:.4}, reference's noise {:?}", reference.stats.noise);
    assert!((energy - 1.0).abs() < 0.03, "energy {energy}");
    assert!(rel_rmse < BALL, "relRMSE {rel_rmse}");
    // Light needs two surfaces to come through the ball; one alone leaves what is reflected outside.
    let [once, twice] = [1, 2].map(|bounces| sum(&beams(bounces)) / sum(&expected));
    println!("ball: {once:.4} of the light with one bounce, {twice:.4} with two");
    assert!(once < 0.1 && twice > 0.9, "{once} of the light with one bounce, {twice} with two");
}

/// What is left of the ball's bright rim by the reference's own blur and noise, which it says to be a few per cent.
const BALL: f64 = 0.25;
