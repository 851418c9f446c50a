//! From a scene and settings to a picture: the order of things above the frame.

mod checks;
mod error;
mod report;
mod temporal;

use std::time::Instant;

use crate::animate::Animator;
use crate::display::{Display, Look};
use crate::film::{self, FilmRows};
use crate::frame::{Frame, Sampling};
use crate::gpu::{Device, DeviceRequest, GpuError, Recorder};
use crate::gpu_scene::GpuScene;
use crate::image::{LayeredImage, RenderInfo};
use crate::motion::{self, MotionVectors};
use crate::scene::{Camera, Light, Scene};
use crate::spans;
use crate::stats::{self, PassTotal, Stats};
use crate::taa::{History, Taa, TaaSettings};
use crate::technique::{self, Context, Settings, Technique, TechniqueKind};
use crate::trace::{self, TraceChoice, Tracer};
use crate::view::{Band, View};

use checks::{bands, camera};
pub use checks::{check_frame, check_size};
pub use error::RenderError;

/// Pixels along one side of a picture, at most.
pub const MAX_SIDE: u32 = 16384;

/// How a scene is to be rendered; `Default` is what the command line does when told nothing.
#[derive(Debug, Clone, Default)]
pub struct RenderSettings {
    pub device: DeviceRequest,
    pub trace: TraceChoice,
    pub technique: TechniqueKind,
    /// The scene's first camera if `None`.
    pub camera: Option<String>,
    /// Pixels; the scene's film if `None`.
    pub size: Option<(u32, u32)>,
    /// Samples a pixel; the scene's film if `None`.
    pub samples: Option<u32>,
    /// Spend the samples where pixels vary; `samples` is then their mean number.
    pub adaptive: bool,
    pub seed: u32,
    /// Of the scene's animation; see [`crate::scene::Animation::time`].
    pub frame: u32,
    /// Find motion vectors too, a layer of the picture; see [`MotionVectors::find`].
    pub motion: bool,
    /// Make the picture of the samples of several frames.
    pub taa: Option<TaaSettings>,
    /// `technique.key=value`; what the scene sets holds for the rest.
    pub set: Vec<String>,
}

/// How far a render is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Samples of the whole picture.
    pub done: u32,
    pub total: u32,
    /// Estimated relative noise of the caustic light (0.01 = 1 %), now and then.
    pub noise: Option<f32>,
}

/// What a render ends in.
pub struct Picture {
    pub image: LayeredImage,
    pub stats: Stats,
}

/// Renders one picture, sample by sample. A picture too large for the device's buffers is rendered in bands of rows,
/// each of which gets every sample.
pub struct Renderer {
    device: Device,
    scene: Scene,
    gpu_scene: GpuScene,
    animator: Animator,
    frame: u32,
    tracer: Tracer,
    trace_choice: String,
    motion: Option<MotionVectors>,
    taa: Option<Taa>,
    taa_settings: Option<TaaSettings>,
    /// Pictures that were shown, where anti-aliasing keeps those, and the camera of the last.
    shown: u32,
    shown_by: Option<Camera>,
    technique_kind: TechniqueKind,
    settings: Settings,
    /// The one looked through; the scene's own of that name, unless [`set_camera`](Renderer::set_camera) took another.
    camera: Camera,
    own_camera: bool,
    /// Those of [`set_lights`](Renderer::set_lights), in place of the scene's.
    lights: Option<Vec<Light>>,
    /// The scene's, where others are in their place.
    own_lights: Vec<Light>,
    size: (u32, u32),
    samples: u32,
    sampling: Sampling,
    seed: u32,
    bands: Vec<BandState>,
    done: u32,
    passes: Vec<PassTotal>,
    started: Instant,
}

struct BandState {
    rows: Band,
    frame: Frame,
    technique: Option<Box<dyn Technique>>,
}

impl Renderer {
    /// Opens the device, uploads the scene and makes every pipeline.
    pub fn new(scene: Scene, settings: &RenderSettings) -> Result<Self, RenderError> {
        Self::check(&scene, settings)?;
        let span = spans::span("open device");
        let device = Device::open(&settings.device)?;
        drop(span);
        Self::with_device(device, scene, settings)
    }

