//! Screen-space refraction against visible points.

use nephroid::render::{Picture, RenderSettings};
use nephroid::scene::Scene;

use crate::common::{Request, layer};
use crate::{assert_sound, counter, difference, load, pool, render, sum};

/// RMS difference over the mean where the camera sees all that the water shows: rays and marches end in neighbouring texels
/// here and there.
const SAME: f64 = 0.1;
/// Of the light: where walls meet the floor, marches take whole texels for what is seen in their middle.
const ENERGY: f64 = 0.02;

fn picture(request: &Request, scene: Scene, set: &[&str], change: &dyn Fn(&mut RenderSettings)) -> Picture {
    let picture = render(request, scene, set, change);
    assert_sound(&picture);
    picture
}

pub fn screen(request: &Request) {
    let above = |set: &[&str], adaptive: bool| {
        picture(request, pool(), &[&["photons.photons=60000"], set].concat(), &|s| {
            s.camera = Some("above".to_string());
            s.samples = Some(2);
            s.adaptive = adaptive;
        })
    };
    for (adaptive, by, marches) in
        [(false, "", &["hierarchical", "linear"][..]), (true, ", adaptive", &["hierarchical"])]
    {
        let points = above(&[], adaptive);
        assert_eq!(counter(&points, "refractions"), 0.0);
        let expected = layer(&points.image, "caustic");
        for march in marches {
            let screen = above(&["photons.refraction=screen", &format!("photons.march={march}")], adaptive);
            let found = layer(&screen.image, "caustic");
            let (energy, error) = (sum(&found) / sum(&expected), difference(&found, &expected));
            println!("{march}{by}: energy {energy:.4}, {error:.4} apart");
            assert!(found != expected, "{march}{by}: it has no effect");
            assert!((energy - 1.0).abs() < ENERGY, "{march}{by}: energy {energy}");
            assert!(error < SAME, "{march}{by}: {error} apart");
            assert!(counter(&screen, "refractions") > 500.0, "{march}{by}: hardly anything is refracted");
            assert_eq!(counter(&screen, "refractions_unbent"), 0.0, "{march}{by}: the floor is out of sight");
        }
    }
    // The liquid bends what is seen out of the view, the more so the smaller that is.
    let unbent = |margin: &str| {
        let set = ["photons.refraction=screen", margin];
        let picture = picture(request, load("cornell_flooded.toml"), &set, &|_| {});
        counter(&picture, "refractions_unbent") / counter(&picture, "refractions")
    };
    let [narrow, wide] = ["photons.margin=0", "photons.margin=0.6"].map(unbent);
    println!("{narrow:.3} of the rays leave the view, {wide:.3} of them a wider one");
    assert!(narrow > 0.1 && wide < 0.7 * narrow, "{narrow} of the rays leave the view, {wide} of them a wider one");
}
