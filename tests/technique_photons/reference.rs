//! Pictures against the reference's light of one specular event.

use nephroid::render::Picture;
use nephroid::scene::Scene;
use nephroid::technique::TechniqueKind;

use crate::common::{Request, layer};
use crate::{assert_sound, difference, load, pool, render, sum, watts};

/// Texels at edges of what is seen lose light, and the fewer pixels the more of them are there.
const SIZE: (u32, u32) = (128, 96);
/// Of the light in the picture, with rays to finish photons.
const ENERGY: f64 = 0.02;

/// Light of one specular event, by the reference.
fn truth(request: &Request, scene: Scene) -> Picture {
    request.render(scene, |s| {
        s.technique = TechniqueKind::Reference;
        s.size = Some(SIZE);
        s.samples = Some(6);
        s.set = ["reference.photons=150000", "reference.reuse=1", "reference.paths=once"].map(String::from).to_vec();
    })
}

/// Caustic light as the camera sees it: what a picture has more than one without.
fn seen(picture: &Picture, dark: &Picture) -> Vec<[f32; 3]> {
    let [lit, dark] = [picture, dark].map(|picture| layer(&picture.image, "final"));
    lit.iter().zip(&dark).map(|(lit, dark)| [0, 1, 2].map(|c| lit[c] - dark[c])).collect()
}

/// Of blocks of 8 x 8 pixels: what so few photons leave by chance on both sides.
const NOISE: f64 = 0.1;

/// Means over blocks of 8 x 8 pixels.
fn blocks(pixels: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let across = SIZE.0 as usize / 8;
    let mut means = vec![[0f32; 3]; across * SIZE.1 as usize / 8];
    for (index, pixel) in pixels.iter().enumerate() {
        let (row, column) = (index / SIZE.0 as usize, index % SIZE.0 as usize);
        let mean = &mut means[row / 8 * across + column / 8];
        (0..3).for_each(|c| mean[c] += pixel[c] / 64.0);
    }
    means
}

pub fn single(request: &Request) {
    for (what, scene) in [("flooded", load("cornell_flooded.toml")), ("pool", pool())] {
        let dark = request.render(scene.clone(), |s| {
            s.technique = TechniqueKind::None;
            s.size = Some(SIZE);
            s.samples = Some(6);
        });
        let expected = seen(&truth(request, scene.clone()), &dark);
        let by = |rescue: &str| {
            let rescue = format!("photons.rescue={rescue}");
            let set = ["photons.photons=80000", "photons.resolution=512", &rescue];
            let picture = render(request, scene.clone(), &set, |s| {
                s.size = Some(SIZE);
                s.samples = Some(6);
            });
            assert_sound(&picture);
            picture
        };
        let [off, rays] = ["off", "rays"].map(by);
        let [less, all] = [&off, &rays].map(|picture| seen(picture, &dark));
        let [below, energy] = [&less, &all].map(|pixels| sum(pixels) / sum(&expected));
        let error = difference(&blocks(&all), &blocks(&expected));
        println!("{what}: energy {below:.4} by views, {energy:.4} with rays, relRMSE of blocks {error:.3}");
        assert!((energy - 1.0).abs() < ENERGY, "{what}: energy {energy}");
        assert!(error < NOISE, "{what}: relRMSE {error}");
        // Views lose light, and find little that is not there: what has a thickness stops light that passes behind it.
        assert!(below < energy + 0.005, "{what}: energy {below} without rays, {energy} with them");
        assert!(watts(&off, "lost") > 0.0, "{what}: nothing is lost");
        // Of the pool they lose what goes off into the air.
        assert!(what != "flooded" || watts(&rays, "rescued") > 0.0, "{what}: nothing is rescued");
    }
}
