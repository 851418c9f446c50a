//! Light at grazing angles, light focused to a point and to a line, media that take all or nothing, and no light at all.

use std::path::Path;

use glam::DVec3;
use nephroid::image::LayeredImage;
use nephroid::scene::{self, Scene};

use crate::common::{Request, layer};
use crate::{assert_sound, counter, difference, pool, render, sum, watts};

/// A floor of 2 x 2 at y = 0 seen from above, inside of a mirror that `SHAPE` says, whose lamp is 1 m above it.
const MIRROR: &str = r#"
[[camera]]
name = "down"
position = [0, 1.5, 0]
target = [0, 0, 0]
up = [0, 0, -1]
fov_y = 36
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
size = [SIZE, SIZE]
material = "white"
[[object]]
name = "mirror"
SHAPE
material = "silver"
[[light]]
name = "lamp"
kind = "point"
position = [0, 1, 0]
intensity = 10
"#;

/// W/sr of the mirrors' lamp times what they reflect.
const REFLECTED: f64 = 9.0;

fn mirror(shape: &str, size: &str) -> Scene {
    scene::parse(&MIRROR.replace("SHAPE", shape).replace("SIZE", size), Path::new("test.toml")).unwrap()
}

/// Where the pixels of a film of 24 x 18 see the floor: x and z.
fn floor_points() -> impl Iterator<Item = (usize, f64, f64)> {
    let half = 1.5 * 18f64.to_radians().tan();
    (0..18 * 24).map(move |pixel| {
        let (row, column) = (pixel / 24, pixel % 24);
        let x = half * (4.0 / 3.0) * ((2 * column + 1) as f64 / 24.0 - 1.0);
        (pixel, x, half * ((2 * row + 1) as f64 / 18.0 - 1.0))
    })
}

/// Energy and RMS error of the caustic light on the mirrors' floor, where `expected` knows it.
fn check(what: &str, image: &LayeredImage, expected: impl Fn(f64, f64) -> Option<f64>, bound: f64) {
    let found = layer(image, "caustic");
    let values = floor_points().filter_map(|(pixel, x, z)| Some((f64::from(found[pixel][1]), expected(x, z)?)));
    let pairs: Vec<(f64, f64)> = values.collect();
    let total = pairs.iter().map(|pair| pair.1).sum::<f64>();
    let energy = pairs.iter().map(|pair| pair.0).sum::<f64>() / total;
    let squares = pairs.iter().map(|(found, expected)| (found - expected).powi(2)).sum::<f64>();
    let rel_rmse = (squares * pairs.len() as f64).sqrt() / total;
    println!("{what}: {} pixels, energy {energy:.4}, relRMSE {rel_rmse:.4}", pairs.len());
    assert!(pairs.len() > 100 && (energy - 1.0).abs() < bound, "{what}: energy {energy}");
    assert!(rel_rmse < 4.0 * bound, "{what}: relRMSE {rel_rmse}");
}

const ONCE: [&str; 5] =
    ["beams.grid=8", "beams.levels=4", "beams.bounces=1", "beams.jitter=off", "beams.vertices=262144"];

pub fn light(request: &Request) {
    // From the centre of a ball back through it: the lamp's own light once more, from the other side.
    let ball = mirror("shape = \"sphere\"\ncentre = [0, 1, 0]\nradius = 2\nsegments = 128", "2");
    let picture = render(request, ball, &ONCE, |_| {});
    assert_sound(&picture);
    let expected = |x: f64, z: f64| Some(REFLECTED / DVec3::new(x, 1.0, z).length().powi(3));
    check("through a point", &picture.image, expected, 0.01);

    // From the axis of a tube to the axis again, below or above the floor: light that has gone so far, between the
    // horizontal and the floor, lands in rings that two angles reach.
    let tube = mirror("shape = \"cylinder\"\ncentre = [0, 1, 0]\nradius = 1\nheight = 2\nsegments = 256", "2.2");
    let picture = render(request, tube, &ONCE, |_| {});
    assert_sound(&picture);
    let expected = |x: f64, z: f64| {
        let r = x.hypot(z);
        let ring = |way: f64| {
            let angle = (1.0 / way).atan();
            angle.cos() * angle.sin().powi(2) / r
        };
        // Nearer to the axis a pixel's middle is not its mean.
        (r > 0.15).then(|| REFLECTED * (ring(2.0 - r) + ring(2.0 + r)))
    };
    check("through a line", &picture.image, expected, 0.02);
    grazing(request);
}

/// Lamp and sun so low over the water that angles with it are a degree at the most of what they light.
fn grazing(request: &Request) {
    let text = std::fs::read_to_string("scenes/flat_water.toml").unwrap();
    let sun = "kind = \"directional\"\ndirection = [1, -0.01, 0.2]\nirradiance = 100";
    let lamp = "kind = \"point\"\nposition = [1.5, 6, -1]\nintensity = 100";
    for (what, light) in [
        ("a low lamp", lamp.replace("[1.5, 6, -1]", "[0, 0.01, 0]")),
        ("a lamp under water", lamp.replace("[1.5, 6, -1]", "[0, -0.01, 0]") + "\nmedium = \"water\""),
        ("a low sun", sun.to_string()),
    ] {
        let changed = text.replace(lamp, &light);
        assert_ne!(changed, text);
        // Walls end above the water and would keep out the sun.
        let changed = changed.replace("size = [10, 2.5, 10]", "size = [10, 2, 10]");
        let scene = scene::parse(&changed.replace("-0.75", "-1"), Path::new("scenes/flat_water.toml")).unwrap();
        let picture = render(request, scene, &["beams.grid=6", "beams.levels=3", "beams.vertices=65536"], |_| {});
        assert_sound(&picture);
        let emitted = watts(&picture, "emitted");
        let booked: f64 = picture.stats.ledger.iter().skip(1).map(|entry| entry.watts).sum();
        println!("{what}: {:?}", picture.stats.ledger);
        assert!((booked / emitted - 1.0).abs() < 1e-3, "{what}: {booked} of {emitted} W");
        assert!(watts(&picture, "landed") > 0.0);
        let caustic = layer(&picture.image, "caustic");
        assert!(sum(&caustic) > 0.0, "{what}: no caustic light");
        // All that is emitted on a hundredth of the floor would be this.
        let most = caustic.iter().flatten().fold(0f32, |a, b| a.max(*b));
        assert!(f64::from(most) < emitted, "{what}: {most} W/m2");
    }
}

