//! A scene file read into a [`Scene`]. `scenes/FORMAT.md` documents every key.

use std::fs;
use std::path::Path;

use glam::Vec3;
use toml::de::DeTable;

use super::error::{SceneError, io_reason};
use super::value::{Limit, Node, QUANTITY, Source, Table};
use super::{
    Animation, Emitter, FilmSettings, Light, Medium, MediumId, Scene, ToneCurve, camera, density, light, material,
    object, technique,
};

/// Pixels a side: one layer of four floats a pixel fills 4 GiB then.
const LARGEST_FILM: u32 = 16_384;
const MOST_SAMPLES: u32 = 1 << 20;
/// Points on a stretch of a path in a medium that scatters.
const VOLUME_SAMPLES: u32 = 4;
const MOST_VOLUME_SAMPLES: u32 = 1024;
const MOST_FRAMES: u32 = 1_000_000;

const INDEX: Limit = Limit { holds: |n| (1.0..=10.0).contains(&n), words: "from 1 to 10" };
const ASYMMETRY: Limit = Limit { holds: |g| (-0.999..=0.999).contains(&g), words: "from -0.999 to 0.999" };
/// Frames per second that are allowed; as told below.
pub const FPS: std::ops::RangeInclusive<f64> = 0.01..=1000.0;
const FRAMES_PER_SECOND: Limit = Limit { holds: |fps| FPS.contains(&fps), words: "from 0.01 to 1000" };
const EXPOSURE: Limit = Limit { holds: |stops| (-32.0..=32.0).contains(&stops), words: "from -32 to 32" };

/// Reads the scene file at `path` and all files it refers to; relative names are taken from the scene file's folder.
///
/// # Errors
/// The first thing wrong with the scene, in one sentence that names file and line.
pub fn load(path: &Path) -> Result<Scene, SceneError> {
    load_at(path, None)
}

/// As [`load`]; where `fps` is given, frames per second, it stands for what the file says.
///
/// # Errors
/// As [`load`]. Simulated water may be too fast for few frames per second.
pub fn load_at(path: &Path, fps: Option<f64>) -> Result<Scene, SceneError> {
    let refuse = |error| SceneError::Unreadable { path: path.to_owned(), reason: io_reason(&error) };
    let text = fs::read_to_string(path).map_err(refuse)?;
    parse_at(&text, path, fps)
}

/// Reads a scene from `text` as if it stood in the file `path`.
///
/// # Errors
/// As [`load`].
pub fn parse(text: &str, path: &Path) -> Result<Scene, SceneError> {
    parse_at(text, path, None)
}

fn parse_at(text: &str, path: &Path, fps: Option<f64>) -> Result<Scene, SceneError> {
    let source = Source { path, text };
    let document = DeTable::parse(text).map_err(|error| syntax_error(source, &error))?;
    let keys = ["film", "animation", "camera", "medium", "material", "object", "light", "technique"];
    let root = Table::root(source, document.get_ref(), &keys)?;

    let mut scene = empty_scene(path);
    if let Some(film) = root.get("film") {
        scene.film = read_film(&film)?;
    }
    if let Some(animation) = root.get("animation") {
        scene.animation = read_animation(&animation)?;
    }
    scene.animation.fps = fps.unwrap_or(scene.animation.fps);
    for node in tables(&root, "medium")? {
        read_medium(&node, &mut scene)?;
    }
    for node in tables(&root, "camera")? {
        camera::read(&node, &mut scene)?;
    }
    for node in tables(&root, "material")? {
        material::read(&node, &mut scene)?;
    }
    for node in tables(&root, "light")? {
        light::read(&node, &mut scene)?;
    }
    object::read_all(&tables(&root, "object")?, &mut scene)?;
    if let Some(node) = root.get("technique") {
        technique::read(&node, &mut scene)?;
    }

    if scene.cameras.is_empty() {
        root.need("camera", "at least one [[camera]]")?;
    }
    if scene.instances.is_empty() {
        root.need("object", "at least one [[object]]")?;
    }
    if scene.lights.is_empty() {
        scene.warnings.push(format!("{} has no [[light]]: only its background is seen", path.display()));
    }
    let swallowed = scene.lights.iter().filter(|light| swallows(&scene.media[light.medium], &light.emitter));
    let warning = |light: &Light| {
        let medium = &scene.media[light.medium].name;
        format!("nothing of the directional light \"{}\" arrives: its medium \"{medium}\" has no end", light.name)
    };
    let warnings: Vec<String> = swallowed.map(warning).collect();
    scene.warnings.extend(warnings);
    let animation = scene.animation.clone();
    animation.pose(&mut scene, 0.0);
    Ok(scene)
}

/// Whether light from infinitely far is lost on an endless way through a medium.
fn swallows(medium: &Medium, emitter: &Emitter) -> bool {
    let endless = medium.density.is_none() && medium.extinction().max_element() > 0.0;
    endless && matches!(emitter, Emitter::Directional { .. })
}

