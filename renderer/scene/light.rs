//! `[[light]]`.

use super::error::SceneError;
use super::file::{read_medium_id, read_name};
use super::value::{COORDINATE, Limit, Node, QUANTITY, Table};
use super::{Emitter, Light, Scene};

const HALF_ANGLE: Limit = Limit { holds: |degrees| (0.0..=90.0).contains(&degrees), words: "from 0 to 90" };

const POINT_KEYS: &[&str] = &["name", "kind", "medium", "position", "intensity"];
const SPOT_KEYS: &[&str] = &["name", "kind", "medium", "position", "target", "intensity", "inner", "outer"];
const DIRECTIONAL_KEYS: &[&str] = &["name", "kind", "medium", "direction", "irradiance"];

#[derive(Clone, Copy)]
enum Kind {
    Point,
    Spot,
    Directional,
}

pub(super) fn read(node: &Node, scene: &Scene) -> Result<Light, SceneError> {
    let kinds = [("point", Kind::Point), ("spot", Kind::Spot), ("directional", Kind::Directional)];
    let any = node.any_table("[[light]]")?;
    let kind = any.need("kind", "\"point\", \"spot\", \"directional\"")?.choice(&kinds)?;
    let table = match kind {
        Kind::Point => node.table("a point [[light]]", POINT_KEYS)?,
        Kind::Spot => node.table("a spot [[light]]", SPOT_KEYS)?,
        Kind::Directional => node.table("a directional [[light]]", DIRECTIONAL_KEYS)?,
    };
    let name = read_name(&table, "light", scene.lights.iter().map(|light| light.name.as_str()))?;
    let emitter = match kind {
        Kind::Point => point(&table)?,
        Kind::Spot => spot(&table)?,
        Kind::Directional => directional(&table)?,
    };
    Ok(Light { name, emitter, medium: read_medium_id(&table, "medium", &scene.media)? })
}

fn point(table: &Table) -> Result<Emitter, SceneError> {
    let position = table.need("position", "a list of three numbers")?.vec3(COORDINATE)?;
    let intensity = table.need("intensity", "W/sr, a number or a list of three")?.rgb(QUANTITY)?;
    Ok(Emitter::Point { position: position.as_vec3(), intensity })
}

fn spot(table: &Table) -> Result<Emitter, SceneError> {
    let position = table.need("position", "a list of three numbers")?.vec3(COORDINATE)?;
    let target_node = table.need("target", "a list of three numbers")?;
    let target = target_node.vec3(COORDINATE)?;
    let Some(direction) = (target - position).try_normalize() else {
        return Err(target_node.refuse("a point other than the light's position"));
    };
    let intensity = table.need("intensity", "W/sr, a number or a list of three")?.rgb(QUANTITY)?;
    let outer = table.need("outer", "a half angle in degrees from 0 to 90")?.number(HALF_ANGLE)?;
    let inner = table.or("inner", outer, |node| {
        let inner = node.number(HALF_ANGLE)?;
        if inner > outer { Err(node.refuse(format!("a number from 0 to `outer`, {outer}"))) } else { Ok(inner) }
    })?;
    Ok(Emitter::Spot {
        position: position.as_vec3(),
        direction: direction.as_vec3(),
        intensity,
        inner: inner.to_radians() as f32,
        outer: outer.to_radians() as f32,
    })
}

fn directional(table: &Table) -> Result<Emitter, SceneError> {
    let direction = table.need("direction", "a list of three numbers")?.direction()?;
    let irradiance = table.need("irradiance", "W/m2, a number or a list of three")?.rgb(QUANTITY)?;
    Ok(Emitter::Directional { direction: direction.as_vec3(), irradiance })
}
