//! Beams drawn by a rasteriser, against tiles that look for them.

use std::path::Path;

use crate::beams::flat_water::flat_water_beams;
use crate::beams::stage::{FLOOR, Stage, counter, in_smoke, many_beams, parse};
use crate::common::Request;
use nephroid::frame::Sampling;
use nephroid::gpu::Capability;
use nephroid::scene::{self, Scene};
use nephroid::technique::beams::accumulate::{Bounds, Options, Tier};
use nephroid::technique::beams::beam::Beam;

/// Light at points, which is what hulls bring.
const POINTS: Options = Options { footprints: false, ..Options::DEFAULT };

/// RMS difference over the RMS value. Both tiers run the same code on the same points, so what differs is the order of a
/// sum; a pixel that a hull does not cover is far more.
const TIERS: f64 = 1e-3;

fn relative(a: &[[f32; 4]], b: &[[f32; 4]]) -> f64 {
    let squares = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>();
    let channels = |all: &[[f32; 4]]| all.iter().map(|v| f64::from(v[0])).collect::<Vec<_>>();
    let (a, b) = (channels(a), channels(b));
    let difference = squares(&mut a.iter().zip(&b).map(|(a, b)| a - b));
    (difference / squares(&mut b.iter().copied())).sqrt()
}

/// A sample's irradiance and radiance from media, each slot of which is something, and how many fragments were drawn.
struct Seen {
    irradiance: Vec<[f32; 4]>,
    volume: Vec<[f32; 4]>,
    drawn: f64,
}

fn seen(request: &Request, scene: Scene, beams: &[Beam], options: Options, sample: u32) -> Seen {
    let mut stage = Stage::new(request, scene, (61, 45), Sampling::Uniform);
    let accumulator = stage.accumulator(beams, options);
    let geometry = request.info.capabilities.has(Capability::GeometryShader);
    let expected = match options.tier {
        Some(Tier::Geometry) if !geometry => Tier::Vertices,
        other => other.unwrap_or(Tier::Compute),
    };
    assert_eq!(accumulator.tier(), expected);
    let irradiance = stage.sample(&accumulator, sample).into_iter().map(|(_, irradiance)| irradiance).collect();
    let volume = if stage.frame.film.has_volume() { stage.read("SampleVolume", 1) } else { Vec::new() };
    let drawn = counter(&accumulator, "beam_fragments_drawn");
    Seen { irradiance, volume, drawn }
}

/// Every tier against tiles; returns the fragments drawn of each kind of hull.
fn compare(request: &Request, scene: &dyn Fn() -> Scene, beams: &[Beam]) -> [f64; 2] {
    let truth = seen(request, scene(), beams, POINTS, 3);
    assert_eq!(truth.drawn, 0.0);
    let mut drawn = [0.0; 2];
    for tier in [Tier::Geometry, Tier::Vertices] {
        for (index, bounds) in [Bounds::Six, Bounds::Prism].into_iter().enumerate() {
            let options = Options { tier: Some(tier), bounds, ..POINTS };
            let found = seen(request, scene(), beams, options, 3);
            let surfaces = relative(&found.irradiance, &truth.irradiance);
            println!("{tier:?} {bounds:?}: surfaces {surfaces:.1e}, {} fragments", found.drawn);
            assert!(surfaces < TIERS, "{tier:?} {bounds:?}: {surfaces}");
            if !truth.volume.is_empty() {
                let volume = relative(&found.volume, &truth.volume);
                println!("{tier:?} {bounds:?}: media {volume:.1e}");
                assert!(volume < TIERS, "{tier:?} {bounds:?}: {volume}");
            }
            assert!(found.drawn > 0.0);
            // The same hulls, but for what compilers make of them.
            let same = (drawn[index] - found.drawn).abs() <= 1e-3 * found.drawn;
            assert!(drawn[index] == 0.0 || same, "{} and {} fragments", drawn[index], found.drawn);
            drawn[index] = found.drawn;
        }
    }
    drawn
}

pub fn surfaces(request: &Request) {
    let [six, prism] = compare(request, &|| parse(FLOOR), &many_beams());
    assert!(six < prism, "{six} fragments of six sides, {prism} of prisms");
}

pub fn media(request: &Request) {
    let beams: Vec<Beam> = many_beams().into_iter().map(|beam| Beam { medium: 1, ..beam }).collect();
    // From the side, and from inside the beams.
    for eye in ["[0.3, 1.2, 4]", "[0.2, 0.8, 0.3]"] {
        let text = in_smoke("absorption = 0.2\nscattering = 0.3\nasymmetry = 0.6")
            .replace("position = [0, 4, 0]\ntarget = [0, 0, 0]", &format!("position = {eye}\ntarget = [0, 0.7, 0]"))
            .replace("up = [0, 0, -1]", "up = [0, 1, 0]");
        compare(request, &|| parse(&text), &beams);
    }
}

pub fn mirrors(request: &Request) {
    // Seen from above, all of the floor is behind the water: nothing is drawn that counts, and tiles see it all.
    let beams = flat_water_beams(24);
    let water = std::fs::read_to_string("scenes/flat_water.toml").unwrap();
    let turbid = water.replace("index = 1.33", "index = 1.33\nscattering = 0.05\nabsorption = 0.05");
    let above = |text: &str| {
        let mut scene = scene::parse(text, Path::new("scenes/flat_water.toml")).unwrap();
        scene.cameras.reverse();
        scene
    };
    compare(request, &|| above(&turbid), &beams);
    compare(request, &|| scene::parse(&turbid, Path::new("scenes/flat_water.toml")).unwrap(), &beams);
}

pub fn switched_off(request: &Request) {
    let options = Options { tier: Some(Tier::Geometry), ..POINTS };
    let stage = Stage::new(request, parse(FLOOR), (8, 6), Sampling::Uniform);
    assert_eq!(stage.accumulator(&many_beams(), options).tier(), Tier::Compute);
}
