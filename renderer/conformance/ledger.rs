//! What is known of drivers: the failures that are expected, and what is done about them. One file a driver.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use thiserror::Error;

use crate::gpu::DeviceInfo;

/// The files that come with the program, in the order in which DRIVERS.md shows them.
const FILES: &[(&str, &str)] = &[
    ("lavapipe.toml", include_str!("ledger/lavapipe.toml")),
    ("swiftshader.toml", include_str!("ledger/swiftshader.toml")),
    ("nvidia.toml", include_str!("ledger/nvidia.toml")),
    ("software.toml", include_str!("ledger/software.toml")),
    ("layers.toml", include_str!("ledger/layers.toml")),
];

/// One driver's file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ledger {
    /// As people call it.
    pub title: String,
    /// As the driver calls itself, which `nephroid devices` shows; `None` where the notes are of no one driver.
    pub driver: Option<String>,
    #[serde(default, rename = "expect")]
    pub expectations: Vec<Expectation>,
    #[serde(default, rename = "note")]
    pub notes: Vec<Note>,
}

/// A case that fails on some versions of a driver.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expectation {
    /// `group.case`.
    pub case: String,
    /// The tiers on which it fails; all where the list is empty.
    #[serde(default)]
    pub tiers: Vec<String>,
    /// The first version, such as `25.0`; every one up to `before` if `None`.
    pub from: Option<String>,
    /// The first version that is right; every one from `from` on is wrong if `None`.
    pub before: Option<String>,
    /// What the driver does.
    pub reason: String,
    /// Where its authors know of it, or that they do not.
    pub upstream: String,
}

/// Something that users or authors should know, in the words of DRIVERS.md.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Note {
    pub driver: String,
    pub version: String,
    pub symptom: String,
    /// How to see it again.
    pub check: String,
    /// What Nephroid does about it.
    pub answer: String,
}

/// Why a ledger cannot be used.
#[derive(Debug, Error)]
pub enum LedgerError {
    #[error("{path} cannot be read: {reason}")]
    Read { path: PathBuf, reason: String },
    #[error("{path}: {reason}")]
    Parse { path: PathBuf, reason: String },
    #[error("{path}: {case}: {found} is no case; 'nephroid conformance --list' shows them")]
    Case { path: PathBuf, case: &'static str, found: String },
    #[error("{path}: the expectation of {case}: {found} is no tier; allowed are: {allowed}")]
    Tier { path: PathBuf, case: String, found: String, allowed: String },
    #[error("{path}: the expectation of {case}: {found} is no version; allowed are numbers with dots between them")]
    Version { path: PathBuf, case: String, found: String },
}

/// The ledgers that come with the program.
///
/// # Errors
/// None, for files that the tests have seen.
pub fn built_in() -> Result<Vec<Ledger>, LedgerError> {
    FILES.iter().map(|(name, text)| parse(Path::new(name), text)).collect()
}

/// A ledger from a file.
///
/// # Errors
/// A file that cannot be read or is no ledger; cases, tiers or versions that are none.
pub fn load(path: &Path) -> Result<Ledger, LedgerError> {
    let unread = |error: std::io::Error| LedgerError::Read { path: path.to_owned(), reason: error.to_string() };
    parse(path, &std::fs::read_to_string(path).map_err(unread)?)
}

fn parse(path: &Path, text: &str) -> Result<Ledger, LedgerError> {
    let refused = |error: toml::de::Error| {
        let line = error.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count());
        let reason = format!("line {line}: {}", error.message().replace('\n', " "));
        LedgerError::Parse { path: path.to_owned(), reason }
    };
    let ledger: Ledger = toml::from_str(text).map_err(refused)?;
    ledger.expectations.iter().try_for_each(|expectation| check(path, expectation))?;
    Ok(ledger)
}

