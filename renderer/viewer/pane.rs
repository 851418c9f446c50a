//! One picture of the window: a renderer at full size, and one at a fraction of it for as long as things move.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use super::history::History;
use super::state::{Eye, Followed, Method, Stage, Wish};
use crate::display::{Display, Look};
use crate::gpu::Device;
use crate::image::LayeredImage;
use crate::render::{MAX_SIDE, RenderError, RenderSettings, Renderer};
use crate::scene::Scene;
use crate::stats::Stats;

/// How often ledger, counters and warnings are read back.
const STATS_EVERY: Duration = Duration::from_secs(1);

/// What is shown of a renderer's samples.
#[derive(Clone, PartialEq)]
pub struct Shown {
    /// Pixels.
    pub size: (u32, u32),
    pub samples: u32,
    pub frame: u32,
    look: Look,
    /// No two pictures of any panes have the same.
    pub version: u64,
}

/// Of the latest picture of any pane.
static VERSION: AtomicU64 = AtomicU64::new(0);

pub struct Pane {
    pub method: Method,
    full: Stage,
    draft: Option<Stage>,
    /// Whether the draft is the latest that followed a wish.
    drafted: bool,
    /// How often the picture at full size was started over.
    pub restarts: u64,
    display: Display,
    pub shown: Option<Shown>,
    /// 8-bit sRGB and alpha, of what is shown.
    pub pixels: Vec<[u8; 4]>,
    /// Of the full size.
    pub history: History,
    pub stats: Option<Stats>,
    stats_at: Option<Instant>,
    /// The newest estimate of the caustic light's relative noise.
    pub noise: Option<f32>,
    /// What the latest sample at full size took.
    pub sample_time: Option<Duration>,
    /// Why the picture is not what was asked for: it stays until something else is asked for.
    pub failure: Option<(String, Wish, Method)>,
}

/// What all panes are made with.
pub struct Base<'a> {
    pub device: &'a Device,
    pub scene: &'a Scene,
    pub settings: &'a RenderSettings,
}

impl Pane {
    /// Looks through the scene's camera of the settings, until it is told to follow another wish.
    pub fn new(base: &Base<'_>, wish: &Wish, method: &Method) -> Result<Self, RenderError> {
        Ok(Pane {
            method: method.clone(),
            full: stage(base, wish, method)?,
            draft: None,
            drafted: false,
            restarts: 0,
            display: Display::new(base.device)?,
            shown: None,
            pixels: Vec::new(),
            history: History::default(),
            stats: None,
            stats_at: None,
            noise: None,
            sample_time: None,
            failure: None,
        })
    }

    pub fn renderer(&self) -> &Renderer {
        &self.full.renderer
    }

    /// The renderer that is at what is shown, be it of full size or not.
    pub fn seen(&self) -> &Renderer {
        self.draft.as_ref().filter(|_| self.drafted).map_or(self.renderer(), |draft| &draft.renderer)
    }

    /// Samples of the picture at full size.
    pub fn done(&self) -> u32 {
        self.full.renderer.done()
    }

    /// Whether the samples at full size are of this wish.
    pub fn follows(&self, wish: &Wish) -> bool {
        self.full.is(wish, &self.method)
    }

    /// Whether there are fewer than `limit` samples of this wish, and more can come.
    pub fn wants_more(&self, wish: &Wish, limit: u32) -> bool {
        self.failure_of(wish).is_none() && (!self.follows(wish) || self.done() < limit)
    }

    /// Why this wish cannot be shown.
    pub fn failure_of(&self, wish: &Wish) -> Option<&str> {
        let failure = self.failure.as_ref().filter(|(_, w, method)| w == wish && *method == self.method);
        failure.map(|(reason, ..)| reason.as_str())
    }

    /// Shows the wish: one more sample at a `scale`-th of its size each way, unless there are `limit` already.
    ///
    /// # Errors
    /// Where the device is lost or hangs. What else goes wrong becomes [`failure`](Self::failure).
    pub fn advance(
        &mut self,
        base: &Base<'_>,
        wish: &Wish,
        scale: u32,
        limit: u32,
        look: Look,
    ) -> Result<(), RenderError> {
        if self.failure_of(wish).is_some() {
            return Ok(());
        }
        let ((width, height), most) = (wish.size, most_side(base.device));
        if width.max(height) > most {
            let reason = format!("the picture is {width} x {height} pixels; this device can show 1 to {most} each way");
            self.failure = Some((reason, wish.clone(), self.method.clone()));
            return Ok(());
        }
        match self.try_advance(base, wish, scale, limit, look) {
            Err(error) if !is_fatal(&error) => {
                self.failure = Some((error.to_string(), wish.clone(), self.method.clone()));
                Ok(())
            }
            other => {
                self.failure = None;
                other
            }
        }
    }

