//! The command line, by running the binary.

mod animate;
mod program;
mod refusals;
mod trace_file;
mod volume;

use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use nephroid::image::{LayeredImage, openexr, png, tone};
use program::{Folder, Outcome, SCENE};

#[test]
fn help_and_version() {
    let folder = Folder::new();
    let help = folder.run("--help").stdout;
    let view: &[&str] = if cfg!(feature = "viewer") { &["view"] } else { &[] };
    let commands = ["render", "animate", "compare", "volume", "devices", "conformance", "completions", "man"];
    for command in commands.iter().chain(view) {
        assert!(help.contains(&format!("\n  {command} ")), "{command} is not in\n{help}");
        assert!(folder.run(&format!("{command} --help")).stdout.contains("Usage: nephroid"), "{command}");
    }
    assert_eq!(folder.run("--version").stdout, format!("nephroid {}\n", env!("CARGO_PKG_VERSION")));
    // The one place where a user finds the settings of techniques.
    assert!(folder.run("render --help").stdout.contains("\n  --set reference.photons="));
}

#[test]
fn completions_and_manual_pages() {
    let folder = Folder::new();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        assert!(folder.run(&format!("completions {shell}")).stdout.contains("technique"), "{shell}");
    }
    assert!(folder.run("man").stdout.contains(".TH nephroid 1"));
    assert!(folder.run("man render").stdout.contains(r"\-\-technique"));
}

#[test]
fn a_closed_pipe_ends_the_program_in_silence() {
    let folder = Folder::new();
    for arguments in ["man", "completions bash", "devices", "devices --json", "--help"] {
        let (reader, writer) = io::pipe().unwrap();
        drop(reader);
        let output = folder.command(arguments.split_whitespace()).stdout(writer).output().unwrap();
        let outcome = Outcome::of(output);
        assert_eq!((outcome.status, outcome.stderr.as_str()), (Some(0), ""), "{arguments}");
    }
}

#[test]
fn devices_are_listed_alike_as_table_and_json() {
    let folder = Folder::new();
    let devices: serde_json::Value = serde_json::from_str(&folder.run("devices --json").stdout).unwrap();
    let devices = devices.as_array().unwrap();
    assert!(!devices.is_empty());
    let table = folder.run("devices").stdout;
    for (index, device) in devices.iter().enumerate() {
        assert_eq!(device["index"], index);
        assert!(device["capabilities"].is_array() && device["limits"]["storage_range"].is_u64());
        let line = format!("{index}  {}", device["name"].as_str().unwrap());
        assert!(table.lines().any(|l| l == line), "'{line}' is not in\n{table}");
    }
}

#[test]
fn a_rendering_writes_what_it_says() {
    let folder = Folder::new();
    let outcome =
        folder.run("render scene.toml --technique none -o a.exr -o a.png --stats a.json --camera under --seed 7");
    assert_eq!(folder.files(), ["a.exr", "a.json", "a.png", "scene.toml"]);
    for name in ["a.exr", "a.png", "a.json"] {
        let line = format!("Wrote   {}", folder.at(name).display());
        assert!(outcome.stdout.lines().any(|l| l == line), "'{line}' is not in\n{}", outcome.stdout);
    }
    for word in ["Device  ", "Driver  ", "Tier    ", "Time    "] {
        assert!(outcome.stdout.lines().any(|l| l.starts_with(word)), "{}", outcome.stdout);
    }
    let (first, last) = (outcome.stderr.lines().next().unwrap(), outcome.stderr.lines().last().unwrap());
    assert!(first.starts_with("sample 1 of 2, ") && last.starts_with("sample 2 of 2, "), "{}", outcome.stderr);

    let file = openexr::read(&folder.at("a.exr")).unwrap();
    for layer in ["final", "caustic", "direct", "albedo", "normal", "depth"] {
        let layer = file.layer(layer).unwrap_or_else(|| panic!("there is no layer {layer}"));
        assert_eq!((layer.width, layer.height), (16, 12));
    }
    for (name, value) in [("camera", "under"), ("samples", "2"), ("seed", "7"), ("technique", "none")] {
        assert_eq!(file.attributes[&format!("nephroid.{name}")], value);
    }
    let picture = png::read_linear(&folder.at("a.png")).unwrap();
    assert_eq!((picture.width, picture.height), (16, 12));

    let stats: serde_json::Value = serde_json::from_slice(&std::fs::read(folder.at("a.json")).unwrap()).unwrap();
    let choice = stats["trace_choice"].as_str().unwrap();
    assert!(outcome.stdout.lines().any(|l| l == choice), "'{choice}' is not in\n{}", outcome.stdout);
    for (field, holds) in STATS_FIELDS {
        assert!(holds(&stats[field]), "{field} is {} in\n{stats:#}", stats[field]);
    }
}

