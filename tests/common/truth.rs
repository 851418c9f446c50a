//! The pool's floor under waves, made elsewhere; see `tests/truth`.

use std::path::Path;

use nephroid::image;

use super::layer;

const WIDTH: usize = 120;
const HEIGHT: usize = 90;

/// A picture to hold others against where it holds itself.
pub struct Truth {
    /// Pixels.
    pub size: (u32, u32),
    /// Green; `None` where not all of the pixel is floor.
    pixels: Vec<Option<f64>>,
}

impl Truth {
    /// What a camera of the pool sees, at its own size over `coarser`. The truth is box-filtered, so its blocks' means are
    /// the truth of larger pixels.
    pub fn of_pool(camera: &str, coarser: usize) -> Self {
        let picture = image::read(Path::new(&format!("tests/truth/pool_{camera}_{WIDTH}x{HEIGHT}.exr"))).unwrap();
        let (found, mask) = (layer(&picture, "final"), &picture.layer("mask").unwrap().channels[0].samples);
        let size = (WIDTH / coarser, HEIGHT / coarser);
        let block = |row: usize, column: usize| {
            let inside = (0..coarser * coarser)
                .map(move |i| (coarser * row + i / coarser) * WIDTH + coarser * column + i % coarser);
            let all = inside.clone().all(|i| mask[i] > 0.5);
            all.then(|| inside.map(|i| f64::from(found[i][1])).sum::<f64>() / (coarser * coarser) as f64)
        };
        let pixels = (0..size.1).flat_map(|row| (0..size.0).map(move |column| (row, column)));
        let pixels = pixels.map(|(row, column)| block(row, column)).collect();
        Truth { size: (size.0 as u32, size.1 as u32), pixels }
    }

    /// Energy ratio and relative RMSE of a layer of a picture of that size.
    pub fn against(&self, found: &[[f32; 3]]) -> (f64, f64) {
        let pairs = || found.iter().zip(&self.pixels).filter_map(|(f, truth)| Some((f64::from(f[1]), (*truth)?)));
        let count = pairs().count() as f64;
        let mean = pairs().map(|(_, truth)| truth).sum::<f64>() / count;
        let energy = pairs().map(|(f, _)| f).sum::<f64>() / count / mean;
        let squares = pairs().map(|(f, truth)| (f - truth).powi(2)).sum::<f64>() / count;
        (energy, squares.sqrt() / mean)
    }
}
