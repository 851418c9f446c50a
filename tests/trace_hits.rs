//! Hits of every back-end against an oracle in f64 that tries every triangle.

mod common;
mod tracing;

use std::process::ExitCode;

use common::{Case, Request, assert_valid};
use glam::{Affine3A, Quat, Vec3};
use nephroid::gpu_scene::{GpuScene, MASK_DIFFUSE, MASK_SPECULAR};
use nephroid::scene::{Mesh, Scene, shapes};
use nephroid::trace::{Backend, ProbeHit, Ray, Tracer};
use tracing::{ANY_MASK, Oracle, Random, hits, is_hit, mesh, random_rays, ray, scene, soup, tracers, water};

/// Rays per scene and mask: what the oracle does in a second.
const RAYS: usize = 3000;

/// A hit's place may be off by this, relative to the way from the origin: some ten roundings of f32.
const PLACE: f64 = 3e-6;

/// A ray that passes an edge within this share of the triangle's height may count as inside or outside.
const EDGE: f64 = 1e-4;

/// Weights of vertices may be off by this: an error of place in triangles a hundred times smaller than the scene.
const WEIGHTS: f64 = 1e-2;

fn main() -> ExitCode {
    common::run(&[
        Case { name: "hits_are_the_oracles", needs: &[], disable: "", run: random_scenes },
        Case { name: "odd_meshes_are_traced", needs: &[], disable: "", run: odd_meshes },
        Case { name: "odd_rays_end", needs: &[], disable: "", run: odd_rays },
        Case { name: "moved_scenes_are_followed", needs: &[], disable: "", run: moved },
    ])
}

/// Turned, mirrored and stretched instances, each mask, closest and any hits.
fn random_scenes(request: &Request) {
    let device = request.open();
    let mut random = Random(1);
    let meshes = vec![soup(&mut random, 150), shapes::sphere("sphere", glam::DVec3::ZERO, 0.8, 12)];
    let instances: Vec<_> = (0..9).map(|i| (i % 2, placed(&mut random, 3.0))).collect();
    let scene = scene(meshes, &instances);
    let gpu_scene = GpuScene::new(&device, &scene).unwrap();
    let oracle = Oracle::new(&scene);
    let mut rays = random_rays(&mut random, RAYS, Vec3::ZERO, 4.0);
    for (i, ray) in rays.iter_mut().enumerate() {
        let length = Vec3::from(ray.direction).length();
        if i % 3 == 1 {
            ray.t_min = 4.0 * random.unit() / length;
        }
        if i % 4 == 1 {
            ray.t_max = ray.t_min + 4.0 * random.unit() / length;
        }
    }
    for tracer in tracers(&device, &scene, &gpu_scene) {
        for mask in [MASK_SPECULAR, MASK_DIFFUSE, ANY_MASK] {
            let closest = hits(&device, &gpu_scene, &tracer, &rays, mask, false);
            check(&oracle, &rays, &closest, mask, tracer.backend.name());
            let any = hits(&device, &gpu_scene, &tracer, &rays, mask, true);
            for ((ray, closest), any) in rays.iter().zip(&closest).zip(&any) {
                assert_eq!(is_hit(closest), is_hit(any), "{}: {ray:?}", tracer.backend.name());
            }
        }
    }
    assert_valid(&device);
}

fn placed(random: &mut Random, spread: f32) -> Affine3A {
    let turn = Quat::from_axis_angle(random.direction(), 6.0 * random.unit());
    let stretch = Vec3::new(0.3 + random.unit(), 0.3 + random.unit(), -0.3 - random.unit());
    Affine3A::from_scale_rotation_translation(stretch, turn, spread * random.cube())
}

/// Every hit is where the triangle is that it names, and nothing is in front of it.
fn check(oracle: &Oracle, rays: &[Ray], hits: &[ProbeHit], mask: u32, who: &str) {
    let mut found = 0;
    for (ray, hit) in rays.iter().zip(hits) {
        let length = f64::from(Vec3::from(ray.direction).length());
        let reach = f64::from(Vec3::from(ray.origin).length()) + 4.0;
        let tolerance = |t: f64| PLACE * (t.abs() + reach / length);
        let expected = oracle.closest(ray, mask);
        // Where the ray grazes an edge or an end of its range, either answer is right.
        let clear = |t: f64, inside: f64| {
            inside > EDGE && (t - f64::from(ray.t_min)) > tolerance(t) && (f64::from(ray.t_max) - t) > tolerance(t)
        };
        if is_hit(hit) {
            found += 1;
            let context = format!("{who}: {ray:?} {hit:?}, expected {expected:?}");
            assert!(oracle.mask(hit.instance) & mask != 0, "masked out: {context}");
            assert!(hit.t > ray.t_min && hit.t < ray.t_max, "out of range: {context}");
            let Some(named) = oracle.meet(ray, hit.instance, hit.primitive) else { continue };
            let t = f64::from(hit.t);
            // Nearly edge-on, t is as uncertain as the place across the ray is, over the slope.
            assert!(named.inside > -EDGE, "beside its triangle: {context} {named:?}");
            assert!((named.t - t).abs() <= 50.0 * tolerance(t), "off its triangle: {context} {named:?}");
            let weights = glam::Vec2::from(hit.barycentrics).as_dvec2() - named.barycentrics;
            assert!(weights.abs().max_element() < WEIGHTS, "wrong weights: {context} {named:?}");
            if let Some((_, _, closest)) = expected
                && clear(closest.t, closest.inside)
            {
                assert!(t <= closest.t + 50.0 * tolerance(t), "behind the closest: {context}");
            }
        } else if let Some((_, _, closest)) = expected {
            assert!(!clear(closest.t, closest.inside), "{who}: missed: {ray:?}, expected {expected:?}");
        }
    }
    assert!(found > rays.len() / 20, "{who}: only {found} of {} rays hit anything", rays.len());
}

