//! Optical paths from a light through one plane or line, in f64: what `kernels/technique/eikonal/path.glsl` is checked
//! against.

use glam::DVec3;

/// Where light comes from and what it goes through.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Source {
    /// A point light at a place, in a medium of that refractive index.
    Point { position: DVec3, index: f64 },
    /// Parallel light along a unit direction, in a medium of that index; its path is 0 at the origin.
    Directional { direction: DVec3, index: f64 },
    /// The paper's: 0 on the surface, as if the index below were infinite.
    Surface,
}

impl Source {
    /// The path as far as `at`, metres times index.
    pub fn path_to(&self, at: DVec3) -> f64 {
        match *self {
            Source::Point { position, index } => index * position.distance(at),
            Source::Directional { direction, index } => index * direction.dot(at),
            Source::Surface => 0.0,
        }
    }

    /// Of the medium that it comes through; 0 of the paper's.
    pub fn index(&self) -> f64 {
        match *self {
            Source::Point { index, .. } | Source::Directional { index, .. } => index,
            Source::Surface => 0.0,
        }
    }

    /// Its gradient at `at`.
    fn gradient(&self, at: DVec3) -> DVec3 {
        match *self {
            Source::Point { position, index } => index * (at - position).normalize_or_zero(),
            Source::Directional { direction, index } => index * direction,
            Source::Surface => DVec3::ZERO,
        }
    }

    /// The shortest path to `to` through the plane at `on` with unit `normal`, `beyond` being the index on the side of `to`; and
    /// where it crosses the plane.
    pub fn through_plane(&self, on: DVec3, normal: DVec3, to: DVec3, beyond: f64) -> (f64, DVec3) {
        let foot = to - normal * normal.dot(to - on);
        let across = match *self {
            Source::Point { position, .. } => (position - to).reject_from_normalized(normal),
            _ => self.gradient(to).reject_from_normalized(normal) * -1.0,
        };
        let Some(along) = across.try_normalize() else { return (self.total(foot, to, beyond), foot) };
        // The path is convex along the plane, so its slope has one zero; it lies between the two feet.
        let slope = |t: f64| {
            let at = foot + t * along;
            (self.gradient(at) + beyond * (at - to).normalize_or_zero()).dot(along)
        };
        let (mut low, mut high) = match *self {
            Source::Point { .. } => (0.0, across.length()),
            _ => (0.0, 1e3 * to.distance(foot)),
        };
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if slope(middle) < 0.0 { low = middle } else { high = middle }
        }
        let at = foot + 0.5 * (low + high) * along;
        (self.total(at, to, beyond), at)
    }

    fn total(&self, at: DVec3, to: DVec3, beyond: f64) -> f64 {
        self.path_to(at) + beyond * at.distance(to)
    }
}
