//! Water that is moved on the device: waves against the height field they are defined by, the simulation against closed
//! forms of the wave equation and of its discrete twin.

mod common;
mod water;

use std::process::ExitCode;

use common::{Case, Request};
use glam::{DVec2, Vec3};
use nephroid::scene::animation::{Drop, Rain, WaterMotion};
use nephroid::scene::height_field::{Bump, HeightField, Relief, Wave};
use water::{Stage, drop, still_sheet, within_walls};

fn main() -> ExitCode {
    common::run(&[
        Case {
            name: "waves_are_the_height_field_at_every_time",
            needs: &[],
            disable: "",
            run: waves_are_the_height_field,
        },
        Case { name: "what_does_not_move_is_left_alone", needs: &[], disable: "", run: left_alone },
        Case {
            name: "a_mode_of_the_sheet_swings_as_its_discrete_twin",
            needs: &[],
            disable: "",
            run: mode_is_its_discrete_twin,
        },
        Case { name: "strongly_damped_water_sinks_without_flicker", needs: &[], disable: "", run: strong_damping },
        Case { name: "halved_spacing_quarters_the_error", needs: &[], disable: "", run: second_order },
        Case { name: "energy_and_mean_height_stay", needs: &[], disable: "", run: energy_and_mean_stay },
        Case { name: "a_symmetric_start_stays_symmetric", needs: &[], disable: "", run: symmetry_stays },
        Case { name: "a_drop_sends_a_ring_out_at_the_speed_of_waves", needs: &[], disable: "", run: ring },
        Case { name: "drops_add_up_and_one_at_time_0_is_a_bump", needs: &[], disable: "", run: drops_add_up },
        Case { name: "a_drop_falls_at_the_step_nearest_its_time", needs: &[], disable: "", run: nearest_step },
        Case { name: "a_frame_alone_is_the_frame_in_its_row_and_backwards", needs: &[], disable: "", run: frame_alone },
    ])
}

/// Of the sheet's largest height or coordinate: a few roundings of f32.
const WAVE_HEIGHT: f64 = 2e-6;
const WAVE_NORMAL: f64 = 1e-5;

fn waves_are_the_height_field(request: &Request) {
    let wave = |wavelength: f64, amplitude, direction, phase| Wave { wavelength, amplitude, direction, phase };
    let field = HeightField {
        x: [-7.0, 4.3],
        z: [1.1, 9.0],
        quads: [96, 61],
        base: 0.31,
        waves: vec![
            wave(3.1, 0.2, 0.4, 0.3),
            wave(0.9, 0.03, 2.5, -40.0),
            wave(0.21, 0.004, -1.2, 1.0),
            wave(1.7, 0.08, 3.2, 2.0),
            wave(60.0, 0.5, 5.0, 0.0),
        ],
        bumps: vec![Bump { centre: DVec2::new(-1.0, 4.0), height: -0.4, radius: 0.8 }],
        relief: Some(Relief { columns: 3, rows: 2, values: vec![0.1, 0.9, 0.3, 0.5, 0.2, 0.7], height: 0.3 }),
    };
    for depth in [None, Some(0.4)] {
        let mut stage = Stage::new(request, &[(field.clone(), WaterMotion::Waves { depth })], 24.0);
        let still = stage.scene.clone();
        // The last is 1e5 s.
        for frame in [0, 1, 7, 1003, 24 * 3600, 2_400_000] {
            stage.go_to(frame);
            let now = field.at(depth, f64::from(frame) / 24.0);
            let extent = field.vertices().map(|(x, z)| now.height(x, z).abs()).fold(0.0, f64::max);
            let mesh = stage.mesh(0);
            for (index, (x, z)) in field.vertices().enumerate() {
                let (position, before) = (mesh.positions[index], stage.mesh_of(&still, 0).positions[index]);
                assert_eq!((position.x, position.z), (before.x, before.z), "vertex {index}");
                let error = (f64::from(position.y) - now.height(x, z)).abs();
                assert!(error < WAVE_HEIGHT * extent, "vertex {index} of frame {frame}: {error} of {extent}");
                let error = (mesh.normals[index].as_dvec3() - now.normal(x, z)).length();
                assert!(error < WAVE_NORMAL, "normal {index} of frame {frame}: {error}");
            }
            // Texture coordinates, and the meshes before and after.
            stage.assert_host_is_device();
        }
    }
}