fn check(path: &Path, expectation: &Expectation) -> Result<(), LedgerError> {
    let case = expectation.case.clone();
    if !super::CASES.iter().copied().flatten().any(|known| known.id() == case) {
        return Err(LedgerError::Case { path: path.to_owned(), case: "an expectation", found: case });
    }
    if let Some(found) = expectation.tiers.iter().find(|tier| super::Tier::named(tier).is_none()) {
        let allowed = super::TIERS.iter().map(|tier| tier.name).collect::<Vec<_>>().join(", ");
        return Err(LedgerError::Tier { path: path.to_owned(), case, found: found.clone(), allowed });
    }
    let numbers = |text: &&String| !text.split('.').all(|part| part.parse::<u32>().is_ok());
    match [&expectation.from, &expectation.before].into_iter().flatten().find(numbers) {
        Some(found) => Err(LedgerError::Version { path: path.to_owned(), case, found: found.clone() }),
        None => Ok(()),
    }
}

/// The expectation that holds for a case on a tier of a device, if there is one.
pub fn expected<'a>(ledgers: &'a [Ledger], device: &DeviceInfo, case: &str, tier: &str) -> Option<&'a Expectation> {
    let version = version_in(&device.driver_version);
    let holds = |expectation: &&Expectation| {
        let reached = expectation.from.as_ref().is_none_or(|from| compare(&version, from) != Ordering::Less);
        let mended = expectation.before.as_ref().is_some_and(|before| compare(&version, before) != Ordering::Less);
        let on_tier = expectation.tiers.is_empty() || expectation.tiers.iter().any(|known| known == tier);
        expectation.case == case && on_tier && reached && !mended
    };
    let of_driver = ledgers.iter().filter(|ledger| ledger.driver.as_ref() == Some(&device.driver));
    of_driver.flat_map(|ledger| &ledger.expectations).find(holds)
}

/// The first number with a dot in it of what a driver calls its version: `25.0.7` of `Mesa 25.0.7-2 (LLVM 15.0.6)`.
fn version_in(text: &str) -> String {
    let words = text.split(|c: char| !c.is_ascii_digit() && c != '.');
    let number = words.map(|word| word.trim_matches('.')).find(|word| word.contains('.'));
    number.unwrap_or("0").to_string()
}

/// Part by part, as numbers; missing parts are zero.
fn compare(a: &str, b: &str) -> Ordering {
    let parts = |text: &str| -> Vec<u64> { text.split('.').map(|part| part.parse().unwrap_or(0)).collect() };
    let (a, b) = (parts(a), parts(b));
    let at = |parts: &[u64], index: usize| parts.get(index).copied().unwrap_or(0);
    (0..a.len().max(b.len()))
        .map(|i| at(&a, i).cmp(&at(&b, i)))
        .find(|o| *o != Ordering::Equal)
        .unwrap_or(Ordering::Equal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_in_ledgers_are_sound() {
        let ledgers = built_in().unwrap();
        assert_eq!(ledgers.len(), FILES.len());
    }

    #[test]
    fn versions_are_numbers() {
        assert_eq!(version_in("Mesa 25.0.7-2~bpo12+1 (LLVM 15.0.6)"), "25.0.7");
        assert_eq!(version_in("5.0.0"), "5.0.0");
        assert_eq!(version_in("r52 570.86.15"), "570.86.15");
        assert_eq!(version_in("git"), "0");
        assert_eq!(compare("25.0.7", "25.1"), Ordering::Less);
        assert_eq!(compare("25.10", "25.9.3"), Ordering::Greater);
        assert_eq!(compare("22.3", "22.3.0"), Ordering::Equal);
    }

    #[test]
    fn what_is_no_case_is_refused() {
        let text = |entry: &str| format!("title = \"x\"\n[[expect]]\nreason = \"r\"\nupstream = \"u\"\n{entry}");
        let say = |entry: &str| parse(Path::new("x.toml"), &text(entry)).unwrap_err().to_string();
        assert!(say("case = \"memory.none\"").contains("memory.none is no case"));
        assert!(say("case = \"bvh.masks\"\ntiers = [\"half\"]").contains("half is no tier; allowed are: full, "));
        assert!(say("case = \"bvh.masks\"\nfrom = \"new\"").contains("new is no version"));
        assert!(say("case = \"bvh.masks\"\nsince = \"1\"").starts_with("x.toml: line 6: unknown field"));
    }
}
