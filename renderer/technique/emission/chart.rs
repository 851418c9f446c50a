//! How a light sees a triangle: as convex polygons in the (u, v) coordinates of [`EmissionCell`](super::EmissionCell).

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

/// Six of the cube, one plane.
pub const FACES: usize = 7;
const PLANE: usize = 6;
/// Planes around a spot light's cone; they enclose 0.3 % more than the cone.
const CONE_PLANES: u32 = 32;

/// Outward axis, U and V of a cube face.
pub fn axes(face: usize) -> [DVec3; 3] {
    let [first, second, third] = [0, 1, 2].map(|i| DVec3::AXES[(face / 2 + i) % 3]);
    if face.is_multiple_of(2) { [first, second, third] } else { [-first, third, second] }
}

/// Directions that the light's plane is spanned by; the formula is Duff et al.'s (2017), in the doc of
/// [`EmissionCell`](super::EmissionCell).
pub fn plane_basis(direction: DVec3) -> [DVec3; 2] {
    let DVec3 { x, y, z } = direction;
    let s = if z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (s + z);
    [DVec3::new(1.0 + s * a * x * x, s * a * x * y, -s * x), DVec3::new(a * x * y, s + a * y * y, -y)]
}

/// A light as a projector of triangles.
pub struct Projector {
    view: View,
    buffers: Buffers,
}

enum View {
    Cube {
        position: DVec3,
        /// Of a spot light.
        cone: Option<Cone>,
        /// Metres: a triangle this near may be met in any direction.
        touch: f64,
        /// Relative rounding of the tracer.
        rounding: f64,
    },
    Plane {
        basis: [DVec3; 2],
    },
}

/// What a spot light reaches, its apex in the origin.
pub struct Cone {
    /// Unit.
    axis: DVec3,
    sin: f64,
    cos: f64,
    /// Inward normals of planes through the origin that touch it from outside.
    planes: Vec<DVec3>,
}

/// Kept between triangles so that none allocates.
#[derive(Default)]
struct Buffers {
    cone: Vec<DVec3>,
    face: Vec<DVec3>,
    spare: Vec<DVec3>,
    polygon: Vec<DVec2>,
}

impl Projector {
    /// Everything around `position` is seen. `touch` in metres: a triangle this near is taken to be met in every
    /// direction. `rounding`: what the tracer's rounding may move directions by.
    pub fn point(position: DVec3, touch: f64, rounding: f64) -> Self {
        Self::cube(position, None, touch, rounding)
    }

    /// As [`Projector::point`], but only within `half_angle` radians (at most pi/2) of `direction`.
    pub fn spot(position: DVec3, direction: DVec3, half_angle: f64, touch: f64, rounding: f64) -> Self {
        Self::cube(position, Some(Cone::new(direction.normalize(), half_angle)), touch, rounding)
    }

    pub fn directional(direction: DVec3) -> Self {
        let view = View::Plane { basis: plane_basis(direction.normalize()) };
        Projector { view, buffers: Buffers::default() }
    }

    fn cube(position: DVec3, cone: Option<Cone>, touch: f64, rounding: f64) -> Self {
        Projector { view: View::Cube { position, cone, touch, rounding }, buffers: Buffers::default() }
    }

    /// Gives `visit` each face that shows a part of the world-space triangle, and that part: one to 39 points.
    pub fn project(&mut self, triangle: [DVec3; 3], mut visit: impl FnMut(usize, &[DVec2])) {
        match &self.view {
            View::Plane { basis: [u, v] } => {
                let polygon = triangle.map(|point| DVec2::new(point.dot(*u), point.dot(*v)));
                visit(PLANE, &polygon);
            }
            View::Cube { position, cone, touch, rounding } => {
                let triangle = triangle.map(|point| point - *position);
                if touches_origin(triangle, *touch) {
                    for triangle in octahedron() {
                        project_onto_cube(triangle, cone.as_ref(), *rounding, &mut self.buffers, &mut visit);
                    }
                } else {
                    project_onto_cube(triangle, cone.as_ref(), *rounding, &mut self.buffers, &mut visit);
                }
            }
        }
    }
}

impl Cone {
    /// `axis` is unit; `half_angle` in radians, at most pi/2.
    pub fn new(axis: DVec3, half_angle: f64) -> Self {
        let ((sin, cos), [u, v]) = (half_angle.sin_cos(), plane_basis(axis));
        let plane = |i: u32| {
            let around = DVec2::from_angle(TAU * f64::from(i) / f64::from(CONE_PLANES));
            sin * axis - cos * (around.x * u + around.y * v)
        };
        Cone { axis, sin, cos, planes: (0..CONE_PLANES).map(plane).collect() }
    }

