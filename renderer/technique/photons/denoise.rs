//! Spatiotemporal variance-guided filtering (Schied et al. 2017) of the irradiance on the camera's texels, which nature
//! has demodulated: no albedo is in it.
//!
//! Where it departs from the paper, and why:
//!
//! - The wavelet's stops are the same from both sides, and what a texel gains its neighbour loses: flux is kept to rounding.
//!   The paper divides by the sum of weights, which gives light away at edges.
//! - The variance is that of the mean over the history (a set's, times the sum of squares of the sets' shares), not of one
//!   set: as a history grows, less is filtered.
//! - What is kept as history is unfiltered, so that blur does not add up from set to set.
//! - A history can adapt (`photons.history=adaptive`), as A-SVGF's (Schied, Peters and Dachsbacher 2018) by a gradient:
//!   means over 3 x 3 and 7 x 7 texels of the set and of its history are compared. By how many standard deviations they
//!   differ, over `change`, less 1, twice, is the part of the history that is forgotten.
//! - The stop for luminance compares means over 3 x 3 texels: where photons are fewer than texels, a single one stands many
//!   deviations above its neighbours.
//!
//! With a history, samples of a still picture are sets that follow each other, and the film is the mean of what each of
//! them showed. The first sets are in all of these, so that the mean of n samples from nothing has up to twice the
//! variance of the plain mean of their sets; the light is the same, since all shares add up to one. Light that only the
//! table of cubes holds is not filtered.

use glam::{Affine3A, DAffine3, DMat3, Vec3};

use super::settings::{DENOISE_OFF, DENOISE_TEMPORAL};
use crate::gpu::{Bindings, Buffer, Device, GpuError, Kernel, Recorder};
use crate::light_view::LightView;
use crate::technique::Settings;

crate::gpu_struct! {
    /// What all kernels of the filter are told; see `kernels/technique/photons/denoise.glsl`.
    pub struct DenoisePush {
        pub camera: u32,
        pub stride: u32,
        pub still: u32,
        pub temporal: u32,
        pub adaptive: u32,
        pub alpha: f32,
        pub change: f32,
        pub sigma: f32,
        pub normals: f32,
        pub planes: f32,
        pub padding0: u32,
        pub padding1: u32,
    }
}

/// Bytes of a texel's light, moments or texel.
const TEXEL_BYTES: u64 = 16;

/// How much is filtered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DenoiseOptions {
    /// Whether sets are accumulated at all.
    pub temporal: bool,
    /// Whether the history is shortened where light changes.
    pub adaptive: bool,
    /// Least share of a new set.
    pub alpha: f32,
    /// Standard deviations by which light may differ from its history.
    pub change: f32,
    /// Levels of the wavelet.
    pub levels: u32,
    /// Standard deviations of luminance.
    pub sigma: f32,
    /// Power of the normals' cosine.
    pub normals: f32,
    /// Texels' widths that a place may be off another's plane.
    pub planes: f32,
}

impl DenoiseOptions {
    /// None where nothing is filtered.
    pub fn of(settings: &Settings) -> Option<Self> {
        let mode = settings.choice("denoise");
        (mode != DENOISE_OFF).then(|| DenoiseOptions {
            temporal: mode == DENOISE_TEMPORAL,
            adaptive: settings.choice("history") == "adaptive",
            alpha: settings.number("alpha"),
            change: settings.number("change"),
            levels: settings.integer("levels"),
            sigma: settings.number("sigma"),
            normals: settings.number("normals"),
            planes: settings.number("planes"),
        })
    }
}

/// The camera's texels that irradiance is filtered on.
pub struct Receivers<'a> {
    /// The blocks `LightViews` (the camera's the last), `CameraTexels`, `CameraAreas` and `PhotonIrradiance`.
    pub bindings: &'a Bindings,
    pub texels: &'a Buffer,
    pub irradiance: &'a Buffer,
    /// Index of the camera's view, and the view.
    pub camera: u32,
    pub view: LightView,
    /// Of all instances, to world space.
    pub transforms: Vec<Affine3A>,
}

/// What the camera saw, and where things were.
struct Seen {
    texels: Buffer,
    view: LightView,
    transforms: Vec<Affine3A>,
}

/// The filter and its history.
pub struct Denoiser {
    options: DenoiseOptions,
    reproject: Kernel,
    accumulate: Kernel,
    guide: Kernel,
    wavelet: Kernel,
    /// What is kept from restart to restart, and all that is bound.
    own: Bindings,
    bindings: Bindings,
    /// Light and variance, from level to level.
    filtered: [Buffer; 2],
    irradiance: Buffer,
    camera: u32,
    now: Seen,
    /// What the history lies on where that is not what the camera sees now, kept from restart to restart until a set is
    /// recorded.
    before: Option<Seen>,
    sets: u32,
}

impl Denoiser {
    /// With no history.
    pub fn new(device: &Device, options: DenoiseOptions, receivers: Receivers<'_>) -> Result<Self, GpuError> {
        let texels = u64::from(receivers.view.columns) * u64::from(receivers.view.rows);
        let kept = if options.temporal { TEXEL_BYTES * texels } else { 0 };
        let filtered = |name| Buffer::new(device, name, TEXEL_BYTES * texels);
        let filtered = [filtered("photons filtered, even")?, filtered("photons filtered, odd")?];
        let own = Bindings::new()
            .buffer("PhotonHistory", &Buffer::zeroed(device, "photons history", kept)?)
            .buffer("PhotonMoments", &Buffer::zeroed(device, "photons moments", kept)?)
            .buffer("FollowedHistory", &Buffer::new(device, "photons history followed", kept)?)
            .buffer("FollowedMoments", &Buffer::new(device, "photons moments followed", kept)?)
            .buffer("FilterGuides", &Buffer::new(device, "photons guides", 8 * texels)?);
        Ok(Denoiser {
            options,
            reproject: Kernel::new(device, "photons/reproject", "")?,
            accumulate: Kernel::new(device, "photons/accumulate", "")?,
            guide: Kernel::new(device, "photons/guide", "")?,
            wavelet: Kernel::new(device, "photons/wavelet", "")?,
            bindings: with_way_back(device, &own, &receivers, None)?,
            own,
            filtered,
            irradiance: receivers.irradiance.clone(),
            camera: receivers.camera,
            now: Seen::of(receivers),
            before: None,
            sets: 0,
        })
    }

