//! The swept solver on devices against fast marching from the same values.

use glam::{DVec2, Vec3};
use nephroid::scene::{Emitter, Scene};
use nephroid::technique::eikonal::marching::{Order, march};
use nephroid::technique::eikonal::{SolverOptions, VolumeOptions};

use super::{QUADS, Request, Rig, WATER, cube, difference, water};

/// Cells times index by which the device's f32 may be off after 32 planes of water four metres deep.
const FIRST: f64 = 1e-4;
/// The largest and mean difference of second order: marching takes a cell's values from what it had accepted by then, and
/// never looks again, which shows where waves meet.
const SECOND: (f64, f64) = (5e-3, 1e-4);

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

fn options(order: Order) -> VolumeOptions {
    // Marching knows nothing of how waves go on beyond the sides.
    let solver = SolverOptions { order, rounds: 1, linear: false };
    VolumeOptions { grid: Some(cube(32)), solver, ..VolumeOptions::default() }
}

fn compare(request: &Request, order: Order) -> (f64, f64) {
    let mut worst = (0.0f64, 0.0f64);
    for emitter in [lamp(), sun()] {
        let rig = Rig::new(request, &waves(emitter), &options(order));
        let start = rig.given();
        let found = rig.wave();
        let marched = march(&rig.volume.grid, |_| WATER, &start, order);
        let (most, mean) = difference(&rig.volume.grid, WATER, &found, |at| marched[at]);
        let settled = rig.volume.check(&rig.device, &rig.kernels).unwrap();
        assert_eq!(settled.unreached, 0);
        worst = (worst.0.max(most), worst.1.max(mean));
    }
    worst
}

pub fn first(request: &Request) {
    let (most, _) = compare(request, Order::First);
    assert!(most < FIRST, "{most} cells");
}

pub fn second(request: &Request) {
    let (most, mean) = compare(request, Order::Second);
    assert!(most < SECOND.0 && mean < SECOND.1, "{most} and {mean} cells");
}

pub fn equal_bits(request: &Request) {
    let scene = waves(lamp());
    let bits = |_| {
        let rig = Rig::new(request, &scene, &options(Order::Second));
        rig.wave().into_iter().map(f64::to_bits).collect::<Vec<_>>()
    };
    let [first, again] = [0, 1].map(bits);
    assert_eq!(first, again);
}
