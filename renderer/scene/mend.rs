//! What a mesh may lack or have too much of: normals, degenerate triangles.

use glam::{DVec3, Vec3};

use super::Mesh;

/// Twice a triangle's area over the square of its longest side, below which it is a line: f32 coordinates put the
/// vertices of real slivers above 1e-8.
const LEAST_ASPECT: f64 = 1e-12;

/// Removes triangles without area and says how many there were.
pub fn drop_degenerate(mesh: &mut Mesh) -> usize {
    let before = mesh.triangles.len();
    let Mesh { positions, triangles, .. } = mesh;
    triangles.retain(|&triangle| {
        let [a, b, c] = corners(positions, triangle);
        let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
        (b - a).cross(c - a).length() > LEAST_ASPECT * longest
    });
    before - triangles.len()
}

/// The sentence for `count` dropped triangles of `what`.
pub fn dropped_warning(what: &str, count: usize) -> String {
    let noun = if count == 1 { "triangle" } else { "triangles" };
    format!("{what}: dropped {count} degenerate {noun}, which have no area")
}

/// Unit normals: the mean of the adjoining faces' normals, weighted by the faces' angles there.
///
/// `smoothing` gives each vertex the group it shares a normal with, group ids being below the number of vertices. A
/// vertex without faces gets +y.
pub fn smooth_normals(positions: &[Vec3], triangles: &[[u32; 3]], smoothing: &[u32]) -> Vec<Vec3> {
    let mut sums = vec![DVec3::ZERO; positions.len()];
    let mut any = vec![DVec3::Y; positions.len()];
    for &triangle in triangles {
        let corners = corners(positions, triangle);
        let [a, b, c] = corners;
        let Some(face) = (b - a).cross(c - a).try_normalize() else {
            continue;
        };
        for (k, &vertex) in triangle.iter().enumerate() {
            let [here, next, last] = [corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]];
            let group = smoothing[vertex as usize] as usize;
            sums[group] += (next - here).angle_between(last - here) * face;
            any[group] = face;
        }
    }
    // Two faces back to back cancel out; either is as good.
    let unit = |group: usize| {
        if sums[group].length() > 1e-9 { sums[group].normalize() } else { any[group] }
    };
    smoothing.iter().map(|&group| unit(group as usize).as_vec3()).collect()
}

/// Turns shading normals to the front of the faces around them where they point to the back, and says how many.
pub fn turn_normals(mesh: &mut Mesh) -> usize {
    let mut fronts = vec![DVec3::ZERO; mesh.positions.len()];
    for &triangle in &mesh.triangles {
        let [a, b, c] = corners(&mesh.positions, triangle);
        for vertex in triangle {
            fronts[vertex as usize] += (b - a).cross(c - a);
        }
    }
    let mut turned = 0;
    for (normal, front) in mesh.normals.iter_mut().zip(fronts) {
        if normal.as_dvec3().dot(front) < 0.0 {
            *normal = -*normal;
            turned += 1;
        }
    }
    turned
}

fn corners(positions: &[Vec3], triangle: [u32; 3]) -> [DVec3; 3] {
    triangle.map(|vertex| positions[vertex as usize].as_dvec3())
}
