//! A scene of sheets of water that move, without a picture; and closed forms of the wave equation.

use glam::{DVec2, DVec3};
use nephroid::animate::Animator;
use nephroid::gpu::Device;
use nephroid::gpu_scene::{GpuScene, Vertex};
use nephroid::scene::animation::{Drop, Simulation, Water, WaterMotion};
use nephroid::scene::height_field::HeightField;
use nephroid::scene::{self, Mesh, MeshId, Scene};

use crate::common::{Request, assert_valid};

const EMPTY: &str = r#"
[[camera]]
name = "above"
position = [0, 5, 0.1]
target = [0, 0, 0]
[[material]]
name = "grey"
kind = "diffuse"
albedo = 0.5
[[object]]
name = "first"
shape = "plane"
size = [1, 1]
material = "grey"
[[object]]
name = "last"
shape = "sphere"
radius = 1
segments = 12
material = "grey"
[[light]]
name = "lamp"
kind = "point"
position = [0, 4, 0]
intensity = 1
"#;

/// Sheets of water on a device, between two meshes that stay.
pub struct Stage {
    pub scene: Scene,
    device: Device,
    gpu_scene: GpuScene,
    animator: Animator,
}

impl Stage {
    pub fn new(request: &Request, waters: &[(HeightField, WaterMotion)], fps: f64) -> Stage {
        let device = request.open();
        let mut scene = scene::parse(EMPTY, std::path::Path::new("test.toml")).unwrap();
        scene.animation.fps = fps;
        for (index, (field, motion)) in waters.iter().enumerate() {
            scene.meshes.insert(1 + index, field.mesh("water"));
            let water = Water { mesh: 1 + index, field: field.clone(), motion: motion.clone() };
            scene.animation.waters.push(water);
            // The sphere's.
            scene.instances[1].mesh += 1;
        }
        let gpu_scene = GpuScene::new(&device, &scene).unwrap();
        let animator = Animator::new(&device, &scene, &gpu_scene).unwrap();
        Stage { scene, device, gpu_scene, animator }
    }

    pub fn go_to(&mut self, frame: u32) -> Vec<MeshId> {
        let moved = self.animator.go_to(frame, &mut self.scene, &mut self.gpu_scene).unwrap();
        self.animator.followed();
        assert_valid(&self.device);
        moved.meshes
    }

    pub fn mesh_id(&self, water: usize) -> MeshId {
        self.scene.animation.waters[water].mesh
    }

    pub fn mesh_of<'a>(&self, scene: &'a Scene, water: usize) -> &'a Mesh {
        &scene.meshes[self.mesh_id(water)]
    }

    pub fn mesh(&self, water: usize) -> &Mesh {
        self.mesh_of(&self.scene, water)
    }

    /// All vertices on the device, which are to be those of the scene.
    pub fn assert_host_is_device(&self) -> Vec<Vertex> {
        let count = self.scene.meshes.iter().map(|mesh| mesh.positions.len()).sum();
        let vertices: Vec<Vertex> = self.gpu_scene.vertices.read(count).unwrap();
        let host = self.scene.meshes.iter().flat_map(|mesh| {
            (0..mesh.positions.len()).map(|i| Vertex {
                position: mesh.positions[i].to_array(),
                u: mesh.uvs[i].x,
                normal: mesh.normals[i].to_array(),
                v: mesh.uvs[i].y,
            })
        });
        assert!(host.eq(vertices.iter().copied()));
        vertices
    }
}

/// 2.4 by 2 metres round the origin, flat.
pub fn still_sheet(quads: [u32; 2]) -> HeightField {
    HeightField { x: [-1.2, 1.2], z: [-1.0, 1.0], quads, base: 0.0, waves: Vec::new(), bumps: Vec::new(), relief: None }
}

pub fn simulation(speed: f64) -> Simulation {
    Simulation { speed, damping: 0.0, drops: Vec::new(), rain: None }
}

pub fn within_walls() -> WaterMotion {
    WaterMotion::Simulated(simulation(1.0))
}

pub fn drop(time: f64, height: f64) -> Drop {
    Drop { time, centre: DVec2::new(0.3, 0.1), height, radius: 0.1 }
}

