//! `nephroid conformance`, by running the binary: what it finds on the drivers here, and what it makes of drivers that crash,
//! hang and lie.

mod junit;
mod schema;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use nephroid::conformance::faults::Fault;
use nephroid::conformance::{CASES, drivers, ledger};
use serde_json::Value;
use tempfile::TempDir;

/// Cases that take seconds each on software devices, and whose work others do too.
const SLOW: [&str; 3] = ["bvh.watertight", "bvh.barycentrics", "beams.flat_water"];
/// Those that SwiftShader makes a technique's pipelines for; one of them is left.
const SLOW_ON_SWIFTSHADER: [&str; 8] = [
    "reference.flat_water",
    "mnee.flat_water",
    "photons.flat_water",
    "photons.ledger",
    "beams.ledger",
    "beams.hulls",
    "eikonal.flat_water",
    "frame.direct_light",
];

fn nephroid(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_nephroid"));
    command.arg("conformance").args(arguments).env_remove("NEPHROID_DEVICE");
    command.output().unwrap()
}

fn text(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

/// Index and name of each device.
fn devices() -> Vec<(String, String)> {
    let output = Command::new(env!("CARGO_BIN_EXE_nephroid")).args(["devices", "--json"]).output().unwrap();
    let devices: Value = serde_json::from_slice(&output.stdout).unwrap();
    let named = |device: &Value| (device["index"].to_string(), device["name"].as_str().unwrap_or_default().to_string());
    let found: Vec<_> = devices.as_array().unwrap().iter().map(named).collect();
    assert!(!found.is_empty(), "no Vulkan device to test on");
    found
}

/// The device that has all that cases want, or else the first.
fn best() -> String {
    let devices = devices();
    let best = devices.iter().find(|(_, name)| name.contains("llvmpipe")).unwrap_or(&devices[0]);
    best.0.clone()
}

/// A filter for these cases alone.
fn filter<'a>(cases: impl IntoIterator<Item = &'a str>) -> String {
    let cases: Vec<String> = cases.into_iter().map(|case| case.replace('.', "\\.")).collect();
    format!("^({})$", cases.join("|"))
}

/// A run's exit status, what it printed, and its report.
struct Outcome {
    status: Option<i32>,
    text: String,
    report: Value,
    folder: TempDir,
}

impl Outcome {
    fn of(arguments: &[&str]) -> Outcome {
        let folder = TempDir::new().unwrap();
        let json = folder.path().join("report.json");
        let output = nephroid(&[arguments, &["--json", json.to_str().unwrap()]].concat());
        let text = text(&output);
        let report = std::fs::read(&json).unwrap_or_else(|error| panic!("{error}: {text}"));
        Outcome { status: output.status.code(), text, report: serde_json::from_slice(&report).unwrap(), folder }
    }

    /// Names of the cases that ended so.
    fn cases(&self, outcome: &str) -> Vec<String> {
        let cases = self.report["cases"].as_array().unwrap().iter();
        let named = cases.filter(|case| case["outcome"] == outcome);
        named.map(|case| case["case"].as_str().unwrap().to_string()).collect()
    }
}

/// The software drivers and whatever else is here, on every tier: each with one of its capabilities disabled, and with all.
#[test]
fn drivers_do_what_the_ledger_says() {
    for (index, name) in devices() {
        let left_out: Vec<&str> = match name.contains("SwiftShader") {
            true => SLOW.into_iter().chain(SLOW_ON_SWIFTSHADER).collect(),
            false => SLOW.to_vec(),
        };
        let all: Vec<String> = CASES.iter().copied().flatten().map(|case| case.id()).collect();
        let wanted =
            all.iter().map(String::as_str).filter(|id| !left_out.contains(id) && !id.starts_with("self_check"));
        let run =
            Outcome::of(&["--device", &index, "--filter", &filter(wanted), "--quick", "--validation", "--verbose"]);
        assert_eq!(run.status, Some(0), "{name}:\n{}", run.text);
        assert!(run.report["summary"]["pass"].as_u64() > Some(30), "{name}:\n{}", run.text);
        let offered = run.report["device"]["capabilities"].as_array().unwrap().len();
        assert_eq!(run.report["tiers"].as_array().unwrap().len(), offered + 2, "{name}: {}", run.report["tiers"]);
        println!("{}", run.text.lines().rev().take(3).collect::<Vec<_>>().join("\n"));
    }
}

