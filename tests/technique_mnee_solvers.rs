//! The baselines of the technique `mnee`: Newton's method and specular manifold sampling against closed forms, the walk
//! and themselves.

mod common;

use std::process::ExitCode;

use common::measure::counter;
use common::pool::{coarse, flat_water_irradiance, floor_point};
use common::{Case, Request, layer};
use nephroid::random;
use nephroid::render::Picture;
use nephroid::technique::TechniqueKind;

fn main() -> ExitCode {
    common::run(&[
        Case { name: "flat_water_is_the_closed_form", needs: &[], disable: "", run: flat_water },
        Case { name: "flat_water_is_right_on_average", needs: &[], disable: "", run: flat_water_unbiased },
        Case { name: "newton_finds_the_walks_path", needs: &[], disable: "", run: newton_and_walk },
        Case { name: "unbiased_has_the_walks_energy", needs: &[], disable: "", run: unbiased_and_walk },
        Case { name: "more_starts_find_more", needs: &[], disable: "", run: biased_and_walk },
        Case { name: "a_cap_darkens_and_is_counted", needs: &[], disable: "", run: cap },
        Case { name: "equal_seeds_give_equal_bits", needs: &[], disable: "", run: bits },
        Case { name: "all_numbers_are_finite", needs: &[], disable: "", run: finite },
        Case { name: "settings_without_use_are_told", needs: &[], disable: "", run: told },
    ])
}

const WALK: &str = "mnee.solver=walk";
const NEWTON: &str = "mnee.solver=newton";
const BIASED: &str = "mnee.solver=sms-biased";
const UNBIASED: &str = "mnee.solver=sms-unbiased";

/// Standard errors that a mean may be off by.
const CONFIDENCE: f64 = 4.0;

/// A picture by `mnee`, of the camera under the water where the scene has one.
fn render(request: &Request, scene: &str, size: (u32, u32), samples: u32, set: &[&str]) -> Picture {
    let scene = coarse(scene);
    let under = scene.cameras.iter().find(|camera| camera.name == "under").map(|camera| camera.name.clone());
    request.render(scene, |s| {
        s.technique = TechniqueKind::Mnee;
        s.camera = under;
        s.size = Some(size);
        s.samples = Some(samples);
        s.set = set.iter().map(|s| s.to_string()).collect();
    })
}

fn caustic(picture: &Picture) -> Vec<f64> {
    layer(&picture.image, "caustic").iter().map(|p| f64::from(p[1])).collect()
}

/// What one sample of flat water shows at each floor pixel over what it should, at the very points that it sees.
fn flat_water_ratios(request: &Request, (width, height): (u32, u32), set: &[&str]) -> (Picture, Vec<f64>) {
    let picture = render(request, "flat_water.toml", (width, height), 1, set);
    let irradiance = caustic(&picture);
    let [jitter_x, jitter_y] = random::sample_2d(0, 0).map(f64::from);
    let mut ratios = Vec::new();
    for row in 0..height {
        for column in 0..width {
            let (x, y) = (f64::from(column) + jitter_x - 0.5, f64::from(row) + jitter_y - 0.5);
            if let Some((x, z)) = floor_point(x, y, width.into(), height.into()) {
                ratios.push(irradiance[(row * width + column) as usize] / flat_water_irradiance(x, z));
            }
        }
    }
    assert!(ratios.len() > (width * height / 4) as usize);
    (picture, ratios)
}

fn flat_water(request: &Request) {
    for set in [WALK, NEWTON, BIASED] {
        let (picture, ratios) = flat_water_ratios(request, (48, 36), &[set]);
        let worst = ratios.iter().map(|ratio| (ratio - 1.0).abs()).fold(0.0, f64::max);
        println!("{set}: {} points, worst {worst:.2e}, {:?}", ratios.len(), picture.stats.counters);
        // Nothing is left to chance but whether a start finds the path, and all but one in fifty do: of twenty never none.
        assert!(worst < 1e-3, "{set}: {worst}");
    }
}

/// Mean and its standard error.
fn mean(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}

fn flat_water_unbiased(request: &Request) {
    let (picture, ratios) = flat_water_ratios(request, (128, 96), &[UNBIASED]);
    let (mean, error) = mean(&ratios);
    println!("{} points: {mean:.4} +- {error:.4}, {:?}", ratios.len(), picture.stats.counters);
    assert!((mean - 1.0).abs() < CONFIDENCE * error, "{mean} +- {error}");
    assert!(error < 0.02, "{error}");
    assert_eq!(counter(&picture, "trials_capped"), 0.0);
    // A path, where the start finds it at all, is seen a whole number of times.
    assert!(ratios.iter().all(|ratio| (ratio - ratio.round()).abs() < 1e-3 * ratio.max(1.0)));
    assert!(ratios.iter().any(|ratio| *ratio > 1.5) && ratios.iter().any(|ratio| *ratio < 0.5));
}

