//! The cases, group by group.

mod atomics;
mod barriers;
mod geometry;
mod image_formats;
mod indirect;
mod memory;
mod pipelines;
mod precision;
mod raster;
mod subgroups;
mod techniques;
mod tracing;

use super::case::{Bench, Case, CaseError};
use crate::gpu::Capability;

/// Every case, in the order in which they run.
pub static CASES: &[&[Case]] = &[
    memory::CASES,
    barriers::CASES,
    atomics::CASES,
    indirect::CASES,
    subgroups::CASES,
    pipelines::CASES,
    precision::CASES,
    image_formats::CASES,
    raster::CASES,
    geometry::CASES,
    tracing::RAY_QUERY_CASES,
    tracing::BVH_CASES,
    techniques::CASES,
    #[cfg(feature = "faults")]
    self_check::CASES,
];

/// A case that hangs the device on purpose; it runs only where it is asked for.
pub static DEVICE_LOSS: Case = Case {
    group: "device",
    name: "loss",
    about: "a kernel that does not end becomes an error, not a hang (--lose-device)",
    needs: &[],
    minds: &[],
    catches: &[],
    run: pipelines::endless,
};

const GRAPHICS: &[Capability] = &[Capability::Graphics];

/// Cases that do what a driver should not, for the tests of the runner.
#[cfg(feature = "faults")]
mod self_check {
    use super::{Bench, Case, CaseError};
    use crate::conformance::case::Worst;

    const fn case(name: &'static str, run: fn(&mut Bench<'_>) -> Result<(), CaseError>) -> Case {
        Case { group: "self_check", name, about: "for tests of the runner", needs: &[], minds: &[], catches: &[], run }
    }

    pub(super) const CASES: &[Case] = &[
        case("passes", |bench| {
            bench.at_most("nothing", Worst::default(), 0.0, "");
            Ok(())
        }),
        case("fails", |bench| {
            bench.at_most("seven", Worst { measured: 7.0, place: "here".to_string() }, 3.5, "things");
            Ok(())
        }),
        case("crashes", |_| std::process::abort()),
        case("hangs", |_| {
            std::thread::sleep(std::time::Duration::from_secs(3600));
            Ok(())
        }),
        case("passes_again", |bench| {
            bench.at_most("nothing", Worst::default(), 0.0, "");
            Ok(())
        }),
    ];
}
