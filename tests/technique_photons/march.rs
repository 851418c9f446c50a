//! Photons followed over a pyramid of depths against photons followed texel by texel.

use std::path::Path;

use nephroid::render::Picture;
use nephroid::scene::{self, Scene};

use crate::common::{Request, layer};
use crate::{assert_sound, changed, counter, load, pool, render, watts};

const LAMP: &str = "kind = \"point\"\nposition = [1.5, 6, -1]\nintensity = 100";

fn lit_by(light: &str) -> Scene {
    // Walls end above the water and would keep out a low sun.
    changed(
        "pool.toml",
        &[("[256, 256]", "[64, 64]"), (LAMP, light), ("size = [10, 2.5, 10]", "size = [10, 2, 10]"), ("-0.75", "-1")],
    )
}

/// A lamp on the axis of a tube of silver, over a floor: one frustum cannot hold the tube.
pub fn tube() -> Scene {
    let text = r#"
[[camera]]
name = "down"
position = [0, 1.9, 0.4]
target = [0, 0, 0]
fov_y = 50
[[material]]
name = "white"
kind = "diffuse"
albedo = 1
[[material]]
name = "silver"
kind = "mirror"
reflectance = 0.9
[[object]]
name = "floor"
shape = "plane"
size = [5, 5]
material = "white"
[[object]]
name = "block"
shape = "box"
centre = [0.3, 0.2, 0.1]
size = [0.2, 0.4, 0.3]
material = "white"
[[object]]
name = "mirror"
shape = "cylinder"
centre = [0, 1, 0]
radius = 1
height = 2
segments = 48
material = "silver"
[[light]]
name = "lamp"
kind = "point"
position = [0.2, 1.1, 0]
intensity = 10
"#;
    scene::parse(text, Path::new("test.toml")).unwrap()
}

/// Sizes of views that no power of two divides: 97 texels a side of a light's, and 37 + 2 x 4 across the camera's.
const ODD: (&[&str], (u32, u32)) = (&["photons.photons=12000", "photons.resolution=97"], (37, 23));

/// Both ways end in the same; how many times fewer steps the pyramid takes.
fn assert_same(
    what: &str,
    request: &Request,
    scene: impl Fn() -> Scene,
    set: &[&str],
    size: (&[&str], (u32, u32)),
) -> f64 {
    let picture = |march: &str| {
        let picture = render(request, scene(), &[size.0, set, &[march]].concat(), |s| s.size = Some(size.1));
        assert_sound(&picture);
        picture
    };
    let [fast, slow] = ["photons.march=hierarchical", "photons.march=linear"].map(picture);
    for (a, b) in fast.stats.ledger.iter().zip(&slow.stats.ledger) {
        assert_eq!(a.watts, b.watts, "{what}: {}", a.name);
    }
    for name in ["photons_traced", "light_hits", "camera_hits", "photons_skimming"] {
        assert_eq!(counter(&fast, name), counter(&slow, name), "{what}: {name}");
    }
    let bits = |p: &Picture| layer(&p.image, "caustic").into_iter().flatten().map(f32::to_bits).collect::<Vec<_>>();
    assert!(bits(&fast) == bits(&slow), "{what}: pictures differ");
    assert!(watts(&fast, "landed") > 0.0, "{what}: nothing lands");
    let steps = |p: &Picture| counter(p, "light_steps") + counter(p, "camera_steps");
    let ratio = steps(&slow) / steps(&fast);
    println!("{what}: {ratio:.2} times fewer steps, {:?}", fast.stats.ledger);
    ratio
}

/// Of a picture of 160 x 120 and a light's view of 511 texels a side; larger views gain more, and tiny ones nothing.
const FEWER: f64 = 2.0;

pub fn both(request: &Request) {
    assert_same("lamp, aimed", request, pool, &[], ODD);
    let large = (&["photons.photons=12000", "photons.resolution=511"][..], (160, 120));
    let fewer = assert_same("lamp, large views", request, pool, &[], large);
    assert!(fewer > FEWER, "only {fewer} times fewer steps");
    assert_same("lamp, rescued", request, pool, &["photons.rescue=rays", "photons.margin=0"], ODD);
    assert_same("lamp, Eq. 2", request, pool, &["photons.end=linear"], ODD);
    assert_same("lamp, all round", request, tube, &[], ODD);
    let sun = "kind = \"directional\"\ndirection = [0.4, -0.5, 0.3]\nirradiance = 100";
    assert_same("sun", request, || lit_by(sun), &[], ODD);
    let spot = "kind = \"spot\"\nposition = [1.5, 6, -1]\ntarget = [0, 0, 0]\nouter = 25\nintensity = 100";
    assert_same("spot", request, || lit_by(spot), &[], ODD);
    assert_same("blocks", request, || load("cornell_flooded.toml"), &["photons.thickness=0.05"], ODD);
}
