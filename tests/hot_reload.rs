//! Changed kernels are run, broken ones are not: every case edits its own copy of the kernel folder.

mod common;

use std::fs;
use std::path::Path;
use std::process::ExitCode;

use common::text::FLOOR;
use common::{Case, Request, assert_valid};
use nephroid::gpu::{Capability, Device, KernelWatch, ReloadReport};
use nephroid::render::{RenderSettings, Renderer};
use nephroid::scene;
use nephroid::technique::TechniqueKind;
use tempfile::TempDir;

const DIRECT: &str = "frame/direct.comp.glsl";
const INCLUDE: &str = "shared/brightness.glsl";
const FRAGMENT: &str = "frame/visibility.frag.glsl";

/// Sums of a few f32 of one size in another order.
const ROUNDING: f32 = 1e-5;

fn main() -> ExitCode {
    common::run(&[
        Case { name: "a_changed_kernel_is_run", needs: &[], disable: "", run: changed },
        Case { name: "a_changed_include_reaches_its_kernels", needs: &[], disable: "", run: included },
        Case { name: "a_changed_raster_stage_is_run", needs: &[Capability::PreciseRaster], disable: "", run: raster },
        Case { name: "an_error_keeps_the_last_good_pipeline", needs: &[], disable: "", run: broken },
        Case { name: "a_changed_interface_is_refused", needs: &[], disable: "", run: misfit },
        Case { name: "a_folder_without_kernels_is_refused", needs: &[], disable: "", run: no_folder },
    ])
}

/// A lit floor, rendered with kernels that can be edited.
struct Bench {
    folder: TempDir,
    renderer: Renderer,
    watch: KernelWatch,
}

impl Bench {
    fn new(request: &Request) -> Self {
        let folder = TempDir::new().unwrap();
        copy(nephroid_kernels::source_folder(), folder.path());
        let settings = RenderSettings {
            device: request.device.clone(),
            trace: "bvh".parse().unwrap(),
            technique: TechniqueKind::None,
            size: Some((8, 6)),
            ..Default::default()
        };
        let renderer =
            Renderer::new(scene::parse(&format!("{FLOOR}{LAMP}"), Path::new("test.toml")).unwrap(), &settings).unwrap();
        let mut watch = KernelWatch::new(renderer.device(), folder.path()).unwrap();
        assert_eq!(watch.poll(), [], "the copy is what was built in");
        Bench { folder, renderer, watch }
    }

    /// Replaces the only `old` in a file, and returns its line.
    fn edit(&self, file: &str, old: &str, new: &str) -> usize {
        let path = self.folder.path().join(file);
        let text = fs::read_to_string(&path).unwrap();
        let [before, after] = text.split(old).collect::<Vec<_>>()[..] else { panic!("{old} is not once in {file}") };
        fs::write(path, format!("{before}{new}{after}")).unwrap();
        before.matches('\n').count() + 1
    }

    /// The kernel's name with its back-end, which a poll must report as its only outcome.
    fn expect_reload_of(&mut self, name: &str) {
        let reports = self.watch.poll();
        let [ReloadReport::Reloaded { kernel }] = &reports[..] else { panic!("{reports:?}") };
        assert_eq!(kernel.split(' ').next(), Some(name));
        assert_eq!(self.watch.poll(), [], "a change is told once");
    }

    fn expect_kept(&mut self, name: &str) -> String {
        let reports = self.watch.poll();
        let [ReloadReport::Kept { kernels, reason }] = &reports[..] else { panic!("{reports:?}") };
        assert!(kernels.len() == 1 && kernels[0].starts_with(name), "{kernels:?}");
        assert_eq!(self.watch.poll(), [], "a refusal is told once");
        reason.clone()
    }

    /// The layer of so many samples from the start, red channel.
    fn layer(&mut self, name: &str, samples: u32) -> Vec<f32> {
        self.renderer.restart().unwrap();
        self.more(name, samples)
    }

    /// The layer after so many samples more.
    fn more(&mut self, name: &str, samples: u32) -> Vec<f32> {
        for _ in 0..samples {
            self.renderer.sample().unwrap();
        }
        assert_valid(self.renderer.device());
        let image = self.renderer.finish().unwrap().image;
        image.layer(name).unwrap().to_rgb().unwrap().pixels.iter().map(|pixel| pixel[0]).collect()
    }
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy(&path, &target);
        } else {
            fs::copy(&path, target).unwrap();
        }
    }
}

fn doubled(values: &[f32]) -> Vec<f32> {
    values.iter().map(|value| 2.0 * value).collect()
}

const RADIANCE: &str = "vec4(radiance, 0.0)";
const TWICE_RADIANCE: &str = "vec4(2.0 * radiance, 0.0)";

fn changed(request: &Request) {
    let mut bench = Bench::new(request);
    let (one, two) = (bench.layer("direct", 1), bench.layer("direct", 2));
    assert!(one.iter().all(|value| *value > 0.0));

    // Between two samples of one picture: the kernel at hand is what changes.
    bench.layer("direct", 1);
    bench.edit(DIRECT, RADIANCE, TWICE_RADIANCE);
    bench.expect_reload_of("frame/direct");
    let mixed = bench.more("direct", 1);
    for ((one, two), mixed) in one.iter().zip(&two).zip(mixed) {
        let expected = 0.5 * (one + 2.0 * (2.0 * two - one));
        assert!((mixed / expected - 1.0).abs() < ROUNDING, "{mixed} {expected}");
    }

    // From the start: kernels made later are the changed ones too. Doubling is exact.
    assert_eq!(bench.layer("direct", 2), doubled(&two));

    bench.edit(DIRECT, TWICE_RADIANCE, RADIANCE);
    bench.expect_reload_of("frame/direct");
    assert_eq!(bench.layer("direct", 2), two);

    bench.edit(DIRECT, RADIANCE, "vec4( radiance , 0.0 )");
    assert_eq!(bench.watch.poll(), [], "the same code is no reason to start over");
}

