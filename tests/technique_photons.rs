//! The technique `photons` from lights to pictures: closed forms, the reference, and itself; and its filter.

#[path = "technique_photons/agreement.rs"]
mod agreement;
mod common;
#[path = "technique_photons/denoise/mod.rs"]
mod denoise;
#[path = "technique_photons/edges.rs"]
mod edges;
#[path = "technique_photons/extremes.rs"]
mod extremes;
#[path = "technique_photons/flat.rs"]
mod flat;
#[path = "technique_photons/ledger.rs"]
mod ledger;
#[path = "technique_photons/march.rs"]
mod march;
#[path = "technique_photons/points.rs"]
mod points;
#[path = "technique_photons/reference.rs"]
mod reference;
#[path = "technique_photons/refraction.rs"]
mod refraction;
#[path = "technique_photons/splats.rs"]
mod splats;

use std::path::Path;
use std::process::ExitCode;

use common::measure::{assert_finite, counter, difference, sum, watts};
use common::{Case, Request};
use nephroid::render::{Picture, RenderSettings};
use nephroid::scene::{self, Scene};
use nephroid::technique::TechniqueKind;

fn main() -> ExitCode {
    let case = |name, run| Case { name, needs: &[], disable: "", run };
    let cases = vec![
        case("even_light_is_flat_at_every_tilt", flat::even as fn(&Request)),
        case("flat_water_sends_the_closed_form", flat::water),
        case("a_flat_mirror_shows_its_lamp_twice", flat::mirror),
        case("slats_shine_evenly", edges::slats_shine_evenly),
        case("unseen_light_goes_by_the_shading_normal", edges::unseen_light_goes_by_the_shading_normal),
        case("screen_space_refraction_shows_what_points_show", refraction::screen),
        case("blue_points_have_less_noise_and_the_same_light", points::blue),
        case("discs_make_even_light_smoother", splats::smoother),
        case("discs_keep_to_their_surface", splats::keep_to_their_surface),
        case("both_marches_hit_the_same", march::both),
        case("photons_are_accounted_for", ledger::adds_up),
        case("fresnel_choice_loses_no_light", ledger::fresnel),
        case("faint_photons_are_a_game_of_chance", ledger::faint),
        case("single_specular_light_is_the_reference", reference::single),
        case("ways_to_see_agree", agreement::tiers),
        case("drivers_hit_the_same", agreement::drivers),
        case("equal_seeds_give_equal_photons", agreement::equal_bits),
        case("a_frame_of_photons_alone_is_that_in_its_row", agreement::frame_alone),
        case("bands_are_the_whole_picture", agreement::bands),
        case("adaptive_samples_keep_the_photons", agreement::adaptive),
        case("photons_without_anything_to_meet", extremes::nothing),
        case("photons_at_odd_settings_are_sound", extremes::settings),
        case("photons_at_any_scale_are_alike", extremes::scales),
        case("photons_in_media_and_rough_mirrors", extremes::media),
        case("a_flat_field_stays_flat", denoise::space::flat),
        case("light_stays_on_its_surface", denoise::space::edges),
        case("flux_is_kept_on_slanting_surfaces", denoise::space::flux),
        case("noise_falls", denoise::space::noise),
        case("histories_are_means", denoise::history::means),
        case("a_camera_that_moves_keeps_what_it_saw", denoise::history::camera),
        case("an_object_that_moves_takes_its_history_along", denoise::history::object),
        case("light_that_changes_does_not_lag", denoise::history::change),
        case("adapting_keeps_the_light", denoise::history::steady),
        case("pictures_have_less_noise_and_the_same_light", denoise::pictures::noise),
        case("frames_of_a_still_scene_converge", denoise::pictures::frames),
    ];
    common::run(cases.leak())
}

fn load(name: &str) -> Scene {
    scene::load(&Path::new("scenes").join(name)).unwrap()
}

/// A shipped scene with some of its text changed.
fn changed(name: &str, changes: &[(&str, &str)]) -> Scene {
    let path = Path::new("scenes").join(name);
    let mut text = std::fs::read_to_string(&path).unwrap();
    for (from, to) in changes {
        assert!(text.contains(from), "{name} has no {from}");
        text = text.replace(from, to);
    }
    scene::parse(&text, &path).unwrap()
}

/// The pool with less water, so that it is quick.
fn pool() -> Scene {
    changed("pool.toml", &[("quads = [256, 256]", "quads = [64, 64]")])
}

/// A small picture by few photons that `change` sets up further.
fn render(request: &Request, scene: Scene, set: &[&str], change: impl FnOnce(&mut RenderSettings)) -> Picture {
    let few = ["photons.photons=20000", "photons.resolution=256"];
    request.render(scene, |s| {
        s.technique = TechniqueKind::Photons;
        s.size = Some((24, 18));
        s.samples = Some(1);
        s.set = few.iter().chain(set).map(|item| item.to_string()).collect();
        change(s);
    })
}

/// Asks that nothing was left out for being no number, or for want of room or steps.
fn assert_sound(picture: &Picture) {
    assert_eq!(watts(picture, "non_finite"), 0.0);
    for name in ["photons_dropped", "marches_cut"] {
        assert_eq!(counter(picture, name), 0.0, "{name}");
    }
    assert_finite(picture);
}
