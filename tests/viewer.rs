//! The window, opened by the binary under Xvfb: every technique, sizes, and what becomes of a display that is not there.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, ExitCode, Output, Stdio};
use std::time::{Duration, Instant};

use libtest_mimic::{Arguments, Trial};
use nephroid::gpu::Device;
use nephroid::image::{RgbImage, png};
use nephroid::technique::TechniqueKind;
use tempfile::TempDir;

/// Part of the name of a device that presents to Xvfb, and of one that does not.
const PRESENTS: &str = "llvmpipe";
const DOES_NOT: &str = "SwiftShader";

/// What both the window and `nephroid render` are told: little to do, and the same bits each time.
const SETTINGS: [&str; 6] = ["--trace", "cwbvh", "--camera", "under", "--set", "reference.photons=20000"];

/// No run of the window takes a third of this on two slow cores; one that waits for ever is not to keep the tests.
const LIMIT: Duration = Duration::from_secs(120);
/// Points of the window that the picture does not get: the panel on the right, the line below.
const PANEL: (usize, usize) = (340, 30);
/// Of the picture's mean as the window shows it, enlarged: pixels are looked at in their middles, where interpolation takes
/// a few per cent of their neighbours.
const ENLARGED: f32 = 0.05;

fn main() -> ExitCode {
    let names: Vec<String> = Device::list().unwrap_or_default().into_iter().map(|device| device.name).collect();
    let has = |part: &str| names.iter().any(|name| name.contains(part));
    let server = Command::new("Xvfb").arg("-help").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok();
    let without = |driver: &str| match (server, has(driver)) {
        (false, _) => Some("Xvfb is not installed".to_string()),
        (_, false) => Some(format!("no {driver} device")),
        _ => None,
    };
    let trials = vec![
        trial("a_script_plays_every_technique", without(PRESENTS), plays_a_script),
        trial("ctrl_c_closes_the_window", without(PRESENTS), ctrl_c),
        trial("a_device_that_cannot_present_is_named", without(DOES_NOT), cannot_present),
        trial("a_missing_library_is_named", without(PRESENTS), missing_library),
        trial("no_display_and_bad_input_are_sentences", None, refusals),
    ];
    libtest_mimic::run(&Arguments::from_args(), trials).exit_code()
}

fn trial(name: &str, missing: Option<String>, run: fn()) -> Trial {
    let name = missing.as_ref().map_or(name.to_string(), |reason| format!("{name} (skipped: {reason})"));
    Trial::test(name, move || {
        run();
        Ok(())
    })
    .with_ignored_flag(missing.is_some())
}

