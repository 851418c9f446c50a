//! The techniques on a pool of flat water, whose light has a closed form.

use std::path::Path;

use super::{Bench, Case, CaseError};
use crate::conformance::case::Worst;
use crate::conformance::closed_forms::{flat_water_irradiance, floor_point};
use crate::gpu::Capability;
use crate::image::RgbImage;
use crate::render::{Picture, RenderSettings, Renderer};
use crate::scene::{self, Scene};
use crate::technique::TechniqueKind;
use crate::trace::TraceChoice;

/// Whatever picks an implementation for a stage of these: rays, and what camera and lights see.
const MINDS: &[Capability] = &[Capability::RayQuery, Capability::PreciseRaster];

const FLAT: &str = "light on the floor under flat water against Snell's law and Fresnel's equations";
const LEDGER: &str = "every watt that the lamp sends out is booked, through waves, and none is no number";
const DIRECT: &str = "light straight on a floor against the closed form";

const fn case(
    group: &'static str,
    name: &'static str,
    about: &'static str,
    run: fn(&mut Bench<'_>) -> Result<(), CaseError>,
) -> Case {
    Case { group, name, about, needs: &[], minds: MINDS, catches: &[], run }
}

pub(super) const CASES: &[Case] = &[
    case("frame", "direct_light", DIRECT, direct),
    case("reference", "flat_water", FLAT, |bench| flat_water(bench, &REFERENCE)),
    case("reference", "ledger", LEDGER, |bench| ledger(bench, &REFERENCE)),
    case("mnee", "flat_water", FLAT, |bench| flat_water(bench, &MNEE)),
    case("beams", "flat_water", FLAT, |bench| flat_water(bench, &BEAMS)),
    case("beams", "ledger", LEDGER, |bench| ledger(bench, &BEAMS)),
    Case {
        group: "beams",
        name: "hulls",
        about: "the same light by hulls that are drawn, from a geometry stage or else from a kernel",
        needs: super::GRAPHICS,
        minds: &[Capability::GeometryShader],
        catches: &[],
        run: hulls,
    },
    case("photons", "flat_water", FLAT, |bench| flat_water(bench, &PHOTONS)),
    case("photons", "ledger", LEDGER, |bench| ledger(bench, &PHOTONS)),
    case("eikonal", "flat_water", FLAT, |bench| flat_water(bench, &EIKONAL)),
];

/// A technique, and what it is held to.
struct Way<'a> {
    kind: TechniqueKind,
    set: &'a [&'static str],
    samples: u32,
    /// Of the sum over pixels, relative.
    energy: f64,
    /// RMS error of pixels over the mean.
    noise: f64,
    /// Of the ledger's sum, relative.
    balance: f64,
}

/// 400,000 photons gathered a thousand at a time, of smooth light.
const REFERENCE: Way<'_> = Way {
    kind: TechniqueKind::Reference,
    set: &["reference.photons=200000", "reference.reuse=2", "reference.neighbours=1000"],
    samples: 4,
    energy: 0.005,
    noise: 0.02,
    balance: 1e-3,
};

/// Without noise: what f32 leaves, and a pixel's area beside its centre.
const MNEE: Way<'_> = Way { kind: TechniqueKind::Mnee, set: &[], samples: 4, energy: 0.002, noise: 0.01, balance: 0.0 };

/// What triangles between rays leave of smooth light.
const BEAMS: Way<'_> = Way {
    kind: TechniqueKind::Beams,
    set: &["beams.grid=16", "beams.levels=1", "beams.vertices=16384"],
    samples: 1,
    energy: 0.005,
    noise: 0.01,
    balance: 1e-3,
};

/// A hundred photons and more on a pixel, spread more evenly than by chance.
const PHOTONS: Way<'_> = Way {
    kind: TechniqueKind::Photons,
    set: &["photons.photons=100000", "photons.resolution=512"],
    samples: 1,
    energy: 0.01,
    noise: 0.25,
    balance: 1e-4,
};

/// What cells of 15 cm and more leave of smooth light.
const EIKONAL: Way<'_> = Way {
    kind: TechniqueKind::Eikonal,
    set: &["eikonal.resolution=64"],
    samples: 4,
    energy: 0.01,
    noise: 0.02,
    balance: 0.0,
};

const SIZE: (u32, u32) = (32, 24);

fn flat_pool() -> Result<Scene, CaseError> {
    Ok(scene::parse(include_str!("../../../scenes/flat_water.toml"), Path::new("flat_water.toml"))?)
}

/// The pool with waves, coarse so that it is quick.
fn waves() -> Result<Scene, CaseError> {
    let text = include_str!("../../../scenes/pool.toml").replace("quads = [256, 256]", "quads = [48, 48]");
    Ok(scene::parse(&text, Path::new("pool.toml"))?)
}

/// A picture on the bench's device, with rays by ray queries where there are such, else by the wide tree, on a device that is
/// compute alone by the binary one.
fn render(bench: &Bench<'_>, scene: Scene, way: &Way<'_>, size: (u32, u32)) -> Result<Picture, CaseError> {
    let trace = match bench.device.has(Capability::RayQuery) {
        true => TraceChoice::RayQuery,
        false if bench.tier.is_compute() => TraceChoice::Bvh2,
        false => TraceChoice::Cwbvh,
    };
    let settings = RenderSettings {
        technique: way.kind,
        trace,
        size: Some(size),
        samples: Some(way.samples),
        set: way.set.iter().map(|set| set.to_string()).collect(),
        ..Default::default()
    };
    let mut renderer = Renderer::with_device(bench.device.clone(), scene, &settings)?;
    for _ in 0..renderer.samples() {
        renderer.sample()?;
    }
    Ok(renderer.finish()?)
}

