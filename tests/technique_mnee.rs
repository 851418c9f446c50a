//! The technique `mnee` against an oracle in f64, closed forms, a truth made elsewhere, and itself on other tiers.

mod common;
mod mnee;
mod oracle;

use std::process::ExitCode;

use common::{Case, Request};
use glam::Vec3;
use mnee::{Receiver, WATER, ask, lamp, oracle_irradiances, pool, sun};
use nephroid::random;
use nephroid::scene::Light;

const CASES: &[Case] = &[Case { name: "paths_of_waves", needs: &[], disable: "", run: paths_of_waves }];

fn main() -> ExitCode {
    common::run(CASES)
}

/// Points on the floor of a pool `size` wide, evenly spread.
fn floor_points(count: u32, size: f32, depth: f32, seed: u32) -> Vec<Receiver> {
    (0..count)
        .map(|i| {
            let [x, z] = random::sample_2d(i, seed);
            Receiver { position: Vec3::new((x - 0.5) * size, -depth, (z - 0.5) * size), normal: Vec3::Y, medium: WATER }
        })
        .collect()
}

fn paths_of_waves(request: &Request) {
    let quads: u32 = std::env::var("Q").map_or(32, |v| v.parse().unwrap());
    let slope: f64 = std::env::var("SL").map_or(0.4, |v| v.parse().unwrap());
    let search = std::env::var("SEARCH").unwrap_or("footprints".into());
    let lights: Vec<Light> =
        vec![lamp(Vec3::new(0.3, 1.5, -0.4)), sun(Vec3::new(0.3, -1.0, 0.2)), sun(Vec3::new(1.0, -0.25, 0.1))];
    for (index, light) in lights.into_iter().enumerate() {
        let water = oracle::meshes::height_field(7 + index as u64, quads, 2.0, slope);
        let surface = oracle::Surface::of_mesh(&water);
        let scene = pool(water, 0.8, 6.0, vec![light.clone()]);
        let receivers = floor_points(4000, 1.2, 0.79999, 5 + index as u32);
        let answers = ask(request, &scene, &receivers, "bvh", &[&format!("mnee.search={search}")]);
        let (mut right, mut energy, mut expected_energy, mut roots, mut bad) = (0, 0.0, 0.0, 0, 0);
        let mut shown = 0;
        for (receiver, &found) in receivers.iter().zip(&answers.irradiances) {
            let parts = oracle_irradiances(&surface, receiver, &light);
            let expected: f64 = parts.iter().sum();
            roots += parts.len();
            expected_energy += expected;
            energy += f64::from(found);
            if (f64::from(found) - expected).abs() <= 1e-3 * expected.max(1e-6) {
                right += 1;
            } else {
                bad += 1;
                if shown < 12 {
                    shown += 1;
                    println!("  {:?}: found {found:.5}, expected {expected:.5} of {parts:.5?}", receiver.position);
                }
            }
        }
        println!("light {index}: right {right} bad {bad} roots {roots} energy {:.5}", energy / expected_energy);
        for c in &answers.counters {
            if c.value != 0.0 {
                print!("{} {}, ", c.name, c.value);
            }
        }
        println!();
    }
}
