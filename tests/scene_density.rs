//! Density grids of media: files, noise, and the sentence for each that is refused.

mod scene_text;

use std::fs;
use std::path::Path;

use glam::Vec3;
use nephroid::scene::{DensityGrid, Scene, SceneError, parse};
use scene_text::{check_sentence, sentence};

/// Line numbers in the sentences below count from the first line here.
const SOUND: &str = r#"[[camera]]
name = "eye"
position = [0, 1, 4]
target = [0, 0, 0]
[[medium]]
name = "smoke"
index = 1
scattering = 2
[medium.density]
kind = "noise"
lower = [-1, 0, -1]
upper = [1, 1, 3]
cell = 0.5
[[material]]
name = "sand"
kind = "diffuse"
albedo = 0.5
[[object]]
name = "ground"
shape = "plane"
size = [4, 4]
material = "sand"
[[light]]
name = "sun"
kind = "directional"
direction = [0, -1, 0]
irradiance = 1
medium = "smoke"
"#;

/// The only grid of the sound scene with `change` after its cells' size.
fn grid(change: &str) -> DensityGrid {
    let scene = scene_text::read(&SOUND.replace("cell = 0.5", &format!("cell = 0.5\n{change}"))).unwrap();
    assert_eq!(scene.media[1].density, Some(0));
    scene.densities[0].clone()
}

fn mean(grid: &DensityGrid) -> f64 {
    grid.values.iter().map(|&v| f64::from(v)).sum::<f64>() / grid.values.len() as f64
}

#[test]
fn noise_fills_its_box() {
    let found = grid("");
    assert_eq!((found.bounds.min, found.bounds.max), (Vec3::new(-1.0, 0.0, -1.0), Vec3::new(1.0, 1.0, 3.0)));
    assert_eq!(found.points, [32, 16, 64], "cells are square");
    assert_eq!(found.values.len(), 32 * 16 * 64);
    assert!(found.values.iter().all(|v| (0.0..=1.0).contains(v)));
    // Of some 60 features of standard deviation 1/4 over root 2.
    assert!((mean(&found) - 0.5).abs() < 0.1, "{}", mean(&found));
    let spread = found.values.iter().map(|&v| (f64::from(v) - mean(&found)).powi(2)).sum::<f64>();
    assert!((spread / found.values.len() as f64).sqrt() > 0.08);
    assert_eq!(found, grid("seed = 0"), "the same noise each time");
    assert_ne!(found, grid("seed = 1"));
    assert_eq!(grid("resolution = 3").points, [2, 2, 3], "two points along each axis at least");
}

#[test]
fn a_threshold_empties_and_a_fade_closes_the_box() {
    let thin = grid("threshold = 0.5");
    let empty = thin.values.iter().filter(|&&v| v == 0.0).count() as f64 / thin.values.len() as f64;
    assert!((0.3..0.7).contains(&empty), "{empty}");
    // Where there is something, it is what was above the threshold, stretched.
    for (thin, full) in thin.values.iter().zip(&grid("").values) {
        assert!((thin - ((full - 0.5) / 0.5).max(0.0)).abs() < 1e-6);
    }
    let faded = grid("fade = 0.25");
    let [x, y, z] = faded.points;
    for (index, &value) in (0u32..).zip(&faded.values) {
        let at = [index % x, index / x % y, index / (x * y)];
        let face = at.into_iter().zip([x, y, z]).any(|(at, points)| at == 0 || at + 1 == points);
        assert!(!face || value == 0.0, "{at:?}: {value}");
    }
    assert!(mean(&faded) > 0.1);
}

#[test]
fn noise_is_smooth_at_the_size_of_its_cells() {
    // One octave whose cells hold 16 points: neighbours differ by no more than the noise's steepest slope allows.
    let found = grid("octaves = 1");
    let row = &found.values[..32];
    let steepest = row.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f32::max);
    assert!(steepest < 0.25, "{steepest}");
}

