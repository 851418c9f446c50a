//! `nephroid render`: from a scene file to picture files.

mod args;
#[cfg(feature = "hot-reload")]
mod watch;

use std::process::ExitCode;
use std::time::{Duration, Instant};

pub use args::RenderArgs;

use super::args::PictureArgs;
use super::error::PictureError;
use super::interrupt;
use super::output::{self, Teller};
use super::places;
use super::progress::Display;
use super::request::Request;
use super::trace_file::TraceFile;
use crate::image::atomic;
use crate::render::{Picture, Renderer};
use crate::scene;
use crate::spans;

/// Renders and writes all files. The status is 0, or 130 where Ctrl-C made the picture one of fewer samples.
///
/// # Errors
/// Everything that can be checked is, before the first sample: outputs, scene, device, settings.
pub fn run(args: &RenderArgs) -> Result<ExitCode, PictureError> {
    let start = Instant::now();
    let formats = args.output.iter().map(|path| atomic::check(path)).collect::<Result<Vec<_>, _>>()?;
    let PictureArgs { scene, stats, trace_file, .. } = &args.picture;
    stats.iter().chain(trace_file).try_for_each(|path| atomic::check_place(path))?;
    let reports = [("--stats", stats), ("--trace-file", trace_file)];
    let reports = reports.into_iter().filter_map(|(option, path)| Some((option, path.clone()?)));
    let pictures = args.output.iter().map(|path| ("--output", path.clone()));
    places::distinct([("the scene", scene.clone())].into_iter().chain(reports).chain(pictures))?;
    let trace_file = trace_file.as_deref().map(TraceFile::start);

    let span = spans::span("load scene");
    let mut scene = scene::load(&args.picture.scene)?;
    drop(span);
    let mut teller = Teller::new(args.picture.quiet);
    teller.warn(&scene.warnings);
    let settings = args.picture.settings(args.frame);
    let request = Request::new(&mut scene, &settings)?;

    let mut renderer = Renderer::new(scene, &settings)?;
    let device = renderer.device().clone();
    teller.tell_device(&renderer);
    teller.warn(&device.warnings());
    teller.tell_late_start(renderer.scene(), args.frame);
    teller.tell_frames_before(&renderer, args.frame);

    let (done, kernels) = render(&mut renderer, args)?;
    let Picture { mut image, stats } = renderer.finish()?;
    // One of fewer samples, or by kernels from elsewhere, is not what was asked for.
    if done == renderer.samples() && kernels == Kernels::BuiltIn {
        request.mark(&mut image);
    }
    interrupt::spare(|| {
        for (path, format) in args.output.iter().zip(formats) {
            output::write(path, format, &image, &renderer.scene().film)?;
        }
        args.picture.stats.as_deref().map_or(Ok(()), |path| output::write_json(path, &stats))
    })?;
    let trace_file = trace_file.map(|file| interrupt::spare(|| file.write(&device.info.name))).transpose()?;

    teller.warn(&stats.warnings);
    tell_result(&teller, done, renderer.samples(), start.elapsed());
    args.output.iter().chain(&args.picture.stats).chain(&trace_file).for_each(|path| teller.tell_file(path));
    output::refuse_validation_messages(&device)?;
    Ok(if done < renderer.samples() { ExitCode::from(interrupt::STATUS) } else { ExitCode::SUCCESS })
}

/// What a picture was made by.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kernels {
    BuiltIn,
    /// At least one was swapped in while the program ran.
    #[cfg(feature = "hot-reload")]
    Reloaded,
}

/// Renders all samples, or fewer where Ctrl-C comes, and returns their number.
fn render(renderer: &mut Renderer, args: &RenderArgs) -> Result<(u32, Kernels), PictureError> {
    let kernels = Kernels::BuiltIn;
    #[cfg(feature = "hot-reload")]
    let (mut kernels, mut watch) = (kernels, watch::Watch::new(args, renderer)?);
    interrupt::catch();
    let mut display = Display::new(renderer.samples(), args.picture.quiet);
    let mut done = 0;
    while done < renderer.samples() && !(interrupt::came() && done > 0) {
        #[cfg(feature = "hot-reload")]
        if watch.poll(renderer, &display)? {
            kernels = Kernels::Reloaded;
            display.finish();
            display = Display::new(renderer.samples(), args.picture.quiet);
        }
        let progress = renderer.sample()?;
        display.update(&progress);
        done = progress.done;
    }
    display.finish();
    Ok((done, kernels))
}

fn tell_result(teller: &Teller, done: u32, samples: u32, time: Duration) {
    if done < samples {
        teller.tell(format_args!("Stopped by Ctrl-C: the picture has {done} of {samples} samples"));
    }
    teller.tell(format_args!("Time    {:.1} s for {done} samples a pixel", time.as_secs_f64()));
}
