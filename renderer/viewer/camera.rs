//! Camera by hand: round a point, or in flight.

use glam::{Quat, Vec2, Vec3};

use crate::scene::Camera;

/// How far from straight up or down the camera stays, in radians: nearer, "up" would turn over.
const POLE: f32 = 0.02;
/// Turned by a drag across the picture's height.
const RADIANS_PER_HEIGHT: f32 = 3.0;
/// Distance per notch of the wheel.
const ZOOM: f32 = 0.88;
/// Metres that the camera stays off its target: the way to look would be lost.
const NEAREST: f32 = 1e-3;

/// What dragging does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Control {
    /// Goes round the camera's target.
    Orbit,
    /// Looks around from where the camera is.
    Fly,
}

/// Turns by a drag of `delta`, in heights of the picture, y down.
pub fn turn(camera: &mut Camera, control: Control, delta: Vec2) {
    let arm = camera.target - camera.position;
    let angles = delta * RADIANS_PER_HEIGHT;
    match control {
        Control::Orbit => camera.position = camera.target - turned(arm, camera.up, -angles.x, -angles.y),
        Control::Fly => camera.target = camera.position + turned(arm, camera.up, angles.x * -0.5, angles.y * -0.5),
    }
}

/// Moves sideways, so that the target follows a drag of `delta` heights of the picture.
pub fn pan(camera: &mut Camera, delta: Vec2) {
    let arm = camera.target - camera.position;
    let height = 2.0 * arm.length() * (camera.fov_y.to_radians() * 0.5).tan();
    let (right, up) = across(arm, camera.up);
    shift(camera, (up * delta.y - right * delta.x) * height);
}

/// Goes nearer (positive) or farther by notches of the wheel; in flight, forward or back by a tenth of `speed` each.
pub fn zoom(camera: &mut Camera, control: Control, notches: f32, speed: f32) {
    let arm = camera.target - camera.position;
    match control {
        Control::Orbit => {
            let distance = (arm.length() * ZOOM.powf(notches)).max(NEAREST);
            camera.position = camera.target - arm.normalize_or_zero() * distance;
        }
        Control::Fly => shift(camera, arm.normalize_or_zero() * notches * 0.1 * speed),
    }
}

/// Moves by metres: x to the right, y up the world, z forward.
pub fn walk(camera: &mut Camera, metres: Vec3) {
    let arm = camera.target - camera.position;
    let (right, _) = across(arm, camera.up);
    let step = right * metres.x + camera.up.normalize_or_zero() * metres.y + arm.normalize_or_zero() * metres.z;
    shift(camera, step);
}

fn shift(camera: &mut Camera, by: Vec3) {
    camera.position += by;
    camera.target += by;
}

/// Unit vectors to the right of `arm` and up across it.
fn across(arm: Vec3, up: Vec3) -> (Vec3, Vec3) {
    let right = arm.cross(up).try_normalize().unwrap_or_else(|| arm.any_orthogonal_vector().normalize_or_zero());
    (right, right.cross(arm).normalize_or_zero())
}

/// `arm` turned by `yaw` round `up` and by `pitch` across it, and kept off the poles.
fn turned(arm: Vec3, up: Vec3, yaw: f32, pitch: f32) -> Vec3 {
    let up = up.normalize_or_zero();
    let arm = Quat::from_axis_angle(up, yaw) * arm;
    let height = arm.normalize_or_zero().dot(up).clamp(-1.0, 1.0).acos();
    let wanted = (height - pitch).clamp(POLE, std::f32::consts::PI - POLE);
    let (right, _) = across(arm, up);
    Quat::from_axis_angle(right, height - wanted) * arm
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera {
            name: String::new(),
            position: Vec3::new(0.0, 1.0, 4.0),
            target: Vec3::new(0.0, 1.0, 0.0),
            up: Vec3::Y,
            fov_y: 60.0,
            medium: 0,
        }
    }

    #[test]
    fn orbits_keep_the_distance_and_stay_off_the_poles() {
        let mut camera = camera();
        for _ in 0..50 {
            turn(&mut camera, Control::Orbit, Vec2::new(0.1, 0.2));
            let arm = camera.target - camera.position;
            assert!((arm.length() - 4.0).abs() < 1e-3, "{}", arm.length());
            assert!(arm.normalize().dot(Vec3::Y).abs() < 1.0 - 1e-5);
        }
        // Dragged down all the way, the camera looks down.
        assert!(camera.position.y > 4.9);
    }

    #[test]
    fn the_picture_follows_the_pointer() {
        // To the right: the camera goes left round its target; in flight the look itself follows.
        let mut orbit = camera();
        turn(&mut orbit, Control::Orbit, Vec2::new(0.1, 0.0));
        assert!(orbit.position.x < 0.0);
        let mut fly = camera();
        turn(&mut fly, Control::Fly, Vec2::new(0.1, 0.0));
        assert!(fly.target.x > 0.0 && fly.position == camera().position);
        let mut panned = camera();
        pan(&mut panned, Vec2::new(0.1, 0.0));
        assert!(panned.target.x < 0.0);
    }

    #[test]
    fn walking_goes_where_the_camera_looks() {
        let mut camera = camera();
        walk(&mut camera, Vec3::new(1.0, 2.0, 3.0));
        assert!((camera.position - Vec3::new(1.0, 3.0, 1.0)).length() < 1e-5);
        zoom(&mut camera, Control::Orbit, 1.0, 0.0);
        assert!(((camera.target - camera.position).length() - 4.0 * ZOOM).abs() < 1e-5);
        zoom(&mut camera, Control::Orbit, 1000.0, 0.0);
        assert!((camera.target - camera.position).length() > 0.5 * NEAREST);
    }
}