    fn try_advance(
        &mut self,
        base: &Base<'_>,
        wish: &Wish,
        scale: u32,
        limit: u32,
        look: Look,
    ) -> Result<(), RenderError> {
        let drafted = scale > 1;
        let (wish, method) = match drafted {
            true => {
                let size = (wish.size.0.div_ceil(scale), wish.size.1.div_ceil(scale));
                (Wish { size, ..wish.clone() }, self.method.draft(scale))
            }
            false => (wish.clone(), self.method.clone()),
        };
        if drafted && self.draft.is_none() {
            self.draft = Some(stage(base, &wish, &method)?);
        }
        let stage = self.draft.as_mut().filter(|_| drafted).unwrap_or(&mut self.full);
        let followed = stage.follow(&wish, &method)?;
        self.drafted = drafted;
        if followed != Followed::Already && !drafted {
            self.history.restart(followed, stage.renderer.passes());
            self.restarts += 1;
            (self.noise, self.stats_at) = (None, None);
        }
        let renderer = &mut stage.renderer;
        if renderer.done() < limit {
            let started = Instant::now();
            let progress = renderer.sample()?;
            if !drafted {
                self.sample_time = Some(started.elapsed());
                self.noise = progress.noise.or(self.noise);
                self.history.add(renderer.passes());
            }
        }
        self.show(wish.frame, drafted, look)
    }

    /// Makes the picture anew where it is not that of the renderer's samples as they are to look.
    fn show(&mut self, frame: u32, drafted: bool, look: Look) -> Result<(), RenderError> {
        let stage = self.draft.as_ref().filter(|_| drafted).unwrap_or(&self.full);
        let renderer = &stage.renderer;
        let version = self.shown.as_ref().map_or(0, |shown| shown.version);
        let shown = Shown { size: renderer.size(), samples: renderer.done(), frame, look, version };
        if shown.samples > 0 && self.shown.as_ref() != Some(&shown) {
            self.pixels = renderer.display(&mut self.display, look)?;
            let version = VERSION.fetch_add(1, Ordering::Relaxed) + 1;
            self.shown = Some(Shown { version, ..shown });
        }
        Ok(())
    }

    /// Reads ledger, counters and warnings back, now and then.
    pub fn read_stats(&mut self) -> Result<(), RenderError> {
        let read = self.stats.as_ref().filter(|_| self.stats_at.is_some()).map_or(0, |stats| stats.samples);
        if self.done() != read && self.stats_at.is_none_or(|at| at.elapsed() > STATS_EVERY) {
            self.stats = Some(self.full.renderer.stats()?);
            self.stats_at = Some(Instant::now());
        }
        Ok(())
    }

    /// All layers of the samples so far, at full size.
    pub fn image(&self) -> Result<LayeredImage, RenderError> {
        Ok(self.full.renderer.finish()?.image)
    }

    /// Starts over with the kernels as they are now.
    #[cfg(feature = "hot-reload")]
    pub fn restart(&mut self) -> Result<(), RenderError> {
        self.shown = None;
        self.restarts += 1;
        for stage in std::iter::once(&mut self.full).chain(&mut self.draft) {
            stage.renderer.restart()?;
        }
        Ok(())
    }
}

/// Pixels along one side of a picture that the window can show, at most: it is one texture.
pub fn most_side(device: &Device) -> u32 {
    device.info.limits.target_side.min(MAX_SIDE)
}

/// A renderer for the wish, or as near as can be had at once; it follows the rest.
fn stage(base: &Base<'_>, wish: &Wish, method: &Method) -> Result<Stage, RenderError> {
    let mut near = wish.clone();
    near.lights = None;
    if let Eye::Own(_) = near.eye {
        near.eye = Eye::Scene(first_camera(base));
    }
    let camera = match &near.eye {
        Eye::Scene(name) => name.clone(),
        Eye::Own(camera) => camera.name.clone(),
    };
    let settings = RenderSettings {
        technique: method.kind,
        set: method.items(),
        camera: Some(camera),
        size: Some(near.size),
        frame: near.frame,
        taa: near.taa_settings(),
        ..base.settings.clone()
    };
    let renderer = Renderer::with_device(base.device.clone(), base.scene.clone(), &settings)?;
    Ok(Stage::new(renderer, near, method.clone()))
}

fn first_camera(base: &Base<'_>) -> String {
    base.scene.cameras.first().map(|camera| camera.name.clone()).unwrap_or_default()
}

fn is_fatal(error: &RenderError) -> bool {
    use crate::gpu::GpuError;
    matches!(error, RenderError::Gpu(GpuError::DeviceLost { .. } | GpuError::Timeout { .. }))
}
