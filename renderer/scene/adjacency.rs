//! Which triangles meet at each edge of a mesh.

use glam::Vec3;

use super::Mesh;

/// What lies across one edge of a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Neighbour {
    /// Nothing; or the edge has no length.
    Boundary,
    /// The one other triangle there.
    Triangle(u32),
    /// More than one other triangle: a place in [`Adjacency::non_manifold`].
    NonManifold(u32),
}

/// The neighbours of every triangle of a mesh, closed or open.
///
/// Vertices at equal positions count as one, so that split normals and texture coordinates do not tear the surface.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Adjacency {
    /// For triangle [a, b, c], across the edges ab, bc and ca.
    pub neighbours: Vec<[Neighbour; 3]>,
    /// The triangles at each edge that has more than two, in ascending order.
    pub non_manifold: Vec<Vec<u32>>,
    /// Edges with one triangle.
    pub boundary_edges: usize,
    /// Edges with exactly two triangles.
    pub inner_edges: usize,
    /// Those inner edges whose two triangles face different sides.
    pub flipped_edges: usize,
}

/// A triangle's side; ordered so that the sides of one edge come together, in the order of triangles.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    /// Welded vertices, the lower first.
    ends: [u32; 2],
    triangle: u32,
    /// 0, 1 or 2.
    place: u8,
    /// Whether the triangle runs from the lower end to the higher.
    upward: bool,
}

impl Adjacency {
    /// Works in O(n log n); equal meshes give equal results.
    pub fn of(mesh: &Mesh) -> Self {
        let welded = weld(&mesh.positions);
        let sides = sorted_sides(&mesh.triangles, &welded);
        let mut adjacency =
            Adjacency { neighbours: vec![[Neighbour::Boundary; 3]; mesh.triangles.len()], ..Self::default() };
        for edge in sides.chunk_by(|a, b| a.ends == b.ends) {
            adjacency.join(edge);
        }
        adjacency
    }

    /// All edges, each counted once.
    pub fn edges(&self) -> usize {
        self.boundary_edges + self.inner_edges + self.non_manifold.len()
    }

    /// Whether every edge has two triangles that face the same side.
    pub fn is_closed(&self) -> bool {
        self.boundary_edges == 0 && self.non_manifold.is_empty() && self.flipped_edges == 0
    }

    fn join(&mut self, edge: &[Side]) {
        match edge {
            [] => {}
            [_] => self.boundary_edges += 1,
            [a, b] => {
                self.inner_edges += 1;
                self.flipped_edges += usize::from(a.upward == b.upward);
                self.set(a, Neighbour::Triangle(b.triangle));
                self.set(b, Neighbour::Triangle(a.triangle));
            }
            many => {
                let place = self.non_manifold.len() as u32;
                many.iter().for_each(|side| self.set(side, Neighbour::NonManifold(place)));
                self.non_manifold.push(many.iter().map(|side| side.triangle).collect());
            }
        }
    }

    fn set(&mut self, side: &Side, neighbour: Neighbour) {
        self.neighbours[side.triangle as usize][usize::from(side.place)] = neighbour;
    }
}

/// For each position the first vertex that is exactly there.
pub fn weld(positions: &[Vec3]) -> Vec<u32> {
    // Adding 0 makes -0 and 0 the same bits.
    let bits = |vertex: u32| (positions[vertex as usize] + Vec3::ZERO).to_array().map(f32::to_bits);
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    order.sort_unstable_by_key(|&vertex| (bits(vertex), vertex));
    let mut welded = vec![0; positions.len()];
    for same in order.chunk_by(|&a, &b| bits(a) == bits(b)) {
        for &vertex in same {
            welded[vertex as usize] = same[0];
        }
    }
    welded
}

fn sorted_sides(triangles: &[[u32; 3]], welded: &[u32]) -> Vec<Side> {
    let mut sides = Vec::with_capacity(3 * triangles.len());
    for (triangle, vertices) in triangles.iter().enumerate() {
        let ends = vertices.map(|vertex| welded[vertex as usize]);
        for place in 0..3 {
            let [from, to] = [ends[place], ends[(place + 1) % 3]];
            if from != to {
                let ends = [from.min(to), from.max(to)];
                sides.push(Side { ends, triangle: triangle as u32, place: place as u8, upward: from < to });
            }
        }
    }
    sides.sort_unstable();
    sides
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::scene::shapes::{plane, sphere};

    fn mesh(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Mesh {
        let positions = positions.iter().map(|&position| Vec3::from_array(position)).collect();
        Mesh { positions, triangles: triangles.to_vec(), ..Mesh::default() }
    }

    #[test]
    fn a_sphere_has_eulers_characteristic_two() {
        let mesh = sphere("sphere", DVec3::ONE, 1.0, 24);
        let adjacency = Adjacency::of(&mesh);
        let mut welded = weld(&mesh.positions);
        welded.sort_unstable();
        welded.dedup();
        assert!(adjacency.is_closed());
        assert_eq!(welded.len() + mesh.triangles.len(), adjacency.edges() + 2);
    }

    #[test]
    fn a_grid_has_its_rim_as_boundary() {
        let (columns, rows) = (7, 4);
        let adjacency = Adjacency::of(&plane("plane", DVec3::ZERO, DVec2::ONE, [columns, rows]));
        let (columns, rows) = (columns as usize, rows as usize);
        assert_eq!(adjacency.boundary_edges, 2 * (columns + rows));
        assert_eq!(adjacency.inner_edges, 3 * columns * rows - columns - rows);
        assert_eq!((adjacency.non_manifold.len(), adjacency.flipped_edges), (0, 0));
        // Triangles a, d, c and a, c, b of the first quad: they meet in ac; ad and ab lie on the rim.
        assert_eq!(adjacency.neighbours[0][0], Neighbour::Boundary);
        assert_eq!(adjacency.neighbours[0][2], Neighbour::Triangle(1));
        assert_eq!(adjacency.neighbours[1], [Neighbour::Triangle(0), Neighbour::Triangle(2), Neighbour::Boundary]);
    }

    #[test]
    fn three_triangles_at_an_edge_are_listed() {
        let positions = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        let adjacency = Adjacency::of(&mesh(&positions, &[[0, 1, 2], [1, 0, 3], [0, 1, 4]]));
        assert_eq!(adjacency.non_manifold, [[0, 1, 2]]);
        assert_eq!((adjacency.boundary_edges, adjacency.inner_edges), (6, 0));
        assert!(adjacency.neighbours.iter().all(|edges| edges[0] == Neighbour::NonManifold(0)));
        assert!(!adjacency.is_closed());
    }

    #[test]
    fn vertices_at_one_place_are_one_whatever_the_sign_of_zero() {
        let positions =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, -0.0, 0.0], [1.0, 1.0, 0.0], [-0.0, 1.0, 0.0]];
        let adjacency = Adjacency::of(&mesh(&positions, &[[0, 1, 2], [3, 4, 5]]));
        assert_eq!((adjacency.boundary_edges, adjacency.inner_edges, adjacency.flipped_edges), (4, 1, 0));
        assert_eq!(adjacency.neighbours[0][1], Neighbour::Triangle(1));
        assert_eq!(adjacency.neighbours[1][2], Neighbour::Triangle(0));
    }

    #[test]
    fn a_neighbour_that_faces_the_other_side_is_counted() {
        let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        let adjacency = Adjacency::of(&mesh(&positions, &[[0, 1, 2], [1, 2, 3]]));
        assert_eq!((adjacency.inner_edges, adjacency.flipped_edges), (1, 1));
    }
}
