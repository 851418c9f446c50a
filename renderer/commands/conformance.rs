//! `nephroid conformance`: a test of a Vulkan driver.

use std::fmt::Write as _;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::Args;
use clap::builder::PossibleValuesParser;
use regex::Regex;
use thiserror::Error;

use crate::conformance::ledger::{self, Ledger, LedgerError};
use crate::conformance::report::{html, json, junit, summary, told};
use crate::conformance::{self, CASES, Case, ChildRequest, DEVICE_LOSS, Plan, RunnerError, TIERS, Tier, drivers};
use crate::gpu::{Device, DeviceInfo, GpuError};
use crate::image::{ImageError, atomic};

const HELP: &str = "\
Each case checks one behaviour that caustics depend on, against a closed form or an oracle in f64, on every tier of the
device: all that it offers, all but one capability, and compute alone. Cases run in processes of their own, so that a
driver that crashes or hangs costs one case. A failure tells what was measured, what is allowed, where it was, and the
command that runs it again.

Examples:
  nephroid conformance --html report                 # everything, on the most capable device
  nephroid conformance --filter '^(bvh|ray_query)\\.' --tier full --verbose
  nephroid conformance --device llvmpipe --json report.json --junit report.xml

Exit status: 0 all as expected, 1 something failed, or passed that the ledger expects to fail, 2 wrong usage.";

/// Test whether a Vulkan driver does what caustics depend on
#[derive(Debug, Clone, Args)]
#[command(after_help = HELP)]
pub struct ConformanceArgs {
    /// Index or part of the name of the device to test, see 'nephroid devices' [default: the most capable]
    #[arg(long, value_name = "DEVICE", env = "NEPHROID_DEVICE", hide_env_values = true)]
    pub device: Option<String>,
    /// Run the cases alone whose name, group.case, has a match of this regular expression
    #[arg(long, value_name = "RE", value_parser = expression)]
    pub filter: Option<Regex>,
    /// Tiers to run on, with commas between them [default: all that the device offers]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = tier_names())]
    pub tier: Vec<String>,
    /// Leave cases out on tiers where nothing that they use differs from the full tier
    #[arg(long)]
    pub quick: bool,
    /// List the cases and what they check, and run nothing
    #[arg(long)]
    pub list: bool,
    /// Print all that was measured, not failures alone
    #[arg(long, short)]
    pub verbose: bool,
    /// Write the report as JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the report as JUnit XML, for continuous integration
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
    /// Write the report, with pictures, to index.html in this folder, which is made
    #[arg(long, value_name = "DIR")]
    pub html: Option<PathBuf>,
    /// Take the expected failures from this file, not those that come with the program
    #[arg(long, value_name = "FILE")]
    pub ledger: Option<PathBuf>,
    /// Bring this file, DRIVERS.md, up to date with the ledger and with this run
    #[arg(long, value_name = "FILE")]
    pub drivers: Option<PathBuf>,
    /// Seconds that a case may take
    #[arg(long, value_name = "S", default_value_t = 120, value_parser = clap::value_parser!(u64).range(1..=86_400))]
    pub time_limit: u64,
    /// Run under the Vulkan validation layers; what they say fails the case
    #[arg(long)]
    pub validation: bool,
    /// Also run a kernel that does not end, to see the device being lost: that may stop the display, or the machine
    #[arg(long)]
    pub lose_device: bool,

    /// Of a child: the tier that it runs `cases` on.
    #[arg(long, hide = true, value_parser = tier_names())]
    pub child: Option<String>,
    #[arg(long, hide = true, value_delimiter = ',', requires = "child")]
    pub cases: Vec<String>,
    #[arg(long, hide = true, requires = "child")]
    pub pictures: bool,
    /// Put a fault in, to see that a case finds it
    #[cfg(feature = "faults")]
    #[arg(long, hide = true, value_parser = PossibleValuesParser::new(
        conformance::faults::Fault::ALL.map(conformance::faults::Fault::name)
    ))]
    pub fault: Option<String>,
}

fn expression(text: &str) -> Result<Regex, String> {
    // The last line has the reason; those before show the place, which does not fit into one sentence.
    Regex::new(text).map_err(|error| {
        let message = error.to_string();
        let reason = message.lines().last().unwrap_or_default().trim_start_matches("error: ").to_string();
        format!("it is no regular expression: {reason}")
    })
}

fn tier_names() -> PossibleValuesParser {
    PossibleValuesParser::new(TIERS.iter().map(|tier| tier.name))
}

