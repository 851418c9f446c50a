//! What the window works on: the wish, one pane or two, and how the time between two drawings is spent.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::camera::Control;
use super::heat::Heat;
use super::pane::{Base, Pane};
use super::state::{Eye, Method, Wish};
use super::{ViewError, ViewSettings, medium};
use crate::display::Look;
use crate::gpu::Device;
use crate::image::{self, Format, ImageError};
use crate::render::{RenderError, RenderSettings};
use crate::scene::{self, Camera, Scene};
use crate::technique::TechniqueKind;

/// How long after the last change things count as moving.
const MOVING: Duration = Duration::from_millis(250);
/// Samples that take less are rendered whatever the user does; those that take more wait for a moment's rest.
const QUICK: Duration = Duration::from_millis(60);
const REST: Duration = Duration::from_millis(150);
/// Time for samples between two drawings of the window.
const SLICE: Duration = Duration::from_millis(12);

/// How finely the picture is rendered while things move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// By how long a sample takes.
    Auto,
    /// A fraction of the size each way.
    Fixed(u32),
}

/// The animation's state.
pub struct Play {
    pub playing: bool,
    /// Frames per second of the window's time.
    pub rate: f64,
    /// One past the last frame of the loop.
    pub end: u32,
    since: Option<Since>,
}

/// What the clock of an animation counts from.
struct Since {
    start: Instant,
    first: u32,
    rate: f64,
    /// The frame that the clock asked for last.
    asked: u32,
}

/// What the window shows that can change between drawings, without the user.
#[derive(Clone, PartialEq)]
pub struct News {
    pictures: [Option<u64>; 2],
    map: Option<u64>,
    stats: [Option<u32>; 2],
    message: Option<(String, bool)>,
    failed: [bool; 2],
}

pub struct Session {
    pub device: Device,
    pub scene: Scene,
    settings: RenderSettings,
    pub wish: Wish,
    pub look: Look,
    pub left: Pane,
    /// The other half of a split view.
    pub right: Option<Pane>,
    /// Where the view is split, 0 to 1 of the picture's width.
    pub divider: f32,
    pub heat: Option<Heat>,
    pub scale: Scale,
    pub control: Control,
    /// Of flight, m/s.
    pub speed: f32,
    pub play: Play,
    /// Samples after which the picture is left as it is.
    pub limit: u32,
    /// The newest thing to tell, and whether it is bad news.
    pub message: Option<(String, bool)>,
    /// Which pane comes next.
    turn: bool,
    moved: Option<Instant>,
    touched: Option<Instant>,
    saved: u32,
    #[cfg(feature = "hot-reload")]
    watch: Option<crate::gpu::KernelWatch>,
    #[cfg(feature = "hot-reload")]
    polled: Option<Instant>,
}

impl Session {
    /// Renders on `device`, which was opened for the window. Nothing is rendered yet.
    pub fn new(device: &Device, scene: Scene, heat: Option<Heat>, settings: &ViewSettings) -> Result<Self, ViewError> {
        let ViewSettings { render, samples, .. } = settings;
        let size = render.size.or(heat.as_ref().map(Heat::size)).unwrap_or((scene.film.width, scene.film.height));
        let camera = render.camera.clone().or_else(|| scene.cameras.first().map(|c| c.name.clone()));
        let eye = Eye::Scene(camera.unwrap_or_default());
        let wish = Wish { eye, lights: None, frame: render.frame, size, taa: render.taa.map_or(1, |taa| taa.frames) };
        // Wrong settings are refused here; from then on all come from the panel's table.
        let items: Vec<String> = scene.settings.iter().map(|setting| setting.item()).collect();
        let method = Method::new(render.technique, &[items.as_slice(), &render.set].concat());
        let left = Pane::new(&Base { device, scene: &scene, settings: render }, &wish, &method)?;
        let (speed, rate) = (0.3 * scene.bounds().diagonal().clamp(0.01, 1e4), scene.animation.fps);
        #[cfg(feature = "hot-reload")]
        let watch = settings.watch.as_ref().map(|folder| crate::gpu::KernelWatch::new(device, folder)).transpose()?;
        Ok(Session {
            device: device.clone(),
            look: Look::from(&scene.film),
            scene,
            settings: render.clone(),
            wish,
            left,
            right: None,
            divider: 0.5,
            heat,
            scale: Scale::Auto,
            control: Control::Orbit,
            speed,
            play: Play { playing: false, rate, end: (10.0 * rate) as u32, since: None },
            limit: *samples,
            message: None,
            turn: false,
            moved: None,
            touched: None,
            saved: 0,
            #[cfg(feature = "hot-reload")]
            watch,
            #[cfg(feature = "hot-reload")]
            polled: None,
        })
    }

