//! Runs of one kernel that take turns with their buffers.

use ash::vk;

use super::{Groups, Pass};
use crate::gpu::{Bindings, GpuError, Kernel};

impl Pass<'_> {
    /// Runs `kernel` once for each of `pushes`, by turns with one and the other of `bindings`; each run sees what those before it
    /// wrote. Sets are made once, as in [`dispatch_in_turn`](Pass::dispatch_in_turn).
    pub fn dispatch_by_turns<P: bytemuck::NoUninit>(
        &mut self,
        kernel: &Kernel,
        bindings: [&[&Bindings]; 2],
        pushes: impl IntoIterator<Item = P>,
        groups: Groups<'_>,
    ) -> Result<&mut Self, GpuError> {
        let groups = self.check_groups(kernel, groups)?;
        let mut sets = Vec::new();
        for bindings in bindings {
            let found = self.recorder.descriptors.sets(&kernel.name, &kernel.layout, bindings, size_of::<P>())?;
            sets.push(found);
            bindings.iter().for_each(|b| self.hold(*b));
        }
        let pipeline = kernel.pipeline.get();
        self.hold(&pipeline);
        for (turn, push) in pushes.into_iter().enumerate() {
            if turn > 0 {
                let stage = vk::PipelineStageFlags::COMPUTE_SHADER;
                self.recorder.barrier(stage, vk::AccessFlags::SHADER_READ | vk::AccessFlags::SHADER_WRITE);
            }
            let (raw, commands) = (&self.recorder.device.raw, self.recorder.commands);
            let (point, layout) = (vk::PipelineBindPoint::COMPUTE, &pipeline.layout);
            // SAFETY: the sets were made for the layout that the pipeline was made with, and `sets` checked the push constants' size.
            unsafe {
                if turn == 0 {
                    raw.cmd_bind_pipeline(commands, point, pipeline.raw);
                }
                raw.cmd_bind_descriptor_sets(commands, point, layout.raw, 0, &sets[turn % 2], &[]);
                raw.cmd_push_constants(commands, layout.raw, layout.stages, 0, bytemuck::bytes_of(&push));
            }
            self.run(&groups);
        }
        Ok(self)
    }
}
