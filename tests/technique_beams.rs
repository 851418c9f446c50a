//! The technique `beams`, from lights to pictures and from given beams to light: closed forms, f64, a truth made elsewhere,
//! the reference, and itself.

#[path = "technique_beams/accumulate.rs"]
mod accumulate;
#[path = "technique_beams/agreement.rs"]
mod agreement;
mod beams;
mod common;
#[path = "technique_beams/extremes.rs"]
mod extremes;
#[path = "technique_beams/filter.rs"]
mod filter;
#[path = "technique_beams/lattice.rs"]
mod lattice;
#[path = "technique_beams/ledger.rs"]
mod ledger;
#[path = "technique_beams/pictures.rs"]
mod pictures;
#[path = "technique_beams/tiers.rs"]
mod tiers;
#[path = "technique_beams/volume.rs"]
mod volume;

use std::path::Path;
use std::process::ExitCode;

use common::measure::{assert_finite, counter, difference, sum, watts};
use common::pool::coarse;
use common::{Case, Request};
use nephroid::gpu::Capability;
use nephroid::render::{Picture, RenderSettings};
use nephroid::scene::{self, Scene};
use nephroid::technique::TechniqueKind;

fn main() -> ExitCode {
    common::run(&[
        Case { name: "leaves_add_up_to_the_light", needs: &[], disable: "", run: lattice::light },
        Case { name: "leaves_tile_the_lattice", needs: &[], disable: "", run: lattice::tiles },
        Case { name: "each_rule_splits", needs: &[], disable: "", run: lattice::rules },
        Case { name: "light_is_accounted_for", needs: &[], disable: "", run: ledger::adds_up },
        Case { name: "the_sun_comes_through_its_medium", needs: &[], disable: "", run: ledger::sun },
        Case { name: "flat_water_is_the_closed_form", needs: &[], disable: "", run: pictures::flat_water },
        Case { name: "beams_through_waves_are_the_truth", needs: &[], disable: "", run: pictures::waves },
        Case { name: "a_ball_of_glass_is_the_reference", needs: &[], disable: "", run: pictures::glass_sphere },
        Case { name: "tiers_agree", needs: &[Capability::GeometryShader], disable: "", run: agreement::tiers },
        Case { name: "equal_seeds_give_equal_bits", needs: &[], disable: "", run: agreement::equal_bits },
        Case { name: "a_frame_alone_is_the_frame_in_its_row", needs: &[], disable: "", run: agreement::frame_alone },
        Case { name: "adaptive_samples_keep_the_light", needs: &[], disable: "", run: agreement::adaptive },
        Case { name: "extreme_light_is_finite", needs: &[], disable: "", run: extremes::light },
        Case { name: "extreme_media_are_finite", needs: &[], disable: "", run: extremes::media },
        Case { name: "light_that_looks_elsewhere_is_told", needs: &[], disable: "", run: extremes::elsewhere },
        Case { name: "beams_without_room_are_coarse", needs: &[], disable: "", run: extremes::room },
        Case { name: "surfaces_are_lit_as_in_f64", needs: &[], disable: "", run: accumulate::surfaces },
        Case { name: "a_beam_lands_with_all_its_flux", needs: &[], disable: "", run: accumulate::flux },
        Case {
            name: "given_beams_of_flat_water_are_the_closed_form",
            needs: &[],
            disable: "",
            run: accumulate::flat_water,
        },
        Case { name: "shadows_fall", needs: &[], disable: "", run: accumulate::shadows },
        Case { name: "degenerate_beams_are_dark_or_finite", needs: &[], disable: "", run: accumulate::degenerate },
        Case { name: "adaptive_rounds_and_equal_bits", needs: &[], disable: "", run: accumulate::adaptive },
        Case { name: "the_filter_keeps_even_light_and_flux", needs: &[], disable: "", run: filter::flat_and_flux },
        Case { name: "the_filter_is_as_wide_as_it_says", needs: &[], disable: "", run: filter::width },
        Case { name: "the_filter_does_not_leak", needs: &[], disable: "", run: filter::leaks },
        Case { name: "the_filter_ends_at_bands", needs: &[], disable: "", run: filter::bands },
        Case { name: "the_filter_gives_equal_bits", needs: &[], disable: "", run: filter::equal_bits },
        Case { name: "media_scatter_as_in_f64", needs: &[], disable: "", run: volume::one_by_one },
        Case { name: "a_crowd_of_beams_adds_up", needs: &[], disable: "", run: volume::crowd },
        Case { name: "other_integrals_agree", needs: &[], disable: "", run: volume::integrals },
        Case { name: "given_beams_in_extreme_media_are_finite", needs: &[], disable: "", run: volume::extremes },
        Case { name: "flat_water_scatters_as_quadrature_says", needs: &[], disable: "", run: volume::flat_water },
        Case { name: "smoke_scatters_as_quadrature_says", needs: &[], disable: "", run: volume::smoke },
        Case { name: "levels_show_the_same_shafts", needs: &[], disable: "", run: volume::levels },
        Case { name: "water_of_any_strength_is_finite", needs: &[], disable: "", run: volume::strengths },
        Case { name: "tiers_agree_on_surfaces", needs: &[Capability::Graphics], disable: "", run: tiers::surfaces },
        Case { name: "tiers_agree_in_media", needs: &[Capability::Graphics], disable: "", run: tiers::media },
        Case {
            name: "tiers_share_what_mirrors_show",
            needs: &[Capability::Graphics],
            disable: "",
            run: tiers::mirrors,
        },
        Case { name: "tiers_can_be_switched_off", needs: &[], disable: "graphics", run: tiers::switched_off },
    ])
}

fn load(name: &str) -> Scene {
    scene::load(&Path::new("scenes").join(name)).unwrap()
}

fn pool() -> Scene {
    coarse("pool.toml")
}

/// A picture by beams that `change` sets up further.
fn render(request: &Request, scene: Scene, set: &[&str], change: impl FnOnce(&mut RenderSettings)) -> Picture {
    request.render(scene, |s| {
        s.technique = TechniqueKind::Beams;
        s.size = Some((24, 18));
        s.samples = Some(1);
        s.set = set.iter().map(|item| item.to_string()).collect();
        change(s);
    })
}

/// Asks that nothing was left out for being no number, or for want of room.
fn assert_sound(picture: &Picture) {
    for entry in &picture.stats.counters {
        let wrong = entry.name.contains("non_finite") || entry.name.ends_with("_dropped");
        assert!(!wrong || entry.value == 0.0, "{} {}", entry.value, entry.name);
    }
    assert_finite(picture);
}
