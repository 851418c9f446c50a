//! The parallel solver: Godunov's differences, swept in the order in which light goes through the grid.

use super::device::{CheckPush, EikonalChecks, EikonalGrid, EikonalSweep, EikonalVolume, SweepPush};
use super::marching::Order;
use crate::gpu::{Bindings, Buffer, Device, GpuError, Kernel, Recorder};

/// How a wave is solved for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolverOptions {
    pub order: Order,
    /// Times that each cell is visited, at least 1.
    pub visits: u32,
    /// Whether waves that come in by the grid's sides go on there as they are inside; else nothing comes in.
    pub linear: bool,
}

impl Default for SolverOptions {
    fn default() -> Self {
        SolverOptions { order: Order::Second, visits: 4, linear: true }
    }
}

/// How far cells are from what their neighbours say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settled {
    /// Largest difference, in cells times index.
    pub worst: f64,
    /// Cells that differ by more than was tolerated.
    pub unsettled: u32,
    /// Cells in the medium that have no value.
    pub unreached: u32,
    /// Cells whose values were given.
    pub given: u32,
}

/// Levels from one visit of a cell to its next, as in `update.glsl`.
const SPACING: u32 = 3;

pub struct Solver {
    device: Device,
    sweep: Kernel,
    check: Kernel,
}

impl Solver {
    pub fn new(device: &Device) -> Result<Self, GpuError> {
        Ok(Solver {
            device: device.clone(),
            sweep: Kernel::new(device, "eikonal/sweep", "")?,
            check: Kernel::new(device, "eikonal/check", "")?,
        })
    }

    /// Records a sweep over the volume that `bindings` hold: `EikonalVolumes`, whose entry `volume` has `grid`, and
    /// `EikonalValues`, one a cell: [`UNKNOWN`](super::device::UNKNOWN) where to be found, [`OUTSIDE`](super::device::OUTSIDE),
    /// or not less than 0 with the sign bit set where given. Cells are visited outward from the column `foot`.
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
        let turns = grid.cells[2] + farthest(0) + farthest(1) + SPACING * (options.visits - 1);
        let pushes = (0..turns).map(|turn| SweepPush { sweep: EikonalSweep { turn, ..sweep } });
        let invocations = grid.cells[0] * grid.cells[1] * options.visits;
        recorder.pass("eikonal/sweep")?.dispatch_in_turn(&self.sweep, &[bindings], pushes, invocations)?;
        Ok(())
    }

    /// Looks at all cells and waits. `tolerance`: cells times index.
    pub fn check(
        &self,
        bindings: &Bindings,
        volume: &EikonalVolume,
        foot: [i32; 2],
        options: &SolverOptions,
        tolerance: f32,
    ) -> Result<Settled, GpuError> {
        let sums = Buffer::zeroed(&self.device, "eikonal checks", size_of::<EikonalChecks>() as u64)?;
        let bindings = bindings.clone().buffer("EikonalCheckSums", &sums);
        let push = CheckPush { sweep: sweep_of(0, foot, options), tolerance, padding0: 0 };
        let mut recorder = Recorder::new(&self.device)?;
        let cells = volume.grid.cells.iter().product();
        recorder.pass("eikonal/check")?.dispatch(&self.check, &[&bindings], &push, cells)?;
        recorder.submit()?;
        let sums: Vec<EikonalChecks> = sums.read(1)?;
        let found = |sums: &EikonalChecks| Settled {
            worst: f64::from(f32::from_bits(sums.worst)),
            unsettled: sums.unsettled,
            unreached: sums.unreached,
            given: sums.given,
        };
        Ok(sums.first().map_or(Settled { worst: 0.0, unsettled: 0, unreached: 0, given: 0 }, found))
    }
}

fn sweep_of(volume: u32, foot: [i32; 2], options: &SolverOptions) -> EikonalSweep {
    EikonalSweep {
        volume,
        order: if options.order == Order::Second { 2 } else { 1 },
        linear: u32::from(options.linear),
        visits: options.visits,
        foot,
        turn: 0,
        padding0: 0,
    }
}
