//! What the tests of the tracer share beside [`nephroid::conformance::rays`].
#![allow(dead_code, unused_imports, reason = "each test binary uses its part")]

use nephroid::gpu::Device;
use nephroid::gpu_scene::GpuScene;
use nephroid::scene::Scene;
use nephroid::trace::{Backend, Probe, ProbeHit, Ray, Tracer};

pub use nephroid::conformance::rays::{ANY_MASK, Oracle, Random, is_hit, mesh, random_rays, ray, scene, soup, water};

/// The back-ends that the device has, each with the scene built.
pub fn tracers(device: &Device, scene: &Scene, gpu_scene: &GpuScene) -> Vec<Tracer> {
    let available = Backend::ALL.into_iter().filter(|backend| {
        let available = backend.available(device);
        if !available {
            println!("skipped on {}: {}, which the device lacks", device.info.name, backend.name());
        }
        available
    });
    available.map(|backend| Tracer::new(device, scene, gpu_scene, backend).unwrap()).collect()
}

pub fn hits(
    device: &Device,
    gpu_scene: &GpuScene,
    tracer: &Tracer,
    rays: &[Ray],
    mask: u32,
    any_hit: bool,
) -> Vec<ProbeHit> {
    let probe = Probe::new(device, tracer, rays).unwrap();
    probe.run(tracer, gpu_scene, mask, any_hit).unwrap();
    probe.hits().unwrap()
}