/// Beams whose edges all end on water or on nothing are not written where nothing scatters; what a receiver narrower than
/// such a beam would get is missing. 0.14 % on lavapipe.
const UNSEEN: f64 = 5e-3;

/// Of the light in clear water, what may get through a tenth of a millimetre: the walls at the waterline are lit, for the
/// reference too.
const WATERLINE: f64 = 1e-3;

pub fn media(request: &Request) {
    let text = std::fs::read_to_string("scenes/turbid_pool.toml").unwrap().replace("[256, 256]", "[64, 64]");
    let own = "absorption = [0.1, 0.03, 0.02]\nscattering = [0.06, 0.06, 0.06]";
    let set = ["beams.grid=6", "beams.levels=3", "beams.vertices=65536"];
    let picture = |coefficients: &str| {
        let changed = text.replace(own, coefficients);
        assert_ne!(changed, text);
        let scene = scene::parse(&changed, Path::new("scenes/turbid_pool.toml")).unwrap();
        let picture = render(request, scene, &set, |_| {});
        assert_sound(&picture);
        let booked: f64 = picture.stats.ledger.iter().skip(1).map(|entry| entry.watts).sum();
        let balance = booked / watts(&picture, "emitted") - 1.0;
        assert!(balance.abs() < 1e-3, "{coefficients}: {balance}");
        picture
    };
    let clear = picture("absorption = 0");
    assert!(clear.image.layer("caustic_volume").is_none(), "nothing scatters");
    let thin = picture("scattering = 1e-6");
    let error = difference(&layer(&thin.image, "caustic"), &layer(&clear.image, "caustic"));
    assert!(error < UNSEEN, "thin water changes the floor by {error}");
    // Light in thin water goes with the coefficient.
    let thicker = sum(&layer(&picture("scattering = 1e-5").image, "caustic_volume"));
    let ratio = thicker / sum(&layer(&thin.image, "caustic_volume"));
    assert!((ratio / 10.0 - 1.0).abs() < 1e-3, "ten times as much scatters {ratio} times the light");
    for coefficients in ["absorption = 10000\nscattering = 1", "scattering = 10000", "absorption = 10000"] {
        let thick = picture(coefficients);
        let left = sum(&layer(&thick.image, "caustic"));
        let part = left / sum(&layer(&clear.image, "caustic"));
        assert!(part < WATERLINE, "{coefficients}: {part} of the light gets through");
        let taken = watts(&thick, "absorbed") + watts(&thick, "scattered");
        println!("{coefficients}: {taken} W taken, {:?}", thick.stats.ledger);
        assert!(taken > 0.5 * watts(&clear, "landed"), "{coefficients}: {taken} W taken");
    }
}

pub fn elsewhere(request: &Request) {
    let text = std::fs::read_to_string("scenes/flat_water.toml").unwrap();
    let spot = "kind = \"spot\"\nposition = [1.5, 6, -1]\ntarget = [1.5, 9, -1]\nouter = 30\nintensity = 100";
    let away = text.replace("kind = \"point\"\nposition = [1.5, 6, -1]\nintensity = 100", spot);
    let dry =
        text.replace("kind = \"dielectric\"\nfront = \"air\"\nback = \"water\"", "kind = \"diffuse\"\nalbedo = 0.5");
    for (what, text) in [("a spot that looks away", away), ("no water", dry)] {
        let scene = scene::parse(&text, Path::new("scenes/flat_water.toml")).unwrap();
        let picture = render(request, scene, &[], |_| {});
        assert_sound(&picture);
        assert_eq!(sum(&layer(&picture.image, "caustic")), 0.0, "{what}");
        let told = picture.stats.warnings.iter().any(|warning| warning.contains("no light reaches a specular object"));
        assert!(told, "{what}: {:?}", picture.stats.warnings);
    }
}

/// Light that lands, over what it is where there is room: coarser beams say it less exactly, but all of it.
const COARSER: f64 = 0.01;

pub fn room(request: &Request) {
    let set = |vertices| [format!("beams.vertices={vertices}"), "beams.bounces=1".to_string()];
    let picture = |vertices| {
        let set = set(vertices);
        render(request, pool(), &[&set[0], &set[1]], |_| {})
    };
    let (roomy, cramped) = (picture(65_536), picture(4096));
    assert_sound(&roomy);
    assert!(counter(&cramped, "vertices") < 0.3 * counter(&roomy, "vertices"));
    let ratio = watts(&cramped, "landed") / watts(&roomy, "landed");
    assert!((ratio - 1.0).abs() < COARSER, "{ratio} of the light lands");
    let ratio = sum(&layer(&cramped.image, "caustic")) / sum(&layer(&roomy.image, "caustic"));
    println!("{ratio} of the light in the picture");
    assert!((ratio - 1.0).abs() < 10.0 * COARSER, "{ratio} of the light is in the picture");
    let told = cramped.stats.warnings.iter().any(|warning| warning.contains("no room to be as fine as asked for"));
    assert!(told, "{:?}", cramped.stats.warnings);
}
