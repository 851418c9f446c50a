//! The image spaces: what lights see of what is specular and opaque and the camera of what is opaque, as ids and pyramids
//! of depths.

use glam::Vec3;

use super::StorePush;
use crate::gpu::{Bindings, Buffer, GpuError, Kernel, Recorder};
use crate::light_view::{IdRaster, LightView, draws, light_views};
use crate::scene::Scene;
use crate::technique::Context;
use crate::view::View;

crate::gpu_struct! {
    /// What a camera's texel shows; see `kernels/technique/photons/store.glsl`.
    pub struct CameraTexel {
        pub depth: f32,
        pub shading: u32,
        pub geometric: u32,
        pub instance: u32,
    }
}

crate::gpu_struct! {
    pub struct SeePush {
        pub view: u32,
        pub layer: u32,
        pub rastered: u32,
        pub thickness: f32,
    }
}

crate::gpu_struct! {
    pub struct PyramidPush {
        pub view: u32,
        pub level: u32,
        pub padding0: u32,
        pub padding1: u32,
    }
}

crate::gpu_struct! {
    pub struct CameraPush {
        pub camera: u32,
        pub padding0: u32,
        pub padding1: u32,
        pub padding2: u32,
    }
}

crate::gpu_struct! {
    pub struct CoveragePush {
        pub store: StorePush,
        pub places: u32,
        pub padding0: u32,
    }
}

/// Rays by which a texel at an edge is shared out among what it shows.
const PLACES: u32 = 16;
/// Levels that a pyramid can have.
const LEVELS: usize = 16;
const SPECULAR: u32 = 0;
const OPAQUE: u32 = 1;
/// Bytes of a texel's and its pyramid's slabs, rounded up: four thirds of eight.
const SLAB_BYTES: u64 = 11;
/// Bytes of the camera's texel where they are most.
const CAMERA_BYTES: u64 = 16;

/// The views, their texels and what finds them.
pub struct Spaces {
    /// Those of lights, then the camera's.
    pub views: Vec<LightView>,
    pub bindings: Bindings,
    /// The block `CameraTexels`.
    pub texels: Buffer,
    lights: Option<IdRaster>,
    camera: Option<IdRaster>,
    /// Bound where rays find everything.
    no_ids: Buffer,
    draws: [Vec<(u32, u32)>; 2],
    see: Kernel,
    pyramid: Kernel,
    show: Kernel,
    coverage: Kernel,
    areas: Buffer,
    thickness: f32,
}

/// None where the device cannot draw them.
fn raster(context: &Context<'_>, name: &str, view: &LightView) -> Result<Option<IdRaster>, GpuError> {
    let (device, columns, rows) = (context.device, view.columns, view.rows);
    let possible = IdRaster::is_possible(device, columns, rows);
    possible.then(|| IdRaster::new(device, name, columns, rows, 1)).transpose()
}

/// What the camera sees straight ahead, `margin` of the picture's longer side beyond each border, with as many texels as
/// pixels or, where there would be more than `most`, each for several.
fn camera_view(view: &View, margin: f32, most: u64) -> LightView {
    let [right, up, forward] = [view.right, view.up, view.forward].map(Vec3::from_array);
    let (half_width, half_height) = (right.length(), up.length());
    let border = (margin * view.width.max(view.height) as f32).ceil() as u32;
    let (columns, rows) = (view.width + 2 * border, view.height + 2 * border);
    let pixels_per_texel =
        (1u32..).find(|n| u64::from(columns.div_ceil(*n)) * u64::from(rows.div_ceil(*n)) <= most.max(4)).unwrap_or(1);
    let (columns, rows) = (columns.div_ceil(pixels_per_texel).max(2), rows.div_ceil(pixels_per_texel).max(2));
    // Of the first texel's middle, in pixels from the picture's corner.
    let first = 0.5 * pixels_per_texel as f32 - border as f32;
    let at = |pixels: f32, size: u32, half: f32| (2.0 * pixels / size as f32 - 1.0) * half;
    let last = |count: u32| first + ((count - 1) * pixels_per_texel) as f32;
    LightView {
        origin: view.position,
        light: 0,
        right: (right / half_width).to_array(),
        columns,
        // Rows run down, as the picture's do.
        up: (-up / half_height).to_array(),
        rows,
        forward: forward.to_array(),
        first_texel: 0,
        lower: [at(first, view.width, half_width), at(first, view.height, half_height)],
        upper: [at(last(columns), view.width, half_width), at(last(rows), view.height, half_height)],
        perspective: 1,
        reach: f32::MAX,
        padding0: 0,
        padding1: 0,
    }
}

/// The views of the lights at `resolution`, or at less where their texels would not fit beside the camera's, and the
/// camera's own.
fn views_of(scene: &Scene, camera: &View, options: &SpaceOptions, storage: u64) -> Vec<LightView> {
    let camera = camera_view(camera, options.margin, storage / 2 / CAMERA_BYTES);
    let camera_texels = u64::from(camera.columns) * u64::from(camera.rows);
    let mut views = light_views(scene, options.resolution);
    let room = (storage / SLAB_BYTES).saturating_sub(camera_texels) / (views.len() as u64).max(1);
    let side = options.resolution.min(room.isqrt() as u32).max(2);
    if side < options.resolution {
        views = light_views(scene, side);
    }
    views.push(camera);
    let mut first_texel = 0;
    for view in &mut views {
        view.first_texel = first_texel;
        first_texel += view.columns * view.rows;
    }
    views
}

