//! The parallel solver: Godunov's differences, swept in the order in which light goes through the grid.

use super::device::{CheckPush, DecidePush, EikonalChecks, EikonalGrid, EikonalSweep, SettlePush, SweepPush};
use super::marching::Order;
use crate::gpu::{Bindings, Buffer, Device, GpuError, Groups, Kernel, Recorder};

/// How values come from their neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheme {
    /// Plane by plane, each cell along its light's way from between cells of the plane before.
    Planes,
    /// Differences against the wave, in sweeps.
    Sweeps(Order),
    /// Fast marching, on the host, for comparison.
    Marching(Marching),
}

/// The paper's method, with or without what it prints of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Marching {
    pub order: Order,
    /// Begins from the surface's vertices in their cells (Algorithm 1), which makes noise (erratum 17).
    pub snapped: bool,
    /// Finds the grid's sides first (Algorithm 2).
    pub sides: bool,
}

/// How a wave is solved for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolverOptions {
    pub scheme: Scheme,
    /// With sweeps, rounds of further ones at most, while cells have not settled.
    pub rounds: u32,
    /// Whether waves that come in by the grid's sides are as if the surface went on linearly there; else nothing comes in.
    pub linear: bool,
}

impl Default for SolverOptions {
    fn default() -> Self {
        SolverOptions { scheme: Scheme::Planes, rounds: 1, linear: true }
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

/// Cells times index by which a cell may be off what its neighbours say.
pub const TOLERANCE: f32 = 1e-4;

/// Cells times index from which on a block of cells is visited again; errors of many cells add up on the light's way.
const ASKS: f32 = 1e-5;
/// What rounding leaves of that: of values of as many cells as there are along the three sides.
const ROUNDING: f32 = 1.2e-7;
/// Of what a block is visited for, the change that its neighbours are visited for.
const PASSED_ON: f32 = 0.5;
/// Planes that an invocation goes through, as in the kernels.
pub(super) const BLOCK: u32 = 4;
/// Bits of [`EikonalSweep::options`].
const SECOND: u32 = 1;
const LINEAR: u32 = 2;
const BACKWARD: u32 = 4;
/// The sweeps of a further round, in units of [`BACKWARD`].
const ROUND: [u32; 4] = [0, 1, 2, 3];

pub struct Solver {
    plane: Kernel,
    sweep: Kernel,
    settle: Kernel,
    check: Kernel,
    decide: Kernel,
    sums: Buffer,
}

impl Solver {
    pub fn new(device: &Device) -> Result<Self, GpuError> {
        Ok(Solver {
            plane: Kernel::new(device, "eikonal/plane", "")?,
            sweep: Kernel::new(device, "eikonal/sweep", "")?,
            settle: Kernel::new(device, "eikonal/settle", "")?,
            check: Kernel::new(device, "eikonal/check", "")?,
            decide: Kernel::new(device, "eikonal/decide", "")?,
            sums: Buffer::zeroed(device, "eikonal checks", size_of::<EikonalChecks>() as u64)?,
        })
    }

    /// Records how the values of `grid` are found, unless that is the host's. `bindings` hold `EikonalSides` and `EikonalAsked`, which
    /// [`Volume`](super::Volume) makes, and `EikonalValues`, one a cell: [`UNKNOWN`](super::device::UNKNOWN) where to be
    /// found, [`OUTSIDE`](super::device::OUTSIDE), or not less than 0 with the sign bit set where given. `foot`: the column
    /// from which light spreads.
    pub fn record(
        &self,
        recorder: &mut Recorder,
        bindings: &Bindings,
        grid: &EikonalGrid,
        foot: [i32; 2],
        options: &SolverOptions,
    ) -> Result<(), GpuError> {
        let sweep = sweep_of(grid, foot, options);
        let [u, v, planes] = grid.cells;
        if options.scheme == Scheme::Planes {
            let pushes = (1..planes).map(|turn| SweepPush { sweep: EikonalSweep { turn, ..sweep } });
            let groups = Groups::of(&self.plane, u * v);
            recorder.pass("eikonal/plane")?.dispatch_in_turn(&self.plane, &[bindings], pushes, groups)?;
            return Ok(());
        }
        if matches!(options.scheme, Scheme::Marching(_)) {
            return Ok(());
        }
        let blocks = planes.div_ceil(BLOCK);
        let pushes = (0..blocks + farthest(grid, foot)).map(|turn| SweepPush { sweep: EikonalSweep { turn, ..sweep } });
        let groups = Groups::of(&self.sweep, 2 * u * blocks);
        recorder.pass("eikonal/sweep")?.dispatch_in_turn(&self.sweep, &[bindings], pushes, groups)?;
        let own = bindings.clone().buffer("EikonalCheckSums", &self.sums);
        for _ in 0..options.rounds {
            self.record_check(recorder, bindings, grid, sweep)?;
            let [groups_x, groups_y] = Groups::folded(&self.settle, u * blocks);
            let push = DecidePush { groups_x, groups_y };
            recorder.pass("eikonal/decide")?.dispatch(&self.decide, &[&own], &push, 1)?;
            let least = PASSED_ON * asks(grid) * sweep.step;
            let pushes = ROUND.into_iter().flat_map(|backward| {
                let options = sweep.options + backward * BACKWARD;
                let turn = move |turn| EikonalSweep { turn, options, ..sweep };
                (0..blocks + u + v - 2).map(move |at| SettlePush { sweep: turn(at), least, padding0: 0 })
            });
            let groups = Groups::From(&self.sums, GROUPS_OFFSET);
            recorder.pass("eikonal/settle")?.dispatch_in_turn(&self.settle, &[&own], pushes, groups)?;
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
        let blocks = grid.cells[0] * grid.cells[1] * grid.cells[2].div_ceil(BLOCK);
        let push = CheckPush { sweep, tolerance: TOLERANCE, asks: asks(grid) };
        recorder.pass("eikonal/check")?.dispatch(&self.check, &[&own], &push, blocks)?;
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
        self.record_check(&mut recorder, bindings, grid, sweep_of(grid, foot, options))?;
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
const GROUPS_OFFSET: u64 = std::mem::offset_of!(EikonalChecks, groups_x) as u64;

/// Turns between the first visit of a plane and the last; on the foot's lower side they are one later.
fn farthest(grid: &EikonalGrid, foot: [i32; 2]) -> u32 {
    let turns = |i: usize| (foot[i] + 1).max(grid.cells[i] as i32 - 1 - foot[i]) as u32;
    turns(0) + turns(1)
}

fn asks(grid: &EikonalGrid) -> f32 {
    ASKS.max(ROUNDING * grid.cells.iter().sum::<u32>() as f32)
}

fn sweep_of(grid: &EikonalGrid, foot: [i32; 2], options: &SolverOptions) -> EikonalSweep {
    let second = if options.scheme == Scheme::Sweeps(Order::Second) { SECOND } else { 0 };
    let linear = if options.linear { LINEAR } else { 0 };
    EikonalSweep {
        cells: grid.cells,
        first: grid.first,
        strides: grid.strides,
        step: grid.index * grid.cell,
        foot,
        turn: 0,
        options: second + linear,
    }
}