    /// Fails for settings that no device could render.
    pub(crate) fn check(scene: &Scene, settings: &RenderSettings) -> Result<Settings, RenderError> {
        camera(scene, settings.camera.as_deref())?;
        check_size(settings.size.unwrap_or((scene.film.width, scene.film.height)))?;
        check_frame(scene, settings.frame)?;
        if settings.samples == Some(0) {
            return Err(RenderError::Samples { found: 0 });
        }
        let technique = Settings::of(settings.technique, scene, &settings.set)?;
        if settings.adaptive && !settings.technique.per_sample(&technique) {
            return Err(RenderError::NotAdaptive { technique: settings.technique.name() });
        }
        Ok(technique)
    }

    /// As [`new`](Self::new), on a device that is open; what `settings` say of one is not looked at.
    pub fn with_device(device: Device, scene: Scene, settings: &RenderSettings) -> Result<Self, RenderError> {
        let started = Instant::now();
        let technique_settings = Self::check(&scene, settings)?;
        let size = settings.size.unwrap_or((scene.film.width, scene.film.height));
        let samples = settings.samples.unwrap_or(scene.film.samples);
        let sampling = if settings.adaptive { Sampling::Adaptive { samples } } else { Sampling::Uniform };
        let span = spans::span("upload scene");
        let gpu_scene = GpuScene::new(&device, &scene)?;
        drop(span);
        let mut animator = Animator::new(&device, &scene, &gpu_scene)?;
        // Built at time 0 whatever the frame, so that a frame has the same structures however it is come to.
        let span = spans::span("build tracing structures");
        let (tracer, choice) = trace::choose(&device, &scene, &gpu_scene, settings.trace)?;
        drop(span);
        if settings.motion || settings.taa.is_some() {
            animator.keep_previous(&gpu_scene)?;
        }
        let camera = camera(&scene, settings.camera.as_deref())?.clone();
        let motion = settings.motion.then(|| MotionVectors::new(&device, &tracer)).transpose()?;
        let mut renderer = Renderer {
            device,
            scene,
            gpu_scene,
            animator,
            frame: 0,
            tracer,
            trace_choice: choice.reason,
            motion,
            taa: None,
            taa_settings: settings.taa,
            shown: 0,
            shown_by: None,
            technique_kind: settings.technique,
            settings: technique_settings,
            camera,
            own_camera: true,
            lights: None,
            own_lights: Vec::new(),
            size,
            samples,
            sampling,
            seed: settings.seed,
            bands: Vec::new(),
            done: 0,
            passes: Vec::new(),
            started,
        };
        renderer.move_to(settings.frame)?;
        renderer.make_bands()?;
        Ok(renderer)
    }

    /// Forgets all samples. Pipelines stay, and so do buffers whose size depends on the picture alone.
    pub fn restart(&mut self) -> Result<(), RenderError> {
        self.leave(None)?;
        self.passes.clear();
        self.start_over()
    }

    fn start_over(&mut self) -> Result<(), RenderError> {
        self.begin();
        if self.bands.is_empty() {
            return self.make_bands();
        }
        let views: Vec<View> = self.bands.iter().map(|band| self.view(band.rows)).collect();
        let (seed, jitter) = (self.own_seed(), self.jitter());
        let Self { device, scene, gpu_scene, tracer, bands, .. } = self;
        for (BandState { frame, technique, .. }, view) in bands.iter_mut().zip(&views) {
            frame.restart(device, gpu_scene, tracer, view)?;
            frame.jitter_by(jitter);
            if let Some(technique) = technique {
                let _span = spans::span("restart technique");
                technique.restart(&Context { device, scene, tracer, frame, seed })?;
            }
        }
        Ok(())
    }

    /// Goes to a frame of the scene's animation and forgets all samples.
    pub fn go_to(&mut self, frame: u32) -> Result<(), RenderError> {
        check_frame(&self.scene, frame)?;
        self.leave(Some(frame))?;
        self.passes.clear();
        self.move_to(frame)?;
        self.start_over()
    }

    /// Takes the scene, its copy on the device, the tracing structures and the scene's own camera to a frame.
    fn move_to(&mut self, frame: u32) -> Result<(), RenderError> {
        self.frame = frame;
        if !self.scene.animation.moves() && self.motion.is_none() && self.taa_settings.is_none() {
            return Ok(());
        }
        let span = spans::span("animate");
        let moved = self.animator.go_to(frame, &mut self.scene, &mut self.gpu_scene)?;
        stats::add_times(&mut self.passes, &moved.times);
        drop(span);
        if let Some(lights) = &self.lights {
            self.scene.lights.clone_from(lights);
            self.gpu_scene.follow(&self.scene)?;
        }
        let span = spans::span("refit");
        let times = self.tracer.update(&self.device, &self.scene, &self.gpu_scene, &moved.meshes)?;
        stats::add_times(&mut self.passes, &times);
        self.animator.followed();
        drop(span);
        if self.own_camera {
            self.camera = camera(&self.scene, Some(&self.camera.name))?.clone();
        }
        Ok(())
    }

