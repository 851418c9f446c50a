//! What `--set` can tell the accumulation of beams.

use crate::technique::{Setting, SettingKind, Settings};

/// The part of the technique's table that is about accumulation.
pub const SETTINGS: &[Setting] = &[
    Setting {
        key: "accumulate",
        kind: SettingKind::Choice(&["auto", "geometry", "vertices", "compute"]),
        default: "auto",
        unit: "",
        help: "What finds the beams at a pixel: hulls drawn by a rasteriser, made by a geometry stage or by a kernel, or tiles \
               of pixels that look for theirs; auto: tiles",
    },
    Setting {
        key: "bounds",
        kind: SettingKind::Choice(&["six", "prism"]),
        default: "six",
        unit: "",
        help: "The hulls: six sides that touch both ends of a beam, or those of a prism cut off by its ends",
    },
    Setting {
        key: "area",
        kind: SettingKind::Choice(&["vertex", "beam"]),
        default: "vertex",
        unit: "",
        help: "The area that light is spread over: interpolated between the corners of a beam, at each the one of all beams round \
               it, which is smooth from beam to beam; or each beam's own",
    },
    Setting {
        key: "footprint",
        kind: SettingKind::Choice(&["pixel", "point"]),
        default: "pixel",
        unit: "",
        help: "What of a surface a sample looks at: all that its pixel covers, which needs few samples where light is thinner \
               than a pixel, or a point; with --adaptive always a point",
    },
    Setting {
        key: "filter",
        kind: SettingKind::Number { min: 0.0, max: 16.0 },
        default: "0",
        unit: "pixels",
        help: "Standard deviation by which light on surfaces is spread over pixels that see the same surface, for beams that \
               are few and have areas of their own; 0: not at all; not with --adaptive",
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
        key: "interval",
        kind: SettingKind::Choice(&["exact", "scan-plane"]),
        default: "exact",
        unit: "",
        help: "Where a view ray is inside a beam: between its bilinear sides, or by a plane through the ray that takes them \
               for straight, as the paper does",
    },
    Setting {
        key: "integral",
        kind: SettingKind::Choice(&["closed", "adaptive", "midpoint"]),
        default: "closed",
        unit: "",
        help: "The light scattered within that interval: with the beam's area in closed form, by more and more points, or by \
               the one in the middle, as the paper does",
    },
    Setting {
        key: "soft",
        kind: SettingKind::Number { min: 0.0, max: 1e6 },
        default: "0",
        unit: "m",
        help: "Volume light fades within this of the surface behind it; 0 for none, which is exact",
    },
    Setting {
        key: "light_angle",
        kind: SettingKind::Number { min: 0.0, max: 10.0 },
        default: "0.03",
        unit: "degrees",
        help: "Size of the lights where beams focus: no beam gets narrower than this from where it starts",
    },
];

/// What finds the beams at a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tier {
    /// Hulls that a geometry stage makes.
    Geometry,
    /// Hulls that a kernel makes.
    Vertices,
    /// Tiles that look for their beams; without graphics.
    Compute,
}

/// What a rasteriser draws in a beam's place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bounds {
    /// Six sides, edge by edge (Liktor and Dachsbacher 2011); prisms where that is not certain.
    Six,
    /// Prisms (Ernst et al. 2005).
    Prism,
}

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

/// How a view ray's interval in a beam is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interval {
    /// By the bilinear sides, which neighbours share.
    Exact,
    /// By a plane through the ray (Ernst et al. 2005).
    ScanPlane,
}

/// How what is scattered within the interval is added up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Integral {
    Closed,
    Adaptive,
    Midpoint,
}

/// How beams are accumulated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// `None`: [`Tier::Compute`], which was the quickest on both software drivers.
    pub tier: Option<Tier>,
    pub bounds: Bounds,
    pub area: Area,
    pub shadows: Shadows,
    /// What a pixel covers, not its point.
    pub footprints: bool,
    /// Pixels: standard deviation of the low-pass filter on surfaces; 0 for none.
    pub filter: f32,
    pub interval: Interval,
    pub integral: Integral,
    /// m before a surface within which volume light fades.
    pub soft: f32,
    /// Radians.
    pub light_angle: f32,
}

impl Options {
    /// As the settings say, which hold [`SETTINGS`].
    pub fn of(settings: &Settings) -> Self {
        Options {
            tier: match settings.choice("accumulate") {
                "geometry" => Some(Tier::Geometry),
                "vertices" => Some(Tier::Vertices),
                "compute" => Some(Tier::Compute),
                _ => None,
            },
            bounds: if settings.choice("bounds") == "prism" { Bounds::Prism } else { Bounds::Six },
            area: if settings.choice("area") == "beam" { Area::Beam } else { Area::Vertex },
            shadows: if settings.choice("shadows") == "edges" { Shadows::Edges } else { Shadows::Points },
            interval: if settings.choice("interval") == "scan-plane" { Interval::ScanPlane } else { Interval::Exact },
            integral: match settings.choice("integral") {
                "midpoint" => Integral::Midpoint,
                "adaptive" => Integral::Adaptive,
                _ => Integral::Closed,
            },
            soft: settings.number("soft"),
            light_angle: settings.number("light_angle").to_radians(),
            footprints: settings.choice("footprint") == "pixel",
            filter: settings.number("filter"),
        }
    }
}

impl Options {
    /// What the settings say where nothing is set.
    pub const DEFAULT: Options = Options {
        tier: None,
        bounds: Bounds::Six,
        area: Area::Vertex,
        shadows: Shadows::Points,
        footprints: true,
        filter: 0.0,
        interval: Interval::Exact,
        integral: Integral::Closed,
        soft: 0.0,
        light_angle: 0.03f32.to_radians(),
    };
}

impl Default for Options {
    fn default() -> Self {
        Self::DEFAULT
    }
}
