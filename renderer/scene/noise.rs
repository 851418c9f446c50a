//! Noise that makes clouds and smoke.

use glam::{DVec3, IVec3};

use crate::random::combine;

/// Octaves of gradient noise.
pub(super) struct Noise {
    /// Metres between the gradients of the coarsest octave, the size of the largest features.
    pub cell: f64,
    /// Each with half the cells and half the strength of the one before.
    pub octaves: u32,
    /// Of noise from 0 to 1 with mean 1/2, what is empty.
    pub threshold: f64,
    pub seed: u32,
}

impl Noise {
    /// From 0 to 1.
    pub fn density(&self, at: DVec3) -> f64 {
        let (mut sum, mut strength, mut size) = (0.0, 1.0, self.cell);
        let mut strengths = 0.0;
        for octave in 0..self.octaves {
            sum += strength * gradient_noise(at / size, combine(self.seed, octave));
            strengths += strength;
            strength *= 0.5;
            size *= 0.5;
        }
        let value = (0.5 + sum / strengths).clamp(0.0, 1.0);
        ((value - self.threshold) / (1.0 - self.threshold)).max(0.0)
    }
}

/// Perlin's noise (2002) with hashed gradients, from -1 to 1, of standard deviation 1/4; 0 at whole numbers.
fn gradient_noise(at: DVec3, seed: u32) -> f64 {
    let cell = at.floor();
    let part = at - cell;
    let corner = cell.as_ivec3();
    let ease = part * part * part * (part * (part * 6.0 - 15.0) + 10.0);
    let mut sum = 0.0;
    for k in 0..8 {
        let step = IVec3::new(k & 1, k >> 1 & 1, k >> 2);
        let weight = DVec3::select(step.cmpeq(IVec3::ONE), ease, 1.0 - ease).element_product();
        // Far from the origin whole numbers wrap, which no one sees.
        sum += weight * gradient(corner.wrapping_add(step), seed).dot(part - step.as_dvec3());
    }
    sum
}

/// To the middle of one of a cube's twelve edges.
fn gradient(corner: IVec3, seed: u32) -> DVec3 {
    let [x, y, z] = corner.to_array().map(|c| c as u32);
    let hash = combine(combine(combine(seed, x), y), z);
    let sign = |bit: u32| if hash >> bit & 1 == 0 { 1.0 } else { -1.0 };
    let (first, second) = (sign(0), sign(1));
    match (hash >> 2) % 3 {
        0 => DVec3::new(first, second, 0.0),
        1 => DVec3::new(first, 0.0, second),
        _ => DVec3::new(0.0, first, second),
    }
}
