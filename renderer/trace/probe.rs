//! Rays from the host and their hits, for tests, measurements and the choice of a back-end.

use std::time::Instant;

use super::Tracer;
use crate::gpu::{Bindings, Buffer, Device, GpuError, Kernel, Recorder};
use crate::gpu_scene::GpuScene;

crate::gpu_struct! {
    /// World space; `t_min` and `t_max` in units of `direction`.
    pub struct Ray {
        pub origin: [f32; 3],
        pub t_min: f32,
        pub direction: [f32; 3],
        pub t_max: f32,
    }
}

crate::gpu_struct! {
    /// `instance` is [`NO_INSTANCE`](super::NO_INSTANCE) where nothing was hit; `barycentrics` are the weights of the
    /// triangle's second and third vertex; `t` is in units of the ray's direction.
    pub struct ProbeHit {
        pub barycentrics: [f32; 2],
        pub t: f32,
        pub instance: u32,
        pub primitive: u32,
        pub padding0: u32,
    }
}

crate::gpu_struct! {
    pub struct ProbePush {
        pub count: u32,
        pub mask: u32,
        pub any_hit: u32,
    }
}

/// The kernel `trace/probe` with its rays and hits.
pub struct Probe {
    device: Device,
    kernel: Kernel,
    rays: Buffer,
    hits: Buffer,
    count: u32,
    bindings: Bindings,
}

impl Probe {
    /// Uploads `rays` and makes the kernel for the tracer's back-end.
    pub fn new(device: &Device, tracer: &Tracer, rays: &[Ray]) -> Result<Probe, GpuError> {
        let kernel = Kernel::new(device, "trace/probe", tracer.variant())?;
        let (hits_size, count) = (size_of_val(rays) / size_of::<Ray>() * size_of::<ProbeHit>(), rays.len() as u32);
        let rays = Buffer::from_slice(device, "probe rays", rays)?;
        let hits = Buffer::new(device, "probe hits", hits_size as u64)?;
        let bindings = Bindings::new().buffer("ProbeRays", &rays).buffer("ProbeHits", &hits);
        Ok(Probe { device: device.clone(), kernel, rays, hits, count, bindings })
    }

    /// Replaces the rays by as many others.
    pub fn set_rays(&self, rays: &[Ray]) -> Result<(), GpuError> {
        self.rays.upload(bytemuck::cast_slice(&rays[..rays.len().min(self.count as usize)]))
    }

    /// Traces all rays at instances that share a bit with `mask`; the result is the wall-clock time in seconds.
    pub fn run(&self, tracer: &Tracer, scene: &GpuScene, mask: u32, any_hit: bool) -> Result<f64, GpuError> {
        let push = ProbePush { count: self.count, mask, any_hit: u32::from(any_hit) };
        let mut recorder = Recorder::new(&self.device)?;
        let bindings = [&self.bindings, &tracer.bindings, &scene.bindings];
        recorder.pass("trace/probe")?.dispatch(&self.kernel, &bindings, &push, self.count)?;
        let started = Instant::now();
        recorder.submit()?;
        Ok(started.elapsed().as_secs_f64())
    }

    /// The hits of the last run, one a ray.
    pub fn hits(&self) -> Result<Vec<ProbeHit>, GpuError> {
        self.hits.read(self.count as usize)
    }
}
