//! The window and its events, from opening to closing.

use std::panic;
use std::process;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use egui::ViewportId;
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::window::{Window, WindowId};

use super::heat::Heat;
use super::panel::{self, PANEL_WIDTH, STATUS_HEIGHT};
use super::picture::Pictures;
use super::script::{Script, Step};
use super::session::{self, News, Session};
use super::state::Eye;
use super::{Closed, ViewError, ViewSettings};
use crate::commands::interrupt::STATUS;
use crate::gpu::{Device, Drawn, Painter, Swapchain};
use crate::image::{Format, ImageError, png};
use crate::render::Renderer;
use crate::scene::Scene;

/// The smallest window in which the panel can be used, in points.
const LEAST: (f32, f32) = (640.0, 400.0);
/// How long a script waits for the window to take a size or state.
const PATIENCE: Duration = Duration::from_secs(2);
/// How often an idle window looks at what may have changed behind its back.
const IDLE: Duration = Duration::from_millis(200);

/// Ctrl-C.
#[derive(Debug)]
struct Interrupt;

/// Opens the window and stays until it is closed.
///
/// # Errors
/// Scene, settings, script and truth are checked first; then no display, no device that can present to it, or a device
/// that is lost.
pub fn run(settings: &ViewSettings) -> Result<Closed, ViewError> {
    let scene = session::load(&settings.scene)?;
    let heat = settings.truth.as_deref().map(Heat::new).transpose()?;
    Renderer::check(&scene, &settings.render)?;
    let script = settings.script.as_deref().map(Script::read).transpose()?.unwrap_or_default();
    let no_display = |reason: String| ViewError::NoDisplay { reason };
    let events = event_loop().map_err(no_display)?;
    catch_ctrl_c(events.create_proxy());
    let mut app = App { settings, start: Some((scene, heat, script)), live: None, end: Ok(Closed::ByUser) };
    events.run_app(&mut app).map_err(|error| no_display(reason(&error)))?;
    if let Some(live) = app.live.take() {
        // What is still held when the device goes is told of only then.
        let messages = live.session.device.validation_log();
        drop(live);
        let messages = messages.lock().map(|messages| messages.clone()).unwrap_or_default();
        if let (Some(first), Ok(_)) = (messages.first(), &app.end) {
            return Err(ViewError::Validation { count: messages.len(), first: first.clone() });
        }
    }
    app.end
}

/// The connection to the display, or why there is none. winit (0.30) panics where a library of X11 is missing.
fn event_loop() -> Result<EventLoop<Interrupt>, String> {
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| {}));
    let built = panic::catch_unwind(|| EventLoop::<Interrupt>::with_user_event().build());
    panic::set_hook(hook);
    match built {
        Ok(built) => built.map_err(|error| reason(&error)),
        Err(panic) => {
            let said = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
            Err(said.unwrap_or("a library of the display is missing").trim_end_matches('.').to_string())
        }
    }
}

/// What a windowing error says, without its place in a source file.
fn reason(error: &dyn std::fmt::Display) -> String {
    let text = error.to_string();
    text.rsplit_once(": ").map_or(text.as_str(), |(_, last)| last).trim_end_matches('.').to_string()
}

/// The first Ctrl-C closes the window after the sample at hand, the second ends the program. Where it cannot be caught, it
/// ends the program as it would anyway.
fn catch_ctrl_c(proxy: EventLoopProxy<Interrupt>) {
    let came = AtomicBool::new(false);
    let _ = ctrlc::set_handler(move || {
        if came.swap(true, Ordering::Relaxed) {
            process::exit(STATUS.into());
        }
        let _ = proxy.send_event(Interrupt);
    });
}

struct App<'a> {
    settings: &'a ViewSettings,
    start: Option<(Scene, Option<Heat>, Script)>,
    live: Option<Live>,
    end: Result<Closed, ViewError>,
}

