//! `nephroid volume`: caustic volumes into a file, for programs that only look them up.

use std::path::PathBuf;

use clap::Args;
use thiserror::Error;

use super::args::disable_help;
use super::output::{self, Teller, ValidationError};
use super::places::{self, PlaceError};
use crate::animate::Animator;
use crate::gpu::{Capabilities, Device, DeviceRequest, GpuError};
use crate::gpu_scene::GpuScene;
use crate::image::{ImageError, atomic};
use crate::render::{RenderError, check_frame};
use crate::scene::{self, SceneError};
use crate::technique::eikonal::{self, file};
use crate::technique::{Settings, TechniqueError, TechniqueKind};

const EXAMPLES: &str = "\
Examples:
  nephroid volume scenes/pool.toml -o pool.volumes
  nephroid volume scenes/pool.toml --set eikonal.resolution=256 --frame 12 -o pool.volumes
  nephroid render scenes/pool.toml --technique eikonal --set eikonal.read=pool.volumes -o pool.png

The file is a line of JSON and 32-bit floats; README.md says which.";

/// Solve for the caustic volumes of a scene's lights and write them to a file
#[derive(Debug, Clone, Args)]
#[command(after_help = EXAMPLES)]
pub struct VolumeArgs {
    /// The scene file (.toml)
    pub scene: PathBuf,
    /// The file to write
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// The frame of the scene's animation
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub frame: u32,
    /// A setting of eikonal; give it again for more
    #[arg(long, value_name = "eikonal.KEY=VALUE")]
    pub set: Vec<String>,
    /// Index or part of the name of the device to use, see 'nephroid devices' [default: the most capable]
    #[arg(long, value_name = "DEVICE", env = "NEPHROID_DEVICE", hide_env_values = true)]
    pub device: Option<String>,
    #[arg(long, value_name = "LIST", help = disable_help(), value_parser = Capabilities::parse)]
    pub disable: Option<Capabilities>,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
    /// Run under the Vulkan validation layers, and fail if they find something
    #[arg(long)]
    pub validation: bool,
}

/// Why no volumes were written.
#[derive(Debug, Error)]
pub enum VolumeError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Place(#[from] PlaceError),
    #[error(transparent)]
    Technique(#[from] TechniqueError),
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    Gpu(#[from] GpuError),
    #[error(transparent)]
    File(#[from] ImageError),
    #[error(transparent)]
    Validation(#[from] ValidationError),
    #[error("{scene}: no light shines through a refracting surface on anything, so there is no volume to write")]
    NoVolume { scene: PathBuf },
}

/// Solves and writes; all of the file or nothing.
///
/// # Errors
/// Those of the scene, the settings, the device and the file.
pub fn run(args: &VolumeArgs) -> Result<(), VolumeError> {
    atomic::check_place(&args.output)?;
    places::distinct([("the scene", args.scene.clone()), ("--output", args.output.clone())])?;
    let mut scene = scene::load(&args.scene)?;
    check_frame(&scene, args.frame)?;
    let mut teller = Teller::new(args.quiet);
    teller.warn(&scene.warnings);
    let settings = Settings::of(TechniqueKind::Eikonal, &scene, &args.set)?;
    let device = Device::open(&DeviceRequest {
        device: args.device.clone().filter(|name| !name.is_empty()),
        disable: args.disable.clone().unwrap_or_default(),
        validation: args.validation,
    })?;
    let mut gpu_scene = GpuScene::new(&device, &scene)?;
    if args.frame > 0 {
        Animator::new(&device, &scene, &gpu_scene)?.go_to(args.frame, &mut scene, &mut gpu_scene)?;
    }
    let volumes = eikonal::precompute(&device, &scene, &gpu_scene, &settings)?;
    if volumes.is_empty() {
        return Err(VolumeError::NoVolume { scene: args.scene.clone() });
    }
    file::write(&args.output, &volumes)?;
    for volume in &volumes {
        let [x, y, z] = volume.header.cells;
        let light = &scene.lights[volume.header.light].name;
        teller.tell(format_args!("Volume  {light}: {x} x {y} x {z} cells of {:.4} m", volume.header.cell));
    }
    teller.tell_file(&args.output);
    Ok(output::refuse_validation_messages(&device)?)
}
