//! Plane, box, sphere and open tube as meshes with exact normals.
//!
//! Counter-clockwise triangles face the side that the normals point to.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::Mesh;

/// A mesh vertex before it is rounded to f32.
pub struct Vertex {
    pub position: DVec3,
    /// Unit.
    pub normal: DVec3,
    pub uv: DVec2,
}

/// A sheet of `columns` x `rows` quads, both at least 1, its vertices in rows.
///
/// The quad with corners a, b along a row and d, c along the next becomes the triangles a, d, c and a, c, b: they face
/// the side from which rows run clockwise of columns.
pub fn grid(name: &str, columns: u32, rows: u32, vertex: impl Fn(u32, u32) -> Vertex) -> Mesh {
    let mut mesh = Mesh { name: name.to_owned(), ..Mesh::default() };
    for row in 0..=rows {
        for column in 0..=columns {
            let Vertex { position, normal, uv } = vertex(column, row);
            mesh.positions.push(position.as_vec3());
            // Adding 0 turns -0 into 0.
            mesh.normals.push((normal + DVec3::ZERO).as_vec3());
            mesh.uvs.push(uv.as_vec2());
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let a = row * (columns + 1) + column;
            let [b, d] = [a + 1, a + columns + 1];
            let c = d + 1;
            mesh.triangles.push([a, d, c]);
            mesh.triangles.push([a, c, b]);
        }
    }
    mesh
}

/// A horizontal rectangle around `centre`, `size` along x and z, facing +y.
pub fn plane(name: &str, centre: DVec3, size: DVec2, subdivisions: [u32; 2]) -> Mesh {
    rectangle(name, centre, size.x * DVec3::X, size.y * DVec3::Z, subdivisions)
}

/// The rectangle spanned by `across` and `along`, facing `along` x `across`.
fn rectangle(name: &str, centre: DVec3, across: DVec3, along: DVec3, subdivisions: [u32; 2]) -> Mesh {
    let normal = along.cross(across).normalize();
    let [columns, rows] = subdivisions;
    grid(name, columns, rows, |column, row| {
        let uv = DVec2::new(f64::from(column) / f64::from(columns), f64::from(row) / f64::from(rows));
        let position = centre + (uv.x - 0.5) * across + (uv.y - 0.5) * along;
        Vertex { position, normal, uv: DVec2::new(uv.x, 1.0 - uv.y) }
    })
}

/// One side of a box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Face {
    NegativeX,
    PositiveX,
    NegativeY,
    PositiveY,
    NegativeZ,
    PositiveZ,
}

impl Face {
    /// All six, each with its name in a scene file.
    pub const ALL: [(&'static str, Face); 6] = [
        ("-x", Face::NegativeX),
        ("+x", Face::PositiveX),
        ("-y", Face::NegativeY),
        ("+y", Face::PositiveY),
        ("-z", Face::NegativeZ),
        ("+z", Face::PositiveZ),
    ];

    /// Outward, then across, with the direction along being their cross product.
    fn axes(self) -> (DVec3, DVec3) {
        match self {
            Face::NegativeX => (DVec3::NEG_X, DVec3::Z),
            Face::PositiveX => (DVec3::X, DVec3::NEG_Z),
            Face::NegativeY => (DVec3::NEG_Y, DVec3::NEG_X),
            Face::PositiveY => (DVec3::Y, DVec3::X),
            Face::NegativeZ => (DVec3::NEG_Z, DVec3::NEG_X),
            Face::PositiveZ => (DVec3::Z, DVec3::X),
        }
    }
}

/// The given faces of a box, which share no vertices; `inward` turns them to the inside, as a room's walls.
pub fn cuboid(name: &str, centre: DVec3, size: DVec3, faces: &[Face], inward: bool) -> Mesh {
    let mut mesh = Mesh { name: name.to_owned(), ..Mesh::default() };
    for face in faces {
        let (outward, across) = face.axes();
        let along = across.cross(outward);
        // Seen from inside, left and right change places.
        let across = if inward { -across } else { across };
        let middle = centre + 0.5 * outward * size;
        append(&mut mesh, rectangle(name, middle, across * size, along * size, [1, 1]));
    }
    mesh
}

fn append(mesh: &mut Mesh, part: Mesh) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(part.positions);
    mesh.normals.extend(part.normals);
    mesh.uvs.extend(part.uvs);
    mesh.triangles.extend(part.triangles.iter().map(|triangle| triangle.map(|vertex| vertex + first)));
}

/// A sphere of `segments` (at least 3) meridians and half as many rings, facing outward.
///
/// Its vertices lie on the sphere, so the mesh is inside it; the vertices of the seam and poles are doubled for their
/// texture coordinates, at equal positions to the last bit.
pub fn sphere(name: &str, centre: DVec3, radius: f64, segments: u32) -> Mesh {
    let rings = (segments / 2).max(2);
    let mut mesh = grid(name, segments, rings, |column, row| {
        let latitude = match row {
            0 => DVec2::Y,
            row if row == rings => DVec2::NEG_Y,
            row => {
                let (sin, cos) = (PI * f64::from(row) / f64::from(rings)).sin_cos();
                DVec2::new(sin, cos)
            }
        };
        let around = meridian(column, segments);
        let normal = DVec3::new(latitude.x * around.x, latitude.y, latitude.x * around.z);
        Vertex { position: centre + radius * normal, normal, uv: sheet_uv(column, row, segments, rings) }
    });
    let Mesh { positions, triangles, .. } = &mut mesh;
    triangles.retain(|&[a, b, c]| {
        let [a, b, c] = [a, b, c].map(|vertex| positions[vertex as usize]);
        a != b && b != c && c != a
    });
    mesh
}

