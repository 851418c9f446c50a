//! Light along the wave against closed forms.

use glam::{DVec2, DVec3, Vec3};
use nephroid::scene::Emitter;
use nephroid::technique::eikonal::{Grid, Intensity, Spread, VolumeOptions};

use super::common::pool::refracted_light;
use super::{QUADS, Request, Rig, WATER, cube, water};

/// Of flat water's light, what it may be off anywhere.
const FLAT: f64 = 0.005;
/// Of a lamp's light, largest and mean: sides and what is next to the surface have differences of lower order.
const LAMP: (f64, f64) = (0.02, 0.002);
/// Of the light on a cap's axis.
const AXIS: f64 = 0.03;

fn options(grid: Grid) -> VolumeOptions {
    VolumeOptions { grid: Some(grid), ..VolumeOptions::default() }
}

/// The largest and mean part by which light is off, where it is known: between four cells, u and v being x and z.
fn off(rig: &Rig, exact: impl Fn(DVec3) -> f64) -> (f64, f64) {
    let light = lit(rig);
    let grid = *rig.volume.grid();
    let mut wrong = Vec::new();
    for (index, &light) in light.iter().enumerate().filter(|(_, light)| **light >= 0.0) {
        let between = grid.centre(grid.place(index)) + DVec3::new(0.5, 0.0, 0.5) * grid.cell;
        wrong.push((f64::from(light) / exact(between) - 1.0).abs());
    }
    assert!(wrong.iter().all(|off| off.is_finite()));
    // The top eighth is air, and a row each has no neighbour.
    assert!(wrong.len() as u32 >= 31 * 27 * 31, "{} have light", wrong.len());
    (wrong.iter().copied().fold(0.0, f64::max), wrong.iter().sum::<f64>() / wrong.len() as f64)
}

fn lit(rig: &Rig) -> Vec<f32> {
    rig.wave();
    rig.run(|recorder| rig.volume.record_light(recorder, &rig.scene.bindings, &rig.kernels).unwrap());
    rig.volume.read_light().unwrap()
}

/// Of parallel light on flat water, the part that is just below, across its way.
pub fn below(cos_in: f64, index: f64) -> f64 {
    let cos_out = (1.0 - (1.0 - cos_in * cos_in) / (index * index)).sqrt();
    let perpendicular = ((cos_in - index * cos_out) / (cos_in + index * cos_out)).powi(2);
    let parallel = ((index * cos_in - cos_out) / (index * cos_in + cos_out)).powi(2);
    (1.0 - 0.5 * (perpendicular + parallel)) * cos_in / cos_out
}

/// Parallel light, straight and aslant, is the same everywhere, sides and edges included.
pub fn flat(request: &Request) {
    for direction in [DVec3::NEG_Y, DVec3::new(0.7, -1.0, 0.2), DVec3::new(-0.5, -1.0, -1.1)] {
        let direction = direction.as_vec3().normalize();
        let emitter = Emitter::Directional { direction, irradiance: Vec3::ONE };
        let rig = Rig::new(request, &water(emitter, 8.0, 1, |_| 0.0), &options(cube(32)));
        let (most, _) = off(&rig, |_| below(-f64::from(direction.y), WATER));
        println!("{direction}: {most:.1e}");
        assert!(most < FLAT, "{direction}: {most}");
    }
}

/// A lamp's light through flat water.
pub fn lamp(request: &Request) {
    let emitter = Emitter::Point { position: Vec3::new(1.5, 6.0, -1.0), intensity: Vec3::splat(100.0) };
    let rig = Rig::new(request, &water(emitter, 8.0, 1, |_| 0.0), &options(cube(32)));
    let (most, mean) = off(&rig, |at| refracted_light(at).fluence / 100.0);
    println!("largest {most:.4}, mean {mean:.5}");
    assert!(most < LAMP.0 && mean < LAMP.1, "{most} and {mean}");
}

/// On the axis of a cap light grows as the square of what is left to its focus falls.
pub fn cap(request: &Request) {
    let radius = 1.0;
    let cap = |at: DVec2| (radius * radius - at.length_squared()).max(0.0).sqrt() - radius;
    let emitter = Emitter::Directional { direction: Vec3::NEG_Y, irradiance: Vec3::ONE };
    let grid = Grid { lower: DVec3::new(-0.62, -1.16, -0.62), cell: 0.04, cells: [31, 32, 31] };
    let rig = Rig::new(request, &water(emitter, 1.4, 240, cap), &options(grid));
    let light = lit(&rig);
    let focus = radius * WATER / (WATER - 1.0);
    for plane in [3, 12, 21] {
        let at = [15, plane, 15];
        let depth = -grid.centre(at).y;
        // Four lie around the axis.
        let around = [[14, 14], [14, 15], [15, 14], [15, 15]].map(|[x, z]| f64::from(light[grid.index([x, plane, z])]));
        let found = around.iter().sum::<f64>() / 4.0;
        let expected = below(1.0, WATER) * (focus / (focus - depth)).powi(2);
        println!("{depth} m: {:.4}", found / expected);
        assert!((found / expected - 1.0).abs() < AXIS, "{depth} m down: {found} for {expected}");
    }
}

