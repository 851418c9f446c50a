//! The scalar wave through a volume: flat water, a pulse's speed, a cap's focus, and what sums cannot show.

use glam::{DVec2, DVec3, Vec3};
use nephroid::scene::{Emitter, Scene};
use nephroid::technique::eikonal::{Grid, Start, Sum, VolumeOptions, Wave, WaveKernels, WaveOptions};

use super::light::below;
use super::{Request, Rig, WATER, cube, water};

/// Of flat water's light under a sun straight above, what it may be off anywhere: what a pulse sampled once a cell sums to.
const FLAT: f64 = 0.005;
/// The same of a sun aslant, largest and mean: the wave on the grid is late by part of a cell, of which the sides know nothing. 0.06
/// and 0.0044 on llvmpipe.
const ASLANT: (f64, f64) = (0.1, 0.01);
/// Of the wave's energy, what may be thrown back by sides and bottom.
const THROWN_BACK: f64 = 0.01;
/// Cells a step, less 1: of waves along an axis, and of waves 12 degrees off it, by the scheme's dispersion.
const SPEED: (f64, f64) = (1e-3, 0.01);
/// Of the way to a cap's focus, how far off it the most light may be: of a wave in time with the light, 0.03 on llvmpipe; and of the
/// paper's, which starts from stairs of cells.
const FOCUS: (f64, f64) = (0.06, 0.25);
/// At that focus light rises some hundredfold, and the sum with signs by less than this.
const SIGNED_RISE: f32 = 2.0;

const ASLANT_SUN: DVec3 = DVec3::new(0.25, -1.0, 0.1);

fn sun(direction: DVec3) -> Emitter {
    Emitter::Directional { direction: direction.as_vec3().normalize(), irradiance: Vec3::ONE }
}

struct Waved {
    rig: Rig,
    wave: Wave,
    light: Vec<f32>,
}

impl Waved {
    fn new(request: &Request, scene: &Scene, volume: &VolumeOptions, options: &WaveOptions) -> Waved {
        let rig = Rig::new(request, scene, volume);
        let wave = Wave::new(&rig.device, &rig.volume, options).unwrap();
        let kernels = WaveKernels::new(&rig.device).unwrap();
        rig.run(|recorder| wave.record(recorder, &rig.scene.bindings, &rig.volume, &rig.kernels, &kernels).unwrap());
        let light = rig.volume.read_light().unwrap();
        Waved { rig, wave, light }
    }

    fn flat(request: &Request, direction: DVec3, options: &WaveOptions) -> Waved {
        let volume = VolumeOptions { grid: Some(cube(32)), ..VolumeOptions::default() };
        Waved::new(request, &water(sun(direction), 8.0, 1, |_| 0.0), &volume, options)
    }

    fn grid(&self) -> Grid {
        *self.rig.volume.grid()
    }
}

/// Flat water under the sun, sides and edges included; and what is left of the wave when it has gone through.
pub fn flat(request: &Request) {
    for (direction, most_off, mean_off) in [(DVec3::NEG_Y, FLAT, FLAT), (ASLANT_SUN, ASLANT.0, ASLANT.1)] {
        let waved = Waved::flat(request, direction, &WaveOptions::default());
        let grid = waved.grid();
        let expected = below(-direction.normalize().y, WATER);
        let wrong: Vec<f64> = (grid.centres().zip(&waved.light).filter(|(at, _)| at.y < 0.0))
            .map(|(_, &light)| (f64::from(light) / expected - 1.0).abs())
            .collect();
        let (most, mean) = (wrong.iter().copied().fold(0.0, f64::max), wrong.iter().sum::<f64>() / wrong.len() as f64);
        assert!(most < most_off && mean < mean_off, "{direction}: {most} and {mean}");

        let left: f64 = waved.wave.read_phi().unwrap().iter().map(|&phi| f64::from(phi).powi(2)).sum();
        // A cell's sum is the pulse's energy through it; what crosses a plane of cells is all of it.
        let all = expected * f64::from(grid.cells[0] * grid.cells[2]) * pulse_energy();
        assert!(left < THROWN_BACK * all, "{direction}: {} of the wave is left", left / all);
    }
}

/// Of the pulse with height 1: the sum of its squares, a cell apart.
fn pulse_energy() -> f64 {
    (-8..=8).map(f64::from).map(|t| (t * (0.5 - 0.5 * t * t).exp()).powi(2)).sum()
}

