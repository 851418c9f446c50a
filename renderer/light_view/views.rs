//! The frusta and boxes through which lights see what is specular, in f64 and widened by what rounding may do.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3};

use super::{LAYERS, LightView};
use crate::scene::{Emitter, Scene};
use crate::technique::emission::chart::{self, Cone, Projector};
use crate::technique::emission::grid::Rectangle;
use crate::technique::emission::{Bounds, ROUNDING, Target, UPSTREAM, specular_targets, triangles};

/// Cosine of the angle from its axis up to which one frustum sees everything, 70 degrees: there a chart's unit of area is a
/// twenty-fifth of what it is on the axis. Light that goes farther round needs the faces of a cube.
pub(super) const COS_AIMED: f64 = 0.342;
/// Steps towards the farthest direction, to the middle of all: the angle is then within some 3 % of the least.
const CENTRING: u32 = 32;
/// Turns of a rectangle about its axis that are tried, over a right angle.
const TURNS: u32 = 16;
/// A turned rectangle has to be this much smaller: objects along the axes keep theirs.
const WORTH_TURNING: f64 = 0.99;

/// The views of a scene's lights, by light, each with a lattice of `resolution` x `resolution` texels a layer.
///
/// Every straight line from a light to a specular triangle runs through a view of it, save those outside a spot light's
/// cone.
pub fn light_views(scene: &Scene, resolution: u32) -> Vec<LightView> {
    let targets = specular_targets(scene);
    let bounds = Bounds::of(scene);
    let mut views = Vec::new();
    for (light, of_scene) in (0u32..).zip(&scene.lights) {
        let charts = if targets.is_empty() { Vec::new() } else { charts(&of_scene.emitter, &targets, &bounds) };
        for chart in charts {
            let first_texel = (LAYERS * views.len()) as u32 * resolution * resolution;
            views.push(LightView { light, columns: resolution, rows: resolution, first_texel, ..chart });
        }
    }
    views
}

/// Views without light and lattice.
fn charts(emitter: &Emitter, targets: &[Target], bounds: &Bounds) -> Vec<LightView> {
    if power(emitter) <= 0.0 {
        return Vec::new();
    }
    match *emitter {
        Emitter::Point { position, .. } => around(position.as_dvec3(), None, targets, bounds),
        Emitter::Spot { position, direction, outer, .. } => {
            let half_angle = (f64::from(outer) + ROUNDING).min(FRAC_PI_2);
            around(position.as_dvec3(), Some((direction.as_dvec3().normalize(), half_angle)), targets, bounds)
        }
        Emitter::Directional { direction, .. } => {
            let direction = direction.as_dvec3().normalize();
            let blur = ROUNDING * bounds.reach();
            let offset = bounds.least_along(direction) - UPSTREAM * bounds.diagonal() - blur;
            let points: Vec<DVec3> = corners(targets).collect();
            let frame = Frame::fitted(direction, false, &points);
            let reach = -bounds.least_along(-direction) - offset + blur;
            vec![frame.view(offset * direction, frame.rectangle(&points).widened(blur, None), reach)]
        }
    }
}

fn power(emitter: &Emitter) -> f32 {
    match emitter {
        Emitter::Point { intensity, .. } | Emitter::Spot { intensity, .. } => intensity.element_sum(),
        Emitter::Directional { irradiance, .. } => irradiance.element_sum(),
    }
}

fn corners<'a>(targets: &'a [Target]) -> impl Iterator<Item = DVec3> + 'a {
    triangles(targets).flatten()
}

/// The views of a point light, or of a spot light of an axis and half angle: one that is aimed, or faces of a cube.
fn around(position: DVec3, cone: Option<(DVec3, f64)>, targets: &[Target], bounds: &Bounds) -> Vec<LightView> {
    let touch = ROUNDING * bounds.reach().max(position.abs().max_element());
    let farthest = (bounds.min - position).abs().max((bounds.max - position).abs()).length() + touch;
    let touched = || triangles(targets).any(|t| chart::touches_origin(t.map(|p| p - position), touch));
    if !touched() {
        let points = seen(position, cone, targets);
        if points.is_empty() {
            return Vec::new();
        }
        if let Some(view) = aimed(position, cone, &points, touch, farthest) {
            return vec![view];
        }
    }
    let mut projector = match cone {
        None => Projector::point(position, touch, ROUNDING),
        Some((axis, half_angle)) => Projector::spot(position, axis, half_angle, touch, ROUNDING),
    };
    let mut shown = [Rectangle::EMPTY; chart::FACES];
    for triangle in triangles(targets) {
        projector.project(triangle, |face, polygon| {
            polygon.iter().for_each(|&point| shown[face].include(point));
        });
    }
    let faces = shown.iter().enumerate().filter(|(_, area)| !area.is_empty());
    let view = |(face, area): (usize, &Rectangle)| {
        let [forward, right, up] = chart::axes(face);
        let frame = Frame { right, up, forward, perspective: true };
        frame.view(position, area.widened(ROUNDING, Some(1.0)), farthest)
    };
    faces.map(view).collect()
}

