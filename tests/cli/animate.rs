//! Sequences: whatever interrupts them, however they are shared out, the files are those of one undisturbed run.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, SystemTime};

use nephroid::image::{openexr, png};

use crate::interrupt;
use crate::program::{Folder, Outcome, SCENE};

/// Bits are promised for one back-end, and `auto` measures.
const NONE: &str = "--technique none --trace bvh --quiet";
const MNEE: &str = "--technique mnee --trace bvh --quiet";

/// A folder in which the pond has waves that travel.
fn moving() -> Folder {
    let folder = Folder::new();
    let waves = "quads = 8\nmotion = { kind = \"waves\", depth = 1 }\nwaves = [{ wavelength = 1.5, amplitude = 0.05 }]";
    fs::write(folder.at("scene.toml"), SCENE.replace("quads = 1", waves)).unwrap();
    folder
}

/// The files of a sub-folder by name, in order.
fn files(folder: &Folder, name: &str) -> Vec<(String, Vec<u8>)> {
    let entries = fs::read_dir(folder.at(name)).unwrap().map(|entry| entry.unwrap().path());
    let name = |path: &Path| path.file_name().unwrap().to_str().unwrap().to_owned();
    let mut files: Vec<_> = entries.map(|path| (name(&path), fs::read(&path).unwrap())).collect();
    files.sort();
    files
}

fn names(files: &[(String, Vec<u8>)]) -> Vec<&str> {
    files.iter().map(|(name, _)| name.as_str()).collect()
}

#[test]
fn shards_and_stills_are_the_frames_of_one_run() {
    let folder = moving();
    folder.run(&format!("animate scene.toml --frames 2..4 {MNEE} -o whole/f_%03d.exr -o whole/f_%03d.png"));
    for shard in ["2/2", "1/2"] {
        folder.run(&format!(
            "animate scene.toml --frames 2..4 {MNEE} -o parts/f_%03d.exr -o parts/f_%03d.png --shard {shard}"
        ));
        let wanted: &[&str] = if shard == "2/2" { &["f_003.exr", "f_003.png"] } else { &[] };
        assert!(wanted.is_empty() || names(&files(&folder, "parts")) == wanted);
    }
    let whole = files(&folder, "whole");
    assert_eq!(names(&whole), ["f_002.exr", "f_002.png", "f_003.exr", "f_003.png", "f_004.exr", "f_004.png"]);
    assert!(whole == files(&folder, "parts"), "shards made other files");
    let picture = |name: &str| openexr::read(&folder.at(name)).unwrap();
    assert!(picture("whole/f_002.exr").layers != picture("whole/f_003.exr").layers, "nothing moves");

    fs::create_dir(folder.at("still")).unwrap();
    folder.run(&format!("render scene.toml --frame 3 {MNEE} -o still/f_003.exr -o still/f_003.png"));
    assert!(files(&folder, "still") == whole[2..4], "a still is another picture");
}

#[test]
fn anti_aliased_frames_are_those_of_one_run_too() {
    let folder = moving();
    let picture = format!("{NONE} --taa=3 -o");
    folder.run(&format!("animate scene.toml --frames 1..5 {picture} whole/f_%03d.exr"));
    folder.run(&format!("animate scene.toml --frames 1..5 --shard 1/2 {picture} parts/f_%03d.exr"));
    folder.run(&format!("animate scene.toml --frames 1..5 --resume {picture} parts/f_%03d.exr"));
    let whole = files(&folder, "whole");
    assert!(whole == files(&folder, "parts"), "parts are other files");
    fs::create_dir(folder.at("still")).unwrap();
    folder.run(&format!("render scene.toml --frame 4 {picture} still/f_004.exr"));
    assert!(files(&folder, "still") == whole[3..4], "a still is another picture");
    // The window's length is a part of what is asked for.
    folder.run(&format!("animate scene.toml --frames 1..5 --resume {NONE} --taa=2 -o parts/f_%03d.exr"));
    assert!(whole != files(&folder, "parts"), "frames of another window were kept");
}

