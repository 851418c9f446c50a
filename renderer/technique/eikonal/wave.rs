//! The scalar wave through a volume (Mercier, section 4 and Algorithm 3): what it leaves in each cell while it crosses, as light.
//!
//! With phi_t = 0 at first the sum of phi over all time obeys Laplace's equation, since the sum of phi_tt is phi_t at the end less
//! phi_t at the beginning; so it has no maximum below the surface, and shows no caustic. Energy goes by the square of phi, which
//! is what is summed unless the paper's own is asked for.

pub mod device;

use device::{BLOCK, WaveBlock, WaveGrid, WaveResultPush, WaveStartPush, WaveStepPush};
use glam::{DVec3, UVec3, Vec3};

use super::volume::{Kernels, Volume};
use crate::gpu::{Bindings, Buffer, Device, GpuError, Groups, Kernel, Recorder};

/// How the wave begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// In the cells that are given a pulse comes in when light does and as strong, so that it goes on the way that light does,
    /// whatever the light and the index; beyond the volume's sides, as the eikonal solution goes on there. Above the surface
    /// there is no wave.
    InTime,
    /// The paper's: 1 in the cells that the surface passes through and 0 elsewhere, at rest. It goes up and down, perpendicular
    /// to the surface, as if the index were infinite; air is as water to it.
    AtOnce,
}

/// What is summed over the steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sum {
    /// phi, as printed.
    Signed,
    /// |phi|, which goes by the root of light.
    Absolute,
    /// phi squared, which goes by light.
    Squared,
}

impl Sum {
    /// Of light, the power that sums go by.
    fn root(self) -> f64 {
        if self == Sum::Squared { 1.0 } else { 0.5 }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct WaveOptions {
    pub start: Start,
    pub sum: Sum,
    /// Columns of cells around the volume in which the wave is damped, the more the farther out, to what comes in there.
    pub border: u32,
    /// Width of the pulse that comes in, cells: of a bell its standard deviation; of the odd pulse from its middle to its peak.
    pub pulse: f64,
    /// Light is `gain` times what flat water would leave there, times the sum over flat water's to this power (section 4.1). 1 and 2
    /// give light for sums of squares and of absolute values.
    pub gain: f64,
    pub power: f64,
    /// Of the pulse's height, what is no wave any more. Blocks of cells without a wave are left alone.
    pub quiet: f64,
    /// Instead of as many as the wave takes through the volume.
    pub steps: Option<u32>,
}

impl Default for WaveOptions {
    fn default() -> Self {
        WaveOptions {
            start: Start::InTime,
            sum: Sum::Squared,
            border: 8,
            pulse: 1.0,
            gain: 1.0,
            power: 1.0,
            quiet: 3e-2,
            steps: None,
        }
    }
}

/// Cells before the first light that time begins: the pulse's first half.
const LEAD: f64 = 6.0;
/// Of the longest way, how much longer light may take that waves have bent.
const BENT: f64 = 0.15;
/// Damping a step in the border's outermost columns.
const DAMPING: f32 = 2.0;
/// Blocks of a column that are looked at one after the other.
const BLOCKS_A_STRAND: u32 = 8;
/// Invocations that step a block.
const TILES: u32 = 16;

pub struct WaveKernels {
    start: Kernel,
    step: Kernel,
    result: Kernel,
}

impl WaveKernels {
    pub fn new(device: &Device) -> Result<Self, GpuError> {
        Ok(WaveKernels {
            start: Kernel::new(device, "eikonal/wave_start", "")?,
            step: Kernel::new(device, "eikonal/wave_step", "")?,
            result: Kernel::new(device, "eikonal/wave_result", "")?,
        })
    }
}

/// How much there was to do in the last recording that was run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stepped {
    /// Steps after which there was no wave left, or all there were.
    pub steps: u32,
    /// Of all blocks, those that were stepped in the mean over those steps.
    pub part: f64,
}

/// A wave in the cells of a volume.
pub struct Wave {
    grid: WaveGrid,
    options: WaveOptions,
    steps: u32,
    /// Light for which the amplitude is 1.
    scale: f64,
    /// Metres times index, a cell.
    step: f64,
    phi: [Buffer; 2],
    sums: Buffer,
    blocks: Buffer,
    tally: Buffer,
    /// By turns.
    bindings: [Bindings; 2],
}

impl Wave {
    /// Fails where the cells do not fit a buffer.
    pub fn new(device: &Device, volume: &Volume, options: &WaveOptions) -> Result<Self, GpuError> {
        let shared = volume.shared();
        let top = u32::from(options.start == Start::AtOnce);
        let around = [2 * options.border, 2 * options.border, top];
        let blocks = [0, 1, 2].map(|i| (shared.grid.cells[i] + around[i]).div_ceil(BLOCK[i]));
        let grid = WaveGrid {
            cells: shared.grid.cells,
            first: shared.grid.first,
            strides: shared.grid.strides,
            border: options.border,
            blocks,
            top,
        };
        let buffer = |name: &str| Buffer::new(device, name, 4 * grid.padded().iter().product::<u64>());
        let phi = [buffer("wave phi, even")?, buffer("wave phi, odd")?];
        let sums = buffer("wave sums")?;
        let count = blocks.iter().map(|&n| u64::from(n)).product::<u64>();
        let block_bytes = count * size_of::<WaveBlock>() as u64;
        let blocks = Buffer::new(device, "wave blocks", block_bytes)?;
        let tally = Buffer::zeroed(device, "wave tally", 8)?;
        let bindings = (volume.bindings.clone())
            .buffer("WaveSums", &sums)
            .buffer("WaveArrivals", &buffer("wave arrivals")?)
            .buffer("WaveAmplitudes", &buffer("wave amplitudes")?)
            .buffer("WaveBlocks", &blocks)
            .buffer("WaveTally", &tally);
        let turn = |now: usize| bindings.clone().buffer("WaveNow", &phi[now]).buffer("WaveBefore", &phi[1 - now]);
        Ok(Wave {
            steps: options.steps.unwrap_or_else(|| steps_through(volume, options)),
            scale: brightest(volume),
            step: f64::from(shared.grid.index * shared.grid.cell),
            bindings: [turn(0), turn(1)],
            options: options.clone(),
            grid,
            phi,
            sums,
            blocks,
            tally,
        })
    }