fn plays_a_script() {
    let (server, folder) = (Server::start(), folder());
    let mut script = String::from("size 96x72\nwindow 1000x700\n");
    for kind in TechniqueKind::ALL {
        let name = kind.name();
        script += &format!("technique {name}\nwait 2\nscreenshot {name}.png\n");
    }
    // The last technique stays in use.
    script += "
        capture window.png
        exposure 1
        screenshot bright.png
        exposure 0
        split none
        wait 2
        capture split.png
        split off
        wait 2
        capture unsplit.png
        technique none
        heat final
        wait 2
        capture heat.png
        heat off
        technique reference
        set reference.photons=5000
        wait 2
        screenshot set.png
        set reference.photons=20000
        TECHNIQUE
        wait 2
        turn 0.1 0.1           # dragging, at a fraction of the size and then at the full size
        screenshot turned.png
        camera under
        wait 2
        screenshot back.png
        taa 4                  # in use and out of it again: nothing of it is left in what stands still
        split none
        frame 3
        turn 0.1 0
        turn 0.1 0
        wait 2
        camera under
        taa off
        minimise
        restore
        window 900x640
        size 64x48
        wait 2
        screenshot small.png
        split off
        capture smaller.png
        quit";
    let last = TechniqueKind::ALL.last().unwrap().name();
    let script = script.replace("TECHNIQUE", &format!("technique {last}"));
    std::fs::write(folder.path().join("script.txt"), script).unwrap();
    let truth = ["--technique", last, "--size", "96x72", "--samples", "2", "-o", "truth.exr"];
    let output = finish(&mut run(&folder, "render", &truth, &SETTINGS[..4]));
    assert!(output.status.success(), "{output:?}");
    let arguments = ["--device", PRESENTS, "--script", "script.txt", "--truth", "truth.exr", "--validation"];
    let output = server.view(&folder, &arguments);
    assert!(output.status.success(), "{output:?}");

    for kind in TechniqueKind::ALL {
        let name = kind.name();
        let arguments = ["--technique", name, "--size", "96x72", "--samples", "2", "-o", "render.png"];
        // Settings are those of one technique.
        let own = SETTINGS.len() - if *kind == TechniqueKind::Reference { 0 } else { 2 };
        let output = finish(&mut run(&folder, "render", &arguments, &SETTINGS[..own]));
        assert!(output.status.success(), "{output:?}");
        assert!(
            picture(&folder, "render.png") == picture(&folder, &format!("{name}.png")),
            "{name} is not what render makes"
        );
        // All light comes through the water, so all of it is caustic.
        let light = mean(&folder, &format!("{name}.png")).0;
        assert!((light > 0.01) == (*kind != TechniqueKind::None), "{name}: {light}");
    }
    assert!(picture(&folder, "turned.png") != picture(&folder, &format!("{last}.png")));
    assert!(
        picture(&folder, "back.png") == picture(&folder, &format!("{last}.png")),
        "the scene's camera is not the same again"
    );
    assert_eq!(mean(&folder, "small.png").1, (64, 48));
    for (name, window, screenshot) in
        [("window.png", (1000, 700), format!("{last}.png")), ("smaller.png", (900, 640), "small.png".to_string())]
    {
        let (light, size) = mean(&folder, &screenshot);
        let (shown, found) = (in_window(&folder, name, size, 0.0..1.0), mean(&folder, name).1);
        assert_eq!(found, window, "{name}");
        assert!((luminance(shown) / light - 1.0).abs() < ENLARGED, "{name}: {shown:?}, and {screenshot} is {light}");
    }
    let size = (96, 72);
    let (left, right) =
        (in_window(&folder, "split.png", size, 0.0..0.45), in_window(&folder, "split.png", size, 0.55..1.0));
    // `none` has no caustic light, and the pool no other.
    assert!(luminance(right) < 0.1 * luminance(left), "{left:?} {right:?}");
    assert_eq!(
        in_window(&folder, "unsplit.png", size, 0.0..1.0),
        in_window(&folder, "window.png", size, 0.0..1.0),
        "the first picture is not back"
    );
    let [red, _, blue] = in_window(&folder, "heat.png", size, 0.0..1.0);
    assert!(blue > 1.2 * red, "darker than the truth, the picture is not blue: {red} {blue}");
    let (light, bright) = (mean(&folder, &format!("{last}.png")).0, mean(&folder, "bright.png").0);
    assert!(bright > 1.3 * light, "a stop more: {light} {bright}");
    assert!(picture(&folder, "set.png") != picture(&folder, "reference.png"), "other photons, the same picture");
}

fn ctrl_c() {
    let (server, folder) = (Server::start(), folder());
    // A pipe that closes when the window's first picture is there would need the script's help: a file does.
    std::fs::write(folder.path().join("script.txt"), "size 32x24\nwait 1\nscreenshot there.png\nwait 1000000").unwrap();
    let mut command = server.command(&folder, &["--technique", "none", "--script", "script.txt"]);
    let mut child = command.args(["--device", PRESENTS]).stderr(Stdio::piped()).spawn().unwrap();
    wait_for(|| folder.path().join("there.png").exists() || child.try_wait().unwrap().is_some());
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let output = end(child);
    assert!(sent.success() && output.status.code() == Some(130), "{output:?}");
}

