//! What `--stats` writes: what was used, what it took, and where the light went.

use crate::adaptive::AdaptiveStats;
use crate::gpu::{Capabilities, PassTime};
use crate::technique::{CounterEntry, LedgerEntry};

/// A render's report.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Stats {
    pub version: &'static str,
    pub scene: String,
    pub camera: String,
    pub technique: &'static str,
    pub settings: Vec<(String, String)>,
    pub width: u32,
    pub height: u32,
    /// Samples rendered; of a pixel, or in the mean over pixels where sampling is adaptive.
    pub samples: u32,
    /// How samples were spread over pixels, where that was adaptive.
    pub adaptive: Option<AdaptiveStats>,
    pub seed: u32,
    pub device: String,
    pub driver: String,
    pub driver_version: String,
    pub capabilities: Capabilities,
    /// What the capabilities led to, in words.
    pub tier: String,
    /// `ray_query`, `cwbvh` or `bvh2`.
    pub trace: &'static str,
    /// Why that back-end.
    pub trace_choice: String,
    /// Rows of the picture that were rendered together.
    pub bands: u32,
    /// By name, summed over the samples.
    pub passes: Vec<PassTotal>,
    /// Of this process since its start; on a software device that is the rendering too.
    pub cpu_seconds: f64,
    pub wall_seconds: f64,
    /// Bytes of device memory held at most.
    pub peak_memory_bytes: u64,
    /// W, averaged over the samples.
    pub ledger: Vec<LedgerEntry>,
    /// What the technique counted in the first band of rows.
    pub counters: Vec<CounterEntry>,
    /// Estimated relative noise of the caustic irradiance, where the technique estimates it.
    pub noise: Option<f32>,
    pub warnings: Vec<String>,
}

/// One pass, over all samples.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct PassTotal {
    pub name: String,
    pub calls: u32,
    /// `None` where the device has no timestamps.
    pub milliseconds: Option<f64>,
}

/// Adds the times of one submission.
pub fn add_times(totals: &mut Vec<PassTotal>, times: &[PassTime]) {
    for time in times {
        match totals.iter_mut().find(|total| total.name == time.name) {
            Some(total) => {
                total.calls += 1;
                total.milliseconds = total.milliseconds.zip(time.milliseconds).map(|(a, b)| a + b);
            }
            None => {
                totals.push(PassTotal { name: time.name.clone(), calls: 1, milliseconds: time.milliseconds });
            }
        }
    }
}

/// CPU time of this process, user and system, in seconds; 0 where the system does not tell.
pub fn cpu_seconds() -> f64 {
    cpu_time::ProcessTime::try_now().map_or(0.0, |t| t.as_duration().as_secs_f64())
}
