//! What lights see, by raster and by rays, against every triangle in f64.

mod common;
mod tracing;

use std::process::ExitCode;

use common::{Case, Request, assert_valid};
use glam::{Affine3A, Vec3};
use nephroid::gpu::{Capability, Device, Recorder};
use nephroid::gpu_scene::{GpuScene, MASK_DIFFUSE, MASK_SPECULAR};
use nephroid::light_view::{LAYERS, LightTexel, LightView, LightViewTier, LightViews};
use nephroid::scene::{Emitter, Light, Scene};
use nephroid::trace::{Backend, NO_INSTANCE, Ray, Tracer};
use tracing::{Oracle, Random, ray, soup, water};

/// Texels along a side: enough edges to get wrong, few enough for brute force.
const RESOLUTION: u32 = 33;
/// Metres by which positions and depths of a scene of some 10 m may be off in f32.
const DEPTH: f64 = 1e-4;
/// Barycentrics: rays nearer than this to an edge may meet the neighbour, or nothing.
const EDGE: f64 = 1e-3;
/// Of the texels, those at which raster and rays may differ: edges are drawn to 1/256 of a texel on each side.
const TIES: f64 = 0.005;

fn main() -> ExitCode {
    common::run(&[
        Case { name: "rays_meet_what_brute_force_meets", needs: &[], disable: "", run: rays },
        Case { name: "raster_and_rays_agree", needs: &[Capability::PreciseRaster], disable: "", run: tiers },
    ])
}

/// Soup over water, lit from far and near, by a spot and by the sun; odd instances are specular.
fn scene() -> Scene {
    let place = |x, y, z| Affine3A::from_translation(Vec3::new(x, y, z));
    let meshes = vec![soup(&mut Random(5), 40), water(8, 0.0)];
    let mut scene = tracing::scene(
        meshes,
        &[
            (0, place(1.0, 1.5, 0.0)),
            (1, place(0.0, -1.0, 0.0)),
            (1, place(0.5, -2.5, 0.3)),
            (0, place(-1.0, 0.5, 2.0)),
        ],
    );
    let emitters = [
        Emitter::Point { position: Vec3::new(0.5, 9.0, 1.0), intensity: Vec3::ONE },
        Emitter::Point { position: Vec3::new(0.2, 0.1, 0.3), intensity: Vec3::ONE },
        Emitter::Spot {
            position: Vec3::new(4.0, 3.0, 3.0),
            direction: Vec3::new(-1.0, -1.0, -0.8).normalize(),
            intensity: Vec3::ONE,
            inner: 0.2,
            outer: 0.5,
            image: None,
        },
        Emitter::Directional { direction: Vec3::new(0.3, -1.0, 0.2).normalize(), irradiance: Vec3::ONE },
    ];
    let light = |emitter: &Emitter| Light { name: "l".to_string(), emitter: emitter.clone(), medium: 0 };
    scene.lights = emitters.iter().map(light).collect();
    scene
}

fn look(device: &Device, scene: &Scene, tier: LightViewTier) -> (Vec<LightView>, Vec<LightTexel>) {
    let gpu_scene = GpuScene::new(device, scene).unwrap();
    let tracer = Tracer::new(device, scene, &gpu_scene, Backend::Cwbvh).unwrap();
    let views = LightViews::new(device, scene, &tracer, RESOLUTION, tier).unwrap();
    let mut recorder = Recorder::new(device).unwrap();
    views.record(&mut recorder, &gpu_scene.bindings.clone().and(&tracer.bindings)).unwrap();
    recorder.submit().unwrap();
    assert_valid(device);
    (views.views().to_vec(), views.read().unwrap())
}

/// The ray of a texel, and of which layer and place it is.
fn texel_ray(view: &LightView, index: usize) -> (usize, Ray) {
    let side = RESOLUTION as usize;
    let (layer, place) = (index / (side * side), index % (side * side));
    let at = |axis: usize, step: usize| {
        view.lower[axis] + (view.upper[axis] - view.lower[axis]) * (step as f32 / (side - 1) as f32)
    };
    let across = at(0, place % side) * Vec3::from(view.right) + at(1, place / side) * Vec3::from(view.up);
    let (origin, forward) = (Vec3::from(view.origin), Vec3::from(view.forward));
    let parallel = view.perspective == 0;
    (layer, if parallel { ray(origin + across, forward) } else { ray(origin, (forward + across).normalize()) })
}

