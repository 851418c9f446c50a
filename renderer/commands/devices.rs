//! `nephroid devices`: what there is to render on.

use std::io::{self, Write};

use clap::Args;
use thiserror::Error;

use crate::gpu::{Device, DeviceInfo, GpuError};

const HELP: &str = "\
A device is chosen by its index or a part of its name: nephroid render --device 1 ..., --device nvidia, or the variable
NEPHROID_DEVICE. The capabilities listed are those the driver claims; ray queries are tried before they are used, and
--disable does without any of them.";

/// List the Vulkan devices and what they can do
#[derive(Debug, Clone, Args)]
#[command(after_help = HELP)]
pub struct DevicesArgs {
    /// Print a JSON array instead of a table
    #[arg(long)]
    pub json: bool,
}

/// Why the devices could not be listed.
#[derive(Debug, Error)]
pub enum DevicesError {
    #[error(transparent)]
    Gpu(#[from] GpuError),
    #[error("the devices cannot be printed: {0}")]
    Print(#[from] io::Error),
}

/// Prints the devices to standard output.
///
/// # Errors
/// No loader, no device, a driver that fails, or an output that cannot be written to.
pub fn run(args: &DevicesArgs) -> Result<(), DevicesError> {
    let devices = Device::list()?;
    if devices.is_empty() {
        return Err(GpuError::NoDevice.into());
    }
    let mut output = io::stdout().lock();
    if args.json {
        serde_json::to_writer_pretty(&mut output, &devices).map_err(io::Error::from)?;
        writeln!(output)?;
    } else {
        devices.iter().try_for_each(|device| print(&mut output, device))?;
    }
    Ok(output.flush()?)
}

fn print(output: &mut impl Write, device: &DeviceInfo) -> io::Result<()> {
    let capabilities = match device.capabilities.names().join(", ") {
        names if names.is_empty() => "compute only".to_owned(),
        names => names,
    };
    let usable = device.unsuitable.as_ref().map_or("yes".to_owned(), |reason| format!("no: {reason}"));
    let rows = [
        ("kind", device.kind.to_owned()),
        ("driver", format!("{} {}", device.driver, device.driver_version)),
        ("Vulkan", device.vulkan.clone()),
        ("capabilities", capabilities),
        ("largest buffer", format!("{} MiB", device.limits.storage_range >> 20)),
        ("usable", usable),
    ];
    writeln!(output, "{}  {}", device.index, device.name)?;
    rows.iter().try_for_each(|(name, value)| writeln!(output, "   {name:<15} {value}"))
}
