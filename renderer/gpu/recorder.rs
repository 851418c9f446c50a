//! One command buffer, recorded as named passes: the name is the debug label, the timestamp and the barrier.

mod turns;

use std::any::Any;
use std::sync::Arc;
use std::time::Instant;

use ash::vk;

use super::descriptors::DescriptorPools;
use super::error::Call;
use super::queries::Queries;
use super::{Bindings, Buffer, Capability, Device, GpuError, Kernel};
use crate::spans::{self, Mark};

/// Workgroups along x before a dispatch folds into y; every device offers this many.
const MAX_GROUPS_X: u32 = 65535;

/// How long a pass took on the device.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct PassTime {
    pub name: String,
    /// `None` where the device has no timestamps.
    pub milliseconds: Option<f64>,
}

/// Records passes, then runs them.
pub struct Recorder {
    command_pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    queries: Queries,
    passes: Vec<String>,
    /// Times of the passes that were submitted alone.
    times: Vec<PassTime>,
    descriptors: DescriptorPools,
    /// Whether each pass is submitted when the next one opens.
    each_pass: bool,
    /// Whatever the commands use, held until they have run.
    held: Vec<Arc<dyn Any>>,
    // Dropped after what is held, which may be the last to use it: fields go in their order.
    device: Device,
}

impl Recorder {
    pub fn new(device: &Device) -> Result<Self, GpuError> {
        Self::with(device, device.quirks.submit_each_pass)
    }

    /// As [`new`](Self::new), with all passes in one submission whatever the device's quirks: what orders them is then their
    /// barriers alone. Their times may be wrong.
    pub fn in_one(device: &Device) -> Result<Self, GpuError> {
        Self::with(device, false)
    }

