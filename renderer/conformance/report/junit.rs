//! For continuous integration: JUnit's XML, as Jenkins' schema `junit-10.xsd` has it. A suite is a group on a tier.

use std::fmt::Write;

use super::{Outcome, Report, Run, escaped, number};

/// The report as JUnit XML. Failures that the ledger expects are skipped there, with its reason.
pub fn junit(report: &Report) -> String {
    let mut suites: Vec<(String, Vec<&Run>)> = Vec::new();
    for run in &report.cases {
        let name = format!("{}.{}", run.tier, run.group());
        match suites.last_mut() {
            Some((last, runs)) if *last == name => runs.push(run),
            _ => suites.push((name, vec![run])),
        }
    }
    let all: Vec<&Run> = report.cases.iter().collect();
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let _ = writeln!(
        xml,
        "<testsuites name=\"nephroid conformance\" tests=\"{}\" failures=\"{}\" errors=\"{}\" time=\"{:.3}\">",
        all.len(),
        failures(&all),
        errors(&all),
        report.seconds
    );
    for (name, runs) in &suites {
        suite(&mut xml, report, name, runs);
    }
    xml.push_str("</testsuites>\n");
    xml
}

fn failures(runs: &[&Run]) -> usize {
    runs.iter().filter(|run| matches!(run.outcome, Outcome::Fail | Outcome::UnexpectedPass)).count()
}

fn errors(runs: &[&Run]) -> usize {
    runs.iter().filter(|run| matches!(run.outcome, Outcome::Crash | Outcome::Timeout)).count()
}

fn suite(xml: &mut String, report: &Report, name: &str, runs: &[&Run]) {
    let skipped = runs.iter().filter(|run| matches!(run.outcome, Outcome::Skip | Outcome::ExpectedFailure)).count();
    let seconds: f64 = runs.iter().map(|run| run.seconds).sum();
    let _ = writeln!(
        xml,
        "  <testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"{skipped}\" time=\"{seconds:.3}\">",
        escaped(name),
        runs.len(),
        failures(runs),
        errors(runs)
    );
    xml.push_str("    <properties>\n");
    let device = &report.device;
    for (key, value) in
        [("device", &device.name), ("driver", &device.driver), ("driver version", &device.driver_version)]
    {
        let _ = writeln!(xml, "      <property name=\"{key}\" value=\"{}\"/>", escaped(value));
    }
    xml.push_str("    </properties>\n");
    runs.iter().for_each(|run| case(xml, name, run));
    xml.push_str("  </testsuite>\n");
}

fn case(xml: &mut String, suite: &str, run: &Run) {
    let name = run.case.split_once('.').map_or(run.case.as_str(), |(_, name)| name);
    let _ = write!(
        xml,
        "    <testcase name=\"{}\" classname=\"{}\" time=\"{:.3}\"",
        escaped(name),
        escaped(suite),
        run.seconds
    );
    let reason = escaped(&run.reason);
    let inner = match run.outcome {
        Outcome::Pass => String::new(),
        Outcome::Skip => format!("<skipped message=\"{reason}\"/>"),
        Outcome::ExpectedFailure => {
            let known = run.known.as_ref().map_or("", |known| known.reason.as_str());
            format!("<skipped message=\"expected failure: {}\"/>", escaped(known))
        }
        Outcome::Fail | Outcome::UnexpectedPass => {
            format!(
                "<failure message=\"{reason}\" type=\"{}\">{}</failure>",
                run.outcome.name(),
                escaped(&details(run))
            )
        }
        Outcome::Crash | Outcome::Timeout => {
            format!("<error message=\"{reason}\" type=\"{}\">{}</error>", run.outcome.name(), escaped(&details(run)))
        }
    };
    match inner.is_empty() {
        true => xml.push_str("/>\n"),
        false => {
            let _ = writeln!(xml, ">{inner}</testcase>");
        }
    }
}

fn details(run: &Run) -> String {
    let check = |check: &super::Check| {
        let (measured, bound) = (number(check.measured), number(check.bound));
        format!("{}: {measured}, allowed {bound} {}; {}. ", check.what, check.unit, check.place)
    };
    let failed: String = run.failed_checks().map(check).collect();
    format!("{failed}Again: {}", run.rerun)
}
