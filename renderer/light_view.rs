//! What lights see of the scene: for each light frusta or boxes round the specular objects, and over each a lattice of
//! texels in two layers, what is specular and what is not. Techniques start their light from there.

mod ids;
#[cfg(test)]
mod tests;
mod views;

use crate::gpu::{Bindings, Buffer, Device, GpuError, GpuStruct, Kernel, Layout, Recorder};
use crate::scene::Scene;
use crate::trace::Tracer;

pub(crate) use ids::IdRaster;
pub use views::light_views;

crate::gpu_struct! {
    /// One frustum (point and spot lights) or box (directional ones) of a light. Its chart's coordinates u and v run along
    /// `right` and `up`; (u, v) stands for the direction forward + u right + v up, or, in a box, for the ray along
    /// `forward` from origin + u right + v up, u and v in metres.
    ///
    /// Texel (i, j) lies at lower + (upper - lower) (i / (columns - 1), j / (rows - 1)), of layer l at index
    /// first_texel + (l rows + j) columns + i: layer 0 is what is specular, 1 what is opaque.
    pub struct LightView {
        /// The light's position; of a directional light, a point upstream of the scene.
        pub origin: [f32; 3],
        /// Index into [`Scene::lights`].
        pub light: u32,
        /// Unit, as are `up` and `forward`; right x up = forward.
        pub right: [f32; 3],
        pub columns: u32,
        pub up: [f32; 3],
        pub rows: u32,
        pub forward: [f32; 3],
        pub first_texel: u32,
        /// The part of the chart that specular objects fill.
        pub lower: [f32; 2],
        pub upper: [f32; 2],
        /// 1: a frustum; 0: a box.
        pub perspective: u32,
        /// Metres: nothing of the scene is farther from the light, or in a box from the plane through `origin`.
        pub reach: f32,
        pub padding0: u32,
        pub padding1: u32,
    }
}

crate::gpu_struct! {
    /// What the ray through a point of the lattice meets first in its layer; see `kernels/shared/light_view.glsl`.
    pub struct LightTexel {
        pub position: [f32; 3],
        pub depth: f32,
        pub normal: u32,
        pub geometric: u32,
        pub material: u32,
        pub instance: u32,
        pub barycentrics: [f32; 2],
        pub primitive: u32,
        pub padding0: u32,
    }
}

crate::gpu_struct! {
    /// Push constants of light/visibility and light/resolve.
    pub struct LightViewPush {
        pub view: u32,
        pub instance: u32,
        pub rastered: u32,
        pub padding0: u32,
    }
}

pub const LAYOUTS: &[Layout] = &[LightView::LAYOUT, LightTexel::LAYOUT, LightViewPush::LAYOUT];

/// What is specular, and what is not.
pub const LAYERS: usize = 2;

/// How the texels are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LightViewTier {
    /// Triangles are drawn, and rays decide at their edges: needs [`Capability::PreciseRaster`], and a resolution that the
    /// device can draw.
    Raster,
    /// Every texel is a ray.
    Rays,
    /// `Raster` where it is possible.
    #[default]
    Auto,
}

/// The views of a scene's lights and their texels on the device.
pub struct LightViews {
    views: Vec<LightView>,
    resolution: u32,
    bindings: Bindings,
    texels: Buffer,
    /// Of one view, both layers.
    raster: Option<IdRaster>,
    /// Each instance's number and vertices to draw, of what is specular and of what is not.
    draws: [Vec<(u32, u32)>; LAYERS],
    resolve: Kernel,
}