/// Waves that fold light within the cube, whose sum over x and z is not changed by moving.
fn folding() -> nephroid::scene::Scene {
    let emitter = Emitter::Directional { direction: Vec3::NEG_Y, irradiance: Vec3::ONE };
    water(emitter, 8.0, 2 * QUADS, |at| 0.06 * (3.3 * at.x).sin() * (2.9 * at.y).cos())
}

/// What passes each plane of a volume, and the plane's cells.
fn passing(grid: &Grid, light: &[f32]) -> Vec<f64> {
    let of_plane = |y: u32| {
        let cells = (0..grid.cells[2]).flat_map(|z| (0..grid.cells[0]).map(move |x| grid.index([x, y, z])));
        cells.map(|at| f64::from(light[at]).max(0.0)).sum::<f64>()
    };
    (0..grid.cells[1]).map(of_plane).collect()
}

/// Of the light that passes planes, what waves bring in and out by the sides of one of them; 0.3 % on llvmpipe.
const SIDES: f64 = 0.01;

/// As much light passes a plane after waves have folded it as before.
pub fn conserved(request: &Request) {
    let rig = Rig::new(request, &folding(), &options(cube(32)));
    let light = lit(&rig);
    let planes = passing(rig.volume.grid(), &light);
    // Light goes down; the first planes that are whole lie under the troughs.
    let whole = &planes[..25];
    let expected = below(1.0, WATER) * 31.0 * 31.0;
    for (y, passing) in whole.iter().enumerate() {
        assert!((passing / expected - 1.0).abs() < SIDES, "plane {y}: {}", passing / expected);
    }
    // Folded it is.
    let most = light.iter().copied().fold(0.0, f32::max);
    assert!(most > 2.0, "{most}");
}

/// Waves in planes only move light about, and take from the brightest.
pub fn spread(request: &Request) {
    let [still, spread] = [None, Some(Spread { threshold: 1.0, slope: 0.1 })].map(|spread| {
        let rig = Rig::new(request, &folding(), &VolumeOptions { spread, ..options(cube(32)) });
        let light = lit(&rig);
        (passing(rig.volume.grid(), &light), light)
    });
    for (y, (before, after)) in still.0.iter().zip(&spread.0).enumerate() {
        // What is less than nothing is left out, which adds a little.
        assert!(
            (0.9999..1.03).contains(&(after / before.max(1e-9))) || *before == 0.0,
            "plane {y}: {before} to {after}"
        );
    }
    // At the bottom, where there is most of it.
    let grid = cube(32);
    let bottom = |light: &[f32]| -> f32 {
        let rows = (0..32).flat_map(|z| (0..32).map(move |x| [x, 0, z]));
        rows.map(|at| light[grid.index(at)]).fold(0.0, f32::max)
    };
    assert!(bottom(&spread.1) < 0.8 * bottom(&still.1), "{} of {}", bottom(&spread.1), bottom(&still.1));
}

/// Under a cap the paper's brightness is two cells over what is left to its focus.
pub fn laplacian(request: &Request) {
    let cap = |at: DVec2| (1.0 - at.length_squared()).max(0.0).sqrt() - 1.0;
    let emitter = Emitter::Directional { direction: Vec3::NEG_Y, irradiance: Vec3::ONE };
    let grid = Grid { lower: DVec3::new(-0.62, -1.16, -0.62), cell: 0.04, cells: [31, 32, 31] };
    let intensity = Intensity::Laplacian { base: 0.5, gain: 3.0, power: 2.0 };
    let options = VolumeOptions { intensity, infinite: true, ..options(grid) };
    let rig = Rig::new(request, &water(emitter, 1.4, 240, cap), &options);
    let light = lit(&rig);
    for plane in [12, 17, 21] {
        let at = [15, plane, 15];
        let left = 1.0 + grid.centre(at).y;
        let expected = 0.5 + 3.0 * (2.0 * grid.cell / left).powi(2);
        let found = f64::from(light[grid.index(at)]);
        assert!((found / expected - 1.0).abs() < AXIS, "{left} m to the focus: {found} for {expected}");
    }
}
