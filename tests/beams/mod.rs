//! Beams made on the host, and what they should bring, in f64.
#![allow(dead_code, reason = "each test binary uses its part")]

pub mod oracle;
pub mod stage;

use glam::{DVec3, Vec3};
use nephroid::technique::beams::beam::{Beam, BeamCorner};

/// One edge of a beam to be made.
#[derive(Debug, Clone, Copy)]
pub struct Edge {
    /// m, where the light leaves its specular surface.
    pub start: DVec3,
    /// Unit.
    pub way: DVec3,
    /// m.
    pub length: f64,
    /// m2 and so on: what the light round the edge covers, by the metres along it.
    pub area: [f64; 3],
    /// W, in that area.
    pub flux: f64,
}

impl Edge {
    /// An edge that says nothing of the light round it, so that the beam's own area counts.
    pub fn plain(start: DVec3, way: DVec3, length: f64) -> Self {
        Edge { start, way: way.normalize(), length, area: [1.0, 0.0, 0.0], flux: 1.0 }
    }
}

/// The record of the beam between three edges.
pub fn beam(edges: [Edge; 3], flux: f64, medium: u32) -> Beam {
    // As the kernels have it: what is rounded first is worked with.
    let normal = (edges[0].way + edges[1].way + edges[2].way).normalize().as_vec3().as_dvec3();
    let corner = |edge: &Edge| {
        let along = edge.way.dot(normal);
        let start = normal.dot(edge.start - edges[0].start);
        let area = edge.area.map(|a| a as f32);
        BeamCorner {
            origin: (edge.start - edge.way * (start / along)).as_vec3().to_array(),
            start: start as f32,
            way: (edge.way / along).as_vec3().to_array(),
            end: (start + edge.length * along) as f32,
            area,
            flux: edge.flux as f32,
        }
    };
    Beam {
        corners: [corner(&edges[0]), corner(&edges[1]), corner(&edges[2])],
        normal: normal.as_vec3().to_array(),
        medium,
        flux: Vec3::splat(flux as f32).to_array(),
        flags: 0,
    }
}

/// A beam from a triangle of points, along ways that need not be of length 1, down to the plane y = `floor`.
pub fn beam_to_floor(starts: [DVec3; 3], ways: [DVec3; 3], flux: f64, floor: f64) -> Beam {
    let edge = |i: usize| {
        let way = ways[i].normalize();
        Edge::plain(starts[i], way, (floor - starts[i].y) / way.y)
    };
    beam([edge(0), edge(1), edge(2)], flux, 0)
}

/// Numbers in [0, 1) that look random, the same each time.
pub struct Numbers(pub u64);

impl Numbers {
    pub fn next(&mut self) -> f64 {
        // Knuth's MMIX generator; the high bits are the good ones.
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}
