//! `nephroid view`: a scene in a window.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use super::args::{self, MOST_SAMPLES};
use super::interrupt;
use crate::gpu::{Capabilities, DeviceRequest};
use crate::render::RenderSettings;
use crate::taa::{History, TaaSettings};
use crate::technique::TechniqueKind;
use crate::trace::TraceChoice;
use crate::viewer::{self, Closed, ViewError, ViewSettings};

const EXAMPLES: &str = "\
Examples:
    nephroid view scenes/pool.toml
    nephroid view scenes/pool.toml --technique mnee --camera above --size 320x240
    nephroid view scenes/pool.toml --technique mnee --truth truth.exr

F1 in the window lists its keys.";

/// Open a scene in a window to play with
#[derive(Debug, Clone, Args)]
#[command(after_help = EXAMPLES)]
pub struct ViewArgs {
    /// The scene file (.toml)
    pub scene: PathBuf,
    /// How caustic light is found; `none` leaves it out
    #[arg(long, value_name = "NAME", default_value = TechniqueKind::default().name())]
    #[arg(value_parser = args::named(args::technique_names(), TechniqueKind::parse))]
    pub technique: TechniqueKind,
    /// The camera of the scene to look through first [default: the scene's first]
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,
    /// Width and height of the picture in pixels, such as 640x480 [default: the truth's, or the scene's]
    #[arg(long, value_name = "WxH", allow_hyphen_values = true, value_parser = args::size)]
    pub size: Option<(u32, u32)>,
    /// Samples a pixel after which the picture is left as it is, 1 to 1000000
    #[arg(long, value_name = "N", default_value_t = 4096, allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=MOST_SAMPLES))]
    pub samples: u32,
    /// Equal seeds give equal bits on the same device
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    pub seed: u32,
    /// The frame of the scene's animation to begin with
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    pub frame: u32,
    /// Temporal anti-aliasing: while things move, the picture is made of N pictures, 2 to 64, this one and those shown
    /// before it, each moved to where things are now; 8 where no N is given
    #[arg(long, value_name = "N", num_args = 0..=1, require_equals = true, default_missing_value = args::TAA_FRAMES)]
    #[arg(value_parser = args::taa_frames())]
    pub taa: Option<u32>,
    /// Index or part of the name of the device to use [default: the most capable that can show a window]
    #[arg(long, value_name = "DEVICE", env = "NEPHROID_DEVICE", hide_env_values = true)]
    pub device: Option<String>,
    /// How rays are traced: by the device, or through one of two trees; `auto` takes what it finds fastest
    #[arg(long, value_name = "HOW", default_value = TraceChoice::default().name())]
    #[arg(value_parser = args::named(TraceChoice::ALL.map(TraceChoice::name), str::parse::<TraceChoice>))]
    pub trace: TraceChoice,
    #[arg(long, value_name = "LIST", help = args::disable_help(), value_parser = Capabilities::parse)]
    pub disable: Option<Capabilities>,
    /// A setting of the technique; give it again for more, 'nephroid render --help' lists them all
    #[arg(long, value_name = "TECHNIQUE.KEY=VALUE")]
    pub set: Vec<String>,
    /// A picture (.exr or .png) that errors are measured against
    #[arg(long, value_name = "FILE")]
    pub truth: Option<PathBuf>,
    #[arg(long, value_name = "FILE", long_help = script_help())]
    #[arg(help = "Let the window go through the steps of a file by itself")]
    pub script: Option<PathBuf>,
    /// Run under the Vulkan validation layers, and fail if they find something
    #[arg(long)]
    pub validation: bool,
    /// Swap in every kernel whose GLSL file in FOLDER changes [default: where they were built from]
    #[cfg(feature = "hot-reload")]
    #[arg(long, value_name = "FOLDER", num_args = 0..=1, require_equals = true)]
    pub watch_kernels: Option<Option<PathBuf>>,
}

fn script_help() -> String {
    format!("Let the window go through the steps of a file by itself. {}", viewer::SCRIPT_HELP)
}

/// Opens the window, and returns when it is closed: 0, or 130 where Ctrl-C closed it.
///
/// # Errors
/// Those of [`viewer::run`].
pub fn run(args: &ViewArgs) -> Result<ExitCode, ViewError> {
    let settings = ViewSettings {
        scene: args.scene.clone(),
        render: RenderSettings {
            device: DeviceRequest {
                // A variable set to nothing counts as not set.
                device: args.device.clone().filter(|name| !name.is_empty()),
                disable: args.disable.clone().unwrap_or_default(),
                validation: args.validation,
            },
            trace: args.trace,
            technique: args.technique,
            camera: args.camera.clone(),
            size: args.size,
            samples: None,
            adaptive: false,
            seed: args.seed,
            frame: args.frame,
            motion: false,
            taa: args.taa.map(|frames| TaaSettings { frames, history: History::Shown }),
            set: args.set.clone(),
        },
        samples: args.samples,
        truth: args.truth.clone(),
        script: args.script.clone(),
        #[cfg(feature = "hot-reload")]
        watch: args
            .watch_kernels
            .clone()
            .map(|folder| folder.unwrap_or_else(|| nephroid_kernels::source_folder().to_owned())),
    };
    Ok(match viewer::run(&settings)? {
        Closed::ByUser => ExitCode::SUCCESS,
        Closed::ByCtrlC => ExitCode::from(interrupt::STATUS),
    })
}
