//! Bad input: one sentence that says what was found and what is allowed, the right exit status, and no file touched.

use std::fs;

use nephroid::technique::TechniqueKind;

use crate::program::{Folder, SCENE};

/// `nephroid render` fails with this one sentence.
fn fails(arguments: &str, sentence: &str) {
    fails_in(&Folder::new(), arguments, &[], sentence);
}

fn fails_in(folder: &Folder, arguments: &str, environment: &[(&str, &str)], sentence: &str) {
    let mut command = folder.command(["render"].into_iter().chain(arguments.split_whitespace()));
    command.envs(environment.iter().copied());
    assert_eq!(folder.refused(command, 1), format!("nephroid: {sentence}\n"), "{arguments}");
}

/// `nephroid render scene.toml -o kept.exr` with these options is wrong usage.
fn misused(options: &str, message: &str) {
    let folder = Folder::new();
    let arguments = ["render", "scene.toml", "-o", "kept.exr"].into_iter().chain(options.split_whitespace());
    let stderr = folder.refused(folder.command(arguments), 2);
    let (first, _) = stderr.split_once("\n\n").unwrap();
    assert_eq!(first, format!("error: {message}"), "{options}");
}

#[test]
fn scenes() {
    fails("gone.toml -o kept.exr", "the scene file gone.toml cannot be read: there is no such file");
    fails(". -o kept.exr", "the scene file . cannot be read: it is a folder");

    let folder = Folder::new();
    fs::write(folder.at("scene.toml"), "[film\n").unwrap();
    let sentence = "scene.toml:1:6: not valid TOML: unclosed table, expected `]`";
    fails_in(&folder, "scene.toml -o kept.exr", &[], sentence);
    fs::write(folder.at("scene.toml"), SCENE.replace("samples = 2", "sample = 2")).unwrap();
    let sentence = "scene.toml:5: unknown key `sample` in [film]; allowed: width, height, samples, exposure, tone_curve, \
                    background, volume_samples";
    fails_in(&folder, "scene.toml -o kept.exr", &[], sentence);
}

#[test]
fn sizes_and_counts() {
    let sides = "allowed are whole numbers from 1 to 16384";
    for (size, found) in [
        ("0x12", "the width is '0'"),
        ("16x0", "the height is '0'"),
        ("1000000x12", "the width is '1000000'"),
        ("16x1000000", "the height is '1000000'"),
        ("-4x12", "the width is '-4'"),
        ("16x", "the height is ''"),
    ] {
        misused(&format!("--size {size}"), &format!("invalid value '{size}' for '--size <WxH>': {found}; {sides}"));
    }
    for size in ["abc", "1000000", "0"] {
        let wanted = "wanted are width x height in pixels, such as 640x480, each from 1 to 16384";
        misused(&format!("--size {size}"), &format!("invalid value '{size}' for '--size <WxH>': {wanted}"));
    }
    for samples in ["0", "1000001", "-1"] {
        let message = format!("invalid value '{samples}' for '--samples <N>': {samples} is not in 1..=1000000");
        misused(&format!("--samples {samples}"), &message);
    }
    misused("--seed -1", "invalid value '-1' for '--seed <N>': -1 is not in 0..=4294967295");
}

fn technique_names() -> String {
    TechniqueKind::ALL.iter().map(|technique| technique.name()).collect::<Vec<_>>().join(", ")
}

