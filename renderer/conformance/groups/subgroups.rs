//! Subgroups: no kernel relies on them, so this mostly reports.

use std::collections::BTreeSet;

use super::{Bench, Case, CaseError};
use crate::conformance::case::Worst;
use crate::gpu::Bindings;

pub(super) const CASES: &[Case] = &[Case {
    group: "subgroups",
    name: "sizes",
    about: "every invocation has a place of its own in a subgroup; sizes are reported",
    needs: &[],
    minds: &[],
    catches: &[],
    run: sizes,
}];

/// Invocations, of 16 workgroups.
const COUNT: u32 = 1024;
/// Invocations of a workgroup.
const GROUP: usize = 64;

fn sizes(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let words = bench.words("subgroups", 4 * COUNT)?;
    bench.run("subgroups", &Bindings::new().buffer("Words", &words), COUNT, [0; 3])?;
    let found: Vec<[u32; 4]> = words.read(COUNT as usize)?;
    let sizes: BTreeSet<u32> = found.iter().map(|f| f[0]).collect();
    let numbers: BTreeSet<u32> = found.iter().map(|f| f[1]).collect();
    bench.note("size by properties", bench.device.info.limits.subgroup);
    bench.note("sizes in kernels", format!("{sizes:?}"));
    bench.note("subgroups in 64 invocations", format!("{numbers:?}"));
    let mut worst = Worst::default();
    for (group, invocations) in found.chunks(GROUP).enumerate() {
        let places: BTreeSet<_> = invocations.iter().map(|f| (f[2], f[3])).collect();
        let out = invocations.iter().filter(|f| f[3] >= f[0] || f[2] >= f[1]).count();
        worst.see((GROUP - places.len() + out) as f64, || format!("workgroup {group}"));
    }
    bench.at_most("invocations without a place of their own", worst, 0.0, "of a workgroup");
    Ok(())
}