    /// The user does something: long samples wait.
    pub fn touch(&mut self) {
        self.touched = Some(Instant::now());
    }

    /// Something of the picture moves under the user's hand.
    pub fn moves(&mut self) {
        self.moved = Some(Instant::now());
    }

    pub fn is_moving(&self) -> bool {
        self.play.playing || self.moved.is_some_and(|at| at.elapsed() < MOVING)
    }

    /// Spends a slice of time on the picture: at least one sample, unless the user is busy with the window and a sample
    /// takes long. `true` where there is more to do.
    pub fn advance(&mut self) -> Result<bool, ViewError> {
        self.play_on();
        #[cfg(feature = "hot-reload")]
        self.poll_kernels()?;
        let slow = self.left.sample_time.is_some_and(|time| time > QUICK);
        let resting = self.touched.is_none_or(|at| at.elapsed() > REST);
        if slow && !resting && !self.is_moving() {
            return Ok(true);
        }
        let started = Instant::now();
        let mut more = true;
        while more && started.elapsed() < SLICE {
            more = self.sample()?;
        }
        if let Some(heat) = &mut self.heat {
            heat.update(&self.left, &self.wish, !more);
        }
        if !self.is_moving() {
            self.left.read_stats()?;
        }
        Ok(more)
    }

    fn sample(&mut self) -> Result<bool, RenderError> {
        let scale = if self.is_moving() { self.drafts() } else { 1 };
        let Session { device, scene, settings, wish, left, right, limit, look, .. } = self;
        let base = Base { device, scene, settings };
        // One pane at a time, so that the window waits for one sample only.
        self.turn = !self.turn;
        let mut panes: Vec<&mut Pane> = std::iter::once(left).chain(right).collect();
        let busy = panes.iter().any(|pane| scale > 1 || pane.wants_more(wish, *limit));
        let count = panes.len();
        for (index, pane) in panes.iter_mut().enumerate() {
            if !busy || count == 1 || (index == 1) == self.turn {
                pane.advance(&base, wish, scale, *limit, *look)?;
            }
        }
        let more = panes.iter().any(|pane| pane.wants_more(wish, *limit));
        Ok(more || self.is_moving())
    }

    /// The fraction of the size at which moving things are rendered.
    pub fn drafts(&self) -> u32 {
        match (self.scale, self.left.sample_time) {
            (Scale::Fixed(scale), _) => scale,
            (Scale::Auto, Some(time)) if time < Duration::from_millis(40) => 1,
            (Scale::Auto, Some(time)) if time < Duration::from_millis(160) => 2,
            (Scale::Auto, _) => 4,
        }
    }

    /// Goes to the frame that the clock asks for, once the one before was seen.
    fn play_on(&mut self) {
        if !self.play.playing {
            self.play.since = None;
            return;
        }
        let (frame, rate) = (self.wish.frame, self.play.rate);
        // A frame or speed from elsewhere starts the clock anew.
        self.play.since.take_if(|since| since.asked != frame || since.rate != rate);
        let since = Since { start: Instant::now(), first: frame, rate, asked: frame };
        let since = self.play.since.get_or_insert(since);
        let seen = |pane: &Pane| pane.shown.as_ref().is_none_or(|shown| shown.frame == self.wish.frame);
        if seen(&self.left) && self.right.as_ref().is_none_or(seen) {
            let passed = (since.start.elapsed().as_secs_f64() * rate) as u32;
            since.asked = since.first.wrapping_add(passed) % self.play.end.max(1);
            self.wish.frame = since.asked;
        }
    }

    /// The camera that is looked through, wherever it is now.
    pub fn camera(&self) -> Camera {
        match &self.wish.eye {
            Eye::Own(camera) => camera.clone(),
            Eye::Scene(name) => {
                let seen = self.left.seen();
                let moved = seen.scene().cameras.iter().find(|camera| camera.name == *name);
                moved.unwrap_or(seen.camera()).clone()
            }
        }
    }

    /// Moves the camera by hand, unless it would end up nowhere. Which medium it is in follows from where it is.
    pub fn move_camera(&mut self, change: impl FnOnce(&mut Camera)) {
        let mut camera = self.camera();
        let before = camera.position;
        change(&mut camera);
        if !camera.position.is_finite() || !camera.target.is_finite() || !camera.fov_y.is_finite() {
            return;
        }
        if camera.position != before {
            camera.medium = medium::at(self.left.seen().scene(), camera.position).unwrap_or(camera.medium);
        }
        self.wish.eye = Eye::Own(camera);
        self.moves();
    }

