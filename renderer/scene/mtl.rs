//! MTL files: what of them maps to this renderer's materials.

use std::path::{Path, PathBuf};

use glam::Vec3;

use super::error::{SceneError, in_file, io_reason};
use super::{Material, MaterialId, Medium, MediumId, Scene, Surface, texture};

/// A material of an MTL file.
pub(super) struct Entry {
    pub material: tobj::Material,
    file: PathBuf,
    /// Of its `newmtl`.
    line: u32,
}

/// Kd where an MTL file gives none.
const DEFAULT_ALBEDO: Vec3 = Vec3::splat(0.8);

/// Reads the MTL file `name` that line `line` of the OBJ file `obj` names.
pub(super) fn read(obj: &Path, line: u32, name: &str) -> Result<Vec<Entry>, SceneError> {
    let file = obj.parent().unwrap_or(Path::new("")).join(name);
    let bytes = std::fs::read(&file).map_err(|error| {
        let problem = format!("`mtllib` {} cannot be read: {}", file.display(), io_reason(&error));
        in_file(obj, line, problem)
    })?;
    let text = String::from_utf8_lossy(&bytes);
    let starts = check(&file, &text)?;
    let (materials, _) = tobj::load_mtl_buf(&mut text.as_bytes())
        .map_err(|error| in_file(obj, line, format!("`mtllib` {} cannot be read: {error}", file.display())))?;
    let entries = materials.into_iter().zip(starts);
    Ok(entries.map(|(material, line)| Entry { material, file: file.clone(), line }).collect())
}

/// Refuses numbers `tobj` would panic on, and gives the line of each `newmtl`.
fn check(file: &Path, text: &str) -> Result<Vec<u32>, SceneError> {
    let mut starts = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        let Some(keyword) = words.next() else {
            continue;
        };
        let refuse = |allowed: &str| {
            let found = line.trim().get(keyword.len()..).unwrap_or("").trim();
            in_file(file, index as u32 + 1, format!("`{keyword}` is \"{found}\"; allowed: {allowed}"))
        };
        let values: Vec<&str> = words.collect();
        let within = |count: usize, low: f32, high: f32| {
            let sound = |word: &&str| word.parse().is_ok_and(|x: f32| (low..=high).contains(&x));
            values.iter().take(count).filter(|word| sound(word)).count() == count
        };
        match keyword {
            "newmtl" if values.is_empty() => return Err(refuse("the name of a material")),
            "newmtl" => starts.push(index as u32 + 1),
            "Kd" | "Ks" if !within(3, 0.0, 1.0) => return Err(refuse("three numbers from 0 to 1")),
            "Ka" | "Ke" if !within(3, 0.0, f32::MAX) => {
                return Err(refuse("three numbers of at least 0"));
            }
            "Ns" if !within(1, 0.0, f32::MAX) => return Err(refuse("a number of at least 0")),
            "Ni" if !within(1, 0.001, 10.0) => return Err(refuse("a number from 0.001 to 10")),
            "d" if !within(1, 0.0, 1.0) => return Err(refuse("a number from 0 to 1")),
            "illum" if !within(1, 0.0, 10.0) => return Err(refuse("a whole number from 0 to 10")),
            _ => {}
        }
    }
    Ok(starts)
}

/// Adds the material, called `name`, to the scene.
///
/// `illum` 3 is a mirror of Ks; `illum` 4 to 7, or d below 1 with Ni, an interface from air to a clear medium of index
/// Ni; all else is diffuse with Kd and map_Kd.
pub(super) fn add(entry: &Entry, name: &str, scene: &mut Scene) -> Result<MaterialId, SceneError> {
    if let Some(known) = scene.materials.iter().position(|material| material.name == name) {
        return Ok(known);
    }
    let refuse = |problem: String| in_file(&entry.file, entry.line, problem);
    let material = &entry.material;
    let see_through = material.dissolve.is_some_and(|d| d < 1.0);
    let surface = match (material.illumination_model, material.optical_density) {
        (Some(3), _) => Surface::Mirror { reflectance: material.specular.map_or(Vec3::ONE, Vec3::from_array) },
        (Some(4..=7), None) => {
            let found = &material.name;
            return Err(refuse(format!("the glass \"{found}\" lacks `Ni`; allowed: a number from 1 to 10")));
        }
        (illum, Some(index)) if see_through || matches!(illum, Some(4..=7)) => {
            if index < 1.0 {
                let found = &material.name;
                return Err(refuse(format!("the glass \"{found}\" has `Ni` {index}; allowed: a number from 1 to 10")));
            }
            Surface::Dielectric { front: 0, back: add_medium(name, index, scene) }
        }
        _ => {
            if see_through {
                let file = entry.file.display();
                scene.warnings.push(format!("{file}:{}: drawn opaque, as it has `d` and no `Ni`", entry.line));
            }
            diffuse(entry, scene).map_err(refuse)?
        }
    };
    scene.materials.push(Material { name: name.to_owned(), surface });
    Ok(scene.materials.len() - 1)
}

fn diffuse(entry: &Entry, scene: &mut Scene) -> Result<Surface, String> {
    let albedo = entry.material.diffuse.map_or(DEFAULT_ALBEDO, Vec3::from_array);
    let Some(map) = &entry.material.diffuse_texture else {
        return Ok(Surface::Diffuse { albedo, texture: None });
    };
    if map.starts_with('-') {
        return Err(format!("`map_Kd` is \"{map}\"; allowed: the name of a PNG or JPEG file, without options"));
    }
    // Files written on Windows, the public Sponza's among them, have folders\files.
    let file = entry.file.parent().unwrap_or(Path::new("")).join(map.replace('\\', "/"));
    let texture = texture::open(&file, &mut scene.textures)
        .map_err(|problem| format!("`map_Kd` refers to {}, which {problem}", file.display()))?;
    Ok(Surface::Diffuse { albedo, texture: Some(texture) })
}

fn add_medium(name: &str, index: f32, scene: &mut Scene) -> MediumId {
    let name = name.to_owned();
    scene.media.push(Medium {
        name,
        index,
        absorption: Vec3::ZERO,
        scattering: Vec3::ZERO,
        asymmetry: 0.0,
        density: None,
    });
    scene.media.len() - 1
}
