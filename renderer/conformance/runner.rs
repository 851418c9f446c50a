//! Has the cases run in child processes, and finds out which case a child died of.

use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Read};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use thiserror::Error;

use super::case::{Case, CaseReport};
use super::child::Line;
use super::ledger::{self, Ledger};
use super::report::{DeviceSummary, Known, Outcome, Report, Run, Summary};
use super::tier::Tier;
use crate::gpu::DeviceInfo;

/// What is to be run, and how.
pub struct Plan {
    /// This program; it is started with `conformance --child`.
    pub program: PathBuf,
    pub device: DeviceInfo,
    pub tiers: Vec<Tier>,
    /// In this order, on one tier after the other.
    pub cases: Vec<&'static Case>,
    /// Leave cases out on tiers where nothing that they use differs from the full one.
    pub quick: bool,
    /// Of one case.
    pub limit: Duration,
    pub ledgers: Vec<Ledger>,
    /// Whether cases are to keep pictures.
    pub pictures: bool,
    pub validation: bool,
    /// A fault to put in; test builds have such.
    pub fault: Option<String>,
}

/// Why nothing was run.
#[derive(Debug, Error)]
pub enum RunnerError {
    #[error("{program} cannot be started again for the cases to run in: {reason}")]
    Start { program: PathBuf, reason: String },
}

/// What became of a case in its child.
enum Ending {
    Reported(CaseReport),
    Crash(String),
    Timeout(String),
}