    /// Records the way from the scene's triangles, as they are then, to the volume's light, in place of
    /// [`Volume::record`]: what is given, of a wave that starts in time the eikonal solution too, then the wave.
    pub fn record(
        &self,
        recorder: &mut Recorder,
        scene: &Bindings,
        volume: &Volume,
        kernels: &Kernels,
        wave_kernels: &WaveKernels,
    ) -> Result<(), GpuError> {
        self.record_before(recorder, scene, volume, kernels)?;
        self.record_through(recorder, wave_kernels)
    }

    /// Records what the wave starts from.
    pub fn record_before(
        &self,
        recorder: &mut Recorder,
        scene: &Bindings,
        volume: &Volume,
        kernels: &Kernels,
    ) -> Result<(), GpuError> {
        volume.record_given(recorder, scene, kernels)?;
        volume.record_wave(recorder, kernels)?;
        volume.record_light(recorder, scene, kernels)
    }

    /// Records the wave alone, after [`record_before`](Self::record_before).
    pub fn record_through(&self, recorder: &mut Recorder, kernels: &WaveKernels) -> Result<(), GpuError> {
        let WaveOptions { start, sum, gain, power, .. } = self.options;
        let mut pass = recorder.pass("eikonal/wave_clear")?;
        for buffer in [&self.phi[0], &self.phi[1], &self.sums, &self.blocks, &self.tally] {
            pass.fill(buffer, 0);
        }
        drop(pass);
        let flat_sum = self.flat_sum();
        let push = WaveStartPush {
            grid: self.grid,
            step: self.step as f32,
            lead: LEAD as f32,
            scale: self.scale as f32,
            at_once: if start == Start::AtOnce { flat_sum as f32 } else { 0.0 },
        };
        let [even, odd] = &self.bindings;
        let blocks = self.grid.blocks.iter().product::<u32>();
        recorder.pass("eikonal/wave_start")?.dispatch(&kernels.start, &[even], &push, TILES * blocks)?;
        let strands = self.grid.blocks[2].div_ceil(BLOCKS_A_STRAND);
        let pushes = (0..self.steps).map(|turn| WaveStepPush {
            grid: self.grid,
            turn,
            sum: sum as u32,
            quiet: self.options.quiet as f32,
            width: self.options.pulse as f32,
            damping: DAMPING,
            strands,
        });
        let groups = Groups::of(&kernels.step, TILES * self.grid.blocks[0] * self.grid.blocks[1] * strands);
        let turns: [&[&Bindings]; 2] = [&[even], &[odd]];
        recorder.pass("eikonal/wave_step")?.dispatch_by_turns(&kernels.step, turns, pushes, groups)?;
        let by_light = start == Start::InTime;
        let push = WaveResultPush {
            grid: self.grid,
            scale: self.scale as f32,
            flat_sum: (flat_sum / if by_light { self.scale.powf(sum.root()) } else { 1.0 }) as f32,
            root: if by_light { sum.root() as f32 } else { 0.0 },
            gain: gain as f32,
            power: power as f32,
        };
        let columns = self.grid.cells[0] * self.grid.cells[1];
        recorder.pass("eikonal/wave_result")?.dispatch(&kernels.result, &[even], &push, columns)?;
        Ok(())
    }