    /// Leaves of `inside`, which is `triangle`, what is in front of all planes.
    pub fn clip(&self, triangle: [DVec3; 3], inside: &mut Vec<DVec3>, spare: &mut Vec<DVec3>) {
        // Most triangles of a fine mesh are decided by these two tests: 2 million take 0.8 s instead of 1.8.
        if triangle.iter().all(|point| point.dot(self.axis) >= self.cos * point.length()) {
            return;
        }
        let sideways = triangle[0].reject_from_normalized(self.axis).normalize_or_zero();
        let tangent = self.sin * self.axis - self.cos * sideways;
        if triangle.iter().all(|point| point.dot(tangent) < 0.0) {
            inside.clear();
        }
        self.planes.iter().for_each(|&plane| clip(inside, plane, spare));
    }
}

/// Around the origin, so that it is seen in every direction.
fn octahedron() -> impl Iterator<Item = [DVec3; 3]> {
    let signs = [1.0, -1.0];
    signs.into_iter().flat_map(move |x| {
        signs.into_iter().flat_map(move |y| signs.into_iter().map(move |z| [x * DVec3::X, y * DVec3::Y, z * DVec3::Z]))
    })
}

fn project_onto_cube(
    triangle: [DVec3; 3],
    cone: Option<&Cone>,
    rounding: f64,
    buffers: &mut Buffers,
    visit: &mut impl FnMut(usize, &[DVec2]),
) {
    let Buffers { cone: inside, face: part, spare, polygon } = buffers;
    inside.clear();
    inside.extend(triangle);
    if let Some(cone) = cone {
        cone.clip(triangle, inside, spare);
    }
    let Some(&first) = inside.first() else { return };
    let only = major_face(first);
    if inside.iter().all(|&point| major_face(point) == only) {
        unproject(inside, only, polygon);
        visit(only, polygon);
        return;
    }
    for face in 0..PLANE {
        let [axis, u, v] = axes(face);
        part.clear();
        part.extend(inside.iter());
        for plane in [axis - u, axis + u, axis - v, axis + v] {
            clip(part, plane, spare);
        }
        unproject(part, face, polygon);
        // The neighbour shows such a triangle, unless it is seen edge-on: then both show a line.
        if !polygon.is_empty() && (!on_border(polygon, rounding) || is_edge_on(triangle, rounding)) {
            visit(face, polygon);
        }
    }
}

/// The face that `point` is seen through; on a border, one of them.
fn major_face(point: DVec3) -> usize {
    let size = point.abs();
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    2 * axis + usize::from(point[axis] < 0.0)
}

fn unproject(points: &[DVec3], face: usize, polygon: &mut Vec<DVec2>) {
    let [axis, u, v] = axes(face);
    polygon.clear();
    polygon.extend(points.iter().map(|point| {
        // Clipped points are off the border by rounding.
        (DVec2::new(point.dot(u), point.dot(v)) / point.dot(axis)).clamp(DVec2::NEG_ONE, DVec2::ONE)
    }));
}

/// Keeps what is in front of the plane through the origin: Sutherland and Hodgman 1974.
fn clip(polygon: &mut Vec<DVec3>, plane: DVec3, spare: &mut Vec<DVec3>) {
    if polygon.iter().all(|point| point.dot(plane) >= 0.0) {
        return;
    }
    spare.clear();
    let Some(&last) = polygon.last() else { return };
    let (mut from, mut from_height) = (last, last.dot(plane));
    for &to in polygon.iter() {
        let to_height = to.dot(plane);
        if (from_height < 0.0) != (to_height < 0.0) {
            spare.push(from.lerp(to, from_height / (from_height - to_height)));
        }
        if to_height >= 0.0 {
            spare.push(to);
        }
        (from, from_height) = (to, to_height);
    }
    std::mem::swap(polygon, spare);
}

fn on_border(polygon: &[DVec2], rounding: f64) -> bool {
    let border = 1.0 - rounding;
    [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y]
        .iter()
        .any(|&side| polygon.iter().all(|&point| point.dot(side) >= border))
}

/// Whether the origin is in the triangle's plane, as far as `rounding` lets one tell.
fn is_edge_on(triangle: [DVec3; 3], rounding: f64) -> bool {
    let normal = normal(triangle);
    normal.dot(triangle[0]).abs() <= rounding * normal.length() * triangle[0].length()
}

/// Whether the triangle comes within `distance` of the origin.
pub fn touches_origin(triangle: [DVec3; 3], distance: f64) -> bool {
    let normal = normal(triangle);
    if normal.dot(triangle[0]).powi(2) > distance * distance * normal.length_squared() {
        return false;
    }
    let [a, b, c] = triangle;
    let edges = [[a, b], [b, c], [c, a]];
    let inside = normal != DVec3::ZERO && edges.iter().all(|[from, to]| from.cross(*to).dot(normal) >= 0.0);
    inside || edges.iter().any(|&[from, to]| distance_to_segment(from, to) <= distance)
}

fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// From the origin.
fn distance_to_segment(from: DVec3, to: DVec3) -> f64 {
    let along = to - from;
    let length_squared = along.length_squared();
    let t = if length_squared > 0.0 { (-from.dot(along) / length_squared).clamp(0.0, 1.0) } else { 0.0 };
    (from + t * along).length()
}
