//! Pipelines made by many threads at once, and a kernel that does not end.

use std::thread;

use super::{Bench, Case, CaseError};
use crate::conformance::ConformancePush;
use crate::conformance::case::Worst;
use crate::gpu::{Bindings, GpuError, Kernel, Recorder};
use crate::random::mix_bits;

pub(super) const CASES: &[Case] = &[Case {
    group: "pipelines",
    name: "many_threads",
    about: "8 threads make pipelines at once, and each pipeline does its work",
    needs: &[],
    minds: &[],
    catches: &[],
    run: many_threads,
}];

const THREADS: u32 = 8;
/// Pipelines that each thread makes.
const EACH: usize = 8;
/// Words that each pipeline writes.
const WORDS: u32 = 256;

fn many_threads(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let device = bench.device;
    // Others beside the one that is run, so that threads compile different kernels at a time.
    let names = ["conformance/write", "conformance/step", "conformance/atomics", "conformance/arithmetic"];
    let make = |thread: u32| -> Result<Vec<Kernel>, GpuError> {
        let turns = 0..EACH;
        turns.map(|turn| Kernel::anew(device, names[(thread as usize + turn) % names.len()], "")).collect()
    };
    let made: Vec<Result<Vec<Kernel>, GpuError>> = thread::scope(|scope| {
        let threads: Vec<_> = (0..THREADS).map(|thread| scope.spawn(move || make(thread))).collect();
        let lost =
            || GpuError::Kernel { kernel: names[0].to_string(), reason: "a thread that made it died".to_string() };
        threads.into_iter().map(|thread| thread.join().unwrap_or_else(|_| Err(lost()))).collect()
    });
    let words = bench.words("written", WORDS)?;
    let bindings = Bindings::new().buffer("Words", &words);
    for (seed, kernel) in (0u32..).zip(made.into_iter().collect::<Result<Vec<_>, _>>()?.iter().flatten()) {
        if kernel.name != names[0] {
            continue;
        }
        let mut recorder = Recorder::new(device)?;
        let push = ConformancePush { count: WORDS, a: 0, b: 1, c: seed };
        recorder.pass(&kernel.name)?.dispatch(kernel, &[&bindings], &push, WORDS)?;
        recorder.submit()?;
        let expected: Vec<u32> = (0..WORDS).map(|i| mix_bits(i ^ seed)).collect();
        bench.equal("words written", &words.read::<u32>(WORDS as usize)?, &expected);
    }
    Ok(())
}

/// The device is expected to be lost, or the wait to end; anything is better than a hang.
pub(super) fn endless(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let words = crate::gpu::Buffer::from_slice(bench.device, "never zero", &[1u32; 4])?;
    let answer = bench.run("endless", &Bindings::new().buffer("Words", &words), 64, [0; 3]);
    let told = matches!(answer, Err(GpuError::DeviceLost { .. } | GpuError::Timeout { .. }));
    let what = answer.map_or_else(|error| error.to_string(), |()| "the kernel ended".to_string());
    bench.note("the answer", &what);
    let worst = Worst { measured: f64::from(u8::from(!told)), place: what };
    bench.at_most("other answers than a lost device or the end of patience", worst, 0.0, "");
    Ok(())
}
