//! The refracting surfaces as the walk needs them: corners in world space, and what lies across each edge.

use glam::Vec3;

use crate::gpu::{Bindings, Buffer, Device, GpuError, GpuStruct, Kernel, Layout, Recorder};
use crate::scene::adjacency::{Adjacency, Neighbour};
use crate::scene::{Instance, Mesh, Scene};

/// In place of a triangle: an open edge, or an instance that does not refract.
const NO_TRIANGLE: u32 = u32::MAX;

/// Added to the half angle of a cone of normals, rad: what rounding turns normals and half vectors by, with room.
const SPREAD_MARGIN: f32 = 0.02;

crate::gpu_struct! {
    /// World space; see `kernels/technique/mnee/surface.glsl`.
    pub struct SpecularVertex {
        pub position: [f32; 3],
        pub padding0: u32,
        pub normal: [f32; 3],
        pub padding1: u32,
    }
}

crate::gpu_struct! {
    /// A triangle's corners and what lies across its edges 01, 12, 20.
    pub struct SpecularTriangle {
        pub corner: [u32; 3],
        pub instance: u32,
        pub across: [u32; 3],
        pub padding0: u32,
    }
}

crate::gpu_struct! {
    /// Where an instance's triangles are, and a cone that holds its shading normals.
    pub struct SpecularInstance {
        pub axis: [f32; 3],
        pub cos_spread: f32,
        pub first_triangle: u32,
        pub first_vertex: u32,
        pub padding0: u32,
        pub padding1: u32,
    }
}

crate::gpu_struct! {
    pub struct SurfacePush {
        pub instance: u32,
        pub vertices: u32,
    }
}

pub const LAYOUTS: &[Layout] =
    &[SpecularVertex::LAYOUT, SpecularTriangle::LAYOUT, SpecularInstance::LAYOUT, SurfacePush::LAYOUT];

/// All refracting instances of a scene on the device: 32 bytes a triangle and 32 a vertex.
pub struct SpecularSurface {
    pub bindings: Bindings,
    pub triangles: u32,
    pub vertices: u32,
    /// Those that refract, each with its number of vertices.
    pub instances: Vec<SurfacePush>,
    /// One an instance of the scene, on the device and here.
    records: Buffer,
    placed: Vec<SpecularInstance>,
    transform: Kernel,
}

impl SpecularSurface {
    /// Finds neighbours on the host. Fails where a buffer is larger than the device allows.
    pub fn new(device: &Device, scene: &Scene) -> Result<Self, GpuError> {
        let mut triangles = Vec::new();
        let mut records = Vec::new();
        let mut instances = Vec::new();
        let mut first_vertex = 0;
        for (index, instance) in (0u32..).zip(&scene.instances) {
            let refracts = scene.refracts(instance);
            let (axis, cos_spread) = normal_cone(scene, instance);
            records.push(SpecularInstance {
                axis: axis.to_array(),
                cos_spread,
                first_triangle: if refracts { triangles.len() as u32 } else { NO_TRIANGLE },
                first_vertex,
                padding0: 0,
                padding1: 0,
            });
            if refracts {
                let vertices = scene.meshes[instance.mesh].positions.len() as u32;
                append_triangles(&mut triangles, scene, index, first_vertex);
                instances.push(SurfacePush { instance: index, vertices });
                first_vertex += vertices;
            }
        }
        let buffer = Buffer::from_slice(device, "mnee instances", &records)?;
        let vertex_bytes = u64::from(first_vertex) * size_of::<SpecularVertex>() as u64;
        let bindings = Bindings::new()
            .buffer("SpecularVertices", &Buffer::new(device, "mnee vertices", vertex_bytes)?)
            .buffer("SpecularTriangles", &Buffer::from_slice(device, "mnee triangles", &triangles)?)
            .buffer("SpecularInstances", &buffer);
        let transform = Kernel::new(device, "mnee/surface", "")?;
        Ok(SpecularSurface {
            bindings,
            triangles: triangles.len() as u32,
            vertices: first_vertex,
            instances,
            records: buffer,
            placed: records,
            transform,
        })
    }

