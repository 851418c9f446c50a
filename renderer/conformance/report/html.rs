//! For people at a screen: one file that holds everything, light or dark as the reader has it.

use std::fmt::Write;

use super::{Outcome, Report, Run, escaped, number};

const STYLE: &str = include_str!("html.css");

/// The report as one HTML page.
pub fn html(report: &Report) -> String {
    let mut page = String::new();
    let device = &report.device;
    let _ = write!(
        page,
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>Conformance of {0}</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n",
        escaped(&device.name)
    );
    head(&mut page, report);
    failures(&mut page, report);
    table(&mut page, report);
    pictures(&mut page, report);
    measurements(&mut page, report);
    page.push_str("</main>\n</body>\n</html>\n");
    page
}

fn head(page: &mut String, report: &Report) {
    let device = &report.device;
    let _ = writeln!(page, "<h1>{}</h1>\n<dl>", escaped(&device.name));
    let capabilities = match device.capabilities.join(", ") {
        names if names.is_empty() => "compute only".to_string(),
        names => names,
    };
    let rows = [
        ("Driver", format!("{} {}", device.driver, device.driver_version)),
        ("Vulkan", device.vulkan.clone()),
        ("Kind", device.kind.clone()),
        ("Capabilities", capabilities),
        ("Run by", format!("{}, in {:.0} s", report.program, report.seconds)),
    ];
    for (name, value) in rows {
        let _ = writeln!(page, "<div><dt>{name}</dt><dd>{}</dd></div>", escaped(&value));
    }
    page.push_str("</dl>\n<ul class=\"summary\">\n");
    let s = report.summary;
    let counts = [
        (Outcome::Fail, s.fail, "failed"),
        (Outcome::Crash, s.crash, "crashed"),
        (Outcome::Timeout, s.timeout, "took too long"),
        (Outcome::UnexpectedPass, s.unexpected_pass, "passed unexpectedly"),
        (Outcome::ExpectedFailure, s.expected_failure, "failed as expected"),
        (Outcome::Pass, s.pass, "passed"),
        (Outcome::Skip, s.skip, "skipped"),
    ];
    for (outcome, count, what) in counts.into_iter().filter(|(_, count, _)| *count > 0) {
        let _ = writeln!(page, "<li class=\"{}\"><b>{count}</b> {what}</li>", outcome.name());
    }
    page.push_str("</ul>\n");
}

/// A word for a cell.
fn word(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Pass => "pass",
        Outcome::Fail => "FAIL",
        Outcome::Skip => "–",
        Outcome::Crash => "CRASH",
        Outcome::Timeout => "TIMEOUT",
        Outcome::ExpectedFailure => "expected",
        Outcome::UnexpectedPass => "UNEXPECTED",
    }
}

fn anchor(run: &Run) -> String {
    format!("{}-{}", run.tier, run.case.replace('.', "-"))
}

fn table(page: &mut String, report: &Report) {
    page.push_str("<h2>Cases by tiers</h2>\n<div class=\"wide\"><table class=\"matrix\">\n<thead><tr><th>Case</th>");
    report.tiers.iter().for_each(|tier| {
        let _ = write!(page, "<th>{}</th>", escaped(tier));
    });
    page.push_str("</tr></thead>\n<tbody>\n");
    let mut group = "";
    // The cases of the first tier are those of all tiers.
    for first in report.cases.iter().filter(|run| Some(&run.tier) == report.tiers.first()) {
        if first.group() != group {
            group = first.group();
            let _ = writeln!(page, "<tr class=\"group\"><th colspan=\"{}\">{group}</th></tr>", report.tiers.len() + 1);
        }
        let _ = write!(page, "<tr><th title=\"{}\">{}</th>", escaped(&first.about), escaped(&first.case));
        for tier in &report.tiers {
            let run = report.cases.iter().find(|run| run.case == first.case && run.tier == *tier);
            let _ = match run {
                Some(run) if run.outcome == Outcome::Skip => {
                    write!(page, "<td class=\"skip\" title=\"{}\">{}</td>", escaped(&run.reason), word(run.outcome))
                }
                Some(run) => write!(
                    page,
                    "<td class=\"{}\"><a href=\"#{}\" title=\"{}\">{}</a></td>",
                    run.outcome.name(),
                    anchor(run),
                    escaped(&run.reason),
                    word(run.outcome)
                ),
                None => write!(page, "<td></td>"),
            };
        }
        page.push_str("</tr>\n");
    }
    page.push_str(
        "</tbody></table></div>\n<p class=\"hint\">A dash is a case that was not run there. Point at a cell for the reason.</p>\n",
    );
}

