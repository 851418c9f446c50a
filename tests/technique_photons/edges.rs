//! Light at edges of what the camera sees, and on what it does not see.

use std::path::Path;

use glam::Vec3;
use nephroid::render::Picture;
use nephroid::scene::{self, Scene};
use nephroid::technique::TechniqueKind;

use crate::common::{Request, layer};
use crate::flat::{even_text, tilted_scene};
use crate::{assert_sound, difference, render, sum, watts};

const SIZE: (u32, u32) = (32, 24);

/// Slats under flat water, two or three pixels wide, over a floor.
fn slats() -> Scene {
    let mut text = even_text("5, 6", "-2, 0.2", 60.0, "0.1, -1");
    for index in 0..9 {
        let (x, turn) = (-1.2 + 0.3 * f64::from(index), 7 * index);
        text += &format!(
            "[[object]]\nname = \"slat {index}\"\nshape = \"plane\"\nsize = [0.13, 3]\nmaterial = \"white\"\n\
             transform = {{ translate = [{x}, -1.6, 0], rotate = [0, {turn}, 0] }}\n"
        );
    }
    scene::parse(&text, Path::new("test.toml")).unwrap()
}

/// The slats by photons.
pub fn slatted(request: &Request, set: &[&str]) -> Picture {
    let set = [&["photons.photons=250000", "photons.resolution=1024"], set].concat();
    let picture = render(request, slats(), &set, |s| {
        s.size = Some(SIZE);
        s.samples = Some(4);
    });
    assert_sound(&picture);
    picture
}

/// Light at the very points, without noise or blur.
pub fn slats_truth(request: &Request) -> Vec<[f32; 3]> {
    let picture = request.render(slats(), |s| {
        s.technique = TechniqueKind::Mnee;
        s.size = Some(SIZE);
        s.samples = Some(32);
    });
    layer(&picture.image, "caustic")
}

/// Of all light: what stands for a texel is known to a sixteenth, and what is behind an outline not at all.
const ENERGY: f64 = 0.02;
/// Three in four pixels have an edge. With whole texels for surfaces that fill a part of them it is 0.17 and more.
const ERROR: f64 = 0.12;

pub fn slats_shine_evenly(request: &Request) {
    let expected = slats_truth(request);
    for rescue in ["photons.rescue=off", "photons.rescue=rays"] {
        let found = layer(&slatted(request, &[rescue]).image, "caustic");
        let (energy, error) = (sum(&found) / sum(&expected), difference(&found, &expected));
        println!("{rescue}: energy {energy:.4}, relRMSE {error:.4}");
        assert!((energy - 1.0).abs() < ENERGY, "{rescue}: energy {energy}");
        assert!(error < ERROR, "{rescue}: relRMSE {error}");
    }
}

/// Of light that goes by the cosine to another normal.
const COSINE: f64 = 0.01;

/// A camera that sees a floor by total reflection only, and its normals bent.
pub fn unseen_light_goes_by_the_shading_normal(request: &Request) {
    let bend = 40f32.to_radians();
    let light = |bent: bool| {
        let mut scene = tilted_scene(90.0, 125.0, 10.0);
        if bent {
            let floor = scene.instances.iter().find(|instance| instance.name == "floor").unwrap();
            let normals = &mut scene.meshes[floor.mesh].normals;
            normals.iter_mut().for_each(|n| *n = Vec3::new(bend.sin(), bend.cos(), 0.0));
        }
        let picture = render(request, scene, &["photons.rescue=rays", "photons.photons=60000"], |_| {});
        assert_sound(&picture);
        assert_eq!(watts(&picture, "landed"), 0.0, "the camera sees the floor");
        sum(&layer(&picture.image, "caustic"))
    };
    let [straight, bent] = [false, true].map(light);
    assert!(straight > 0.0);
    let (ratio, expected) = (bent / straight, f64::from(bend.cos()));
    println!("{ratio:.4} of the light, {expected:.4} expected");
    assert!((ratio - expected).abs() < COSINE, "{ratio} of the light, not {expected}");
}