#[test]
fn a_scene_says_how_many_frames_it_has() {
    let folder = moving();
    let command = format!("animate scene.toml {NONE} -o f_%d.png");
    let stderr = folder.refused(folder.command(command.split_whitespace()), 1);
    let sentence =
        "scene.toml does not say how many frames it has; say which to render by --frames, such as --frames 0..47";
    assert_eq!(stderr, format!("nephroid: {sentence}\n"));
    let scene = fs::read_to_string(folder.at("scene.toml")).unwrap();
    for frames in [2, 3] {
        fs::write(folder.at("scene.toml"), format!("{scene}\n[animation]\nframes = {frames}\n")).unwrap();
        let said = folder.run(&format!("{} --resume", command.replace(" --quiet", ""))).stdout;
        // A longer animation has the frames that a shorter one had.
        let wanted =
            if frames == 2 { "0 of 2 frames are there, 2 missing" } else { "2 of 3 frames are there, 1 missing" };
        assert!(said.starts_with(&format!("Resume  {wanted}\n")), "{said}");
    }
}

#[test]
fn fps_says_which_time_a_frame_shows() {
    let folder = moving();
    folder.run(&format!("animate scene.toml --frames 6 --fps 48 {NONE} -o fast_%d.exr"));
    folder.run(&format!("animate scene.toml --frames 3 {NONE} -o slow_%d.exr"));
    let layers = |name: &str| openexr::read(&folder.at(name)).unwrap().layers;
    assert!(layers("fast_6.exr") == layers("slow_3.exr"), "an eighth of a second is shown as two times");
}

/// Enough samples for a frame to take tens of milliseconds, so that a kill can meet any part of it.
const LONG: &str = "--samples 40";

#[cfg(unix)]
#[test]
fn a_killed_sequence_resumes() {
    let folder = moving();
    let animate =
        |at: &str| format!("animate scene.toml --frames 0..3 {LONG} {NONE} -o {at}/f_%d.exr -o {at}/f_%d.png");
    folder.run(&animate("whole"));
    let whole = files(&folder, "whole");

    let loud = animate("cut").replace(" --quiet", "");
    let mut child = start(&folder, &loud, "frame 0 is done, ");
    // Whatever the moment, the end must be the same; the clock's last digits choose it.
    let moment = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap().subsec_nanos() % 200;
    std::thread::sleep(Duration::from_millis(moment.into()));
    child.kill().unwrap();
    child.wait().unwrap();

    // What else a crash may leave: half a file of each kind, and temporary files, here one of a sequence beside.
    for name in ["cut/f_0.exr", "cut/f_1.png"] {
        let bytes = fs::read(folder.at(&name.replace("cut", "whole"))).unwrap();
        fs::write(folder.at(name), &bytes[..2 * bytes.len() / 3]).unwrap();
    }
    let (ours, anothers) =
        (folder.at("cut/.nephroid-f_2.exr-a1B2c3.part"), folder.at("cut/.nephroid-g_2.exr-a1B2c3.part"));
    for path in [&ours, &anothers] {
        fs::write(path, "cut short").unwrap();
    }
    // A file that is whole, and another frame's.
    fs::copy(folder.at("whole/f_0.png"), folder.at("cut/f_2.png")).unwrap();

    let said = folder.run(&format!("{loud} --resume")).stdout;
    let found = said.lines().find(|line| line.starts_with("Resume  ")).unwrap().to_owned();
    assert!(found.contains(" of 4 frames are there, ") && found.contains(" damaged"), "{found}");
    assert!(!ours.exists(), "a temporary file is left");
    fs::remove_file(&anothers).expect("a temporary file of another sequence was taken");
    assert!(files(&folder, "cut") == whole, "moment {moment} ms: {found}");

    // Nothing is left to do, and nothing is touched, not even on a machine without a device.
    let mut command = folder.command(format!("{loud} --resume").split_whitespace());
    let outcome = Outcome::of(command.env("VK_DRIVER_FILES", "/nonexistent").output().unwrap());
    assert_eq!(outcome.status, Some(0), "{}", outcome.stderr);
    assert!(outcome.stdout.starts_with("Resume  4 of 4 frames are there\n"), "{}", outcome.stdout);
}