/// Everything there is once the window is open. What draws goes before what it draws on.
struct Live {
    painter: Painter,
    swapchain: Swapchain,
    pictures: Pictures,
    egui: egui_winit::State,
    session: Session,
    panel: panel::Panel,
    script: Script,
    /// Since when the script waits for the window.
    waiting: Option<Instant>,
    capture: bool,
    captured: Option<(u32, u32, Vec<[u8; 3]>)>,
    /// Whether nothing of the window can be seen, as the display tells.
    occluded: bool,
    minimised: bool,
    /// Whether the window had no area when it was to be drawn last.
    empty: bool,
    repaint_at: Option<Instant>,
    /// Of the last round of work: whether there was more to do, and what there was to see.
    before: Option<(bool, News)>,
    window: Arc<Window>,
}

impl App<'_> {
    fn finish(&mut self, events: &ActiveEventLoop, end: Result<Closed, ViewError>) {
        if !events.exiting() {
            self.end = end;
            events.exit();
        }
    }
}

impl ApplicationHandler<Interrupt> for App<'_> {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        let Some((scene, heat, script)) = self.start.take() else { return };
        match Live::open(events, self.settings, scene, heat, script) {
            Ok(live) => self.live = Some(live),
            Err(error) => self.finish(events, Err(error)),
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(live) = self.live.as_mut().filter(|_| !events.exiting()) else { return };
        match event {
            WindowEvent::CloseRequested | WindowEvent::Destroyed => return self.finish(events, Ok(Closed::ByUser)),
            WindowEvent::RedrawRequested => {
                if let Err(error) = live.draw() {
                    self.finish(events, Err(error));
                }
                return;
            }
            WindowEvent::Resized(_) => live.swapchain.resized(),
            WindowEvent::Occluded(occluded) => live.occluded = occluded,
            _ => {}
        }
        live.session.touch();
        let _ = live.egui.on_window_event(&live.window, &event);
        live.window.request_redraw();
    }

    fn user_event(&mut self, events: &ActiveEventLoop, _: Interrupt) {
        self.finish(events, Ok(Closed::ByCtrlC));
    }

    /// Between events: the script goes on, the picture gets better.
    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let Some(live) = self.live.as_mut().filter(|_| !events.exiting()) else { return };
        match live.work() {
            Ok(Some(next)) => events.set_control_flow(next),
            Ok(None) => self.finish(events, Ok(Closed::ByUser)),
            Err(error) => self.finish(events, Err(error)),
        }
    }
}

impl Live {
    fn open(
        events: &ActiveEventLoop,
        settings: &ViewSettings,
        scene: Scene,
        heat: Option<Heat>,
        script: Script,
    ) -> Result<Self, ViewError> {
        let name = scene.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let (width, height) =
            (settings.render.size).or(heat.as_ref().map(Heat::size)).unwrap_or((scene.film.width, scene.film.height));
        let (width, height) = (width as f32 + PANEL_WIDTH, height as f32 + STATUS_HEIGHT);
        let attributes = Window::default_attributes()
            .with_title(format!("{name} - Nephroid"))
            .with_inner_size(winit::dpi::LogicalSize::new(width.clamp(1180.0, 1800.0), height.clamp(800.0, 1100.0)))
            .with_min_inner_size(winit::dpi::LogicalSize::new(LEAST.0, LEAST.1));
        let window = events.create_window(attributes).map_err(|e| ViewError::NoDisplay { reason: reason(&e) })?;
        let window = Arc::new(window);
        let (device, surface) = Device::open_for_window(&settings.render.device, window.clone())?;
        let swapchain = Swapchain::new(&device, surface)?;
        let painter = Painter::new(&device, &swapchain)?;
        let context = egui::Context::default();
        panel::style(&context);
        let side = device.info.limits.target_side as usize;
        let egui = egui_winit::State::new(
            context,
            ViewportId::ROOT,
            &window,
            Some(window.scale_factor() as f32),
            window.theme(),
            Some(side),
        );
        let session = Session::new(&device, scene, heat, settings)?;
        Ok(Live {
            painter,
            swapchain,
            pictures: Pictures::default(),
            egui,
            session,
            panel: panel::Panel::default(),
            script,
            waiting: None,
            capture: false,
            captured: None,
            occluded: false,
            minimised: false,
            empty: false,
            repaint_at: None,
            before: None,
            window,
        })
    }