fn layer(picture: &Picture, name: &str) -> Result<RgbImage, CaseError> {
    let missing = || CaseError::Other(format!("the picture has no layer \"{name}\""));
    picture.image.layer(name).and_then(|layer| layer.to_rgb()).ok_or_else(missing)
}

/// Holds the floor's pixels against a closed form of x and z.
fn compare(
    bench: &mut Bench<'_>,
    found: &RgbImage,
    expected: impl Fn(f64, f64) -> f64,
    energy: f64,
    noise: f64,
) -> Result<(), CaseError> {
    let (width, height) = (found.width, found.height);
    let place = |index: usize| floor_point((index % width) as f64, (index / width) as f64, width as f64, height as f64);
    let value = |index: usize| place(index).map_or(0.0, |(x, z)| expected(x, z));
    let inside: Vec<bool> = (0..width * height).map(|index| place(index).is_some()).collect();
    let truth = RgbImage { width, height, pixels: (0..width * height).map(|index| [value(index) as f32; 3]).collect() };
    let (mut sum, mut expected_sum, mut squares, mut count) = (0.0, 0.0, 0.0, 0.0);
    let mut not_finite = Worst::default();
    for (index, pixel) in found.pixels.iter().enumerate() {
        let bad = pixel.iter().filter(|v| !v.is_finite()).count();
        not_finite.see(bad as f64, || format!("pixel {}, {}", index % width, index / width));
        if inside[index] {
            let (pixel, value) = (f64::from(pixel[1]), value(index));
            sum += pixel;
            expected_sum += value;
            squares += (pixel - value).powi(2);
            count += 1.0;
        }
    }
    bench.picture(found, &truth, inside);
    bench.at_most("numbers of the picture that are none", not_finite, 0.0, "");
    let place =
        format!("{count} pixels of the floor: {:.6}, not {:.6}, in the mean", sum / count, expected_sum / count);
    let mut worst = Worst::default();
    worst.see((sum / expected_sum - 1.0).abs(), || place.clone());
    bench.at_most("light in sum, relative", worst, energy, "");
    let mut worst = Worst::default();
    worst.see((squares * count).sqrt() / expected_sum, || place);
    bench.at_most("RMS error of pixels over the mean", worst, noise, "");
    Ok(())
}

fn flat_water(bench: &mut Bench<'_>, way: &Way<'_>) -> Result<(), CaseError> {
    let picture = render(bench, flat_pool()?, way, SIZE)?;
    bench.note("tier", &picture.stats.tier);
    compare(bench, &layer(&picture, "caustic")?, flat_water_irradiance, way.energy, way.noise)
}

fn hulls(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    if !bench.device.info.limits.float_sums {
        return Err(CaseError::Skip("the driver does not blend 32-bit floats".to_string()));
    }
    let way = match bench.device.has(Capability::GeometryShader) {
        true => "beams.accumulate=geometry",
        false => "beams.accumulate=vertices",
    };
    bench.note("hulls", way);
    // A pixel's footprint on a surface is looked for in tiles however volumes are drawn; points are drawn.
    let set = [BEAMS.set, &["beams.footprint=point", way]].concat();
    flat_water(bench, &Way { set: &set, samples: 4, ..BEAMS })
}

/// The pool without its water: the lamp shines straight on the floor.
fn direct(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let mut scene = flat_pool()?;
    scene.instances.retain(|instance| instance.name != "water");
    scene.cameras.iter_mut().for_each(|camera| camera.medium = scene.lights[0].medium);
    let none = Way { kind: TechniqueKind::None, set: &[], samples: 16, energy: 0.0, noise: 0.0, balance: 0.0 };
    let picture = render(bench, scene, &none, SIZE)?;
    bench.note("tier", &picture.stats.tier);
    // 100 W/sr at (1.5, 6, -1), 8 m above the floor, of albedo 0.8.
    let radiance = |x: f64, z: f64| {
        let squared = (x - 1.5).powi(2) + (z + 1.0).powi(2) + 64.0;
        0.8 / std::f64::consts::PI * 100.0 * 8.0 / squared.powf(1.5)
    };
    compare(bench, &layer(&picture, "direct")?, radiance, 0.002, 0.005)
}

fn ledger(bench: &mut Bench<'_>, way: &Way<'_>) -> Result<(), CaseError> {
    let picture = render(bench, waves()?, &Way { samples: 1, ..*way }, (8, 6))?;
    bench.note("tier", &picture.stats.tier);
    let entries = &picture.stats.ledger;
    let watts = |name: &str| entries.iter().find(|entry| entry.name == name).map_or(0.0, |entry| entry.watts);
    let emitted = watts("emitted");
    let booked: f64 = entries.iter().skip(1).map(|entry| entry.watts).sum();
    for entry in entries {
        bench.note(&format!("{}, W", entry.name), format!("{:.4}", entry.watts));
    }
    let mut worst = Worst::default();
    worst.see((booked / emitted - 1.0).abs(), || format!("{booked} W booked of {emitted} W"));
    bench.at_most("watts that are not booked, relative", worst, way.balance, "");
    let nothing = Worst { measured: f64::from(u8::from(watts("landed") <= 0.0)), place: "landed".to_string() };
    bench.at_most("whether no light lands", nothing, 0.0, "");
    let none = Worst { measured: watts("non_finite"), place: "non_finite".to_string() };
    bench.at_most("watts that are no number", none, 0.0, "W");
    Ok(())
}
