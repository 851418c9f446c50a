//! Rays against f64, the same cases for the device's ray queries and for the trees in compute.

use glam::{Affine3A, DVec3, Mat3, Quat, Vec2, Vec3};

use super::{Bench, Case, CaseError};
use crate::conformance::case::Worst;
use crate::conformance::faults::{Fault, injected};
use crate::conformance::rays::{ANY_MASK, Oracle, Random, is_hit, random_rays, ray, scene, soup, water};
use crate::gpu::Capability;
use crate::gpu_scene::{GpuScene, MASK_DIFFUSE, MASK_SPECULAR};
use crate::scene::{Mesh, Scene, shapes};
use crate::trace::{Backend, Following, Probe, ProbeHit, Ray, Tracer};

const TREES: &[Backend] = &[Backend::Cwbvh, Backend::Bvh2];

/// The cases of one group; `$run` is a module of functions for its back-ends.
macro_rules! cases {
    ($group:literal, $needs:expr, $backends:expr) => {
        &[
            cases!($group, $needs, "closest", CLOSEST, &[], |bench| closest(bench, $backends)),
            cases!($group, $needs, "masks", MASKS, &[Fault::Mask], |bench| masks(bench, $backends)),
            cases!($group, $needs, "ranges", RANGES, &[], |bench| ranges(bench, $backends)),
            cases!($group, $needs, "watertight", WATERTIGHT, &[], |bench| watertight(bench, $backends)),
            cases!($group, $needs, "barycentrics", BARYCENTRICS, &[Fault::Barycentrics], |bench| barycentrics(
                bench, $backends
            )),
            cases!($group, $needs, "refit", REFIT, &[], |bench| refit(bench, $backends)),
        ]
    };
    ($group:literal, $needs:expr, $name:literal, $about:expr, $catches:expr, $run:expr) => {
        Case { group: $group, name: $name, about: $about, needs: $needs, minds: &[], catches: $catches, run: $run }
    };
}

const CLOSEST: &str = "the closest hit in turned, stretched and mirrored instances, by trying every triangle in f64";
const MASKS: &str = "rays see the instances that share a bit with their mask, and no others";
const RANGES: &str = "hits lie strictly between t_min and t_max; rays with NaN hit nothing";
const WATERTIGHT: &str = "of 10^6 rays at edges and vertices of closed surfaces none gets through";
const BARYCENTRICS: &str = "triangle, t and barycentrics of 10^6 rays at edges and vertices, against f64";
const REFIT: &str = "after vertices and instances have moved, hits are those of the new places, in f64";

pub(super) const RAY_QUERY_CASES: &[Case] = cases!("ray_query", &[Capability::RayQuery], &[Backend::RayQuery]);
pub(super) const BVH_CASES: &[Case] = cases!("bvh", &[], TREES);

/// Hits of all rays, as the device says or as a fault has it.
fn hits(
    bench: &Bench<'_>,
    gpu_scene: &GpuScene,
    tracer: &Tracer,
    rays: &[Ray],
    mask: u32,
) -> Result<Vec<ProbeHit>, CaseError> {
    let probe = Probe::new(bench.device, tracer, rays)?;
    probe.run(tracer, gpu_scene, if injected(Fault::Mask) { ANY_MASK } else { mask }, false)?;
    let mut hits = probe.hits()?;
    if injected(Fault::Barycentrics) {
        hits.iter_mut().for_each(|hit| hit.barycentrics.swap(0, 1));
    }
    Ok(hits)
}

/// A hit's place may be off by this, relative to the way from the origin: some ten roundings of f32.
const PLACE: f64 = 3e-6;
/// Nearly edge-on, t is as uncertain as the place across the ray is, over the slope.
const SLOPE: f64 = 50.0;
/// A ray that passes an edge within this share of the triangle's height may count as inside or outside.
const EDGE: f64 = 1e-4;

