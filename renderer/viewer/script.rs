//! `--script`: steps that the window goes through by itself, for demonstrations and tests.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::render::MAX_SIDE;
use crate::taa;
use crate::technique::TechniqueKind;

/// The steps as `--help` and messages list them.
pub const HELP: &str = "\
A script has one step a line; # begins a comment:
  technique NAME       as --technique
  set T.KEY=VALUE      as --set
  camera NAME          looks through a camera of the scene
  turn X Y             orbits by X and Y heights of the picture, moving
  frame N              goes to a frame of the animation
  exposure STOPS       brightens or darkens the picture
  taa N                makes a picture of N while things move; 'taa off' ends it
  size WxH             renders pictures of that size
  window WxH           gives the window that size
  split NAME           shows that technique beside the first; 'split off' ends it
  heat LAYER           shows the error of a layer of --truth; 'heat off' ends it
  wait N               until the picture has N samples, and no more are rendered
  screenshot FILE      writes the picture, .png or .exr
  capture FILE         writes the whole window, .png
  minimise, restore    the window
  quit                 closes the window";

/// One line.
#[derive(Debug, Clone, PartialEq)]
pub enum Step {
    Technique(TechniqueKind),
    Set(String),
    Camera(String),
    Turn(f32, f32),
    Frame(u32),
    Exposure(f32),
    /// 1 for none but itself.
    Taa(u32),
    Size(u32, u32),
    Window(u32, u32),
    Split(Option<TechniqueKind>),
    Heat(Option<String>),
    Wait(u32),
    Screenshot(PathBuf),
    Capture(PathBuf),
    Minimise,
    Restore,
    Quit,
}

/// Why a script cannot be followed.
#[derive(Debug, Error)]
pub enum ScriptError {
    #[error("{path}: cannot be read: {reason}")]
    Read { path: PathBuf, reason: String },
    #[error("{path}, line {line}: {reason}")]
    Line { path: PathBuf, line: usize, reason: String },
}

/// The steps to come, each with its line.
#[derive(Debug, Default)]
pub struct Script {
    pub steps: VecDeque<(usize, Step)>,
    pub path: PathBuf,
}

impl Script {
    /// # Errors
    /// A file that cannot be read, or the first line that is no step.
    pub fn read(path: &Path) -> Result<Self, ScriptError> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| ScriptError::Read { path: path.to_owned(), reason: error.to_string() })?;
        let mut steps = VecDeque::new();
        for (line, text) in (1..).zip(text.lines()) {
            let text = text.split('#').next().unwrap_or_default().trim();
            if !text.is_empty() {
                let step = parse(text).map_err(|reason| ScriptError::Line { path: path.to_owned(), line, reason })?;
                steps.push_back((line, step));
            }
        }
        Ok(Script { steps, path: path.to_owned() })
    }

    /// An error at a line of it.
    pub fn error(&self, line: usize, reason: String) -> ScriptError {
        ScriptError::Line { path: self.path.clone(), line, reason }
    }
}

fn parse(text: &str) -> Result<Step, String> {
    let (name, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    let rest = rest.trim();
    let need = |what: &str| match rest {
        "" => Err(format!("'{name}' needs {what}")),
        rest => Ok(rest),
    };
    let number = |text: &str, what: &str| text.parse::<u32>().map_err(|_| format!("'{text}' is not {what}"));
    let real = |text: &str| {
        text.parse::<f32>().ok().filter(|x| x.is_finite()).ok_or_else(|| format!("'{text}' is not a number"))
    };
    let technique = |text: &str| TechniqueKind::parse(text).map_err(|error| error.to_string());
    let off = |text: &str| (text != "off").then(|| text.to_string());
    Ok(match name {
        "technique" => Step::Technique(technique(need("the name of a technique")?)?),
        "set" => Step::Set(need("technique.key=value")?.to_string()),
        "camera" => Step::Camera(need("the name of a camera")?.to_string()),
        "turn" => {
            let words: Vec<&str> = need("two numbers")?.split_whitespace().collect();
            let [x, y] = words[..] else { return Err("'turn' needs two numbers".to_string()) };
            Step::Turn(real(x)?, real(y)?)
        }
        "frame" => Step::Frame(number(need("a frame's number")?, "a frame's number")?),
        "exposure" => Step::Exposure(real(need("stops")?)?),
        "taa" => Step::Taa(match off(need("a number of frames, or off")?) {
            None => 1,
            Some(text) => match number(&text, "a number of frames")? {
                frames if taa::FRAMES.contains(&frames) => frames,
                _ => {
                    let (least, most) = (taa::FRAMES.start(), taa::FRAMES.end());
                    return Err(format!("'{text}' is out of range; a picture is made of {least} to {most} frames"));
                }
            },
        }),
        "size" | "window" => {
            let (width, height) = need("width x height, such as 640x480")?
                .split_once('x')
                .ok_or_else(|| format!("'{rest}' is not width x height, such as 640x480"))?;
            let side = |text| number(text, "a number of pixels");
            let (width, height) = (side(width)?, side(height)?);
            if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
                return Err(format!("'{rest}' is out of range; each side is from 1 to {MAX_SIDE} pixels"));
            }
            if name == "size" { Step::Size(width, height) } else { Step::Window(width, height) }
        }
        "split" => Step::Split(off(need("the name of a technique, or off")?).map(|name| technique(&name)).transpose()?),
        "heat" => Step::Heat(off(need("the name of a layer, or off")?)),
        "wait" => Step::Wait(number(need("a number of samples")?, "a number of samples")?),
        "screenshot" => Step::Screenshot(need("a file to write")?.into()),
        "capture" => Step::Capture(need("a file to write")?.into()),
        "minimise" => Step::Minimise,
        "restore" => Step::Restore,
        "quit" => Step::Quit,
        other => {
            return Err(format!("'{other}' is no step; 'nephroid view --help' lists the steps"));
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_read_and_others_refused() {
        assert_eq!(parse("technique mnee"), Ok(Step::Technique(TechniqueKind::Mnee)));
        assert_eq!(parse("size 320x240"), Ok(Step::Size(320, 240)));
        assert_eq!(parse("turn 0.5 -0.25"), Ok(Step::Turn(0.5, -0.25)));
        assert_eq!(parse("turn\t1\t  2"), Ok(Step::Turn(1.0, 2.0)));
        assert_eq!(parse("split off"), Ok(Step::Split(None)));
        assert_eq!(parse("taa 8"), Ok(Step::Taa(8)));
        assert_eq!(parse("taa off"), Ok(Step::Taa(1)));
        for (line, message) in [
            ("jump", "'jump' is no step"),
            ("wait", "'wait' needs a number of samples"),
            ("wait x", "'x' is not a number of samples"),
            ("size 0x5", "out of range"),
            ("taa 1", "made of 2 to 64 frames"),
            ("technique glass", "there is no technique \"glass\""),
        ] {
            let refused = parse(line).unwrap_err();
            assert!(refused.contains(message), "{refused}");
        }
    }
}
