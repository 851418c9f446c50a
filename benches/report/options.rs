//! What stands on a benchmark's command line.

use std::error::Error;

use nephroid::render::RenderSettings;

/// A name, with its dashes, and its value.
pub type Given = (String, String);

/// What was given, in its order.
pub fn given() -> Result<Vec<Given>, Box<dyn Error>> {
    // Cargo passes --bench to every bench.
    let mut words = std::env::args().skip(1).filter(|word| word != "--bench");
    let mut given = Vec::new();
    while let Some(name) = words.next() {
        let value = words.next().ok_or(format!("{name} needs a value"))?;
        given.push((name, value));
    }
    Ok(given)
}

/// What the benchmarks that render have in common: `--camera`, `--device`, `--set`, `--size` and `--trace`.
pub fn put(settings: &mut RenderSettings, (name, value): Given) -> Result<(), Box<dyn Error>> {
    match name.as_str() {
        "--camera" => settings.camera = Some(value),
        "--device" => settings.device.device = Some(value),
        "--set" => settings.set.push(value),
        "--size" => {
            let (width, height) = value.split_once('x').ok_or("--size wants WxH")?;
            settings.size = Some((width.parse()?, height.parse()?));
        }
        "--trace" => settings.trace = value.parse()?,
        _ => return Err(format!("unknown option {name}").into()),
    }
    Ok(())
}

pub fn numbers(list: &str) -> Result<Vec<u32>, Box<dyn Error>> {
    list.split(',').map(|number| Ok(number.trim().parse()?)).collect()
}