/// Whether a hit is what the oracle says; else what is wrong with it. Where a ray grazes an edge or an end of its range,
/// either answer is right.
fn verdict(oracle: &Oracle, ray: &Ray, hit: &ProbeHit, mask: u32) -> Option<String> {
    let reach = f64::from(Vec3::from(ray.origin).length()) + 4.0;
    let length = f64::from(Vec3::from(ray.direction).length());
    let tolerance = |t: f64| PLACE * (t.abs() + reach / length);
    let expected = oracle.closest(ray, mask);
    let clear = expected.filter(|(_, _, there)| {
        let [from_start, to_end] = [there.t - f64::from(ray.t_min), f64::from(ray.t_max) - there.t];
        there.inside > EDGE && from_start > tolerance(there.t) && to_end > tolerance(there.t)
    });
    if !is_hit(hit) {
        return clear.map(|(instance, triangle, there)| {
            format!("missed: triangle {triangle} of instance {instance} at t = {}", there.t)
        });
    }
    if oracle.mask(hit.instance) & mask == 0 {
        return Some(format!("instance {} is not of the mask", hit.instance));
    }
    if !(hit.t > ray.t_min && hit.t < ray.t_max) {
        return Some(format!("t = {} is out of range", hit.t));
    }
    let named = oracle.meet(ray, hit.instance, hit.primitive)?;
    let t = f64::from(hit.t);
    if named.inside < -EDGE {
        return Some(format!("beside triangle {} of instance {} by {}", hit.primitive, hit.instance, -named.inside));
    }
    if (named.t - t).abs() > SLOPE * tolerance(t) {
        return Some(format!("t = {t}, not {}", named.t));
    }
    let behind = clear.filter(|(_, _, there)| t > there.t + SLOPE * tolerance(t));
    behind.map(|(_, _, there)| format!("t = {t}, and there is something at {}", there.t))
}

/// Counts the rays whose hits are not the oracle's.
fn judge(bench: &mut Bench<'_>, what: &str, oracle: &Oracle, rays: &[Ray], hits: &[ProbeHit], mask: u32) {
    let mut worst = Worst::default();
    let mut wrong = 0u32;
    for (ray, hit) in rays.iter().zip(hits) {
        if let Some(reason) = verdict(oracle, ray, hit, mask) {
            wrong += 1;
            worst.see(1.0, || format!("first from {:?} along {:?}: {reason}", ray.origin, ray.direction));
        }
    }
    worst.measured = wrong.into();
    bench.at_most(what, worst, 0.0, &format!("wrong of {}", rays.len()));
}

fn placed(random: &mut Random, spread: f32) -> Affine3A {
    let turn = Quat::from_axis_angle(random.direction(), 6.0 * random.unit());
    let stretch = Vec3::new(0.3 + random.unit(), 0.3 + random.unit(), -0.3 - random.unit());
    Affine3A::from_scale_rotation_translation(stretch, turn, spread * random.cube())
}

/// Two meshes in nine places; every second instance is specular.
fn instances() -> Scene {
    let mut random = Random(1);
    let meshes = vec![soup(&mut random, 150), shapes::sphere("sphere", DVec3::ZERO, 0.8, 12)];
    let instances: Vec<_> = (0..9).map(|i| (i % 2, placed(&mut random, 3.0))).collect();
    scene(meshes, &instances)
}

/// Rays that an oracle tries every triangle for.
const TRIED: usize = 2000;

fn closest(bench: &mut Bench<'_>, backends: &[Backend]) -> Result<(), CaseError> {
    let scene = instances();
    let gpu_scene = GpuScene::new(bench.device, &scene)?;
    let oracle = Oracle::new(&scene);
    let mut random = Random(2);
    let mut rays = random_rays(&mut random, TRIED, Vec3::ZERO, 4.0);
    for (i, ray) in rays.iter_mut().enumerate() {
        let length = Vec3::from(ray.direction).length();
        if i % 3 == 1 {
            ray.t_min = 4.0 * random.unit() / length;
        }
        if i % 4 == 1 {
            ray.t_max = ray.t_min + 4.0 * random.unit() / length;
        }
    }
    for &backend in backends {
        let tracer = Tracer::new(bench.device, &scene, &gpu_scene, backend)?;
        let hits = hits(bench, &gpu_scene, &tracer, &rays, ANY_MASK)?;
        judge(bench, &format!("rays by {}", backend.name()), &oracle, &rays, &hits, ANY_MASK);
    }
    Ok(())
}