fn odd_meshes(request: &Request) {
    let device = request.open();
    let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
    let single = mesh("single", corners.clone(), vec![[0, 1, 2]]);
    let empty = mesh("empty", corners.clone(), Vec::new());
    let same = mesh("same", corners.clone(), vec![[0, 1, 2]; 3000]);
    let point_and_line = mesh("degenerate", corners.clone(), vec![[0, 0, 0], [0, 1, 1], [0, 1, 2]]);
    let huge = mesh("huge", corners.iter().map(|c| *c * 1e6).collect(), vec![[0, 1, 2]]);
    let tiny = mesh("tiny", corners.iter().map(|c| *c * 1e-6).collect(), vec![[0, 1, 2]]);
    let mut chain: Vec<Vec3> = Vec::new();
    for i in 0..120 {
        chain.extend(corners.iter().map(|c| *c * 1.2f32.powi(-i)));
    }
    let chain = mesh("chain", chain, (0..120).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect());
    for odd in [single, same, point_and_line, huge, tiny, chain] {
        let size = odd.positions.iter().fold(0.0f32, |m, p| m.max(p.length()));
        let name = odd.name.clone();
        let scene = scene(vec![empty.clone(), odd], &[(0, Affine3A::IDENTITY), (1, Affine3A::IDENTITY)]);
        let at = Vec3::new(0.25, 0.375, 0.0) * size;
        let down = ray(at + Vec3::Z * size, -Vec3::Z);
        let past = ray(at + Vec3::new(1.0, 0.0, 1.0) * size, -Vec3::Z);
        let gpu_scene = GpuScene::new(&device, &scene).unwrap();
        for tracer in tracers(&device, &scene, &gpu_scene) {
            let found = hits(&device, &gpu_scene, &tracer, &[down, past], ANY_MASK, false);
            let who = format!("{name} by {}", tracer.backend.name());
            assert_eq!(found[0].instance, 1, "{who}");
            assert!((found[0].t / size - 1.0).abs() < 1e-5, "{who}: {:?}", found[0]);
            assert!(!is_hit(&found[1]), "{who}: {:?}", found[1]);
        }
    }
    nothing_there(&device, scene(vec![empty], &[(0, Affine3A::IDENTITY)]));
    nothing_there(&device, scene(Vec::new(), &[]));
    many_instances(&device);
    assert_valid(&device);
}

fn nothing_there(device: &nephroid::gpu::Device, scene: Scene) {
    let gpu_scene = GpuScene::new(device, &scene).unwrap();
    for tracer in tracers(device, &scene, &gpu_scene) {
        let found = hits(device, &gpu_scene, &tracer, &[ray(Vec3::Z, -Vec3::Z)], ANY_MASK, false);
        assert!(!is_hit(&found[0]), "{}", tracer.backend.name());
    }
}

fn many_instances(device: &nephroid::gpu::Device) {
    let mut random = Random(7);
    let instances: Vec<_> = (0..400).map(|_| (0, placed(&mut random, 5.0))).collect();
    let scene = scene(vec![soup(&mut random, 6)], &instances);
    let gpu_scene = GpuScene::new(device, &scene).unwrap();
    let oracle = Oracle::new(&scene);
    let rays = random_rays(&mut random, RAYS / 3, Vec3::ZERO, 5.0);
    for tracer in tracers(device, &scene, &gpu_scene) {
        let found = hits(device, &gpu_scene, &tracer, &rays, ANY_MASK, false);
        check(&oracle, &rays, &found, ANY_MASK, tracer.backend.name());
    }
}

