//! Every point of a triangle where the half vector is parallel to the normal.
//!
//! With h the half vector and N the interpolated normal, roots are zeros of F = h x N. N is linear over the triangle and
//! h has bounded derivatives, so F is its first-order expansion up to a remainder known beforehand. A part of the
//! triangle whose expansion stays farther from zero than that is dropped. Where F changes little enough for a chord
//! iteration to contract, the part holds at most one root and the iteration finds it. All else is cut in four.

use glam::{DMat2, DVec2, DVec3};

use super::{Patch, Query};

/// Second derivatives of x / |x| are at most this over |x|^2: the largest s sqrt(4 - 3 s^2), s a sine.
const BEND: f64 = 1.1547005383792517;
/// Parts smaller than this part of the triangle are not cut: a fold closer than that is not told from a single root.
const SMALLEST: f64 = 1e-7;
/// Roots this far outside of the triangle, in barycentrics, are on its edge.
const EDGE: f64 = 1e-9;
/// Residual of a root: the sine between half vector and normal.
const PARALLEL: f64 = 1e-11;
/// Two roots of a triangle closer than this, in barycentrics, are one.
const SAME: f64 = 1e-8;
/// Parts looked at in one triangle; a hundred are usual.
const MOST: usize = 1_000_000;

/// The triangle in metres along two unit axes of its plane, so that lengths in its chart are lengths in space.
struct Chart<'a> {
    patch: &'a Patch,
    query: &'a Query,
    axes: [DVec3; 2],
    turns: [DVec3; 2],
    /// At least how much the normal changes over a metre.
    spin: f64,
    to_barycentrics: DMat2,
}

/// F and its derivatives at a point, seen along the normal there, and what bounds them nearby.
struct Expansion {
    value: DVec2,
    slope: DMat2,
    half_slope: f64,
    normal_size: f64,
    legs: [(f64, f64); 2],
}

/// Barycentrics of all roots of F in the triangle, edges included.
pub fn find(patch: &Patch, query: &Query) -> Vec<DVec2> {
    assert!(query.point_index != query.light_index, "without a change of index any crossing goes straight");
    let chart = Chart::new(patch, query);
    let corners = [DVec3::ZERO, patch.edges[0], patch.edges[1]].map(|e| chart.axes.map(|axis| axis.dot(e)).into());
    let (_, whole) = around(&corners);
    let mut roots: Vec<DVec2> = Vec::new();
    let mut parts: Vec<[DVec2; 3]> = vec![corners];
    let mut looked_at = 0;
    while let Some(part) = parts.pop() {
        looked_at += 1;
        assert!(looked_at < MOST, "no bound separates the roots of {patch:?} for {query:?}");
        let (centre, radius) = around(&part);
        let expansion = chart.expand(centre);
        if distance_to_triangle(part.map(|corner| expansion.at(corner - centre))) > expansion.remainder(radius, &chart)
        {
            continue;
        }
        let root = if expansion.contracts(radius, &chart) {
            chart.chord(centre, radius, &expansion)
        } else if radius < SMALLEST * whole {
            chart.newton(centre)
        } else {
            parts.extend(quarters(part));
            None
        };
        let at = root.map(|root| chart.to_barycentrics * root).filter(|&at| chart.is_root(at));
        roots.extend(at.filter(|&at| roots.iter().all(|other| other.distance(at) > SAME)));
    }
    roots
}

impl<'a> Chart<'a> {
    fn new(patch: &'a Patch, query: &'a Query) -> Self {
        let x = patch.edges[0].normalize();
        let axes = [x, patch.geometric.cross(x)];
        let [a, b] = axes.map(|axis| patch.weights(axis));
        let turns = [a, b].map(|step| patch.turn(step));
        let spin = (turns[0].length_squared() + turns[1].length_squared()).sqrt();
        Self { patch, query, axes, turns, spin, to_barycentrics: DMat2::from_cols(a, b) }
    }

    fn expand(&self, at: DVec2) -> Expansion {
        let place = self.patch.corner + at.x * self.axes[0] + at.y * self.axes[1];
        let normal = self.patch.normal + at.x * self.turns[0] + at.y * self.turns[1];
        let (to_point, point_leg) = self.query.toward_point(place);
        let (to_light, light_leg) = self.query.toward_light(place);
        let legs = [(self.query.point_index, point_leg), (self.query.light_index, light_leg)];
        let half = self.query.point_index * to_point + self.query.light_index * to_light;
        let half_change = |step: DVec3| {
            (to_point * to_point.dot(step) - step) * (self.query.point_index / point_leg)
                + (to_light * to_light.dot(step) - step) * (self.query.light_index / light_leg)
        };
        let side = normal.normalize().any_orthonormal_vector();
        let sides = [side, normal.normalize().cross(side)];
        let seen = |v: DVec3| DVec2::from(sides.map(|side| side.dot(v)));
        let column = |i: usize| seen(half_change(self.axes[i]).cross(normal) + half.cross(self.turns[i]));
        Expansion {
            value: seen(half.cross(normal)),
            slope: DMat2::from_cols(column(0), column(1)),
            half_slope: legs.map(|(index, leg)| index / leg).iter().sum(),
            normal_size: normal.length(),
            legs,
        }
    }

