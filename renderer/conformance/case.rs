//! A case, and the bench it runs on.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::faults::Fault;
use super::{ConformancePush, Tier};
use crate::gpu::{Bindings, Buffer, Capabilities, Capability, Device, GpuError, Kernel, Recorder};
use crate::image::{Mask, RgbImage, heatmap, png, tone};
use crate::render::RenderError;
use crate::scene::SceneError;
use crate::trace::TraceError;

/// A check of one behaviour.
pub struct Case {
    pub group: &'static str,
    pub name: &'static str,
    /// What it checks, in one line.
    pub about: &'static str,
    /// Capabilities without which it makes no sense.
    pub needs: &'static [Capability],
    /// Further capabilities that its outcome may depend on: quick runs have it on tiers that lack one of these too.
    pub minds: &'static [Capability],
    /// The faults that it is there to find.
    pub catches: &'static [Fault],
    pub run: fn(&mut Bench<'_>) -> Result<(), CaseError>,
}

impl Case {
    /// `group.case`.
    pub fn id(&self) -> String {
        format!("{}.{}", self.group, self.name)
    }

    /// Why it does not run on a tier of a device that has `offered`, if so. `quick`: nor where nothing that it uses differs
    /// from the full tier.
    pub fn skipped(&self, tier: Tier, offered: &Capabilities, quick: bool) -> Option<String> {
        let left = offered.without(&tier.disabled());
        if let Some(missing) = self.needs.iter().find(|c| !left.has(**c)) {
            let who = if offered.has(*missing) { "tier" } else { "driver" };
            return Some(format!("the {who} lacks {}", missing.name()));
        }
        let differs = |c: &&Capability| offered.has(**c) && !left.has(**c);
        let alike = quick && !tier.is_full() && !tier.is_compute() && !self.minds.iter().any(|c| differs(&c));
        alike.then(|| "as on the full tier: it uses nothing of what is disabled".to_string())
    }
}

/// Why a case came to no answer.
#[derive(Debug, Error)]
pub enum CaseError {
    #[error(transparent)]
    Gpu(#[from] GpuError),
    #[error(transparent)]
    Trace(#[from] TraceError),
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Not a failure: there is nothing to check on this device.
    #[error("{0}")]
    Skip(String),
    #[error("{0}")]
    Other(String),
}

/// A number that was measured, and the largest that passes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Check {
    pub what: String,
    pub measured: f64,
    pub bound: f64,
    /// Of both.
    pub unit: String,
    /// Where the worst of it was, with what was found and what was expected.
    pub place: String,
    pub passed: bool,
}

/// Something about the device that is neither right nor wrong.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Note {
    pub what: String,
    pub value: String,
}

/// A picture that a case made: PNG files in base 64.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PictureOfCase {
    pub width: usize,
    pub height: usize,
    pub found: String,
    pub expected: String,
    /// Found minus expected: blue too dark, red too bright.
    pub error: String,
    /// What the full colours of `error` stand for, in the pictures' unit.
    pub scale: f32,
}

/// What a case left on its bench.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct CaseReport {
    pub checks: Vec<Check>,
    pub notes: Vec<Note>,
    #[serde(default)]
    pub pictures: Vec<PictureOfCase>,
    /// Why there was nothing to check.
    pub skipped: Option<String>,
    /// Why it ended early.
    pub error: Option<String>,
    pub seconds: f64,
}

/// Where a case runs, and what it says.
pub struct Bench<'a> {
    pub device: &'a Device,
    pub tier: Tier,
    /// Whether pictures are of interest.
    pub pictures: bool,
    pub(super) report: CaseReport,
}

/// The worst of many measurements, and where it was.
#[derive(Debug, Clone, Default)]
pub struct Worst {
    pub measured: f64,
    pub place: String,
}

impl Worst {
    /// Keeps the larger; what is no number is worse than any. `place` is asked only then.
    pub fn see(&mut self, measured: f64, place: impl FnOnce() -> String) {
        let measured = if measured.is_finite() { measured } else { f64::MAX };
        if measured > self.measured {
            *self = Worst { measured, place: place() };
        }
    }
}

impl<'a> Bench<'a> {
    pub fn new(device: &'a Device, tier: Tier, pictures: bool) -> Self {
        Bench { device, tier, pictures, report: CaseReport::default() }
    }

    /// Passes where the worst is at most `bound`.
    pub fn at_most(&mut self, what: &str, worst: Worst, bound: f64, unit: &str) {
        let Worst { measured, place } = worst;
        let passed = measured <= bound;
        self.report.checks.push(Check {
            what: what.to_string(),
            measured,
            bound,
            unit: unit.to_string(),
            place,
            passed,
        });
    }

    /// Passes where both lists are the same, and counts differences.
    pub fn equal<T: PartialEq + std::fmt::Debug>(&mut self, what: &str, found: &[T], expected: &[T]) {
        let mut differing = found.iter().zip(expected).enumerate().filter(|(_, (a, b))| a != b);
        let mut worst = Worst::default();
        if let Some((index, (a, b))) = differing.next() {
            worst.see(1.0 + differing.count() as f64, || format!("place {index}: {a:?}, not {b:?}"));
        }
        if found.len() != expected.len() {
            worst.see(f64::MAX, || format!("{} places, not {}", found.len(), expected.len()));
        }
        self.at_most(what, worst, 0.0, "differences");
    }

    /// Says something that is neither right nor wrong.
    pub fn note(&mut self, what: &str, value: impl std::fmt::Display) {
        self.report.notes.push(Note { what: what.to_string(), value: value.to_string() });
    }

    /// Keeps a picture beside what was expected of it. `inside` are the pixels that count.
    pub fn picture(&mut self, found: &RgbImage, expected: &RgbImage, inside: Vec<bool>) {
        if !self.pictures {
            return;
        }
        let mask = Mask { width: found.width, height: found.height, inside };
        let Ok(map) = heatmap::signed(found, expected, &mask) else { return };
        let brightest = expected.pixels.iter().flatten().fold(0.0f32, |m, v| m.max(*v)).max(f32::MIN_POSITIVE);
        let shown = |image: &RgbImage| -> Vec<[u8; 3]> {
            image.pixels.iter().map(|p| tone::to_srgb8(p.map(|v| v / brightest))).collect()
        };
        let file = |pixels: &[[u8; 3]]| {
            png::encode(found.width, found.height, pixels)
                .map(|bytes| super::report::base64(&bytes))
                .unwrap_or_default()
        };
        self.report.pictures.push(PictureOfCase {
            width: found.width,
            height: found.height,
            found: file(&shown(found)),
            expected: file(&shown(expected)),
            error: file(&map.pixels),
            scale: map.scale,
        });
    }

    /// A buffer of that many u32, all zero.
    pub fn words(&self, name: &str, count: u32) -> Result<Buffer, GpuError> {
        Buffer::zeroed(self.device, name, 4 * u64::from(count))
    }

    /// The kernel `conformance/<name>`.
    pub fn kernel(&self, name: &str) -> Result<Kernel, GpuError> {
        Kernel::new(self.device, &format!("conformance/{name}"), "")
    }

    /// Runs a kernel alone, and waits. `push`: a, b and c.
    pub fn run(&self, name: &str, bindings: &Bindings, count: u32, [a, b, c]: [u32; 3]) -> Result<(), GpuError> {
        let kernel = self.kernel(name)?;
        let mut recorder = Recorder::new(self.device)?;
        recorder.pass(&kernel.name)?.dispatch(&kernel, &[bindings], &ConformancePush { count, a, b, c }, count)?;
        recorder.submit()?;
        Ok(())
    }
}