/// By central differences of the mesh's heights, which go on mirrored behind the walls.
pub fn normal_by_differences(field: &HeightField, mesh: &Mesh, index: usize) -> DVec3 {
    let [columns, rows] = field.quads.map(|quads| quads as usize + 1);
    let (column, row) = (index % columns, index / columns);
    let height = |column: usize, row: usize| f64::from(mesh.positions[row * columns + column].y);
    let inside = |at: usize, count: usize| at > 0 && at + 1 < count;
    let across = if inside(column, columns) { height(column + 1, row) - height(column - 1, row) } else { 0.0 };
    let along = if inside(row, rows) { height(column, row + 1) - height(column, row - 1) } else { 0.0 };
    let slope = DVec2::new(across, along) / (2.0 * field.spacing());
    DVec3::new(-slope.x, 1.0, -slope.y).normalize()
}

/// Half of the cell's area at a wall, a quarter in a corner; the sum over all is 1.
fn weights(field: &HeightField) -> impl Iterator<Item = f64> {
    let [columns, rows] = field.quads;
    let weight = |at: u32, quads: u32| if at == 0 || at == quads { 0.5 } else { 1.0 } / f64::from(quads);
    (0..=rows).flat_map(move |row| (0..=columns).map(move |column| weight(column, columns) * weight(row, rows)))
}

pub fn mean(field: &HeightField, heights: &[f64]) -> f64 {
    weights(field).zip(heights).map(|(weight, height)| weight * height).sum()
}

/// What leapfrog keeps between two steps: half the square of the velocity plus half the product of the slopes at the two,
/// times the speed of waves squared. In the mean over the sheet.
pub fn energy(field: &HeightField, speed: f64, step: f64, now: &[f64], next: &[f64]) -> f64 {
    let kinetic = weights(field).zip(now.iter().zip(next)).map(|(w, (a, b))| w * ((b - a) / step).powi(2)).sum::<f64>();
    let [columns, rows] = field.quads.map(|quads| quads as usize + 1);
    let spacing = field.spacing();
    let product = |a: usize, b: usize| (now[b] - now[a]) * (next[b] - next[a]);
    // An edge along a wall has one cell beside it.
    let half = |at: usize, count: usize| if at == 0 || at + 1 == count { 0.5 } else { 1.0 };
    let mut across = 0.0;
    let mut along = 0.0;
    for (column, row) in (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row))) {
        let at = row * columns + column;
        if column + 1 < columns {
            across += half(row, rows) * product(at, at + 1);
        }
        if row + 1 < rows {
            along += half(column, columns) * product(at, at + columns);
        }
    }
    let cells = f64::from(field.quads[0] * field.quads[1]);
    let potential = across / spacing.x.powi(2) + along / spacing.y.powi(2);
    0.5 * kinetic + 0.5 * speed * speed * potential / cells
}

/// Height of a Gaussian drop of height 1 and standard deviation 1 on water without walls, at distance `r` after waves have
/// gone `way`: the integral over k of k exp(-k^2 / 2) cos(k way) J0(k r).
pub fn ring(r: f64, way: f64) -> f64 {
    // Trapezoids converge at once: nothing is left at 7, and the integrand is odd round 0 but for its even continuation.
    const STEPS: u32 = 600;
    let width = 7.0 / f64::from(STEPS);
    let at = |step: u32| {
        let k = f64::from(step) * width;
        k * (-0.5 * k * k).exp() * (k * way).cos() * bessel_0(k * r)
    };
    // The derivative at 0 is 1: the end correction of Euler and Maclaurin.
    width * (1..STEPS).map(at).sum::<f64>() + width * width / 12.0
}

/// J0(x) = the mean of cos(x sin t), by a sum that converges faster than any power.
fn bessel_0(x: f64) -> f64 {
    let count = 40 + x as u32;
    let angle = |k: u32| std::f64::consts::PI * (f64::from(k) + 0.5) / f64::from(count);
    (0..count).map(|k| (x * angle(k).sin()).cos()).sum::<f64>() / f64::from(count)
}

/// Where the outermost crest of a line is, in its points: the vertex of a parabola through the highest three.
pub fn crest(line: &[f64]) -> f64 {
    let highest = (1..line.len() - 1).max_by(|&a, &b| line[a].total_cmp(&line[b])).unwrap();
    let (a, b, c) = (line[highest - 1], line[highest], line[highest + 1]);
    highest as f64 + 0.5 * (a - c) / (a - 2.0 * b + c)
}