    /// The frame of the scene's animation that is shown.
    pub fn frame(&self) -> u32 {
        self.frame
    }

    /// Looks through `camera` from now on, at whatever frame, and forgets all samples.
    pub fn set_camera(&mut self, camera: Camera) -> Result<(), RenderError> {
        self.leave(None)?;
        (self.camera, self.own_camera) = (camera, false);
        self.restart()
    }

    /// Looks through the scene's camera of that name from now on, and forgets all samples.
    pub fn look_through(&mut self, name: &str) -> Result<(), RenderError> {
        self.leave(None)?;
        (self.camera, self.own_camera) = (camera(&self.scene, Some(name))?.clone(), true);
        self.restart()
    }

    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Lights the scene by `lights` from now on, at whatever frame, or by its own again, and forgets all samples. They are
    /// as many as the scene's, each of the same kind.
    pub fn set_lights(&mut self, lights: Option<Vec<Light>>) -> Result<(), RenderError> {
        self.leave(None)?;
        if self.lights.is_none() {
            self.own_lights.clone_from(&self.scene.lights);
        }
        self.scene.lights.clone_from(lights.as_ref().unwrap_or(&self.own_lights));
        let back = self.lights.is_some() && lights.is_none();
        self.lights = lights;
        self.gpu_scene.follow(&self.scene)?;
        // Those with keys are where the frame has them, which may be another than when they were left.
        if back { self.go_to(self.frame) } else { self.restart() }
    }

    /// Pixels.
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// Renders pictures of another size from now on, and forgets all samples.
    pub fn set_size(&mut self, size: (u32, u32)) -> Result<(), RenderError> {
        check_size(size)?;
        self.passes.clear();
        let before = std::mem::replace(&mut self.size, size);
        self.make_bands().or_else(|error| {
            self.size = before;
            self.make_bands()?;
            Err(error)
        })
    }

    /// Renders by another technique, or the same with other settings, and forgets all samples.
    pub fn set_technique(&mut self, kind: TechniqueKind, set: &[String]) -> Result<(), RenderError> {
        let settings = Settings::of(kind, &self.scene, set)?;
        if self.sampling != Sampling::Uniform && !kind.per_sample(&settings) {
            return Err(RenderError::NotAdaptive { technique: kind.name() });
        }
        self.passes.clear();
        let before = std::mem::replace(&mut self.settings, settings);
        let kind_before = std::mem::replace(&mut self.technique_kind, kind);
        self.make_bands().or_else(|error| {
            (self.technique_kind, self.settings) = (kind_before, before);
            self.make_bands()?;
            Err(error)
        })
    }

    /// The bands anew, without samples; none where one of them fails.
    fn make_bands(&mut self) -> Result<(), RenderError> {
        let _span = spans::span("make pipelines");
        self.bands.clear();
        self.begin();
        self.taa = None;
        let taa = self.taa_settings.map(|settings| Taa::new(&self.device, &self.tracer, self.size, settings));
        self.taa = taa.transpose()?;
        let bytes = film::largest_bytes_per_pixel(self.scene.scatters());
        let rows = bands(self.size, bytes, self.device.info.limits.storage_range);
        self.bands = rows.into_iter().map(|band| self.band(band)).collect::<Result<_, _>>()?;
        Ok(())
    }

    fn check_bands(&self) -> Result<(), RenderError> {
        if self.bands.is_empty() { Err(RenderError::Unmade) } else { Ok(()) }
    }

    fn view(&self, band: Band) -> View {
        View { seed: self.own_seed(), ..View::new(&self.camera, &self.scene.film, self.size, band).of(&self.scene) }
    }

    fn band(&self, band: Band) -> Result<BandState, RenderError> {
        let view = self.view(band);
        let mut frame = Frame::new(&self.device, &self.gpu_scene, &self.tracer, &view, self.sampling)?;
        frame.jitter_by(self.jitter());
        let Self { device, scene, tracer, .. } = self;
        let context = Context { device, scene, tracer, frame: &frame, seed: self.own_seed() };
        let technique = technique::create(self.technique_kind, &self.settings, &context)?;
        Ok(BandState { rows: band, frame, technique })
    }

