//! What `--set reference.key=value` can say.

use crate::technique::{Setting, SettingKind};

pub const SETTINGS: &[Setting] = &[
    Setting {
        key: "photons",
        kind: SettingKind::Integer { min: 1, max: 4_000_000 },
        default: "2000000",
        unit: "photons",
        help: "Photons that leave the lights at once",
    },
    Setting {
        key: "reuse",
        kind: SettingKind::Integer { min: 1, max: 1024 },
        default: "4",
        unit: "samples",
        help: "Samples that gather from one set of photons: more of them smooth a pixel's own detail for less",
    },
    Setting {
        key: "radius",
        kind: SettingKind::Number { min: 0.1, max: 100.0 },
        default: "1",
        unit: "pixels",
        help: "First gathering radius; it shrinks as photons arrive",
    },
    Setting {
        key: "neighbours",
        kind: SettingKind::Number { min: 0.0, max: 1000.0 },
        default: "8",
        unit: "photons",
        help: "Photons that the first radius holds at least, were all spread evenly over the specular surfaces",
    },
    Setting {
        key: "alpha",
        kind: SettingKind::Number { min: 0.1, max: 0.99 },
        default: "0.67",
        unit: "",
        help: "Part of a sample's photons that is kept as the radius shrinks; lower shrinks faster",
    },
    Setting {
        key: "volume_photons",
        kind: SettingKind::Integer { min: 1, max: 4_000_000 },
        default: "2000000",
        unit: "photons",
        help: "Photons that a set leaves in media that scatter, as many on each path, at least one and at most 64",
    },
    Setting {
        key: "volume_neighbours",
        kind: SettingKind::Number { min: 0.1, max: 10000.0 },
        default: "64",
        unit: "photons",
        help: "Photons in media that the first radius holds round a camera's path, were a set spread as on surfaces",
    },
    Setting {
        key: "fresnel",
        kind: SettingKind::Choice(&["chance", "split"]),
        default: "chance",
        unit: "",
        help: "At the first interface: one branch by chance, or both with their weights (costs twice the rays)",
    },
    Setting {
        key: "paths",
        kind: SettingKind::Choice(&[
            "all",
            "once",
            "refracted",
            "refracted-once",
            "not-refracted-once",
            "reflected",
            "reflected-once",
            "mixed",
        ]),
        default: "all",
        unit: "",
        help: "Which S+ of L S+ D and L S+ V counts: any, one event, refractions only, one refraction, and so on",
    },
];

/// All path classes.
pub const ALL_CLASSES: u32 = 31;

/// The bits of `path_class` in `emit.comp.glsl`.
pub fn class_bits(paths: &str) -> u32 {
    match paths {
        "once" => 1 | 4,
        "refracted-once" => 1,
        "refracted" => 1 | 2,
        "not-refracted-once" => ALL_CLASSES & !1,
        "reflected-once" => 4,
        "reflected" => 4 | 8,
        "mixed" => 16,
        _ => ALL_CLASSES,
    }
}