/// Points, from the light's place, whose convex hull holds what can be seen of the specular triangles.
fn seen(position: DVec3, cone: Option<(DVec3, f64)>, targets: &[Target]) -> Vec<DVec3> {
    let Some((axis, half_angle)) = cone else { return corners(targets).map(|p| p - position).collect() };
    let cone = Cone::new(axis, half_angle);
    let (mut inside, mut spare, mut points) = (Vec::new(), Vec::new(), Vec::new());
    for triangle in triangles(targets) {
        let triangle = triangle.map(|p| p - position);
        inside.clear();
        inside.extend(triangle);
        cone.clip(triangle, &mut inside, &mut spare);
        points.extend_from_slice(&inside);
    }
    points
}

/// One frustum that sees all `points`; none where they lie too far round.
fn aimed(
    position: DVec3,
    cone: Option<(DVec3, f64)>,
    points: &[DVec3],
    touch: f64,
    farthest: f64,
) -> Option<LightView> {
    let axis = match cone {
        Some((axis, half_angle)) if half_angle.cos() >= COS_AIMED => axis,
        _ => middle(points),
    };
    if points.iter().any(|p| p.dot(axis) < COS_AIMED * p.length()) {
        return None;
    }
    let frame = Frame::fitted(axis, true, points);
    let rectangle = frame.rectangle(points);
    let nearest = points.iter().map(|p| p.dot(axis)).fold(f64::INFINITY, f64::min);
    let radius2 = rectangle.lower.abs().max(rectangle.upper.abs()).length_squared();
    // What moves a point sideways by `touch`, or turns an axis by a rounding, moves it this far over the chart.
    let margin = (ROUNDING + touch / nearest) * (1.0 + radius2);
    Some(frame.view(position, rectangle.widened(margin, None), farthest))
}

/// A direction about in the middle of all: the centre of the smallest cap, after Badoiu and Clarkson 2003.
fn middle(points: &[DVec3]) -> DVec3 {
    let directions: Vec<DVec3> = points.iter().map(|p| p.normalize()).collect();
    let farthest = |centre: DVec3| {
        let farther = |a: DVec3, b: DVec3| if b.dot(centre) < a.dot(centre) { b } else { a };
        directions.iter().copied().reduce(farther).unwrap_or(centre)
    };
    let mut centre = directions.iter().sum::<DVec3>().normalize_or(directions[0]);
    let mut best = (f64::NEG_INFINITY, centre);
    for step in 0..CENTRING {
        let away = farthest(centre);
        // The mean direction, where all begins, is the best where objects lie evenly round it.
        if away.dot(centre) > best.0 {
            best = (away.dot(centre), centre);
        }
        centre = (centre + (away - centre) / f64::from(step + 2)).normalize_or(centre);
    }
    best.1
}

/// The axes of a view, unit to f32.
struct Frame {
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    perspective: bool,
}

impl Frame {
    /// Along `forward`, and so turned about it that the rectangle round `points` is small.
    fn fitted(forward: DVec3, perspective: bool, points: &[DVec3]) -> Frame {
        let [right, up] = chart::plane_basis(forward);
        let unturned = Frame { right, up, forward, perspective };
        let flat: Vec<DVec2> = points.iter().map(|&p| unturned.at(p)).collect();
        let area = |turn: u32| {
            let back = DVec2::from_angle(-angle(turn));
            let mut rectangle = Rectangle::EMPTY;
            flat.iter().for_each(|&p| rectangle.include(back.rotate(p)));
            rectangle.extent().element_product()
        };
        let least = (1..TURNS).map(|turn| (turn, area(turn))).min_by(|a, b| a.1.total_cmp(&b.1));
        let turn = least.filter(|&(_, least)| least < WORTH_TURNING * area(0)).map_or(0, |(turn, _)| turn);
        let (sin, cos) = angle(turn).sin_cos();
        // Rounded, so that the rectangle is found in the coordinates that kernels work out.
        let [right, up, forward] = [cos * right + sin * up, cos * up - sin * right, forward].map(rounded);
        Frame { right, up, forward, perspective }
    }

    /// Chart coordinates of a point, which for a frustum is given from the light's place.
    fn at(&self, point: DVec3) -> DVec2 {
        let across = DVec2::new(point.dot(self.right), point.dot(self.up));
        if self.perspective { across / point.dot(self.forward) } else { across }
    }

    fn rectangle(&self, points: &[DVec3]) -> Rectangle {
        let mut rectangle = Rectangle::EMPTY;
        points.iter().for_each(|&point| rectangle.include(self.at(point)));
        rectangle
    }

    fn view(&self, origin: DVec3, rectangle: Rectangle, reach: f64) -> LightView {
        let [right, up, forward] = [self.right, self.up, self.forward].map(|axis| axis.as_vec3().to_array());
        LightView {
            origin: origin.as_vec3().to_array(),
            light: 0,
            right,
            columns: 0,
            up,
            rows: 0,
            forward,
            first_texel: 0,
            lower: rectangle.lower.as_vec2().to_array(),
            upper: rectangle.upper.as_vec2().to_array(),
            perspective: self.perspective.into(),
            reach: reach as f32,
            padding0: 0,
            padding1: 0,
        }
    }
}

fn rounded(axis: DVec3) -> DVec3 {
    axis.as_vec3().as_dvec3()
}

fn angle(turn: u32) -> f64 {
    FRAC_PI_2 * f64::from(turn) / f64::from(TURNS)
}
