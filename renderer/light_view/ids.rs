//! Which triangles a view shows, drawn.

use super::LightViewPush;
use crate::gpu::{Bindings, Buffer, Capability, Device, GpuError, Raster, RasterTargets, Recorder};

/// Draws ids of views of one size, and keeps those of the last view by layer.
pub(crate) struct IdRaster {
    raster: Raster,
    targets: RasterTargets,
    /// The block `LightIds`: two u32 a texel.
    pub ids: Buffer,
    layers: u64,
}

impl IdRaster {
    /// Whether the device can draw views of that size precisely.
    pub fn is_possible(device: &Device, columns: u32, rows: u32) -> bool {
        device.has(Capability::PreciseRaster) && columns.max(rows) <= device.info.limits.target_side
    }

    pub fn new(device: &Device, name: &str, columns: u32, rows: u32, layers: u64) -> Result<Self, GpuError> {
        let targets = RasterTargets::ids(device, name, columns, rows)?;
        let ids = Buffer::new(device, name, layers * u64::from(columns) * u64::from(rows) * 8)?;
        Ok(IdRaster { raster: Raster::new(device, "light/visibility", &targets)?, targets, ids, layers })
    }

    /// Records passes `<label>/visibility` and `<label>/visibility-copy` that draw `draws`, instances and their vertices,
    /// as view `view` of the block `LightViews` shows them, into the ids' layer `layer`.
    pub fn record(
        &self,
        recorder: &mut Recorder,
        label: &str,
        bindings: &[&Bindings],
        (view, layer): (u32, u64),
        draws: &[(u32, u32)],
    ) -> Result<(), GpuError> {
        let item =
            |&(instance, vertices): &(u32, u32)| (LightViewPush { view, instance, rastered: 1, padding0: 0 }, vertices);
        let items: Vec<_> = draws.iter().map(item).collect();
        recorder.pass(&format!("{label}/visibility"))?.draw(&self.raster, &self.targets, bindings, &items)?;
        let offset = layer * self.ids.size() / self.layers;
        recorder.pass(&format!("{label}/visibility-copy"))?.copy_image(&self.targets.color, &self.ids, offset);
        Ok(())
    }
}
