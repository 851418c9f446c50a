//! Where the light goes, in sum.

use nephroid::render::Picture;
use nephroid::scene::Scene;

use crate::common::{Request, layer};
use crate::flat::{even_scene, mirror_scene, transmittance};
use crate::march::tube;
use crate::{assert_sound, changed, counter, load, pool, render, sum, watts};

/// Of the entries' sum: each amount is rounded to a unit, and is a f32.
const BALANCE: f64 = 1e-5;

fn assert_balance(what: &str, picture: &Picture) {
    let emitted = watts(picture, "emitted");
    let booked: f64 = picture.stats.ledger.iter().skip(1).map(|entry| entry.watts).sum();
    println!("{what}: {:.2e} off, {:?}", booked / emitted - 1.0, picture.stats.ledger);
    assert!(emitted > 0.0 && (booked / emitted - 1.0).abs() < BALANCE, "{what}: {booked} of {emitted} W");
    assert_sound(picture);
}

pub fn adds_up(request: &Request) {
    let small = ("[256, 256]", "[64, 64]");
    let absorbing = "index = 1.33\nabsorption = [0.3, 0.1, 0]";
    let turbid = "index = 1.33\nabsorption = 0.1\nscattering = [0.1, 0.2, 0.3]";
    let scenes: [(&str, Scene, &[&str]); 6] = [
        ("waves", pool(), &["landed", "hidden"]),
        ("absorbing water", changed("pool.toml", &[small, ("index = 1.33", absorbing)]), &["landed", "absorbed"]),
        (
            "turbid water",
            changed("pool.toml", &[small, ("index = 1.33", turbid)]),
            &["landed", "absorbed", "scattered"],
        ),
        ("brass", load("cup.toml"), &["landed", "absorbed", "missed"]),
        ("a tube", tube(), &["landed", "absorbed"]),
        ("flooded", load("cornell_flooded.toml"), &["landed", "hidden"]),
    ];
    for (what, scene, there) in scenes {
        for rescue in ["off", "rays"] {
            let set = format!("photons.rescue={rescue}");
            let picture = render(request, scene.clone(), &[&set], |s| s.samples = Some(2));
            assert_balance(&format!("{what}, rescue {rescue}"), &picture);
            for entry in there {
                assert!(watts(&picture, entry) > 0.0, "{what}, rescue {rescue}: nothing {entry}");
            }
            // What the views lose of the open pool goes off into the air.
            let rescued = rescue == "rays" && what == "flooded";
            assert!(!rescued || watts(&picture, "rescued") > 0.0, "{what}: nothing is rescued");
            assert!(rescue == "rays" || watts(&picture, "rescued") == 0.0, "{what}: rays where none are asked for");
            assert!(rescue == "off" || watts(&picture, "lost") == 0.0, "{what}: rays lose light");
            // Over the camera's view, outlines take up what a ray sees pass by.
            assert!(rescue == "off" || counter(&picture, "camera_steps") == 0.0, "{what}: no ray is asked");
        }
    }
}

/// Of the light's parts: three standard deviations of 100,000 choices.
const CHANCE: f64 = 0.004;

/// What flat water reflects of a low sun goes off to where nothing is, and what passes lands.
pub fn fresnel(request: &Request) {
    let (sun, set) = (20f64.to_radians().sin(), ["photons.rescue=rays", "photons.photons=100000"]);
    let picture = render(request, even_scene(20.0), &set, |_| {});
    assert_balance("a low sun", &picture);
    let emitted = watts(&picture, "emitted") - watts(&picture, "missed");
    let part = |names: &[&str]| names.iter().map(|name| watts(&picture, name)).sum::<f64>() / emitted;
    let (up, down) = (part(&["escaped"]), part(&["landed", "hidden", "rescued"]));
    let passed = transmittance(sun, 1.33);
    println!("{up} reflected, {down} refracted, {passed} expected");
    assert!((up + down - 1.0).abs() < 1e-3, "{up} + {down} of the light go on");
    assert!((down - passed).abs() < CHANCE, "{down} of the light passes, not {passed}");
}

/// What photons are more than faint ones by chance, over the picture.
const GAME: f64 = 0.03;

pub fn faint(request: &Request) {
    let picture = |luminance: &str| {
        let set = ["photons.photons=60000", luminance];
        let picture = render(request, mirror_scene(0.01), &set, |s| s.samples = Some(2));
        assert_sound(&picture);
        picture
    };
    let [all, some] = ["photons.luminance=0", "photons.luminance=0.04"].map(picture);
    assert_eq!(watts(&all, "faint"), 0.0);
    let followed = counter(&some, "photons_traced") / counter(&all, "photons_traced");
    // A hundredth of the mean flux, about, where four hundredths are the least.
    assert!((0.15..0.5).contains(&followed), "{followed} of the photons are followed");
    let [before, after] = [&all, &some].map(|picture| sum(&layer(&picture.image, "caustic")));
    println!("{followed} of the photons have {} of the light; {} W faint", after / before, watts(&some, "faint"));
    assert!((after / before - 1.0).abs() < GAME, "{} of the light", after / before);
    let reflected = 0.01 * watts(&some, "emitted");
    assert!(watts(&some, "faint").abs() < GAME * reflected, "{} W faint", watts(&some, "faint"));
    let booked: f64 = some.stats.ledger.iter().skip(1).map(|entry| entry.watts).sum();
    assert!((booked / watts(&some, "emitted") - 1.0).abs() < BALANCE);
}