/// A grid volume of 2 x 3 x 4 points that hold 0, 1, 2 ...
fn vol() -> Vec<u8> {
    let mut bytes = b"VOL\x03".to_vec();
    for word in [1i32, 2, 3, 4, 1] {
        bytes.extend(word.to_le_bytes());
    }
    for corner in [-1f32, -2.0, -3.0, 1.0, 2.0, 3.0] {
        bytes.extend(corner.to_le_bytes());
    }
    (0..24).for_each(|i| bytes.extend((i as f32).to_le_bytes()));
    bytes
}

/// The sound scene with a file of `bytes` for a density, and `more` beside its name.
fn with_file(bytes: &[u8], more: &str) -> Result<Scene, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("smoke.vol"), bytes).unwrap();
    let (before, rest) = SOUND.split_once("kind = \"noise\"").unwrap();
    let (_, after) = rest.split_once("cell = 0.5").unwrap();
    let text = format!("{before}file = \"smoke.vol\"\n{more}\n{after}");
    parse(&text, &folder.path().join("scene.toml"))
}

#[test]
fn a_file_is_read_and_placed() {
    let grid = with_file(&vol(), "").unwrap().densities.remove(0);
    assert_eq!((grid.bounds.min, grid.bounds.max), (Vec3::new(-1.0, -2.0, -3.0), Vec3::new(1.0, 2.0, 3.0)));
    assert_eq!(grid.points, [2, 3, 4]);
    assert_eq!(grid.values, (0..24).map(|i| i as f32).collect::<Vec<_>>());
    let grid = with_file(&vol(), "lower = [0, 0, 0]\nupper = [1, 5, 2]").unwrap().densities.remove(0);
    assert_eq!((grid.bounds.min, grid.bounds.max), (Vec3::ZERO, Vec3::new(1.0, 5.0, 2.0)));
    let grid = with_file(&vol(), "upper = [9, 9, 9]").unwrap().densities.remove(0);
    assert_eq!((grid.bounds.min, grid.bounds.max), (Vec3::new(-1.0, -2.0, -3.0), Vec3::splat(9.0)));
}

#[test]
fn each_wrong_file_has_its_sentence() {
    let changed = |at: usize, bytes: &[u8]| {
        let mut file = vol();
        file[at..at + bytes.len()].copy_from_slice(bytes);
        file
    };
    let no_volume = "is not a grid volume; allowed: Mitsuba's format VOL, version 3";
    let cases: Vec<(Vec<u8>, &str)> = vec![
        (Vec::new(), no_volume),
        (vol()[..47].to_vec(), no_volume),
        (changed(3, &[4]), no_volume),
        (changed(4, &[2]), "has encoding 2 and 1 channels; allowed: encoding 1, which is 32-bit floats, and 1 channel"),
        (
            changed(20, &[3]),
            "has encoding 1 and 3 channels; allowed: encoding 1, which is 32-bit floats, and 1 channel",
        ),
        (changed(8, &[1]), "has 1 x 3 x 4 points; allowed: 2 to 4096 along each axis and 33554432 in all"),
        (
            changed(8, &(-2i32).to_le_bytes()),
            "has -2 x 3 x 4 points; allowed: 2 to 4096 along each axis and 33554432 in all",
        ),
        (
            changed(8, &[0, 16, 0, 0, 0, 16, 0, 0, 0, 16, 0, 0]),
            "has 4096 x 4096 x 4096 points; allowed: 2 to 4096 along each axis and 33554432 in all",
        ),
        (vol()[..100].to_vec(), "is 100 bytes long; its 2 x 3 x 4 points need 144"),
        ([vol(), vec![0]].concat(), "is 145 bytes long; its 2 x 3 x 4 points need 144"),
        (changed(48, &(-1f32).to_le_bytes()), "holds -1 as value 0; allowed: numbers from 0 to 1e9"),
        (changed(140, &f32::NAN.to_le_bytes()), "holds NaN as value 23; allowed: numbers from 0 to 1e9"),
        (
            changed(24, &f32::INFINITY.to_le_bytes()),
            "has a box from [inf, -2.0, -3.0] to [1.0, 2.0, 3.0]; allowed: coordinates from -1e6 to 1e6, the last at \
             least 1e-6 above the first, or `lower` and `upper` beside it",
        ),
    ];
    for (bytes, expected) in cases {
        let sentence = with_file(&bytes, "").unwrap_err().to_string();
        assert!(sentence.contains("scene.toml:10: `medium.density.file` refers to "), "{sentence}");
        assert!(sentence.ends_with(&format!("smoke.vol, which {expected}")), "{sentence}\n{expected}");
        assert!(!sentence.contains('\n'));
    }
    let sentence = with_file(&vol(), "lower = [0, 2, 0]").unwrap_err().to_string();
    let expected = "`medium.density.lower` is the list [0, 2, 0]; allowed: a corner at least 1e-6 above the lower one along each axis";
    assert!(sentence.ends_with(expected), "{sentence}");
}

