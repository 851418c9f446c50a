//! Against closed forms: flat and tilted water, a lamp, a cap.

use glam::{DVec2, DVec3, Vec3};
use nephroid::scene::Emitter;
use nephroid::technique::eikonal::marching::Order;
use nephroid::technique::eikonal::path::Source;
use nephroid::technique::eikonal::{Scheme, VolumeOptions};

use super::{Request, Rig, SCHEMES, WATER, cube, difference, solver, water};

/// Cells times index that rounding may make of what is given: paths of some ten metres in f32.
const ROUNDING: f64 = 2e-4;

const LAMP: DVec3 = DVec3::new(0.6, 5.0, -0.4);

fn lamp_source() -> Source {
    Source::Point { position: LAMP, index: 1.0 }
}

fn lamp_light() -> Emitter {
    Emitter::Point { position: LAMP.as_vec3(), intensity: Vec3::splat(100.0) }
}

fn sun_light(direction: DVec3) -> Emitter {
    Emitter::Directional { direction: direction.as_vec3(), irradiance: Vec3::ONE }
}

fn options(cells: u32, scheme: Scheme) -> VolumeOptions {
    VolumeOptions { grid: Some(cube(cells)), solver: solver(scheme), ..VolumeOptions::default() }
}

/// Values next to tilted water, whose triangles are much larger or much smaller than cells.
pub fn given(request: &Request) {
    let slope = DVec2::new(0.06, -0.04);
    let normal = DVec3::new(-slope.x, 1.0, -slope.y).normalize();
    let direction = DVec3::new(0.5, -1.0, -0.3).as_vec3().normalize();
    let sun = Source::Directional { direction: direction.as_dvec3(), index: 1.0 };
    for quads in [1, 160] {
        for (source, light) in [(lamp_source(), lamp_light()), (sun, sun_light(direction.as_dvec3()))] {
            let rig = Rig::new(request, &water(light, 8.0, quads, |at| slope.dot(at)), &options(32, Scheme::Planes));
            let grid = *rig.volume.grid();
            let start = rig.given();
            let mut count = 0;
            for (index, value) in start.iter().enumerate() {
                let at = grid.centre(grid.place(index));
                let depth = -normal.dot(at);
                assert_eq!(value.is_nan(), depth < 0.0, "{at} with {quads} quads");
                // Two cells along an axis are as far off the plane as that, and every such cell has to be given.
                assert!(value.is_nan() || value.is_finite() || depth / normal.y > 1.9 * grid.cell, "{at} {depth}");
                if !value.is_finite() {
                    continue;
                }
                count += 1;
                let exact = source.through_plane(DVec3::ZERO, normal, at, WATER).0;
                let off = (value - exact).abs() / grid.cell;
                assert!(off < ROUNDING, "{at} with {quads} quads: off by {off} cells");
            }
            assert!(count >= 2 * 32 * 32, "{count} cells are given");
        }
    }
}

/// Parallel light through flat and tilted water: phi is linear, which differences take without error, and waves that come
/// in by the sides go on as they are.
pub fn planes(request: &Request) {
    for (slope, direction) in [
        (DVec2::ZERO, DVec3::NEG_Y),
        (DVec2::ZERO, DVec3::new(0.7, -1.0, 0.2)),
        (DVec2::new(0.06, 0.04), DVec3::new(-0.6, -1.0, 0.5)),
    ] {
        let direction = direction.as_vec3().normalize().as_dvec3();
        let source = Source::Directional { direction, index: 1.0 };
        let normal = DVec3::new(-slope.x, 1.0, -slope.y).normalize();
        for scheme in SCHEMES {
            let scene = water(sun_light(direction), 8.0, 4, |at| slope.dot(at));
            let rig = Rig::new(request, &scene, &options(32, scheme));
            let grid = *rig.volume.grid();
            let exact = |i: usize| source.through_plane(DVec3::ZERO, normal, grid.centre(grid.place(i)), WATER).0;
            let (most, _) = difference(&grid, WATER, &rig.wave(), exact);
            assert!(most < 2e-3, "{direction} {scheme:?}: {most} cells");
        }
    }
}

/// A lamp over flat water: errors and order of convergence.
pub fn lamp(request: &Request) {
    for scheme in SCHEMES {
        let run = |cells: u32| {
            let rig = Rig::new(request, &water(lamp_light(), 8.0, 1, |_| 0.0), &options(cells, scheme));
            let grid = *rig.volume.grid();
            let exact =
                |i: usize| lamp_source().through_plane(DVec3::ZERO, DVec3::Y, grid.centre(grid.place(i)), WATER).0;
            let (_, mean) = difference(&grid, WATER, &rig.wave(), exact);
            mean * grid.cell
        };
        let [coarse, fine] = [16, 32].map(run);
        let rate = (coarse / fine).log2();
        let least = match scheme {
            Scheme::Sweeps(Order::First) => 0.6,
            Scheme::Sweeps(Order::Second) => 1.4,
            _ => 2.5,
        };
        println!("{scheme:?}: {coarse:.2e} m, {fine:.2e} m, order {rate:.2}");
        assert!(rate > least, "{scheme:?} converges with order {rate}");
    }
}

/// The radius of the cap of water, metres.
const RADIUS: f64 = 2.0;

/// Parallel light through a cap comes together at its radius with an infinite index, and at n R / (n - 1) in water: measured
/// by how the wave is bent below its middle, extrapolated from where rays have not met.
pub fn focus(request: &Request) {
    for (infinite, index, expected) in [(true, 1.0, RADIUS), (false, WATER, WATER * RADIUS / (WATER - 1.0))] {
        let cap = |at: DVec2| (RADIUS * RADIUS - at.length_squared()).max(0.0).sqrt() - RADIUS;
        let scene = water(sun_light(DVec3::NEG_Y), 2.4, 240, cap);
        let mut options = options(32, Scheme::Planes);
        options.infinite = infinite;
        options.grid = Some(nephroid::technique::eikonal::Grid {
            lower: DVec3::new(-0.62, -1.16, -0.62),
            cell: 0.04,
            cells: [31, 32, 31],
        });
        let rig = Rig::new(request, &scene, &options);
        let grid = *rig.volume.grid();
        let wave = rig.wave();
        // A metre down, phi over the radius: its curvature is index over what is left to the focus.
        let depth_cells = 6;
        let at = |x: u32, z: u32| wave[grid.index([x, depth_cells, z])];
        let below = -grid.centre([15, depth_cells, 15]).y;
        let reach = 6;
        let around = at(15 - reach, 15) + at(15 + reach, 15) + at(15, 15 - reach) + at(15, 15 + reach);
        let curvature = (around - 4.0 * at(15, 15)) / (2.0 * (f64::from(reach) * grid.cell).powi(2));
        let found = below - index / curvature;
        assert!((found - expected).abs() < 2.0 * grid.cell, "{found} m for {expected} m");
    }
}