fn left_alone(request: &Request) {
    let flat = still_sheet([8, 6]);
    let wavy = HeightField {
        waves: vec![Wave { wavelength: 1.0, amplitude: 0.1, direction: 0.0, phase: 0.0 }],
        ..flat.clone()
    };
    let deep = WaterMotion::Waves { depth: None };
    let mut stage = Stage::new(request, &[(flat, deep.clone()), (wavy.clone(), deep), (wavy, within_walls())], 24.0);
    let (still, waves, simulated) = (stage.mesh_id(0), stage.mesh_id(1), stage.mesh_id(2));
    assert_eq!(stage.go_to(0), [still, waves, simulated]);
    assert!(stage.go_to(0).is_empty());
    assert_eq!(stage.go_to(3), [waves, simulated]);
    assert!(stage.go_to(3).is_empty());
}

/// cos(m pi x / width) cos(n pi z / depth) over the sheet, its walls being crests or troughs: two waves.
fn mode(field: HeightField, amplitude: f64, m: f64, n: f64) -> HeightField {
    let first = DVec2::new(field.x[0], field.z[0]);
    let size = DVec2::new(field.x[1], field.z[1]) - first;
    let k = std::f64::consts::PI * DVec2::new(m, n) / size;
    let wave = |k: DVec2| Wave {
        wavelength: std::f64::consts::TAU / k.length(),
        amplitude: 0.5 * amplitude,
        direction: k.y.atan2(k.x),
        phase: std::f64::consts::FRAC_PI_2 - k.dot(first),
    };
    HeightField { waves: vec![wave(k), wave(DVec2::new(k.x, -k.y))], ..field }
}

/// Of the amplitude: the rounding of the coefficients to f32 over some three hundred radians.
const TWIN: f64 = 1e-5;

fn mode_is_its_discrete_twin(request: &Request) {
    const AMPLITUDE: f64 = 0.1;
    for (m, n, damping) in [(3.0, 2.0, 0.0), (1.0, 4.0, 1.7), (7.0, 0.0, 0.3)] {
        let field = mode(still_sheet([24, 25]), AMPLITUDE, m, n);
        let mut simulation = water::simulation(1.3);
        simulation.damping = damping;
        let steps = simulation.steps_per_frame(&field, 24.0);
        let mut stage = Stage::new(request, &[(field.clone(), WaterMotion::Simulated(simulation))], 24.0);
        let spacing = field.spacing();
        let step = 1.0 / (24.0 * f64::from(steps));
        // h(n+1) (1 + g) = (2 - a) h(n) - (1 - g) h(n-1), h(1) = (1 - a / 2) h(0): the roots are a damped turn.
        let half_sine = |m: f64, quads: u32| (std::f64::consts::PI * m / f64::from(2 * quads)).sin().powi(2);
        let bends = DVec2::new(half_sine(m, field.quads[0]), half_sine(n, field.quads[1]));
        let a = 4.0 * ((1.3 * step / spacing).powf(2.0) * bends).element_sum();
        let g = 0.5 * damping * step;
        let decay = ((1.0 - g) / (1.0 + g)).sqrt();
        let turn = ((1.0 - 0.5 * a) / (1.0 - g * g).sqrt()).acos();
        let beside = ((1.0 - 0.5 * a) / decay - turn.cos()) / turn.sin();
        for frame in [0, 1, 2, 19, 200, 1000] {
            stage.go_to(frame);
            let count = f64::from(frame * steps);
            let swing = decay.powf(count) * ((turn * count).cos() + beside * (turn * count).sin());
            for (index, (x, z)) in field.vertices().enumerate() {
                let error = f64::from(stage.mesh(0).positions[index].y) - field.height(x, z) * swing;
                assert!(error.abs() < TWIN * AMPLITUDE, "vertex {index} of frame {frame}: {error}");
                let normal = water::normal_by_differences(&field, stage.mesh(0), index);
                let error = (stage.mesh(0).normals[index].as_dvec3() - normal).length();
                assert!(error < WAVE_NORMAL, "normal {index} of frame {frame}: {error}");
            }
        }
        // The twin's frequency and decay are the wave equation's to second order: seven half waves of 24 quads are the
        // most off, by 3.3 %.
        let k = std::f64::consts::PI * DVec2::new(m / 2.4, n / 2.0);
        let frequency = (1.3 * 1.3 * k.length_squared() - 0.25 * damping * damping).sqrt();
        assert!((turn / step / frequency - 1.0).abs() < 0.04, "{} {frequency}", turn / step);
        assert!((decay.ln() / step + 0.5 * damping).abs() <= 1e-3 * damping, "{}", decay.ln() / step);
    }
}

