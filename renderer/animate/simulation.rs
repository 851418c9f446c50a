//! Simulated water: the damped wave equation on a height field's vertices, step after step on the device.
//!
//! The state is a height and the increment that led to it, two floats each. Frame n is n times a fixed number of steps
//! after time 0, whatever frames were shown before: the way back is another start.

use std::ops::Range;

use glam::DVec2;

use super::add_times;
use crate::gpu::{Bindings, Buffer, Device, GpuError, GpuStruct, Kernel, Layout, PassTime, Recorder};
use crate::scene::animation::{Drop, Simulation};
use crate::scene::height_field::HeightField;

crate::gpu_struct! {
    /// See `kernels/animate/sheet.glsl`.
    pub struct SheetPush {
        pub columns: u32,
        pub rows: u32,
        pub along_x: f32,
        pub along_z: f32,
        pub gain: f32,
        pub loss: f32,
        pub first: u32,
        pub count: u32,
    }
}

crate::gpu_struct! {
    /// A drop; see `kernels/animate/drops.comp.glsl`.
    pub struct SheetDrop {
        pub centre: [f32; 2],
        pub spacing: [f32; 2],
        pub height: f32,
        pub padding0: u32,
    }
}

crate::gpu_struct! {
    pub struct SheetMeshPush {
        pub first_vertex: u32,
        pub columns: u32,
        pub rows: u32,
        pub base: f32,
        pub per_x: f32,
        pub per_z: f32,
    }
}

pub(super) const LAYOUTS: &[Layout] = &[SheetPush::LAYOUT, SheetDrop::LAYOUT, SheetMeshPush::LAYOUT];

/// Vertices times steps and drops in one submission: about a second without a GPU. A step of 263,169 vertices took SwiftShader 29 ms
/// and llvmpipe 8 ms on two cores that other work had too, so 110 and 31 ns a vertex.
const VERTEX_STEPS: u64 = 1 << 23;

/// Steps and drops in one submission, and drops in one pass, at most.
const MOST_WORK: u64 = 256;
const MOST_DROPS: usize = 64;

/// What one submission does, in this order.
#[derive(Default)]
struct Batch {
    work: Vec<Work>,
    drops: Vec<SheetDrop>,
    /// Steps and drops: a drop takes about what a step takes.
    cost: usize,
}

enum Work {
    /// Step 0 is the start.
    Step(u64),
    /// The drops of this range fall at this step.
    Drops(u64, Range<usize>),
}

impl Batch {
    fn step(&mut self, step: u64) {
        self.work.push(Work::Step(step));
        self.cost += 1;
    }

    fn drops(&mut self, step: u64, drops: &[SheetDrop]) {
        let first = self.drops.len();
        self.drops.extend(drops);
        self.work.push(Work::Drops(step, first..self.drops.len()));
        self.cost += drops.len();
    }
}

/// A height field under the wave equation.
pub(super) struct SimulatedWater {
    device: Device,
    field: HeightField,
    simulation: Simulation,
    /// A frame.
    steps: u64,
    /// Steps a second.
    rate: f64,
    push: SheetPush,
    surface_push: SheetMeshPush,
    /// As it is let go: heights, then increments of half a step before.
    start: Buffer,
    heights: [Buffer; 2],
    increments: Buffer,
    /// For even and odd steps: which heights are now.
    bindings: [Bindings; 2],
    simulate: Kernel,
    drops: Kernel,
    surface: Kernel,
    /// The step that the state is at, where it is at any.
    at: Option<u64>,
    /// The step that the vertices show.
    shown: Option<u64>,
}

impl SimulatedWater {
    /// `vertices`: the buffer that the field's mesh is in, and the index of its first vertex there.
    pub fn new(
        device: &Device,
        field: &HeightField,
        simulation: &Simulation,
        fps: f64,
        (vertices, first_vertex): (&Buffer, u32),
    ) -> Result<Self, GpuError> {
        let steps = simulation.steps_per_frame(field, fps);
        let rate = fps * f64::from(steps);
        let [columns, rows] = field.quads.map(|quads| quads + 1);
        let spacing = field.spacing();
        let couple = (simulation.speed / (rate * spacing)).powf(2.0);
        // Damping takes g (d(n-1/2) + d(n+1/2)) from the acceleration.
        let g = 0.5 * simulation.damping / rate;
        let push = SheetPush {
            columns,
            rows,
            along_x: couple.x as f32,
            along_z: couple.y as f32,
            gain: (1.0 / (1.0 + g)) as f32,
            loss: (2.0 * g / (1.0 + g)) as f32,
            first: 0,
            count: 0,
        };
        let per = (0.5 / spacing).as_vec2();
        let surface_push =
            SheetMeshPush { first_vertex, columns, rows, base: field.base as f32, per_x: per.x, per_z: per.y };
        let start = Buffer::from_slice(device, "simulated water at its start", &start(field, couple))?;
        let state = |name| Buffer::new(device, name, start.size() / 2);
        let heights = [state("heights of even steps")?, state("heights of odd steps")?];
        let increments = state("increments of heights")?;
        let bindings = [[0, 1], [1, 0]].map(|[now, next]| {
            Bindings::new()
                .buffer("Vertices", vertices)
                .buffer("HeightsNow", &heights[now])
                .buffer("HeightsNext", &heights[next])
                .buffer("Increments", &increments)
        });
        Ok(SimulatedWater {
            device: device.clone(),
            field: field.clone(),
            simulation: simulation.clone(),
            steps: steps.into(),
            rate,
            push,
            surface_push,
            start,
            heights,
            increments,
            bindings,
            simulate: Kernel::new(device, "animate/simulate", "")?,
            drops: Kernel::new(device, "animate/drops", "")?,
            surface: Kernel::new(device, "animate/surface", "")?,
            at: None,
            shown: None,
        })
    }

