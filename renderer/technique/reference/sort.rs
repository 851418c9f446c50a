//! Photons, sorted by the cells of a hashed grid, so that who looks for those near a place finds them.

use super::records::{GridPush, Photon, ScanPush};
use crate::gpu::{Bindings, Buffer, Device, GpuError, Kernel, Recorder};

/// Grid buckets, the largest number that two levels of 1024-wide scans reach with room for the end.
const MAX_BUCKETS: u32 = 1 << 19;
/// Numbers that one workgroup scans.
const SCAN_BLOCK: u32 = 1024;

#[derive(Clone)]
pub struct SortKernels {
    count: Kernel,
    scan_blocks: Kernel,
    scan_sums: Kernel,
    scan_add: Kernel,
    scatter: Kernel,
}

impl SortKernels {
    pub fn new(device: &Device) -> Result<Self, GpuError> {
        let kernel = |name: &str| Kernel::new(device, &format!("reference/{name}"), "");
        Ok(SortKernels {
            count: kernel("count")?,
            scan_blocks: kernel("scan_blocks")?,
            scan_sums: kernel("scan_sums")?,
            scan_add: kernel("scan_add")?,
            scatter: kernel("scatter")?,
        })
    }
}

/// The photons of one set, a slot each, and their grid.
pub struct Sorted {
    /// `PhotonGrid`, `Photons`, `SortedPhotons` and `BucketStarts`, for those who gather too.
    pub bindings: Bindings,
    pub photons: Buffer,
    /// The block `PhotonGrid`, one number: what the cells' size goes by.
    pub grid: Buffer,
    pub slots: u32,
    pub buckets: u32,
    bucket_starts: Buffer,
    kernels: SortKernels,
    /// What labels of passes begin with.
    label: &'static str,
}

impl Sorted {
    /// Fails where the device has no room for so many photons.
    pub fn new(device: &Device, kernels: &SortKernels, label: &'static str, slots: u32) -> Result<Self, GpuError> {
        let buckets = slots.next_power_of_two().clamp(SCAN_BLOCK, MAX_BUCKETS);
        let bytes = u64::from(slots) * size_of::<Photon>() as u64;
        let grid = Buffer::new(device, "reference grid", 16)?;
        let photons = Buffer::new(device, "reference photons", bytes)?;
        let bucket_starts = Buffer::new(device, "reference buckets", u64::from(buckets + SCAN_BLOCK) * 4)?;
        let bindings = Bindings::new()
            .buffer("PhotonGrid", &grid)
            .buffer("Photons", &photons)
            .buffer("BucketStarts", &bucket_starts)
            .buffer("Places", &Buffer::new(device, "reference places", u64::from(slots) * 4)?)
            .buffer("SortedPhotons", &Buffer::new(device, "reference sorted photons", bytes)?)
            .buffer("BlockSums", &Buffer::new(device, "reference block sums", u64::from(SCAN_BLOCK) * 4)?);
        Ok(Sorted { bindings, photons, grid, slots, buckets, bucket_starts, kernels: kernels.clone(), label })
    }

    /// Sorts the photons that are there by then; `GridState` has been set.
    pub fn record(&self, recorder: &mut Recorder) -> Result<(), GpuError> {
        let Sorted { kernels, label, bindings, .. } = self;
        let bindings = [bindings];
        let push = GridPush { slots: self.slots, buckets: self.buckets };
        let padded = self.buckets + SCAN_BLOCK;
        let blocks = padded / SCAN_BLOCK;
        let name = |stage: &str| format!("{label}{stage}");
        recorder.pass(&name("clear"))?.fill(&self.bucket_starts, 0);
        recorder.pass(&name("count"))?.dispatch(&kernels.count, &bindings, &push, self.slots)?;
        // One workgroup of 64 a block of 1024.
        recorder.pass(&name("scan_blocks"))?.dispatch(&kernels.scan_blocks, &bindings, &(), blocks * 64)?;
        recorder.pass(&name("scan_sums"))?.dispatch(&kernels.scan_sums, &bindings, &ScanPush { blocks }, 64)?;
        recorder.pass(&name("scan_add"))?.dispatch(&kernels.scan_add, &bindings, &(), padded)?;
        recorder.pass(&name("scatter"))?.dispatch(&kernels.scatter, &bindings, &push, self.slots)?;
        Ok(())
    }
}