/// What is promised of `--stats`, and whether a value will do.
type Promise = (&'static str, fn(&serde_json::Value) -> bool);
const STATS_FIELDS: [Promise; 12] = [
    ("device", is_named),
    ("driver", is_named),
    ("driver_version", is_named),
    ("capabilities", |v| v.is_array()),
    ("tier", is_named),
    ("trace", is_named),
    ("passes", |v| v.as_array().is_some_and(|passes| passes.iter().all(|pass| is_named(&pass["name"])))),
    ("cpu_seconds", |v| v.as_f64() > Some(0.0)),
    ("wall_seconds", |v| v.as_f64() > Some(0.0)),
    ("peak_memory_bytes", |v| v.as_u64() > Some(0)),
    ("ledger", |v| v.is_array()),
    ("warnings", |v| v.as_array().is_some_and(Vec::is_empty)),
];

fn is_named(value: &serde_json::Value) -> bool {
    value.as_str().is_some_and(|text| !text.is_empty())
}

#[test]
fn settings_come_from_the_scene_where_the_command_line_is_silent() {
    let folder = Folder::new();
    let own = "[technique.reference]\nphotons = 1000\nalpha = 0.5\n[technique.mnee]\nrest = \"photons\"\n";
    std::fs::write(folder.at("scene.toml"), format!("{SCENE}{own}")).unwrap();
    folder.run(
        "render scene.toml -o a.exr --size 8x8 --samples 1 --technique reference --set reference.alpha=0.75 --stats a.json",
    );
    let stats: serde_json::Value = serde_json::from_slice(&std::fs::read(folder.at("a.json")).unwrap()).unwrap();
    let settings = stats["settings"].as_array().unwrap();
    let value = |key: &str| settings.iter().find(|pair| pair[0] == key).unwrap()[1].as_str().unwrap();
    assert_eq!((value("photons"), value("alpha"), value("fresnel")), ("1000", "0.75", "chance"));
}

#[test]
fn a_png_is_exposed_and_tone_mapped_as_the_scene_says() {
    let folder = Folder::new();
    let film = "samples = 2\nexposure = 1.5\ntone_curve = \"reinhard\"";
    std::fs::write(folder.at("scene.toml"), SCENE.replace("samples = 2", film)).unwrap();
    folder.run("render scene.toml --technique none -o a.exr -o a.png --quiet");
    let linear = openexr::read(&folder.at("a.exr")).unwrap().select(Path::new("a.exr"), None).unwrap();
    assert!(linear.pixels.iter().any(|&pixel| tone::luminance(pixel) > 0.01), "the picture is black");
    let wanted = tone::display(&linear.pixels, 1.5, |colour| tone::reinhard_extended(colour, 4.0));
    let found = png::read_linear(&folder.at("a.png")).unwrap().pixels;
    assert!(found.into_iter().map(tone::to_srgb8).eq(wanted));
}

#[test]
fn a_device_variable_set_to_nothing_counts_as_not_set() {
    let folder = Folder::new();
    let arguments = "render scene.toml --technique none -o a.png --samples 1";
    let device = |stdout: &str| stdout.lines().find(|line| line.starts_with("Device  ")).unwrap().to_owned();
    let usual = folder.run(arguments);
    let mut command = folder.command(arguments.split_whitespace());
    let empty = Outcome::of(command.env("NEPHROID_DEVICE", "").output().unwrap());
    assert_eq!(device(&empty.stdout), device(&usual.stdout));
}

#[test]
fn quiet_prints_nothing() {
    let folder = Folder::new();
    let outcome = folder.run("render scene.toml --technique none -o a.png --size 4x3 --samples 1 --quiet");
    assert_eq!((outcome.stdout.as_str(), outcome.stderr.as_str()), ("", ""));
    assert_eq!(folder.files(), ["a.png", "scene.toml"]);
}

/// All samples of all layers, so that even the sign of a zero counts.
fn bits(path: &Path) -> Vec<(String, Vec<u32>)> {
    let LayeredImage { layers, .. } = openexr::read(path).unwrap();
    let channels = layers.into_iter().flat_map(|layer| {
        layer.channels.into_iter().map(move |channel| (format!("{}.{}", layer.name, channel.name), channel.samples))
    });
    channels.map(|(name, samples)| (name, samples.into_iter().map(f32::to_bits).collect())).collect()
}

#[test]
fn equal_seeds_give_equal_bits_and_others_do_not() {
    let folder = Folder::new();
    let render = |name: &str, seed: u32| {
        folder.run(&format!("render scene.toml -o {name} {REFERENCE} --seed {seed} --quiet"));
        bits(&folder.at(name))
    };
    let first = render("first.exr", 1);
    assert!(first == render("again.exr", 1), "the same seed gave another picture");
    assert!(first != render("other.exr", 2), "another seed gave the same picture");

    let same: serde_json::Value =
        serde_json::from_str(&folder.run("compare again.exr first.exr --json").stdout).unwrap();
    assert_eq!((&same["rel_rmse"], &same["energy_ratio"]), (&0.0.into(), &1.0.into()));
}

/// The back-end is named: on a busy machine `auto` may find another one fastest the next time, and bits are promised for
/// equal back-ends only.
const REFERENCE: &str = "--technique reference --set reference.photons=10000 --trace bvh";

/// So many that Ctrl-C comes before the last.
const ENDLESS: u32 = 1_000_000;

/// One sample of so few pixels takes milliseconds; this is for a machine that does much else.
const PATIENCE: Duration = Duration::from_secs(60);

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_the_samples_done() {
    let folder = Folder::new();
    let arguments = format!("render scene.toml --technique none -o a.exr --samples {ENDLESS}");
    let mut command = folder.command(arguments.split_whitespace());
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut errors = BufReader::with_capacity(1, child.stderr.take().unwrap());
    let mut line = String::new();
    errors.read_line(&mut line).unwrap();
    assert!(line.starts_with(&format!("sample 1 of {ENDLESS}, ")), "{line}");
    child.stderr = Some(errors.into_inner());
    let outcome = interrupt(child);
    assert_eq!(outcome.status, Some(130), "{}", outcome.stderr);
    let samples = &openexr::read(&folder.at("a.exr")).unwrap().attributes["nephroid.samples"];
    assert!((1..ENDLESS).contains(&samples.parse().unwrap()), "{samples}");
    let said = format!("Stopped by Ctrl-C: the picture has {samples} of {ENDLESS} samples");
    assert!(outcome.stdout.lines().any(|l| l == said), "'{said}' is not in\n{}", outcome.stdout);
    assert_eq!(folder.files(), ["a.exr", "scene.toml"]);
}

/// Presses Ctrl-C, as it were, and waits.
#[cfg(unix)]
fn interrupt(mut child: Child) -> Outcome {
    let id = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let mut errors = child.stderr.take().unwrap();
    let rest = std::thread::spawn(move || {
        let mut text = String::new();
        errors.read_to_string(&mut text).map(|_| text)
    });
    let deadline = Instant::now() + PATIENCE;
    while child.try_wait().unwrap().is_none() {
        if Instant::now() > deadline {
            child.kill().unwrap();
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    let outcome = Outcome::of(child.wait_with_output().unwrap());
    Outcome { stderr: rest.join().unwrap().unwrap(), ..outcome }
}