    /// Moves the vertices on the device; false where they are there already.
    pub fn go_to(&mut self, frame: u32, times: &mut Vec<PassTime>) -> Result<bool, GpuError> {
        let step = u64::from(frame) * self.steps;
        if self.shown == Some(step) {
            return Ok(false);
        }
        self.shown = None;
        self.advance(step, times)?;
        let mut recorder = Recorder::new(&self.device)?;
        recorder.pass("animate/surface")?.dispatch(
            &self.surface,
            &[&self.bindings[parity(step)]],
            &self.surface_push,
            self.vertices(),
        )?;
        add_times(times, recorder.submit()?);
        self.shown = Some(step);
        Ok(true)
    }

    /// Takes the state to step `to`.
    fn advance(&mut self, to: u64, times: &mut Vec<PassTime>) -> Result<(), GpuError> {
        // An error on the way leaves no state that could be gone on from.
        let first = self.at.take().filter(|&at| at <= to).map_or(0, |at| at + 1);
        let room = (VERTEX_STEPS / u64::from(self.vertices())).clamp(1, MOST_WORK) as usize;
        let mut batch = Batch::default();
        for step in first..=to {
            batch.step(step);
            for drops in self.drops_at(step).chunks(MOST_DROPS.min(room)) {
                if batch.cost + drops.len() > room {
                    self.run(std::mem::take(&mut batch), times)?;
                }
                batch.drops(step, drops);
            }
            if batch.cost >= room || step == to {
                self.run(std::mem::take(&mut batch), times)?;
            }
        }
        self.at = Some(to);
        Ok(())
    }

    fn run(&self, batch: Batch, times: &mut Vec<PassTime>) -> Result<(), GpuError> {
        let drops = Buffer::from_slice(&self.device, "drops", &batch.drops)?;
        let drops = Bindings::new().buffer("SheetDrops", &drops);
        let mut recorder = Recorder::new(&self.device)?;
        for work in batch.work {
            match work {
                Work::Step(0) => {
                    let half = self.increments.size();
                    let mut pass = recorder.pass("animate/start")?;
                    pass.copy(&self.start, 0, &self.heights[0], 0, half);
                    pass.copy(&self.start, half, &self.increments, 0, half);
                }
                Work::Step(step) => {
                    let before = &self.bindings[parity(step - 1)];
                    let mut pass = recorder.pass("animate/simulate")?;
                    pass.dispatch(&self.simulate, &[before], &self.push, self.vertices())?;
                }
                Work::Drops(step, range) => {
                    let push = SheetPush { first: range.start as u32, count: range.len() as u32, ..self.push };
                    let bindings = [&self.bindings[parity(step)], &drops];
                    recorder.pass("animate/drops")?.dispatch(&self.drops, &bindings, &push, self.vertices())?;
                }
            }
        }
        add_times(times, recorder.submit()?);
        Ok(())
    }

    /// The drops whose times are nearest to this step's.
    fn drops_at(&self, step: u64) -> Vec<SheetDrop> {
        let from = |step: u64| (step as f64 - 0.5) / self.rate;
        let spacing = self.field.spacing();
        let origin = DVec2::new(self.field.x[0], self.field.z[0]);
        let record = |drop: Drop| SheetDrop {
            centre: ((drop.centre - origin) / spacing).as_vec2().to_array(),
            spacing: (spacing / drop.radius).as_vec2().to_array(),
            height: drop.height as f32,
            padding0: 0,
        };
        let drops = self.simulation.drops_between(&self.field, from(step), from(step + 1));
        drops.into_iter().map(record).collect()
    }

    fn vertices(&self) -> u32 {
        self.push.columns * self.push.rows
    }
}

fn parity(step: u64) -> usize {
    (step & 1) as usize
}

/// Heights above the base, then the increments of half a step before that leave the sheet at rest at time 0.
fn start(field: &HeightField, couple: DVec2) -> Vec<[f32; 2]> {
    let [columns, rows] = field.quads.map(|quads| quads as usize + 1);
    let heights: Vec<f64> = field.vertices().map(|(x, z)| field.height(x, z) - field.base).collect();
    // Behind a wall the sheet is its own mirror image.
    let before = |at: usize| if at == 0 { 1 } else { at - 1 };
    let after = |at: usize, count: usize| if at + 1 == count { at - 1 } else { at + 1 };
    let increments = (0..heights.len()).map(|index| {
        let (column, row) = (index % columns, index / columns);
        let bend = |a: usize, b: usize| heights[a] + heights[b] - 2.0 * heights[index];
        let across = bend(row * columns + before(column), row * columns + after(column, columns));
        let along = bend(before(row) * columns + column, after(row, rows) * columns + column);
        -0.5 * (couple.x * across + couple.y * along)
    });
    let split = |value: f64| [value as f32, (value - f64::from(value as f32)) as f32];
    heights.iter().copied().chain(increments).map(split).collect()
}
