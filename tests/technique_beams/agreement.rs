//! Ways to the same picture, and what moves it.

use nephroid::render::{Picture, RenderSettings};
use nephroid::technique::TechniqueKind;

use crate::common::pool::coarse;
use crate::common::sequence::{self, bits};
use crate::common::{Request, layer};
use crate::{assert_sound, counter, difference, pool, render, sum};

/// RMS difference over the mean: orders of sums, and a hull's edge.
const TIERS: f64 = 1e-3;

const SMALL: [&str; 4] = ["beams.grid=6", "beams.levels=3", "beams.bounces=1", "beams.vertices=65536"];

fn small(request: &Request, extra: &[&str], change: impl FnOnce(&mut RenderSettings)) -> Picture {
    let picture = render(request, coarse("turbid_pool.toml"), &[&SMALL[..], extra].concat(), |s| {
        s.size = Some((32, 24));
        change(s);
    });
    assert_sound(&picture);
    picture
}

/// Both layers of caustic light against those of another picture.
fn assert_same(what: &str, picture: &Picture, truth: &Picture, bound: f64) {
    for name in ["caustic", "caustic_volume"] {
        let (found, expected) = (layer(&picture.image, name), layer(&truth.image, name));
        assert!(sum(&expected) > 0.0, "{what}: no {name}");
        let error = difference(&found, &expected);
        println!("{what}, {name}: {error:.1e}");
        assert!(error < bound, "{what}: {name} differs by {error}");
    }
}

pub fn tiers(request: &Request) {
    for footprint in ["beams.footprint=pixel", "beams.footprint=point"] {
        let truth = small(request, &[footprint, "beams.accumulate=compute"], |_| {});
        assert_eq!(counter(&truth, "beam_fragments_drawn"), 0.0);
        for tier in ["vertices", "geometry"] {
            let accumulate = format!("beams.accumulate={tier}");
            let picture = small(request, &[footprint, &accumulate], |_| {});
            assert!(counter(&picture, "beam_fragments_drawn") > 0.0, "{tier} draws nothing");
            assert_same(&format!("{footprint} {tier}"), &picture, &truth, TIERS);
        }
    }
    // What cannot be had is done in another way.
    let truth = small(request, &[], |_| {});
    for (disable, draws) in [("geometry-shader", true), ("graphics", false)] {
        let picture = small(request, &["beams.accumulate=geometry"], |s| s.device = request.without(disable));
        assert_eq!(counter(&picture, "beam_fragments_drawn") > 0.0, draws, "without {disable}");
        assert_same(&format!("without {disable}"), &picture, &truth, TIERS);
    }
}

pub fn equal_bits(request: &Request) {
    let picture = |jitter: &str, seed: u32, samples: u32| {
        small(request, &[jitter, "beams.reuse=1"], |s| {
            s.seed = seed;
            s.samples = Some(samples);
        })
    };
    let [on, off] = ["beams.jitter=on", "beams.jitter=off"];
    let first = picture(on, 7, 3);
    assert!(bits(&first) == bits(&picture(on, 7, 3)), "equal seeds gave different bits");
    assert!(bits(&first) != bits(&picture(on, 8, 3)), "the seed has no effect");
    // The ledger knows where grids lie, and nothing of where in their pixels samples look.
    let landed = |jitter: &str, seed: u32, samples: u32| crate::watts(&picture(jitter, seed, samples), "landed");
    assert!(landed(on, 7, 1) != landed(on, 8, 1), "the seed does not move the grids");
    assert!(landed(on, 7, 1) != landed(on, 7, 2), "grids do not move from set to set");
    assert_eq!(landed(off, 7, 1), landed(off, 8, 2), "grids move without jitter");
    let mean = |jitter: &str| sum(&layer(&small(request, &[jitter], |_| {}).image, "caustic"));
    // It moves beams' borders, not the light.
    let ratio = mean(on) / mean(off);
    assert!((ratio - 1.0).abs() < 0.02, "jitter changes the light to {ratio} of it");
}

pub fn frame_alone(request: &Request) {
    let settings = RenderSettings {
        device: request.device.clone(),
        trace: "bvh".parse().unwrap(),
        technique: TechniqueKind::Beams,
        camera: Some("under".to_string()),
        size: Some((24, 18)),
        samples: Some(2),
        set: SMALL.map(String::from).to_vec(),
        ..Default::default()
    };
    let [first, alone] = sequence::frame_alone(request, pool, &settings);
    let moved = difference(&layer(&first.image, "caustic"), &layer(&alone.image, "caustic"));
    assert!(moved > 0.05, "five frames moved the light by {moved}");
}

pub fn adaptive(request: &Request) {
    let uniform = small(request, &[], |s| s.samples = Some(8));
    let adaptive = small(request, &["beams.filter=2"], |s| {
        s.samples = Some(8);
        s.adaptive = true;
    });
    // It would spread light over slots that are not pixels, and says that it does not.
    let told =
        |picture: &Picture| picture.stats.warnings.iter().any(|warning| warning.contains("beams.filter is left out"));
    assert!(told(&adaptive) && !told(&uniform), "{:?}", adaptive.stats.warnings);
    for name in ["caustic", "caustic_volume"] {
        let (found, expected) = (layer(&adaptive.image, name), layer(&uniform.image, name));
        let ratio = sum(&found) / sum(&expected);
        println!("adaptive {name}: {ratio} of the light, difference {:.2e}", difference(&found, &expected));
        // Two estimates of the same picture: what eight samples of pixels and two sets of beams leave.
        assert!((ratio - 1.0).abs() < 0.02, "{name}: {ratio} of the light");
    }
    assert!(adaptive.stats.adaptive.is_some());
    // What neighbours see says nothing of what a sample's pixel covers.
    let points = small(request, &["beams.footprint=point"], |s| {
        s.samples = Some(8);
        s.adaptive = true;
    });
    assert!(bits(&points) == bits(&adaptive), "adaptive samples look at more than points");
}
