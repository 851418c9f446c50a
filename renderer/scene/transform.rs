//! Where an object stands: `transform`, and the same at the times of its keys.

use glam::{Affine3A, DAffine3, DQuat, DVec3, EulerRot};

use super::error::SceneError;
use super::value::{ANGLE, COORDINATE, Limit, Node, Table};

/// Mirroring would turn a mesh inside out.
const SCALE: Limit = Limit { holds: |s| (1e-6..=1e6).contains(&s), words: "from 1e-6 to 1e6" };

pub(super) const KEYS: &[&str] = &["translate", "rotate", "scale"];

/// Scales, then rotates, then translates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Metres.
    pub translate: DVec3,
    /// Unit.
    pub rotate: DQuat,
    /// Positive.
    pub scale: DVec3,
}

impl Placement {
    pub const IDENTITY: Placement = Placement { translate: DVec3::ZERO, rotate: DQuat::IDENTITY, scale: DVec3::ONE };

    /// Object space to world space, rounded once.
    pub fn transform(&self) -> Affine3A {
        let transform = DAffine3::from_scale_rotation_translation(self.scale, self.rotate, self.translate);
        Affine3A::from_mat4(glam::DMat4::from(transform).as_mat4())
    }
}

/// `transform`.
pub(super) fn read(node: &Node) -> Result<Placement, SceneError> {
    read_pose(&node.table("`transform`", KEYS)?, &Placement::IDENTITY)
}

/// What a table with [`KEYS`] says; `own` is what it leaves out.
pub(super) fn read_pose(table: &Table, own: &Placement) -> Result<Placement, SceneError> {
    Ok(Placement {
        translate: table.or("translate", own.translate, |node| node.vec3(COORDINATE))?,
        rotate: table.or("rotate", own.rotate, |node| rotation(&node))?,
        scale: table.or("scale", own.scale, |node| node.triple(SCALE))?,
    })
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