#[test]
fn each_wrong_value_has_its_sentence() {
    let cases = [
        (
            "kind = \"noise\"",
            "kind = \"smoke\"",
            "bad.toml:10: `medium.density.kind` is the text \"smoke\"; allowed: \"noise\"",
        ),
        (
            "kind = \"noise\"\n",
            "",
            "bad.toml:9: `density` lacks `kind`; allowed: \"noise\", or `file`, the name of a VOL file",
        ),
        (
            "kind = \"noise\"",
            "file = \"no.vol\"",
            "bad.toml:13: unknown key `cell` in the `density` of a file; allowed: file, lower, upper",
        ),
        ("cell = 0.5", "", "bad.toml:9: a noise `density` lacks `cell`; allowed: a number of metres"),
        ("cell = 0.5", "cell = 0", "bad.toml:13: `medium.density.cell` is 0; allowed: a number from 1e-6 to 1e6"),
        (
            "cell = 0.5",
            "cell = 1\nresolution = 257",
            "bad.toml:14: `medium.density.resolution` is 257; allowed: a whole number from 2 to 256",
        ),
        (
            "cell = 0.5",
            "cell = 1\nthreshold = 1",
            "bad.toml:14: `medium.density.threshold` is 1; allowed: a number from 0 to 0.95",
        ),
        (
            "upper = [1, 1, 3]",
            "upper = [1, 0, 3]",
            "bad.toml:12: `medium.density.upper` is the list [1, 0, 3]; allowed: a corner at least 1e-6 above the lower one along each axis",
        ),
        ("upper = [1, 1, 3]\n", "", "bad.toml:9: a noise `density` lacks `upper`; allowed: a list of three numbers"),
    ];
    for (from, to, expected) in cases {
        assert_eq!(sentence(SOUND, from, to), expected, "{to}");
    }
    let missing = SOUND.replace("kind = \"noise\"", "file = \"no.vol\"").replace("cell = 0.5", "");
    let error = parse(&missing, Path::new("bad.toml")).unwrap_err();
    check_sentence(&error);
    assert!(error.to_string().ends_with("no.vol, which cannot be read: there is no such file"), "{error}");
}

#[test]
fn a_sun_in_an_endless_medium_is_warned_of() {
    assert!(scene_text::read(SOUND).unwrap().warnings.is_empty(), "smoke ends");
    let (before, rest) = SOUND.split_once("[medium.density]").unwrap();
    let (_, after) = rest.split_once("cell = 0.5\n").unwrap();
    let warnings = scene_text::read(&format!("{before}{after}")).unwrap().warnings;
    assert_eq!(warnings, ["nothing of the directional light \"sun\" arrives: its medium \"smoke\" has no end"]);
}