#[test]
fn unknown_names() {
    misused(
        "--technique phlogiston",
        &format!("invalid value 'phlogiston' for '--technique <NAME>'\n  [possible values: {}]", technique_names()),
    );
    misused(
        "--trace guess",
        "invalid value 'guess' for '--trace <HOW>'\n  [possible values: auto, ray-query, bvh, bvh2, cwbvh]",
    );
    misused(
        "--disable ray-qeury",
        "invalid value 'ray-qeury' for '--disable <LIST>': unknown capability \"ray-qeury\" in the list of what to \
         disable; allowed are: ray-query, graphics, precise-raster, geometry-shader, float-atomics, timestamps",
    );
    misused("--colour red", "unexpected argument '--colour' found");
    let sentence = "scene.toml has no camera \"side\"; it has: above, under";
    fails("scene.toml -o kept.exr --camera side", sentence);

    for technique in ["none", "reference"] {
        let sentence = format!(
            "adaptive sampling needs a technique that finds the light of each sample by itself, and {technique} with \
             these settings does not"
        );
        fails(&format!("scene.toml -o kept.exr --technique {technique} --adaptive"), &sentence);
    }

    let folder = Folder::new();
    let names = folder.device_names();
    let found: Vec<_> = names.iter().enumerate().map(|(index, name)| format!("{index} {name}")).collect();
    let sentence = format!("no Vulkan device matches \"abacus\"; there are: {}", found.join("; "));
    fails_in(&folder, "scene.toml -o kept.exr --device abacus", &[], &sentence);
    fails_in(&folder, "scene.toml -o kept.exr", &[("NEPHROID_DEVICE", "abacus")], &sentence);
}

#[test]
fn settings() {
    let keys = TechniqueKind::Reference.settings().iter().map(|setting| setting.key).collect::<Vec<_>>().join(", ");
    let unknown = format!("the technique reference has no setting \"phlogiston\"; it has: {keys}");
    for (setting, sentence) in [
        ("photons", "\"photons\" is not of the form technique.key=value, such as reference.photons=1000000"),
        ("phlogiston.photons=1", &format!("there is no technique \"phlogiston\"; allowed are: {}", technique_names())),
        ("reference.phlogiston=1", &unknown),
        ("reference.photons=0", "reference.photons is \"0\"; allowed is an integer from 1 to 4000000"),
        ("reference.photons=many", "reference.photons is \"many\"; allowed is an integer from 1 to 4000000"),
        ("reference.radius=1e9", "reference.radius is \"1e9\"; allowed is a number from 0.1 to 100"),
        ("reference.alpha=nan", "reference.alpha is \"nan\"; allowed is a number from 0.1 to 0.99"),
        ("reference.fresnel=both", "reference.fresnel is \"both\"; allowed is one of chance, split"),
    ] {
        fails(&format!("scene.toml -o kept.exr --technique reference --set {setting}"), sentence);
    }
    fails(
        "scene.toml -o kept.exr --technique none --set reference.photons=1000",
        "the setting \"reference.photons=1000\" is for another technique than none, which is the one in use",
    );
}

#[test]
fn outputs() {
    fails("scene.toml -o gone/out.exr", "gone/out.exr: cannot be written: the folder gone does not exist");
    // Of several outputs none is written where one cannot be.
    fails("scene.toml -o kept.exr -o gone/out.png", "gone/out.png: cannot be written: the folder gone does not exist");
    let formats = "the file name ends in neither .exr nor .png, the formats known here";
    fails("scene.toml -o out.jpg", &format!("out.jpg: {formats}"));
    fails("scene.toml -o out", &format!("out: {formats}"));
    let folder = Folder::new();
    fs::create_dir(folder.at("folder.png")).unwrap();
    fails_in(&folder, "scene.toml -o folder.png", &[], "folder.png: cannot be written: it is a folder");
    let stats = "scene.toml -o kept.exr --stats";
    fails_in(&folder, &format!("{stats} folder.png"), &[], "folder.png: cannot be written: it is a folder");
    for (options, first) in [("-o ./kept.exr", "--output"), ("--stats kept.exr", "--stats")] {
        let second = "--output";
        let path = if first == second { "./kept.exr" } else { "kept.exr" };
        let sentence = format!("{path}: {first} and {second} name the same file; each needs its own");
        fails(&format!("scene.toml -o kept.exr {options}"), &sentence);
    }
    let sentence = "gone/stats.json: cannot be written: the folder gone does not exist";
    fails_in(&folder, &format!("{stats} gone/stats.json"), &[], sentence);

    let stderr = folder.refused(folder.command(["render", "scene.toml"]), 2);
    assert!(stderr.starts_with("error: the following required arguments were not provided:\n  --output <FILE>\n"));
}

