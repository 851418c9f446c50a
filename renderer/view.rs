//! The camera as the kernels see it.

use glam::Vec3;

use crate::scene::{Camera, FilmSettings, Scene};

/// Stretches in media that scatter that are kept of each camera path.
pub const SEGMENTS: u32 = 4;

crate::gpu_struct! {
    /// The camera and the band of rows that is being rendered; see `kernels/shared/view.glsl`.
    pub struct View {
        pub position: [f32; 3],
        pub width: u32,
        pub right: [f32; 3],
        pub height: u32,
        pub up: [f32; 3],
        pub first_row: u32,
        pub forward: [f32; 3],
        pub rows: u32,
        pub medium: u32,
        pub seed: u32,
        pub pixel_angle: f32,
        pub lights: u32,
        pub background: [f32; 3],
        pub reach: f32,
        pub segments: u32,
        pub volume_samples: u32,
        pub padding0: u32,
        pub padding1: u32,
    }
}

/// Rows `first..first + count` of the picture, rendered together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Band {
    pub first: u32,
    pub count: u32,
}

impl View {
    /// A film of `width` x `height` pixels behind `camera`.
    pub fn new(camera: &Camera, film: &FilmSettings, (width, height): (u32, u32), band: Band) -> View {
        // Far from the origin, f32 may not tell a camera from its target.
        let forward = (camera.target - camera.position).try_normalize().unwrap_or(Vec3::NEG_Z);
        // Looking along `up`, any direction across serves.
        let right = forward.cross(camera.up).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
        let up = right.cross(forward);
        let half_height = (camera.fov_y.to_radians() * 0.5).tan();
        let aspect = width as f32 / height as f32;
        View {
            position: camera.position.to_array(),
            width,
            right: (right * half_height * aspect).to_array(),
            height,
            up: (up * half_height).to_array(),
            first_row: band.first,
            forward: forward.to_array(),
            rows: band.count,
            medium: camera.medium as u32,
            seed: 0,
            pixel_angle: 2.0 * half_height / height as f32,
            lights: 0,
            background: film.background.to_array(),
            reach: 0.0,
            segments: 0,
            volume_samples: film.volume_samples,
            padding0: 0,
            padding1: 0,
        }
    }

    /// The same on `scene`: its lights, how far rays are followed through its media, and whether stretches of paths in
    /// them are kept.
    pub fn of(self, scene: &Scene) -> View {
        let segments = if scene.scatters() { SEGMENTS } else { 0 };
        View { lights: scene.lights.len() as u32, reach: scene.reach(), segments, ..self }
    }
}