/// A pulse goes a cell in a step.
pub fn speed(request: &Request) {
    for (direction, tolerance) in [(DVec3::NEG_Y, SPEED.0), (ASLANT_SUN, SPEED.1)] {
        let across = direction.normalize() * DVec3::new(1.0, 0.0, 1.0) / WATER;
        let way = across - DVec3::Y * (1.0 - across.length_squared()).sqrt();
        let front = |steps: u32| {
            let options = WaveOptions { steps: Some(steps), ..WaveOptions::default() };
            let waved = Waved::flat(request, direction, &options);
            let (mut sum, mut weight) = (0.0, 0.0);
            let grid = waved.grid();
            for (at, phi) in grid.centres().zip(waved.wave.read_phi().unwrap()) {
                // As many cells on either side of the front, and none near the sides.
                if at.x.abs() < 0.6 && at.z.abs() < 0.6 {
                    sum += f64::from(phi).powi(2) * at.dot(way) / grid.cell;
                    weight += f64::from(phi).powi(2);
                }
            }
            sum / weight
        };
        let (early, late) = (28, 36);
        let found = (front(late) - front(early)) / f64::from(late - early);
        assert!((found - 1.0).abs() < tolerance, "{direction}: {found} cells a step");
    }
}

/// Parallel light through a cap of that radius, 64 cells wide.
fn cap(request: &Request, options: &WaveOptions, infinite: bool) -> Waved {
    let radius = RADIUS;
    let cap = |at: DVec2| (radius * radius - at.length_squared()).max(0.0).sqrt() - radius;
    let grid = Grid { lower: DVec3::new(-1.2, -2.3, -1.2), cell: 2.4 / 64.0, cells: [64; 3] };
    let volume = VolumeOptions { grid: Some(grid), infinite, ..VolumeOptions::default() };
    Waved::new(request, &water(sun(DVec3::NEG_Y), 2.6, 200, cap), &volume, options)
}

/// Of the cap, metres.
const RADIUS: f64 = 1.6;

/// The place of the most there is, and how deep it lies.
fn brightest(grid: &Grid, values: &[f32]) -> ([u32; 3], f64) {
    let most = (values.iter().enumerate()).max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(index, _)| index);
    (grid.place(most), -grid.centre(grid.place(most)).y)
}

/// With an infinite index there is most light near the cap's radius.
pub fn focus(request: &Request) {
    for (start, tolerance) in [(Start::InTime, FOCUS.0), (Start::AtOnce, FOCUS.1)] {
        let waved = cap(request, &WaveOptions { start, ..WaveOptions::default() }, true);
        let (place, depth) = brightest(&waved.grid(), &waved.light);
        assert!((depth / RADIUS - 1.0).abs() < tolerance, "{start:?}: {depth} m for {RADIUS} m");
        assert!(place[0].abs_diff(32) < 3 && place[2].abs_diff(32) < 3, "{start:?}: {place:?}");
    }
}

/// The sum of phi itself obeys Laplace's equation below the surface: it has its most at an end of the volume, and no focus.
pub fn signed(request: &Request) {
    let waved = cap(request, &WaveOptions { sum: Sum::Signed, ..WaveOptions::default() }, true);
    let grid = waved.grid();
    let sums = waved.wave.read_sums().unwrap();
    let at = |depth: f64| sums[grid.index([32, ((-depth - grid.lower.y) / grid.cell) as u32, 32])];
    let (place, depth) = brightest(&grid, &sums);
    let inside = [place[0], place[2]].iter().all(|&i| (1..63).contains(&i)) && place[1] > 0 && depth > 4.0 * grid.cell;
    assert!(!inside, "the most is at {place:?}");
    let rise = at(RADIUS) / at(0.2);
    assert!((0.5..SIGNED_RISE).contains(&rise), "at the focus the sum is {rise} times what it is below the surface");
}

pub fn equal_bits(request: &Request) {
    let bits = |_| -> Vec<u32> {
        let waved = Waved::flat(request, ASLANT_SUN, &WaveOptions::default());
        waved.light.iter().map(|light| light.to_bits()).collect()
    };
    let [first, again] = [0, 1].map(bits);
    assert_eq!(first, again);
}
