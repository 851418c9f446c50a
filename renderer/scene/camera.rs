//! `[[camera]]`.

use glam::DVec3;

use super::Scene;
use super::animation::{CameraPose, Keys};
use super::error::SceneError;
use super::file::{read_medium_id, read_name};
use super::keyed::{self, KEYED};
use super::value::{COORDINATE, Limit, Node, Table};

const FIELD_OF_VIEW: Limit = Limit { holds: |fov| (0.1..=179.0).contains(&fov), words: "from 0.1 to 179" };

/// The sine of the angle between a camera's up and its view, below which the picture has no defined roll.
const LEAST_UP_SINE: f64 = 1e-4;

const POSE: &[&str] = &["position", "target", "up", "fov_y"];

/// Reads one camera, and its keys, into the scene.
pub(super) fn read(node: &Node, scene: &mut Scene) -> Result<(), SceneError> {
    let table = node.table("[[camera]]", &[&["name"], POSE, &["medium"], KEYED].concat())?;
    let name = read_name(&table, "camera", scene.cameras.iter().map(|camera| camera.name.as_str()))?;
    let own = read_pose(node, &table, None)?;
    let medium = read_medium_id(&table, "medium", &scene.media)?;
    let place = scene.cameras.len();
    let keys: Option<Keys<CameraPose>> =
        keyed::read(&table, place..place + 1, "a key of a [[camera]]", POSE, |node, key| {
            read_pose(node, key, Some(&own))
        })?;
    scene.animation.cameras.extend(keys);
    scene.cameras.push(own.camera(name, medium));
    Ok(())
}

/// What the table at `node` says; `own` is what it leaves out.
fn read_pose(node: &Node, table: &Table, own: Option<&CameraPose>) -> Result<CameraPose, SceneError> {
    let point = "a list of three numbers";
    let pose = CameraPose {
        position: table.or_need("position", point, own.map(|own| own.position), |node| node.vec3(COORDINATE))?,
        target: table.or_need("target", point, own.map(|own| own.target), |node| node.vec3(COORDINATE))?,
        up: table.or("up", own.map_or(DVec3::Y, |own| own.up), |node| node.direction())?,
        fov_y: table.or("fov_y", own.map_or(45.0, |own| own.fov_y), |node| node.number(FIELD_OF_VIEW))?,
    };
    let refuse = |keys: [&str; 3], allowed: &str| {
        let first = keys.iter().find_map(|key| table.get(key));
        Err(first.unwrap_or_else(|| node.clone()).refuse(allowed))
    };
    let view = pose.target - pose.position;
    if view.length() < CameraPose::LEAST_DISTANCE {
        return refuse(["target", "position", "up"], "a point at least 1e-6 from the camera's position");
    }
    if pose.up.cross(view.normalize()).length() < LEAST_UP_SINE {
        let allowed = "a camera whose `up` (0, 1, 0 if left out) is not along its view";
        return refuse(["up", "target", "position"], allowed);
    }
    Ok(pose)
}
