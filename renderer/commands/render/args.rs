//! What `nephroid render` takes, and its help.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use crate::gpu::{Capabilities, Capability, DeviceRequest};
use crate::render::{MAX_SIDE, RenderSettings};
use crate::technique::{Setting, TechniqueKind};
use crate::trace::TraceChoice;

const MOST_SAMPLES: i64 = 1_000_000;

const EXAMPLES: &str = "\
Examples:
  A picture to look at, and all layers in linear light to measure:
    nephroid render scenes/pool.toml --technique reference -o pool.png -o pool.exr
  A quick look through another camera:
    nephroid render scenes/pool.toml --camera under --size 320x240 --samples 4 -o under.png
  On the second device of 'nephroid devices', as if it could not trace rays itself:
    nephroid render scenes/cup.toml --device 1 --disable ray-query -o cup.png

Ctrl-C ends a rendering after the current sample and writes the picture as it is then; a second one ends it at once.";

/// Render a scene to picture files
#[derive(Debug, Clone, Args)]
#[command(after_help = EXAMPLES, after_long_help = long_help())]
pub struct RenderArgs {
    /// The scene file (.toml)
    pub scene: PathBuf,
    /// A file to write; give it again for more: .exr holds all layers in linear light, .png the picture for display
    #[arg(short, long, value_name = "FILE", required = true)]
    pub output: Vec<PathBuf>,
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
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=MOST_SAMPLES))]
    pub samples: Option<u32>,
    /// Spend the samples where pixels vary; --samples is then their mean number
    #[arg(long)]
    pub adaptive: bool,
    /// Equal seeds give equal bits on the same device
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    pub seed: u32,
    /// The frame of the scene's animation to render
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    pub frame: u32,
    /// Write motion vectors too: how far what each pixel shows has moved since the frame before, an EXR layer
    #[arg(long)]
    pub motion: bool,
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
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
    /// Run under the Vulkan validation layers, and fail if they find something
    #[arg(long)]
    pub validation: bool,
    /// Start over with the changed kernels whenever a GLSL file in FOLDER changes [default: where they were built from]
    #[cfg(feature = "hot-reload")]
    #[arg(long, value_name = "FOLDER", num_args = 0..=1, require_equals = true)]
    pub watch_kernels: Option<Option<PathBuf>>,
}

impl RenderArgs {
    /// What the renderer has to know.
    pub fn settings(&self) -> RenderSettings {
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
            frame: self.frame,
            motion: self.motion,
            set: self.set.clone(),
        }
    }
}

/// Takes one of `names`, and `parse` makes a value of it; help, completions and errors list the names.
fn named<T, E>(
    names: impl IntoIterator<Item = &'static str>,
    parse: fn(&str) -> Result<T, E>,
) -> impl TypedValueParser<Value = T>
where
    T: Clone + Send + Sync + 'static,
    E: std::error::Error + Send + Sync + 'static,
{
    PossibleValuesParser::new(names).try_map(move |name| parse(&name))
}

fn technique_names() -> impl Iterator<Item = &'static str> {
    TechniqueKind::ALL.iter().map(|technique| technique.name())
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let (width, height) = text
        .split_once(['x', 'X'])
        .ok_or("wanted are width x height in pixels, such as 640x480, each from 1 to 16384")?;
    Ok((side("width", width)?, side("height", height)?))
}

fn side(name: &str, text: &str) -> Result<u32, String> {
    let pixels = text.parse().ok().filter(|pixels| (1..=MAX_SIDE).contains(pixels));
    pixels.ok_or_else(|| format!("the {name} is '{text}'; allowed are whole numbers from 1 to {MAX_SIDE}"))
}

fn disable_help() -> String {
    let names = Capability::ALL.map(Capability::name).join(", ");
    format!("Do without capabilities of the device, separated by commas: {names}")
}

fn long_help() -> String {
    let mut help = EXAMPLES.to_owned();
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
