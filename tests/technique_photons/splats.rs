//! Photons drawn as discs.

use crate::common::{Request, layer};
use crate::edges::{slats_truth, slatted};
use crate::flat::even_scene;
use crate::{assert_sound, difference, render, sum, watts};

/// Of all light: discs do not change how much there is.
const ENERGY: f64 = 0.001;
/// What is left of the noise by discs that cover nine texels and more.
const NOISE: f64 = 0.6;

pub fn smoother(request: &Request) {
    let picture = |store: &str| {
        let set = ["photons.photons=30000", store, "photons.footprint=2.5"];
        let picture = render(request, even_scene(90.0), &set, |s| s.samples = Some(1));
        assert_sound(&picture);
        picture
    };
    let [single, discs] = ["photons.store=texels", "photons.store=splats"].map(picture);
    assert_eq!(watts(&single, "landed"), watts(&discs, "landed"));
    let [before, after] = [&single, &discs].map(|picture| layer(&picture.image, "caustic"));
    // Even light stays even to the border: what lies beyond it gives as much as it gets.
    let even = vec![[0.0, (sum(&before) / before.len() as f64) as f32, 0.0]; before.len()];
    let [noise, left] = [&before, &after].map(|pixels| difference(pixels, &even));
    let energy = sum(&after) / sum(&before);
    println!("{noise:.4} of noise, {left:.4} with discs, {energy:.5} of the light");
    assert!(left < NOISE * noise, "{left} of noise is left, of {noise}");
    assert!((energy - 1.0).abs() < 5.0 * ENERGY, "{energy} of the light");
}

/// What discs do to even light on slats whose pixels have edges: no more than texels.
const EDGES: f64 = 0.02;

pub fn keep_to_their_surface(request: &Request) {
    let truth = slats_truth(request);
    for rescue in ["photons.rescue=off", "photons.rescue=rays"] {
        let [single, discs] = ["photons.store=texels", "photons.store=splats"].map(|s| slatted(request, &[rescue, s]));
        for name in ["landed", "rescued", "hidden", "lost"] {
            assert_eq!(watts(&single, name), watts(&discs, name), "{rescue}: {name}");
        }
        let [before, after] = [&single, &discs].map(|picture| layer(&picture.image, "caustic"));
        let [error, errors] = [&before, &after].map(|pixels| difference(pixels, &truth));
        let energy = sum(&after) / sum(&before);
        println!("{rescue}: relRMSE {error:.4} by texels, {errors:.4} by discs, {energy:.5} of the light");
        assert!((energy - 1.0).abs() < 5.0 * ENERGY, "{rescue}: {energy} of the light");
        assert!(errors < error + EDGES, "{rescue}: relRMSE {errors}, {error} by texels");
    }
}
