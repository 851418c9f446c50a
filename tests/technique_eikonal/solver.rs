//! The swept solver on devices against fast marching from the same values.

use glam::{DVec2, Vec3};
use nephroid::scene::{Emitter, Scene};
use nephroid::technique::eikonal::marching::{Order, march};
use nephroid::technique::eikonal::{Marching, Scheme, SolverOptions, VolumeOptions};

use super::{QUADS, Request, Rig, WATER, cube, difference, water};

/// Cells times index by which the device's f32 may be off after 32 planes of water four metres deep.
const FIRST: f64 = 1e-4;
/// The largest and mean difference of second order: marching takes a cell's values from what it had accepted by then, and
/// never looks again, which shows where waves meet.
const SECOND: (f64, f64) = (5e-3, 1e-4);

/// The same of planes: what marching's second order is off.
const PLANES: (f64, f64) = (0.05, 0.01);
/// Columns that what comes in by open sides reaches, which planes do without differently.
const INNER: u32 = 11;

/// Waves that fold light within the cube.
fn waves(emitter: Emitter) -> Scene {
    water(emitter, 6.0, QUADS, |at: DVec2| {
        0.05 * (2.1 * at.x + 0.7 * at.y).sin() + 0.04 * (3.3 * at.y - 1.7 * at.x + 1.0).sin()
    })
}

fn lamp() -> Emitter {
    Emitter::Point { position: Vec3::new(0.6, 5.0, -0.4), intensity: Vec3::splat(100.0) }
}

fn sun() -> Emitter {
    Emitter::Directional { direction: Vec3::new(0.5, -1.0, -0.3).normalize(), irradiance: Vec3::ONE }
}

fn options(scheme: Scheme) -> VolumeOptions {
    // Marching knows nothing of how waves go on beyond the sides.
    let solver = SolverOptions { scheme, rounds: 1, linear: false };
    VolumeOptions { grid: Some(cube(32)), solver, ..VolumeOptions::default() }
}

/// Largest and mean difference from marching, in columns at least `inner` cells from the sides.
fn compare(request: &Request, scheme: Scheme, order: Order, inner: u32) -> (f64, f64) {
    let mut worst = (0.0f64, 0.0f64);
    for emitter in [lamp(), sun()] {
        let rig = Rig::new(request, &waves(emitter), &options(scheme));
        let grid = *rig.volume.grid();
        let start = rig.given();
        let mut found = rig.wave();
        let marched = march(&grid, |_| WATER, &start, order);
        let is_inner = |at: u32| (inner..grid.cells[0] - inner).contains(&at);
        for (at, value) in found.iter_mut().enumerate() {
            let [x, _, z] = grid.place(at);
            *value = if is_inner(x) && is_inner(z) { *value } else { f64::NAN };
        }
        let (most, mean) = difference(&grid, WATER, &found, |at| marched[at]);
        if scheme != Scheme::Planes {
            let settled = rig.volume.check(&rig.device, &rig.kernels).unwrap();
            assert_eq!(settled.unreached, 0);
        }
        worst = (worst.0.max(most), worst.1.max(mean));
    }
    worst
}

pub fn first(request: &Request) {
    let (most, _) = compare(request, Scheme::Sweeps(Order::First), Order::First, 0);
    assert!(most < FIRST, "{most} cells");
}

pub fn second(request: &Request) {
    let (most, mean) = compare(request, Scheme::Sweeps(Order::Second), Order::Second, 0);
    assert!(most < SECOND.0 && mean < SECOND.1, "{most} and {mean} cells");
}

pub fn planes(request: &Request) {
    let (most, mean) = compare(request, Scheme::Planes, Order::Second, INNER);
    println!("largest {most:.1e}, mean {mean:.1e}");
    assert!(most < PLANES.0 && mean < PLANES.1, "{most} and {mean} cells");
}

pub fn on_the_host(request: &Request) {
    let order = Order::First;
    let marching = Marching { order, snapped: false, sides: false };
    let host = waves(lamp());
    let rig = Rig::new(request, &host, &options(Scheme::Marching(marching)));
    let start = rig.given();
    rig.volume.solve_on_host(&rig.device, &host, &rig.scene.bindings, &rig.kernels).unwrap();
    let marched = march(rig.volume.grid(), |_| WATER, &start, order);
    let (most, _) = difference(rig.volume.grid(), WATER, &rig.volume.read().unwrap().0, |at| marched[at]);
    assert!(most < FIRST, "{most} cells");
}

pub fn equal_bits(request: &Request) {
    let scene = waves(lamp());
    let bits = |_| {
        let rig = Rig::new(request, &scene, &options(Scheme::Planes));
        rig.wave().into_iter().map(f64::to_bits).collect::<Vec<_>>()
    };
    let [first, again] = [0, 1].map(bits);
    assert_eq!(first, again);
}
