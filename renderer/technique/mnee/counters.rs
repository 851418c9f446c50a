//! How often what happened in the search for paths, so that no failure is silent.

use crate::gpu::{Buffer, GpuError};
use crate::technique::{CounterEntry, double_words};

/// In the order of `kernels/technique/mnee/counters.glsl`.
pub const NAMES: [&str; 28] = [
    "points",
    "starts",
    "triangles_crossed",
    "walks_to_boundary",
    "walks_past_slopes",
    "walks_closed",
    "walks_to_crease",
    "walks_at_step_cap",
    "walks_dropped",
    "arcs",
    "arcs_dropped",
    "roots",
    "unsolved",
    "rejected_wrong_side",
    "rejected_behind_surface",
    "rejected_blocked",
    "rejected_second_crossing",
    "non_finite",
    "paths",
    "seeds",
    "duplicates",
    "trials",
    "projections",
    "trials_not_converged",
    "trials_capped",
    "walks_to_first_path",
    "roots_dropped",
    "footprints_left_out",
];

/// Words of the buffer: two a counter, and the longest walk.
pub const WORDS: usize = 2 * NAMES.len() + 2;

/// Reads the counters, and what follows from them.
pub fn read(buffer: &Buffer) -> Result<Vec<CounterEntry>, GpuError> {
    let words: Vec<u32> = buffer.read(WORDS)?;
    let counts: Vec<f64> = double_words(&words).collect();
    let value = |name: &str| NAMES.iter().position(|&n| n == name).map_or(0.0, |index| counts[index]);
    let mean = |what: &str, over: &str| value(what) / value(over).max(1.0);
    let mut entries: Vec<_> = NAMES.iter().zip(&counts).map(|(name, &value)| CounterEntry { name, value }).collect();
    entries.push(CounterEntry { name: "triangles_crossed_longest_walk", value: f64::from(words[2 * NAMES.len()]) });
    entries.push(CounterEntry { name: "triangles_crossed_mean_per_start", value: mean("triangles_crossed", "starts") });
    entries.push(CounterEntry { name: "roots_mean_per_point", value: mean("roots", "points") });
    Ok(entries)
}