#[test]
fn drivers_and_layers_that_are_missing() {
    let folder = Folder::new();
    let render = "scene.toml -o kept.exr";
    let no_device = "the Vulkan loader reports no device; install a driver for the GPU, or lavapipe, a software driver: \
                     the package mesa-vulkan-drivers on Debian and Ubuntu";
    let nowhere = [("VK_DRIVER_FILES", "/nonexistent"), ("VK_ICD_FILENAMES", "/nonexistent")];
    fails_in(&folder, render, &nowhere, no_device);
    for arguments in [&["devices"][..], &["devices", "--json"]] {
        let mut command = folder.command(arguments);
        command.envs(nowhere);
        assert_eq!(folder.refused(command, 1), format!("nephroid: {no_device}\n"));
    }

    // A folder without layers.
    let here = folder.at("");
    let no_layers = [("VK_LAYER_PATH", here.to_str().unwrap()), ("VK_ADD_LAYER_PATH", "")];
    let sentence = "validation was asked for, but the layer VK_LAYER_KHRONOS_validation is not installed";
    fails_in(&folder, &format!("{render} --validation"), &no_layers, sentence);
}

#[cfg(target_os = "linux")]
#[test]
fn a_loader_that_is_missing() {
    let folder = Folder::new();
    // A file of that name that is no library stands in for a loader that is not there.
    let library = folder.at("libvulkan.so.1");
    fs::write(&library, "").unwrap();
    let here = folder.at("");
    let sentence = format!(
        "no Vulkan loader was found ({}: file too short); install one: the package libvulkan1 on Debian and Ubuntu, \
         vulkan-loader on Fedora, vulkan-icd-loader on Arch",
        library.display()
    );
    let environment = [("LD_LIBRARY_PATH", here.to_str().unwrap().trim_end_matches('/'))];
    fails_in(&folder, "scene.toml -o kept.exr", &environment, &sentence);
}

#[test]
fn capabilities_with_no_fallback() {
    let message = "the capability compute cannot be disabled: it has no fallback";
    misused("--disable compute", &format!("invalid value 'compute' for '--disable <LIST>': {message}"));
    let folder = Folder::new();
    let sentence = format!(
        "the device {} has no ray queries in use, so that --trace ray-query cannot be; use auto or bvh",
        folder.device_names()[0]
    );
    let arguments = "scene.toml -o kept.exr --device 0 --trace ray-query --disable ray-query";
    fails_in(&folder, arguments, &[], &sentence);
}

#[test]
fn comparisons_and_pages() {
    let folder = Folder::new();
    let stderr = folder.refused(folder.command(["compare", "gone.exr", "kept.exr"]), 1);
    assert!(stderr.starts_with("nephroid: gone.exr: cannot be read: "), "{stderr}");
    let stderr = folder.refused(folder.command(["man", "woman"]), 1);
    let view = if cfg!(feature = "viewer") { "view, " } else { "" };
    let allowed = format!("render, animate, {view}compare, volume, devices, conformance, completions, man, help");
    let sentence = format!("there is no command 'woman' to print a manual page of; allowed are: {allowed}");
    assert_eq!(stderr, format!("nephroid: {sentence}\n"));
    let stderr = folder.refused(folder.command(["completions", "crab"]), 2);
    assert!(stderr.contains("invalid value 'crab' for '<SHELL>'"), "{stderr}");
}

#[cfg(feature = "hot-reload")]
#[test]
fn folders_without_kernels() {
    fails(
        "scene.toml -o kept.exr --quiet --watch-kernels=.",
        "the kernels cannot be watched: . is not a folder with kernel sources",
    );
}