fn strong_damping(request: &Request) {
    // Of the amplitude. The mode's own swing per step at the least number of steps for waves alone would be 30 times this.
    const TOLERANCE: f64 = 1e-3;
    let field = mode(still_sheet([24, 20]), 0.1, 3.0, 2.0);
    let mut simulation = water::simulation(1.3);
    simulation.damping = 1e3;
    let mut stage = Stage::new(request, &[(field.clone(), WaterMotion::Simulated(simulation))], 24.0);
    let k = std::f64::consts::PI * DVec2::new(3.0 / 2.4, 1.0);
    let frequency = 1.3 * k.length();
    // The slow of the two ways to fall; the other is over within milliseconds.
    let rate = 500.0 - (500.0f64.powi(2) - frequency.powi(2)).sqrt();
    for frame in [0, 1, 2, 3, 10] {
        stage.go_to(frame);
        let sunk = (-rate * f64::from(frame) / 24.0).exp();
        for (index, (x, z)) in field.vertices().enumerate() {
            let error = f64::from(stage.mesh(0).positions[index].y) - field.height(x, z) * sunk;
            assert!(error.abs() < TOLERANCE * 0.1, "vertex {index} of frame {frame}: {error}");
        }
    }
}

fn second_order(request: &Request) {
    // Of an error that falls as the square of the spacing; higher orders are below a tenth here.
    const RATIO: std::ops::Range<f64> = 3.7..4.3;
    const TIME: f64 = 1.0;
    const SPEED: f64 = 1.1999;
    let errors = [1, 2, 4].map(|finer| {
        let field = mode(still_sheet([12 * finer, 10 * finer]), 0.1, 2.0, 1.0);
        // Just below half a quad a step at all three.
        let mut simulation = water::simulation(SPEED);
        simulation.damping = 0.9;
        let mut stage = Stage::new(request, &[(field.clone(), WaterMotion::Simulated(simulation))], 6.0);
        stage.go_to(6);
        let k = std::f64::consts::PI * DVec2::new(2.0 / 2.4, 1.0 / 2.0);
        let frequency = (SPEED * SPEED * k.length_squared() - 0.25 * 0.9 * 0.9).sqrt();
        let (sine, cosine) = (frequency * TIME).sin_cos();
        let swing = (-0.45 * TIME).exp() * (cosine + 0.45 / frequency * sine);
        let error = |(index, (x, z)): (usize, (f64, f64))| {
            (f64::from(stage.mesh(0).positions[index].y) - swing * field.height(x, z)).abs()
        };
        field.vertices().enumerate().map(error).fold(0.0, f64::max)
    });
    for pair in errors.windows(2) {
        assert!(RATIO.contains(&(pair[0] / pair[1])), "{errors:?}");
    }
}