impl LightViews {
    /// The lights' views of `scene`, each with `resolution` x `resolution` (at least 2) texels a layer.
    ///
    /// # Errors
    /// [`GpuError::Unsuitable`] where `tier` asks for a raster that the device cannot do, and those of memory.
    pub fn new(
        device: &Device,
        scene: &Scene,
        tracer: &Tracer,
        resolution: u32,
        tier: LightViewTier,
    ) -> Result<Self, GpuError> {
        let resolution = resolution.max(2);
        let possible = IdRaster::is_possible(device, resolution, resolution);
        if tier == LightViewTier::Raster && !possible {
            return Err(GpuError::Unsuitable {
                device: device.info.name.clone(),
                reason: format!("it cannot draw what lights see at {resolution} x {resolution} texels precisely"),
            });
        }
        let draw = || IdRaster::new(device, "light visibility", resolution, resolution, LAYERS as u64);
        let raster = match tier {
            LightViewTier::Rays => None,
            _ => possible.then(draw).transpose()?,
        };
        let mut made = LightViews {
            views: Vec::new(),
            resolution,
            bindings: Bindings::new(),
            texels: Buffer::new(device, "light texels", 0)?,
            raster,
            draws: draws(scene),
            resolve: Kernel::new(device, "light/resolve", tracer.variant())?,
        };
        made.restart(device, scene)?;
        Ok(made)
    }

    /// Looks again at a scene whose objects or lights have moved; they are as many as they were. The texels are found by the
    /// next [`record`](Self::record).
    pub fn restart(&mut self, device: &Device, scene: &Scene) -> Result<(), GpuError> {
        self.views = light_views(scene, self.resolution);
        let bytes = (self.texels_of_a_view() * self.views.len() * size_of::<LightTexel>()) as u64;
        if self.texels.size() < bytes {
            self.texels = Buffer::new(device, "light texels", bytes)?;
        }
        let ids = self.raster.as_ref().map(|raster| raster.ids.clone());
        self.bindings = Bindings::new()
            .buffer("LightViews", &Buffer::from_slice(device, "light views", &self.views)?)
            .buffer("LightTexels", &self.texels)
            .buffer("LightIds", &ids.map_or_else(|| Buffer::new(device, "no light ids", 0), Ok)?);
        Ok(())
    }

    /// Of both layers.
    fn texels_of_a_view(&self) -> usize {
        LAYERS * self.resolution.pow(2) as usize
    }

    /// By light. One that reaches nothing specular has none.
    pub fn views(&self) -> &[LightView] {
        &self.views
    }

    /// The blocks `LightViews` and `LightTexels`.
    pub fn bindings(&self) -> &Bindings {
        &self.bindings
    }

    /// What the texels are found by.
    pub fn tier(&self) -> &'static str {
        if self.raster.is_some() { "raster light views" } else { "ray-cast light views" }
    }

    /// Records how the texels are found; `bindings` has the scene and the tracer.
    pub fn record(&self, recorder: &mut Recorder, bindings: &Bindings) -> Result<(), GpuError> {
        let all = [bindings, &self.bindings];
        for index in 0..self.views.len() as u32 {
            let rastered = u32::from(self.raster.is_some());
            let push = LightViewPush { view: index, instance: 0, rastered, padding0: 0 };
            if let Some(raster) = &self.raster {
                for (layer, draws) in (0u64..).zip(&self.draws) {
                    raster.record(recorder, "light", &all, (index, layer), draws)?;
                }
            }
            let name = if self.raster.is_some() { "light/resolve" } else { "light/cast" };
            recorder.pass(name)?.dispatch(&self.resolve, &all, &push, self.texels_of_a_view() as u32)?;
        }
        Ok(())
    }

    /// The texels, for tests and pictures of them: those of all views, as [`LightView`] tells.
    pub fn read(&self) -> Result<Vec<LightTexel>, GpuError> {
        self.texels.read(self.texels_of_a_view() * self.views.len())
    }
}

/// Each instance's number and vertices to draw, of what is specular and of what is not.
pub(crate) fn draws(scene: &Scene) -> [Vec<(u32, u32)>; LAYERS] {
    [true, false].map(|specular| {
        let instances = (0u32..).zip(&scene.instances);
        let wanted = instances.filter(|(_, i)| scene.materials[i.material].surface.is_specular() == specular);
        wanted.map(|(index, i)| (index, 3 * scene.meshes[i.mesh].triangles.len() as u32)).collect()
    })
}