fn empty_scene(path: &Path) -> Scene {
    let air = Medium {
        name: "air".to_owned(),
        index: 1.0,
        absorption: Vec3::ZERO,
        scattering: Vec3::ZERO,
        asymmetry: 0.0,
        density: None,
    };
    let film = FilmSettings {
        width: 640,
        height: 480,
        samples: 16,
        exposure: 0.0,
        tone_curve: ToneCurve::Linear,
        background: Vec3::ZERO,
        volume_samples: VOLUME_SAMPLES,
    };
    Scene {
        path: path.to_owned(),
        film,
        cameras: Vec::new(),
        meshes: Vec::new(),
        instances: Vec::new(),
        materials: Vec::new(),
        textures: Vec::new(),
        densities: Vec::new(),
        media: vec![air],
        lights: Vec::new(),
        animation: Default::default(),
        settings: Vec::new(),
        warnings: Vec::new(),
    }
}

/// The parser's message, which may span lines, as one sentence.
fn syntax_error(source: Source, error: &toml::de::Error) -> SceneError {
    let offset = error.span().map_or(0, |span| span.start);
    let words: Vec<&str> = error.message().split_whitespace().collect();
    SceneError::Syntax { at: source.line_and_column(offset), reason: words.join(" ") }
}

/// The tables of `[[key]]`, none where there is no such key.
fn tables<'s>(root: &Table<'s>, key: &str) -> Result<Vec<Node<'s>>, SceneError> {
    match root.get(key) {
        None => Ok(Vec::new()),
        Some(node) => {
            let nodes = node.list(&format!("tables, each written [[{key}]]"))?;
            if nodes.is_empty() {
                return Err(node.refuse(format!("at least one [[{key}]], or no such key")));
            }
            Ok(nodes)
        }
    }
}

/// The key `name`, checked against the names already given to things of that kind.
pub(super) fn read_name<'a>(
    table: &Table,
    kind: &'static str,
    mut taken: impl Iterator<Item = &'a str>,
) -> Result<String, SceneError> {
    let node = table.need("name", "a text that is not empty")?;
    let name = node.text()?;
    if taken.any(|other| other == name) {
        return Err(SceneError::TakenName { at: node.at(), kind, name: name.to_owned() });
    }
    Ok(name.to_owned())
}

/// The place of the named thing among `names`.
pub(super) fn find_name<'a>(
    node: &Node,
    kind: &'static str,
    names: impl Iterator<Item = &'a str> + Clone,
) -> Result<usize, SceneError> {
    let wanted = node.text()?;
    let known = || {
        let known: Vec<String> = names.clone().map(|name| format!("\"{name}\"")).collect();
        if known.is_empty() { "none".to_owned() } else { known.join(", ") }
    };
    names.clone().position(|name| name == wanted).ok_or_else(|| SceneError::UnknownName {
        at: node.at(),
        key: node.key.clone(),
        kind,
        found: wanted.to_owned(),
        known: known(),
    })
}

/// The medium that `key` names, air where it is left out.
pub(super) fn read_medium_id(table: &Table, key: &str, media: &[Medium]) -> Result<MediumId, SceneError> {
    let names = media.iter().map(|medium| medium.name.as_str());
    table.or(key, 0, |node| find_name(&node, "medium", names))
}

fn read_film(node: &Node) -> Result<FilmSettings, SceneError> {
    let table = node
        .table("[film]", &["width", "height", "samples", "exposure", "tone_curve", "background", "volume_samples"])?;
    let curves = [("linear", ToneCurve::Linear), ("reinhard", ToneCurve::Reinhard)];
    Ok(FilmSettings {
        width: table.or("width", 640, |node| node.whole(1, LARGEST_FILM))?,
        height: table.or("height", 480, |node| node.whole(1, LARGEST_FILM))?,
        samples: table.or("samples", 16, |node| node.whole(1, MOST_SAMPLES))?,
        exposure: table.or("exposure", 0.0, |node| node.number(EXPOSURE))? as f32,
        tone_curve: table.or("tone_curve", ToneCurve::Linear, |node| node.choice(&curves))?,
        background: table.or("background", Vec3::ZERO, |node| node.rgb(QUANTITY))?,
        volume_samples: table.or("volume_samples", VOLUME_SAMPLES, |node| node.whole(1, MOST_VOLUME_SAMPLES))?,
    })
}

/// Reads one medium, and its density, into the scene.
fn read_medium(node: &Node, scene: &mut Scene) -> Result<(), SceneError> {
    let table = node.table("[[medium]]", &["name", "index", "absorption", "scattering", "asymmetry", "density"])?;
    let mut medium = Medium {
        name: read_name(&table, "medium", scene.media.iter().map(|medium| medium.name.as_str()))?,
        index: table.need("index", "a number from 1 to 10")?.number(INDEX)? as f32,
        absorption: table.or("absorption", Vec3::ZERO, |node| node.rgb(QUANTITY))?,
        scattering: table.or("scattering", Vec3::ZERO, |node| node.rgb(QUANTITY))?,
        asymmetry: table.or("asymmetry", 0.0, |node| node.number(ASYMMETRY))? as f32,
        density: None,
    };
    if let Some(node) = table.get("density") {
        medium.density = Some(scene.densities.len());
        scene.densities.push(density::read(&node)?);
    }
    scene.media.push(medium);
    Ok(())
}

fn read_animation(node: &Node) -> Result<Animation, SceneError> {
    let table = node.table("[animation]", &["fps", "frames"])?;
    Ok(Animation {
        fps: table.or("fps", 24.0, |node| node.number(FRAMES_PER_SECOND))?,
        frames: table.get("frames").map(|node| node.whole(1, MOST_FRAMES)).transpose()?,
        ..Animation::default()
    })
}
