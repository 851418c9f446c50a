//! Motion vectors against closed forms: where a camera a frame ago saw the point that is seen now.

mod common;

use std::path::Path;
use std::process::ExitCode;

use common::{Case, Request, assert_valid};
use glam::{DVec2, DVec3, Vec3Swizzles};
use nephroid::image::LayeredImage;
use nephroid::render::RenderSettings;
use nephroid::scene::animation::WaterMotion;
use nephroid::scene::{self, Scene};
use nephroid::technique::TechniqueKind;

/// Pixels.
const TOLERANCE: f64 = 0.01;
/// Pixels: what moves, moves farther than this somewhere.
const FAR: f64 = 0.5;
const SIZE: (u32, u32) = (48, 36);

fn main() -> ExitCode {
    common::run(&[
        Case { name: "a_camera_that_moves_over_what_stands", needs: &[], disable: "", run: camera_moves },
        Case { name: "an_object_that_moves_before_a_camera_that_stands", needs: &[], disable: "", run: object_moves },
        Case { name: "water_that_rises", needs: &[], disable: "", run: water_rises },
        Case { name: "a_frame_alone_has_the_vectors_of_its_row", needs: &[], disable: "", run: frame_alone },
    ])
}

/// A floor before a camera that looks down at it, past its edge; `%camera`, `%floor` and `%more` are filled in.
const SCENE: &str = r#"
[animation]
fps = 10
[film]
background = [0.1, 0.1, 0.1]
[[camera]]
name = "eye"
position = [0, 3, 4]
target = [0, 0, 0]
fov_y = 50
%camera
[[material]]
name = "grey"
kind = "diffuse"
albedo = 0.5
[[object]]
name = "floor"
%floor
material = "grey"
[[light]]
name = "lamp"
kind = "point"
position = [0, 4, 0]
intensity = 10
"#;

const PLANE: &str = "shape = \"plane\"\nsize = [6, 5]\nsubdivisions = [3, 2]\n";

fn parse(camera: &str, floor: &str) -> Scene {
    scene::parse(&SCENE.replace("%camera", camera).replace("%floor", floor), Path::new("test.toml")).unwrap()
}

fn settings(request: &Request, frame: u32) -> RenderSettings {
    RenderSettings {
        device: request.device.clone(),
        trace: "bvh".parse().unwrap(),
        technique: TechniqueKind::None,
        size: Some(SIZE),
        samples: Some(1),
        frame,
        motion: true,
        ..Default::default()
    }
}

/// The vectors of a frame.
fn vectors(request: &Request, scene: &Scene, frame: u32) -> Vec<DVec2> {
    let renderer = request.renderer(scene.clone(), &settings(request, frame));
    let picture = renderer.finish().unwrap();
    assert_valid(renderer.device());
    motion(&picture.image)
}

fn motion(image: &LayeredImage) -> Vec<DVec2> {
    let layer = image.layer("motion").unwrap();
    let (x, y) = (layer.channel("X").unwrap(), layer.channel("Y").unwrap());
    x.iter().zip(y).map(|(x, y)| DVec2::new((*x).into(), (*y).into())).collect()
}

/// A pinhole in f64.
#[derive(Clone, Copy)]
struct Eye {
    position: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
}

impl Eye {
    fn new(position: DVec3, target: DVec3) -> Eye {
        let forward = (target - position).normalize();
        let right = forward.cross(DVec3::Y).normalize();
        Eye { position, forward, right, up: right.cross(forward) }
    }

    /// Pixels from the picture's middle to the edge of a square of 90 degrees.
    fn scale() -> f64 {
        0.5 * f64::from(SIZE.1) / 25f64.to_radians().tan()
    }

    fn middle() -> DVec2 {
        0.5 * DVec2::new(SIZE.0.into(), SIZE.1.into())
    }

    fn ray(&self, pixel: DVec2) -> DVec3 {
        let at = (pixel - Eye::middle()) / Eye::scale();
        self.forward + at.x * self.right - at.y * self.up
    }

    /// Where a point at `way` from the eye is seen, pixels.
    fn sees(&self, way: DVec3) -> DVec2 {
        Eye::middle() + Eye::scale() * DVec2::new(way.dot(self.right), -way.dot(self.up)) / way.dot(self.forward)
    }
}

fn pixels() -> impl Iterator<Item = DVec2> {
    (0..SIZE.1).flat_map(|row| (0..SIZE.0).map(move |column| DVec2::new(column.into(), row.into()) + 0.5))
}

/// Compares with `expected` of each pixel; `None` where rounding decides what is seen.
fn compare(found: &[DVec2], expected: impl Fn(DVec2) -> Option<DVec2>) {
    let mut farthest = 0.0f64;
    for (pixel, found) in pixels().zip(found) {
        let Some(expected) = expected(pixel) else { continue };
        assert!((*found - expected).length() < TOLERANCE, "pixel {pixel}: {found} instead of {expected}");
        farthest = farthest.max(expected.length());
    }
    assert!(farthest > FAR, "nothing moved farther than {farthest} pixels");
}

/// On the plane y = 0, inside or outside of the rectangle by more than a pixel.
fn on_floor(point: DVec3, centre: DVec3) -> Option<bool> {
    let from_edge = (DVec2::new(3.0, 2.5) - (point - centre).xz().abs()).min_element();
    (from_edge.abs() > 0.05).then_some(from_edge > 0.0)
}