    /// Shows another technique beside the one that is shown, or the one alone again.
    pub fn split(&mut self, kind: Option<TechniqueKind>) -> Result<(), RenderError> {
        let Some(kind) = kind else {
            self.right = None;
            return Ok(());
        };
        let mut method = self.left.method.clone();
        method.kind = kind;
        if let Some(right) = &mut self.right {
            right.method = method;
            return Ok(());
        }
        let base = Base { device: &self.device, scene: &self.scene, settings: &self.settings };
        self.right = Some(Pane::new(&base, &self.wish, &method)?);
        Ok(())
    }

    /// As [`split`](Self::split); what goes wrong is told in the window.
    pub fn split_or_tell(&mut self, kind: Option<TechniqueKind>) {
        if let Err(error) = self.split(kind) {
            self.message = Some((error.to_string(), true));
        }
    }

    /// Why a picture of the wish cannot be had.
    pub fn failure(&self) -> Option<&str> {
        std::iter::once(&self.left).chain(&self.right).find_map(|pane| pane.failure_of(&self.wish))
    }

    /// To be compared with that of the last drawing.
    pub fn news(&self) -> News {
        let panes = [Some(&self.left), self.right.as_ref()];
        News {
            pictures: panes.map(|pane| pane.and_then(|pane| pane.shown.as_ref()).map(|shown| shown.version)),
            map: self.heat.as_ref().and_then(|heat| heat.map.as_ref()).map(|map| map.version),
            stats: panes.map(|pane| pane.and_then(|pane| pane.stats.as_ref()).map(|stats| stats.samples)),
            message: self.message.clone(),
            failed: panes.map(|pane| pane.is_some_and(|pane| pane.failure.is_some())),
        }
    }

    /// Samples of the pane that has fewest, of the picture as it is wished.
    pub fn done(&self) -> u32 {
        let right = self.right.as_ref().map_or(u32::MAX, Pane::done);
        self.left.done().min(right)
    }

    /// Whether the samples at full size are of what is wished.
    pub fn follows(&self) -> bool {
        let mut panes = std::iter::once(&self.left).chain(&self.right);
        panes.all(|pane| pane.follows(&self.wish))
    }

    /// Writes the picture at full size as `nephroid render` would write it, with the window's exposure and tone curve.
    pub fn save(&self, path: &Path, format: Format) -> Result<(), ViewError> {
        image::write(path, format, &self.left.image()?, self.look)?;
        Ok(())
    }

    /// Writes the picture as PNG and EXR under the next free name in the working folder, and tells of it.
    pub fn screenshot(&mut self) {
        let stem = self.scene.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let technique = self.left.method.kind.name();
        let (png, exr) = loop {
            self.saved += 1;
            let [png, exr] =
                ["png", "exr"].map(|ending| PathBuf::from(format!("{stem}-{technique}-{:03}.{ending}", self.saved)));
            if !png.exists() && !exr.exists() {
                break (png, exr);
            }
        };
        let written =
            self.catch_up().and_then(|()| self.save(&png, Format::Png)).and_then(|()| self.save(&exr, Format::Exr));
        self.message = Some(match written {
            Ok(()) => (format!("Wrote {} and {}", png.display(), exr.display()), false),
            Err(error) => (error.to_string(), true),
        });
    }

    /// Renders a sample at full size where there is none of the wish.
    pub fn catch_up(&mut self) -> Result<(), ViewError> {
        let Session { device, scene, settings, wish, left, look, .. } = self;
        if left.follows(wish) && left.done() > 0 {
            return Ok(());
        }
        left.advance(&Base { device, scene, settings }, wish, 1, 1, *look)?;
        match left.failure_of(wish) {
            Some(reason) => Err(ViewError::Picture { reason: reason.to_string() }),
            None => Ok(()),
        }
    }

    #[cfg(feature = "hot-reload")]
    fn poll_kernels(&mut self) -> Result<(), RenderError> {
        const EVERY: Duration = Duration::from_millis(500);
        let Some(watch) = &mut self.watch else { return Ok(()) };
        if self.polled.is_some_and(|at| at.elapsed() < EVERY) {
            return Ok(());
        }
        let reports = watch.poll();
        self.polled = Some(Instant::now());
        if reports.is_empty() {
            return Ok(());
        }
        let good = |report: &crate::gpu::ReloadReport| matches!(report, crate::gpu::ReloadReport::Reloaded { .. });
        let all: Vec<String> = reports.iter().map(ToString::to_string).collect();
        self.message = Some((all.join("\n"), !reports.iter().all(good)));
        if reports.iter().any(good) {
            for pane in std::iter::once(&mut self.left).chain(&mut self.right) {
                pane.restart()?;
            }
        }
        Ok(())
    }
}

/// Reads the scene; its warnings are told in the window.
pub fn load(path: &Path) -> Result<Scene, ViewError> {
    Ok(scene::load(path)?)
}

/// The format of a screenshot's file, and whether it can be written.
pub fn check(path: &Path) -> Result<Format, ImageError> {
    image::atomic::check(path)
}
