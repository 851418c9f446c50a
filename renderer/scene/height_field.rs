//! Surfaces y = h(x, z): water from listed waves, ground from bumps and grey images, in any sum.
//!
//! All maths is in f64; a mesh is rounded to f32 once, at the end.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::Mesh;
use super::shapes::{Vertex, grid};

/// A height over the rectangle `x` by `z`, in metres, y up.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightField {
    /// First and last, first < last.
    pub x: [f64; 2],
    /// First and last, first < last.
    pub z: [f64; 2],
    /// Along x and z, at least 1.
    pub quads: [u32; 2],
    /// Added to all else.
    pub base: f64,
    pub waves: Vec<Wave>,
    pub bumps: Vec<Bump>,
    pub relief: Option<Relief>,
}

/// `amplitude` sin(k . (x, z) + `phase`), with k of length 2 pi / `wavelength`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wave {
    /// Metres, positive.
    pub wavelength: f64,
    /// Metres.
    pub amplitude: f64,
    /// Radians from +x to +z.
    pub direction: f64,
    /// Radians.
    pub phase: f64,
}

impl Wave {
    /// Along x and z, 1/m.
    pub fn wave_vector(&self) -> DVec2 {
        TAU / self.wavelength * DVec2::from_angle(self.direction)
    }
}

/// `height` exp(-r^2 / (2 `radius`^2)), r being the distance from `centre`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bump {
    /// x and z, metres.
    pub centre: DVec2,
    /// Metres; negative for a hollow.
    pub height: f64,
    /// One standard deviation, metres, positive.
    pub radius: f64,
}

/// A grey image laid over the whole rectangle; the centres of its border pixels lie on the rectangle's edges.
///
/// Catmull-Rom splines join the pixels, so that slopes and normals are continuous.
#[derive(Debug, Clone, PartialEq)]
pub struct Relief {
    /// Pixels along x, at least 2.
    pub columns: usize,
    /// Pixels along z, at least 2.
    pub rows: usize,
    /// Row 0 at the first z; `columns` x `rows` of them.
    pub values: Vec<f64>,
    /// Metres from value 0 to value 1.
    pub height: f64,
}

impl HeightField {
    /// y at (x, z), metres.
    pub fn height(&self, x: f64, z: f64) -> f64 {
        self.height_and_slope(x, z).0
    }

    /// dh/dx and dh/dz.
    pub fn slope(&self, x: f64, z: f64) -> DVec2 {
        self.height_and_slope(x, z).1
    }

    /// Unit, upward.
    pub fn normal(&self, x: f64, z: f64) -> DVec3 {
        let slope = self.slope(x, z);
        DVec3::new(-slope.x, 1.0, -slope.y).normalize()
    }

    fn height_and_slope(&self, x: f64, z: f64) -> (f64, DVec2) {
        let at = DVec2::new(x, z);
        let mut height = self.base;
        let mut slope = DVec2::ZERO;
        for wave in &self.waves {
            let k = wave.wave_vector();
            let (sin, cos) = (k.dot(at) + wave.phase).sin_cos();
            height += wave.amplitude * sin;
            slope += wave.amplitude * cos * k;
        }
        for bump in &self.bumps {
            let offset = at - bump.centre;
            let variance = bump.radius * bump.radius;
            let value = bump.height * (-0.5 * offset.length_squared() / variance).exp();
            height += value;
            slope -= value / variance * offset;
        }
        if let Some(relief) = &self.relief {
            let first = DVec2::new(self.x[0], self.z[0]);
            let size = DVec2::new(self.x[1], self.z[1]) - first;
            let (value, per_rectangle) = relief.sample((at - first) / size);
            height += value;
            slope += per_rectangle / size;
        }
        (height, slope)
    }

    /// From a vertex to its neighbours along x and z, metres.
    pub fn spacing(&self) -> DVec2 {
        DVec2::new(self.x[1] - self.x[0], self.z[1] - self.z[0]) / DVec2::from(self.quads.map(f64::from))
    }

    /// x and z of the mesh's vertices, in their order: rows along x.
    pub fn vertices(&self) -> impl Iterator<Item = (f64, f64)> {
        let [columns, rows] = self.quads;
        (0..=rows).flat_map(move |row| (0..=columns).map(move |column| self.vertex(column, row)))
    }

    fn vertex(&self, column: u32, row: u32) -> (f64, f64) {
        let u = f64::from(column) / f64::from(self.quads[0]);
        let v = f64::from(row) / f64::from(self.quads[1]);
        (self.x[0] + (self.x[1] - self.x[0]) * u, self.z[0] + (self.z[1] - self.z[0]) * v)
    }

