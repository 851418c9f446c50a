//! `[[light]]`.

use glam::{DVec3, Vec3};

use super::animation::{Aim, LightPose};
use super::error::SceneError;
use super::file::{read_medium_id, read_name};
use super::keyed::{self, KEYED};
use super::value::{COORDINATE, Limit, Node, QUANTITY, Table};
use super::{Emitter, Light, Scene, SpotImage, texture};

const HALF_ANGLE: Limit = Limit { holds: |degrees| (0.0..=90.0).contains(&degrees), words: "from 0 to 90" };

/// The tangents of these are what an image is stretched over.
const IMAGE_ANGLE: Limit =
    Limit { holds: |degrees| (0.1..=89.0).contains(&degrees), words: "from 0.1 to 89 beside `image`" };

/// The sine of the angle between the axis of a light with an image and its up, below which the image has no defined roll.
const LEAST_UP_SINE: f64 = 1e-4;

const CONE: &[&str] = &["inner", "outer", "image", "up"];

#[derive(Clone, Copy)]
enum Kind {
    Point,
    Spot,
    Directional,
}

impl Kind {
    fn title(self) -> &'static str {
        match self {
            Kind::Point => "a point [[light]]",
            Kind::Spot => "a spot [[light]]",
            Kind::Directional => "a directional [[light]]",
        }
    }

    /// What keys can change.
    fn pose(self) -> &'static [&'static str] {
        match self {
            Kind::Point => &["position", "intensity"],
            Kind::Spot => &["position", "target", "intensity"],
            Kind::Directional => &["direction", "irradiance"],
        }
    }
}

/// Reads one light, and its keys, into the scene.
pub(super) fn read(node: &Node, scene: &mut Scene) -> Result<(), SceneError> {
    let kinds = [("point", Kind::Point), ("spot", Kind::Spot), ("directional", Kind::Directional)];
    let any = node.any_table("[[light]]")?;
    let kind = any.need("kind", "\"point\", \"spot\", \"directional\"")?.choice(&kinds)?;
    let cone = if let Kind::Spot = kind { CONE } else { &[] };
    let table = node.table(kind.title(), &[&["name", "kind", "medium"], kind.pose(), cone, KEYED].concat())?;
    let name = read_name(&table, "light", scene.lights.iter().map(|light| light.name.as_str()))?;
    let up = read_up(&table)?;
    let own = read_pose(kind, node, &table, None, up)?;
    let emitter = match kind {
        Kind::Point => Emitter::Point { position: Vec3::ZERO, intensity: Vec3::ZERO },
        Kind::Spot => read_cone(&table, up, scene)?,
        Kind::Directional => Emitter::Directional { direction: Vec3::ZERO, irradiance: Vec3::ZERO },
    };
    let mut light = Light { name, emitter, medium: read_medium_id(&table, "medium", &scene.media)? };
    own.put(&mut light);
    let place = scene.lights.len();
    let title = format!("a key of {}", kind.title());
    let keys = keyed::read(&table, place..place + 1, &title, kind.pose(), |node, key| {
        read_pose(kind, node, key, Some(&own), up)
    })?;
    scene.animation.lights.extend(keys);
    scene.lights.push(light);
    Ok(())
}

/// Which way the top of a light's image is; `None` for a light without one.
fn read_up(table: &Table) -> Result<Option<DVec3>, SceneError> {
    match (table.get("image"), table.get("up")) {
        (None, None) => Ok(None),
        (None, Some(up)) => Err(up.refuse("this key beside `image` only")),
        (Some(_), up) => up.map_or(Ok(DVec3::Y), |up| up.direction()).map(Some),
    }
}

/// What the table at `node` says; `own` is what it leaves out. `up`: of the light's image.
fn read_pose(
    kind: Kind,
    node: &Node,
    table: &Table,
    own: Option<&LightPose>,
    up: Option<DVec3>,
) -> Result<LightPose, SceneError> {
    let three = "a list of three numbers";
    let position = || table.or_need("position", three, own.map(|own| own.position), |node| node.vec3(COORDINATE));
    let power = |key, unit: &str| {
        let allowed = format!("{unit}, a number or a list of three");
        table.or_need(key, &allowed, own.map(|own| own.power), |node| node.triple(QUANTITY))
    };
    match kind {
        Kind::Point => Ok(LightPose { position: position()?, aim: Aim::Nowhere, power: power("intensity", "W/sr")? }),
        Kind::Spot => {
            let position = position()?;
            let aim = table
                .or_need("target", three, own.map(|own| own.aim), |node| Ok(Aim::Target(node.vec3(COORDINATE)?)))?;
            let pose = LightPose { position, aim, power: power("intensity", "W/sr")? };
            let refuse = |keys: [&str; 3], allowed: &str| {
                let first = keys.iter().find_map(|key| table.get(key));
                Err(first.unwrap_or_else(|| node.clone()).refuse(allowed))
            };
            let Some(axis) = pose.axis() else {
                return refuse(["target", "position", "up"], "a point other than the light's position");
            };
            if up.is_some_and(|up| up.cross(axis).length() < LEAST_UP_SINE) {
                let allowed = "a light whose `up` (0, 1, 0 if left out) is not along its axis";
                return refuse(["up", "target", "position"], allowed);
            }
            Ok(pose)
        }
        Kind::Directional => {
            let aim = table
                .or_need("direction", three, own.map(|own| own.aim), |node| Ok(Aim::Direction(node.direction()?)))?;
            Ok(LightPose { position: DVec3::ZERO, aim, power: power("irradiance", "W/m2")? })
        }
    }
}

/// A spot light that is yet to be posed.
fn read_cone(table: &Table, up: Option<DVec3>, scene: &mut Scene) -> Result<Emitter, SceneError> {
    let limit = if up.is_some() { IMAGE_ANGLE } else { HALF_ANGLE };
    let outer = table.need("outer", "a half angle in degrees from 0 to 90")?.number(limit)?;
    let inner = table.or("inner", outer, |node| {
        let inner = node.number(HALF_ANGLE)?;
        if inner > outer { Err(node.refuse(format!("a number from 0 to `outer`, {outer}"))) } else { Ok(inner) }
    })?;
    let (inner, outer) = (inner.to_radians() as f32, outer.to_radians() as f32);
    let image = match (table.get("image"), up) {
        (Some(node), Some(up)) => {
            Some(SpotImage { texture: texture::read(&node, &mut scene.textures)?, up: up.as_vec3() })
        }
        _ => None,
    };
    Ok(Emitter::Spot { position: Vec3::ZERO, direction: Vec3::NEG_Y, intensity: Vec3::ZERO, inner, outer, image })
}