    /// What flat water's wave leaves in a cell where its amplitude is 1. Let go at once it goes half up and half down; a pulse that
    /// comes in is summed over its length.
    fn flat_sum(&self) -> f64 {
        use std::f64::consts::{E, PI};
        let width = self.options.pulse;
        match (self.options.start, self.options.sum) {
            (Start::AtOnce, Sum::Squared) => 0.25,
            (Start::AtOnce, _) => 0.5,
            (Start::InTime, Sum::Signed) => width * (2.0 * PI).sqrt(),
            (Start::InTime, Sum::Absolute) => 2.0 * width * E.sqrt(),
            (Start::InTime, Sum::Squared) => 0.5 * width * E * PI.sqrt(),
        }
    }

    pub fn stepped(&self) -> Result<Stepped, GpuError> {
        let found: Vec<u32> = self.tally.read(2)?;
        let [blocks, steps] = [0, 1].map(|i| found.get(i).copied().unwrap_or(0));
        let all = f64::from(self.grid.blocks.iter().product::<u32>()) * f64::from(steps.max(1));
        Ok(Stepped { steps, part: f64::from(blocks) / all })
    }

    /// phi after the last step, in order of the volume's cells.
    pub fn read_phi(&self) -> Result<Vec<f32>, GpuError> {
        self.in_order(&self.phi[self.steps as usize % 2])
    }

    /// What was summed, in order of the volume's cells.
    pub fn read_sums(&self) -> Result<Vec<f32>, GpuError> {
        self.in_order(&self.sums)
    }

    fn in_order(&self, buffer: &Buffer) -> Result<Vec<f32>, GpuError> {
        let WaveGrid { cells: [u, v, planes], first, strides, .. } = self.grid;
        let found: Vec<f32> = buffer.read(self.grid.padded().iter().product::<u64>() as usize)?;
        let mut ordered = vec![0.0; (u * v * planes) as usize];
        for z in 0..planes {
            for y in 0..v {
                for x in 0..u {
                    let cell = first + x as i32 * strides[0] + y as i32 * strides[1] + z as i32 * strides[2];
                    ordered[cell as usize] = found[self.grid.index([x, y, z])];
                }
            }
        }
        Ok(ordered)
    }
}

/// Steps after which what comes in has gone through: light goes a cell in a step.
fn steps_through(volume: &Volume, options: &WaveOptions) -> u32 {
    let shared = volume.shared();
    let source = &shared.source;
    let size = volume.grid().cell * UVec3::from(volume.grid().cells).as_dvec3();
    let lower = volume.grid().lower;
    let place = Vec3::from(source.place).as_dvec3();
    let reference = Vec3::from(source.reference).as_dvec3();
    // No path is longer than straight on through the denser of both media.
    let away =
        |corner: DVec3| if source.kind == 0 { corner.distance(reference) } else { place.dot(corner - reference) };
    let longest = (0..8u32).map(|i| {
        let far = glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0);
        away(DVec3::select(far, lower + size, lower))
    });
    let denser = f64::from(source.index.max(shared.grid.index) / shared.grid.index);
    let through = f64::from(shared.grid.cells[2]);
    let longest = longest.fold(0.0, f64::max) * denser / volume.grid().cell;
    // Without a light in time with which it starts the wave only has the planes to go through.
    let longest = if options.start == Start::AtOnce || source.kind == 2 { through } else { longest };
    let steps = LEAD + longest + BENT * through + 2.0 * LEAD * options.pulse;
    steps.ceil() as u32
}

/// The light where the volume is nearest to it, over what it sends.
fn brightest(volume: &Volume) -> f64 {
    let source = &volume.shared().source;
    if source.kind != 0 {
        return 1.0;
    }
    let place = Vec3::from(source.place).as_dvec3();
    let size = volume.grid().cell * UVec3::from(volume.grid().cells).as_dvec3();
    let nearest = place.clamp(volume.grid().lower, volume.grid().lower + size);
    1.0 / place.distance_squared(nearest).max(volume.grid().cell.powi(2))
}