    /// One round of work; `None` where the script has closed the window.
    fn work(&mut self) -> Result<Option<ControlFlow>, ViewError> {
        if !self.follow_script()? {
            return Ok(None);
        }
        let scripted = !self.script.steps.is_empty();
        // X11 tells of it only where it is asked.
        self.minimised = self.window.is_minimized().unwrap_or(false);
        if self.is_hidden() && !scripted {
            return Ok(Some(ControlFlow::WaitUntil(Instant::now() + IDLE)));
        }
        let more = self.session.advance()?;
        let drawn_for_egui = self.repaint_at.is_some_and(|at| at <= Instant::now());
        let now = Some((more, self.session.news()));
        let changed = self.before != now;
        self.before = now;
        if more || scripted || drawn_for_egui || changed {
            self.window.request_redraw();
            return Ok(Some(ControlFlow::Poll));
        }
        let idle = Instant::now() + IDLE;
        Ok(Some(ControlFlow::WaitUntil(self.repaint_at.map_or(idle, |at| at.min(idle)))))
    }

    fn is_hidden(&self) -> bool {
        self.occluded || self.minimised || self.empty
    }

    fn draw(&mut self) -> Result<(), ViewError> {
        // Some drivers wait for a window that is not shown.
        if (self.occluded || self.minimised) && !self.capture {
            return Ok(());
        }
        let size = self.window.inner_size();
        let input = self.egui.take_egui_input(&self.window);
        let context = self.egui.egui_ctx().clone();
        let Live { session, pictures, panel, .. } = self;
        let output = context.run(input, |context| panel.show(context, session, pictures));
        let repaint = output.viewport_output.get(&ViewportId::ROOT).map(|viewport| viewport.repaint_delay);
        self.repaint_at = repaint.and_then(|delay| Instant::now().checked_add(delay));
        self.egui.handle_platform_output(&self.window, output.platform_output);
        let shapes = context.tessellate(output.shapes, output.pixels_per_point);
        self.painter.set(output.textures_delta, shapes, output.pixels_per_point)?;
        match self.swapchain.draw((size.width, size.height), &mut self.painter, self.capture)? {
            Drawn::Shown(picture) => {
                self.empty = false;
                self.capture &= picture.is_none();
                self.captured = picture.or(self.captured.take());
            }
            Drawn::Hidden => self.empty = true,
            Drawn::Again => self.window.request_redraw(),
        }
        Ok(())
    }

    /// Does the steps that can be done now; `false` at the end that the script asks for.
    fn follow_script(&mut self) -> Result<bool, ViewError> {
        while let Some((line, step)) = self.script.steps.front().cloned() {
            if step == Step::Quit {
                return Ok(false);
            }
            let done = self.step(&step).map_err(|error| match error {
                StepError::Line(reason) => ViewError::from(self.script.error(line, reason)),
                StepError::View(error) => error,
            })?;
            if !done {
                break;
            }
            self.waiting = None;
            self.script.steps.pop_front();
        }
        Ok(true)
    }

