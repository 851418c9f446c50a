//! Which medium a point is in, for a camera that is moved by hand through the water's surface.

use glam::Vec3;

use crate::scene::{MediumId, Scene, Surface};

/// Triangles are so much larger than they are, in barycentrics: a camera straight below an edge must not see through it.
const EDGE: f32 = 1e-4;

/// The medium at a point: that on the near side of the first interface in some direction. `None` where no interface is
/// met in any of them.
pub fn at(scene: &Scene, point: Vec3) -> Option<MediumId> {
    [Vec3::Y, Vec3::NEG_Y, Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z]
        .into_iter()
        .find_map(|direction| along(scene, point, direction))
}

fn along(scene: &Scene, from: Vec3, direction: Vec3) -> Option<MediumId> {
    let mut nearest = (f32::INFINITY, None);
    for instance in &scene.instances {
        let Surface::Dielectric { front, back } = scene.materials[instance.material].surface else { continue };
        // In the object's space, where one step along the ray is as far as in the world.
        let to_object = instance.transform.inverse();
        let (origin, ray) = (to_object.transform_point3(from), to_object.transform_vector3(direction));
        let mesh = &scene.meshes[instance.mesh];
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|index| mesh.positions[index as usize]);
            let (u, v) = (b - a, c - a);
            let normal = u.cross(v);
            let slope = ray.dot(normal);
            let t = (a - origin).dot(normal) / slope;
            // A slope of 0 makes t infinite or not a number.
            if !(t > 0.0 && t < nearest.0) {
                continue;
            }
            let p = origin + ray * t - a;
            let area = normal.length_squared();
            let (s, r) = (p.cross(v).dot(normal) / area, u.cross(p).dot(normal) / area);
            if s >= -EDGE && r >= -EDGE && s + r <= 1.0 + EDGE {
                nearest = (t, Some(if slope < 0.0 { front } else { back }));
            }
        }
    }
    nearest.1
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn cameras_of_shipped_scenes_are_in_the_media_that_their_files_name() {
        for name in ["pool", "flat_water", "lagoon", "glass_sphere", "cornell_flooded"] {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{name}.toml"));
            let scene = crate::scene::load(&path).unwrap();
            for camera in &scene.cameras {
                // Not every scene has an interface in one of the directions.
                let found = at(&scene, camera.position).unwrap_or(camera.medium);
                assert_eq!(found, camera.medium, "{name} {}", camera.name);
            }
            if ["pool", "lagoon"].contains(&name) {
                assert!(scene.cameras.iter().all(|camera| at(&scene, camera.position).is_some()), "{name}");
            }
        }
    }
}
