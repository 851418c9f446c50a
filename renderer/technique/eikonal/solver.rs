//! The parallel solver: Godunov's differences, swept in the order in which light goes through the grid.

use super::device::{CheckPush, DecidePush, EikonalChecks, EikonalGrid, EikonalSweep, SweepPush};
use super::marching::Order;
use crate::gpu::{Bindings, Buffer, Device, GpuError, Groups, Kernel, Recorder};

/// How a wave is solved for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolverOptions {
    pub order: Order,
    /// Times that the first sweep visits each cell, at least 1.
    pub visits: u32,
    /// Rounds of further sweeps at most, while any cell is off by more than [`TOLERANCE`].
    pub rounds: u32,
    /// Whether waves that come in by the grid's sides go on there as they are inside; else nothing comes in.
    pub linear: bool,
}

impl Default for SolverOptions {
    fn default() -> Self {
        SolverOptions { order: Order::Second, visits: 2, rounds: 1, linear: true }
    }
}

/// How far cells are from what their neighbours say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settled {
    /// Largest difference, in cells times index.
    pub worst: f64,
    /// Cells that differ by more than [`TOLERANCE`].
    pub unsettled: u32,
    /// Cells in the medium that have no value.
    pub unreached: u32,
}

/// Cells times index by which a cell may be off what its neighbours say: ten times what rounding leaves.
pub const TOLERANCE: f32 = 1e-4;

/// Levels from one visit of a cell to its next, as in `update.glsl`.
const SPACING: u32 = 3;
/// The orders of a further round, as in [`EikonalSweep::inward`]: light that waves or lenses bend towards the foot, along both
/// axes or one, and what then goes outward again.
const ROUND: [u32; 4] = [3, 1, 2, 0];

pub struct Solver {
    sweep: Kernel,
    check: Kernel,
    decide: Kernel,
    sums: Buffer,
}

impl Solver {
    pub fn new(device: &Device) -> Result<Self, GpuError> {
        Ok(Solver {
            sweep: Kernel::new(device, "eikonal/sweep", "")?,
            check: Kernel::new(device, "eikonal/check", "")?,
            decide: Kernel::new(device, "eikonal/decide", "")?,
            sums: Buffer::zeroed(device, "eikonal checks", size_of::<EikonalChecks>() as u64)?,
        })
    }

    /// Records sweeps over the volume that `bindings` hold: `EikonalVolumes`, whose entry `volume` has `grid`, and
    /// `EikonalValues`, one a cell: [`UNKNOWN`](super::device::UNKNOWN) where to be found, [`OUTSIDE`](super::device::OUTSIDE),
    /// or not less than 0 with the sign bit set where given. `foot`: the column from which light spreads.
    pub fn record(
        &self,
        recorder: &mut Recorder,
        bindings: &Bindings,
        volume: u32,
        grid: &EikonalGrid,
        foot: [i32; 2],
        options: &SolverOptions,
    ) -> Result<(), GpuError> {
        let sweep = sweep_of(volume, foot, options);
        let farthest = |i: usize| foot[i].max(grid.cells[i] as i32 - 1 - foot[i]) as u32;
        let levels = grid.cells[2] + farthest(0) + farthest(1);
        let columns = grid.cells[0] * grid.cells[1];
        let turns = levels + SPACING * (options.visits - 1);
        let pushes = (0..turns).map(|turn| SweepPush { sweep: EikonalSweep { turn, ..sweep } });
        let groups = Groups::of(&self.sweep, columns * options.visits);
        recorder.pass("eikonal/sweep")?.dispatch_in_turn(&self.sweep, &[bindings], pushes, groups)?;
        for _ in 0..options.rounds {
            self.record_check(recorder, bindings, grid, sweep)?;
            let [groups_x, groups_y] = Groups::folded(&self.sweep, columns);
            let own = bindings.clone().buffer("EikonalCheckSums", &self.sums);
            let push = DecidePush { groups_x, groups_y };
            recorder.pass("eikonal/decide")?.dispatch(&self.decide, &[&own], &push, 1)?;
            let turn = |inward| {
                (0..levels).map(move |turn| SweepPush { sweep: EikonalSweep { turn, inward, visits: 1, ..sweep } })
            };
            let groups = Groups::From(&self.sums, GROUPS_OFFSET);
            let pushes = ROUND.into_iter().flat_map(turn);
            recorder.pass("eikonal/settle")?.dispatch_in_turn(&self.sweep, &[bindings], pushes, groups)?;
        }
        Ok(())
    }

    fn record_check(
        &self,
        recorder: &mut Recorder,
        bindings: &Bindings,
        grid: &EikonalGrid,
        sweep: EikonalSweep,
    ) -> Result<(), GpuError> {
        recorder.pass("eikonal/clear_check")?.fill(&self.sums, 0);
        let own = bindings.clone().buffer("EikonalCheckSums", &self.sums);
        let push = CheckPush { sweep, tolerance: TOLERANCE, padding0: 0 };
        recorder.pass("eikonal/check")?.dispatch(&self.check, &[&own], &push, grid.cells.iter().product())?;
        Ok(())
    }

    /// Looks at all cells and waits.
    pub fn check(
        &self,
        device: &Device,
        bindings: &Bindings,
        grid: &EikonalGrid,
        foot: [i32; 2],
        options: &SolverOptions,
    ) -> Result<Settled, GpuError> {
        let mut recorder = Recorder::new(device)?;
        self.record_check(&mut recorder, bindings, grid, sweep_of(0, foot, options))?;
        recorder.submit()?;
        let sums: Vec<EikonalChecks> = self.sums.read(1)?;
        let found = |sums: &EikonalChecks| Settled {
            worst: f64::from(f32::from_bits(sums.worst)),
            unsettled: sums.unsettled,
            unreached: sums.unreached,
        };
        Ok(sums.first().map_or(Settled { worst: 0.0, unsettled: 0, unreached: 0 }, found))
    }
}

/// Bytes of [`EikonalChecks`] before its group counts.
const GROUPS_OFFSET: u64 = std::mem::offset_of!(EikonalChecks, groups) as u64;

fn sweep_of(volume: u32, foot: [i32; 2], options: &SolverOptions) -> EikonalSweep {
    EikonalSweep {
        volume,
        order: if options.order == Order::Second { 2 } else { 1 },
        linear: u32::from(options.linear),
        visits: options.visits,
        foot,
        turn: 0,
        inward: 0,
    }
}
