//! Storage buffers at their limits, ranges at offsets, and push constants.

use super::{Bench, Case, CaseError};
use crate::gpu::{Bindings, Buffer, GpuError, Recorder};
use crate::random::mix_bits;

/// Bytes of the largest buffer that is tried, where the device allows more: memory may be short of its own limit.
const LARGEST: u64 = 1 << 30;
/// `maxStorageBufferRange` at least.
const LEAST: u64 = 1 << 27;

pub(super) const CASES: &[Case] = &[
    Case {
        group: "memory",
        name: "largest_range",
        about: "a storage buffer as large as the device allows (1 GiB at most) holds what is written to both its ends",
        needs: &[],
        minds: &[],
        catches: &[],
        run: largest_range,
    },
    Case {
        group: "memory",
        name: "range_offsets",
        about: "ranges bound at multiples of the offset alignment are where they should be, and no larger",
        needs: &[],
        minds: &[],
        catches: &[],
        run: range_offsets,
    },
    Case {
        group: "memory",
        name: "push_constants",
        about: "128 bytes of push constants arrive",
        needs: &[],
        minds: &[],
        catches: &[],
        run: push_constants,
    },
    Case {
        group: "memory",
        name: "copies",
        about: "uploads and readbacks of odd sizes and offsets keep every byte",
        needs: &[],
        minds: &[],
        catches: &[],
        run: copies,
    },
];

/// Places that are written across the whole of a buffer, and again at its end.
const PLACES: u32 = 4096;

fn largest_range(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let mut bytes = bench.device.info.limits.storage_range.min(LARGEST) / 4 * 4;
    // A range may be larger than what memory there is; 128 MiB are what every Vulkan device has to allow.
    let buffer = loop {
        match Buffer::new(bench.device, "largest range", bytes) {
            Err(GpuError::OutOfMemory { .. }) if bytes / 2 >= LEAST => bytes = bytes / 8 * 4,
            made => break made?,
        }
    };
    let words = (bytes / 4) as u32;
    bench.note("bytes that the device allows", bench.device.info.limits.storage_range);
    bench.note("bytes tried", bytes);
    let gathered = bench.words("gathered", PLACES)?;
    let both = Bindings::new().buffer("Words", &buffer).buffer("Gathered", &gathered);
    let spread = words / PLACES;
    // All over it, and the very last words.
    for (what, first, stride, seed) in
        [("words all over it", 0, spread, 1), ("the last words", words - PLACES, 1, 2), ("the first words", 0, 1, 3)]
    {
        bench.run("write", &both, PLACES, [first, stride, seed])?;
        bench.run("gather", &both, PLACES, [first, stride, 0])?;
        let expected: Vec<u32> = (0..PLACES).map(|i| mix_bits((first + i * stride) ^ seed)).collect();
        bench.equal(what, &gathered.read::<u32>(PLACES as usize)?, &expected);
    }
    let end = buffer.read_at::<u32>(bytes - 4 * u64::from(PLACES), PLACES as usize)?;
    let expected: Vec<u32> = (words - PLACES..words).map(|at| mix_bits(at ^ 2)).collect();
    bench.equal("the last words, read by the host", &end, &expected);
    Ok(())
}

fn range_offsets(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let step = bench.device.info.limits.storage_offset_alignment.max(4);
    bench.note("offset alignment, bytes", step);
    let ranges = 8;
    let words = (step / 4) as u32;
    let buffer = bench.words("ranges", ranges * words)?;
    // Every second range is written, from its first word to its last.
    for range in (1..ranges).step_by(2) {
        let bindings = Bindings::new().range("Words", &buffer, u64::from(range) * step, step);
        bench.run("write", &bindings, words, [0, 1, range])?;
    }
    let value = |range: u32, at: u32| if range % 2 == 1 { mix_bits(at ^ range) } else { 0 };
    let expected: Vec<u32> = (0..ranges).flat_map(|range| (0..words).map(move |at| value(range, at))).collect();
    bench.equal("words of all ranges", &buffer.read::<u32>((ranges * words) as usize)?, &expected);
    Ok(())
}

fn push_constants(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let buffer = bench.words("pushed", 32)?;
    let kernel = bench.kernel("push")?;
    let bindings = Bindings::new().buffer("Words", &buffer);
    for seed in 0..4u32 {
        let pushed: [u32; 32] = std::array::from_fn(|i| mix_bits(i as u32 ^ seed << 8));
        let mut recorder = Recorder::new(bench.device)?;
        recorder.pass(&kernel.name)?.dispatch(&kernel, &[&bindings], &pushed, 32)?;
        recorder.submit()?;
        bench.equal("words pushed", &buffer.read::<u32>(32)?, &pushed);
    }
    Ok(())
}

fn copies(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    const WORDS: u32 = 65_539;
    let buffer = bench.words("copied", WORDS)?;
    let mut expected = vec![0u32; WORDS as usize];
    for (turn, (first, count)) in
        [(0usize, 65_539usize), (1, 1), (3, 4097), (65_538, 1), (4095, 3)].into_iter().enumerate()
    {
        let values: Vec<u32> = (0..count as u32).map(|i| mix_bits(i ^ (turn as u32) << 20)).collect();
        expected[first..first + count].copy_from_slice(&values);
        buffer.upload_at(4 * first as u64, bytemuck::cast_slice(&values))?;
        let back = buffer.read_at::<u32>(4 * first as u64, count)?;
        bench.equal("a part read back", &back, &values);
    }
    bench.equal("all of it", &buffer.read::<u32>(WORDS as usize)?, &expected);
    Ok(())
}