fn failures(page: &mut String, report: &Report) {
    let told = |run: &&Run| run.outcome.fails() || run.outcome == Outcome::ExpectedFailure;
    if !report.cases.iter().any(|run| told(&run)) {
        return;
    }
    page.push_str("<h2>What went wrong</h2>\n");
    for run in report.cases.iter().filter(told) {
        let _ = writeln!(
            page,
            "<section class=\"failure {}\"><h3>{} <small>on {}: {}</small></h3>\n<p>{}</p>",
            run.outcome.name(),
            escaped(&run.case),
            escaped(&run.tier),
            run.outcome.name(),
            escaped(&run.about)
        );
        if !run.reason.is_empty() {
            let _ = writeln!(page, "<p>{}</p>", escaped(&run.reason));
        }
        if let Some(known) = &run.known {
            let _ =
                writeln!(page, "<p>The ledger: {} Upstream: {}</p>", escaped(&known.reason), escaped(&known.upstream));
        }
        checks(page, run, true);
        let _ = writeln!(page, "<p>Again: <code>{}</code></p></section>", escaped(&run.rerun));
    }
}

fn checks(page: &mut String, run: &Run, failed_only: bool) {
    let shown: Vec<_> = run.checks.iter().filter(|check| !failed_only || !check.passed).collect();
    if shown.is_empty() {
        return;
    }
    page.push_str("<div class=\"wide\"><table><thead><tr><th>Measured</th><th>Found</th><th>Allowed</th><th>Where</th></tr></thead><tbody>\n");
    for check in shown {
        let _ = writeln!(
            page,
            "<tr class=\"{}\"><td>{}</td><td class=\"number\">{}</td><td class=\"number\">{} {}</td><td>{}</td></tr>",
            if check.passed { "" } else { "beyond" },
            escaped(&check.what),
            number(check.measured),
            number(check.bound),
            escaped(&check.unit),
            escaped(&check.place)
        );
    }
    page.push_str("</tbody></table></div>\n");
}

fn pictures(page: &mut String, report: &Report) {
    if report.cases.iter().all(|run| run.pictures.is_empty()) {
        return;
    }
    page.push_str("<h2>Pictures</h2>\n<p class=\"hint\">Errors are blue where a picture is too dark, red where it is too bright, grey where nothing is asked.</p>\n<div class=\"pictures\">\n");
    for run in &report.cases {
        for picture in &run.pictures {
            let _ = writeln!(
                page,
                "<figure><figcaption>{} <small>on {}</small></figcaption><div class=\"row\">",
                escaped(&run.case),
                escaped(&run.tier)
            );
            let shown = [("found", &picture.found), ("expected", &picture.expected), ("error", &picture.error)];
            for (what, data) in shown {
                let _ = writeln!(
                    page,
                    "<div><img alt=\"{what}\" width=\"{}\" height=\"{}\" src=\"data:image/png;base64,{data}\"><span>{what}{}</span></div>",
                    picture.width,
                    picture.height,
                    if what == "error" {
                        format!(", full colours: {}", number(picture.scale.into()))
                    } else {
                        String::new()
                    }
                );
            }
            page.push_str("</div></figure>\n");
        }
    }
    page.push_str("</div>\n");
}

fn measurements(page: &mut String, report: &Report) {
    page.push_str("<h2>All measurements</h2>\n");
    for run in report.cases.iter().filter(|run| run.outcome != Outcome::Skip) {
        let _ = writeln!(
            page,
            "<details id=\"{}\"><summary><span class=\"dot {}\"></span>{} <small>on {}, {}, {:.1} s</small></summary>\n<p>{}</p>",
            anchor(run),
            run.outcome.name(),
            escaped(&run.case),
            escaped(&run.tier),
            run.outcome.name(),
            run.seconds,
            escaped(&run.about)
        );
        checks(page, run, false);
        if !run.notes.is_empty() {
            page.push_str("<ul>\n");
            for note in &run.notes {
                let _ = writeln!(page, "<li>{}: {}</li>", escaped(&note.what), escaped(&note.value));
            }
            page.push_str("</ul>\n");
        }
        page.push_str("</details>\n");
    }
}
