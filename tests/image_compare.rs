//! `compare` from files to report: layers, masks, the heat map and both ways to print.

use std::fs;
use std::path::{Path, PathBuf};

use nephroid::commands::compare::{CompareArgs, compare};
use nephroid::image::{FINAL_LAYER, Layer, LayeredImage, RgbImage, openexr, png};

fn grey(value: f32) -> RgbImage {
    RgbImage { width: 8, height: 4, pixels: vec![[value; 3]; 32] }
}

fn write(path: &Path, layers: &[(&str, f32)]) -> PathBuf {
    let layers = layers.iter().map(|(name, value)| Layer::from_rgb(name, &grey(*value))).collect();
    openexr::write(path, &LayeredImage { layers, ..Default::default() }).unwrap();
    path.to_owned()
}

fn args(test: &Path, truth: &Path) -> CompareArgs {
    CompareArgs { test: test.to_owned(), truth: truth.to_owned(), layer: None, mask: None, json: false, heatmap: None }
}

#[test]
fn a_layer_is_compared_with_its_twin_or_with_plain_rgb() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let test = write(&at("test.exr"), &[(FINAL_LAYER, 3.0), ("caustic", 1.5)]);
    let plain = write(&at("plain.exr"), &[(FINAL_LAYER, 1.0)]);
    let layered = write(&at("layered.exr"), &[(FINAL_LAYER, 1.0), ("caustic", 2.0)]);
    let ratio = |truth: &Path, layer: Option<&str>| {
        let args = CompareArgs { layer: layer.map(str::to_owned), ..args(&test, truth) };
        compare(&args).unwrap().metrics.energy_ratio
    };
    assert_eq!(ratio(&plain, None), 3.0);
    assert_eq!(ratio(&plain, Some("caustic")), 1.5);
    assert_eq!(ratio(&layered, Some("caustic")), 0.75);

    let absent = CompareArgs { layer: Some("volume".to_owned()), ..args(&test, &plain) };
    let error = compare(&absent).unwrap_err().to_string();
    assert!(error.ends_with("has no layer 'volume'; its layers are: final, caustic"), "{error}");
    let single = write(&at("single.exr"), &[("volume", 2.0)]);
    assert_eq!(compare(&args(&single, &plain)).unwrap().layer, "volume");
}

#[test]
fn mask_and_heat_map_are_files() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let test = write(&at("test.exr"), &[(FINAL_LAYER, 0.75)]);
    let truth = write(&at("truth.exr"), &[(FINAL_LAYER, 0.5)]);
    let mask: Vec<[u8; 3]> = (0..32).map(|i| [if i < 10 { 255 } else { 0 }; 3]).collect();
    png::write(&at("mask.png"), 8, 4, &mask).unwrap();
    let wanted = CompareArgs { mask: Some(at("mask.png")), heatmap: Some(at("error.png")), ..args(&test, &truth) };
    let report = compare(&wanted).unwrap();
    assert_eq!((report.metrics.pixels, report.heatmap_scale), (10, Some(0.25)));
    let map = png::read_linear(&at("error.png")).unwrap();
    assert_eq!((map.width, map.height), (8, 4));
    assert_ne!(map.pixels[0], map.pixels[31], "the mask shows");

    let misnamed = CompareArgs { heatmap: Some(at("error.exr")), ..args(&test, &truth) };
    let error = compare(&misnamed).unwrap_err().to_string();
    assert!(error.ends_with("a heat map is a PNG; give it a name that ends in .png"), "{error}");
    assert!(!fs::exists(at("error.exr")).unwrap());
}

#[test]
fn the_report_prints_as_table_and_as_one_object() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let test = write(&at("test.exr"), &[(FINAL_LAYER, 0.625)]);
    let truth = write(&at("truth.exr"), &[(FINAL_LAYER, 0.5)]);
    let report = compare(&args(&test, &truth)).unwrap();
    let table = report.to_string();
    for line in ["relative RMSE  25.0000 %", "energy ratio   1.250000", "bias           +25.0000 %"] {
        assert!(table.contains(line), "'{line}' is not in\n{table}");
    }
    let object = serde_json::to_value(&report).unwrap();
    assert_eq!(object["rel_rmse"], 0.25);
    assert_eq!(object["energy_ratio"], 1.25);
    assert_eq!(object["layer"], "final");
    assert_eq!(object["pixels"], 32);
    assert!(object.get("heatmap_scale").is_none());

    let same = compare(&args(&truth, &truth)).unwrap();
    assert!(same.to_string().contains("PSNR           equal"));
    assert!(serde_json::to_value(&same).unwrap()["psnr"].is_null());
}

#[test]
fn pictures_that_do_not_go_together_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let truth = write(&folder.path().join("truth.exr"), &[(FINAL_LAYER, 0.5)]);
    let test = folder.path().join("test.png");
    png::write(&test, 1, 1, &[[255; 3]]).unwrap();
    let error = compare(&args(&test, &truth)).unwrap_err().to_string();
    let expected = format!(
        "{} cannot be compared with {}: the test is 1x1 pixels and the truth 8x4; they must be \
         the same",
        test.display(),
        truth.display()
    );
    assert_eq!(error, expected);
}