/// An open tube around the y axis through `centre`, its middle, facing outward.
pub fn cylinder(name: &str, centre: DVec3, radius: f64, height: f64, segments: u32, subdivisions: u32) -> Mesh {
    grid(name, segments, subdivisions, |column, row| {
        let normal = meridian(column, segments);
        let y = height * (0.5 - f64::from(row) / f64::from(subdivisions));
        let position = centre + radius * normal + y * DVec3::Y;
        Vertex { position, normal, uv: sheet_uv(column, row, segments, subdivisions) }
    })
}

/// Horizontal unit vector; the last column is the first one again, to the last bit.
fn meridian(column: u32, segments: u32) -> DVec3 {
    let (sin, cos) = (TAU * f64::from(column % segments) / f64::from(segments)).sin_cos();
    DVec3::new(cos, 0.0, -sin)
}

fn sheet_uv(column: u32, row: u32, columns: u32, rows: u32) -> DVec2 {
    DVec2::new(f64::from(column) / f64::from(columns), 1.0 - f64::from(row) / f64::from(rows))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::adjacency::Adjacency;

    /// f32 rounding of the positions tilts the facets by less.
    const TOLERANCE: f64 = 1e-5;

    /// Twice the signed volume between the origin and the mesh: positive where it faces outward.
    fn volume(mesh: &Mesh) -> f64 {
        let corner = |vertex: u32| mesh.positions[vertex as usize].as_dvec3();
        mesh.triangles.iter().map(|t| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0).sum()
    }

    fn faces_as_its_normals(mesh: &Mesh) {
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|vertex| mesh.positions[vertex as usize].as_dvec3());
            let front = (b - a).cross(c - a).normalize();
            for vertex in triangle {
                assert!(mesh.normals[*vertex as usize].as_dvec3().dot(front) > 0.0, "{} {triangle:?}", mesh.name);
            }
        }
    }

    #[test]
    fn a_box_is_closed_with_its_volume_and_turns_inside_out() {
        let size = DVec3::new(1.0, 2.0, 3.0);
        let faces = Face::ALL.map(|(_, face)| face);
        for (inward, sign) in [(false, 1.0), (true, -1.0)] {
            let mesh = cuboid("box", DVec3::splat(0.5), size, &faces, inward);
            faces_as_its_normals(&mesh);
            assert!(Adjacency::of(&mesh).is_closed());
            // Textures stand upright on the walls: the first vertex of each is its upper left one.
            for wall in (0..24).step_by(4).filter(|&wall| mesh.normals[wall].y == 0.0) {
                assert!(mesh.positions[wall].y > mesh.positions[wall + 2].y, "{wall}");
            }
            assert!((volume(&mesh) - sign * 6.0).abs() < TOLERANCE, "{}", volume(&mesh));
        }
    }

    #[test]
    fn a_sphere_is_closed_and_its_volume_tends_to_the_balls() {
        let mesh = sphere("sphere", DVec3::ZERO, 2.0, 64);
        faces_as_its_normals(&mesh);
        let adjacency = Adjacency::of(&mesh);
        assert!(adjacency.is_closed());
        // Chords of 64 segments fall short of the arc by pi^2 / (6 * 32^2), twice for the two directions.
        let ball = 4.0 / 3.0 * PI * 8.0;
        assert!((0.99..1.0).contains(&(volume(&mesh) / ball)), "{}", volume(&mesh) / ball);
        for (position, normal) in mesh.positions.iter().zip(&mesh.normals) {
            assert!((position.as_dvec3() - 2.0 * normal.as_dvec3()).length() < TOLERANCE);
        }
    }

    #[test]
    fn a_tube_faces_outward_and_is_open_at_both_ends() {
        let mesh = cylinder("tube", DVec3::Y, 1.0, 2.0, 48, 3);
        faces_as_its_normals(&mesh);
        let adjacency = Adjacency::of(&mesh);
        assert_eq!((adjacency.boundary_edges, adjacency.flipped_edges), (2 * 48, 0));
        let (low, high) = mesh.positions.iter().fold((9.0f32, -9.0f32), |(l, h), p| (l.min(p.y), h.max(p.y)));
        assert_eq!((low, high), (0.0, 2.0));
    }

    #[test]
    fn a_plane_faces_up() {
        let mesh = plane("plane", DVec3::ZERO, DVec2::new(4.0, 6.0), [3, 2]);
        faces_as_its_normals(&mesh);
        assert!(mesh.normals.iter().all(|normal| *normal == glam::Vec3::Y));
    }
}
