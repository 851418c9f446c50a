//! Dispatches and draws whose size is in a buffer.

use super::{Bench, Case, CaseError, GRAPHICS};
use crate::conformance::ConformancePush;
use crate::conformance::faults::{Fault, in_order};
use crate::gpu::{Bindings, Buffer, Recorder};

const fn case(
    name: &'static str,
    about: &'static str,
    catches: &'static [Fault],
    run: fn(&mut Bench<'_>) -> Result<(), CaseError>,
) -> Case {
    Case { group: "indirect", name, about, needs: &[], minds: &[], catches, run }
}

pub(super) const CASES: &[Case] = &[
    case(
        "dispatch_counts",
        "as many workgroups run along each axis as the arguments say, none where they say 0",
        &[],
        counts,
    ),
    case(
        "order",
        "32 indirect dispatches whose sizes the ones before wrote, in one submission",
        &[Fault::Barrier],
        order,
    ),
    Case {
        group: "indirect",
        name: "draw_counts",
        about: "as many triangles are drawn as the arguments say",
        needs: GRAPHICS,
        minds: &[],
        catches: &[],
        run: super::raster::indirect,
    },
];

/// Invocations of a workgroup of `count` and `relay`.
const GROUP: u32 = 4;

fn counts(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let sizes = [[1u32, 1, 1], [0, 1, 1], [1, 0, 7], [5, 1, 0], [7, 3, 2], [65_535, 1, 1], [1, 300, 1], [2, 1, 40]];
    let arguments = Buffer::from_slice(bench.device, "arguments", sizes.as_flattened())?;
    let kernel = bench.kernel("count")?;
    let (mut found, mut expected) = (Vec::new(), Vec::new());
    for (index, size) in sizes.iter().enumerate() {
        let words = bench.words("counted", 4)?;
        let mut recorder = Recorder::new(bench.device)?;
        let bindings = Bindings::new().buffer("Words", &words);
        recorder.pass(&kernel.name)?.dispatch_indirect(&kernel, &[&bindings], &(), &arguments, 12 * index as u64)?;
        recorder.submit()?;
        found.push(words.read::<u32>(4)?);
        let groups: u32 = size.iter().product();
        let reached = size.map(|n| if groups == 0 { 0 } else { n });
        expected.push(vec![GROUP * groups, reached[0], reached[1], reached[2]]);
    }
    bench.equal("invocations and reach of each size", &found, &expected);
    Ok(())
}

/// Links of the chain.
const LINKS: u32 = 32;
/// Groups that each link has more than the one before.
const MORE: u32 = 3;

fn order(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let words = bench.words("counted", LINKS)?;
    // Where a link's arguments were not written yet, it has none.
    let mut start = vec![0u32; 3 * (LINKS as usize + 1)];
    start[..3].fill(1);
    let arguments = Buffer::from_slice(bench.device, "arguments", &start)?;
    let kernel = bench.kernel("relay")?;
    let bindings = Bindings::new().buffer("Words", &words).buffer("Arguments", &arguments);
    let mut recorder = Recorder::in_one(bench.device)?;
    for link in in_order(LINKS as usize) {
        let push = ConformancePush { count: 0, a: link as u32, b: MORE, c: 0 };
        let mut pass = recorder.pass(&kernel.name)?;
        pass.dispatch_indirect(&kernel, &[&bindings], &push, &arguments, 12 * link as u64)?;
    }
    recorder.submit()?;
    let expected: Vec<u32> = (0..LINKS).map(|link| GROUP * (1 + MORE * link)).collect();
    bench.equal("invocations of each link", &words.read::<u32>(LINKS as usize)?, &expected);
    Ok(())
}