    /// Follows normals and transforms that have changed; the triangles have not.
    pub fn update(&mut self, scene: &Scene) -> Result<(), GpuError> {
        for (record, instance) in self.placed.iter_mut().zip(&scene.instances) {
            let (axis, cos_spread) = normal_cone(scene, instance);
            (record.axis, record.cos_spread) = (axis.to_array(), cos_spread);
        }
        self.records.upload(bytemuck::cast_slice(&self.placed))
    }

    /// Records the way of all vertices to world space, from the scene's instances as they are then.
    pub fn record(&self, recorder: &mut Recorder, scene: &Bindings) -> Result<(), GpuError> {
        let mut pass = recorder.pass("mnee/surface")?;
        for push in &self.instances {
            pass.dispatch(&self.transform, &[scene, &self.bindings], push, push.vertices)?;
        }
        Ok(())
    }
}

/// The triangles of an instance. Across an edge that more than two share, or whose triangles face different sides, nothing
/// can be walked to.
fn append_triangles(triangles: &mut Vec<SpecularTriangle>, scene: &Scene, instance: u32, first_vertex: u32) {
    let mesh = &scene.meshes[scene.instances[instance as usize].mesh];
    let adjacency = Adjacency::of(mesh);
    let first_triangle = triangles.len() as u32;
    for (corners, neighbours) in mesh.triangles.iter().zip(&adjacency.neighbours) {
        let edges = neighbours.iter().enumerate().map(|(edge, neighbour)| match *neighbour {
            Neighbour::Triangle(there) => {
                edge_back(mesh, there, corners, edge).map_or(NO_TRIANGLE, |back| 4 * (first_triangle + there) + back)
            }
            Neighbour::Boundary | Neighbour::NonManifold(_) => NO_TRIANGLE,
        });
        let mut across = [NO_TRIANGLE; 3];
        across.iter_mut().zip(edges).for_each(|(slot, edge)| *slot = edge);
        triangles.push(SpecularTriangle {
            corner: corners.map(|corner| corner + first_vertex),
            instance,
            across,
            padding0: 0,
        });
    }
}

/// The edge of triangle `there` that runs the other way along edge `edge` of the triangle with `corners`; `None` where the
/// two face different sides.
fn edge_back(mesh: &Mesh, there: u32, corners: &[u32; 3], edge: usize) -> Option<u32> {
    let position = |corner: u32| mesh.positions[corner as usize];
    let (from, to) = (position(corners[edge]), position(corners[(edge + 1) % 3]));
    let other = mesh.triangles.get(there as usize)?;
    (0..3usize).find(|&e| position(other[e]) == to && position(other[(e + 1) % 3]) == from).map(|e| e as u32)
}

/// Axis and cosine of the half angle of a cone that holds an instance's shading normals in world space.
fn normal_cone(scene: &Scene, instance: &Instance) -> (Vec3, f32) {
    let mesh = &scene.meshes[instance.mesh];
    let to_normal = instance.transform.matrix3.inverse().transpose();
    let normals =
        || mesh.normals.iter().map(|&normal| Vec3::from(to_normal * glam::Vec3A::from(normal)).normalize_or_zero());
    let axis = normals().sum::<Vec3>().normalize_or_zero();
    let least = normals().map(|normal| normal.dot(axis)).fold(1.0, f32::min);
    let spread = least.clamp(-1.0, 1.0).acos() + SPREAD_MARGIN;
    // Past a right angle the cone's other half would have to be looked at too; everything is inside then.
    if axis == Vec3::ZERO || spread >= std::f32::consts::FRAC_PI_2 { (Vec3::Y, -1.0) } else { (axis, spread.cos()) }
}
