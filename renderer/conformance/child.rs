//! The process that cases run in, which may die or hang with its driver.

use std::io::{self, Write};
use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::case::{Bench, Case, CaseError, CaseReport, Check};
use super::tier::Tier;
use crate::gpu::{Device, DeviceRequest};

/// What a child is to do.
pub struct ChildRequest {
    /// Index.
    pub device: usize,
    pub tier: Tier,
    /// In this order, on one open device.
    pub cases: Vec<&'static Case>,
    pub pictures: bool,
    pub validation: bool,
}

/// What a child says on standard output, a line each. Drivers may say more there, which is no such line.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Line {
    /// The case of that name begins.
    Begin(String),
    /// It has ended.
    End(String, Box<CaseReport>),
    /// The device cannot be opened.
    Refused(String),
}

fn say(output: &mut impl Write, line: &Line) -> io::Result<()> {
    serde_json::to_writer(&mut *output, line).map_err(io::Error::from)?;
    writeln!(output)?;
    output.flush()
}

/// Runs the cases and says what comes of them.
///
/// # Errors
/// Where nobody listens.
pub fn serve(request: &ChildRequest, output: &mut impl Write) -> io::Result<()> {
    let opened = Device::open(&DeviceRequest {
        device: Some(request.device.to_string()),
        disable: request.tier.disabled(),
        validation: request.validation,
    });
    let device = match opened {
        Ok(device) => device,
        Err(error) => return say(output, &Line::Refused(error.to_string())),
    };
    for case in &request.cases {
        say(output, &Line::Begin(case.id()))?;
        let mut bench = Bench::new(&device, request.tier, request.pictures);
        let report = run(case, &mut bench);
        say(output, &Line::End(case.id(), Box::new(report)))?;
    }
    Ok(())
}

fn run(case: &Case, bench: &mut Bench<'_>) -> CaseReport {
    let (started, said) = (Instant::now(), bench.device.validation_messages().len());
    // What the driver claims and the smoke test found not to work has been disabled.
    let claimed = case.needs.iter().find(|capability| !bench.device.has(**capability));
    let answer = match claimed {
        Some(capability) => Err(CaseError::Other(format!(
            "the driver claims {}, which does not work: {}",
            capability.name(),
            bench.device.warnings().join("; ")
        ))),
        None => (case.run)(bench),
    };
    let mut report = std::mem::take(&mut bench.report);
    match answer {
        Ok(()) => {}
        Err(CaseError::Skip(reason)) => report.skipped = Some(reason),
        Err(error) => report.error = Some(error.to_string()),
    }
    if let [first, rest @ ..] = &bench.device.validation_messages()[said..] {
        report.checks.push(Check {
            what: "messages of the validation layers".to_string(),
            measured: 1.0 + rest.len() as f64,
            bound: 0.0,
            unit: String::new(),
            place: first.clone(),
            passed: false,
        });
    }
    report.seconds = started.elapsed().as_secs_f64();
    report
}