fn energy_and_mean_stay(request: &Request) {
    // Of the energy and of the largest height: what rounding to f32 positions leaves.
    const ENERGY: f64 = 1e-6;
    const MEAN: f64 = 5e-9;
    let bump = Bump { centre: DVec2::new(0.4, -0.3), height: 0.1, radius: 0.3 };
    let field = HeightField { bumps: vec![bump], ..still_sheet([24, 20]) };
    let speed = 1.1;
    // A step a frame, so that the energy between two steps can be seen.
    let simulation = water::simulation(speed);
    let fps = 2.0 * speed / field.spacing().min_element();
    assert_eq!(simulation.steps_per_frame(&field, fps), 1);
    let mut stage = Stage::new(request, &[(field.clone(), WaterMotion::Simulated(simulation))], fps);
    let mut heights = |frame| {
        stage.go_to(frame);
        stage.mesh(0).positions.iter().map(|p| f64::from(p.y)).collect::<Vec<f64>>()
    };
    let mut at = |frame| {
        let (now, next) = (heights(frame), heights(frame + 1));
        (water::mean(&field, &now), water::energy(&field, speed, 1.0 / fps, &now, &next))
    };
    let (mean, energy) = at(0);
    assert!(mean > 1e-3 && energy > 0.0, "{mean} {energy}");
    for frame in [1, 50, 700, 3000] {
        let (later_mean, later) = at(frame);
        assert!((later / energy - 1.0).abs() < ENERGY, "frame {frame}: {later} of {energy}");
        assert!((later_mean - mean).abs() < MEAN * bump.height, "frame {frame}: {later_mean} of {mean}");
    }
}

fn symmetry_stays(request: &Request) {
    let bump = Bump { centre: DVec2::ZERO, height: 0.1, radius: 0.2 };
    let field = HeightField { x: [-1.0, 1.0], z: [-1.0, 1.0], bumps: vec![bump], ..still_sheet([32, 32]) };
    let mut simulation = water::simulation(1.0);
    simulation.drops = vec![Drop { time: 0.3, centre: DVec2::ZERO, height: -0.2, radius: 0.13 }];
    simulation.damping = 0.2;
    let mut stage = Stage::new(request, &[(field, WaterMotion::Simulated(simulation))], 24.0);
    for frame in [1, 30, 300] {
        stage.go_to(frame);
        let mesh = stage.mesh(0);
        let at = |column: usize, row: usize| (mesh.positions[33 * row + column].y, mesh.normals[33 * row + column]);
        for (column, row) in (0..33).flat_map(|row| (0..33).map(move |column| (column, row))) {
            let ((y, n), (y_across, n_across), (y_turned, n_turned)) =
                (at(column, row), at(32 - column, row), at(row, column));
            assert_eq!((y, n), (y_across, n_across * Vec3::new(-1.0, 1.0, 1.0)), "{column} {row}");
            assert_eq!((y, n), (y_turned, Vec3::new(n_turned.z, n_turned.y, n_turned.x)), "{column} {row}");
        }
    }
}

fn ring(request: &Request) {
    // Of the drop's height. Four vertices to a standard deviation are off by some hundredths of the ring's own.
    const PROFILE: f64 = 1e-2;
    // A crest of the ring between two times, over their difference.
    const SPEED: f64 = 0.01;
    let (speed, radius) = (1.25, 0.1);
    let field = HeightField { x: [-2.0, 2.0], z: [-2.0, 2.0], ..still_sheet([160, 160]) };
    let mut simulation = water::simulation(speed);
    let fps = 20.0;
    // At a step, so that the nearest step is its time.
    let time = 3.0 / fps;
    simulation.drops = vec![Drop { time, centre: DVec2::ZERO, height: 0.1, radius }];
    let mut stage = Stage::new(request, &[(field, WaterMotion::Simulated(simulation))], fps);
    let mut crests = Vec::new();
    for frame in [2, 3, 5, 17, 29] {
        stage.go_to(frame);
        let since = f64::from(frame) / fps - time;
        let line = |dx: usize, dz: usize| -> Vec<f64> {
            (0..=80).map(|k| f64::from(stage.mesh(0).positions[161 * (80 + k * dz) + 80 + k * dx].y)).collect()
        };
        for (line, spacing) in [(line(1, 0), 0.025), (line(0, 1), 0.025), (line(1, 1), 0.025 * 2f64.sqrt())] {
            for (k, height) in line.iter().enumerate().take_while(|(k, _)| *k as f64 * spacing < 1.99) {
                let r = k as f64 * spacing;
                let truth = if since < 0.0 { 0.0 } else { 0.1 * water::ring(r / radius, speed * since / radius) };
                assert!((height - truth).abs() < PROFILE * 0.1, "frame {frame}, {r} m: {height}, {truth} expected");
            }
            if frame > 5 {
                crests.push(water::crest(&line) * spacing);
            }
        }
    }
    for (first, second) in crests[..3].iter().zip(&crests[3..]) {
        let found = (second - first) / (12.0 / fps);
        assert!((found / speed - 1.0).abs() < SPEED, "{found} m/s instead of {speed}");
    }
}