/// Runs all cases on all tiers; `seen` gets each run as it ends.
///
/// # Errors
/// A child that cannot be started. What happens to it then is an outcome.
pub fn run(plan: &Plan, mut seen: impl FnMut(&Run)) -> Result<Report, RunnerError> {
    let started = Instant::now();
    let mut runs = Vec::new();
    for &tier in &plan.tiers {
        let mut add = |case: &Case, ending: Result<Ending, String>, seconds: f64| {
            let run = judged(plan, tier, case, ending, seconds);
            seen(&run);
            runs.push(run);
        };
        // A group is a child's work: what one group leaves behind in a driver does not meet the next.
        let mut groups: Vec<(&str, VecDeque<&'static Case>)> = Vec::new();
        for &case in &plan.cases {
            if let Some(reason) = case.skipped(tier, &plan.device.capabilities, plan.quick) {
                add(case, Err(reason), 0.0);
                continue;
            }
            match groups.last_mut() {
                Some((group, cases)) if *group == case.group => cases.push_back(case),
                _ => groups.push((case.group, VecDeque::from([case]))),
            }
        }
        for (_, mut cases) in groups {
            while !cases.is_empty() {
                run_child(plan, tier, &mut cases, &mut add)?;
            }
        }
    }
    // Cases that were skipped come before those of their tier that ran; put them back in the plan's order.
    let place = |run: &Run| {
        let tier = plan.tiers.iter().position(|tier| tier.name == run.tier);
        (tier, plan.cases.iter().position(|case| case.id() == run.case))
    };
    runs.sort_by_key(place);
    Ok(Report {
        schema: super::report::SCHEMA,
        program: format!("nephroid {}", env!("CARGO_PKG_VERSION")),
        device: DeviceSummary::of(&plan.device),
        tiers: plan.tiers.iter().map(|tier| tier.name.to_string()).collect(),
        seconds: started.elapsed().as_secs_f64(),
        summary: Summary::of(&runs),
        cases: runs,
    })
}

/// Has one child run cases off the queue, until it has done them all, dies, or takes too long for one.
fn run_child(
    plan: &Plan,
    tier: Tier,
    cases: &mut VecDeque<&'static Case>,
    add: &mut impl FnMut(&Case, Result<Ending, String>, f64),
) -> Result<(), RunnerError> {
    let mut child = start(plan, tier, cases)?;
    let (lines, errors) = listen(&mut child);
    let mut began = Instant::now();
    let before = cases.len();
    loop {
        match lines.recv_timeout(plan.limit.saturating_sub(began.elapsed())) {
            Ok(Line::Begin(_)) => began = Instant::now(),
            Ok(Line::End(id, report)) => {
                if cases.front().is_some_and(|case| case.id() == id)
                    && let Some(case) = cases.pop_front()
                {
                    add(case, Ok(Ending::Reported(*report)), began.elapsed().as_secs_f64());
                }
                began = Instant::now();
            }
            Ok(Line::Refused(reason)) => {
                for case in cases.drain(..) {
                    let report = CaseReport { error: Some(reason.clone()), ..Default::default() };
                    add(case, Ok(Ending::Reported(report)), 0.0);
                }
            }
            Err(RecvTimeoutError::Timeout) => {
                end(&mut child);
                if let Some(case) = cases.pop_front() {
                    let reason = format!("no answer within {} s", plan.limit.as_secs_f64());
                    add(case, Ok(Ending::Timeout(reason)), began.elapsed().as_secs_f64());
                }
                return Ok(());
            }
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    let status = reap(&mut child, plan.limit);
    // A child may also die while it puts things away after its last case: that is the last case's crash, but it has answered.
    if let Some(case) = cases.pop_front() {
        let words = errors.join().unwrap_or_default();
        let at = if cases.len() + 1 == before { "at its first case" } else { "here" };
        add(
            case,
            Ok(Ending::Crash(format!("the process died {at}, {}{words}", describe(status)))),
            began.elapsed().as_secs_f64(),
        );
    }
    Ok(())
}

fn start(plan: &Plan, tier: Tier, cases: &VecDeque<&'static Case>) -> Result<Child, RunnerError> {
    let names: Vec<String> = cases.iter().map(|case| case.id()).collect();
    let mut command = Command::new(&plan.program);
    command.args(["conformance", "--child", tier.name, "--cases", &names.join(",")]);
    command.args(["--device", &plan.device.index.to_string()]);
    if plan.pictures {
        command.arg("--pictures");
    }
    if plan.validation {
        command.arg("--validation");
    }
    if let Some(fault) = &plan.fault {
        command.args(["--fault", fault]);
    }
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let failed =
        |error: std::io::Error| RunnerError::Start { program: plan.program.clone(), reason: error.to_string() };
    command.spawn().map_err(failed)
}

/// The child's lines as they come, and the end of what it says on standard error.
fn listen(child: &mut Child) -> (Receiver<Line>, JoinHandle<String>) {
    let (sender, lines) = mpsc::channel();
    if let Some(output) = child.stdout.take() {
        thread::spawn(move || {
            let text = BufReader::new(output).lines().map_while(Result::ok);
            let known = text.filter_map(|line| serde_json::from_str(&line).ok());
            // Nobody listens any more once the child took too long.
            let _ = known.map(|line| sender.send(line)).find(|sent| sent.is_err());
        });
    }
    let errors = child.stderr.take();
    let last_words = thread::spawn(move || {
        let mut text = Vec::new();
        let _ = errors.map(|mut errors| errors.read_to_end(&mut text));
        let text = String::from_utf8_lossy(&text);
        text.lines()
            .rev()
            .find(|line| !line.trim().is_empty())
            .map_or(String::new(), |line| format!("; its last words: {line}"))
    });
    (lines, last_words)
}

fn end(child: &mut Child) {
    // It may have ended by itself meanwhile.
    let _ = child.kill();
    let _ = child.wait();
}

/// How a child ended that says nothing more; one that does not end by itself is ended.
fn reap(child: &mut Child, limit: Duration) -> Option<ExitStatus> {
    let silent = Instant::now();
    while silent.elapsed() < limit {
        match child.try_wait() {
            Ok(None) => thread::sleep(Duration::from_millis(5)),
            ended => return ended.ok().flatten(),
        }
    }
    end(child);
    None
}

fn describe(status: Option<ExitStatus>) -> String {
    status.map_or("in an unknown way".to_string(), |status| status.to_string())
}

/// The run of a case that ended so, in the light of the ledger. `Err` is the reason for which it was not run.
fn judged(plan: &Plan, tier: Tier, case: &Case, ending: Result<Ending, String>, seconds: f64) -> Run {
    let id = case.id();
    let (mut outcome, reason, report) = match ending {
        Err(reason) => (Outcome::Skip, reason, CaseReport::default()),
        Ok(Ending::Crash(reason)) => (Outcome::Crash, reason, CaseReport::default()),
        Ok(Ending::Timeout(reason)) => (Outcome::Timeout, reason, CaseReport::default()),
        Ok(Ending::Reported(report)) => {
            let failed = report.checks.iter().filter(|check| !check.passed).count();
            match (&report.skipped, &report.error) {
                (Some(reason), _) => (Outcome::Skip, reason.clone(), report),
                (None, Some(error)) => (Outcome::Fail, error.clone(), report),
                (None, None) if failed > 0 => (
                    Outcome::Fail,
                    format!("{failed} of {} measurements are beyond their bounds", report.checks.len()),
                    report,
                ),
                (None, None) => (Outcome::Pass, String::new(), report),
            }
        }
    };
    let expectation = ledger::expected(&plan.ledgers, &plan.device, &id, tier.name);
    let known = expectation.map(|e| Known { reason: e.reason.clone(), upstream: e.upstream.clone() });
    let mut reason = reason;
    match (outcome, &known) {
        (Outcome::Fail | Outcome::Crash | Outcome::Timeout, Some(_)) => outcome = Outcome::ExpectedFailure,
        (Outcome::Pass, Some(known)) => {
            outcome = Outcome::UnexpectedPass;
            reason = format!(
                "the ledger expects a failure ({}); take the entry out, or end its version range",
                known.reason
            );
        }
        _ => {}
    }
    Run {
        about: case.about.to_string(),
        rerun: rerun(plan, tier, &id),
        case: id,
        tier: tier.name.to_string(),
        outcome,
        reason,
        known,
        seconds: if report.seconds > 0.0 { report.seconds } else { seconds },
        checks: report.checks,
        notes: report.notes,
        pictures: report.pictures,
    }
}

/// The command that runs one case alone.
fn rerun(plan: &Plan, tier: Tier, id: &str) -> String {
    // What is in brackets may hold anything; the rest of a name is enough, if a shell takes it as it is.
    let name = plan.device.name.split(" (").next().unwrap_or_default();
    let plain = name.chars().all(|c| c.is_ascii_alphanumeric() || " -_.".contains(c));
    let device = if plain { format!("'{name}'") } else { plan.device.index.to_string() };
    let fault = plan.fault.as_ref().map_or(String::new(), |fault| format!(" --fault {fault}"));
    format!(
        "nephroid conformance --device {device} --tier {} --filter '^{}$'{fault}",
        tier.name,
        id.replace('.', "\\.")
    )
}
