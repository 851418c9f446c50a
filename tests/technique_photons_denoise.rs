//! The filter of photons' irradiance: on fields and surfaces made up here, against closed forms, and in pictures.

#[path = "technique_photons_denoise/bed.rs"]
mod bed;
mod common;
#[path = "technique_photons_denoise/history.rs"]
mod history;
#[path = "technique_photons_denoise/pictures.rs"]
mod pictures;
#[path = "technique_photons_denoise/space.rs"]
mod space;

use std::process::ExitCode;

use common::Case;

fn main() -> ExitCode {
    common::run(&[
        Case { name: "a_flat_field_stays_flat", needs: &[], disable: "", run: space::flat },
        Case { name: "light_stays_on_its_surface", needs: &[], disable: "", run: space::edges },
        Case { name: "flux_is_kept_on_slanting_surfaces", needs: &[], disable: "", run: space::flux },
        Case { name: "noise_falls", needs: &[], disable: "", run: space::noise },
        Case { name: "histories_are_means", needs: &[], disable: "", run: history::means },
        Case { name: "a_camera_that_moves_keeps_what_it_saw", needs: &[], disable: "", run: history::camera },
        Case { name: "an_object_that_moves_takes_its_history_along", needs: &[], disable: "", run: history::object },
        Case { name: "light_that_changes_does_not_lag", needs: &[], disable: "", run: history::change },
        Case { name: "adapting_keeps_the_light", needs: &[], disable: "", run: history::steady },
        Case { name: "pictures_have_less_noise_and_the_same_light", needs: &[], disable: "", run: pictures::noise },
        Case { name: "frames_of_a_still_scene_converge", needs: &[], disable: "", run: pictures::frames },
    ])
}
