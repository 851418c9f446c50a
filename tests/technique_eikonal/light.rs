//! Light along the wave against closed forms.

use glam::{DVec2, DVec3, Vec3};
use nephroid::scene::Emitter;
use nephroid::technique::eikonal::marching::Order;
use nephroid::technique::eikonal::{Grid, SolverOptions, VolumeOptions};

use super::common::pool::refracted_light;
use super::{Request, Rig, WATER, cube, water};

/// Of flat water's light, what it may be off anywhere.
const FLAT: f64 = 0.005;
/// Of a lamp's light, largest and mean: upwind light of first order is spread across its way, and its curvature next to the
/// grid's sides is that a column inwards. 0.038 and 0.0035 on llvmpipe, 0.058 and 0.0035 on SwiftShader.
const LAMP: (f64, f64) = (0.08, 0.005);
/// Of the light on a cap's axis.
const AXIS: f64 = 0.03;

fn options(grid: Grid) -> VolumeOptions {
    let solver = SolverOptions { order: Order::Second, ..SolverOptions::default() };
    VolumeOptions { grid: Some(grid), solver, ..VolumeOptions::default() }
}

/// Light of all cells in water, NaN in others, and the largest and mean part by which it is off.
fn off(rig: &Rig, exact: impl Fn(DVec3) -> f64) -> (f64, f64) {
    let wave = rig.wave();
    rig.run(|recorder| rig.volume.record_light(recorder, &rig.scene.bindings, &rig.kernels).unwrap());
    let light = rig.volume.read_light().unwrap();
    let grid = rig.volume.grid;
    let mut wrong = Vec::new();
    for (index, (&light, _)) in light.iter().zip(&wave).enumerate().filter(|(_, (_, wave))| !wave.is_nan()) {
        let expected = exact(grid.centre(grid.place(index)));
        wrong.push((f64::from(light) / expected - 1.0).abs());
    }
    assert!(wrong.iter().all(|off| off.is_finite()));
    (wrong.iter().copied().fold(0.0, f64::max), wrong.iter().sum::<f64>() / wrong.len() as f64)
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
        assert!(most < FLAT, "{direction}: {most}");
    }
}

/// A lamp's light through flat water.
pub fn lamp(request: &Request) {
    let emitter = Emitter::Point { position: Vec3::new(1.5, 6.0, -1.0), intensity: Vec3::splat(100.0) };
    let rig = Rig::new(request, &water(emitter, 8.0, 1, |_| 0.0), &options(cube(32)));
    let (most, mean) = off(&rig, |at| refracted_light(at).fluence / 100.0);
    assert!(most < LAMP.0 && mean < LAMP.1, "{most} and {mean}");
}

/// On the axis of a cap light grows as the square of what is left to its focus falls.
pub fn cap(request: &Request) {
    let radius = 1.0;
    let cap = |at: DVec2| (radius * radius - at.length_squared()).max(0.0).sqrt() - radius;
    let emitter = Emitter::Directional { direction: Vec3::NEG_Y, irradiance: Vec3::ONE };
    let grid = Grid { lower: DVec3::new(-0.62, -1.16, -0.62), cell: 0.04, cells: [31, 32, 31] };
    let rig = Rig::new(request, &water(emitter, 1.4, 240, cap), &options(grid));
    rig.wave();
    rig.run(|recorder| rig.volume.record_light(recorder, &rig.scene.bindings, &rig.kernels).unwrap());
    let light = rig.volume.read_light().unwrap();
    let focus = radius * WATER / (WATER - 1.0);
    for plane in [3, 12, 21] {
        let at = [15, plane, 15];
        let depth = -grid.centre(at).y;
        let found = f64::from(light[grid.index(at)]);
        let expected = below(1.0, WATER) * (focus / (focus - depth)).powi(2);
        assert!((found / expected - 1.0).abs() < AXIS, "{depth} m down: {found} for {expected}");
    }
}