    fn with(device: &Device, each_pass: bool) -> Result<Self, GpuError> {
        let pool_info = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::TRANSIENT)
            .queue_family_index(device.queue_family);
        // SAFETY: the family is the one the device was made with.
        let command_pool = unsafe { device.raw.create_command_pool(&pool_info, None) }.call("vkCreateCommandPool")?;
        let mut recorder = Recorder {
            device: device.clone(),
            command_pool,
            commands: vk::CommandBuffer::null(),
            queries: Queries::new(device, !each_pass),
            passes: Vec::new(),
            times: Vec::new(),
            descriptors: DescriptorPools::new(device),
            each_pass,
            held: Vec::new(),
        };
        let info = vk::CommandBufferAllocateInfo::default().command_pool(command_pool).command_buffer_count(1);
        // SAFETY: the pool was just made.
        recorder.commands = unsafe { device.raw.allocate_command_buffers(&info) }.call("vkAllocateCommandBuffers")?[0];
        recorder.begin()?;
        Ok(recorder)
    }

    fn begin(&mut self) -> Result<(), GpuError> {
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the command buffer is new, or its pool was reset after it had run.
        unsafe { self.device.raw.begin_command_buffer(self.commands, &begin) }.call("vkBeginCommandBuffer")
    }

    /// Opens a pass: everything before it is finished and visible to it. Commands within one pass are not ordered.
    pub fn pass(&mut self, name: &str) -> Result<Pass<'_>, GpuError> {
        if self.each_pass && !self.passes.is_empty() {
            self.flush()?;
        }
        let (commands, index) = (self.commands, self.passes.len() as u32);
        self.queries.reserve(commands, index)?;
        self.barrier(
            vk::PipelineStageFlags::ALL_COMMANDS,
            vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE,
        );
        if let (Some(labels), Ok(text)) = (&self.device.labels, std::ffi::CString::new(name)) {
            let label = vk::DebugUtilsLabelEXT::default().label_name(&text);
            // SAFETY: the command buffer is being recorded; the label is copied.
            unsafe { labels.cmd_begin_debug_utils_label(commands, &label) };
        }
        self.passes.push(name.to_string());
        // At the bottom: after the barrier, so that a pass is not billed for the one before.
        self.queries.write(commands, 2 * index, vk::PipelineStageFlags::BOTTOM_OF_PIPE);
        Ok(Pass { recorder: self, index })
    }

    fn barrier(&self, stage: vk::PipelineStageFlags, access: vk::AccessFlags) {
        let barrier =
            vk::MemoryBarrier::default().src_access_mask(vk::AccessFlags::MEMORY_WRITE).dst_access_mask(access);
        // SAFETY: a global memory barrier outside of rendering.
        unsafe {
            self.device.raw.cmd_pipeline_barrier(
                self.commands,
                vk::PipelineStageFlags::ALL_COMMANDS,
                stage,
                vk::DependencyFlags::empty(),
                &[barrier],
                &[],
                &[],
            );
        }
    }

    /// Runs what was recorded and waits for it. The times are in the order of the passes.
    pub fn submit(mut self) -> Result<Vec<PassTime>, GpuError> {
        let (started, mark) = (Instant::now(), spans::mark());
        self.execute()?;
        let mut times = std::mem::take(&mut self.times);
        times.extend(self.read_times(started, mark)?);
        Ok(times)
    }

    /// Runs the one pass recorded so far and starts over.
    fn flush(&mut self) -> Result<(), GpuError> {
        let (started, mark) = (Instant::now(), spans::mark());
        self.execute()?;
        let times = self.read_times(started, mark)?;
        self.times.extend(times);
        self.passes.clear();
        self.held.clear();
        self.descriptors = DescriptorPools::new(&self.device);
        // SAFETY: the pool's only command buffer has run.
        unsafe { self.device.raw.reset_command_pool(self.command_pool, vk::CommandPoolResetFlags::empty()) }
            .call("vkResetCommandPool")?;
        self.begin()
    }

    fn execute(&mut self) -> Result<(), GpuError> {
        let _span = spans::span_of("submit and wait", || self.describe());
        self.barrier(vk::PipelineStageFlags::HOST, vk::AccessFlags::HOST_READ);
        let raw = self.device.raw.clone();
        // SAFETY: the command buffer is complete, and everything it uses is held by `self.held`.
        unsafe { raw.end_command_buffer(self.commands) }.call("vkEndCommandBuffer")?;
        // SAFETY: no preconditions.
        let fence = unsafe { raw.create_fence(&vk::FenceCreateInfo::default(), None) }.call("vkCreateFence")?;
        let done = self.run(fence);
        if matches!(done, Err(GpuError::Timeout { .. })) {
            self.leak();
            return done;
        }
        // SAFETY: the fence has been signalled, was never submitted, or its device is lost.
        unsafe { raw.destroy_fence(fence, None) };
        done
    }

    /// Gives up what a submission that did not end may still use: leaking it is the only safe way.
    fn leak(&mut self) {
        std::mem::forget(std::mem::take(&mut self.held));
        std::mem::forget(std::mem::replace(&mut self.descriptors, DescriptorPools::new(&self.device)));
        self.queries.leak();
        self.command_pool = vk::CommandPool::null();
        std::mem::forget(self.device.clone());
    }

    fn run(&self, fence: vk::Fence) -> Result<(), GpuError> {
        let commands = [self.commands];
        let submits = [vk::SubmitInfo::default().command_buffers(&commands)];
        let started = Instant::now();
        {
            let queue = self.device.queue.lock().map_err(|_| self.lost())?;
            // SAFETY: the queue is locked for the call, as Vulkan asks.
            unsafe { self.device.raw.queue_submit(*queue, &submits, fence) }.map_err(|e| self.failure(e))?;
        }
        let patience = self.device.patience();
        // SAFETY: the fence belongs to the submission above.
        unsafe { self.device.raw.wait_for_fences(&[fence], true, patience.as_nanos() as u64) }.map_err(|e| match e {
            vk::Result::TIMEOUT => GpuError::Timeout {
                device: self.device.info.name.clone(),
                pass: self.describe(),
                seconds: started.elapsed().as_secs(),
            },
            other => self.failure(other),
        })
    }

    fn failure(&self, result: vk::Result) -> GpuError {
        match result {
            vk::Result::ERROR_DEVICE_LOST => self.lost(),
            vk::Result::ERROR_OUT_OF_DEVICE_MEMORY | vk::Result::ERROR_OUT_OF_HOST_MEMORY => GpuError::OutOfMemory {
                device: self.device.info.name.clone(),
                what: self.describe(),
                bytes: 0,
                held: self.device.held_memory(),
            },
            result => GpuError::Vulkan { call: "vkQueueSubmit", result },
        }
    }

    fn lost(&self) -> GpuError {
        GpuError::DeviceLost { device: self.device.info.name.clone(), pass: self.describe() }
    }

    fn describe(&self) -> String {
        match self.passes.as_slice() {
            [] => "no pass".to_string(),
            [one] => one.clone(),
            [first, .., last] => format!("{first} to {last}"),
        }
    }

    /// `mark`: when the submission was made, where spans are kept.
    fn read_times(&self, started: Instant, mark: Option<Mark>) -> Result<Vec<PassTime>, GpuError> {
        if self.each_pass {
            let elapsed = started.elapsed().as_secs_f64() * 1e3;
            let milliseconds = self.device.has(Capability::Timestamps).then_some(elapsed);
            if let (Some(mark), Some(milliseconds), [name]) = (mark, milliseconds, self.passes.as_slice()) {
                spans::pass_alone(name, mark, milliseconds);
            }
            return Ok(self.passes.iter().map(|name| PassTime { name: name.clone(), milliseconds }).collect());
        }
        let ticks = self.queries.read(self.passes.len())?;
        let period = f64::from(self.device.info.limits.timestamp_period) * 1e-6;
        let time = |index: usize| {
            let (start, end) = (ticks.get(2 * index)?, ticks.get(2 * index + 1)?);
            Some(end.saturating_sub(*start) as f64 * period)
        };
        let times: Vec<PassTime> = (self.passes.iter().enumerate())
            .map(|(i, name)| PassTime { name: name.clone(), milliseconds: time(i) })
            .collect();
        if let (Some(mark), Some(&first)) = (mark, ticks.first()) {
            let begin = |i: usize| Some(ticks.get(2 * i)?.saturating_sub(first) as f64 * period);
            let timed = times.iter().enumerate();
            spans::passes(mark, timed.filter_map(|(i, pass)| Some((pass.name.clone(), begin(i)?, pass.milliseconds?))));
        }
        Ok(times)
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        // SAFETY: the commands have run or were never submitted; what may still run was given up by `leak`, and destroying
        // a null pool does nothing.
        unsafe { self.device.raw.destroy_command_pool(self.command_pool, None) };
    }
}

