//! What keys say of cameras, objects and lights.

use std::ops::Range;

use glam::DVec3;

use super::timeline::{Span, Timeline};
use crate::scene::transform::Placement;
use crate::scene::{Camera, Emitter, Light, MediumId};

/// The motion of a thing by keys.
#[derive(Debug, Clone, PartialEq)]
pub struct Keys<P> {
    /// Which cameras, instances or lights of the scene: one, or the instances of one OBJ file.
    pub of: Range<usize>,
    pub timeline: Timeline,
    /// One a time of the timeline.
    pub poses: Vec<P>,
}

impl<P: Pose> Keys<P> {
    /// At `time`, seconds.
    pub fn at(&self, time: f64) -> P {
        P::at(&self.timeline.at(time), &self.poses)
    }
}

/// Everything about a thing that keys can change.
pub trait Pose: Copy {
    /// At a moment among the keys whose poses these are.
    fn at(span: &Span, poses: &[Self]) -> Self;
    /// Whether a motion that repeats may end with this pose and begin with the other.
    fn joins(&self, other: &Self) -> bool;
    /// Whether there is one way to the pose of the next key.
    fn leads_to(&self, _next: &Self) -> bool {
        true
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraPose {
    /// Metres.
    pub position: DVec3,
    /// Metres.
    pub target: DVec3,
    /// Unit.
    pub up: DVec3,
    /// Degrees.
    pub fov_y: f64,
}

impl CameraPose {
    /// A camera may look at a point this far away, metres.
    pub const LEAST_DISTANCE: f64 = 1e-6;

    /// The camera so posed.
    pub fn camera(&self, name: String, medium: MediumId) -> Camera {
        let [position, target, up] = [self.position, self.target, self.up].map(|vector| vector.as_vec3());
        Camera { name, position, target, up, fov_y: self.fov_y as f32, medium }
    }

    pub fn put(&self, camera: &mut Camera) {
        camera.position = self.position.as_vec3();
        camera.target = self.target.as_vec3();
        camera.up = self.up.as_vec3();
        camera.fov_y = self.fov_y as f32;
    }
}

impl Pose for CameraPose {
    /// Where the target passes through the camera, it looks the way it did at the last key.
    fn at(span: &Span, poses: &[Self]) -> Self {
        let last = poses[span.from];
        let position = span.vector(|key| poses[key].position);
        let mut target = span.vector(|key| poses[key].target);
        if (target - position).length() < Self::LEAST_DISTANCE {
            target = position + (last.target - last.position).normalize();
        }
        let up = unit(span, |key| poses[key].up);
        CameraPose { position, target, up, fov_y: span.number(|key| poses[key].fov_y) }
    }

    fn joins(&self, other: &Self) -> bool {
        self == other
    }
}

impl Pose for Placement {
    fn at(span: &Span, poses: &[Self]) -> Self {
        Placement {
            translate: span.vector(|key| poses[key].translate),
            rotate: span.rotation(|key| poses[key].rotate),
            scale: span.vector(|key| poses[key].scale),
        }
    }

    /// A whole turn later is the same rotation, but for the rounding of its angles.
    fn joins(&self, other: &Self) -> bool {
        let same_rotation = self.rotate.dot(other.rotate).abs() > 1.0 - 1e-12;
        self.translate == other.translate && self.scale == other.scale && same_rotation
    }

    /// Of half a turn, rounding would decide which way it goes.
    fn leads_to(&self, next: &Self) -> bool {
        self.rotate.dot(next.rotate).abs() > 1e-9
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightPose {
    /// Metres; of no account for a directional light.
    pub position: DVec3,
    pub aim: Aim,
    /// Intensity, W/sr, or irradiance, W/m2.
    pub power: DVec3,
}

/// Where a light's axis points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Aim {
    /// A point light has no axis.
    Nowhere,
    /// Metres, other than the light's position.
    Target(DVec3),
    /// Unit, the way the light travels.
    Direction(DVec3),
}

impl Aim {
    /// Those of the target or of the direction; zero where there is neither.
    fn coordinates(self) -> DVec3 {
        match self {
            Aim::Nowhere => DVec3::ZERO,
            Aim::Target(coordinates) | Aim::Direction(coordinates) => coordinates,
        }
    }
}

impl LightPose {
    pub fn put(&self, light: &mut Light) {
        match &mut light.emitter {
            Emitter::Point { position, intensity } => {
                (*position, *intensity) = (self.position.as_vec3(), self.power.as_vec3());
            }
            Emitter::Spot { position, direction, intensity, .. } => {
                (*position, *intensity) = (self.position.as_vec3(), self.power.as_vec3());
                *direction = self.direction().as_vec3();
            }
            Emitter::Directional { direction, irradiance } => {
                (*direction, *irradiance) = (self.direction().as_vec3(), self.power.as_vec3());
            }
        }
    }

    /// Unit; `None` for a light without an axis, or whose target is where the light is.
    pub fn axis(&self) -> Option<DVec3> {
        match self.aim {
            Aim::Nowhere => None,
            Aim::Target(target) => (target - self.position).try_normalize(),
            Aim::Direction(direction) => Some(direction),
        }
    }

    fn direction(&self) -> DVec3 {
        self.axis().unwrap_or(DVec3::NEG_Y)
    }
}

impl Pose for LightPose {
    /// Where the target passes through the light, it points the way it did at the last key.
    fn at(span: &Span, poses: &[Self]) -> Self {
        let last = poses[span.from];
        let [position, target, power] =
            [|pose: &Self| pose.position, |pose: &Self| pose.aim.coordinates(), |pose: &Self| pose.power]
                .map(|of| span.vector(|key| of(&poses[key])));
        let aim = match last.aim {
            Aim::Nowhere => Aim::Nowhere,
            Aim::Direction(_) => Aim::Direction(unit(span, |key| poses[key].direction())),
            Aim::Target(_) => Aim::Target(target),
        };
        let pose = LightPose { position, aim, power };
        if pose.axis().is_some() { pose } else { LightPose { aim: Aim::Direction(last.direction()), ..pose } }
    }

    fn joins(&self, other: &Self) -> bool {
        self == other
    }
}

/// A direction: its coordinates each by itself, made unit again; the last key's where they come to nothing.
fn unit(span: &Span, direction: impl Fn(usize) -> DVec3) -> DVec3 {
    let last = direction(span.from);
    if span.is_at_key() { last } else { span.vector(direction).try_normalize().unwrap_or(last) }
}
