//! DRIVERS.md: the ledger for people to read, and what runs came to. What lies between its markers is made here.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::faults::Fault;
use super::ledger::Ledger;
use super::report::{Outcome, Report};

const LEDGER: [&str; 2] = ["<!-- made from the ledger: begin -->\n", "<!-- made from the ledger: end -->\n"];
const RUNS: [&str; 2] = ["<!-- made from runs: begin -->\n", "<!-- made from runs: end -->\n"];
const RUNS_HEAD: &str = "\n| device | driver | passed | failed | failed as expected | skipped | seconds |\n\
                         |---|---|---|---|---|---|---|\n";

/// Why the file cannot be brought up to date.
#[derive(Debug, Error)]
pub enum DriversError {
    #[error("{path} cannot be read: {reason}")]
    Read { path: PathBuf, reason: String },
    #[error("{path} has no line {marker} in its place, so that there is nowhere to write to")]
    Marker { path: PathBuf, marker: String },
}

/// The text of the file.
///
/// # Errors
/// A file that cannot be read.
pub fn read(path: &Path) -> Result<String, DriversError> {
    let failed = |error: std::io::Error| DriversError::Read { path: path.to_owned(), reason: error.to_string() };
    std::fs::read_to_string(path).map_err(failed)
}

/// The text with what comes from the ledger made anew and, if there is one, the row of a run put in or exchanged.
///
/// # Errors
/// A text without the markers.
pub fn update(path: &Path, text: &str, ledgers: &[Ledger], run: Option<&Report>) -> Result<String, DriversError> {
    let text = exchanged(path, text, LEDGER, |_| tables(ledgers))?;
    exchanged(path, &text, RUNS, |old| runs(old, run))
}

/// The text with what is between the markers given to `make`, and what that makes in its place.
fn exchanged(
    path: &Path,
    text: &str,
    [begin, end]: [&str; 2],
    make: impl FnOnce(&str) -> String,
) -> Result<String, DriversError> {
    let missing = |marker: &str| DriversError::Marker { path: path.to_owned(), marker: marker.trim().to_string() };
    let (before, rest) = text.split_once(begin).ok_or_else(|| missing(begin))?;
    let (old, after) = rest.split_once(end).ok_or_else(|| missing(end))?;
    Ok(format!("{before}{begin}{}{end}{after}", make(old)))
}

/// In a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ")
}

fn tables(ledgers: &[Ledger]) -> String {
    let mut text = String::new();
    for ledger in ledgers {
        let _ = write!(text, "\n## {}\n", ledger.title);
        if !ledger.expectations.is_empty() {
            text.push_str("\nCases of `nephroid conformance` that are expected to fail:\n\n");
            text.push_str("| case | tiers | versions | reason | upstream |\n|---|---|---|---|---|\n");
            for e in &ledger.expectations {
                let tiers = if e.tiers.is_empty() { "all".to_string() } else { e.tiers.join(", ") };
                let versions = match (&e.from, &e.before) {
                    (None, None) => "all".to_string(),
                    (Some(from), None) => format!("{from} and later"),
                    (None, Some(before)) => format!("before {before}"),
                    (Some(from), Some(before)) => format!("{from} to before {before}"),
                };
                let (reason, upstream) = (cell(&e.reason), cell(&e.upstream));
                let _ = writeln!(text, "| `{}` | {tiers} | {versions} | {reason} | {upstream} |", e.case);
            }
        }
        if !ledger.notes.is_empty() {
            text.push_str(
                "\n| driver | version | symptom | check that shows it | what Nephroid does |\n|---|---|---|---|---|\n",
            );
            for note in &ledger.notes {
                let cells =
                    [&note.driver, &note.version, &note.symptom, &note.check, &note.answer].map(|part| cell(part));
                let _ = writeln!(text, "| {} |", cells.join(" | "));
            }
        }
    }
    text.push('\n');
    text
}

/// The rows that there are, with that of the run in place of the one of the same driver and version, or after them all.
fn runs(old: &str, run: Option<&Report>) -> String {
    let rows = old.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| device |"));
    let mut rows: Vec<String> = rows.map(str::to_string).collect();
    if let Some(report) = run {
        let device = &report.device;
        let key = format!("| {} | {} {} |", cell(&device.name), cell(&device.driver), cell(&device.driver_version));
        let failing: Vec<String> = (report.cases.iter().filter(|run| run.outcome.fails()))
            .map(|run| format!("`{}` on {} ({})", run.case, run.tier, run.outcome.name()))
            .collect();
        let failed = if failing.is_empty() { "none".to_string() } else { failing.join(", ") };
        let mut expected: Vec<&str> = (report.cases.iter().filter(|run| run.outcome == Outcome::ExpectedFailure))
            .map(|run| run.case.as_str())
            .collect();
        expected.dedup();
        expected.sort_unstable();
        expected.dedup();
        let expected: Vec<String> = expected.into_iter().map(|case| format!("`{case}`")).collect();
        let s = report.summary;
        let expected = format!(
            "{}{}",
            s.expected_failure,
            if expected.is_empty() { String::new() } else { format!(": {}", expected.join(", ")) }
        );
        let row = format!("{key} {} | {failed} | {expected} | {} | {:.0} |", s.pass, s.skip, report.seconds);
        match rows.iter_mut().find(|row| row.starts_with(&key)) {
            Some(old) => *old = row,
            None => rows.push(row),
        }
    }
    let mut text = RUNS_HEAD.to_string();
    rows.iter().for_each(|row| text.push_str(&format!("{row}\n")));
    text.push('\n');
    text
}

/// A table of faults, the cases that are there to find them, and those that a run with the fault found failing.
pub fn faults_table(found: &[(Fault, Vec<String>)]) -> String {
    let mut text = String::from("| fault | cases that name it | cases that failed |\n|---|---|---|\n");
    for (fault, failed) in found {
        let named = named(*fault);
        let _ = writeln!(text, "| {} | {} | {} |", fault.name(), quoted(&named), quoted(failed));
    }
    text
}

/// The cases that are there to find a fault.
pub fn named(fault: Fault) -> Vec<String> {
    let all = super::CASES.iter().copied().flatten();
    all.filter(|case| case.catches.contains(&fault)).map(super::Case::id).collect()
}

fn quoted(names: &[String]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}
