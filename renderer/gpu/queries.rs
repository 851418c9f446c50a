//! Timestamps at the beginning and the end of passes.

use ash::vk;

use super::error::Call;
use super::{Capability, Device, GpuError};

/// Passes that a pool of queries times. Pools are made as passes need them: with one for 4096 passes, reset as a whole, the
/// validation layers keep books of every query for every submission, which took most of what tests took on SwiftShader.
const PASSES_OF_POOL: u32 = 32;

/// Two queries a pass, of the passes of one command buffer.
pub struct Queries {
    pools: Vec<vk::QueryPool>,
    timed: bool,
    device: Device,
}

impl Queries {
    /// Of passes that are `wanted` timed, where the device has timestamps.
    pub fn new(device: &Device, wanted: bool) -> Self {
        Queries { pools: Vec::new(), timed: wanted && device.has(Capability::Timestamps), device: device.clone() }
    }

    /// Room for the pass of that number, where there are timestamps; all before it have had theirs. Not within rendering.
    pub fn reserve(&mut self, commands: vk::CommandBuffer, pass: u32) -> Result<(), GpuError> {
        if !self.timed || pass / PASSES_OF_POOL < self.pools.len() as u32 {
            return Ok(());
        }
        let count = 2 * PASSES_OF_POOL;
        let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(count);
        // SAFETY: a query pool has no preconditions; it is reset before its first use, outside of rendering.
        unsafe {
            let pool = self.device.raw.create_query_pool(&info, None).call("vkCreateQueryPool")?;
            self.pools.push(pool);
            self.device.raw.cmd_reset_query_pool(commands, pool, 0, count);
        }
        Ok(())
    }

    /// The time at which `stage` is done with all before it, into query 2n at the beginning of pass n and 2n + 1 at its end.
    pub fn write(&self, commands: vk::CommandBuffer, query: u32, stage: vk::PipelineStageFlags) {
        let (pool, query) = (query / (2 * PASSES_OF_POOL), query % (2 * PASSES_OF_POOL));
        if let Some(&pool) = self.pools.get(pool as usize) {
            // SAFETY: the query is in range and was reset.
            unsafe { self.device.raw.cmd_write_timestamp(commands, stage, pool, query) };
        }
    }

    /// Ticks of all queries of so many passes, which have run; none without timestamps.
    pub fn read(&self, passes: usize) -> Result<Vec<u64>, GpuError> {
        let mut ticks = vec![0; if self.pools.is_empty() { 0 } else { 2 * passes }];
        for (ticks, pool) in ticks.chunks_mut(2 * PASSES_OF_POOL as usize).zip(&self.pools) {
            let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
            // SAFETY: every query in the range was written by the commands that have run.
            unsafe { self.device.raw.get_query_pool_results(*pool, 0, ticks, flags) }.call("vkGetQueryPoolResults")?;
        }
        Ok(ticks)
    }

    /// Gives up what a submission that did not end may still write to.
    pub fn leak(&mut self) {
        self.pools.clear();
    }
}

impl Drop for Queries {
    fn drop(&mut self) {
        for pool in &self.pools {
            // SAFETY: the commands that use it have run or were never submitted.
            unsafe { self.device.raw.destroy_query_pool(*pool, None) };
        }
    }
}
