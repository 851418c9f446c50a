//! What a picture's ledger, counters and layers say.

use nephroid::render::Picture;

/// That entry of the ledger.
pub fn watts(picture: &Picture, name: &str) -> f64 {
    picture.stats.ledger.iter().find(|entry| entry.name == name).unwrap().watts
}

pub fn counter(picture: &Picture, name: &str) -> f64 {
    picture.stats.counters.iter().find(|entry| entry.name == name).unwrap().value
}

/// Of green.
pub fn sum(pixels: &[[f32; 3]]) -> f64 {
    pixels.iter().map(|p| f64::from(p[1])).sum()
}

/// RMS difference over the mean of `b`, green.
pub fn difference(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(a, b)| f64::from(a[1] - b[1]).powi(2)).sum();
    (squares * b.len() as f64).sqrt() / sum(b)
}

/// Asks that every number of every layer is one.
pub fn assert_finite(picture: &Picture) {
    for layer in &picture.image.layers {
        for channel in &layer.channels {
            assert!(channel.samples.iter().all(|v| v.is_finite()), "layer {} {}", layer.name, channel.name);
        }
    }
}
