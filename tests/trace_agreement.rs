//! The back-ends agree on what the cameras of a scene see; and which one is chosen.

mod common;
mod tracing;

use std::path::Path;
use std::process::ExitCode;

use common::{Case, Request, assert_valid};
use nephroid::gpu::{Capability, Device};
use nephroid::gpu_scene::GpuScene;
use nephroid::scene::{self, Camera};
use nephroid::trace::{Backend, MARGIN, Ray, TraceChoice, Tracer, choose};
use tracing::{ANY_MASK, hits, is_hit, ray, tracers};

/// Pixels of one camera; a device without ray queries has less to compare, and SwiftShader is slow.
const PIXELS: (u32, u32) = (960, 720);
const FEW_PIXELS: (u32, u32) = (240, 180);

/// Two hits are a tie, on an edge or where surfaces meet, if their t differ by no more than this share: f32 roundings.
const TIE: f32 = 2e-6;

/// Ties are rare; were they not, wrong ids could pass as ties.
const MOST_TIES: f64 = 0.01;

fn main() -> ExitCode {
    common::run(&[
        Case { name: "back_ends_see_the_same_pool", needs: &[], disable: "", run: pool },
        Case { name: "back_ends_are_chosen_as_asked", needs: &[], disable: "", run: choices },
        Case {
            name: "without_ray_queries_a_bvh_is_chosen",
            needs: &[Capability::RayQuery],
            disable: "ray-query",
            run: disabled,
        },
    ])
}

fn pool(request: &Request) {
    let device = request.open();
    let scene = scene::load(Path::new("scenes/pool.toml")).unwrap();
    let gpu_scene = GpuScene::new(&device, &scene).unwrap();
    let size = if device.has(Capability::RayQuery) { PIXELS } else { FEW_PIXELS };
    let tracers = tracers(&device, &scene, &gpu_scene);
    for camera in &scene.cameras {
        let rays = camera_rays(camera, size);
        let all: Vec<_> =
            tracers.iter().map(|t| (t.backend, hits(&device, &gpu_scene, t, &rays, ANY_MASK, false))).collect();
        let (first, expected) = &all[0];
        for (other, found) in &all[1..] {
            let (mut ties, mut different, mut only_one) = (0, Vec::new(), 0);
            for ((a, b), ray) in expected.iter().zip(found).zip(&rays) {
                if is_hit(a) != is_hit(b) {
                    only_one += 1;
                } else if (a.instance, a.primitive) != (b.instance, b.primitive) {
                    match (a.t - b.t).abs() <= TIE * a.t.abs() {
                        true => ties += 1,
                        false => different.push((ray, a, b)),
                    }
                }
            }
            println!(
                "{} on {}: {} and {} differ in hit or miss at {only_one} of {} rays, in ids at {}, and tie at {ties}",
                camera.name,
                device.info.name,
                first.name(),
                other.name(),
                rays.len(),
                different.len()
            );
            assert_eq!(only_one, 0);
            assert!(different.is_empty(), "{:?}", different[0]);
            assert!(f64::from(ties) < MOST_TIES * rays.len() as f64);
        }
        let seen = expected.iter().filter(|hit| is_hit(hit)).count();
        assert!(seen > rays.len() / 2, "the camera {} sees little: {seen} of {}", camera.name, rays.len());
    }
    assert_valid(&device);
}

fn camera_rays(camera: &Camera, (width, height): (u32, u32)) -> Vec<Ray> {
    let forward = (camera.target - camera.position).normalize();
    let right = forward.cross(camera.up).normalize();
    let up = right.cross(forward);
    let half = (camera.fov_y.to_radians() * 0.5).tan();
    let pixel = |i: u32| {
        let x = (2.0 * ((i % width) as f32 + 0.5) / width as f32 - 1.0) * half * width as f32 / height as f32;
        let y = (1.0 - 2.0 * ((i / width) as f32 + 0.5) / height as f32) * half;
        ray(camera.position, (forward + right * x + up * y).normalize())
    };
    (0..width * height).map(pixel).collect()
}

fn choices(request: &Request) {
    let device = request.open();
    let (tracer, choice) = chosen(&device, "auto");
    println!("{}: {}", device.info.name, choice.reason);
    assert_eq!(tracer.backend, choice.backend);
    if device.has(Capability::RayQuery) {
        assert_eq!(choice.measured.len(), 2, "{choice:?}");
        let speed = |backend| choice.measured.iter().find(|m| m.backend == backend).unwrap().mixed();
        let ray_query = speed(Backend::RayQuery) > MARGIN * speed(Backend::Cwbvh);
        assert_eq!(choice.backend, if ray_query { Backend::RayQuery } else { Backend::Cwbvh });
        assert!(choice.measured.iter().all(|m| m.closest > 0.0 && m.occlusion > 0.0));
    }
    assert_eq!(chosen(&device, "bvh").0.backend, Backend::Cwbvh);
    assert_eq!(chosen(&device, "cwbvh").0.backend, Backend::Cwbvh);
    assert_eq!(chosen(&device, "bvh2").0.backend, Backend::Bvh2);
    let error = "octree".parse::<TraceChoice>().unwrap_err().to_string();
    assert_eq!(error, "unknown tracing back-end \"octree\"; allowed are: auto, ray-query, bvh, bvh2, cwbvh");
    assert_valid(&device);
}

fn disabled(request: &Request) {
    let device = request.open();
    let (tracer, choice) = chosen(&device, "auto");
    assert_eq!(tracer.backend, Backend::Cwbvh);
    assert!(choice.reason.contains("no ray queries"), "{}", choice.reason);
    let scene = scene::load(Path::new("scenes/pool.toml")).unwrap();
    let gpu_scene = GpuScene::new(&device, &scene).unwrap();
    let error = choose(&device, &scene, &gpu_scene, TraceChoice::RayQuery).err().unwrap().to_string();
    assert!(error.contains(&device.info.name) && error.contains("ray queries"), "{error}");
    assert_valid(&device);
}

fn chosen(device: &Device, name: &str) -> (Tracer, nephroid::trace::Choice) {
    let scene = scene::load(Path::new("scenes/pool.toml")).unwrap();
    let gpu_scene = GpuScene::new(device, &scene).unwrap();
    choose(device, &scene, &gpu_scene, name.parse().unwrap()).unwrap()
}
