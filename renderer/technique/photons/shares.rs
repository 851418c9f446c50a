//! How a set's photons are shared out among the views of lights.

use crate::light_view::LightView;
use crate::random;
use crate::scene::{Emitter, Light};

crate::gpu_struct! {
    /// One view's grid of photons; see `kernels/technique/photons/trace.comp.glsl`.
    pub struct Share {
        pub first: u32,
        pub columns: u32,
        pub rows: u32,
        pub power: f32,
    }
}

/// Places along a side at which a view's power is looked up: photons are shared by it, so it need not be exact.
const POINTS: u32 = 32;
/// Photons along a side of what a workgroup follows.
const TILE: u32 = 8;

/// What leaves through the views' rectangles, about: W of the mean channel, and an upper bound of the largest one.
pub struct Power {
    pub mean: f64,
    pub bound: f64,
}

/// Of one light's view; its image, if it projects one, is taken to let everything through.
pub fn power(view: &LightView, light: &Light) -> Power {
    let (intensity, spot) = match &light.emitter {
        Emitter::Point { intensity, .. } => (*intensity, None),
        Emitter::Spot { intensity, direction, outer, .. } => (*intensity, Some((direction.normalize(), outer.cos()))),
        Emitter::Directional { irradiance, .. } => (*irradiance, None),
    };
    let [lower, upper] = [view.lower, view.upper].map(glam::Vec2::from_array);
    let extent = (upper - lower).as_dvec2();
    let [right, up, forward] = [view.right, view.up, view.forward].map(glam::Vec3::from_array);
    let (mut all, mut lit) = (0.0f64, 0.0f64);
    for index in 0..POINTS * POINTS {
        let place = (glam::UVec2::new(index % POINTS, index / POINTS).as_vec2() + 0.5) / POINTS as f32;
        let at = lower + (upper - lower) * place;
        let density = if view.perspective != 0 { f64::from(1.0 + at.length_squared()).powf(-1.5) } else { 1.0 };
        let way = (forward + at.x * right + at.y * up).normalize();
        all += density;
        lit += if spot.is_none_or(|(axis, cos_outer)| way.dot(axis) >= cos_outer) { density } else { 0.0 };
    }
    let area = extent.x * extent.y / f64::from(POINTS * POINTS);
    Power {
        mean: f64::from(intensity.element_sum() / 3.0) * lit.max(0.01 * all) * area,
        bound: f64::from(intensity.max_element()) * all * area,
    }
}

/// About `photons` of them in all, by the views' power; every view has some.
pub fn shares(views: &[LightView], powers: &[Power], photons: u32) -> Vec<Share> {
    let total: f64 = powers.iter().map(|power| power.mean).sum();
    let mut first = 0;
    let mut made = Vec::new();
    for (view, power) in views.iter().zip(powers) {
        let wanted = f64::from(photons) * power.mean / total.max(f64::MIN_POSITIVE);
        let extent = [view.upper[0] - view.lower[0], view.upper[1] - view.lower[1]].map(f64::from);
        let aspect = (extent[0] / extent[1]).clamp(0.01, 100.0);
        let tiles = |count: f64| ((count / f64::from(TILE)).round() as u32).max(1);
        let across = tiles((wanted * aspect).sqrt());
        let down = tiles(wanted / f64::from(across * TILE));
        let (columns, rows) = (across * TILE, down * TILE);
        made.push(Share { first, columns, rows, power: (power.mean / f64::from(columns * rows)) as f32 });
        first += columns * rows;
    }
    made
}

/// Photons of all shares.
pub fn photons(shares: &[Share]) -> u32 {
    shares.iter().map(|share| share.columns * share.rows).sum()
}

/// All numbers below `count`, in no order.
pub fn shuffled(count: u32, seed: u32) -> Vec<u32> {
    let mut order: Vec<u32> = (0..count).collect();
    for last in (1..count).rev() {
        // Not quite even, by one part in 2^32 / count; it need not be.
        let other = random::combine(seed, last) % (last + 1);
        order.swap(last as usize, other as usize);
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(width: f32, height: f32) -> LightView {
        LightView { lower: [-width / 2.0, 0.0], upper: [width / 2.0, height], ..bytemuck::Zeroable::zeroed() }
    }

    #[test]
    fn photons_go_by_power_and_shape() {
        let views = [view(2.0, 1.0), view(1.0, 1.0)];
        let powers = [Power { mean: 3.0, bound: 3.0 }, Power { mean: 1.0, bound: 1.0 }];
        let made = shares(&views, &powers, 1_000_000);
        // Grids are of whole tiles, so that shares are met within a tile's row.
        assert!((f64::from(photons(&made)) - 1e6).abs() < 0.02e6, "{made:?}");
        assert!((f64::from(made[0].columns * made[0].rows) - 0.75e6).abs() < 0.02e6, "{made:?}");
        assert!((f64::from(made[0].columns) / f64::from(made[0].rows) - 2.0).abs() < 0.05, "{made:?}");
        assert_eq!(made[1].first, made[0].columns * made[0].rows);
        assert!(made.iter().all(|share| share.columns % TILE == 0 && share.rows % TILE == 0), "{made:?}");
    }
}
