//! `nephroid animate`: from a scene file to numbered picture files, one a frame.

mod args;
mod cost;
mod files;
mod pattern;
mod progress;
mod resume;
mod sequence;
mod video;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

pub use args::AnimateArgs;
pub use video::VideoError;

use super::error::PictureError;
use super::interrupt;
use super::output::{self, Teller};
use super::request::Request;
use super::trace_file::TraceFile;
use crate::gpu::Device;
use crate::image::Format;
use crate::render::{Picture, RenderSettings, Renderer, check_frame};
use crate::scene::{self, FilmSettings, Scene};
use crate::spans;
use crate::trace::{Backend, TraceChoice};
use cost::{SequenceStats, Split, Watch};
use files::Files;
use progress::Display;
use resume::{Maker, State};
use sequence::{Frames, Shard};
use video::Video;

/// Renders what is missing and writes all files. The status is 0, or 130 where Ctrl-C ended the sequence early.
///
/// # Errors
/// Everything that can be checked is, before the first frame: outputs, ffmpeg, scene, device, settings.
pub fn run(args: &AnimateArgs) -> Result<ExitCode, PictureError> {
    let start = Instant::now();
    let common = &args.picture;
    let shard = args.shard.unwrap_or(Shard::WHOLE);
    let files = Files::new(args, shard)?;
    let video = files.video.as_deref().map(|path| Video::new(path, &files)).transpose()?;
    let mut trace_file = files.trace_file.as_deref().map(TraceFile::start);
    if files.stats.is_some() {
        spans::record();
    }

    let span = spans::span("load scene");
    let mut scene = scene::load_at(&common.scene, args.fps)?;
    drop(span);
    let own = scene.animation.frames.map(|frames| Frames { first: 0, last: frames - 1 });
    let frames = args.frames.or(own).ok_or_else(|| PictureError::Frames { scene: common.scene.clone() })?;
    let mut teller = Teller::new(common.quiet);
    teller.warn(&scene.warnings);
    let mut settings = common.settings(0);
    check_frame(&scene, frames.last)?;
    let request = Request::new(&mut scene, &settings)?;

    let mine: Vec<u32> = frames.of(shard).collect();
    files.check_distinct(&common.scene, frames.first..=frames.last)?;
    files.check_pictures(&mine)?;
    interrupt::catch();
    files.remove_stale(&mine, shard)?;
    let found = if args.resume { look(&files, &mine, &request, &teller) } else { vec![State::Missing; mine.len()] };
    let (kept, todo): (Vec<_>, Vec<_>) =
        mine.iter().copied().zip(found).partition(|(_, s)| matches!(s, State::Kept(_)));
    adopt_backend(&mut settings, &kept);

    let (fps, film) = (scene.animation.fps, scene.film.clone());
    let mut stats = SequenceStats::new(frames, fps, shard, kept.iter().map(|(frame, _)| *frame).collect());
    if todo.is_empty() {
        warn_of_makers(&mut teller, None, &kept);
    }
    let mut row = Row { args, files: &files, request: &request, teller: &mut teller, trace_file: trace_file.as_mut() };
    let todo: Vec<u32> = todo.into_iter().map(|(frame, _)| frame).collect();
    let mut done = 0;
    let mut device = None;
    if todo.is_empty() || interrupt::came() {
        // A report may be all that goes there.
        files.make_folders()?;
    } else {
        (done, device) = row.render(scene, &settings, shard, &todo, &kept, &mut stats)?;
    }

    // Ctrl-C during the last frame is meant for the video.
    let mut stopped = done < todo.len() || video.is_some() && interrupt::came();
    let mut written: Vec<PathBuf> = Vec::new();
    if let Some(path) = &files.stats {
        stats.finish(start.elapsed().as_secs_f64());
        interrupt::spare(|| output::write_json(path, &stats))?;
        written.push(path.clone());
    }
    let mut made = Ok(None);
    if let (Some(video), false) = (&video, stopped) {
        made = make_video(video, (frames, shard), &files, &request, (fps, &film), &teller);
        // A terminal sends Ctrl-C to ffmpeg too, which then complains.
        if interrupt::came() && matches!(made, Err(VideoError::Ffmpeg { .. } | VideoError::Stopped { .. })) {
            (stopped, made) = (true, Ok(None));
        }
    }
    if let Some(file) = trace_file {
        let name = device.as_ref().map_or("none was needed", |device: &Device| device.info.name.as_str());
        written.push(interrupt::spare(|| file.write(name))?);
    }
    written.extend(made?);
    tell_end(&teller, start, (todo.len() - done, done, mine.len()), stopped);
    if done > 0 {
        files.pictures.iter().for_each(|(pattern, _)| teller.tell(format_args!("Wrote   {}", pattern.absolute())));
    }
    written.iter().for_each(|path| teller.tell_file(path));
    device.as_ref().map_or(Ok(()), output::refuse_validation_messages)?;
    Ok(if stopped { ExitCode::from(interrupt::STATUS) } else { ExitCode::SUCCESS })
}