fn included(request: &Request) {
    let mut bench = Bench::new(request);
    // Of its own: one that other kernels include would have the driver compile those for half a minute.
    fs::write(bench.folder.path().join(INCLUDE), "const float BRIGHTNESS = 1.0;\n").unwrap();
    bench.edit(
        DIRECT,
        "#include \"shared/film.glsl\"\n",
        &format!("#include \"shared/film.glsl\"\n#include \"{INCLUDE}\"\n"),
    );
    let before = bench.layer("direct", 1);
    bench.edit(DIRECT, RADIANCE, "vec4(BRIGHTNESS * radiance, 0.0)");
    bench.watch.poll();
    assert_eq!(bench.layer("direct", 1), before);
    bench.edit(INCLUDE, "1.0", "2.0");
    bench.expect_reload_of("frame/direct");
    assert_eq!(bench.layer("direct", 1), doubled(&before));
}

fn raster(request: &Request) {
    let mut bench = Bench::new(request);
    assert!(bench.layer("albedo", 1).iter().all(|value| *value > 0.0));
    bench.edit(FRAGMENT, "void main() {", "void main() {\n    if (gl_FragCoord.x > 4.0) discard;");
    bench.expect_reload_of("frame/visibility");
    let halves = bench.layer("albedo", 1);
    for row in halves.chunks_exact(8) {
        assert!(row[..4].iter().all(|value| *value > 0.0) && row[4..].iter().all(|value| *value == 0.0), "{row:?}");
    }
}

fn broken(request: &Request) {
    let mut bench = Bench::new(request);
    let before = bench.layer("direct", 2);
    bench.edit(DIRECT, RADIANCE, TWICE_RADIANCE);
    bench.expect_reload_of("frame/direct");

    let line = bench.edit(DIRECT, TWICE_RADIANCE, "vec4(3.0 * radience, 0.0)");
    let reason = bench.expect_kept("frame/direct");
    assert!(reason.starts_with(&format!("{DIRECT}:{line}: ")) && reason.contains("radience"), "{reason}");
    assert_eq!(bench.layer("direct", 2), doubled(&before), "the last good kernel is the one that doubles");

    let line = bench.edit(DIRECT, "#include \"shared/film.glsl\"", "#include \"shared/flim.glsl\"");
    let reports = bench.watch.poll();
    let [ReloadReport::Unreadable { reason }] = &reports[..] else { panic!("{reports:?}") };
    assert!(reason.starts_with(&format!("{DIRECT}:{line}: ")) && reason.contains("flim"), "{reason}");
    assert_eq!(bench.watch.poll(), [], "it is told once");
    assert_eq!(bench.layer("direct", 2), doubled(&before));

    bench.edit(DIRECT, "flim", "film");
    assert_eq!(bench.watch.poll(), [], "the code is what was refused before");
    bench.edit(DIRECT, "3.0 * radience", "4.0 * radiance");
    bench.expect_reload_of("frame/direct");
    assert_eq!(bench.layer("direct", 2), doubled(&doubled(&before)));
}

fn misfit(request: &Request) {
    let mut bench = Bench::new(request);
    let before = bench.layer("direct", 2);
    // Each along with a change of the result, to see that it is not run.
    for (file, old, new, word) in [
        (DIRECT, "buffer VisibleShades", "buffer Shades", "Shades"),
        (DIRECT, "set = 2, binding = 3", "set = 2, binding = 30", "binding 30"),
        ("shared/index.glsl", "local_size_x = 64", "local_size_x = 32", "workgroup"),
        ("shared/visible.glsl", "    uint events;", "    uint events;\n    vec4 more;", "VisibleShade"),
        (
            DIRECT,
            "void main() {",
            "layout(push_constant) uniform Push { uint n; } push;\n\nvoid main() {\n    if (push.n == 7u) return;",
            "push constants",
        ),
    ] {
        bench.edit(DIRECT, RADIANCE, TWICE_RADIANCE);
        bench.edit(file, old, new);
        let reports = bench.watch.poll();
        let kept = |r: &ReloadReport| match r {
            ReloadReport::Kept { kernels, reason } => {
                kernels.iter().any(|k| k.starts_with("frame/direct")) && reason.contains(word)
            }
            _ => false,
        };
        assert!(reports.iter().any(kept), "{word}: {reports:?}");
        assert_eq!(bench.layer("direct", 2), before, "{word}");
        bench.edit(file, new, old);
        bench.edit(DIRECT, TWICE_RADIANCE, RADIANCE);
        assert_eq!(bench.watch.poll(), [], "{word}");
    }
}

fn no_folder(request: &Request) {
    let folder = TempDir::new().unwrap();
    let device = Device::open(&request.device).unwrap();
    for path in [folder.path().to_owned(), folder.path().join("missing")] {
        let message = KernelWatch::new(&device, &path).err().unwrap().to_string();
        assert!(message.contains(&path.display().to_string()), "{message}");
    }
}

const LAMP: &str = r#"
[[light]]
name = "lamp"
kind = "point"
position = [0.5, 3, 0]
intensity = 10
"#;