#[test]
fn frames_of_other_settings_are_made_again() {
    let folder = moving();
    let resume = |options: &str| {
        let options =
            format!("animate scene.toml --frames 0..1 --technique none --trace bvh -o f_%d.png --resume {options}");
        let said = folder.run(&options).stdout;
        said.lines().find_map(|line| line.strip_prefix("Resume  ")).unwrap().to_owned()
    };
    assert_eq!(resume(""), "0 of 2 frames are there, 2 missing");
    let again = "0 of 2 frames are there, 2 of another scene, settings or version";
    // Each differs from the one before in one thing; all but the last is undone by the next.
    for options in ["--size 8x6", "--samples 1", "--seed 3", "--camera under", "--fps 12"] {
        assert_eq!(resume(options), again, "{options}");
        // What decides no more than roundings, or nothing at all, keeps them.
        assert_eq!(
            resume(&format!("{options} --disable graphics --stats s.json")),
            "2 of 2 frames are there",
            "{options}"
        );
    }
    // They are kept, and the user is told.
    fs::remove_file(folder.at("f_1.png")).unwrap();
    let options = "animate scene.toml --frames 0..1 --technique none --trace bvh2 -o f_%d.png --resume --fps 12";
    let said = folder.run(options);
    assert!(said.stdout.starts_with("Resume  1 of 2 frames are there, 1 missing\n"), "{}", said.stdout);
    assert!(said.stderr.starts_with("nephroid: warning: 1 of the frames that are kept come from "), "{}", said.stderr);

    let scene = fs::read_to_string(folder.at("scene.toml")).unwrap();
    fs::write(folder.at("scene.toml"), scene.replace("intensity = 10", "intensity = 11")).unwrap();
    assert_eq!(resume("--fps 12"), again);
    fs::rename(folder.at("f_1.png"), folder.at("f_0.png")).unwrap();
    assert_eq!(resume("--fps 12"), "0 of 2 frames are there, 1 missing, 1 of another scene, settings or version");
}

/// So many that Ctrl-C comes before the last.
const ENDLESS: &str = "0..9999";

#[cfg(unix)]
#[test]
fn ctrl_c_ends_after_a_whole_frame() {
    let folder = moving();
    let arguments = format!("animate scene.toml --frames {ENDLESS} --technique none -o cut/f_%d.exr");
    let child = start(&folder, &arguments, "frame 0 is done, 1 of 10000, ");
    let outcome = interrupt(child);
    assert_eq!(outcome.status, Some(130), "{}", outcome.stderr);
    let found = files(&folder, "cut");
    assert!(!found.is_empty() && names(&found).iter().all(|name| name.starts_with("f_")), "{:?}", names(&found));
    found.iter().for_each(|(name, _)| drop(openexr::read(&folder.at("cut").join(name)).unwrap()));
    let left = 10_000 - found.len();
    let said = format!("Stopped by Ctrl-C: {left} of 10000 frames are left; the same command with --resume goes on");
    assert!(outcome.stdout.lines().any(|l| l == said), "'{said}' is not in\n{}", outcome.stdout);
}

/// Starts the binary and waits for the first line on its standard error, which begins so.
#[cfg(unix)]
fn start(folder: &Folder, arguments: &str, line: &str) -> Child {
    let mut command = folder.command(arguments.split_whitespace());
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut errors = BufReader::with_capacity(1, child.stderr.take().unwrap());
    let mut found = String::new();
    errors.read_line(&mut found).unwrap();
    assert!(found.starts_with(line), "{found}");
    child.stderr = Some(errors.into_inner());
    child
}

