//! Scenes whose spot light projects an image.

use nephroid::scene::{self, Scene};

/// Left half white, right half black but for a green lower quarter: sRGB.
pub fn slide() -> image::RgbImage {
    image::RgbImage::from_fn(64, 64, |x, y| match (x < 32, y < 32) {
        (true, _) => image::Rgb([255, 255, 255]),
        (false, true) => image::Rgb([0, 0, 0]),
        (false, false) => image::Rgb([0, 255, 0]),
    })
}

/// The scene, with the image beside it as i.png.
pub fn parse(text: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    slide().save(folder.path().join("i.png")).unwrap();
    scene::parse(text, &folder.path().join("scene.toml")).unwrap()
}
