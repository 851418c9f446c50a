//! `[[material]]`.

use glam::Vec3;

use super::error::SceneError;
use super::file::{read_medium_id, read_name};
use super::value::{FRACTION, Limit, Node, Table};
use super::{Material, Scene, Surface, texture};

/// Below 0.01 the GGX peak (alpha = 1e-4) is narrower than f32 directions resolve; `mirror` is meant for that.
const ROUGHNESS: Limit = Limit { holds: |r| (0.01..=1.0).contains(&r), words: "from 0.01 to 1" };

const DIFFUSE_KEYS: &[&str] = &["name", "kind", "albedo", "texture"];
const DIELECTRIC_KEYS: &[&str] = &["name", "kind", "front", "back"];
const MIRROR_KEYS: &[&str] = &["name", "kind", "reflectance"];
const ROUGH_KEYS: &[&str] = &["name", "kind", "reflectance", "roughness"];

#[derive(Clone, Copy)]
enum Kind {
    Diffuse,
    Dielectric,
    Mirror,
    Rough,
}

/// Reads one material, and its texture, into the scene.
pub(super) fn read(node: &Node, scene: &mut Scene) -> Result<(), SceneError> {
    let kinds = [
        ("diffuse", Kind::Diffuse),
        ("dielectric", Kind::Dielectric),
        ("mirror", Kind::Mirror),
        ("rough", Kind::Rough),
    ];
    let any = node.any_table("[[material]]")?;
    let kind = any.need("kind", "\"diffuse\", \"dielectric\", \"mirror\", \"rough\"")?.choice(&kinds)?;
    let table = match kind {
        Kind::Diffuse => node.table("a diffuse [[material]]", DIFFUSE_KEYS)?,
        Kind::Dielectric => node.table("a dielectric [[material]]", DIELECTRIC_KEYS)?,
        Kind::Mirror => node.table("a mirror [[material]]", MIRROR_KEYS)?,
        Kind::Rough => node.table("a rough [[material]]", ROUGH_KEYS)?,
    };
    let names = scene.materials.iter().map(|material| material.name.as_str());
    let name = read_name(&table, "material", names)?;
    let surface = match kind {
        Kind::Diffuse => diffuse(&table, scene)?,
        Kind::Dielectric => dielectric(&table, scene)?,
        Kind::Mirror => Surface::Mirror { reflectance: reflectance(&table)? },
        Kind::Rough => Surface::Rough {
            reflectance: reflectance(&table)?,
            roughness: table.need("roughness", "a number from 0.01 to 1")?.number(ROUGHNESS)? as f32,
        },
    };
    scene.materials.push(Material { name, surface });
    Ok(())
}

fn diffuse(table: &Table, scene: &mut Scene) -> Result<Surface, SceneError> {
    let texture = match table.get("texture") {
        None => None,
        Some(node) => Some(texture::read(&node, &mut scene.textures)?),
    };
    let albedo = match texture {
        None => table.need("albedo", "a number from 0 to 1, or a list of three")?.rgb(FRACTION)?,
        Some(_) => table.or("albedo", Vec3::ONE, |node| node.rgb(FRACTION))?,
    };
    Ok(Surface::Diffuse { albedo, texture })
}

fn dielectric(table: &Table, scene: &Scene) -> Result<Surface, SceneError> {
    let front = read_medium_id(table, "front", &scene.media)?;
    let node = table.need("back", "the name of a medium")?;
    let back = read_medium_id(table, "back", &scene.media)?;
    if front == back {
        return Err(node.refuse("a medium other than the one in `front` (air if left out)"));
    }
    Ok(Surface::Dielectric { front, back })
}

fn reflectance(table: &Table) -> Result<Vec3, SceneError> {
    table.or("reflectance", Vec3::ONE, |node| node.rgb(FRACTION))
}
