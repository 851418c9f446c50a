//! Which paths a walk along the coplanarity curve can reach from where the straight line meets the surface.
//!
//! The curve is drawn, not walked: every triangle is cut into small ones, the constraint's sign is taken at their
//! corners, and edges that change sign are joined through the small triangles between them. What is joined to the start
//! is its component. Two strands closer than a small triangle can be joined the wrong way.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use super::{Light, Patch, Path, Query, Surface};

/// A corner of a small triangle: on a corner or edge of the mesh whoever shares it gives it the same name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
enum Corner {
    Mesh(usize),
    Edge(usize, usize, u32),
    Inside(usize, u32, u32),
}

/// Places where the curve crosses edges of small triangles, and which are on one component.
#[derive(Default)]
struct Drawing {
    names: HashMap<[Corner; 2], usize>,
    places: Vec<DVec3>,
    parents: Vec<usize>,
}

/// For each path whether it is on the curve's component through the start, the first crossing of the straight way from
/// the point to the light. Every triangle's edge is cut into `cuts`. `None` where the straight way misses the surface,
/// or the start or a path is farther than a triangle's edge from anything drawn.
pub fn on_start_curve(surface: &Surface, query: &Query, paths: &[Path], cuts: u32) -> Option<Vec<bool>> {
    let start = start(surface, query)?;
    let mut drawing = Drawing::draw(surface, query, cuts);
    let patch = surface.patch(0);
    let near = patch.edges[0].length().max(patch.edges[1].length());
    let start = drawing.component(start, near)?;
    paths.iter().map(|path| Some(drawing.component(path.point, near)? == start)).collect()
}

/// Where the straight way from the point to the light first meets the surface.
pub fn start(surface: &Surface, query: &Query) -> Option<DVec3> {
    let [low, high] = surface.bounds();
    let far = (high - low).length() + query.point.distance(low);
    let end = match query.light {
        Light::Point(position) => position,
        Light::Directional(direction) => query.point - far * direction,
    };
    surface.crossed(query.point, end).into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).map(|(_, _, place)| place)
}

/// n . (PM x LM), the coplanarity constraint before anything is normalised; LM has any length for a directional light.
fn constraint(patch: &Patch, query: &Query, at: DVec2) -> f64 {
    let place = patch.position(at);
    let from_light = match query.light {
        Light::Point(position) => place - position,
        Light::Directional(direction) => direction,
    };
    patch.normal(at).dot((place - query.point).cross(from_light))
}

impl Drawing {
    fn draw(surface: &Surface, query: &Query, cuts: u32) -> Self {
        let mut drawing = Self::default();
        let welded = weld(&surface.positions);
        for (triangle, corners) in surface.triangles.iter().enumerate() {
            let patch = surface.patch(triangle);
            let corners = corners.map(|i| welded[i as usize]);
            let at = |i: u32, j: u32| DVec2::new(f64::from(i), f64::from(j)) / f64::from(cuts);
            let value = |i, j| constraint(&patch, query, at(i, j));
            let grid = || (0..=cuts).flat_map(|i| (0..=cuts - i).map(move |j| (i, j)));
            let values: HashMap<(u32, u32), f64> = grid().map(|(i, j)| ((i, j), value(i, j))).collect();
            if values.values().all(|&v| v >= 0.0) || values.values().all(|&v| v < 0.0) {
                continue;
            }
            let small = grid().filter(|(i, j)| i + j < cuts).flat_map(|(i, j)| {
                let upper = (i + j + 2 <= cuts).then_some([(i + 1, j), (i + 1, j + 1), (i, j + 1)]);
                [Some([(i, j), (i + 1, j), (i, j + 1)]), upper]
            });
            for [a, b, c] in small.flatten() {
                let crossed: Vec<usize> = [[a, b], [b, c], [c, a]]
                    .into_iter()
                    .filter(|edge| (values[&edge[0]] < 0.0) != (values[&edge[1]] < 0.0))
                    .map(|edge| {
                        let [first, second] = edge.map(|corner| values[&corner]);
                        let [from, to] = edge.map(|(i, j)| patch.position(at(i, j)));
                        let place = from + first / (first - second) * (to - from);
                        drawing.node(edge.map(|(i, j)| name(triangle, corners, cuts, i, j)), place)
                    })
                    .collect();
                if let [first, second] = crossed[..] {
                    drawing.join(first, second);
                }
            }
        }
        drawing
    }

    fn node(&mut self, mut edge: [Corner; 2], place: DVec3) -> usize {
        edge.sort();
        *self.names.entry(edge).or_insert_with(|| {
            self.places.push(place);
            self.parents.push(self.parents.len());
            self.parents.len() - 1
        })
    }

    fn root(&mut self, mut node: usize) -> usize {
        while self.parents[node] != node {
            self.parents[node] = self.parents[self.parents[node]];
            node = self.parents[node];
        }
        node
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a] = b;
    }

    /// The component drawn nearest to a place.
    fn component(&mut self, place: DVec3, near: f64) -> Option<usize> {
        let distance = |i: &usize| self.places[*i].distance_squared(place);
        let nearest = (0..self.places.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        (distance(&nearest) < near * near).then(|| self.root(nearest))
    }
}

fn name(triangle: usize, [a, b, c]: [usize; 3], cuts: u32, i: u32, j: u32) -> Corner {
    let on_edge = |from: usize, to: usize, step: u32| {
        if from < to { Corner::Edge(from, to, step) } else { Corner::Edge(to, from, cuts - step) }
    };
    match (i, j, cuts - i - j) {
        (0, 0, _) => Corner::Mesh(a),
        (_, 0, 0) => Corner::Mesh(b),
        (0, _, 0) => Corner::Mesh(c),
        (i, 0, _) => on_edge(a, b, i),
        (0, j, _) => on_edge(a, c, j),
        (_, j, 0) => on_edge(b, c, j),
        (i, j, _) => Corner::Inside(triangle, i, j),
    }
}

/// For each position the first one equal to it.
fn weld(positions: &[DVec3]) -> Vec<usize> {
    let mut first = HashMap::new();
    let key = |p: &DVec3| p.to_array().map(|x| (x + 0.0).to_bits());
    positions.iter().enumerate().map(|(i, p)| *first.entry(key(p)).or_insert(i)).collect()
}
