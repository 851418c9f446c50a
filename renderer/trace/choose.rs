//! The choice of a back-end, by measurement where the user leaves it open.

use glam::Vec3;

use super::{Backend, Probe, Ray, TraceError, Tracer};
use crate::gpu::Device;
use crate::gpu_scene::GpuScene;
use crate::scene::Scene;

/// Rays of one measurement: some milliseconds on a GPU, a tenth of a second on two CPU cores.
const RAYS: u32 = 1 << 15;

/// How much faster than the wide BVH ray queries must be. Hardware that has them is faster by more; where the two are
/// close, noise must not decide, since equal seeds give equal bits only on one back-end.
pub const MARGIN: f64 = 1.5;

/// Rounds after the first, which compiles and warms up; the fastest counts.
const ROUNDS: u32 = 3;

/// Instances of any kind.
const ANY_MASK: u32 = 0xff;

/// What the user asked for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum TraceChoice {
    /// Whatever a short measurement finds fastest.
    #[default]
    Auto,
    RayQuery,
    /// The back-end that is fastest in compute.
    Bvh,
    Bvh2,
    Cwbvh,
}

impl TraceChoice {
    pub const ALL: [TraceChoice; 5] =
        [TraceChoice::Auto, TraceChoice::RayQuery, TraceChoice::Bvh, TraceChoice::Bvh2, TraceChoice::Cwbvh];

    /// The command-line value.
    pub fn name(self) -> &'static str {
        match self {
            TraceChoice::Auto => "auto",
            TraceChoice::RayQuery => "ray-query",
            TraceChoice::Bvh => "bvh",
            TraceChoice::Bvh2 => "bvh2",
            TraceChoice::Cwbvh => "cwbvh",
        }
    }
}

impl std::str::FromStr for TraceChoice {
    type Err = TraceError;

    fn from_str(name: &str) -> Result<Self, TraceError> {
        Self::ALL.into_iter().find(|choice| choice.name() == name).ok_or_else(|| TraceError::UnknownChoice {
            found: name.to_string(),
            allowed: Self::ALL.map(Self::name).join(", "),
        })
    }
}

/// Speed of one back-end on the scene at hand, millions of rays a second of wall-clock time.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Measurement {
    pub backend: Backend,
    pub closest: f64,
    pub occlusion: f64,
}

impl Measurement {
    /// Millions of rays a second where half of them ask for the closest hit and half for any.
    pub fn mixed(&self) -> f64 {
        2.0 / (1.0 / self.closest + 1.0 / self.occlusion)
    }
}

/// Which back-end is used, and why.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Choice {
    pub backend: Backend,
    /// Empty where there was nothing to choose.
    pub measured: Vec<Measurement>,
    /// A sentence for the user.
    pub reason: String,
}

/// Builds the tracer that the user asked for, or the one that is measured to be fastest on this scene and device.
pub fn choose(
    device: &Device,
    scene: &Scene,
    gpu_scene: &GpuScene,
    choice: TraceChoice,
) -> Result<(Tracer, Choice), TraceError> {
    let backend = match choice {
        TraceChoice::Auto if Backend::RayQuery.available(device) => return measure(device, scene, gpu_scene),
        TraceChoice::RayQuery => Backend::RayQuery,
        TraceChoice::Bvh2 => Backend::Bvh2,
        TraceChoice::Auto | TraceChoice::Bvh | TraceChoice::Cwbvh => Backend::Cwbvh,
    };
    let reason = match choice {
        TraceChoice::Auto => format!("Rays are traced by {}: the device has no ray queries in use.", backend.name()),
        _ => format!("Rays are traced by {}, as asked.", backend.name()),
    };
    let tracer = Tracer::new(device, scene, gpu_scene, backend)?;
    Ok((tracer, Choice { backend, measured: Vec::new(), reason }))
}

/// The binary tree is left out: it was slower than the wide one on every device so far.
fn measure(device: &Device, scene: &Scene, gpu_scene: &GpuScene) -> Result<(Tracer, Choice), TraceError> {
    let rays = rays(gpu_scene);
    let mut best: Option<(Tracer, Measurement)> = None;
    let mut measured = Vec::new();
    for backend in [Backend::Cwbvh, Backend::RayQuery] {
        let tracer = match Tracer::new(device, scene, gpu_scene, backend) {
            Ok(tracer) => tracer,
            // One back-end is enough; the other may want more memory than there is.
            Err(error) if best.is_some() => {
                device.warn(format!("{} is left out: {error}", backend.name()));
                continue;
            }
            Err(error) => return Err(error),
        };
        let probe = Probe::new(device, &tracer, &rays)?;
        let speed = |any_hit| -> Result<f64, TraceError> {
            probe.run(&tracer, gpu_scene, ANY_MASK, any_hit)?;
            let mut seconds = f64::INFINITY;
            for _ in 0..ROUNDS {
                seconds = seconds.min(probe.run(&tracer, gpu_scene, ANY_MASK, any_hit)?);
            }
            Ok(f64::from(RAYS) / seconds.max(1e-9) * 1e-6)
        };
        let measurement = Measurement { backend, closest: speed(false)?, occlusion: speed(true)? };
        if best.as_ref().is_none_or(|(_, b)| measurement.mixed() > MARGIN * b.mixed()) {
            best = Some((tracer, measurement.clone()));
        }
        measured.push(measurement);
    }
    let (tracer, fastest) = best.ok_or_else(|| TraceError::NoRayQuery { device: device.info.name.clone() })?;
    let speeds: Vec<_> = measured.iter().map(|m| format!("{} {:.2}", m.backend.name(), m.mixed())).collect();
    let reason = format!(
        "Rays are traced by {}, the fastest here ({} million rays a second).",
        fastest.backend.name(),
        speeds.join(", ")
    );
    let choice = Choice { backend: fastest.backend, measured, reason };
    Ok((tracer, choice))
}

/// From a sphere around the scene to points inside its box, the same for every back-end.
fn rays(scene: &GpuScene) -> Vec<Ray> {
    let bounds = &scene.bounds;
    let centre = 0.5 * (bounds.min + bounds.max);
    let radius = 0.75 * bounds.diagonal();
    (0..RAYS)
        .map(|i| {
            // Neighbours stay neighbours, as pixels do: a spiral from pole to pole.
            let height = 1.0 - 2.0 * (i as f32 + 0.5) / RAYS as f32;
            let (sin, cos) = (i as f32 * 0.01).sin_cos();
            let across = (1.0 - height * height).sqrt();
            let origin = centre + radius * Vec3::new(across * cos, height, across * sin);
            let unit = Vec3::new(fraction(i, 0.754_877_7), fraction(i, 0.569_840_3), fraction(i, 0.362_069_3));
            let target = centre + 0.25 * (unit - 0.5) * (bounds.max - bounds.min);
            Ray { origin: origin.to_array(), t_min: 0.0, direction: (target - origin).to_array(), t_max: f32::INFINITY }
        })
        .collect()
}

fn fraction(i: u32, step: f64) -> f32 {
    (f64::from(i) * step).fract() as f32
}
