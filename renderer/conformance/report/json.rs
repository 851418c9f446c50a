//! For machines: `tests/conformance/report.schema.json` says what is in it.

use super::Report;

/// The report as JSON, without its pictures.
///
/// # Errors
/// None that is known: all of it is text and finite numbers.
pub fn json(report: &Report) -> Result<String, serde_json::Error> {
    serde_json::to_string_pretty(report).map(|text| text + "\n")
}