    /// Samples that were asked for.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    pub fn device(&self) -> &Device {
        &self.device
    }

    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// What the device's capabilities led to: `cwbvh tracing, raster visibility`.
    pub fn tier(&self) -> String {
        let visibility = self.bands.first().map_or("", |band| band.frame.visibility_tier());
        format!("{} tracing, {visibility}", self.tracer.backend.module())
    }

    /// Why the tracing back-end is the one it is.
    pub fn trace_choice(&self) -> &str {
        &self.trace_choice
    }

    /// Renders one more sample of every pixel, and waits for it. With anti-aliasing over numbered frames, the first sample
    /// of a frame renders those before it, too, unless they have just been rendered.
    pub fn sample(&mut self) -> Result<Progress, RenderError> {
        self.check_bands()?;
        if self.done == 0 {
            self.render_frames_before()?;
        }
        self.render_sample()?;
        // Reading the film back costs about as much as a tenth of a sample: asked for at powers of two and at the end.
        let telling = self.done.is_power_of_two() || self.done == self.samples;
        Ok(Progress { done: self.done, total: self.samples, noise: if telling { self.noise()? } else { None } })
    }

    fn render_sample(&mut self) -> Result<(), RenderError> {
        let _span = spans::span_of("sample", || self.done.to_string());
        for band in &mut self.bands {
            let span = spans::span("record");
            let mut recorder = Recorder::new(&self.device)?;
            band.frame.record(&mut recorder, self.done)?;
            if let Some(technique) = &mut band.technique {
                technique.record(&band.frame, &mut recorder, self.done)?;
            }
            drop(span);
            stats::add_times(&mut self.passes, &recorder.submit()?);
        }
        self.done += 1;
        Ok(())
    }

    /// The first band's noise stands for the picture's.
    fn noise(&self) -> Result<Option<f32>, GpuError> {
        let Some(BandState { frame, technique: Some(technique), .. }) = self.bands.first() else { return Ok(None) };
        frame.film.noise(&frame.sample_counts(self.done), |samples| technique.second_half(samples))
    }

    /// The picture of the samples so far.
    pub fn finish(&self) -> Result<Picture, RenderError> {
        self.check_bands()?;
        let _span = spans::span("read back");
        let read = |band: &BandState| band.frame.film.read(&band.frame.sample_counts(self.done));
        let rows = self.bands.iter().map(read).collect::<Result<Vec<FilmRows>, _>>()?;
        let mut image = film::assemble(self.size.0 as usize, self.size.1 as usize, &rows);
        let mut stats = self.stats()?;
        self.anti_alias(&mut image, &mut stats)?;
        if let (Some(motion), Some(previous)) = (&self.motion, self.animator.previous()) {
            let mut vectors = Vec::new();
            for band in &self.bands {
                let view = self.previous_view(previous, band.rows);
                let (rows, times) = motion.find(&self.device, &band.frame, previous, &view)?;
                vectors.extend(rows);
                stats::add_times(&mut stats.passes, &times);
            }
            image.layers.push(motion::layer(self.size, &vectors));
        }
        image.attributes = RenderInfo {
            // Without its folder: equal pictures are equal files, however the scene's path was spelled.
            scene: self.scene.path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            technique: self.technique_kind.name().to_string(),
            camera: self.camera.name.clone(),
            samples: self.done,
            seed: self.seed.into(),
            frame: self.frame,
            device: self.device.info.describe(),
            tier: self.tier(),
        }
        .attributes();
        Ok(Picture { image, stats })
    }

    /// The picture of the samples so far as a screen shows it: 8-bit sRGB with alpha 255, row 0 on top. For uniform
    /// sampling.
    pub fn display(&self, display: &mut Display, look: Look) -> Result<Vec<[u8; 4]>, RenderError> {
        if let Some(taa) = self.resolve(&mut Vec::new())? {
            return Ok(display.read_sums(taa.sums(), self.size.0 * self.size.1, look)?);
        }
        let mut pixels = Vec::new();
        for band in &self.bands {
            pixels.extend(display.read(&band.frame.film, self.done, look)?);
        }
        Ok(pixels)
    }

    /// Samples of the picture so far.
    pub fn done(&self) -> u32 {
        self.done
    }

    /// The times of passes, summed over the samples so far.
    pub fn passes(&self) -> &[PassTotal] {
        &self.passes
    }
}