fn masks(bench: &mut Bench<'_>, backends: &[Backend]) -> Result<(), CaseError> {
    let scene = instances();
    let gpu_scene = GpuScene::new(bench.device, &scene)?;
    let oracle = Oracle::new(&scene);
    let rays = random_rays(&mut Random(3), TRIED, Vec3::ZERO, 4.0);
    for &backend in backends {
        let tracer = Tracer::new(bench.device, &scene, &gpu_scene, backend)?;
        for mask in [MASK_SPECULAR, MASK_DIFFUSE, MASK_SPECULAR | MASK_DIFFUSE] {
            let hits = hits(bench, &gpu_scene, &tracer, &rays, mask)?;
            judge(bench, &format!("rays of mask {mask} by {}", backend.name()), &oracle, &rays, &hits, mask);
        }
        let none = hits(bench, &gpu_scene, &tracer, &rays, 0x80)?.iter().filter(|hit| is_hit(hit)).count();
        let worst = Worst { measured: none as f64, place: "no instance has that bit".to_string() };
        bench.at_most(&format!("hits of rays of mask 128 by {}", backend.name()), worst, 0.0, "");
    }
    Ok(())
}

/// Rays along the axes through a cube from -1 to 1, and the t that they should have.
fn rays_of_ranges() -> Vec<(Ray, Option<f32>)> {
    let mut expected = Vec::new();
    for axis in [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z] {
        let other = 0.3 * Vec3::new(axis.y, axis.z, axis.x) + 0.15 * Vec3::new(axis.z, axis.x, axis.y);
        let inside = ray(other, axis);
        expected.push((ray(other - 3.0 * axis, axis), Some(2.0)));
        expected.push((ray(other - 3.0 * axis, axis * 1e-6), Some(2e6)));
        expected.push((ray(5.0 * other - 3.0 * axis, axis), None));
        expected.push((ray(-3.0 * axis, -axis), None));
        // From a surface: its own t = 0 is not in the range, the far side is.
        expected.push((ray(other - axis, axis), Some(2.0)));
        expected.push((ray(other + axis, axis), None));
        expected.push((Ray { t_max: 1.0, ..inside }, None));
        expected.push((Ray { t_max: 1.0001, ..inside }, Some(1.0)));
        expected.push((Ray { t_min: 1.0, ..inside }, None));
        expected.push((Ray { t_min: 0.9999, ..inside }, Some(1.0)));
        expected.push((Ray { t_min: 0.5, t_max: 0.25, ..inside }, None));
        expected.push((Ray { t_max: f32::MAX, ..inside }, Some(1.0)));
        expected.push((Ray { t_min: f32::NAN, ..inside }, None));
        expected.push((Ray { t_max: f32::NAN, ..inside }, None));
        expected.push((ray(Vec3::ZERO, Vec3::ZERO), None));
        expected.push((ray(other + f32::NAN * axis, axis), None));
        expected.push((ray(other, axis + f32::INFINITY * other), None));
    }
    expected
}

fn ranges(bench: &mut Bench<'_>, backends: &[Backend]) -> Result<(), CaseError> {
    let faces = shapes::Face::ALL.map(|(_, face)| face);
    let cube = shapes::cuboid("cube", DVec3::ZERO, DVec3::splat(2.0), &faces, false);
    let scene = scene(vec![cube], &[(0, Affine3A::IDENTITY)]);
    let gpu_scene = GpuScene::new(bench.device, &scene)?;
    let expected = rays_of_ranges();
    let rays: Vec<Ray> = expected.iter().map(|(ray, _)| *ray).collect();
    for &backend in backends {
        let tracer = Tracer::new(bench.device, &scene, &gpu_scene, backend)?;
        let mut worst = Worst::default();
        let mut wrong = 0u32;
        for (hit, (ray, t)) in hits(bench, &gpu_scene, &tracer, &rays, ANY_MASK)?.iter().zip(&expected) {
            let right = match t {
                Some(t) => is_hit(hit) && (hit.t / t - 1.0).abs() < 1e-5,
                None => !is_hit(hit),
            };
            if !right {
                wrong += 1;
                let found = is_hit(hit).then_some(hit.t);
                worst.see(1.0, || format!("first {ray:?}: t = {found:?}, not {t:?}"));
            }
        }
        worst.measured = wrong.into();
        bench.at_most(&format!("rays by {}", backend.name()), worst, 0.0, &format!("wrong of {}", rays.len()));
    }
    Ok(())
}

