//! Sums and counters that many invocations share.

use super::{Bench, Case, CaseError};
use crate::conformance::faults::{Fault, injected};
use crate::gpu::{Bindings, Buffer, Capability, Image};
use crate::random::mix_bits;

/// Invocations, all at once.
const COUNT: u32 = 1 << 18;

const fn case(name: &'static str, about: &'static str, run: fn(&mut Bench<'_>) -> Result<(), CaseError>) -> Case {
    Case { group: "atomics", name, about, needs: &[], minds: &[], catches: &[], run }
}

pub(super) const CASES: &[Case] = &[
    case("integers", "add with carry, min, max, or, xor and compare-and-swap on 1 slot and on 61", integers),
    case("places", "a counter gives each invocation a place of its own", places),
    case("image", "adds to the pixels of an image of 32-bit integers", image),
    Case {
        group: "atomics",
        name: "floats",
        about: "float adds lose nothing: sums of whole numbers are exact",
        needs: &[Capability::FloatAtomics],
        minds: &[],
        catches: &[Fault::FloatAtomics],
        run: floats,
    },
];

/// Tries of a compare and swap. Each that fails means that another has come through, so more than the invocations on a slot
/// cannot fail.
const TRIES: u32 = 8192;

fn integers(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    for (count, slots) in [(2048u32, 1u32), (COUNT, 61)] {
        let start: Vec<u32> = (0..8 * slots).map(|i| if i % 8 == 2 { u32::MAX } else { 0 }).collect();
        let words = Buffer::from_slice(bench.device, "slots", &start)?;
        bench.run("atomics", &Bindings::new().buffer("Words", &words), count, [slots, TRIES, 0])?;
        let mut expected = start;
        for i in 0..count {
            let (value, slot) = (mix_bits(i), (i % slots * 8) as usize);
            let (sum, carry) = expected[slot].overflowing_add(value);
            expected[slot] = sum;
            expected[slot + 1] += u32::from(carry);
            expected[slot + 2] = expected[slot + 2].min(value);
            expected[slot + 3] = expected[slot + 3].max(value);
            expected[slot + 4] |= 1 << (value % 32);
            expected[slot + 5] ^= value;
            expected[slot + 6] += 1;
            expected[slot + 7] += 1;
        }
        bench.equal(&format!("words of {slots} slots"), &words.read::<u32>(8 * slots as usize)?, &expected);
    }
    Ok(())
}

fn places(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let (words, gathered) = (bench.words("counter", 4)?, bench.words("places", COUNT)?);
    let bindings = Bindings::new().buffer("Words", &words).buffer("Gathered", &gathered);
    bench.run("places", &bindings, COUNT, [0; 3])?;
    let mut found: Vec<u32> = gathered.read(COUNT as usize)?;
    found.sort_unstable();
    bench.equal("the counter", &words.read::<u32>(1)?, &[COUNT]);
    bench.equal("numbers at places, in order", &found, &(0..COUNT).collect::<Vec<_>>());
    Ok(())
}

fn image(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let (width, height) = (17u32, 5u32);
    let image = Image::counters(bench.device, "counters", width, height)?;
    bench.run("image_atomics", &Bindings::new().image("counters", &image), COUNT, [width, height, 0])?;
    let mut expected = vec![0u32; (width * height) as usize];
    (0..COUNT).for_each(|i| expected[(i % (width * height)) as usize] += mix_bits(i) & 0xffff);
    bench.equal("pixels", &image.read::<u32>(expected.len())?, &expected);
    Ok(())
}

/// Numbers are below this, so that a slot's sum stays below 2^24, where every whole number is a float.
const BELOW: u32 = 1000;

fn floats(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    for slots in [64u32, 4096] {
        let count = 16_384 * (slots / 64).min(16);
        let buffer = bench.words("sums", slots)?;
        let added = if injected(Fault::FloatAtomics) { count - count / 1000 } else { count };
        bench.run("float_atomics", &Bindings::new().buffer("Floats", &buffer), added, [slots, BELOW, 0])?;
        let mut expected = vec![0.0f32; slots as usize];
        (0..count).for_each(|i| expected[(i % slots) as usize] += (mix_bits(i) % BELOW) as f32);
        bench.equal(&format!("sums of {slots} slots"), &buffer.read::<f32>(slots as usize)?, &expected);
    }
    Ok(())
}
