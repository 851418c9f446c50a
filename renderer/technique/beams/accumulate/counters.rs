//! What accumulation counted.

use crate::gpu::{Buffer, GpuError};
use crate::technique::{CounterEntry, double_words};

/// In the order of `kernels/technique/beams/tally.glsl`.
const NAMES: [&str; 6] = [
    "beam_tests",
    "beam_fragments",
    "beam_shadow_rays",
    "beam_shadowed",
    "beam_fragments_non_finite",
    "beam_fragments_drawn",
];

/// Bytes of the buffer: two words a counter.
pub const BYTES: u64 = 8 * NAMES.len() as u64;

pub fn read(buffer: &Buffer) -> Result<Vec<CounterEntry>, GpuError> {
    let words: Vec<u32> = buffer.read(2 * NAMES.len())?;
    Ok(NAMES.iter().zip(double_words(&words)).map(|(name, value)| CounterEntry { name, value }).collect())
}