#[test]
fn stats_split_each_frame() {
    let folder = moving();
    folder.run(&format!("animate scene.toml --frames 4..5 {MNEE} -o f_%d.png --stats s.json --samples 2"));
    let stats: serde_json::Value = serde_json::from_slice(&fs::read(folder.at("s.json")).unwrap()).unwrap();
    assert_eq!((&stats["first"], &stats["last"], &stats["trace"]), (&4.into(), &5.into(), &"cwbvh".into()));
    let frames = stats["frames"].as_array().unwrap();
    assert_eq!(frames.iter().map(|f| f["frame"].as_u64().unwrap()).collect::<Vec<_>>(), [4, 5]);
    for frame in frames {
        let seconds = frame["seconds"].as_f64().unwrap();
        assert!((seconds - frame["frame"].as_f64().unwrap() / 24.0).abs() < 1e-9, "{seconds}");
        let cost = |part: &str| frame["split"][part]["milliseconds"].as_f64().unwrap();
        let parts = ["animate", "refit", "frame", "technique", "output"].map(cost);
        assert!(parts.iter().all(|&part| part > 0.0), "{parts:?}");
        assert!(parts.iter().sum::<f64>() <= cost("whole"), "{parts:?} of {}", cost("whole"));
        let passes = frame["passes"].as_array().unwrap();
        let walk = passes.iter().find(|pass| pass["name"] == "frame/walk").unwrap();
        assert_eq!(walk["calls"], 2, "passes of another frame are counted");
    }
}

#[cfg(unix)]
#[test]
fn a_video_is_made_of_all_frames() {
    let folder = moving();
    // Keeps the pictures that it is given, and what it was told.
    let path = ffmpeg(&folder, "[ \"$last\" = -encoders ] && exit\necho \"$*\" >told\ncat >\"$last\"");
    let run = |options: &str| {
        let options = format!("animate scene.toml --frames 0..2 {NONE} --fps 12.5 --video v.mp4 {options}");
        let outcome = Outcome::of(folder.command(options.split_whitespace()).env("PATH", &path).output().unwrap());
        assert_eq!(outcome.status, Some(0), "{}", outcome.stderr);
    };
    run("-o f_%d.png --shard 1/2");
    assert!(!folder.at("v.mp4").exists(), "a video of half the frames");
    run("-o f_%d.png --shard 2/2");
    let frames = (0..3).map(|frame| png::read_display(&folder.at(&format!("f_{frame}.png"))).unwrap().pixels);
    let wanted: Vec<u8> = frames.flat_map(|pixels| pixels.as_flattened().to_vec()).collect();
    assert!(fs::read(folder.at("v.mp4")).unwrap() == wanted, "the video is of other pictures");
    let told = fs::read_to_string(folder.at("told")).unwrap();
    assert!(told.contains("-video_size 16x12 -framerate 12.5 -i -"), "{told}");

    fs::remove_file(folder.at("v.mp4")).unwrap();
    run("-o f_%d.exr");
    assert!(fs::read(folder.at("v.mp4")).unwrap() == wanted, "the video of EXR files is of other pictures");
}

