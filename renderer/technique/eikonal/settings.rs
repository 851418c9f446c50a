//! What `--set eikonal.key=value` and a scene file's `[technique.eikonal]` can say.

use super::marching::Order;
use super::{Scheme, SolverOptions, VolumeOptions};
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
        kind: SettingKind::Choice(&["planes", "sweeps", "sweeps-first"]),
        default: "planes",
        unit: "",
        help: "How optical paths are found. planes: each plane of cells from the one before, along light's way between cells. \
               sweeps: by differences of second order against the wave. sweeps-first: of first order, as in the paper",
    },
    Setting {
        key: "sides",
        kind: SettingKind::Choice(&["linear", "open"]),
        default: "linear",
        unit: "",
        help: "What comes in by the volume's sides: a wave as if the surface went on linearly, or nothing",
    },
    Setting {
        key: "shadows",
        kind: SettingKind::Choice(&["rays", "off"]),
        default: "rays",
        unit: "",
        help: "Whether things under the surface and above it shade what is behind them: by a ray back along the wave and on to \
               the light, or not, as in the paper",
    },
];

/// What a technique's volumes are made by.
pub(super) fn volume_options(settings: &Settings) -> VolumeOptions {
    VolumeOptions {
        resolution: settings.integer("resolution"),
        infinite: settings.choice("index") == "infinite",
        solver: SolverOptions {
            scheme: match settings.choice("solver") {
                "sweeps" => Scheme::Sweeps(Order::Second),
                "sweeps-first" => Scheme::Sweeps(Order::First),
                _ => Scheme::Planes,
            },
            linear: settings.choice("sides") == "linear",
            ..SolverOptions::default()
        },
        ..VolumeOptions::default()
    }
}