/// Debian 12's own Mesa, which has neither ray queries nor much else of late.
#[test]
fn an_old_lavapipe_does_what_the_ledger_says() {
    let Ok(manifest) = std::env::var("NEPHROID_OLD_LAVAPIPE") else {
        println!("skipped: NEPHROID_OLD_LAVAPIPE names no manifest; tools/test brings one in where it can");
        return;
    };
    let left_out: Vec<&str> = SLOW.into_iter().chain(SLOW_ON_SWIFTSHADER).collect();
    let all: Vec<String> = CASES.iter().copied().flatten().map(|case| case.id()).collect();
    let wanted = all.iter().map(String::as_str).filter(|id| !left_out.contains(id) && !id.starts_with("self_check"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_nephroid"));
    command
        .args(["conformance", "--tier", "full,compute", "--filter", &filter(wanted)])
        .env("VK_DRIVER_FILES", &manifest);
    let output = command.env_remove("NEPHROID_DEVICE").output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
}

#[test]
fn a_crash_and_a_hang_cost_one_case_each() {
    let run = Outcome::of(&["--device", &best(), "--filter", "^self_check", "--tier", "full", "--time-limit", "3"]);
    assert_eq!(run.status, Some(1), "{}", run.text);
    assert_eq!(run.cases("pass"), ["self_check.passes", "self_check.passes_again"]);
    assert_eq!(run.cases("fail"), ["self_check.fails"]);
    assert_eq!(run.cases("crash"), ["self_check.crashes"]);
    assert_eq!(run.cases("timeout"), ["self_check.hangs"]);
    for words in
        ["seven: 7 things, allowed 3.5000, which is too much", "\n        here\n", "signal: 6", "no answer within 3 s"]
    {
        assert!(run.text.contains(words), "'{words}' is not in\n{}", run.text);
    }
    // The command that a failure names runs it alone, and fails again.
    let again = run.text.lines().find_map(|line| line.trim().strip_prefix("again: nephroid ")).unwrap();
    let shell = format!("\"$NEPHROID\" {again}");
    let output =
        Command::new("sh").args(["-c", &shell]).env("NEPHROID", env!("CARGO_BIN_EXE_nephroid")).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    assert!(text(&output).contains("1 failed"), "{}", text(&output));
}

/// A ledger with one expectation of this device's driver.
fn ledger_file(folder: &Path, device: &Value, case: &str, more: &str) -> PathBuf {
    let path = folder.join("ledger.toml");
    let driver = device["driver"].as_str().unwrap();
    let entry = format!("[[expect]]\ncase = \"{case}\"\nreason = \"it does\"\nupstream = \"nobody\"\n{more}\n");
    std::fs::write(&path, format!("title = \"t\"\ndriver = \"{driver}\"\n{entry}")).unwrap();
    path
}

#[test]
fn expected_failures_pass_and_unexpected_passes_fail() {
    let device = best();
    let first = Outcome::of(&["--device", &device, "--filter", "self_check.passes$", "--tier", "full"]);
    assert_eq!(first.status, Some(0), "{}", first.text);
    let run = |case: &str, more: &str| {
        let path = ledger_file(first.folder.path(), &first.report["device"], case, more);
        let ledger = path.to_str().unwrap();
        Outcome::of(&[
            "--device",
            &device,
            "--filter",
            "self_check.(passes|fails)$",
            "--tier",
            "full",
            "--ledger",
            ledger,
        ])
    };
    let expected = run("self_check.fails", "");
    assert_eq!((expected.status, expected.cases("expected-failure").len()), (Some(0), 1), "{}", expected.text);
    assert!(expected.text.contains("expected: it does (nobody)"), "{}", expected.text);
    // Of other versions, or another tier, the ledger says nothing.
    for more in ["before = \"0.1\"", "from = \"9999\"", "tiers = [\"compute\"]"] {
        let other = run("self_check.fails", more);
        assert_eq!((other.status, other.cases("fail").len()), (Some(1), 1), "{more}: {}", other.text);
    }
    let unexpected = run("self_check.passes", "");
    assert_eq!(unexpected.cases("unexpected-pass"), ["self_check.passes"], "{}", unexpected.text);
    assert_eq!(unexpected.status, Some(1));
}

#[test]
fn reports_keep_to_their_schemas() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let chosen = "^self_check|^memory|image_formats|direct_light";
    let run = Outcome::of(&[
        "--device",
        &best(),
        "--filter",
        chosen,
        "--tier",
        "full,no-timestamps",
        "--quick",
        "--time-limit",
        "20",
        "--junit",
        &at("r.xml"),
        "--html",
        &at("html"),
    ]);
    let schema: Value = serde_json::from_str(include_str!("report.schema.json")).unwrap();
    assert_eq!(schema::errors(&schema, &run.report), Vec::<String>::new());
    // The checker finds what is wrong.
    for (pointer, wrong) in
        [("/seconds", Value::from(-1)), ("/cases/0/outcome", Value::from("lost")), ("/device/name", Value::from(""))]
    {
        let mut broken = run.report.clone();
        *broken.pointer_mut(pointer).unwrap() = wrong;
        assert_eq!(schema::errors(&schema, &broken).len(), 1, "{pointer}");
    }
    let mut broken = run.report.clone();
    broken["more"] = Value::from(1);
    assert_eq!(schema::errors(&schema, &broken).len(), 1);

    let xml = std::fs::read_to_string(at("r.xml")).unwrap();
    let root = junit::parse(&xml).unwrap_or_else(|error| panic!("{error} in\n{xml}"));
    assert_eq!(junit::errors(&root), Vec::<String>::new(), "{xml}");
    let count = |name: &str| root.all(name).len() as f64;
    assert_eq!(root.number("tests"), count("testcase"));
    assert_eq!(count("testcase") as usize, run.report["cases"].as_array().unwrap().len());
    assert_eq!((root.number("failures"), root.number("errors")), (count("failure"), count("error")));
    assert_eq!(count("failure") + count("error"), 3.0, "{xml}");
    assert!(junit::parse(&xml.replace("</testsuite>", "")).is_err());
    assert!(!junit::errors(&junit::parse(&xml.replace("classname", "class_name")).unwrap()).is_empty());

    let html = std::fs::read_to_string(at("html/index.html")).unwrap();
    for part in
        ["prefers-color-scheme: dark", "<th>full</th><th>no-timestamps</th>", "self_check.crashes", "CRASH", "TIMEOUT"]
    {
        assert!(html.contains(part), "'{part}' is not in the page");
    }
    // It needs nothing from elsewhere, and has three pictures of a case.
    let sources: Vec<&str> = html.split("src=\"").skip(1).collect();
    assert!(sources.len() >= 3 && sources.iter().all(|source| source.starts_with("data:image/png;base64,")));
    assert!(
        !html.contains("http") && !html.contains("@import") && !html.contains("<link") && !html.contains("<script")
    );
}

#[test]
fn wrong_usage_and_trouble_have_their_statuses() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "title = 3").unwrap();
    let file = file.to_str().unwrap();
    let inside = format!("{file}/report");
    let cases: [(&[&str], i32, &str); 8] = [
        (&["--filter", "("], 2, "it is no regular expression: unclosed group"),
        (&["--tier", "half"], 2, "no-float-atomics"),
        (&["--time-limit", "0"], 2, "1..=86400"),
        (&["--filter", "^nothing$"], 1, "no case's name matches \"^nothing$\""),
        (&["--device", "no such thing"], 1, "no Vulkan device matches \"no such thing\""),
        (&["--ledger", file], 1, "line 1: invalid type"),
        (&["--html", &inside], 1, "cannot be made"),
        (&["--drivers", file], 1, "has no line <!-- made from the ledger: begin -->"),
    ];
    for (arguments, status, words) in cases {
        let output = nephroid(arguments);
        assert_eq!(output.status.code(), Some(status), "{arguments:?}: {}", text(&output));
        assert!(text(&output).contains(words), "{arguments:?}: '{words}' is not in\n{}", text(&output));
    }
    let list = text(&nephroid(&["--list"]));
    assert!(list.lines().count() > 50 && list.contains("\nbvh.masks ") && !list.contains("self_check"), "{list}");
    assert_eq!(text(&nephroid(&["--list", "--filter", "watertight"])).lines().count(), 2);
    for technique in ["reference", "mnee", "beams", "photons", "eikonal"] {
        assert!(list.contains(&format!("\n{technique}.flat_water ")), "{technique} has no case in\n{list}");
    }
}

/// Every fault is found by every case that names it; without it those pass, by the first test.
#[test]
fn injected_faults_are_found() {
    let device = best();
    let mut table = Vec::new();
    for fault in Fault::ALL {
        let named = drivers::named(fault);
        assert!(!named.is_empty(), "no case names the fault {}", fault.name());
        let chosen = filter(named.iter().map(String::as_str));
        let run = Outcome::of(&["--device", &device, "--tier", "full", "--filter", &chosen, "--fault", fault.name()]);
        let failed = run.cases("fail");
        assert_eq!(failed, named, "{}:\n{}", fault.name(), run.text);
        table.push((fault, failed));
    }
    println!("{}", drivers::faults_table(&table));
}

#[test]
fn drivers_md_is_what_the_ledger_says() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("DRIVERS.md");
    let old = drivers::read(&path).unwrap();
    let new = drivers::update(&path, &old, &ledger::built_in().unwrap(), None).unwrap();
    let differing = old.lines().zip(new.lines()).find(|(old, new)| old != new);
    assert!(
        old == new,
        "DRIVERS.md is not up to date, first at {differing:?}; see its head for the command that mends it"
    );
}