/// Why there is no report.
#[derive(Debug, Error)]
pub enum ConformanceError {
    #[error(transparent)]
    Gpu(#[from] GpuError),
    #[error(transparent)]
    Ledger(#[from] LedgerError),
    #[error(transparent)]
    Runner(#[from] RunnerError),
    #[error(transparent)]
    File(#[from] ImageError),
    #[error(transparent)]
    Drivers(#[from] drivers::DriversError),
    #[error("no case's name matches \"{filter}\"; 'nephroid conformance --list' shows them")]
    NoCase { filter: String },
    #[error("{device} has no tier {tier} that differs from its others; it offers: {offered}")]
    NoTier { device: String, tier: String, offered: String },
    #[error("the folder {path} cannot be made: {reason}")]
    Folder { path: PathBuf, reason: String },
    #[error("the report cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
    #[error("this program's own file cannot be found, and cases run in other processes of it: {0}")]
    Program(io::Error),
    #[error("the report cannot be printed: {0}")]
    Print(#[from] io::Error),
}

/// Runs the cases, prints and writes the report.
///
/// # Errors
/// No such device, tier or case; a ledger that cannot be used; files that cannot be written.
pub fn run(args: &ConformanceArgs) -> Result<ExitCode, ConformanceError> {
    if args.list {
        list(args)?;
        return Ok(ExitCode::SUCCESS);
    }
    if let Some(tier) = args.child.as_deref().and_then(Tier::named) {
        return child(args, tier);
    }
    let devices = Device::list()?;
    let device = crate::gpu::choose(&devices, args.device.as_deref())?.clone();
    let plan = plan(args, device)?;
    check_places(args)?;
    let mut output = io::stdout().lock();
    let mut broken = Ok(());
    let report = conformance::run(&plan, |run| {
        let shown = args.verbose || run.outcome != conformance::Outcome::Skip;
        if shown && broken.is_ok() {
            broken = writeln!(output, "{}", told(run, args.verbose)).and_then(|()| output.flush());
        }
    })?;
    broken?;
    writeln!(output, "{}", summary(&report))?;
    if let Some(path) = &args.json {
        write(path, &json(&report)?)?;
        writeln!(output, "Wrote   {}", path.display())?;
    }
    if let Some(path) = &args.junit {
        write(path, &junit(&report))?;
        writeln!(output, "Wrote   {}", path.display())?;
    }
    if let Some(folder) = &args.html {
        let path = folder.join("index.html");
        write(&path, &html(&report))?;
        writeln!(output, "Wrote   {}", path.display())?;
    }
    if let Some(path) = &args.drivers {
        let text = drivers::read(path)?;
        write(path, &drivers::update(path, &text, &plan.ledgers, Some(&report))?)?;
        writeln!(output, "Wrote   {}", path.display())?;
    }
    Ok(if report.failed() { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// All cases that the arguments name, those of self-checks only where the filter names their group.
fn chosen(args: &ConformanceArgs) -> Result<Vec<&'static Case>, ConformanceError> {
    let all = CASES.iter().copied().flatten().chain(args.lose_device.then_some(&DEVICE_LOSS));
    let named = |case: &&Case| match &args.filter {
        Some(filter) => {
            filter.is_match(&case.id()) && (case.group != "self_check" || filter.as_str().contains("self_check"))
        }
        None => case.group != "self_check",
    };
    let cases: Vec<_> = all.filter(named).collect();
    match (&args.filter, cases.is_empty()) {
        (Some(filter), true) => Err(ConformanceError::NoCase { filter: filter.to_string() }),
        _ => Ok(cases),
    }
}

fn list(args: &ConformanceArgs) -> Result<(), ConformanceError> {
    let mut text = String::new();
    for case in chosen(args)? {
        let _ = writeln!(text, "{:<26} {}", case.id(), case.about);
    }
    let mut output = io::stdout().lock();
    output.write_all(text.as_bytes())?;
    Ok(output.flush()?)
}

fn child(args: &ConformanceArgs, tier: Tier) -> Result<ExitCode, ConformanceError> {
    #[cfg(feature = "faults")]
    if let Some(fault) = args.fault.as_deref().and_then(conformance::faults::Fault::named) {
        conformance::faults::inject(fault);
    }
    let known = || CASES.iter().copied().flatten().chain([&DEVICE_LOSS]);
    let cases = args.cases.iter().filter_map(|name| known().find(|case| case.id() == *name)).collect();
    let device = args.device.as_deref().and_then(|index| index.parse().ok()).unwrap_or(0);
    let request = ChildRequest { device, tier, cases, pictures: args.pictures, validation: args.validation };
    conformance::serve(&request, &mut io::stdout().lock())?;
    Ok(ExitCode::SUCCESS)
}

fn plan(args: &ConformanceArgs, device: DeviceInfo) -> Result<Plan, ConformanceError> {
    let offered = Tier::offered_by(&device);
    let named = |name: &String| {
        offered.iter().find(|tier| tier.name == name).copied().ok_or_else(|| ConformanceError::NoTier {
            device: device.name.clone(),
            tier: name.clone(),
            offered: offered.iter().map(|tier| tier.name).collect::<Vec<_>>().join(", "),
        })
    };
    let tiers =
        if args.tier.is_empty() { offered.clone() } else { args.tier.iter().map(named).collect::<Result<_, _>>()? };
    Ok(Plan {
        program: std::env::current_exe().map_err(ConformanceError::Program)?,
        tiers,
        cases: chosen(args)?,
        quick: args.quick,
        limit: Duration::from_secs(args.time_limit),
        ledgers: ledgers(args)?,
        pictures: args.html.is_some(),
        validation: args.validation,
        #[cfg(feature = "faults")]
        fault: args.fault.clone(),
        #[cfg(not(feature = "faults"))]
        fault: None,
        device,
    })
}

fn ledgers(args: &ConformanceArgs) -> Result<Vec<Ledger>, LedgerError> {
    match &args.ledger {
        Some(path) => Ok(vec![ledger::load(path)?]),
        None => ledger::built_in(),
    }
}

/// Finds out before minutes of work whether what comes of them can be written.
fn check_places(args: &ConformanceArgs) -> Result<(), ConformanceError> {
    if let Some(folder) = &args.html {
        let failed = |error: io::Error| ConformanceError::Folder { path: folder.clone(), reason: error.to_string() };
        fs::create_dir_all(folder).map_err(failed)?;
        atomic::check_place(&folder.join("index.html"))?;
    }
    for path in [&args.json, &args.junit, &args.drivers].into_iter().flatten() {
        atomic::check_place(path)?;
    }
    if let Some(path) = &args.drivers {
        drivers::update(path, &drivers::read(path)?, &ledgers(args)?, None)?;
    }
    Ok(())
}

fn write(path: &Path, text: &str) -> Result<(), ImageError> {
    atomic::write(path, |output| output.write_all(text.as_bytes()).map_err(|error| error.to_string()))
}