/// Says how it ended; `frames`: left, rendered, and all of this shard.
fn tell_end(teller: &Teller, start: Instant, frames: (usize, usize, usize), stopped: bool) {
    let (left, done, all) = frames;
    if stopped {
        let left = if left == 0 { "the video is left".to_owned() } else { format!("{left} of {all} frames are left") };
        teller.tell(format_args!("Stopped by Ctrl-C: {left}; the same command with --resume goes on"));
    }
    teller.tell(format_args!("Time    {:.1} s for {done} frames", start.elapsed().as_secs_f64()));
}

/// Makes the video if all frames are there, and returns its place. Without shards they are.
fn make_video(
    video: &Video,
    (frames, shard): (Frames, Shard),
    files: &Files,
    request: &Request,
    (fps, film): (f64, &FilmSettings),
    teller: &Teller,
) -> Result<Option<PathBuf>, VideoError> {
    let all: Vec<u32> = frames.of(Shard::WHOLE).collect();
    if shard != Shard::WHOLE {
        let states = resume::look(&files.pictures, &all, request);
        let missing = states.iter().filter(|state| !matches!(state, State::Kept(_))).count();
        if missing > 0 {
            teller.tell(format_args!("No video yet: {missing} frames of other shards are not there"));
            return Ok(None);
        }
    }
    // A PNG need not be tone-mapped again.
    let png = files.pictures.iter().find(|(_, format)| *format == Format::Png);
    if let Some(source) = png.or(files.pictures.first()) {
        interrupt::spare(|| video.make(source, all.into_iter(), fps, film))?;
    }
    Ok(Some(video.path().to_owned()))
}

/// What `--resume` finds, told in one line.
fn look(files: &Files, frames: &[u32], request: &Request, teller: &Teller) -> Vec<State> {
    let span = spans::span("look at frames");
    let states = resume::look(&files.pictures, frames, request);
    drop(span);
    let count = |wanted: fn(&State) -> bool| states.iter().filter(|state| wanted(state)).count();
    let parts = [
        (count(|s| *s == State::Missing), "missing"),
        (count(|s| *s == State::Damaged), "damaged"),
        (count(|s| *s == State::Other), "of another scene, settings or version"),
    ];
    let parts: Vec<String> = parts.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!(", {n} {what}")).collect();
    let kept = count(|s| matches!(s, State::Kept(_)));
    teller.tell(format_args!("Resume  {kept} of {} frames are there{}", frames.len(), parts.concat()));
    states
}

/// `--trace auto` measures and may choose differently another day: the frames that are there have decided.
fn adopt_backend(settings: &mut RenderSettings, kept: &[(u32, State)]) {
    let Some((_, State::Kept(maker))) = kept.first() else { return };
    if settings.trace == TraceChoice::Auto {
        let of = |backend: &Backend| maker.tier.starts_with(&format!("{} tracing", backend.module()));
        match Backend::ALL.into_iter().find(of) {
            Some(Backend::Cwbvh) => settings.trace = TraceChoice::Cwbvh,
            Some(Backend::Bvh2) => settings.trace = TraceChoice::Bvh2,
            // Whether this device has it is not known yet: `auto` measures again, and if it decides otherwise, a
            // warning says so.
            Some(Backend::RayQuery) | None => {}
        }
    }
}

