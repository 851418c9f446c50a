//! What the technique's kernels counted, by name.

use crate::gpu::{Buffer, GpuError};
use crate::technique::{CounterEntry, LedgerEntry, double_words};

/// In the order of `kernels/technique/photons/ledger.glsl`.
const ENTRIES: [&str; 15] = [
    "emitted",
    "missed",
    "rough",
    "absorbed",
    "scattered",
    "landed",
    "rescued",
    "hidden",
    "lost",
    "escaped",
    "specular",
    "wrong_side",
    "non_finite",
    "faint",
    "strengthened",
];
/// In the order of `kernels/technique/photons/tallies.glsl`.
const TALLIES: [&str; 10] = [
    "photons_traced",
    "light_steps",
    "camera_steps",
    "light_hits",
    "camera_hits",
    "photons_skimming",
    "marches_cut",
    "photons_dropped",
    "refractions",
    "refractions_unbent",
];

/// Bytes of the buffers: two words an entry.
pub const LEDGER_BYTES: u64 = 8 * ENTRIES.len() as u64;
pub const TALLY_BYTES: u64 = 8 * TALLIES.len() as u64;

fn values(buffer: &Buffer, count: usize) -> Result<Vec<f64>, GpuError> {
    let words: Vec<u32> = buffer.read(2 * count)?;
    Ok(double_words(&words).collect())
}

/// W of the mean channel over `sets` sets, each unit of the buffer `unit` W. What faint photons that were not followed
/// had, less what others got for it, is one entry, which tends to nothing.
pub fn ledger(buffer: &Buffer, unit: f32, sets: u32) -> Result<Vec<LedgerEntry>, GpuError> {
    let scale = f64::from(unit) / f64::from(sets.max(1));
    let watts: Vec<f64> = values(buffer, ENTRIES.len())?.into_iter().map(|value| value * scale).collect();
    let (&strengthened, kept) = watts.split_last().unwrap_or((&0.0, &[]));
    let mut entries: Vec<LedgerEntry> =
        ENTRIES.iter().zip(kept).map(|(name, &watts)| LedgerEntry { name, watts }).collect();
    if let Some(faint) = entries.last_mut() {
        faint.watts -= strengthened;
    }
    Ok(entries)
}

/// Over all sets so far.
pub fn counters(buffer: &Buffer) -> Result<Vec<CounterEntry>, GpuError> {
    let values = values(buffer, TALLIES.len())?;
    Ok(TALLIES.iter().zip(values).map(|(name, value)| CounterEntry { name, value }).collect())
}
