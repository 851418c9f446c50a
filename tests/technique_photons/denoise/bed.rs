//! Surfaces before a camera, and light on them, with no scene behind.

use glam::{Affine3A, DVec3, Vec3};
use nephroid::gpu::{Bindings, Buffer, Device, Recorder};
use nephroid::light_view::LightView;
use nephroid::random;
use nephroid::technique::photons::CameraTexel;
use nephroid::technique::photons::denoise::{DenoiseOptions, Denoiser, Receivers};

/// Texels along each side.
pub const SIDE: u32 = 32;
pub const TEXELS: usize = (SIDE * SIDE) as usize;
const NOTHING: u32 = u32::MAX;

/// The paper's, with a history that is a plain mean.
pub const OPTIONS: DenoiseOptions = DenoiseOptions {
    temporal: false,
    adaptive: false,
    alpha: 0.0,
    change: 2.5,
    levels: 5,
    sigma: 4.0,
    normals: 128.0,
    planes: 1.0,
};

/// History alone: no light is taken for another's.
pub const HISTORY: DenoiseOptions = DenoiseOptions { temporal: true, sigma: 0.0, levels: 1, ..OPTIONS };

/// A camera at `eye` that looks along -z, 90 degrees across.
pub fn view(eye: Vec3) -> LightView {
    let edge = 1.0 - 1.0 / SIDE as f32;
    LightView {
        origin: eye.to_array(),
        light: 0,
        right: [1.0, 0.0, 0.0],
        columns: SIDE,
        up: [0.0, -1.0, 0.0],
        rows: SIDE,
        forward: [0.0, 0.0, -1.0],
        first_texel: 0,
        lower: [-edge; 2],
        upper: [edge; 2],
        perspective: 1,
        reach: f32::MAX,
        padding0: 0,
        padding1: 0,
    }
}

/// The way through a texel's middle, with 1 along the view.
pub fn way(texel: usize) -> DVec3 {
    let at = |i: usize| 2.0 * (i as f64 + 0.5) / f64::from(SIDE) - 1.0;
    DVec3::new(at(texel % SIDE as usize), -at(texel / SIDE as usize), -1.0)
}

/// A plane of an instance seen at a depth.
pub fn texel(depth: f64, normal: DVec3, instance: u32) -> CameraTexel {
    let normal = pack_direction(normal.as_vec3());
    CameraTexel { depth: depth as f32, shading: normal, geometric: normal, instance }
}

pub fn wall(depth: f64, instance: u32) -> CameraTexel {
    texel(depth, DVec3::Z, instance)
}

/// As `pack_direction` of `kernels/shared/math.glsl`.
fn pack_direction(n: Vec3) -> u32 {
    let p = n.truncate() / n.abs().element_sum();
    let fold = |a: f32, b: f32| if n.z < 0.0 { (1.0 - b.abs()) * if a < 0.0 { -1.0 } else { 1.0 } } else { a };
    let bits = |v: f32| u32::from((v.clamp(-1.0, 1.0) * 32767.0).round() as i16 as u16);
    bits(fold(p.x, p.y)) | bits(fold(p.y, p.x)) << 16
}

/// Light that falls in grains, `grains` a texel on average, whose mean is `light`.
pub fn grains(seed: u32, light: impl Fn(usize) -> f64, grains: f64) -> Vec<f64> {
    let grain = |texel: usize| {
        let unit =
            |index: u32| f64::from(random::combine(random::combine(seed, texel as u32), index)) / 4_294_967_296.0;
        // Poisson by Knuth's product.
        let (mut count, mut product) = (0, unit(0));
        while product > (-grains).exp() && count < 64 {
            count += 1;
            product *= unit(count);
        }
        light(texel) * f64::from(count) / grains
    };
    (0..TEXELS).map(grain).collect()
}

/// A filter and what it filters on.
pub struct Bed {
    device: Device,
    denoiser: Option<Denoiser>,
    irradiance: Buffer,
}

impl Bed {
    pub fn new(device: &Device, options: DenoiseOptions, texels: &[CameraTexel]) -> Bed {
        let mut bed =
            Bed { device: device.clone(), denoiser: None, irradiance: Buffer::new(device, "none", 0).unwrap() };
        bed.place(Vec3::ZERO, texels, &[Affine3A::IDENTITY; 2], Some(options));
        bed
    }

    /// Goes on behind another camera, over other texels.
    pub fn go_on(&mut self, eye: Vec3, texels: &[CameraTexel], transforms: &[Affine3A]) {
        self.place(eye, texels, transforms, None);
    }

    fn place(&mut self, eye: Vec3, texels: &[CameraTexel], transforms: &[Affine3A], anew: Option<DenoiseOptions>) {
        let device = &self.device;
        let (view, texels) = (view(eye), Buffer::from_slice(device, "texels", texels).unwrap());
        self.irradiance = Buffer::zeroed(device, "irradiance", 16 * TEXELS as u64).unwrap();
        let bindings = Bindings::new()
            .buffer("LightViews", &Buffer::from_slice(device, "views", &[view]).unwrap())
            .buffer("CameraTexels", &texels)
            .buffer("CameraAreas", &Buffer::zeroed(device, "areas", 4 * TEXELS as u64).unwrap())
            .buffer("PhotonIrradiance", &self.irradiance);
        let transforms = transforms.to_vec();
        let irradiance = &self.irradiance;
        let receivers = Receivers { bindings: &bindings, texels: &texels, irradiance, camera: 0, view, transforms };
        self.denoiser = Some(match (anew, self.denoiser.take()) {
            (None, Some(before)) => before.follow(device, receivers).unwrap(),
            (options, _) => Denoiser::new(device, options.unwrap_or(OPTIONS), receivers).unwrap(),
        });
    }

    /// What is made of a set's light.
    pub fn filter(&mut self, light: &[f64]) -> Vec<f64> {
        // Channels apart, so that one taken for another is seen.
        let set: Vec<[f32; 4]> = light.iter().map(|&v| [v as f32, (2.0 * v) as f32, 0.0, 0.0]).collect();
        self.irradiance.upload(bytemuck::cast_slice(&set)).unwrap();
        let mut recorder = Recorder::new(&self.device).unwrap();
        self.denoiser.as_mut().unwrap().record(&mut recorder, &Bindings::new()).unwrap();
        recorder.submit().unwrap();
        let found: Vec<[f32; 4]> = self.irradiance.read(TEXELS).unwrap();
        for texel in &found {
            assert!((texel[1] - 2.0 * texel[0]).abs() <= 1e-5 * texel[1].abs() && texel[2] == 0.0, "{texel:?}");
        }
        found.into_iter().map(|texel| texel[0].into()).collect()
    }
}

pub fn nothing() -> CameraTexel {
    CameraTexel { depth: 0.0, shading: 0, geometric: 0, instance: NOTHING }
}

/// RMS of the differences, over a mean.
pub fn error(found: &[f64], truth: &[f64]) -> f64 {
    let squares: f64 = found.iter().zip(truth).map(|(a, b)| (a - b).powi(2)).sum();
    (squares / found.len() as f64).sqrt() / (truth.iter().sum::<f64>() / truth.len() as f64)
}