/// Points on edges of triangles whose corners are all `wanted`, in world space: a third each are corners, middles and any.
fn aims(scene: &Scene, wanted: impl Fn(Vec3) -> bool) -> impl FnMut(&mut Random) -> Vec3 {
    let instance = &scene.instances[0];
    let mesh = &scene.meshes[instance.mesh];
    let transform = instance.transform;
    let matrix = Mat3::from(transform.matrix3).as_dmat3();
    let corners = |t: &[u32; 3]| t.map(|i| mesh.positions[i as usize]);
    let triangles: Vec<_> = mesh.triangles.iter().map(corners).filter(|t| t.iter().all(|&p| wanted(p))).collect();
    let mut count = 0;
    move |random| {
        count += 1;
        let triangle = triangles[random.below(triangles.len())];
        let side = random.below(3);
        let (a, b) = (triangle[side].as_dvec3(), triangle[(side + 1) % 3].as_dvec3());
        let share = [0.0, 0.5, f64::from(random.unit())][count % 3];
        (matrix * a.lerp(b, share) + transform.translation.as_dvec3()).as_vec3()
    }
}

/// From points inside of a closed convex surface, every fourth from its very centre, where many edges look like points.
fn from_inside(scene: &Scene, count: usize) -> Vec<Ray> {
    let transform = scene.instances[0].transform;
    let mut random = Random(11);
    let mut aim = aims(scene, |_| true);
    (0..count)
        .map(|i| {
            let origin = if i % 4 == 0 { Vec3::ZERO } else { 0.8 * random.unit() * random.direction() };
            let origin = transform.transform_point3(origin);
            ray(origin, aim(&mut random) - origin)
        })
        .collect()
}

/// From above, steeper than the waves, every fourth exactly downward; away from the water's border.
fn from_above(scene: &Scene, count: usize) -> Vec<Ray> {
    let mut random = Random(12);
    let mut aim = aims(scene, |p| p.x.abs() < 5.5 && p.z.abs() < 5.5);
    (0..count)
        .map(|i| {
            let target = aim(&mut random);
            let height = [0.5, 5.0, 300.0][i % 3];
            let lean = if i % 4 == 0 { Vec3::ZERO } else { random.cube() * Vec3::new(0.5, 0.0, 0.5) };
            let origin = target + height * (Vec3::Y + lean);
            ray(origin, if i % 4 == 0 { -Vec3::Y } else { target - origin })
        })
        .collect()
}

fn sphere() -> Mesh {
    shapes::sphere("sphere", DVec3::ZERO, 1.0, 96)
}

fn watertight(bench: &mut Bench<'_>, backends: &[Backend]) -> Result<(), CaseError> {
    let turn = Quat::from_axis_angle(Vec3::new(1.0, 2.0, -1.0).normalize(), 1.1);
    let far = Vec3::new(100.0, -40.0, 70.0);
    let stretch = Affine3A::from_scale_rotation_translation(Vec3::new(0.1, 3.0, -1.7), turn, far);
    let surfaces = [
        ("a sphere", scene(vec![sphere()], &[(0, Affine3A::IDENTITY)])),
        ("a stretched sphere far off", scene(vec![sphere()], &[(0, stretch)])),
        ("water", scene(vec![water(128, 1.0)], &[(0, Affine3A::IDENTITY)])),
    ];
    for (name, scene) in surfaces {
        let rays = if name == "water" { from_above(&scene, 333_334) } else { from_inside(&scene, 333_333) };
        let gpu_scene = GpuScene::new(bench.device, &scene)?;
        for &backend in backends {
            let tracer = Tracer::new(bench.device, &scene, &gpu_scene, backend)?;
            let found = hits(bench, &gpu_scene, &tracer, &rays, ANY_MASK)?;
            let mut lost = rays.iter().zip(&found).filter(|(_, hit)| !is_hit(hit)).map(|(ray, _)| ray);
            let mut worst = Worst::default();
            if let Some(first) = lost.next() {
                let count = 1 + lost.count();
                worst.see(count as f64, || format!("first from {:?} along {:?}", first.origin, first.direction));
            }
            let what = format!("rays that get through {name} by {}", backend.name());
            bench.at_most(&what, worst, 0.0, &format!("of {}", rays.len()));
        }
    }
    Ok(())
}

