//! What `--set photons.key=value` and a scene file's `[technique.photons]` can say.

use crate::technique::{Setting, SettingKind};

/// All of them.
pub const SETTINGS: &[Setting] = &[
    Setting {
        key: "photons",
        kind: SettingKind::Integer { min: 64, max: 4_000_000 },
        default: "1000000",
        unit: "photons",
        help: "Photons of a set: places on what lights see, in a grid with one photon a cell",
    },
    Setting {
        key: "reuse",
        kind: SettingKind::Integer { min: 1, max: 65_536 },
        default: "1",
        unit: "samples",
        help: "Samples that share one set of photons",
    },
    Setting {
        key: "resolution",
        kind: SettingKind::Integer { min: 16, max: 8192 },
        default: "2048",
        unit: "texels",
        help: "Texels along a side of each light's view; fewer where all views together would not fit the device",
    },
    Setting {
        key: "margin",
        kind: SettingKind::Number { min: 0.0, max: 1.0 },
        default: "0.1",
        unit: "",
        help: "Of the picture's longer side, how far the camera's view goes beyond the picture on every side",
    },
    Setting {
        key: "thickness",
        kind: SettingKind::Number { min: 0.0, max: 1000.0 },
        default: "0",
        unit: "m",
        help: "How thick what the views see is taken to be; 0: by the width of a texel where it is seen",
    },
    Setting {
        key: "march",
        kind: SettingKind::Choice(&["hierarchical", "linear"]),
        default: "hierarchical",
        unit: "",
        help: "How photons are followed over a view: over a pyramid of depths, or texel by texel as in the paper",
    },
    Setting {
        key: "end",
        kind: SettingKind::Choice(&["plane", "linear"]),
        default: "plane",
        unit: "",
        help: "Where in its texel a photon lands: on the plane of the triangle that is seen, or where depths interpolated \
               between texels meet as in the paper (Eq. 2)",
    },
    Setting {
        key: "order",
        kind: SettingKind::Choice(&["tiles", "shuffled"]),
        default: "tiles",
        unit: "",
        help: "Which photons are followed side by side: neighbours, or any, for comparison",
    },
    Setting {
        key: "points",
        kind: SettingKind::Choice(&[POINTS_AUTO, "jittered", POINTS_BLUE]),
        default: POINTS_AUTO,
        unit: "",
        help: "Where in its cell a photon starts. jittered: at random, evenly over many sets. blue: so that photons of a set keep \
               away from each other (blue noise, as in the paper), which is better for one set. auto: blue with a filter, which \
               looks at sets one by one, else jittered",
    },
    Setting {
        key: "rescue",
        kind: SettingKind::Choice(&["off", "rays"]),
        default: "off",
        unit: "",
        help: "What becomes of photons that the views lose: nothing, as in the paper, or a traced ray finishes them and \
               what lands where the camera's view shows nothing is kept in space",
    },
    Setting {
        key: "store",
        kind: SettingKind::Choice(&["texels", "splats"]),
        default: "texels",
        unit: "",
        help: "Where the flux of a photon goes that the camera sees. texels: into the one it lands in, which many sets average \
               to no blur. splats: over those round it that show its surface, so that few photons look smooth",
    },
    Setting {
        key: "footprint",
        kind: SettingKind::Number { min: 0.5, max: 8.0 },
        default: "1.5",
        unit: "pixels",
        help: "With store=splats, radius of the discs that photons are drawn as",
    },
    Setting {
        key: "area",
        kind: SettingKind::Choice(&["surface", "printed"]),
        default: "surface",
        unit: "",
        help: "Flux over the surface that a texel covers, or as the paper prints it (Eq. 3), which is wrong off the axis \
               and at an angle",
    },
    Setting {
        key: "refraction",
        kind: SettingKind::Choice(&["points", REFRACTION_SCREEN]),
        default: "points",
        unit: "",
        help: "Where the light is looked up that is seen through an interface. points: at the visible points, which are traced. \
               screen: where the first refracted ray meets what the camera sees straight ahead, marching over that, as \
               is usual where no rays are traced; albedo and direct light stay those of the points",
    },
    Setting {
        key: "roughness",
        kind: SettingKind::Number { min: 0.0, max: 1.0 },
        default: "0.3",
        unit: "",
        help: "Roughness of mirrors beyond which they are not taken for specular",
    },
    Setting {
        key: "luminance",
        kind: SettingKind::Number { min: 0.0, max: 1.0 },
        default: "0.04",
        unit: "",
        help: "Of a photon's mean flux, below which photons are followed by chance and carry more",
    },
    Setting {
        key: "steps",
        kind: SettingKind::Integer { min: 16, max: 65_536 },
        default: "16384",
        unit: "",
        help: "Steps that a photon takes over one view at the most",
    },
    Setting {
        key: "cube",
        kind: SettingKind::Number { min: 0.25, max: 64.0 },
        default: "1",
        unit: "pixels",
        help: "Least side of the cubes in space that hold the light of places which the camera's view does not show",
    },
    Setting {
        key: "denoise",
        kind: SettingKind::Choice(&[DENOISE_OFF, "spatial", DENOISE_TEMPORAL]),
        default: DENOISE_OFF,
        unit: "",
        help: "How irradiance is filtered. off: not at all; the mean of many samples has no blur, which is right for still \
               pictures. spatial: each set by itself. temporal: after it is added to what sets before it found, of frames \
               before too, for a viewer and for animations of a sample or a few a frame; a frame then depends on those \
               that were shown before it",
    },
    Setting {
        key: "history",
        kind: SettingKind::Choice(&["adaptive", "fixed"]),
        default: "adaptive",
        unit: "",
        help: "With denoise=temporal, whether the history is shortened where a set differs from it",
    },
    Setting {
        key: "alpha",
        kind: SettingKind::Number { min: 0.0, max: 1.0 },
        default: "0.2",
        unit: "",
        help: "With denoise=temporal, least share of a new set; shorter histories are plain means, and 0 makes all of them so",
    },
    Setting {
        key: "change",
        kind: SettingKind::Number { min: 0.5, max: 1000.0 },
        default: "2.5",
        unit: "deviations",
        help: "With history=adaptive, standard deviations from which on a difference shortens the history; at half as \
               many again nothing is left of it",
    },
    Setting {
        key: "levels",
        kind: SettingKind::Integer { min: 1, max: 8 },
        default: "5",
        unit: "",
        help: "With denoise, levels of the wavelet, each twice as wide as the one before",
    },
    Setting {
        key: "sigma",
        kind: SettingKind::Number { min: 0.0, max: 1000.0 },
        default: "4",
        unit: "deviations",
        help: "With denoise, how far the wavelet reaches over differences of light, in standard deviations; 0: no light is \
               filtered in space",
    },
    Setting {
        key: "normals",
        kind: SettingKind::Number { min: 0.0, max: 1000.0 },
        default: "128",
        unit: "",
        help: "With denoise, power of the cosine between normals that light is filtered across",
    },
    Setting {
        key: "planes",
        kind: SettingKind::Number { min: 0.01, max: 1000.0 },
        default: "1",
        unit: "pixels",
        help: "With denoise, how far off each other's plane places can be that light is filtered between",
    },
];

pub(super) const POINTS_AUTO: &str = "auto";
pub(super) const POINTS_BLUE: &str = "blue";
pub(super) const REFRACTION_SCREEN: &str = "screen";
pub(super) const DENOISE_OFF: &str = "off";
pub const DENOISE_TEMPORAL: &str = "temporal";
