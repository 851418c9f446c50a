//! The technique `mnee` against Newton's method and specular manifold sampling: error and time of each at every doubling
//! of the samples, and how much longer each takes to the walk's error.
//!
//! `cargo bench --bench mnee_solvers` renders the pool as the tests do. `-- --truth T.exr --mask M.png --size 480x360
//! --samples 256 --seconds 600` holds it against another truth of the same scene. A solver stops at `--samples`, the
//! unbiased one at 64 times as many, or once it took `--seconds`. Prints a table and writes `target/bench/mnee_solvers.json`.
//!
//! Time is the process's CPU time on a software device, else the clock's, without the first sample, which compiles the
//! kernels: that counts as much as the others do on average. What the frame takes without caustics is measured too.

#[path = "report/mod.rs"]
mod report;

use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

use nephroid::render::{RenderSettings, Renderer};
use nephroid::technique::TechniqueKind;
use nephroid::{scene, stats};
use report::{Truth, options};

/// What is compared; the first is what the others are held against.
const SOLVERS: &[(&str, &[&str])] = &[
    ("walk all", &["mnee.solver=walk", "mnee.solutions=all"]),
    ("walk one", &["mnee.solver=walk", "mnee.solutions=one"]),
    ("newton", &["mnee.solver=newton"]),
    ("biased 1", &["mnee.solver=sms-biased", "mnee.trials=1"]),
    ("biased 5", &["mnee.solver=sms-biased", "mnee.trials=5"]),
    ("biased 20", &["mnee.solver=sms-biased", "mnee.trials=20"]),
    ("biased 50", &["mnee.solver=sms-biased", "mnee.trials=50"]),
    ("unbiased", &[UNBIASED]),
];

const UNBIASED: &str = "mnee.solver=sms-unbiased";

struct Options {
    scene: PathBuf,
    layer: String,
    truth: PathBuf,
    mask: Option<PathBuf>,
    seconds: f64,
    settings: RenderSettings,
}

/// A solver after some samples.
#[derive(Debug, Clone, serde::Serialize)]
struct Row {
    samples: u32,
    seconds: f64,
    rel_rmse: f64,
    energy_ratio: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = options()?;
    let truth = Truth::read(&options.truth, &options.layer, options.mask.as_deref())?;
    let frame = RenderSettings { technique: TechniqueKind::None, ..options.settings.clone() };
    let (about, rows) = run(&options, &frame, None)?;
    let frame_seconds = rows.last().map_or(0.0, |row| row.seconds / f64::from(row.samples));
    println!("{about}, camera {}", options.settings.camera.as_deref().unwrap_or_default());
    println!("the frame without caustics: {:.4} s a sample\n", frame_seconds);
    println!(
        "{:<10} {:>8} {:>9} {:>10} {:>9} {:>9} {:>9}",
        "solver", "samples", "s", "s caustics", "relRMSE", "energy", "x walk"
    );
    let mut walk = Vec::new();
    let mut results = Vec::new();
    for (name, set) in SOLVERS {
        let mut settings = RenderSettings { technique: TechniqueKind::Mnee, ..options.settings.clone() };
        settings.set.extend(set.iter().map(|s| s.to_string()));
        let (_, rows) = run(&options, &settings, Some(&truth))?;
        if walk.is_empty() {
            walk = rows.clone();
        }
        for row in &rows {
            let ratio = slower(&walk, row);
            println!(
                "{name:<10} {:>8} {:>9.2} {:>10.2} {:>8.2}% {:>9.5} {:>9}",
                row.samples,
                row.seconds,
                row.seconds - frame_seconds * f64::from(row.samples),
                100.0 * row.rel_rmse,
                row.energy_ratio,
                ratio.text()
            );
        }
        println!();
        results.push(serde_json::json!({ "solver": name, "settings": set, "rows": rows }));
    }
    report::write(
        "mnee_solvers",
        serde_json::json!({ "device": about, "frame_seconds_per_sample": frame_seconds, "solvers": results }),
    )
}

/// Renders until samples or seconds run out, and tells the error at each doubling of the samples.
fn run(
    options: &Options,
    settings: &RenderSettings,
    truth: Option<&Truth>,
) -> Result<(String, Vec<Row>), Box<dyn Error>> {
    let mut renderer = Renderer::new(scene::load(&options.scene)?, settings)?;
    let software = renderer.device().info.kind == "cpu";
    let start = Instant::now();
    let unbiased = settings.set.iter().any(|s| s == UNBIASED);
    let samples = renderer.samples() * if unbiased { 64 } else { 1 };
    let now = || if software { stats::cpu_seconds() } else { start.elapsed().as_secs_f64() };
    let (mut rows, mut later) = (Vec::new(), 0.0);
    for _ in 0..samples {
        let before = now();
        let done = renderer.sample()?.done;
        if done > 1 {
            later += now() - before;
        }
        if !done.is_power_of_two() || done == 1 {
            continue;
        }
        let seconds = later * f64::from(done) / f64::from(done - 1);
        let metrics = truth.map(|truth| truth.error(&renderer, &options.layer)).transpose()?;
        let (rel_rmse, energy_ratio) = metrics.map_or((0.0, 0.0), |m| (m.rel_rmse, m.energy_ratio));
        rows.push(Row { samples: done, seconds, rel_rmse, energy_ratio });
        if seconds > options.seconds {
            break;
        }
    }
    Ok((format!("{}, {}", renderer.device().info.describe(), renderer.tier()), rows))
}

/// How much longer a solver took to its error than the walk to the same.
enum Slower {
    Times(f64),
    /// The walk's fewest samples have less error already.
    AtLeast(f64),
    /// The walk's most samples have more error.
    Never,
}

impl Slower {
    fn text(&self) -> String {
        match self {
            Slower::Times(times) => format!("{times:.2}"),
            Slower::AtLeast(times) => format!("> {times:.2}"),
            Slower::Never => "-".to_string(),
        }
    }
}

/// Between two of the walk's rows both error and time are taken as powers of the samples.
fn slower(walk: &[Row], row: &Row) -> Slower {
    let Some(first) = walk.first() else { return Slower::Never };
    if row.rel_rmse > first.rel_rmse {
        return Slower::AtLeast(row.seconds / first.seconds);
    }
    for pair in walk.windows(2) {
        let [a, b] = pair else { continue };
        if (b.rel_rmse..=a.rel_rmse).contains(&row.rel_rmse) {
            let part = (a.rel_rmse / row.rel_rmse).ln() / (a.rel_rmse / b.rel_rmse).ln().max(1e-9);
            return Slower::Times(row.seconds / (a.seconds * (b.seconds / a.seconds).powf(part)));
        }
    }
    Slower::Never
}

fn options() -> Result<Options, Box<dyn Error>> {
    let mut options = Options {
        scene: "scenes/pool.toml".into(),
        layer: "refracted".to_string(),
        truth: "tests/truth/pool_under_120x90.exr".into(),
        mask: None,
        seconds: 60.0,
        settings: RenderSettings {
            camera: Some("under".to_string()),
            size: Some((120, 90)),
            samples: Some(64),
            trace: "bvh".parse()?,
            ..Default::default()
        },
    };
    for (name, value) in options::given()? {
        match name.as_str() {
            "--scene" => options.scene = value.into(),
            "--layer" => options.layer = value,
            "--truth" => options.truth = value.into(),
            "--mask" => options.mask = Some(value.into()),
            "--seconds" => options.seconds = value.parse()?,
            "--samples" => options.settings.samples = Some(value.parse()?),
            _ => options::put(&mut options.settings, (name, value))?,
        }
    }
    Ok(options)
}
