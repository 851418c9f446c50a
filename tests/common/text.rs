//! Scenes as text, for several tests.

/// A floor at y = 0 and a camera 4 m above, which sees nothing else. There is no light.
pub const FLOOR: &str = r#"
[[camera]]
name = "down"
position = [0, 4, 0]
target = [0, 0, 0]
up = [0, 0, -1]
fov_y = 60
[[material]]
name = "floor"
kind = "diffuse"
albedo = 0.5
[[object]]
name = "floor"
shape = "plane"
centre = [0, 0, 0]
size = [100, 100]
material = "floor"
"#;

/// The sun, 1, 2 and 3 W/m2, straight down through a flat pane of glass a metre above a white floor, all of it in `medium`.
/// `rest` is more of the scene; `camera` says where from it is seen.
pub fn pane(camera: &str, medium: &str, rest: &str) -> String {
    format!(
        r#"
[[camera]]
name = "c"
{camera}
medium = "{medium}"
{rest}
[[medium]]
name = "glass"
index = 1.5
[[material]]
name = "floor"
kind = "diffuse"
albedo = 1
[[material]]
name = "pane"
kind = "dielectric"
front = "{medium}"
back = "glass"
[[object]]
name = "floor"
shape = "plane"
centre = [0, 0, 0]
size = [10, 10]
material = "floor"
[[object]]
name = "pane"
shape = "box"
centre = [0, 1, 0]
size = [3, 0.1, 2]
material = "pane"
[[light]]
name = "sun"
kind = "directional"
direction = [0, -1, 0]
irradiance = [1, 2, 3]
medium = "{medium}"
"#
    )
}