fn camera_moves(request: &Request) {
    // Half of the keys' way at frame 1, all of it at frame 2.
    let camera = "interpolation = \"linear\"\nkeys = [{ time = 0 }, { time = 0.2, position = [0.6, 3.2, 4], target = [0.4, 0.3, 0.3] }]";
    let scene = parse(camera, PLANE);
    let eye = |part: f64| Eye::new(DVec3::new(0.6 * part, 3.0 + 0.2 * part, 4.0), part * DVec3::new(0.4, 0.3, 0.3));
    for frame in [1, 2] {
        let (now, before) = (eye(0.5 * f64::from(frame)), eye(0.5 * f64::from(frame - 1)));
        let mut seen = [0, 0];
        let found = vectors(request, &scene, frame);
        compare(&found, |pixel| {
            let ray = now.ray(pixel);
            let point = now.position - now.position.y / ray.y * ray;
            let floor = ray.y < 0.0 && on_floor(point, DVec3::ZERO)?;
            Some(pixel - before.sees(if floor { point - before.position } else { ray }))
        });
        for pixel in pixels() {
            let ray = now.ray(pixel);
            let point = now.position - now.position.y / ray.y * ray;
            seen[usize::from(ray.y < 0.0 && on_floor(point, DVec3::ZERO) == Some(true))] += 1;
        }
        assert!(seen[0] > 100 && seen[1] > 100, "{seen:?}");
    }
    assert!(vectors(request, &scene, 0).iter().all(|vector| *vector == DVec2::ZERO));
    assert!(vectors(request, &scene, 5).iter().all(|vector| *vector == DVec2::ZERO));
}

fn object_moves(request: &Request) {
    let floor = format!(
        "{PLANE}interpolation = \"linear\"\nkeys = [{{ time = 0 }}, {{ time = 0.2, translate = [0.4, 0.5, -0.2] }}]"
    );
    let scene = parse("", &floor);
    let eye = Eye::new(DVec3::new(0.0, 3.0, 4.0), DVec3::ZERO);
    let step = 0.5 * DVec3::new(0.4, 0.5, -0.2);
    compare(&vectors(request, &scene, 2), |pixel| {
        let ray = eye.ray(pixel);
        let point = eye.position + (2.0 * step.y - eye.position.y) / ray.y * ray;
        let floor = ray.y < 0.0 && on_floor(point, 2.0 * step)?;
        Some(if floor { pixel - eye.sees(point - step - eye.position) } else { DVec2::ZERO })
    });
}

fn water_rises(request: &Request) {
    // So long a wave that the sheet rises and sinks nearly level.
    let floor = "shape = \"heightfield\"\nx = [-4, 4]\nz = [-4, 3]\nquads = 4\n\
                 waves = [{ wavelength = 2e4, amplitude = 50 }]\nmotion = { kind = \"waves\" }";
    let scene = parse("", floor);
    let water = scene.animation.waters[0].clone();
    assert_eq!(water.motion, WaterMotion::Waves { depth: None });
    let eye = Eye::new(DVec3::new(0.0, 3.0, 4.0), DVec3::ZERO);
    let frame = 3;
    let [now, before] = [0.3, 0.2].map(|time| water.field.at(None, time));
    let rise = now.height(0.0, 0.0) - before.height(0.0, 0.0);
    assert!(rise.abs() > 0.1, "{rise} m");
    compare(&vectors(request, &scene, frame), |pixel| {
        let ray = eye.ray(pixel);
        let mut point = DVec3::ZERO;
        for _ in 0..20 {
            point = eye.position + (now.height(point.x, point.z) - eye.position.y) / ray.y * ray;
        }
        let inside = (DVec2::new(4.0, 3.0) - DVec2::new(point.x.abs(), point.z)).min_element();
        let seen = ray.y < 0.0 && inside > 0.05 && point.z > -3.95;
        let was = point.with_y(before.height(point.x, point.z));
        seen.then(|| pixel - eye.sees(was - eye.position))
    });
}

fn frame_alone(request: &Request) {
    const FRAME: u32 = 4;
    let floor = "shape = \"heightfield\"\nx = [-3, 3]\nz = [-3, 2]\nquads = 32\n\
                 bumps = [{ centre = [0, 0], height = 0.3, radius = 0.4 }]\nmotion = { kind = \"simulated\", speed = 3 }";
    let camera = "keys = [{ time = 0 }, { time = 1, position = [0.6, 3.2, 4] }]";
    let scene = parse(camera, floor);
    let alone = vectors(request, &scene, FRAME);
    assert!(alone.iter().any(|vector| vector.length() > 0.05));
    let mut row = request.renderer(scene.clone(), &settings(request, 0));
    // In a row, again, by a jump from behind, and by one from before.
    for frames in [&[1, 2, 3, FRAME][..], &[FRAME], &[9, FRAME], &[1, FRAME]] {
        for &frame in frames {
            row.go_to(frame).unwrap();
        }
        assert!(motion(&row.finish().unwrap().image) == alone, "{frames:?}");
    }
    assert_valid(row.device());
}