    /// x - S^-1 F(x) with the slope S of the centre: whoever contracts within twice the radius gets to the part's root.
    fn chord(&self, centre: DVec2, radius: f64, expansion: &Expansion) -> Option<DVec2> {
        let back = expansion.slope.inverse();
        let normal = self.patch.normal + centre.x * self.turns[0] + centre.y * self.turns[1];
        let side = normal.normalize().any_orthonormal_vector();
        let sides = [side, normal.normalize().cross(side)];
        let mut at = centre;
        // The step halves at least, so 20 leave a millionth of the radius.
        for _ in 0..20 {
            let f = self.field(at);
            at -= back * DVec2::from(sides.map(|side| side.dot(f)));
            if at.distance(centre) > 2.0 * radius {
                return None;
            }
        }
        self.newton(at)
    }

    fn newton(&self, start: DVec2) -> Option<DVec2> {
        let mut at = start;
        for _ in 0..50 {
            let expansion = self.expand(at);
            let step = expansion.slope.inverse() * expansion.value;
            at -= step;
            if !at.is_finite() {
                return None;
            }
            if (self.to_barycentrics * step).length() < 1e-15 {
                break;
            }
        }
        Some(at)
    }

    fn field(&self, at: DVec2) -> DVec3 {
        let place = self.patch.corner + at.x * self.axes[0] + at.y * self.axes[1];
        self.query.half(place).cross(self.patch.normal + at.x * self.turns[0] + at.y * self.turns[1])
    }

    fn is_root(&self, at: DVec2) -> bool {
        let half = self.query.half(self.patch.position(at));
        let normal = self.patch.normal(at);
        let inside = at.min_element() >= -EDGE && at.x + at.y <= 1.0 + EDGE;
        inside && half.cross(normal).length() <= PARALLEL * half.length() * normal.length()
    }
}

impl Expansion {
    fn at(&self, step: DVec2) -> DVec2 {
        self.value + self.slope * step
    }

    /// Bound on the half vector's second derivative within `reach`.
    fn half_bend(&self, reach: f64) -> f64 {
        let bend = |&(index, leg): &(f64, f64)| {
            if leg > reach { index * BEND / ((leg - reach) * (leg - reach)) } else { f64::INFINITY }
        };
        self.legs.iter().map(bend).sum()
    }

    /// Bound on F less its expansion: with h = h0 + Hs + e and N = N0 + Bs, what is left is Hs x Bs + e x N.
    fn remainder(&self, radius: f64, chart: &Chart) -> f64 {
        let normal = self.normal_size + chart.spin * radius;
        radius * radius * (self.half_slope * chart.spin + 0.5 * self.half_bend(radius) * normal)
    }

    /// Whether within twice the radius the slope differs from the one here by less than half its least stretch.
    fn contracts(&self, radius: f64, chart: &Chart) -> bool {
        let reach = 2.0 * radius;
        let bend = self.half_bend(reach);
        let normal = self.normal_size + chart.spin * reach;
        let change = reach * (bend * normal + 2.0 * self.half_slope * chart.spin + 0.5 * bend * reach * chart.spin);
        change < 0.5 * least_stretch(self.slope)
    }
}

/// The smaller singular value.
fn least_stretch(m: DMat2) -> f64 {
    let squares = m.x_axis.length_squared() + m.y_axis.length_squared();
    let determinant = m.determinant().abs();
    let root = (squares * squares - 4.0 * determinant * determinant).max(0.0).sqrt();
    let largest = (0.5 * (squares + root)).sqrt();
    if largest > 0.0 { determinant / largest } else { 0.0 }
}

fn around(part: &[DVec2; 3]) -> (DVec2, f64) {
    let centre = (part[0] + part[1] + part[2]) / 3.0;
    (centre, part.iter().map(|corner| corner.distance(centre)).fold(0.0, f64::max))
}

fn quarters([a, b, c]: [DVec2; 3]) -> [[DVec2; 3]; 4] {
    let (ab, bc, ca) = (0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a));
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}

/// From the origin; 0 inside.
fn distance_to_triangle(corners: [DVec2; 3]) -> f64 {
    let edges = [(0, 1), (1, 2), (2, 0)].map(|(i, j)| (corners[i], corners[j]));
    let sides = edges.map(|(a, b)| a.perp_dot(b));
    if sides.iter().all(|&s| s > 0.0) || sides.iter().all(|&s| s < 0.0) {
        return 0.0;
    }
    let to_segment = |(a, b): (DVec2, DVec2)| {
        let way = b - a;
        let along = (-a.dot(way) / way.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (a + along * way).length()
    };
    edges.map(to_segment).into_iter().fold(f64::INFINITY, f64::min)
}