fn newton_and_walk(request: &Request) {
    let pixels = |set: &[&str]| caustic(&render(request, "pool.toml", (96, 72), 1, set));
    let (all, one, newton) = (pixels(&[WALK]), pixels(&[WALK, "mnee.solutions=one"]), pixels(&["mnee.solver=newton"]));
    // Where the first path has all the light there is but one.
    let single: Vec<usize> = (0..all.len()).filter(|&i| all[i] > 0.0 && (one[i] / all[i] - 1.0).abs() < 1e-6).collect();
    let agree = single.iter().filter(|&&i| (newton[i] / all[i] - 1.0).abs() < 2e-3).count();
    let dark = single.iter().filter(|&&i| newton[i] == 0.0).count();
    println!("{} of {} points have one path; Newton's is the same in {agree}, dark {dark}", single.len(), all.len());
    assert!(single.len() > all.len() / 2);
    // The rest are starts that Newton's method leads nowhere, or to where it turns in circles.
    assert!(agree as f64 > NEWTON_AGREES * single.len() as f64, "{agree} of {}", single.len());
    assert!(
        agree + dark == single.len(),
        "{} points have another path than the one there is",
        single.len() - agree - dark
    );
}

/// Part of the points with one path at which Newton's method finds it: 99.0 % on the pool, whose waves are gentle.
const NEWTON_AGREES: f64 = 0.98;

fn unbiased_and_walk(request: &Request) {
    let pixels = |set: &[&str]| caustic(&render(request, "pool.toml", (48, 36), 8, set));
    let (walk, unbiased) = (pixels(&[WALK]), pixels(&[UNBIASED]));
    let differences: Vec<f64> = unbiased.iter().zip(&walk).map(|(u, w)| u - w).collect();
    let (difference, error) = mean(&differences);
    let (level, _) = mean(&walk);
    println!("energy {:.4} +- {:.4}", 1.0 + difference / level, error / level);
    assert!(difference.abs() < CONFIDENCE * error, "{difference} +- {error}");
    // Small enough to tell an estimate that leaves the number of trials out, which is a quarter too dark. Were the random
    // numbers of all samples the same, it would be twice that.
    assert!(error < 0.015 * level, "{error} of {level}");
}

fn biased_and_walk(request: &Request) {
    let energy = |set: &[&str]| caustic(&render(request, "pool.toml", (32, 24), 2, set)).iter().sum::<f64>();
    let walk = energy(&[WALK]);
    let ratios = ["mnee.trials=1", "mnee.trials=5", "mnee.trials=50"].map(|trials| energy(&[BIASED, trials]) / walk);
    println!("energy over the walk's by 1, 5 and 50 starts: {ratios:?}");
    assert!(ratios[0] < ratios[1] && ratios[1] < ratios[2]);
    // A path that fifty starts miss is one that few lead to: at folds, and dim.
    assert!((ratios[2] - 1.0).abs() < 0.01, "{ratios:?}");
    assert!(ratios[0] < 0.9, "{ratios:?}");
}

fn cap(request: &Request) {
    let picture = |set: &[&str]| render(request, "pool.toml", (48, 36), 2, set);
    let energy = |picture: &Picture| caustic(picture).iter().sum::<f64>();
    let capped = picture(&[UNBIASED, "mnee.trials=1"]);
    let ratio = energy(&capped) / energy(&picture(&[WALK]));
    println!("energy with a cap of one trial: {ratio}, capped {}", counter(&capped, "trials_capped"));
    // Each path counts once at most, and one start in four finds none.
    assert!(ratio < 0.9, "{ratio}");
    assert!(counter(&capped, "trials_capped") > 0.0);
}

fn bits(request: &Request) {
    for set in [NEWTON, BIASED, UNBIASED] {
        let first = render(request, "pool.toml", (48, 36), 1, &[set, "mnee.trials=5"]).image;
        let second = render(request, "pool.toml", (48, 36), 1, &[set, "mnee.trials=5"]).image;
        let same = layer(&first, "final") == layer(&second, "final");
        assert!(same, "{set}: equal seeds, different bits");
    }
}

fn finite(request: &Request) {
    for scene in ["pool.toml", "glass_sphere.toml", "cornell_flooded.toml", "cup.toml", "lagoon.toml"] {
        for set in [NEWTON, BIASED, UNBIASED] {
            let picture = render(request, scene, (16, 12), 1, &[set, "mnee.trials=10"]);
            let name = format!("{scene} {set}");
            assert_eq!(counter(&picture, "non_finite"), 0.0, "{name}");
            assert!(!picture.stats.warnings.iter().any(|w| w.contains("not finite")), "{name}");
            assert!(caustic(&picture).iter().all(|v| v.is_finite() && *v >= 0.0), "{name}");
        }
    }
}

fn told(request: &Request) {
    let warnings = |set: &[&str]| render(request, "flat_water.toml", (8, 6), 1, set).stats.warnings;
    assert!(warnings(&[NEWTON]).is_empty());
    let told = warnings(&[NEWTON, "mnee.solutions=one"]);
    assert!(told.iter().any(|w| w.contains("mnee.solutions=one is for mnee.solver=walk")), "{told:?}");
}
