//! What a spot light sends where: full inside a cone, none outside another, and times an image where it projects one.

use glam::{DVec2, DVec3};

use super::{chart, solid_angle};
use crate::gpu_scene::stored_texel;
use crate::scene::{Emitter, SpotImage, Texture};

/// Points at which a light's fall-off is taken, over all of its cells.
const FALL_OFF_POINTS: f64 = 262_144.0;
/// The same where it has an image, which may be a thousand texels wide.
const IMAGE_POINTS: f64 = 1_048_576.0;

/// Relative to the light's intensity.
pub struct SpotPattern {
    direction: DVec3,
    cos_inner: f64,
    cos_outer: f64,
    slide: Option<Slide>,
}

/// An image in the light.
struct Slide {
    right: DVec3,
    up: DVec3,
    /// One metre from the light.
    half_width: f64,
    width: usize,
    height: usize,
    /// Row 0 on top.
    texels: Vec<DVec3>,
}

impl SpotPattern {
    /// `None` for another light.
    pub fn of(emitter: &Emitter, textures: &[Texture]) -> Option<Self> {
        let Emitter::Spot { direction, inner, outer, image, .. } = *emitter else { return None };
        let direction = direction.as_dvec3().normalize();
        let [cos_inner, cos_outer] = [inner, outer].map(|angle| f64::from(angle).cos());
        let slide = image.map(|image| Slide::new(image, &textures[image.texture], direction, f64::from(outer)));
        Some(SpotPattern { direction, cos_inner, cos_outer, slide })
    }

    /// How many points its integral over all cells takes.
    pub fn points(&self) -> f64 {
        if self.slide.is_some() { IMAGE_POINTS } else { FALL_OFF_POINTS }
    }

    fn fall_off(&self, direction: DVec3) -> f64 {
        let cosine = direction.dot(self.direction) / direction.length();
        if cosine >= self.cos_inner {
            return 1.0;
        }
        // Where both angles are equal, what is left is below both cosines: no division by 0.
        if cosine <= self.cos_outer {
            return 0.0;
        }
        let t = (cosine - self.cos_outer) / (self.cos_inner - self.cos_outer);
        t * t * (3.0 - 2.0 * t)
    }

    /// Along a direction of any length.
    fn at(&self, direction: DVec3) -> DVec3 {
        match (self.fall_off(direction), &self.slide) {
            (0.0, _) => DVec3::ZERO,
            (fall_off, None) => DVec3::splat(fall_off),
            (fall_off, Some(slide)) => fall_off * slide.at(direction / direction.dot(self.direction)),
        }
    }

    /// Integral over the rectangle of a face, sr.
    pub fn solid_angle(&self, face: usize, lower: DVec2, size: DVec2, steps: u32) -> DVec3 {
        let [axis, u, v] = chart::axes(face);
        let way = |fraction: DVec2| {
            let point = lower + fraction * size;
            (axis + point.x * u + point.y * v, point.length_squared())
        };
        // The inner cone is convex: corners inside are all inside.
        let corners = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE];
        if self.slide.is_none() && corners.iter().all(|&corner| self.fall_off(way(corner).0) >= 1.0) {
            return DVec3::splat(solid_angle(lower, size));
        }
        let middles = || (0..steps).map(|i| (f64::from(i) + 0.5) / f64::from(steps));
        let points = middles().flat_map(|y| middles().map(move |x| DVec2::new(x, y)));
        let sum: DVec3 = points.map(way).map(|(way, r2)| self.at(way) * (1.0 + r2).powf(-1.5)).sum();
        sum * size.element_product() / f64::from(steps * steps)
    }
}

impl Slide {
    fn new(image: SpotImage, texture: &Texture, direction: DVec3, outer: f64) -> Self {
        let [right, up] = image.axes(direction);
        Slide {
            right,
            up,
            half_width: outer.tan(),
            width: texture.width as usize,
            height: texture.height as usize,
            texels: texture.texels.iter().map(|&texel| stored_texel(texel)).collect(),
        }
    }

    /// Bilinear, as `image_color` of the kernels, at a point one metre ahead of the light.
    fn at(&self, point: DVec3) -> DVec3 {
        let across = DVec2::new(point.dot(self.right), -point.dot(self.up));
        let last = DVec2::new(self.width as f64 - 1.0, self.height as f64 - 1.0);
        let place = (0.5 + 0.5 * across / self.half_width) * (last + 1.0) - 0.5;
        let place = place.clamp(DVec2::ZERO, last);
        let low = place.floor();
        let part = place - low;
        let high = (low + 1.0).min(last);
        let texel = |x: f64, y: f64| self.texels[y as usize * self.width + x as usize];
        let row = |y: f64| texel(low.x, y).lerp(texel(high.x, y), part.x);
        row(low.y).lerp(row(high.y), part.y)
    }
}
