//! Benchmarks of several parts, each of which can be asked for by itself.

use std::error::Error;

use nephroid::gpu::{Device, DeviceRequest};

/// A part's name, and what measures it.
pub type Part<Options> = (&'static str, fn(&Options, &Device) -> Result<serde_json::Value, Box<dyn Error>>);

/// The name that was given after `--part`, if there is such a part.
pub fn named<Options>(all: &[Part<Options>], given: String) -> Result<String, Box<dyn Error>> {
    if all.iter().any(|(name, _)| *name == given) {
        return Ok(given);
    }
    let names = all.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
    Err(format!("--part is \"{given}\"; allowed are {names}").into())
}

/// Measures those of `all` that are in `asked`, or all if nothing is, and writes what they found to
/// `target/bench/<bench>.json`.
pub fn measure<Options>(
    bench: &str,
    all: &[Part<Options>],
    asked: &[String],
    options: &Options,
    request: &DeviceRequest,
) -> Result<(), Box<dyn Error>> {
    // One for all parts, so that kernels are compiled once.
    let device = Device::open(request)?;
    println!("{}\n", device.info.describe());
    let mut results = serde_json::Map::new();
    results.insert("device".to_string(), device.info.describe().into());
    for (name, measure) in all {
        if asked.is_empty() || asked.iter().any(|part| part == name) {
            results.insert(name.to_string(), measure(options, &device)?);
        }
    }
    super::write(bench, results.into())
}