fn drops_add_up(request: &Request) {
    // Of the height: roundings of what is the same sum in another order.
    const TOLERANCE: f64 = 3e-6;
    let bump = Bump { centre: DVec2::new(-1.1, 0.2), height: 0.13, radius: 0.2 };
    let after = |field: HeightField, drops: Vec<Drop>| {
        let mut simulation = water::simulation(1.0);
        (simulation.damping, simulation.drops) = (2.0, drops);
        let mut stage = Stage::new(request, &[(field, WaterMotion::Simulated(simulation))], 24.0);
        stage.go_to(9);
        stage.mesh(0).positions.iter().map(|p| f64::from(p.y)).collect::<Vec<f64>>()
    };
    let flat = still_sheet([24, 20]);
    let one = |height| Drop { time: 0.0, centre: bump.centre, height, radius: bump.radius };
    let expected = after(HeightField { bumps: vec![bump], ..flat.clone() }, Vec::new());
    // More than one pass takes.
    for drops in [vec![one(0.13)], vec![one(0.001); 130]] {
        for (found, expected) in after(flat.clone(), drops).iter().zip(&expected) {
            assert!((found - expected).abs() < TOLERANCE * 0.13, "{found} instead of {expected}");
        }
    }
}

fn nearest_step(request: &Request) {
    let field = still_sheet([24, 20]);
    let steps = water::simulation(1.0).steps_per_frame(&field, 6.0);
    assert_eq!(steps, 4);
    let after = |time: f64| {
        let mut simulation = water::simulation(1.0);
        simulation.drops = vec![drop(time / (6.0 * f64::from(steps)), 0.1)];
        let mut stage = Stage::new(request, &[(field.clone(), WaterMotion::Simulated(simulation))], 6.0);
        stage.go_to(3);
        stage.mesh(0).positions.clone()
    };
    let at_six = after(6.0);
    for (time, same) in [(5.4, false), (5.6, true), (6.4, true), (6.6, false)] {
        assert_eq!(after(time) == at_six, same, "{time} steps");
    }
}

fn frame_alone(request: &Request) {
    let field = HeightField {
        bumps: vec![Bump { centre: DVec2::new(0.4, -0.3), height: 0.1, radius: 0.3 }],
        waves: vec![Wave { wavelength: 0.8, amplitude: 0.03, direction: 0.3, phase: 1.0 }],
        ..still_sheet([48, 40])
    };
    let mut simulation = water::simulation(2.0);
    simulation.rain = Some(Rain { rate: 31.0, height: -0.01, radius: 0.06, seed: 3 });
    // At a frame, between two steps, and late.
    simulation.drops = [0.0, 1.0 / 24.0, 2.5 / 24.0, 0.21].map(|time| drop(time, 0.05)).to_vec();
    let waters = [(field.clone(), WaterMotion::Waves { depth: None }), (field, WaterMotion::Simulated(simulation))];
    let vertices = |stage: &Stage| stage.assert_host_is_device();
    let mut row = Stage::new(request, &waters, 24.0);
    let frames = [0, 1, 2, 3, 4, 40];
    let in_row = frames.map(|frame| {
        row.go_to(frame);
        vertices(&row)
    });
    assert!(
        in_row.iter().flatten().all(|vertex| bytemuck::cast_slice::<_, f32>(&[*vertex]).iter().all(|x| x.is_finite()))
    );
    assert!(in_row.windows(2).all(|pair| pair[0] != pair[1]));
    for (frame, expected) in frames.into_iter().zip(&in_row).rev() {
        row.go_to(frame);
        assert_eq!(vertices(&row), *expected, "back at frame {frame}");
    }
    for (frame, expected) in frames.into_iter().zip(&in_row).skip(1).step_by(2) {
        let mut alone = Stage::new(request, &waters, 24.0);
        alone.go_to(frame);
        assert_eq!(vertices(&alone), *expected, "frame {frame} alone");
    }
}
