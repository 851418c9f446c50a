//! `transform` of an object.

use glam::{Affine3A, DAffine3, DQuat, DVec3, EulerRot};

use super::error::SceneError;
use super::value::{ANGLE, COORDINATE, Limit, Node};

/// Mirroring would turn a mesh inside out.
const SCALE: Limit = Limit { holds: |s| (1e-6..=1e6).contains(&s), words: "from 1e-6 to 1e6" };

/// Scales, then rotates, then translates.
pub(super) fn read(node: &Node) -> Result<Affine3A, SceneError> {
    let table = node.table("`transform`", &["translate", "rotate", "scale"])?;
    let translation = table.or("translate", DVec3::ZERO, |node| node.vec3(COORDINATE))?;
    let rotation = table.or("rotate", DQuat::IDENTITY, |node| rotation(&node))?;
    let scale = table.or("scale", DVec3::ONE, |node| node.triple(SCALE))?;
    let transform = DAffine3::from_scale_rotation_translation(scale, rotation, translation);
    Ok(Affine3A::from_mat4(glam::DMat4::from(transform).as_mat4()))
}

/// Degrees about x, then y, then z, all fixed axes; or an axis and an angle in degrees, counter-clockwise seen against
/// the axis.
fn rotation(node: &Node) -> Result<DQuat, SceneError> {
    if let Ok(table) = node.any_table("`rotate`") {
        let table = table.only(&["axis", "angle"])?;
        let axis = table.need("axis", "a list of three numbers")?.direction()?;
        let angle = table.need("angle", "a number of degrees")?.number(ANGLE)?;
        return Ok(DQuat::from_axis_angle(axis, angle.to_radians()));
    }
    let [x, y, z] = node
        .vec3(ANGLE)
        .map_err(|_| node.refuse("three angles in degrees, each from -1e4 to 1e4, or { axis, angle }"))?
        .to_array()
        .map(f64::to_radians);
    Ok(DQuat::from_euler(EulerRot::ZYX, z, y, x))
}
