//! What `--set eikonal.key=value` and a scene file's `[technique.eikonal]` can say.

use std::path::PathBuf;

use super::marching::Order;
use super::{Intensity, Marching, Scheme, SolverOptions, Spread, Start, Sum, VolumeOptions, WaveOptions};
use crate::technique::{Setting, SettingKind, Settings};

/// All of them.
pub const SETTINGS: &[Setting] = &[
    Setting {
        key: "resolution",
        kind: SettingKind::Integer { min: 8, max: 1024 },
        default: "128",
        unit: "cells",
        help: "Cells along the longest side of each light's volume, which spans what is lit below the surface",
    },
    Setting {
        key: "index",
        kind: SettingKind::Choice(&["medium", "infinite"]),
        default: "medium",
        unit: "",
        help: "Refractive index below the surface. medium: the scene's. infinite: as in the paper, whose waves leave at right \
               angles to the surface, whatever the light's direction",
    },
    Setting {
        key: "solver",
        kind: SettingKind::Choice(&["planes", "sweeps", "marching"]),
        default: "planes",
        unit: "",
        help: "How optical paths are found. planes: each plane of cells from the one before, along light's way between cells. \
               sweeps: by differences against the wave. marching: as in the paper, on the host, for comparison",
    },
    Setting {
        key: "order",
        kind: SettingKind::Choice(&["second", "first"]),
        default: "second",
        unit: "",
        help: "With solver=sweeps and marching, order of the differences; the paper's is the first",
    },
    Setting {
        key: "sides",
        kind: SettingKind::Choice(&["linear", "printed", "open"]),
        default: "linear",
        unit: "",
        help: "What comes in by the volume's sides. linear: a wave as if the surface went on linearly. printed: the same by the \
               paper's Algorithm 2, which is all that solver=marching has of it. open: nothing",
    },
    Setting {
        key: "intensity",
        kind: SettingKind::Choice(&["transport", "laplacian", "wave"]),
        default: "transport",
        unit: "",
        help: "How bright a place is. transport: irradiance, of light that goes along the wave. laplacian: as in the paper, by \
               how the wave is bent, over what flat water would let through. wave: by what a scalar wave leaves that goes through the \
               volume (section 4), which passes through focuses, and is as sharp as cells are",
    },
    Setting {
        key: "base",
        kind: SettingKind::Number { min: 0.0, max: 1000.0 },
        default: "1",
        unit: "",
        help: "With intensity=laplacian, brightness where the wave is not hollow",
    },
    Setting {
        key: "gain",
        kind: SettingKind::Number { min: 0.0, max: 100_000.0 },
        default: "0",
        unit: "",
        help: "With intensity=laplacian, brightness for a turn of the front by a radian in a cell; with wave, of what flat water \
               has (a of section 4.1); 0: 20 and 1",
    },
    Setting {
        key: "power",
        kind: SettingKind::Number { min: 0.0, max: 10.0 },
        default: "0",
        unit: "",
        help: "With intensity=laplacian, power of that turn; with wave, of the sum over flat water's (b of section 4.1); 0: 1, and \
               2 for sums that go by the root of light",
    },
    Setting {
        key: "start",
        kind: SettingKind::Choice(&["light", "printed"]),
        default: "light",
        unit: "",
        help: "How waves begin. light: next to the surface as the light's paths say, of waves in time with it. printed: of \
               solver=marching with vertices snapped to cells, of waves all at once in the surface's cells",
    },
    Setting {
        key: "sum",
        kind: SettingKind::Choice(&["squared", "absolute", "signed"]),
        default: "squared",
        unit: "",
        help: "With intensity=wave, what of it is summed up: its square, which goes by light, or as in the paper, whose sum of signed \
               values has no brightest place below the surface",
    },
    Setting {
        key: "border",
        kind: SettingKind::Integer { min: 0, max: 256 },
        default: "8",
        unit: "cells",
        help: "With intensity=wave, how wide the border is in which it is damped",
    },
    Setting {
        key: "dissipation",
        kind: SettingKind::Choice(&["off", "waves"]),
        default: "off",
        unit: "",
        help: "What becomes of light that has gone together: it stays, or below a depth waves in each plane part it again \
               (section 3.3)",
    },
    Setting {
        key: "threshold",
        kind: SettingKind::Number { min: 0.0, max: 100_000.0 },
        default: "0",
        unit: "m",
        help: "With dissipation=waves, that depth below the surface's middle height; 0: where strong hollows of it focus",
    },
    Setting {
        key: "slope",
        kind: SettingKind::Number { min: 0.0, max: 1.0 },
        default: "0",
        unit: "",
        help: "With dissipation=waves, metres across that light goes for a metre down; 0: as the surface turns it in the mean",
    },
    Setting {
        key: "shadows",
        kind: SettingKind::Choice(&["rays", "off"]),
        default: "rays",
        unit: "",
        help: "Whether things under the surface and above it shade what is behind them: by a ray back along the wave and on to \
               the light, or not, as in the paper",
    },
    Setting {
        key: "read",
        kind: SettingKind::File,
        default: NO_FILE,
        unit: "",
        help: "A file of volumes that 'nephroid volume' wrote of the same scene, in place of solving for any; what moves is not \
               followed. none: no file",
    },
];

