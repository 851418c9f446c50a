//! Triangles with interpolated normals, and a hierarchy over where they are and where they face.

use glam::{DAffine3, DMat3, DVec2, DVec3};
use nephroid::scene::{Instance, Mesh};

/// Triangles under one node at most.
const LEAF: usize = 4;

/// A mesh in world space, metres.
///
/// The normal of a point is the linear interpolation of its corners' normals, normalised. Corners' normals of a placed
/// mesh are not unit: as in `kernels/shared/surface.glsl`, normals are interpolated before the transform's scale is
/// divided out.
pub struct Surface {
    pub positions: Vec<DVec3>,
    pub normals: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    mirrored: bool,
    order: Vec<u32>,
    nodes: Vec<Node>,
}

/// Balls around a node's corners and around their normals, which hold all that lies between the corners too.
struct Node {
    centre: DVec3,
    radius: f64,
    normal: DVec3,
    normal_radius: f64,
    content: Content,
}

enum Content {
    Inner([usize; 2]),
    Leaf(std::ops::Range<usize>),
}

/// One triangle: points `corner + alpha edges[0] + beta edges[1]`, normals likewise and not unit.
#[derive(Debug, Clone, Copy)]
pub struct Patch {
    pub corner: DVec3,
    pub edges: [DVec3; 2],
    pub normal: DVec3,
    pub turns: [DVec3; 2],
    /// Unit, on the side of the front face.
    pub geometric: DVec3,
}

impl Patch {
    pub fn position(&self, at: DVec2) -> DVec3 {
        self.corner + at.x * self.edges[0] + at.y * self.edges[1]
    }

    /// Interpolated, not unit.
    pub fn normal(&self, at: DVec2) -> DVec3 {
        self.normal + self.turn(at)
    }

    /// What the interpolated normal gains over a step in barycentrics.
    pub fn turn(&self, step: DVec2) -> DVec3 {
        step.x * self.turns[0] + step.y * self.turns[1]
    }

    /// The step in barycentrics that an offset within the plane is.
    pub fn weights(&self, offset: DVec3) -> DVec2 {
        let [a, b] = self.edges;
        let (aa, ab, bb) = (a.length_squared(), a.dot(b), b.length_squared());
        let (a, b) = (a.dot(offset), b.dot(offset));
        DVec2::new(bb * a - ab * b, aa * b - ab * a) / (aa * bb - ab * ab)
    }
}

