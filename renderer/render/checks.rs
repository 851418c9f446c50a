//! What is asked of a renderer before it renders: cameras, sizes, frames, bands.

use super::{MAX_SIDE, RenderError};
use crate::scene::{Camera, Scene};
use crate::view::Band;

/// The scene's camera of that name, or its first.
pub(super) fn camera<'a>(scene: &'a Scene, name: Option<&str>) -> Result<&'a Camera, RenderError> {
    let found = match name {
        Some(name) => scene.cameras.iter().find(|camera| camera.name == name),
        None => scene.cameras.first(),
    };
    found.ok_or_else(|| RenderError::UnknownCamera {
        scene: scene.path.display().to_string(),
        found: name.unwrap_or_default().to_string(),
        allowed: scene.cameras.iter().map(|c| c.name.as_str()).collect::<Vec<_>>().join(", "),
    })
}

/// Fails for a picture that is empty or larger than is allowed.
pub fn check_size((width, height): (u32, u32)) -> Result<(), RenderError> {
    if (1..=MAX_SIDE).contains(&width) && (1..=MAX_SIDE).contains(&height) {
        Ok(())
    } else {
        Err(RenderError::Size { width, height })
    }
}

/// Fails for a frame that the scene's water cannot be taken to within days.
pub fn check_frame(scene: &Scene, frame: u32) -> Result<(), RenderError> {
    let last = scene.animation.last_frame();
    if frame > last {
        return Err(RenderError::Frame { scene: scene.path.display().to_string(), frame, last });
    }
    Ok(())
}

/// Bands of rows whose largest buffer, of `bytes` a pixel, fits into a storage range of `limit` bytes.
pub(super) fn bands((width, height): (u32, u32), bytes: u64, limit: u64) -> Vec<Band> {
    let rows = (limit / (bytes * u64::from(width))).clamp(1, u64::from(height)) as u32;
    (0..height).step_by(rows as usize).map(|first| Band { first, count: rows.min(height - first) }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film;

    #[test]
    fn bands_cover_every_row_once_and_fit() {
        for bytes in [false, true].map(film::largest_bytes_per_pixel) {
            for (size, limit) in
                [((480, 360), 1 << 27), ((1920, 1080), 1 << 27), ((16384, 16384), 1 << 27), ((7, 5), 1)]
            {
                let bands = bands(size, bytes, limit);
                assert_eq!(bands.iter().map(|b| b.count).sum::<u32>(), size.1);
                assert!(bands.windows(2).all(|pair| pair[0].first + pair[0].count == pair[1].first));
                let largest = bands.iter().map(|b| u64::from(b.count) * u64::from(size.0) * bytes).max();
                assert!(largest <= Some(limit) || bands.iter().all(|b| b.count == 1));
            }
        }
        let portable = bands((1920, 1080), film::largest_bytes_per_pixel(false), 1 << 27);
        assert_eq!(portable.len(), 1, "full HD fits the portable storage range in one band");
    }
}
