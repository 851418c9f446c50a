//! Techniques: each adds caustic light to the film, nothing else.

pub mod beams;
pub mod eikonal;
pub mod emission;
pub mod mnee;
pub mod photons;
pub mod reference;
mod settings;

pub use settings::{Setting, SettingKind, Settings};

use crate::frame::Frame;
use crate::gpu::{Device, GpuError, Recorder};
use crate::scene::Scene;
use crate::trace::Tracer;

/// The techniques by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TechniqueKind {
    /// No caustic light at all.
    None,
    /// Stochastic progressive photon mapping: what the others are held against.
    #[default]
    Reference,
    /// Manifold next-event estimation along the coplanarity curve: light refracted once, without noise.
    Mnee,
    /// Adaptive beam tracing: light between neighbouring rays, in volumes and on surfaces.
    Beams,
    /// Cascaded image-space photon tracing: light followed over what lights and the camera see, without rays.
    Photons,
    /// Wave fronts in a grid: optical paths and light behind a refracting surface, looked up by what it falls on.
    Eikonal,
}

impl TechniqueKind {
    pub const ALL: &'static [TechniqueKind] = &[
        TechniqueKind::None,
        TechniqueKind::Reference,
        TechniqueKind::Mnee,
        TechniqueKind::Beams,
        TechniqueKind::Photons,
        TechniqueKind::Eikonal,
    ];

    /// The name of the Rust file, the kernel folder, the command-line value and the GPU label.
    pub fn name(self) -> &'static str {
        match self {
            TechniqueKind::None => "none",
            TechniqueKind::Reference => "reference",
            TechniqueKind::Mnee => "mnee",
            TechniqueKind::Beams => "beams",
            TechniqueKind::Photons => "photons",
            TechniqueKind::Eikonal => "eikonal",
        }
    }

    pub fn parse(name: &str) -> Result<Self, TechniqueError> {
        Self::ALL.iter().copied().find(|kind| kind.name() == name).ok_or_else(|| TechniqueError::Unknown {
            found: name.to_string(),
            allowed: Self::ALL.iter().map(|k| k.name()).collect::<Vec<_>>().join(", "),
        })
    }

    /// Whether it finds the light at each sample's visible points from that sample alone and calls
    /// [`Frame::record_caustic`]: what adaptive sampling needs.
    pub fn per_sample(self, settings: &Settings) -> bool {
        match self {
            TechniqueKind::None | TechniqueKind::Reference => false,
            TechniqueKind::Mnee => settings.choice("rest") == "off",
            TechniqueKind::Beams | TechniqueKind::Eikonal => true,
            TechniqueKind::Photons => settings.choice("denoise") != photons::DENOISE_TEMPORAL,
        }
    }

    /// What `--set` can tell it.
    pub fn settings(self) -> &'static [Setting] {
        match self {
            TechniqueKind::None => &[],
            TechniqueKind::Reference => reference::SETTINGS,
            TechniqueKind::Mnee => mnee::SETTINGS,
            TechniqueKind::Beams => beams::SETTINGS,
            TechniqueKind::Photons => photons::SETTINGS,
            TechniqueKind::Eikonal => eikonal::SETTINGS,
        }
    }
}

/// What is wrong with the choice of a technique or its settings.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum TechniqueError {
    #[error("there is no technique \"{found}\"; allowed are: {allowed}")]
    Unknown { found: String, allowed: String },
    #[error("\"{found}\" is not of the form technique.key=value, such as reference.photons=1000000")]
    MalformedSetting { found: String },
    #[error("the setting \"{item}\" is for another technique than {technique}, which is the one in use")]
    OtherTechnique { item: String, technique: &'static str },
    #[error("the technique {technique} has no setting \"{found}\"; it has: {allowed}")]
    UnknownSetting { technique: &'static str, found: String, allowed: String },
    #[error("{setting} is \"{found}\"; allowed is {allowed}")]
    SettingValue { setting: String, found: String, allowed: String },
}

/// What a technique is made from.
pub struct Context<'a> {
    pub device: &'a Device,
    pub scene: &'a Scene,
    pub tracer: &'a Tracer,
    pub frame: &'a Frame,
    pub seed: u32,
}

/// Where the light went, in W of the mean channel, averaged over the sets of photons.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct LedgerEntry {
    pub name: &'static str,
    pub watts: f64,
}

/// How often something happened, or a mean of such numbers.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct CounterEntry {
    pub name: &'static str,
    pub value: f64,
}

/// What kernels counted in two words each, the low one first.
fn double_words(words: &[u32]) -> impl Iterator<Item = f64> {
    words.chunks_exact(2).map(|pair| f64::from(pair[1]) * 4_294_967_296.0 + f64::from(pair[0]))
}

/// Adds caustic light to a frame's film.
pub trait Technique {
    /// Starts over with no samples, after `context.frame` has. The scene's vertices, transforms, lights and the camera
    /// may be others; its meshes have the triangles they had, and there are as many lights and pixels.
    fn restart(&mut self, context: &Context<'_>) -> Result<(), GpuError>;

    /// Records what belongs to sample `index`, after the frame's own passes: afterwards the film's caustic layers
    /// hold the technique's estimate from all samples up to this one.
    fn record(&mut self, frame: &Frame, recorder: &mut Recorder, index: u32) -> Result<(), GpuError>;

    /// Where the light went so far; `emitted` first, then what it divides into. W, averaged over the samples.
    fn ledger(&self, samples: u32) -> Result<Vec<LedgerEntry>, GpuError>;

    /// What the technique counted, over all samples so far.
    fn counters(&self) -> Result<Vec<CounterEntry>, GpuError> {
        Ok(Vec::new())
    }

    /// How many of the first `samples` samples belong to the half that the film's irradiance keeps apart, for an
    /// estimate of the noise. `None` where it keeps none.
    fn second_half(&self, _samples: u32) -> Option<u32> {
        None
    }

    /// Things that went wrong without stopping the picture, a sentence each.
    fn warnings(&self) -> Result<Vec<String>, GpuError> {
        Ok(Vec::new())
    }
}

/// Why a technique could not be made.
#[derive(Debug, thiserror::Error)]
pub enum CreateError {
    #[error(transparent)]
    Gpu(#[from] GpuError),
    #[error(transparent)]
    Volumes(#[from] eikonal::file::VolumeFileError),
}

/// The one place where a technique is made from its name.
pub fn create(
    kind: TechniqueKind,
    settings: &Settings,
    context: &Context<'_>,
) -> Result<Option<Box<dyn Technique>>, CreateError> {
    match kind {
        TechniqueKind::None => Ok(None),
        TechniqueKind::Reference => Ok(Some(Box::new(reference::Reference::new(settings, context)?))),
        TechniqueKind::Mnee => Ok(Some(Box::new(mnee::Mnee::new(settings, context)?))),
        TechniqueKind::Beams => Ok(Some(Box::new(beams::Beams::new(settings, context)?))),
        TechniqueKind::Photons => Ok(Some(Box::new(photons::Photons::new(settings, context)?))),
        TechniqueKind::Eikonal => Ok(Some(Box::new(eikonal::Eikonal::new(settings, context)?))),
    }
}