    /// `quads` quads in rows along x; quad a = (x, z), b = (x+, z), c = (x+, z+), d = (x, z+) becomes the triangles
    /// a, d, c and a, c, b. Vertex normals are those of the exact surface.
    pub fn mesh(&self, name: &str) -> Mesh {
        let [columns, rows] = self.quads;
        grid(name, columns, rows, |column, row| {
            let u = f64::from(column) / f64::from(columns);
            let v = f64::from(row) / f64::from(rows);
            let (x, z) = self.vertex(column, row);
            let position = DVec3::new(x, self.height(x, z), z);
            Vertex { position, normal: self.normal(x, z), uv: DVec2::new(u, 1.0 - v) }
        })
    }
}

impl Relief {
    /// Height and its slope, at `at` in [0, 1]^2 of the rectangle; the border goes on outside.
    fn sample(&self, at: DVec2) -> (f64, DVec2) {
        let (column, across) = Spline::at(at.x, self.columns);
        let (row, along) = Spline::at(at.y, self.rows);
        let mut sum = DVec3::ZERO;
        for j in 0..4 {
            let y = (row + j).saturating_sub(1).min(self.rows - 1);
            for i in 0..4 {
                let x = (column + i).saturating_sub(1).min(self.columns - 1);
                let weights = DVec3::new(
                    across.value[i] * along.value[j],
                    across.slope[i] * along.value[j],
                    across.value[i] * along.slope[j],
                );
                sum += weights * self.values[y * self.columns + x];
            }
        }
        sum *= self.height;
        (sum.x, DVec2::new(sum.y, sum.z))
    }
}

/// Weights of four neighbouring pixels, and their derivatives over the whole image's width.
struct Spline {
    value: [f64; 4],
    slope: [f64; 4],
}

impl Spline {
    /// The pixel to the left of `at`, and the weights of it, of the one before and of the two after.
    fn at(at: f64, pixels: usize) -> (usize, Self) {
        let intervals = (pixels - 1) as f64;
        let place = at.clamp(0.0, 1.0) * intervals;
        let pixel = place.floor().min(intervals - 1.0);
        let t = place - pixel;
        let (t2, t3) = (t * t, t * t * t);
        let value = [-t + 2.0 * t2 - t3, 2.0 - 5.0 * t2 + 3.0 * t3, t + 4.0 * t2 - 3.0 * t3, t3 - t2];
        let slope = [-1.0 + 4.0 * t - 3.0 * t2, -10.0 * t + 9.0 * t2, 1.0 + 8.0 * t - 9.0 * t2, 3.0 * t2 - 2.0 * t];
        let value = value.map(|weight| 0.5 * weight);
        let slope = slope.map(|weight| 0.5 * weight * intervals);
        (pixel as usize, Self { value, slope })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field() -> HeightField {
        let relief = Relief {
            columns: 5,
            rows: 4,
            values: (0..20).map(|k| f64::from(k * 7 % 11) / 10.0).collect(),
            height: 0.8,
        };
        HeightField {
            x: [-2.0, 3.0],
            z: [1.0, 4.0],
            quads: [20, 12],
            base: 0.3,
            waves: vec![Wave { wavelength: 1.7, amplitude: 0.2, direction: 0.6, phase: 1.1 }],
            bumps: vec![Bump { centre: DVec2::new(0.4, 2.2), height: -0.7, radius: 0.6 }],
            relief: Some(relief),
        }
    }

    #[test]
    fn the_slope_is_the_derivative_of_the_height() {
        // Central differences of step h are off by h^2 times third derivatives, which reach some hundreds here.
        const STEP: f64 = 1e-5;
        const TOLERANCE: f64 = 1e-6;
        let field = field();
        for k in 0..50 {
            let (x, z) = (-1.9 + 0.097 * f64::from(k), 1.05 + 0.058 * f64::from(k));
            let along = |dx: f64, dz: f64| (field.height(x + dx, z + dz) - field.height(x - dx, z - dz)) / (2.0 * STEP);
            let differences = DVec2::new(along(STEP, 0.0), along(0.0, STEP));
            assert!((field.slope(x, z) - differences).length() < TOLERANCE, "{x} {z}");
        }
    }

    #[test]
    fn a_relief_passes_through_its_pixels() {
        let mut field = field();
        (field.base, field.waves, field.bumps) = (0.0, Vec::new(), Vec::new());
        let values = field.relief.as_ref().unwrap().values.clone();
        for (k, value) in values.iter().enumerate() {
            let (x, z) = (-2.0 + 5.0 * (k % 5) as f64 / 4.0, 1.0 + 3.0 * (k / 5) as f64 / 3.0);
            assert!((field.height(x, z) - 0.8 * value).abs() < 1e-12, "pixel {k}");
        }
    }

    #[test]
    fn each_quad_is_split_from_its_first_corner_to_its_third() {
        let mesh = field().mesh("field");
        assert_eq!(mesh.positions.len(), 21 * 13);
        assert_eq!(mesh.triangles.len(), 2 * 20 * 12);
        assert_eq!(mesh.triangles[..4], [[0, 21, 22], [0, 22, 1], [1, 22, 23], [1, 23, 2]]);
        let last = mesh.positions.last().unwrap();
        assert_eq!((last.x, last.z), (3.0, 4.0));
    }
}