/// Along the axes, through grid lines, from surfaces; and rays that are none.
fn odd_rays(request: &Request) {
    let device = request.open();
    let cube = shapes::cuboid(
        "cube",
        glam::DVec3::ZERO,
        glam::DVec3::splat(2.0),
        &shapes::Face::ALL.map(|(_, face)| face),
        false,
    );
    let scene = scene(vec![cube], &[(0, Affine3A::IDENTITY)]);
    let gpu_scene = GpuScene::new(&device, &scene).unwrap();
    let axes = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
    let mut expected: Vec<(Ray, Option<f32>)> = Vec::new();
    for axis in axes {
        let other = Vec3::new(axis.y, axis.z, axis.x);
        for shift in [0.0, 0.5, 1.0] {
            // Shift 1 runs within a face, along the whole cube: the faces at its ends are hit at their edges.
            expected.push((ray(shift * other - 3.0 * axis, axis), Some(2.0)));
            expected.push((ray(shift * other - 3.0 * axis, axis * 1e-6), Some(2e6)));
            expected.push((ray(shift * other - 3.0 * axis, axis * 1e15), Some(2e-15)));
        }
        expected.push((ray(1.5 * other - 3.0 * axis, axis), None));
        expected.push((ray(-3.0 * axis, -axis), None));
        // From a surface: its own t = 0 is not in the range, the far side is.
        expected.push((ray(0.3 * other - axis, axis), Some(2.0)));
        expected.push((ray(0.3 * other + axis, axis), None));
        let inside = ray(0.3 * other, axis);
        expected.push((Ray { t_max: 1.0, ..inside }, None));
        expected.push((Ray { t_max: 1.0001, ..inside }, Some(1.0)));
        expected.push((Ray { t_min: 1.0, ..inside }, None));
        expected.push((Ray { t_min: 0.9999, ..inside }, Some(1.0)));
        expected.push((Ray { t_min: 0.5, t_max: 0.25, ..inside }, None));
        expected.push((Ray { t_min: -5.0, ..inside }, Some(1.0)));
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            expected.push((ray(other + bad * axis, axis), None));
            expected.push((ray(Vec3::ZERO, axis + bad * other), None));
        }
        expected.push((Ray { t_min: f32::NAN, ..inside }, None));
        expected.push((Ray { t_max: f32::NAN, ..inside }, None));
        expected.push((ray(Vec3::ZERO, Vec3::ZERO), None));
        expected.push((Ray { t_max: f32::MAX, ..inside }, Some(1.0)));
    }
    let rays: Vec<Ray> = expected.iter().map(|(ray, _)| *ray).collect();
    for tracer in tracers(&device, &scene, &gpu_scene) {
        for (hit, (ray, t)) in hits(&device, &gpu_scene, &tracer, &rays, ANY_MASK, false).iter().zip(&expected) {
            // A driver's own ray queries may leak at edges, and lavapipe's do.
            if tracer.backend == Backend::RayQuery
                && Vec3::from(ray.origin).abs().cmpeq(Vec3::ONE).any()
                && !is_hit(hit)
            {
                continue;
            }
            let context = format!("{}: {ray:?} gave {hit:?}, expected {t:?}", tracer.backend.name());
            match t {
                Some(t) => assert!(is_hit(hit) && (hit.t / t - 1.0).abs() < 1e-5, "{context}"),
                None => assert!(!is_hit(hit), "{context}"),
            }
        }
    }
    assert_valid(&device);
}

/// A tracer that followed its scene gives the hits of one that was built for it.
fn moved(request: &Request) {
    let device = request.open();
    let place = |x: f32, turn: f32| Affine3A::from_rotation_translation(Quat::from_rotation_x(turn), Vec3::X * x);
    let state = |water: Mesh, x: f32, turn: f32| {
        let ball = shapes::sphere("ball", glam::DVec3::Y, 0.7, 16);
        scene(vec![water, ball], &[(0, Affine3A::IDENTITY), (1, place(x, turn)), (1, place(-x, 0.0))])
    };
    let before = state(water(32, 0.0), 0.0, 0.0);
    let after = state(water(32, 2.5), 3.0, 1.0);
    let (gpu_before, gpu_after) = (GpuScene::new(&device, &before).unwrap(), GpuScene::new(&device, &after).unwrap());
    let rays = random_rays(&mut Random(3), 20_000, Vec3::ZERO, 5.0);
    for (mut tracer, fresh) in
        tracers(&device, &before, &gpu_before).into_iter().zip(tracers(&device, &after, &gpu_after))
    {
        let old = hits(&device, &gpu_before, &tracer, &rays, ANY_MASK, false);
        tracer.update(&device, &after, &gpu_after, &[0]).unwrap();
        let followed = hits(&device, &gpu_after, &tracer, &rays, ANY_MASK, false);
        let built = hits(&device, &gpu_after, &fresh, &rays, ANY_MASK, false);
        assert_ne!(old, built, "nothing moved");
        assert_same(&tracer, &rays, &followed, &built);
        // A mesh that has other triangles is no moved mesh.
        let other = state(water(16, 0.0), 0.0, 0.0);
        let error = tracer.update(&device, &other, &gpu_after, &[0]).unwrap_err().to_string();
        assert!(error.contains("water"), "{error}");
    }
    assert_valid(&device);
}

/// Equal bits, but for the choice between triangles that are hit at the same t.
fn assert_same(tracer: &Tracer, rays: &[Ray], a: &[ProbeHit], b: &[ProbeHit]) {
    for ((ray, a), b) in rays.iter().zip(a).zip(b) {
        let tie = is_hit(a) && is_hit(b) && a.t == b.t;
        assert!(a == b || tie, "{}: {ray:?}: {a:?} and {b:?}", tracer.backend.name());
    }
}