/// How many workgroups run.
#[derive(Clone, Copy)]
pub enum Groups<'a> {
    Count(u32),
    /// Three u32 counts at that byte of a buffer.
    From(&'a Buffer, u64),
}

impl Groups<'_> {
    /// As many as `count` invocations take.
    pub fn of(kernel: &Kernel, count: u32) -> Self {
        Groups::Count(groups_of(kernel, count))
    }

    /// Along x and y, at least one, for kernels that find their index by `linear_index()`.
    pub fn folded(kernel: &Kernel, count: u32) -> [u32; 2] {
        fold(groups_of(kernel, count).max(1))
    }
}

fn groups_of(kernel: &Kernel, count: u32) -> u32 {
    count.div_ceil(kernel.interface.workgroup.iter().product::<u32>().max(1))
}

/// Along x and y.
fn fold(groups: u32) -> [u32; 2] {
    let x = groups.min(MAX_GROUPS_X);
    [x, groups.div_ceil(x.max(1))]
}

/// An open pass. It closes when dropped.
pub struct Pass<'a> {
    recorder: &'a mut Recorder,
    index: u32,
}

impl Pass<'_> {
    /// Runs `kernel` for at least `count` invocations. The kernel finds its index by `linear_index()`.
    pub fn dispatch(
        &mut self,
        kernel: &Kernel,
        bindings: &[&Bindings],
        push: &impl bytemuck::NoUninit,
        count: u32,
    ) -> Result<&mut Self, GpuError> {
        let groups = Groups::of(kernel, count);
        if matches!(groups, Groups::Count(0)) {
            return Ok(self);
        }
        self.start(kernel, bindings, bytemuck::bytes_of(push), &groups)?;
        Ok(self)
    }

    /// Runs `kernel` with the three u32 group counts at `offset` (bytes) of `arguments`.
    pub fn dispatch_indirect(
        &mut self,
        kernel: &Kernel,
        bindings: &[&Bindings],
        push: &impl bytemuck::NoUninit,
        arguments: &Buffer,
        offset: u64,
    ) -> Result<&mut Self, GpuError> {
        self.start(kernel, bindings, bytemuck::bytes_of(push), &Groups::From(arguments, offset))?;
        Ok(self)
    }

    /// Runs `kernel` once for each of `pushes`; each run sees what those before it wrote. Bound once: sets made anew for each of
    /// hundreds of runs would cost more than the runs.
    pub fn dispatch_in_turn<P: bytemuck::NoUninit>(
        &mut self,
        kernel: &Kernel,
        bindings: &[&Bindings],
        pushes: impl IntoIterator<Item = P>,
        groups: Groups<'_>,
    ) -> Result<&mut Self, GpuError> {
        let mut pushes = pushes.into_iter();
        let Some(first) = pushes.next() else { return Ok(self) };
        self.start(kernel, bindings, bytemuck::bytes_of(&first), &groups)?;
        for push in pushes {
            let stage = vk::PipelineStageFlags::COMPUTE_SHADER;
            self.recorder.barrier(stage, vk::AccessFlags::SHADER_READ | vk::AccessFlags::SHADER_WRITE);
            let (layout, bytes) = (&kernel.layout, bytemuck::bytes_of(&push));
            // SAFETY: push constants of the type that `bind` checked, for the pipeline that is bound.
            unsafe {
                let (raw, commands) = (&self.recorder.device.raw, self.recorder.commands);
                raw.cmd_push_constants(commands, layout.raw, layout.stages, 0, bytes);
            }
            self.run(&groups);
        }
        Ok(self)
    }

    /// Binds what `kernel` wants and runs it.
    fn start(
        &mut self,
        kernel: &Kernel,
        bindings: &[&Bindings],
        push: &[u8],
        groups: &Groups<'_>,
    ) -> Result<(), GpuError> {
        self.hold_groups(kernel, groups)?;
        self.bind(kernel, bindings, push)?;
        self.run(groups);
        Ok(())
    }

    /// Runs what is bound.
    fn run(&self, groups: &Groups<'_>) {
        let (raw, commands) = (&self.recorder.device.raw, self.recorder.commands);
        match *groups {
            // SAFETY: the pipeline and its descriptors are bound.
            Groups::Count(count) => unsafe {
                let [x, y] = fold(count);
                raw.cmd_dispatch(commands, x, y, 1);
            },
            // SAFETY: as above; the buffer was made for indirect use, and is held.
            Groups::From(arguments, offset) => unsafe {
                raw.cmd_dispatch_indirect(commands, arguments.raw, offset);
            },
        }
    }

    /// Holds counts that lie in a buffer, and refuses them where they do not.
    fn hold_groups(&mut self, kernel: &Kernel, groups: &Groups<'_>) -> Result<(), GpuError> {
        if let Groups::From(arguments, offset) = *groups {
            if offset + 12 > arguments.size() || !offset.is_multiple_of(4) {
                return Err(GpuError::Kernel {
                    kernel: kernel.name.clone(),
                    reason: format!("its group counts at byte {offset} are not inside {}", arguments.name()),
                });
            }
            self.hold(arguments);
        }
        Ok(())
    }

    /// Sets every u32 of the buffer.
    pub fn fill(&mut self, buffer: &Buffer, value: u32) -> &mut Self {
        self.hold(buffer);
        // SAFETY: the buffer was made for transfers; its size is a multiple of four.
        unsafe {
            self.recorder.device.raw.cmd_fill_buffer(self.recorder.commands, buffer.raw, 0, vk::WHOLE_SIZE, value);
        }
        self
    }

    /// Copies `bytes` between two buffers.
    pub(crate) fn copy(
        &mut self,
        from: &Buffer,
        from_offset: u64,
        to: &Buffer,
        to_offset: u64,
        bytes: u64,
    ) -> &mut Self {
        self.hold(from);
        self.hold(to);
        let region = vk::BufferCopy { src_offset: from_offset, dst_offset: to_offset, size: bytes };
        // SAFETY: both were made for transfers; callers keep the range inside both.
        unsafe { self.recorder.device.raw.cmd_copy_buffer(self.recorder.commands, from.raw, to.raw, &[region]) };
        self
    }

    pub(crate) fn device(&self) -> &Device {
        &self.recorder.device
    }

    pub(crate) fn commands(&self) -> vk::CommandBuffer {
        self.recorder.commands
    }

    /// Keeps something alive until the commands have run.
    pub(crate) fn hold<T: Clone + 'static>(&mut self, what: &T) {
        self.recorder.held.push(Arc::new(what.clone()));
    }

    pub(crate) fn descriptors(&mut self) -> &mut DescriptorPools {
        &mut self.recorder.descriptors
    }

    fn bind(&mut self, kernel: &Kernel, bindings: &[&Bindings], push: &[u8]) -> Result<(), GpuError> {
        let sets = self.recorder.descriptors.sets(&kernel.name, &kernel.layout, bindings, push.len())?;
        let (raw, commands) = (&self.recorder.device.raw, self.recorder.commands);
        let point = vk::PipelineBindPoint::COMPUTE;
        let pipeline = kernel.pipeline.get();
        // SAFETY: sets and push constants were checked against the layout the pipeline was made with.
        unsafe {
            raw.cmd_bind_pipeline(commands, point, pipeline.raw);
            if !sets.is_empty() {
                raw.cmd_bind_descriptor_sets(commands, point, pipeline.layout.raw, 0, &sets, &[]);
            }
            if !push.is_empty() {
                raw.cmd_push_constants(commands, pipeline.layout.raw, pipeline.layout.stages, 0, push);
            }
        }
        self.hold(&pipeline);
        bindings.iter().for_each(|b| self.hold(*b));
        Ok(())
    }
}

impl Drop for Pass<'_> {
    fn drop(&mut self) {
        self.recorder.queries.write(self.recorder.commands, 2 * self.index + 1, vk::PipelineStageFlags::BOTTOM_OF_PIPE);
        if let Some(labels) = &self.recorder.device.labels {
            // SAFETY: closes the label that the pass opened.
            unsafe { labels.cmd_end_debug_utils_label(self.recorder.commands) };
        }
    }
}