/// First slab of each level of each view, and how many there are.
fn levels_of(views: &[LightView]) -> (Vec<u32>, u64) {
    let mut offsets = Vec::with_capacity(views.len() * LEVELS);
    let mut next = 0u64;
    for view in views {
        for level in 0..LEVELS as u32 {
            offsets.push(next as u32);
            if level <= top(view) {
                next += u64::from(view.columns.div_ceil(1 << level)) * u64::from(view.rows.div_ceil(1 << level));
            }
        }
    }
    (offsets, next)
}

/// The pyramid's last level, of one node.
fn top(view: &LightView) -> u32 {
    (view.columns.max(view.rows).max(2) - 1).ilog2() + 1
}

/// What [`Spaces`] are made by.
pub struct SpaceOptions {
    pub resolution: u32,
    /// Of the picture's longer side.
    pub margin: f32,
    /// m; 0: by the width of texels.
    pub thickness: f32,
}

impl Spaces {
    pub fn new(options: &SpaceOptions, context: &Context<'_>) -> Result<Self, GpuError> {
        let device = context.device;
        let storage = device.info.limits.storage_range;
        let views = views_of(context.scene, context.frame.view(), options, storage);
        let texels = |views: &[LightView]| views.iter().map(|v| u64::from(v.columns) * u64::from(v.rows)).sum::<u64>();
        let (lights, camera) = views.split_at(views.len() - 1);
        let (levels, slabs) = levels_of(&views);
        // All lights' views are of one size.
        let light_raster = lights.first().map(|view| raster(context, "photons light ids", view)).transpose()?;
        let camera_raster = raster(context, "photons camera ids", &camera[0])?;
        let variant = context.tracer.variant();
        let camera_texels = Buffer::new(device, "photons camera texels", CAMERA_BYTES * texels(camera))?;
        let areas = Buffer::new(device, "photons camera areas", 4 * texels(camera))?;
        let bindings = Bindings::new()
            .buffer("LightViews", &Buffer::from_slice(device, "photons views", &views)?)
            .buffer("OpaqueIds", &Buffer::new(device, "photons opaque ids", 8 * texels(&views))?)
            .buffer("SpecularIds", &Buffer::new(device, "photons specular ids", 8 * texels(lights))?)
            .buffer("DepthSlabs", &Buffer::new(device, "photons depth slabs", 8 * slabs)?)
            .buffer("DepthLevels", &Buffer::from_slice(device, "photons depth levels", &levels)?)
            .buffer("CameraTexels", &camera_texels)
            .buffer("CameraAreas", &areas);
        Ok(Spaces {
            bindings,
            texels: camera_texels,
            lights: light_raster.flatten(),
            camera: camera_raster,
            no_ids: Buffer::new(device, "photons no ids", 0)?,
            draws: draws(context.scene),
            see: Kernel::new(device, "photons/see", variant)?,
            pyramid: Kernel::new(device, "photons/pyramid", "")?,
            show: Kernel::new(device, "photons/camera", "")?,
            coverage: Kernel::new(device, "photons/coverage", variant)?,
            areas,
            thickness: options.thickness,
            views,
        })
    }

    /// Index of the camera's view.
    pub fn camera(&self) -> u32 {
        self.views.len() as u32 - 1
    }

    /// Texels of the camera's view.
    pub fn camera_texels(&self) -> u32 {
        self.views.last().map_or(0, |view| view.columns * view.rows)
    }

    /// Records how the texels of all views are found; `scene` has the scene and the tracer.
    pub fn record(&self, recorder: &mut Recorder, scene: &Bindings, store: StorePush) -> Result<(), GpuError> {
        for index in 0..self.camera() {
            self.record_layer(recorder, scene, index, SPECULAR)?;
            self.record_layer(recorder, scene, index, OPAQUE)?;
        }
        self.record_layer(recorder, scene, self.camera(), OPAQUE)?;
        let bindings = [scene, &self.bindings];
        let push = CameraPush { camera: self.camera(), padding0: 0, padding1: 0, padding2: 0 };
        recorder.pass("photons/camera")?.dispatch(&self.show, &bindings, &push, self.camera_texels())?;
        recorder.pass("photons/clear-areas")?.fill(&self.areas, 0);
        let push = CoveragePush { store, places: PLACES, padding0: 0 };
        recorder.pass("photons/coverage")?.dispatch(&self.coverage, &bindings, &push, self.camera_texels())?;
        let deepest = self.views.iter().map(top).max().unwrap_or(0);
        // The same level of all views at once: they do not touch each other.
        for level in 1..=deepest {
            let mut pass = recorder.pass("photons/pyramid")?;
            for (index, view) in (0u32..).zip(&self.views).filter(|(_, view)| level <= top(view)) {
                let nodes = view.columns.div_ceil(1 << level) * view.rows.div_ceil(1 << level);
                let push = PyramidPush { view: index, level, padding0: 0, padding1: 0 };
                pass.dispatch(&self.pyramid, &bindings, &push, nodes)?;
            }
        }
        Ok(())
    }

    fn record_layer(&self, recorder: &mut Recorder, scene: &Bindings, index: u32, layer: u32) -> Result<(), GpuError> {
        let view = &self.views[index as usize];
        let raster = if index == self.camera() { &self.camera } else { &self.lights };
        if let Some(raster) = raster {
            let draws = &self.draws[layer as usize];
            raster.record(recorder, "photons", &[scene, &self.bindings], (index, 0), draws)?;
        }
        let ids = raster.as_ref().map_or(&self.no_ids, |raster| &raster.ids);
        let bindings = self.bindings.clone().buffer("LightIds", ids);
        let rastered = u32::from(raster.is_some());
        let push = SeePush { view: index, layer, rastered, thickness: self.thickness };
        recorder.pass("photons/see")?.dispatch(&self.see, &[scene, &bindings], &push, view.columns * view.rows)?;
        Ok(())
    }
}