    /// Goes on where the camera, the scene or the lights have changed: the history is followed there. It begins anew where
    /// the camera's view has another size or there are other instances.
    pub fn follow(self, device: &Device, receivers: Receivers<'_>) -> Result<Self, GpuError> {
        let size = |view: &LightView| (view.columns, view.rows);
        let before = self.before.unwrap_or(self.now);
        if !self.options.temporal
            || size(&before.view) != size(&receivers.view)
            || before.transforms.len() != receivers.transforms.len()
        {
            return Denoiser::new(device, self.options, receivers);
        }
        Ok(Denoiser {
            bindings: with_way_back(device, &self.own, &receivers, Some(&before))?,
            irradiance: receivers.irradiance.clone(),
            camera: receivers.camera,
            now: Seen::of(receivers),
            before: Some(before),
            ..self
        })
    }

    /// Sets that have gone into the history, or would have: the number of the next one, so that those of successive
    /// frames differ.
    pub fn sets(&self) -> u32 {
        self.sets
    }

    /// Records how the irradiance of a set becomes the filtered one, in its place.
    pub fn record(&mut self, recorder: &mut Recorder, scene: &Bindings) -> Result<(), GpuError> {
        let texels = self.now.view.columns * self.now.view.rows;
        let options = self.options;
        let push = DenoisePush {
            camera: self.camera,
            stride: 1,
            still: u32::from(self.before.is_none()),
            temporal: u32::from(options.temporal),
            adaptive: u32::from(options.adaptive && options.temporal),
            alpha: if options.temporal { options.alpha } else { 1.0 },
            change: options.change,
            sigma: options.sigma,
            normals: options.normals,
            planes: options.planes,
            padding0: 0,
            padding1: 0,
        };
        if options.temporal {
            recorder.pass("photons/reproject")?.dispatch(&self.reproject, &[scene, &self.bindings], &push, texels)?;
        }
        let to = self.bindings.clone().buffer("FilterTo", &self.filtered[0]);
        recorder.pass("photons/accumulate")?.dispatch(&self.accumulate, &[scene, &to], &push, texels)?;
        for level in 0..options.levels {
            let last = level + 1 == options.levels;
            let to = if last { &self.irradiance } else { &self.filtered[(level as usize + 1) % 2] };
            let from = &self.filtered[level as usize % 2];
            let bindings = self.bindings.clone().buffer("FilterFrom", from).buffer("FilterTo", to);
            let push = DenoisePush { stride: 1 << level, ..push };
            recorder.pass("photons/guide")?.dispatch(&self.guide, &[scene, &bindings], &push, texels)?;
            recorder.pass("photons/wavelet")?.dispatch(&self.wavelet, &[scene, &bindings], &push, texels)?;
        }
        self.before = None;
        self.sets = self.sets.wrapping_add(1);
        Ok(())
    }
}

impl Seen {
    fn of(receivers: Receivers<'_>) -> Self {
        Seen { texels: receivers.texels.clone(), view: receivers.view, transforms: receivers.transforms }
    }
}

/// `own`, what is filtered, and what the history lies on: `before`, or where everything is.
fn with_way_back(
    device: &Device,
    own: &Bindings,
    receivers: &Receivers<'_>,
    before: Option<&Seen>,
) -> Result<Bindings, GpuError> {
    let (texels, view) = before.map_or((receivers.texels, receivers.view), |seen| (&seen.texels, seen.view));
    let transforms = before.map_or(&receivers.transforms, |seen| &seen.transforms);
    let ways: Vec<[f32; 4]> =
        receivers.transforms.iter().zip(transforms).flat_map(|(now, then)| way_back(now, then)).collect();
    Ok(own
        .clone()
        .and(receivers.bindings)
        .buffer("TexelsBefore", texels)
        .buffer("ViewBefore", &Buffer::from_slice(device, "photons view before", &[view])?)
        .buffer("WaysBack", &Buffer::from_slice(device, "photons ways back", &ways)?))
}

/// Rows of the map from where a point of an instance is to where it was; the identity, exactly, where it stands still.
fn way_back(now: &Affine3A, then: &Affine3A) -> [[f32; 4]; 3] {
    let wide = |t: &Affine3A| {
        let columns = [t.matrix3.x_axis, t.matrix3.y_axis, t.matrix3.z_axis].map(|c| Vec3::from(c).as_dvec3());
        let matrix = DMat3::from_cols(columns[0], columns[1], columns[2]);
        DAffine3 { matrix3: matrix, translation: Vec3::from(t.translation).as_dvec3() }
    };
    let map = if now == then { DAffine3::IDENTITY } else { wide(then) * wide(now).inverse() };
    let row = |i: usize| {
        let across = map.matrix3.row(i);
        [across.x as f32, across.y as f32, across.z as f32, map.translation[i] as f32]
    };
    [row(0), row(1), row(2)]
}