impl Surface {
    pub fn new(positions: Vec<DVec3>, normals: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Self {
        let order = (0..triangles.len() as u32).collect();
        let mut surface = Self { positions, normals, triangles, mirrored: false, order, nodes: Vec::new() };
        surface.split(0..surface.triangles.len());
        surface
    }

    /// A mesh where its instance puts it.
    pub fn of_instance(mesh: &Mesh, instance: &Instance) -> Self {
        let m = instance.transform.matrix3;
        let matrix = DMat3::from_cols(m.x_axis.as_dvec3(), m.y_axis.as_dvec3(), m.z_axis.as_dvec3());
        Self::placed(mesh, DAffine3 { matrix3: matrix, translation: instance.transform.translation.as_dvec3() })
    }

    pub fn of_mesh(mesh: &Mesh) -> Self {
        Self::placed(mesh, DAffine3::IDENTITY)
    }

    fn placed(mesh: &Mesh, transform: DAffine3) -> Self {
        let to_normal = transform.matrix3.inverse().transpose();
        let mut surface = Self::new(
            mesh.positions.iter().map(|p| transform.transform_point3(p.as_dvec3())).collect(),
            mesh.normals.iter().map(|n| to_normal * n.as_dvec3()).collect(),
            mesh.triangles.clone(),
        );
        surface.mirrored = transform.matrix3.determinant() < 0.0;
        surface
    }

    pub fn patch(&self, triangle: usize) -> Patch {
        let corners = self.triangles[triangle].map(|i| i as usize);
        let [a, b, c] = corners.map(|i| self.positions[i]);
        let [na, nb, nc] = corners.map(|i| self.normals[i]);
        let front = (b - a).cross(c - a).normalize();
        Patch {
            corner: a,
            edges: [b - a, c - a],
            normal: na,
            turns: [nb - na, nc - na],
            geometric: if self.mirrored { -front } else { front },
        }
    }

    /// Low and high corner of the box around it.
    pub fn bounds(&self) -> [DVec3; 2] {
        let start = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        self.positions.iter().fold(start, |[low, high], &p| [low.min(p), high.max(p)])
    }

    /// The same surface from four times as many triangles: corners added in the middle of edges, with the normals that
    /// interpolation gives there.
    pub fn refined(&self) -> Self {
        let (mut positions, mut normals, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
        for &[a, b, c] in &self.triangles {
            let first = positions.len() as u32;
            for [i, j] in [[a, a], [b, b], [c, c], [a, b], [b, c], [c, a]] {
                let (i, j) = (i as usize, j as usize);
                positions.push(0.5 * (self.positions[i] + self.positions[j]));
                normals.push(0.5 * (self.normals[i] + self.normals[j]));
            }
            triangles.extend([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]].map(|t| t.map(|i| first + i)));
        }
        Self { mirrored: self.mirrored, ..Self::new(positions, normals, triangles) }
    }

    /// How often the segment from `a` to `b` crosses triangles other than `except`.
    pub fn crossings(&self, a: DVec3, b: DVec3, except: usize) -> usize {
        self.crossed(a, b).iter().filter(|(triangle, ..)| *triangle != except).count()
    }

    /// Triangles that the segment from `a` to `b` crosses, where along it (0 to 1), and where in space.
    pub fn crossed(&self, a: DVec3, b: DVec3) -> Vec<(usize, f64, DVec3)> {
        let way = b - a;
        let near = |centre: DVec3, radius: f64, _, _| {
            let along = ((centre - a).dot(way) / way.length_squared()).clamp(0.0, 1.0);
            (a + along * way).distance(centre) <= radius * (1.0 + 1e-12)
        };
        let crossed = |triangle: usize| {
            let patch = self.patch(triangle);
            let along = (patch.corner - a).dot(patch.geometric) / way.dot(patch.geometric);
            let place = a + along * way;
            let at = patch.weights(place - patch.corner);
            let inside = (0.0..=1.0).contains(&along) && at.min_element() >= 0.0 && at.x + at.y <= 1.0;
            inside.then_some((triangle, along, place))
        };
        self.candidates(near).into_iter().filter_map(crossed).collect()
    }

    /// Triangles of all leaves that `keep(centre, radius, normal, normal radius)` holds true for, and for all above.
    pub fn candidates(&self, keep: impl Fn(DVec3, f64, DVec3, f64) -> bool) -> Vec<usize> {
        let mut found = Vec::new();
        let mut stack = vec![self.nodes.len() - 1];
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index];
            if !keep(node.centre, node.radius, node.normal, node.normal_radius) {
                continue;
            }
            match &node.content {
                Content::Inner(children) => stack.extend(children),
                Content::Leaf(range) => found.extend(self.order[range.clone()].iter().map(|&t| t as usize)),
            }
        }
        found
    }

    fn split(&mut self, range: std::ops::Range<usize>) -> usize {
        let (centre, radius) = ball(self.corners(&range).map(|i| self.positions[i]));
        let (normal, normal_radius) = ball(self.corners(&range).map(|i| self.normals[i]));
        let content = if range.len() <= LEAF {
            Content::Leaf(range)
        } else {
            let middle = range.start + range.len() / 2;
            self.halve(&range);
            Content::Inner([self.split(range.start..middle), self.split(middle..range.end)])
        };
        self.nodes.push(Node { centre, radius, normal, normal_radius, content });
        self.nodes.len() - 1
    }

    fn corners(&self, range: &std::ops::Range<usize>) -> impl Iterator<Item = usize> + Clone + '_ {
        self.order[range.clone()].iter().flat_map(|&t| self.triangles[t as usize]).map(|i| i as usize)
    }

    /// Puts the triangles of the lower half, along the longest side, first.
    fn halve(&mut self, range: &std::ops::Range<usize>) {
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) =
            self.corners(range).map(|i| self.positions[i]).fold(start, |(low, high), p| (low.min(p), high.max(p)));
        let axis = (high - low).max_position();
        let Self { order, triangles, positions, .. } = self;
        let key = |t: u32| triangles[t as usize].iter().map(|&i| positions[i as usize][axis]).sum::<f64>();
        order[range.clone()].select_nth_unstable_by(range.len() / 2, |&a, &b| key(a).total_cmp(&key(b)));
    }
}

fn ball(points: impl Iterator<Item = DVec3> + Clone) -> (DVec3, f64) {
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = points.clone().fold(start, |(low, high), p| (low.min(p), high.max(p)));
    let centre = 0.5 * (low + high);
    (centre, points.map(|p| p.distance(centre)).fold(0.0, f64::max))
}
