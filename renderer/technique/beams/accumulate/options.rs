//! What `--set` can tell the accumulation of beams.

use crate::technique::{Setting, SettingKind, Settings};

/// The part of the technique's table that is about accumulation.
pub const SETTINGS: &[Setting] = &[
    Setting {
        key: "area",
        kind: SettingKind::Choice(&["vertex", "beam"]),
        default: "vertex",
        unit: "",
        help: "The area that light is spread over: interpolated between the corners of a beam, which is smooth from beam to \
               beam, or each beam's own",
    },
    Setting {
        key: "shadows",
        kind: SettingKind::Choice(&["points", "edges"]),
        default: "points",
        unit: "",
        help: "Whether a visible point in a beam looks for its light by a ray of its own, or believes the edges of the beam \
               where they end on one smooth surface",
    },
    Setting {
        key: "light_angle",
        kind: SettingKind::Number { min: 0.0, max: 10.0 },
        default: "0.03",
        unit: "degrees",
        help: "Size of the lights where beams focus: no beam gets narrower than this from where it starts",
    },
];

/// Where a beam's density comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Area {
    /// The corners' area functions, interpolated: smooth across beams.
    Vertex,
    /// The beam's own cross-section.
    Beam,
}

/// Which points look for their light by a ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shadows {
    /// All of them.
    Points,
    /// Those of beams whose edges do not end on one smooth surface.
    Edges,
}

/// How beams are accumulated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    pub area: Area,
    pub shadows: Shadows,
    /// Radians.
    pub light_angle: f32,
}

impl Options {
    /// As the settings say, which hold [`SETTINGS`].
    pub fn of(settings: &Settings) -> Self {
        Options {
            area: if settings.choice("area") == "beam" { Area::Beam } else { Area::Vertex },
            shadows: if settings.choice("shadows") == "edges" { Shadows::Edges } else { Shadows::Points },
            light_angle: settings.number("light_angle").to_radians(),
        }
    }
}

impl Default for Options {
    fn default() -> Self {
        Options { area: Area::Vertex, shadows: Shadows::Points, light_angle: 0.03f32.to_radians() }
    }
}