    /// Begins or goes on with a step; `true` where it is done.
    fn step(&mut self, step: &Step) -> Result<bool, StepError> {
        let session = &mut self.session;
        match step {
            Step::Technique(kind) => session.left.method.kind = *kind,
            Step::Set(item) => session.left.method.set_item(item).map_err(StepError::Line)?,
            Step::Camera(name) => {
                let names: Vec<_> = session.scene.cameras.iter().map(|camera| camera.name.clone()).collect();
                if !names.contains(name) {
                    return Err(StepError::Line(format!(
                        "the scene has no camera '{name}'; it has: {}",
                        names.join(", ")
                    )));
                }
                session.wish.eye = Eye::Scene(name.clone());
            }
            Step::Turn(x, y) => {
                let (control, delta) = (session.control, glam::Vec2::new(*x, *y));
                session.move_camera(|camera| super::camera::turn(camera, control, delta));
            }
            Step::Frame(frame) => session.wish.frame = *frame,
            Step::Exposure(stops) => session.look.exposure = *stops,
            Step::Taa(frames) => session.wish.taa = *frames,
            Step::Size(width, height) => session.wish.size = (*width, *height),
            Step::Split(kind) => session.split(*kind).map_err(|e| StepError::Line(e.to_string()))?,
            Step::Heat(layer) => return self.heat_step(layer.as_deref()).map(|()| true),
            Step::Wait(samples) => return self.wait(*samples),
            Step::Screenshot(path) => {
                let format = session::check(path).map_err(ViewError::from)?;
                session.catch_up()?;
                session.save(path, format)?;
            }
            Step::Window(width, height) => {
                let wanted = PhysicalSize::new(*width, *height);
                if self.waiting.is_none() {
                    let _ = self.window.request_inner_size(wanted);
                }
                return Ok(self.waited() || self.window.inner_size() == wanted);
            }
            Step::Capture(path) => return self.capture_step(path),
            Step::Minimise => self.window.set_minimized(true),
            Step::Restore => {
                self.window.set_minimized(false);
                (self.occluded, self.minimised, self.empty) = (false, false, false);
            }
            Step::Quit => {}
        }
        Ok(true)
    }

    fn heat_step(&mut self, layer: Option<&str>) -> Result<(), StepError> {
        let Some(heat) = &mut self.session.heat else {
            return Err(StepError::Line("'heat' needs the option --truth".to_string()));
        };
        heat.shown = layer.is_some();
        match layer {
            Some(layer) if !heat.layers.iter().any(|name| name == layer) => {
                let found = heat.layers.join(", ");
                Err(StepError::Line(format!("the truth has no layer '{layer}'; it has: {found}")))
            }
            Some(layer) => {
                heat.layer = layer.to_string();
                Ok(())
            }
            None => Ok(()),
        }
    }

    /// Waits for so many samples of the picture that is wished, and lets no more come.
    fn wait(&mut self, samples: u32) -> Result<bool, StepError> {
        if self.waiting.is_none() {
            self.session.limit = samples;
            self.waiting = Some(Instant::now());
            return Ok(false);
        }
        let session = &self.session;
        if let Some(reason) = session.failure() {
            return Err(StepError::Line(reason.to_string()));
        }
        Ok(!session.is_moving() && session.follows() && session.done() >= samples)
    }

    fn capture_step(&mut self, path: &std::path::Path) -> Result<bool, StepError> {
        if self.waiting.is_none() {
            if session::check(path).map_err(ViewError::from)? != Format::Png {
                return Err(StepError::Line("the window can be written as .png only".to_string()));
            }
            (self.capture, self.captured) = (true, None);
        }
        if let Some((width, height, pixels)) = self.captured.take() {
            png::write(path, width as usize, height as usize, &pixels).map_err(ViewError::from)?;
            return Ok(true);
        }
        match self.waited() {
            true => {
                let reason = "the window was not drawn, or its pictures cannot be read on this device".to_string();
                Err(ViewError::from(ImageError::Write { path: path.to_owned(), reason }).into())
            }
            false => Ok(false),
        }
    }

    /// Whether the script has waited for the window for long enough.
    fn waited(&mut self) -> bool {
        self.waiting.get_or_insert_with(Instant::now).elapsed() > PATIENCE
    }
}

/// Why a step of the script cannot be done.
enum StepError {
    Line(String),
    View(ViewError),
}

impl From<ViewError> for StepError {
    fn from(error: ViewError) -> Self {
        match error {
            ViewError::Picture { reason } => StepError::Line(reason),
            error => StepError::View(error),
        }
    }
}