const NO_FILE: &str = "none";

/// Where volumes are read from, if they are.
pub(super) fn file(settings: &Settings) -> Option<PathBuf> {
    Some(settings.choice("read")).filter(|&path| path != NO_FILE).map(PathBuf::from)
}

/// What a technique's volumes are made by.
pub(super) fn volume_options(settings: &Settings) -> VolumeOptions {
    let order = if settings.choice("order") == "first" { Order::First } else { Order::Second };
    let sides = settings.choice("sides");
    VolumeOptions {
        resolution: settings.integer("resolution"),
        infinite: settings.choice("index") == "infinite",
        solver: SolverOptions {
            scheme: match settings.choice("solver") {
                "sweeps" => Scheme::Sweeps(order),
                "marching" => {
                    let snapped = settings.choice("start") == "printed";
                    Scheme::Marching(Marching { order, snapped, sides: sides != "open" })
                }
                _ => Scheme::Planes,
            },
            linear: sides == "linear",
            ..SolverOptions::default()
        },
        intensity: match settings.choice("intensity") {
            "laplacian" => Intensity::Laplacian {
                base: settings.number("base"),
                gain: unless_zero(settings.number("gain"), 20.0),
                power: unless_zero(settings.number("power"), 1.0),
            },
            _ => Intensity::Transport,
        },
        spread: (settings.choice("dissipation") == "waves")
            .then(|| Spread { threshold: settings.number("threshold").into(), slope: settings.number("slope").into() }),
        wave: (settings.choice("intensity") == "wave").then(|| wave_options(settings)),
        ..VolumeOptions::default()
    }
}

fn wave_options(settings: &Settings) -> WaveOptions {
    let sum = match settings.choice("sum") {
        "absolute" => Sum::Absolute,
        "signed" => Sum::Signed,
        _ => Sum::Squared,
    };
    WaveOptions {
        start: if settings.choice("start") == "printed" { Start::AtOnce } else { Start::InTime },
        sum,
        border: settings.integer("border"),
        gain: unless_zero(settings.number("gain"), 1.0).into(),
        power: unless_zero(settings.number("power"), if sum == Sum::Squared { 1.0 } else { 2.0 }).into(),
        ..WaveOptions::default()
    }
}

fn unless_zero(value: f32, otherwise: f32) -> f32 {
    if value > 0.0 { value } else { otherwise }
}

/// What `settings` say that has no effect.
pub(super) fn useless(settings: &Settings) -> Vec<String> {
    let solver = settings.choice("solver");
    let mut said = Vec::new();
    let mut only = |changed: bool, what: &str, with: &str| {
        if changed {
            said.push(format!("eikonal.{what} is for eikonal.{with}, and has no effect"));
        }
    };
    only(settings.choice("order") == "first" && solver == "planes", "order", "solver=sweeps and marching");
    let intensity = settings.choice("intensity");
    let has_start = solver == "marching" || intensity == "wave";
    only(settings.choice("start") == "printed" && !has_start, "start=printed", "solver=marching and intensity=wave");
    only(settings.choice("sides") == "printed" && solver != "marching", "sides=printed", "solver=marching");
    only(intensity != "laplacian" && settings.number("base") != 1.0, "base", "intensity=laplacian");
    for key in ["gain", "power"] {
        only(intensity == "transport" && settings.number(key) != 0.0, key, "intensity=laplacian and wave");
    }
    only(intensity != "wave" && settings.choice("sum") != "squared", "sum", "intensity=wave");
    only(intensity != "wave" && settings.integer("border") != 8, "border", "intensity=wave");
    only(
        intensity == "wave" && settings.choice("dissipation") != "off",
        "dissipation",
        "intensity=transport and laplacian",
    );
    for key in ["threshold", "slope"] {
        only(settings.choice("dissipation") == "off" && settings.number(key) != 0.0, key, "dissipation=waves");
    }
    said
}