/// Bits are promised for one device and tier. `now`: those of the frames that are to be made.
fn warn_of_makers(teller: &mut Teller, now: Option<&Maker>, kept: &[(u32, State)]) {
    let makers = kept.iter().filter_map(|(_, state)| match state {
        State::Kept(maker) => Some(maker),
        _ => None,
    });
    let Some(usual) = now.or(makers.clone().next()) else { return };
    let others: Vec<&Maker> = makers.filter(|maker| *maker != usual).collect();
    if let Some(Maker { device, tier }) = others.first() {
        let than = if now.is_some() { "those made now" } else { "the first" };
        teller.warn(&[format!(
            "{} of the frames that are kept come from {device}, {tier}, and differ from {than} by roundings",
            others.len()
        )]);
    }
}

/// What rendering a row of frames goes by.
struct Row<'a> {
    args: &'a AnimateArgs,
    files: &'a Files,
    request: &'a Request,
    teller: &'a mut Teller,
    trace_file: Option<&'a mut TraceFile>,
}

impl Row<'_> {
    /// Renders and writes `frames` one after the other, or fewer where Ctrl-C comes; returns how many, and on what.
    fn render(
        &mut self,
        scene: Scene,
        settings: &RenderSettings,
        shard: Shard,
        frames: &[u32],
        kept: &[(u32, State)],
        stats: &mut SequenceStats,
    ) -> Result<(usize, Option<Device>), PictureError> {
        // Structures are built for frame 0 and fitted to every other, so that they do not depend on where a row
        // starts.
        let mut renderer = Renderer::new(scene, settings)?;
        let device = renderer.device().clone();
        self.teller.tell_device(&renderer);
        self.teller.warn(&device.warnings());
        let first = frames.first().copied().unwrap_or_default();
        self.teller.tell_late_start(renderer.scene(), first);
        self.teller.tell_frames_before(&renderer, first);
        let now = Maker { device: device.info.describe(), tier: renderer.tier() };
        warn_of_makers(self.teller, Some(&now), kept);
        self.warn_of_shards(&device, shard, settings);
        self.files.make_folders()?;
        self.files.check_pictures(frames)?;
        let setup = spans::drain();
        self.keep(setup);

        let mut display = Display::new(frames.len(), renderer.samples(), self.args.picture.quiet);
        let mut done = 0;
        for &frame in frames {
            if interrupt::came() {
                break;
            }
            self.frame(&mut renderer, frame, &mut display, stats)?;
            done += 1;
        }
        display.finish();
        Ok((done, Some(device)))
    }

    fn frame(
        &mut self,
        renderer: &mut Renderer,
        frame: u32,
        display: &mut Display,
        stats: &mut SequenceStats,
    ) -> Result<(), PictureError> {
        let whole = Watch::start();
        let span = spans::span_of("frame", || frame.to_string());
        let mut split = Split::default();
        renderer.go_to(frame)?;
        let events = spans::drain();
        split.moved(&events);
        self.keep(events);
        for _ in 0..renderer.samples() {
            let progress = renderer.sample()?;
            display.sample(frame, &progress);
        }
        let events = spans::drain();
        split.rendered(&events);
        self.keep(events);

        let output = Watch::start();
        let Picture { mut image, stats: of_frame } = renderer.finish()?;
        self.request.mark(&mut image);
        interrupt::spare(|| {
            let film = &renderer.scene().film;
            self.files
                .pictures
                .iter()
                .try_for_each(|(pattern, format)| output::write(&pattern.path(frame), *format, &image, film))
        })?;
        split.output.include(output.cost());
        split.whole = whole.cost();
        split.untimed(&of_frame.passes);
        drop(span);
        let events = spans::drain();
        self.keep(events);
        if self.args.picture.stats.is_some() {
            stats.add(frame, &of_frame, split);
        }
        display.frame(frame);
        display.aside(|| self.teller.warn_of_frame(frame, &of_frame.warnings));
        Ok(())
    }

    /// Passes spans on to `--trace-file`, or forgets them.
    fn keep(&mut self, events: Vec<spans::Event>) {
        if let Some(file) = &mut self.trace_file {
            file.extend(events);
        }
    }

    fn warn_of_shards(&mut self, device: &Device, shard: Shard, settings: &RenderSettings) {
        if shard != Shard::WHOLE && settings.trace == TraceChoice::Auto && Backend::RayQuery.available(device) {
            let choice =
                "each shard measures for itself how rays are traced; name one way by --trace where bits must agree";
            self.teller.warn(&[choice.to_owned()]);
        }
    }
}