fn cannot_present() {
    let (server, folder) = (Server::start(), folder());
    let output = server.view(&folder, &["--device", DOES_NOT]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    for part in [DOES_NOT, "cannot show pictures in this window", "nephroid render"] {
        assert!(said.contains(part), "{said}");
    }
}

/// Files that are no libraries are found before those that are.
fn missing_library() {
    let (server, folder) = (Server::start(), folder());
    for name in ["libxkbcommon-x11.so", "libxkbcommon-x11.so.0"] {
        std::fs::write(folder.path().join(name), "").unwrap();
    }
    let output = finish(server.command(&folder, &["--device", PRESENTS]).env("LD_LIBRARY_PATH", folder.path()));
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("no window can be opened") && said.contains("libxkbcommon-x11"), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
}

fn refusals() {
    let folder = folder();
    std::fs::write(folder.path().join("bad.txt"), "wait 1\njump").unwrap();
    let cases: [(&[&str], &str); 5] = [
        (&[], "no window can be opened"),
        (&["--script", "bad.txt"], "bad.txt, line 2: 'jump' is no step"),
        (&["--set", "reference.photons=0"], "reference.photons is \"0\""),
        (&["--camera", "moon"], "no camera \"moon\""),
        (&["--truth", "missing.exr"], "missing.exr: cannot be read"),
    ];
    for (arguments, message) in cases {
        let mut command = run(&folder, "view", arguments, &[]);
        let output = finish(command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY"));
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(1) && said.contains(message), "{arguments:?}: {said}");
        assert_eq!(said.lines().count(), 1, "{said}");
    }
}

/// A folder with the pool, with less water so that it is quick.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/pool.toml")).unwrap();
    std::fs::write(folder.path().join("scene.toml"), text.replace("quads = [256, 256]", "quads = [64, 64]")).unwrap();
    folder
}

fn run(folder: &TempDir, command: &str, arguments: &[&str], more: &[&str]) -> Command {
    let mut binary = Command::new(env!("CARGO_BIN_EXE_nephroid"));
    binary.args([command, "scene.toml"]).args(arguments).args(more).current_dir(folder.path());
    binary
}

fn finish(command: &mut Command) -> Output {
    end(command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap())
}

/// What becomes of it within the limit.
fn end(mut child: Child) -> Output {
    let started = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if started.elapsed() > LIMIT {
            let _ = child.kill();
            panic!("still running after {LIMIT:?}: {:?}", child.wait_with_output());
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    child.wait_with_output().unwrap()
}

/// Mean linear colour of a picture of `size` in a capture of the window, over a range of its columns, 0 to 1.
fn in_window(folder: &TempDir, name: &str, size: (usize, usize), columns: std::ops::Range<f32>) -> [f32; 3] {
    let window = picture(folder, name);
    let free = ((window.width - PANEL.0) as f32, (window.height - PANEL.1) as f32);
    let scale = (free.0 / size.0 as f32).min(free.1 / size.1 as f32);
    let corner = ((free.0 - scale * size.0 as f32) * 0.5, (free.1 - scale * size.1 as f32) * 0.5);
    let at = |corner: f32, index: usize| (corner + (index as f32 + 0.5) * scale) as usize;
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for y in 0..size.1 {
        for x in (0..size.0).filter(|x| columns.contains(&((*x as f32 + 0.5) / size.0 as f32))) {
            let pixel = window.pixels[at(corner.1, y) * window.width + at(corner.0, x)];
            sum = std::array::from_fn(|c| sum[c] + pixel[c]);
            count += 1.0;
        }
    }
    sum.map(|sum| sum / count)
}

fn luminance(colour: [f32; 3]) -> f32 {
    colour.iter().sum::<f32>() / 3.0
}

fn picture(folder: &TempDir, name: &str) -> RgbImage {
    png::read_linear(&folder.path().join(name)).unwrap()
}

/// Mean linear value of a PNG, and its size.
fn mean(folder: &TempDir, name: &str) -> (f32, (usize, usize)) {
    let image = picture(folder, name);
    let sum: f32 = image.pixels.iter().flatten().sum();
    (sum / (3 * image.pixels.len()) as f32, (image.width, image.height))
}

fn wait_for(mut there: impl FnMut() -> bool) {
    for _ in 0..600 {
        if there() {
            return;
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    panic!("nothing came in a minute");
}

/// An X server without a screen, on a display number of its own choice.
struct Server {
    process: Child,
    display: String,
}

impl Server {
    fn start() -> Self {
        let mut process = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut number = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut number).unwrap();
        Server { process, display: format!(":{}", number.trim()) }
    }

    fn command(&self, folder: &TempDir, arguments: &[&str]) -> Command {
        let mut command = run(folder, "view", arguments, &SETTINGS[..4]);
        command.env("DISPLAY", &self.display).env_remove("WAYLAND_DISPLAY").env_remove("NEPHROID_DEVICE");
        command
    }

    fn view(&self, folder: &TempDir, arguments: &[&str]) -> Output {
        finish(self.command(folder, arguments).args(&SETTINGS[4..]))
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
