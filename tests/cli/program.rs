//! The binary as a user meets it: run in a folder of its own that holds a small scene.

use std::ffi::OsStr;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

/// A spot light on a square pond and a raft, which alone is lit directly; seen from above and from within.
pub const SCENE: &str = r#"
[film]
width = 16
height = 12
samples = 2

[[camera]]
name = "above"
position = [0, 3, 3]
target = [0, -1, 0]

[[camera]]
name = "under"
position = [0, -0.5, 1]
target = [0, -1, 0]
medium = "water"

[[medium]]
name = "water"
index = 1.33

[[material]]
name = "floor"
kind = "diffuse"
albedo = 0.8

[[material]]
name = "surface"
kind = "dielectric"
back = "water"

[[object]]
name = "floor"
shape = "plane"
centre = [0, -1, 0]
size = [4, 4]
material = "floor"

[[object]]
name = "pond"
shape = "heightfield"
x = [-2, 2]
z = [-2, 2]
quads = 1
material = "surface"

[[object]]
name = "raft"
shape = "box"
size = [1, 0.2, 1]
material = "floor"

[[light]]
name = "lamp"
kind = "spot"
position = [0.5, 3, 0]
target = [0, 0, 0]
intensity = 10
outer = 30
"#;

/// What stands at `kept.exr` before a command that must not touch it.
pub const KEPT: &[u8] = b"an earlier picture";

/// A folder with `scene.toml`, in which the binary runs.
pub struct Folder(TempDir);

impl Folder {
    pub fn new() -> Self {
        let folder = Folder(tempfile::tempdir().unwrap());
        fs::write(folder.at("scene.toml"), SCENE).unwrap();
        folder
    }

    pub fn at(&self, name: &str) -> PathBuf {
        // Where the temporary folder is behind a link, the program prints what the link leads to.
        self.0.path().canonicalize().unwrap().join(name)
    }

    /// Names in the folder, sorted.
    pub fn files(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    pub fn command<S: AsRef<OsStr>>(&self, arguments: impl IntoIterator<Item = S>) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_nephroid"));
        command.args(arguments).current_dir(self.at("")).env_remove("NEPHROID_DEVICE").stdin(Stdio::null());
        command
    }

    /// Runs `nephroid` with arguments split at blanks, which must succeed.
    pub fn run(&self, arguments: &str) -> Outcome {
        let outcome = Outcome::of(self.command(arguments.split_whitespace()).output().unwrap());
        assert_eq!(outcome.status, Some(0), "nephroid {arguments}\n{}{}", outcome.stdout, outcome.stderr);
        outcome
    }

    /// In the order of their indices.
    pub fn device_names(&self) -> Vec<String> {
        let devices: Vec<serde_json::Value> = serde_json::from_str(&self.run("devices --json").stdout).unwrap();
        devices.iter().map(|device| device["name"].as_str().unwrap().to_owned()).collect()
    }

    /// Runs a command that must fail with `status` and leave the folder as it is.
    pub fn refused(&self, mut command: Command, status: i32) -> String {
        fs::write(self.at("kept.exr"), KEPT).unwrap();
        let before = self.files();
        let outcome = Outcome::of(command.output().unwrap());
        assert_eq!(outcome.status, Some(status), "{command:?}\n{}{}", outcome.stdout, outcome.stderr);
        assert_eq!(outcome.stdout, "", "{command:?}");
        assert_eq!(self.files(), before, "{command:?} left files behind");
        assert_eq!(fs::read(self.at("kept.exr")).unwrap(), KEPT, "{command:?}");
        outcome.stderr
    }
}

pub struct Outcome {
    pub status: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Outcome {
    pub fn of(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Outcome { status: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }
}
