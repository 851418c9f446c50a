//! Where photons start.

use crate::common::{Request, layer};
use crate::flat::even_scene;
use crate::{assert_sound, difference, render, sum, watts};

/// What blue points leave of the noise of a set of three photons a texel. Measured: 0.75.
const NOISE: f64 = 0.8;
/// Of the light of sixteen sets, how much less or more may be there by chance at the picture's border. Measured: 3e-4.
const ENERGY: f64 = 0.001;

pub fn blue(request: &Request) {
    let picture = |points: &str, sets: u32, denoise: &str| {
        let set = ["photons.photons=30000", points, denoise];
        let picture = render(request, even_scene(90.0), &set, |s| s.samples = Some(sets));
        assert_sound(&picture);
        picture
    };
    let caustic = |points: &str, sets: u32, denoise: &str| layer(&picture(points, sets, denoise).image, "caustic");
    let even = |pixels: &[[f32; 3]]| vec![[0.0, (sum(pixels) / pixels.len() as f64) as f32, 0.0]; pixels.len()];
    let [jittered, blue] = ["photons.points=jittered", "photons.points=blue"];
    let off = "photons.denoise=off";
    let [before, after] = [jittered, blue].map(|points| caustic(points, 1, off));
    let [noise, left] = [&before, &after].map(|pixels| difference(pixels, &even(pixels)));
    let [many, few] = [jittered, blue].map(|points| caustic(points, 16, off));
    let energy = sum(&few) / sum(&many);
    println!("{noise:.4} of noise, {left:.4} with blue points; {energy:.5} of the light after 16 sets");
    assert!(left < NOISE * noise, "{left} of noise is left, of {noise}");
    assert!((energy - 1.0).abs() < ENERGY, "{energy} of the light");
    // Blue points are at other places in each set.
    let after_sixteen = difference(&few, &even(&few));
    assert!(after_sixteen < 0.5 * left, "{after_sixteen} of noise after 16 sets, {left} after one");
    let landed = |points: &str, denoise: &str| watts(&picture(points, 1, denoise), "landed");
    let auto = "photons.points=auto";
    assert_eq!(landed(auto, off), landed(jittered, off));
    let spatial = "photons.denoise=spatial";
    assert_eq!(landed(auto, spatial), landed(blue, spatial));
    assert_ne!(landed(jittered, off), landed(blue, off));
}
