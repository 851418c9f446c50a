//! What `--set beams.key=value` and a scene file's `[technique.beams]` can say.

use super::accumulate;
use crate::technique::{Setting, SettingKind};

/// All of them.
pub const SETTINGS: &[Setting] = &{
    let mut all = [GENERATION[0]; GENERATION.len() + accumulate::SETTINGS.len()];
    let mut index = 0;
    while index < all.len() {
        let own = index < GENERATION.len();
        all[index] = if own { GENERATION[index] } else { accumulate::SETTINGS[index - GENERATION.len()] };
        index += 1;
    }
    all
};

const ON_OFF: SettingKind = SettingKind::Choice(&["on", "off"]);

/// How beams are made.
const GENERATION: &[Setting] = &[
    Setting {
        key: "grid",
        kind: SettingKind::Integer { min: 2, max: 64 },
        default: "16",
        unit: "cells",
        help: "Cells along a side of the coarse grid over what a light sees",
    },
    Setting {
        key: "levels",
        kind: SettingKind::Integer { min: 0, max: 8 },
        default: "4",
        unit: "",
        help: "How often a cell can be split in four",
    },
    Setting {
        key: "least_level",
        kind: SettingKind::Integer { min: 0, max: 8 },
        default: "1",
        unit: "",
        help: "How often every cell is split, whatever the rules say",
    },
    Setting {
        key: "vertices",
        kind: SettingKind::Integer { min: 1024, max: 4_194_304 },
        default: "524288",
        unit: "",
        help: "Room for vertices of the refined grids; 2 kB each, 3 with light scattered in grids of density; no kind of record takes more than the device's storage range",
    },
    Setting {
        key: "bounces",
        kind: SettingKind::Integer { min: 1, max: 4 },
        default: "3",
        unit: "surfaces",
        help: "Specular surfaces that light is followed over, reflected and refracted at each",
    },
    Setting {
        key: "reuse",
        kind: SettingKind::Integer { min: 1, max: 65_536 },
        default: "4",
        unit: "samples",
        help: "Samples that share one set of beams; the next set is cut from a grid that has moved",
    },
    Setting {
        key: "jitter",
        kind: ON_OFF,
        default: "on",
        unit: "",
        help: "Whether grids move from set to set, which averages out where beams begin and end",
    },
    Setting {
        key: "light",
        kind: SettingKind::Choice(&["rays", "raster", "cast"]),
        default: "rays",
        unit: "",
        help: "How what a light sees first is found: by a ray for each vertex that there is, or before in a buffer of all places \
               where one can be, rastered where the device can or ray cast; grids do not move then",
    },
    Setting {
        key: "split_surface",
        kind: ON_OFF,
        default: "on",
        unit: "",
        help: "Split beams over discontinuities of what they leave or meet",
    },
    Setting {
        key: "normal",
        kind: SettingKind::Number { min: 0.1, max: 180.0 },
        default: "30",
        unit: "degrees",
        help: "Angle between the normals at two edges that makes a discontinuity",
    },
    Setting {
        key: "depth",
        kind: SettingKind::Number { min: 0.001, max: 1000.0 },
        default: "0.3",
        unit: "",
        help: "Difference of two edges' lengths over the shorter that makes a discontinuity",
    },
    Setting { key: "split_energy", kind: ON_OFF, default: "on", unit: "", help: "Split beams that focus light" },
    Setting {
        key: "convergence",
        kind: SettingKind::Number { min: -10.0, max: 1.0 },
        default: "0.5",
        unit: "",
        help: "Cross-section at the end over the one at the start below which a beam focuses; negative: turned over",
    },
    Setting {
        key: "energy",
        kind: SettingKind::Number { min: 0.0, max: 1.0 },
        default: "0.0001",
        unit: "",
        help: "Of its coarse cell's light, what a beam has to carry to be split for focus or deviation",
    },
    Setting {
        key: "split_camera",
        kind: ON_OFF,
        default: "on",
        unit: "",
        help: "Split nearer beams more: none that is narrower than `pixels`",
    },
    Setting {
        key: "pixels",
        kind: SettingKind::Number { min: 0.0, max: 1000.0 },
        default: "0.3",
        unit: "pixels",
        help: "Width, as seen at the point of the beam's central ray nearest to the camera, below which no beam is split",
    },
    Setting {
        key: "split_light",
        kind: ON_OFF,
        default: "on",
        unit: "",
        help: "Split beams over the light's own pattern: cones' edges and projected images",
    },
    Setting {
        key: "pattern",
        kind: SettingKind::Number { min: 0.001, max: 1.0 },
        default: "0.3",
        unit: "",
        help: "Difference of the light's power at two edges over the larger above which its pattern splits a beam",
    },
    Setting { key: "split_deviation", kind: ON_OFF, default: "on", unit: "", help: "Split beams whose sides bend" },
    Setting {
        key: "deviation",
        kind: SettingKind::Number { min: 0.001, max: 1000.0 },
        default: "0.2",
        unit: "pixels",
        help: "How far the middle between two edges may land beside the mean of theirs",
    },
    Setting {
        key: "cutoff",
        kind: SettingKind::Number { min: 0.0, max: 1.0 },
        default: "0.001",
        unit: "",
        help: "Of the light's power: weaker branches are not followed",
    },
    Setting {
        key: "extent",
        kind: SettingKind::Number { min: 0.0, max: 1.0 },
        default: "0",
        unit: "",
        help: "Of the fluence at its start, below which a beam that meets nothing ends; 0: as far as any light is followed",
    },
];