/// For each texel of each view.
fn each(views: &[LightView], mut visit: impl FnMut(usize, &LightView, usize, Ray)) {
    for view in views {
        for index in 0..LAYERS * (RESOLUTION * RESOLUTION) as usize {
            let (layer, ray) = texel_ray(view, index);
            visit(view.first_texel as usize + index, view, layer, ray);
        }
    }
}

fn rays(request: &Request) {
    let scene = scene();
    let (views, texels) = look(&request.open(), &scene, LightViewTier::Rays);
    // Aimed, cube faces, aimed, a box.
    let lights: Vec<u32> = views.iter().map(|view| view.light).collect();
    assert!(lights.contains(&0) && lights.contains(&2) && lights.ends_with(&[3]), "{lights:?}");
    assert!(lights.iter().filter(|&&light| light == 1).count() > 1, "{lights:?}");
    let oracle = Oracle::new(&scene);
    let (mut met, mut ties) = ([0, 0], 0);
    each(&views, |index, _, layer, ray| {
        let mask = [MASK_SPECULAR, MASK_DIFFUSE][layer];
        let (found, texel) = (oracle.closest(&ray, mask), texels[index]);
        met[layer] += usize::from(texel.instance != NO_INSTANCE);
        match found {
            Some((instance, primitive, at)) if (instance, primitive) == (texel.instance, texel.primitive) => {
                let position = Vec3::from(ray.origin).as_dvec3() + at.t * Vec3::from(ray.direction).as_dvec3();
                let away = position.distance(Vec3::from(texel.position).as_dvec3());
                assert!(away < DEPTH && (at.t - f64::from(texel.depth)).abs() < DEPTH, "texel {index}: {away} m away");
                assert_eq!(texel.material, scene.instances[instance as usize].material as u32);
            }
            None if texel.instance == NO_INSTANCE => {}
            // Neighbours share the edge that the ray runs through, or what is met ends there.
            _ => {
                let inside = |instance, primitive| oracle.meet(&ray, instance, primitive).map_or(0.0, |at| at.inside);
                let named = texel.instance == NO_INSTANCE || inside(texel.instance, texel.primitive) > -EDGE;
                let missed = found.is_none_or(|(_, _, at)| at.inside < EDGE);
                assert!(named && missed, "texel {index}: {texel:?} instead of {found:?}");
                ties += 1;
            }
        }
    });
    println!("{} views, {met:?} texels met, {ties} ties", views.len());
    assert!(met[0] > 1000 && met[1] > 1000 && ties < 100, "{met:?} {ties}");
}

fn tiers(request: &Request) {
    let scene = scene();
    let device = request.open();
    let (views, raster) = look(&device, &scene, LightViewTier::Raster);
    let (_, rays) = look(&device, &scene, LightViewTier::Rays);
    let oracle = Oracle::new(&scene);
    let (mut differ, mut wrong) = (0, 0);
    each(&views, |index, _, _, ray| {
        let (a, b) = (raster[index], rays[index]);
        if (a.instance, a.primitive) == (b.instance, b.primitive) {
            let away = (Vec3::from(a.position) - Vec3::from(b.position)).length();
            assert!(f64::from(away) < DEPTH, "texel {index}: {a:?} {b:?}");
            return;
        }
        differ += 1;
        // Whichever is named, the ray must really run through it, or past its very edge.
        for texel in [a, b].iter().filter(|texel| texel.instance != NO_INSTANCE) {
            let inside = oracle.meet(&ray, texel.instance, texel.primitive).map_or(0.0, |at| at.inside);
            wrong += usize::from(inside < -EDGE);
        }
    });
    println!("{differ} of {} texels differ", raster.len());
    assert_eq!(wrong, 0);
    assert!((differ as f64) < TIES * raster.len() as f64, "{differ} of {}", raster.len());
}
