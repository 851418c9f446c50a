//! What every command takes that renders: which picture, how, and on what.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValuesParser, RangedU64ValueParser, TypedValueParser};

use crate::gpu::{Capabilities, Capability, DeviceRequest};
use crate::render::{MAX_SIDE, RenderSettings};
use crate::taa::{self, History, TaaSettings};
use crate::technique::{Setting, TechniqueKind};
use crate::trace::TraceChoice;

pub(super) const MOST_SAMPLES: i64 = 1_000_000;

// A doc comment here would become the description of every command that takes these.
#[derive(Debug, Clone, Args)]
pub struct PictureArgs {
    /// The scene file (.toml)
    pub scene: PathBuf,
    /// How caustic light is found; `none` leaves it out
    #[arg(long, value_name = "NAME", default_value = TechniqueKind::default().name())]
    #[arg(value_parser = named(technique_names(), TechniqueKind::parse))]
    pub technique: TechniqueKind,
    /// The camera of the scene to look through [default: the scene's first]
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,
    /// Width and height in pixels, each 1 to 16384, such as 640x480 [default: the scene's]
    #[arg(long, value_name = "WxH", allow_hyphen_values = true, value_parser = size)]
    pub size: Option<(u32, u32)>,
    /// Samples a pixel, 1 to 1000000 [default: the scene's]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=MOST_SAMPLES))]
    pub samples: Option<u32>,
    /// Spend the samples where pixels vary; --samples is then their mean number
    #[arg(long)]
    pub adaptive: bool,
    /// Equal seeds give equal bits on the same device
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    pub seed: u32,
    /// Write motion vectors too: how far what each pixel shows has moved since the frame before, an EXR layer
    #[arg(long)]
    pub motion: bool,
    /// Temporal anti-aliasing: the picture is made of the samples of N frames, 2 to 64, this one and those before it, each
    /// moved to where things are now; 8 where no N is given
    #[arg(long, value_name = "N", num_args = 0..=1, require_equals = true, default_missing_value = TAA_FRAMES)]
    #[arg(value_parser = taa_frames())]
    pub taa: Option<u32>,
    /// Index or part of the name of the device to use, see 'nephroid devices' [default: the most capable]
    #[arg(long, value_name = "DEVICE", env = "NEPHROID_DEVICE", hide_env_values = true)]
    pub device: Option<String>,
    /// How rays are traced: by the device, or through one of two trees; `auto` takes what it finds fastest
    #[arg(long, value_name = "HOW", default_value = TraceChoice::default().name())]
    #[arg(value_parser = named(TraceChoice::ALL.map(TraceChoice::name), str::parse::<TraceChoice>))]
    pub trace: TraceChoice,
    #[arg(long, value_name = "LIST", help = disable_help(), value_parser = Capabilities::parse)]
    pub disable: Option<Capabilities>,
    /// A setting of a technique; give it again for more, --help lists them all
    #[arg(long, value_name = "TECHNIQUE.KEY=VALUE")]
    pub set: Vec<String>,
    /// Write what the rendering took to a JSON file: device, times of passes, memory, energy ledger, warnings
    #[arg(long, value_name = "FILE")]
    pub stats: Option<PathBuf>,
    /// Write a timeline of host and device to a JSON file that Perfetto (ui.perfetto.dev) opens
    #[arg(long, value_name = "FILE")]
    pub trace_file: Option<PathBuf>,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
    /// Run under the Vulkan validation layers, and fail if they find something
    #[arg(long)]
    pub validation: bool,
}

impl PictureArgs {
    /// What the renderer has to know, for `frame` of the scene's animation.
    pub fn settings(&self, frame: u32) -> RenderSettings {
        RenderSettings {
            device: DeviceRequest {
                // A variable set to nothing counts as not set.
                device: self.device.clone().filter(|name| !name.is_empty()),
                disable: self.disable.clone().unwrap_or_default(),
                validation: self.validation,
            },
            trace: self.trace,
            technique: self.technique,
            camera: self.camera.clone(),
            size: self.size,
            samples: self.samples,
            adaptive: self.adaptive,
            seed: self.seed,
            frame,
            motion: self.motion,
            taa: self.taa.map(|frames| TaaSettings { frames, history: History::Numbered }),
            set: self.set.clone(),
        }
    }
}

/// Takes one of `names`, and `parse` makes a value of it; help, completions and errors list the names.
pub(super) fn named<T, E>(
    names: impl IntoIterator<Item = &'static str>,
    parse: fn(&str) -> Result<T, E>,
) -> impl TypedValueParser<Value = T>
where
    T: Clone + Send + Sync + 'static,
    E: std::error::Error + Send + Sync + 'static,
{
    PossibleValuesParser::new(names).try_map(move |name| parse(&name))
}

pub(super) fn technique_names() -> impl Iterator<Item = &'static str> {
    TechniqueKind::ALL.iter().map(|technique| technique.name())
}

pub(super) fn size(text: &str) -> Result<(u32, u32), String> {
    let (width, height) = text
        .split_once(['x', 'X'])
        .ok_or("wanted are width x height in pixels, such as 640x480, each from 1 to 16384")?;
    Ok((side("width", width)?, side("height", height)?))
}

fn side(name: &str, text: &str) -> Result<u32, String> {
    let pixels = text.parse().ok().filter(|pixels| (1..=MAX_SIDE).contains(pixels));
    pixels.ok_or_else(|| format!("the {name} is '{text}'; allowed are whole numbers from 1 to {MAX_SIDE}"))
}

/// [`taa::DEFAULT_FRAMES`] as it would be given.
pub(super) const TAA_FRAMES: &str = "8";

pub(super) fn taa_frames() -> RangedU64ValueParser<u32> {
    let allowed = u64::from(*taa::FRAMES.start())..=u64::from(*taa::FRAMES.end());
    RangedU64ValueParser::new().range(allowed)
}

pub(super) fn disable_help() -> String {
    let names = Capability::ALL.map(Capability::name).join(", ");
    format!("Do without capabilities of the device, separated by commas: {names}")
}

/// `examples`, and all settings of all techniques after them.
pub fn long_help(examples: &str) -> String {
    let mut help = examples.to_owned();
    for &technique in TechniqueKind::ALL {
        let (name, settings) = (technique.name(), technique.settings());
        if !settings.is_empty() {
            let _ = write!(help, "\n\nSettings of --technique {name}, with their defaults:");
            settings.iter().for_each(|setting| describe(&mut help, name, setting));
        }
    }
    help
}

fn describe(help: &mut String, technique: &str, setting: &Setting) {
    let Setting { key, kind, default, unit, help: meaning } = setting;
    let comma = if unit.is_empty() { "" } else { ", " };
    let _ = write!(help, "\n  --set {technique}.{key}={default}\n      {meaning} ({}{comma}{unit})", kind.allowed());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_of_anti_aliasing_are_the_default() {
        assert_eq!(TAA_FRAMES.parse(), Ok(taa::DEFAULT_FRAMES));
    }
}
