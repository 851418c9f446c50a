//! What a run found, and the forms in which it is told.

mod html;
mod json;
mod junit;
mod text;

pub use html::html;
pub use json::json;
pub use junit::junit;
pub use text::{summary, told};

use serde::Serialize;

use super::case::{Check, Note, PictureOfCase};
use crate::gpu::DeviceInfo;

/// Of the JSON form; it grows when a field goes or changes its meaning.
pub const SCHEMA: u32 = 1;

/// What became of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    Pass,
    Fail,
    Skip,
    /// Its process died.
    Crash,
    /// Its process took too long.
    Timeout,
    /// It failed, and the ledger knows.
    ExpectedFailure,
    /// It passed, and the ledger says that it fails.
    UnexpectedPass,
}

impl Outcome {
    /// As in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Outcome::Pass => "pass",
            Outcome::Fail => "fail",
            Outcome::Skip => "skip",
            Outcome::Crash => "crash",
            Outcome::Timeout => "timeout",
            Outcome::ExpectedFailure => "expected-failure",
            Outcome::UnexpectedPass => "unexpected-pass",
        }
    }

    /// Whether the run as a whole fails by it.
    pub fn fails(self) -> bool {
        matches!(self, Outcome::Fail | Outcome::Crash | Outcome::Timeout | Outcome::UnexpectedPass)
    }
}

/// What the ledger says of a failure.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Known {
    pub reason: String,
    pub upstream: String,
}

/// One case on one tier.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Run {
    /// `group.case`.
    pub case: String,
    pub about: String,
    pub tier: String,
    pub outcome: Outcome,
    /// Why it failed or was skipped; empty where it passed.
    pub reason: String,
    /// The ledger's entry.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub known: Option<Known>,
    pub seconds: f64,
    pub checks: Vec<Check>,
    pub notes: Vec<Note>,
    /// The command that runs it alone.
    pub rerun: String,
    #[serde(skip)]
    pub pictures: Vec<PictureOfCase>,
}

impl Run {
    /// The part of `case` before the dot.
    pub fn group(&self) -> &str {
        self.case.split('.').next().unwrap_or_default()
    }

    /// What was measured and is beyond its bound.
    pub fn failed_checks(&self) -> impl Iterator<Item = &Check> {
        self.checks.iter().filter(|check| !check.passed)
    }
}

/// The device that cases ran on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DeviceSummary {
    pub name: String,
    pub kind: String,
    pub driver: String,
    pub driver_version: String,
    pub vulkan: String,
    /// By name.
    pub capabilities: Vec<String>,
}

impl DeviceSummary {
    pub(super) fn of(info: &DeviceInfo) -> Self {
        DeviceSummary {
            name: info.name.clone(),
            kind: info.kind.to_string(),
            driver: info.driver.clone(),
            driver_version: info.driver_version.clone(),
            vulkan: info.vulkan.clone(),
            capabilities: info.capabilities.names().iter().map(|name| name.to_string()).collect(),
        }
    }
}

/// How many runs came to what.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Summary {
    pub pass: usize,
    pub fail: usize,
    pub skip: usize,
    pub crash: usize,
    pub timeout: usize,
    pub expected_failure: usize,
    pub unexpected_pass: usize,
}

impl Summary {
    pub(super) fn of(runs: &[Run]) -> Self {
        let count = |outcome: Outcome| runs.iter().filter(|run| run.outcome == outcome).count();
        Summary {
            pass: count(Outcome::Pass),
            fail: count(Outcome::Fail),
            skip: count(Outcome::Skip),
            crash: count(Outcome::Crash),
            timeout: count(Outcome::Timeout),
            expected_failure: count(Outcome::ExpectedFailure),
            unexpected_pass: count(Outcome::UnexpectedPass),
        }
    }
}

/// All of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    pub schema: u32,
    pub program: String,
    pub device: DeviceSummary,
    pub tiers: Vec<String>,
    /// Of wall-clock time.
    pub seconds: f64,
    pub summary: Summary,
    /// Tier by tier, each in the order of the cases.
    pub cases: Vec<Run>,
}

impl Report {
    /// Whether anything went otherwise than it should, or than the ledger says.
    pub fn failed(&self) -> bool {
        self.cases.iter().any(|run| run.outcome.fails())
    }
}

/// Bytes in base 64.
pub(super) fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let digit = |bits: u32| char::from(DIGITS[(bits & 63) as usize]);
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let bits = (0..3).fold(0, |bits, i| bits << 8 | u32::from(chunk.get(i).copied().unwrap_or(0)));
        for place in 0..4 {
            text.push(if place <= chunk.len() { digit(bits >> (18 - 6 * place)) } else { '=' });
        }
    }
    text
}

/// Text between tags or in quotes, in XML and HTML. Characters that XML does not have become spaces.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\n' | '\t' => out.push(' '),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// A measurement in few digits.
fn number(value: f64) -> String {
    let size = value.abs();
    if value == value.trunc() && size < 1e9 {
        format!("{value}")
    } else if (1e-3..1e5).contains(&size) {
        format!("{value:.4}")
    } else if size == f64::MAX {
        "not a number".to_string()
    } else {
        format!("{value:.2e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_become_base_64() {
        let cases = [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")];
        for (bytes, text) in cases {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }

    #[test]
    fn markup_is_escaped() {
        assert_eq!(escaped("a < b & \"c\"\n\u{1}"), "a &lt; b &amp; &quot;c&quot;  ");
    }
}
