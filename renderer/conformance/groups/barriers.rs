//! Work that needs what was written before it. All of it is in one submission, where barriers alone give an order.

use super::{Bench, Case, CaseError};
use crate::conformance::ConformancePush;
use crate::conformance::faults::{Fault, in_order};
use crate::gpu::{Bindings, Groups, Recorder};
use crate::random::mix_bits;

/// Words of a link, of 64 workgroups.
const WORDS: u32 = 4096;
/// Links; an even number, so that the last one writes the first half.
const LINKS: u32 = 64;
/// What a word needs is this far off, in another workgroup.
const REACH: u32 = 1027;

const fn case(
    name: &'static str,
    about: &'static str,
    catches: &'static [Fault],
    run: fn(&mut Bench<'_>) -> Result<(), CaseError>,
) -> Case {
    Case { group: "barriers", name, about, needs: &[], minds: &[], catches, run }
}

const BARRIER: &[Fault] = &[Fault::Barrier];

pub(super) const CASES: &[Case] = &[
    case("passes", "64 dispatches that each need the one before, in passes of one submission", BARRIER, passes),
    case("dispatches", "64 dispatches that each need the one before, within one pass", BARRIER, dispatches),
    case(
        "fill_then_read",
        "a kernel sees what a fill before it wrote, and a fill overwrites what a kernel wrote",
        BARRIER,
        fill,
    ),
    case(
        "copy_then_read",
        "a kernel sees what a copy before it brought, and a copy takes what a kernel wrote",
        BARRIER,
        copy,
    ),
    case("workgroup", "barrier() in a workgroup orders shared memory", &[], workgroup),
];

/// Both halves before the first link.
fn start() -> Vec<u32> {
    (0..2 * WORDS).map(|i| if i < WORDS { mix_bits(i) } else { 0 }).collect()
}

/// The first half after all links.
fn end() -> Vec<u32> {
    let mut words: Vec<u32> = start()[..WORDS as usize].to_vec();
    for link in 0..LINKS {
        let needed = |i: u32| words[((i + REACH) % WORDS) as usize];
        words = (0..WORDS)
            .map(|i| needed(i).wrapping_mul(1_664_525).wrapping_add(1_013_904_223).wrapping_add(link))
            .collect();
    }
    words
}

fn links() -> Vec<ConformancePush> {
    let push = |link: usize| ConformancePush { count: WORDS, a: REACH, b: link as u32, c: 0 };
    in_order(LINKS as usize).into_iter().map(push).collect()
}

fn passes(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let words = crate::gpu::Buffer::from_slice(bench.device, "links", &start())?;
    let (kernel, bindings) = (bench.kernel("step")?, Bindings::new().buffer("Words", &words));
    let mut recorder = Recorder::in_one(bench.device)?;
    for push in links() {
        recorder.pass(&kernel.name)?.dispatch(&kernel, &[&bindings], &push, WORDS)?;
    }
    recorder.submit()?;
    bench.equal("words after the last link", &words.read::<u32>(WORDS as usize)?, &end());
    Ok(())
}

fn dispatches(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let words = crate::gpu::Buffer::from_slice(bench.device, "links", &start())?;
    let (kernel, bindings) = (bench.kernel("step")?, Bindings::new().buffer("Words", &words));
    let mut recorder = Recorder::in_one(bench.device)?;
    let groups = Groups::of(&kernel, WORDS);
    recorder.pass(&kernel.name)?.dispatch_in_turn(&kernel, &[&bindings], links(), groups)?;
    recorder.submit()?;
    bench.equal("words after the last link", &words.read::<u32>(WORDS as usize)?, &end());
    Ok(())
}

/// Rounds of fills or copies and kernels by turns.
const ROUNDS: u32 = 16;

fn fill(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let words = bench.words("filled", WORDS)?;
    let seen = bench.words("seen", ROUNDS * WORDS)?;
    let (gather, write) = (bench.kernel("gather")?, bench.kernel("write")?);
    let mut recorder = Recorder::in_one(bench.device)?;
    for round in 0..ROUNDS {
        let bytes = 4 * u64::from(WORDS);
        let part = Bindings::new().buffer("Words", &words).range("Gathered", &seen, u64::from(round) * bytes, bytes);
        for step in in_order(3) {
            let push = ConformancePush { count: WORDS, a: 0, b: 1, c: round };
            let mut pass = recorder.pass("barriers/fill")?;
            match step {
                0 => drop(pass.dispatch(&write, &[&part], &push, WORDS)?),
                1 => drop(pass.fill(&words, 0x0101_0101 * round)),
                _ => drop(pass.dispatch(&gather, &[&part], &push, WORDS)?),
            };
        }
    }
    recorder.submit()?;
    let expected: Vec<u32> = (0..ROUNDS * WORDS).map(|i| 0x0101_0101 * (i / WORDS)).collect();
    bench.equal("words seen", &seen.read::<u32>((ROUNDS * WORDS) as usize)?, &expected);
    Ok(())
}

fn copy(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let (from, to) = (bench.words("copied from", WORDS)?, bench.words("copied to", WORDS)?);
    let seen = bench.words("seen", ROUNDS * WORDS)?;
    let (gather, write) = (bench.kernel("gather")?, bench.kernel("write")?);
    let mut recorder = Recorder::in_one(bench.device)?;
    for round in 0..ROUNDS {
        let bytes = 4 * u64::from(WORDS);
        let source = Bindings::new().buffer("Words", &from);
        let part = Bindings::new().buffer("Words", &to).range("Gathered", &seen, u64::from(round) * bytes, bytes);
        for step in in_order(3) {
            let push = ConformancePush { count: WORDS, a: 0, b: 1, c: round };
            let mut pass = recorder.pass("barriers/copy")?;
            match step {
                0 => drop(pass.dispatch(&write, &[&source], &push, WORDS)?),
                1 => drop(pass.copy(&from, 0, &to, 0, bytes)),
                _ => drop(pass.dispatch(&gather, &[&part], &push, WORDS)?),
            };
        }
    }
    recorder.submit()?;
    let expected: Vec<u32> = (0..ROUNDS * WORDS).map(|i| mix_bits((i % WORDS) ^ (i / WORDS))).collect();
    bench.equal("words seen", &seen.read::<u32>((ROUNDS * WORDS) as usize)?, &expected);
    Ok(())
}

/// Invocations of a workgroup, as in `shared/index.glsl`.
const GROUP: usize = 64;

fn workgroup(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let values: Vec<u32> = (0..WORDS).map(mix_bits).collect();
    let words = crate::gpu::Buffer::from_slice(bench.device, "summed", &values)?;
    bench.run("workgroup", &Bindings::new().buffer("Words", &words), WORDS, [0; 3])?;
    let running = |group: &[u32]| -> Vec<u32> {
        let add = |sum: &mut u32, value: &u32| {
            *sum = sum.wrapping_add(*value);
            Some(*sum)
        };
        group.iter().scan(0u32, add).collect()
    };
    let expected: Vec<u32> = values.chunks(GROUP).flat_map(running).collect();
    bench.equal("running sums", &words.read::<u32>(WORDS as usize)?, &expected);
    Ok(())
}