/// Weights of vertices may be off by this: an error of place in triangles a hundred times smaller than the scene. 5e-4 is what
/// both trees and lavapipe's ray queries are off.
const WEIGHTS: f64 = 2e-3;
/// And t, in units of ten roundings: 0.04 is what they are off.
const DEPTH: f64 = 2.0;

fn barycentrics(bench: &mut Bench<'_>, backends: &[Backend]) -> Result<(), CaseError> {
    let surfaces = [
        ("a sphere", scene(vec![sphere()], &[(0, Affine3A::IDENTITY)])),
        ("water", scene(vec![water(128, 1.0)], &[(0, Affine3A::IDENTITY)])),
    ];
    for (name, scene) in surfaces {
        let rays = if name == "water" { from_above(&scene, 500_000) } else { from_inside(&scene, 500_000) };
        let gpu_scene = GpuScene::new(bench.device, &scene)?;
        let oracle = Oracle::new(&scene);
        for &backend in backends {
            let tracer = Tracer::new(bench.device, &scene, &gpu_scene, backend)?;
            let found = hits(bench, &gpu_scene, &tracer, &rays, ANY_MASK)?;
            let [mut beside, mut off, mut weights] = [(); 3].map(|()| Worst::default());
            for (ray, hit) in rays.iter().zip(&found).filter(|(_, hit)| is_hit(hit)) {
                let Some(named) = oracle.meet(ray, hit.instance, hit.primitive) else { continue };
                let reach = f64::from(Vec3::from(ray.origin).length()) + 4.0;
                let tolerance = PLACE * (named.t.abs() + reach / f64::from(Vec3::from(ray.direction).length()));
                let at = |what: String| format!("from {:?} along {:?}: {what}", ray.origin, ray.direction);
                beside.see(-named.inside, || at(format!("triangle {}", hit.primitive)));
                off.see((named.t - f64::from(hit.t)).abs() / tolerance, || at(format!("{}, not {}", hit.t, named.t)));
                let error = (Vec2::from(hit.barycentrics).as_dvec2() - named.barycentrics).abs().max_element();
                weights.see(error, || at(format!("{:?}, not {}", hit.barycentrics, named.barycentrics)));
            }
            let who = format!("{name} by {}", backend.name());
            bench.at_most(&format!("distance from the triangle named, {who}"), beside, WEIGHTS, "of its height");
            bench.at_most(&format!("t, {who}"), off, DEPTH, "of ten roundings");
            bench.at_most(&format!("barycentrics, {who}"), weights, WEIGHTS, "");
        }
    }
    Ok(())
}

fn refit(bench: &mut Bench<'_>, backends: &[Backend]) -> Result<(), CaseError> {
    let place = |x: f32, turn: f32| Affine3A::from_rotation_translation(Quat::from_rotation_x(turn), Vec3::X * x);
    let state = |phase: f64, x: f32, turn: f32| {
        let ball = shapes::sphere("ball", DVec3::Y, 0.7, 12);
        scene(vec![water(24, phase), ball], &[(0, Affine3A::IDENTITY), (1, place(x, turn)), (1, place(-x, 0.0))])
    };
    let (before, after) = (state(0.0, 0.0, 0.0), state(2.5, 3.0, 1.0));
    let (gpu_before, gpu_after) = (GpuScene::new(bench.device, &before)?, GpuScene::new(bench.device, &after)?);
    let oracle = Oracle::new(&after);
    let rays = random_rays(&mut Random(3), TRIED, Vec3::ZERO, 5.0);
    for &backend in backends {
        let ways: &[(&str, Following)] = match backend {
            Backend::RayQuery => &[("rebuild", Following::Rebuild), ("update", Following::Update)],
            _ => &[("refit", Following::Rebuild)],
        };
        for (way, following) in ways {
            let mut tracer = Tracer::following(bench.device, &before, &gpu_before, backend, *following)?;
            tracer.update(bench.device, &after, &gpu_after, &[0])?;
            let hits = hits(bench, &gpu_after, &tracer, &rays, ANY_MASK)?;
            judge(bench, &format!("rays by {}, {way}", backend.name()), &oracle, &rays, &hits, ANY_MASK);
        }
    }
    Ok(())
}