#[cfg(unix)]
#[test]
fn an_ffmpeg_that_does_not_run_is_noticed_at_once() {
    let folder = moving();
    let path = ffmpeg(&folder, "exit 3");
    let mut command = animate(&folder, &format!("--frames 0..1 {NONE} -o f_%d.png --video v.mp4"));
    let stderr = folder.refused(
        {
            command.env("PATH", path);
            command
        },
        1,
    );
    let program = folder.at("bin/ffmpeg");
    let sentence = format!("--video needs the program ffmpeg, and {} does not run: exit status: 3", program.display());
    assert_eq!(stderr, format!("nephroid: {sentence}; mend it, or leave --video out\n"));
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_no_half_video() {
    let folder = moving();
    folder.run(&format!("animate scene.toml --frames 0..1 {NONE} -o f_%d.png"));
    // Says that it has begun, and does not end by itself.
    let path = ffmpeg(&folder, "[ \"$last\" = -encoders ] && exit\necho begun >told\nexec sleep 600");
    let options = "animate scene.toml --frames 0..1 --technique none --trace bvh -o f_%d.png --video v.mp4 --resume";
    let mut command = folder.command(options.split_whitespace());
    let command = command.env("PATH", path).stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = command.spawn().unwrap();
    while !folder.at("told").exists() {
        std::thread::sleep(Duration::from_millis(10));
    }
    let outcome = interrupt(child);
    assert_eq!(outcome.status, Some(130), "{}", outcome.stderr);
    let said = "Stopped by Ctrl-C: the video is left; the same command with --resume goes on";
    assert!(outcome.stdout.lines().any(|l| l == said), "'{said}' is not in\n{}", outcome.stdout);
    assert_eq!(folder.files(), ["bin", "f_0.png", "f_1.png", "scene.toml", "told"]);
}

/// Puts a shell script in the place of ffmpeg, in which `last` is the last argument, and returns the PATH to find it.
#[cfg(unix)]
fn ffmpeg(folder: &Folder, script: &str) -> String {
    use std::os::unix::fs::PermissionsExt;
    fs::create_dir(folder.at("bin")).unwrap();
    fs::write(folder.at("bin/ffmpeg"), format!("#!/bin/sh\nfor last; do :; done\n{script}\n")).unwrap();
    fs::set_permissions(folder.at("bin/ffmpeg"), fs::Permissions::from_mode(0o755)).unwrap();
    format!("{}:{}", folder.at("bin").display(), std::env::var("PATH").unwrap())
}

#[test]
fn reports_go_into_the_folder_of_the_frames() {
    let folder = moving();
    let run = |options: &str| {
        folder.run(&format!("animate scene.toml --frames 0..1 {NONE} -o new/f_%d.png {options}"));
    };
    let reports = "--stats new/s_{shard}.json --trace-file new/t_{shard}.json";
    run(&format!("--shard 3/3 {reports}"));
    assert_eq!(names(&files(&folder, "new")), ["s_3.json", "t_3.json"], "of a shard without frames");
    // What a killed run left.
    let stale = folder.at("new/.nephroid-s_1.json-a1B2c3.part");
    fs::write(&stale, "cut short").unwrap();
    run(reports);
    let wanted = ["f_0.png", "f_1.png", "s_1.json", "s_3.json", "t_1.json", "t_3.json"];
    assert_eq!(names(&files(&folder, "new")), wanted);
}

#[test]
fn what_was_not_timed_is_not_reported_as_nothing() {
    let folder = moving();
    folder.run(&format!("animate scene.toml --frames 0..1 {NONE} -o f_%d.png --stats s.json --disable timestamps"));
    let stats: serde_json::Value = serde_json::from_slice(&fs::read(folder.at("s.json")).unwrap()).unwrap();
    for split in [&stats["total"], &stats["frames"][1]["split"]] {
        assert!(split["frame"]["milliseconds"].is_null() && split["frame"]["cpu_seconds"].is_null(), "{split}");
        assert!(split["whole"]["milliseconds"].as_f64() > Some(0.0), "{split}");
    }
}

#[test]
fn a_scene_is_the_same_by_another_path() {
    let folder = moving();
    fs::create_dir(folder.at("sub")).unwrap();
    for (scene, at) in [("scene.toml", "a"), ("sub/../scene.toml", "b")] {
        folder.run(&format!("animate {scene} --frames 1 {NONE} -o {at}/f_%d.exr"));
    }
    assert!(files(&folder, "a") == files(&folder, "b"), "the path's spelling is in the file");
}

fn animate(folder: &Folder, arguments: &str) -> Command {
    folder.command(["animate", "scene.toml"].into_iter().chain(arguments.split_whitespace()))
}

#[test]
fn wrong_usage_is_refused() {
    let wanted = "wanted is one %d, or %04d and the like, in the file's name";
    for (pattern, message) in [
        ("a.exr", format!("all frames would go to one file; {wanted}")),
        ("%d_%d.exr", format!("it has 2 places for the frame's number; {wanted}")),
        ("%d/a.exr", format!("the frame's number is in a folder's name; {wanted}")),
        ("%4d.exr", format!("%4d is not known here; {wanted}, filled with zeros to 1 to 20 digits")),
        ("a%.exr", "a % is neither %d, %04d nor %%".to_owned()),
    ] {
        misused(
            &format!("--frames 0..1 -o {pattern}"),
            &format!("invalid value '{pattern}' for '--output <PATTERN>': {message}"),
        );
    }
    let wanted = "wanted are the first and the last frame, such as 0..47, or one frame";
    for (frames, message) in [
        ("3..1", format!("the last frame comes before the first; {wanted}")),
        ("-1..1", wanted.to_owned()),
        ("0..", wanted.to_owned()),
        ("all", wanted.to_owned()),
        ("0..1000000", "these are more than 1000000 frames".to_owned()),
    ] {
        misused(
            &format!("-o %d.png --frames {frames}"),
            &format!("invalid value '{frames}' for '--frames <A..B>': {message}"),
        );
    }
    for shard in ["0/2", "3/2", "2", "1/0", "-1/2", "1/1000001"] {
        let message = "wanted are the part and the number of parts, such as 1/4, at most 1000000";
        misused(
            &format!("-o %d.png --frames 0..1 --shard {shard}"),
            &format!("invalid value '{shard}' for '--shard <I/N>': {message}"),
        );
    }
    for fps in ["0", "-1", "nan", "many"] {
        let message = format!("invalid value '{fps}' for '--fps <N>': allowed are numbers from 0.01 to 1000");
        misused(&format!("-o %d.png --frames 0..1 --fps {fps}"), &message);
    }
}

fn misused(arguments: &str, message: &str) {
    let folder = Folder::new();
    let stderr = folder.refused(animate(&folder, arguments), 2);
    assert_eq!(stderr.split_once("\n\n").unwrap().0, format!("error: {message}"), "{arguments}");
}

#[test]
fn what_cannot_be_done_is_refused_before_the_first_frame() {
    let folder = Folder::new();
    let fails = |arguments: &str, sentence: &str| {
        let stderr = folder.refused(animate(&folder, &format!("--frames 0..1 {arguments}")), 1);
        assert_eq!(stderr, format!("nephroid: {sentence}\n"), "{arguments}");
    };
    fails("-o f_%d.jpg", "f_0.jpg: the file name ends in neither .exr nor .png, the formats known here");
    fs::create_dir(folder.at("f_1.png")).unwrap();
    fails("-o f_%d.png", "f_1.png: cannot be written: it is a folder");
    fails("-o new/f_%d.png --camera side", "scene.toml has no camera \"side\"; it has: above, under");
    fails("-o f_%d.exr --stats gone/s.json", "gone/s.json: cannot be written: the folder gone does not exist");
    fails("-o f_%d.exr --trace-file gone/t.json", "gone/t.json: cannot be written: the folder gone does not exist");
    fs::write(folder.at("file"), "").unwrap();
    fails("-o file/f_%d.exr", "file/f_0.exr: cannot be written: file is not a folder");
    for (arguments, path, first, second) in [
        ("-o f_%d.png -o ./f_%02d.png --frames 9..10", "./f_10.png", "--output", "--output"),
        ("-o f_%d.png --stats s.json --trace-file ./s.json", "./s.json", "--stats", "--trace-file"),
        ("-o f_%d.png --stats scene.toml", "scene.toml", "the scene", "--stats"),
        // A frame of another shard.
        ("-o f_%d.png --trace-file f_{shard}.png --shard 2/3", "f_2.png", "--trace-file", "--output"),
    ] {
        let frames = if arguments.contains("--frames") { "" } else { "--frames 0..2" };
        let stderr = folder.refused(animate(&folder, &format!("{frames} {arguments}")), 1);
        let sentence = format!("{path}: {first} and {second} name the same file; each needs its own");
        assert_eq!(stderr, format!("nephroid: {sentence}\n"), "{arguments}");
    }
    for option in ["--stats", "--trace-file"] {
        let sentence = "all shards would write this one file for";
        let rest = "put {shard} into its name, for the shard's number";
        fails(&format!("-o f_%d.exr --shard 1/2 {option} s.json"), &format!("s.json: {sentence} {option}; {rest}"));
    }
    fails("-o f_%d.exr --video v.avi", "v.avi: a video is an MP4 file; give it a name that ends in .mp4");

    let mut command = animate(&folder, "--frames 0..1 -o f_%d.exr --video v.mp4");
    let empty: PathBuf = folder.at("f_1.png");
    let stderr = folder.refused(
        {
            command.env("PATH", empty);
            command
        },
        1,
    );
    let sentence = "--video needs the program ffmpeg, which is not on the PATH; install it, or leave --video out";
    assert_eq!(stderr, format!("nephroid: {sentence}\n"));
}
