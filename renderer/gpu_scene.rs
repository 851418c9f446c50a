//! The scene's copy on the device: one buffer a kind of thing, the same for every kernel.

use glam::{Affine3A, DVec3, Mat4, UVec3, Vec3};

use crate::gpu::{Bindings, Buffer, Device, GpuError};
use crate::scene::{Bounds, DensityGrid, Emitter, Light, Material, Medium, Mesh, Scene, Surface, Texture};

/// Instances of specular surfaces (dielectric, mirror, rough).
pub const MASK_SPECULAR: u32 = 1;
/// Instances of diffuse surfaces.
pub const MASK_DIFFUSE: u32 = 2;

const NO_TEXTURE: u32 = u32::MAX;
const NO_GRID: u32 = u32::MAX;

crate::gpu_struct! {
    /// Object space.
    #[derive(Default)]
    pub struct Vertex {
        pub position: [f32; 3],
        pub u: f32,
        pub normal: [f32; 3],
        pub v: f32,
    }
}

/// The GPU's structs, named as in `kernels/shared/scene.glsl`.
pub mod records {
    use crate::gpu_struct;

    gpu_struct! {
        pub struct Instance {
            pub to_world: [[f32; 4]; 3],
            pub to_object: [[f32; 4]; 3],
            pub first_vertex: u32,
            pub first_index: u32,
            pub triangles: u32,
            pub material: u32,
            pub mask: u32,
            pub mirrored: u32,
            pub padding0: u32,
            pub padding1: u32,
        }
    }
    gpu_struct! {
        pub struct Material {
            pub kind: u32,
            pub front: u32,
            pub back: u32,
            pub texture: u32,
            pub color: [f32; 3],
            pub alpha: f32,
        }
    }
    gpu_struct! {
        pub struct Medium {
            pub absorption: [f32; 3],
            pub index: f32,
            pub scattering: [f32; 3],
            pub asymmetry: f32,
            pub grid: u32,
            pub padding0: u32,
            pub padding1: u32,
            pub padding2: u32,
        }
    }
    gpu_struct! {
        pub struct DensityGrid {
            pub lower: [f32; 3],
            pub first_voxel: u32,
            pub cells_per_metre: [f32; 3],
            pub padding0: u32,
            pub points: [u32; 3],
            pub padding1: u32,
        }
    }
    gpu_struct! {
        pub struct Light {
            pub position: [f32; 3],
            pub kind: u32,
            pub direction: [f32; 3],
            pub medium: u32,
            pub intensity: [f32; 3],
            pub cos_inner: f32,
            pub cos_outer: f32,
            pub image: u32,
            pub half_width: f32,
            pub padding0: u32,
            pub up: [f32; 3],
            pub padding1: u32,
        }
    }
    gpu_struct! {
        pub struct Texture {
            pub first_texel: u32,
            pub width: u32,
            pub height: u32,
            pub padding0: u32,
        }
    }
}

/// Where one mesh lies in the shared buffers.
#[derive(Debug, Clone, Copy)]
pub struct MeshRange {
    pub first_vertex: u32,
    pub vertices: u32,
    /// In `Indices`; indices are relative to `first_vertex`.
    pub first_index: u32,
    pub triangles: u32,
}

/// The scene on the device.
pub struct GpuScene {
    pub bindings: Bindings,
    pub vertices: Buffer,
    pub indices: Buffer,
    /// One a mesh of the scene.
    pub meshes: Vec<MeshRange>,
    pub instances: Vec<records::Instance>,
    instance_records: Buffer,
    light_records: Buffer,
    /// World space, of all instances.
    pub bounds: Bounds,
}

impl GpuScene {
    /// Uploads the scene. Fails where a buffer is larger than the device allows.
    pub fn new(device: &Device, scene: &Scene) -> Result<Self, GpuError> {
        let (vertices, indices, meshes) = pack_meshes(&scene.meshes);
        let vertices = Buffer::from_slice_with_usage(device, "scene vertices", &vertices, geometry_usage(device))?;
        let indices = Buffer::from_slice_with_usage(device, "scene indices", &indices, geometry_usage(device))?;
        let instances = pack_instances(scene, &meshes);
        let materials: Vec<_> = scene.materials.iter().map(pack_material).collect();
        let media: Vec<_> = scene.media.iter().map(pack_medium).collect();
        let lights: Vec<_> = scene.lights.iter().map(pack_light).collect();
        let instance_records = Buffer::from_slice(device, "scene instances", &instances)?;
        let light_records = Buffer::from_slice(device, "scene lights", &lights)?;
        let (textures, texels) = pack_textures(&scene.textures);
        let (grids, voxels) = pack_densities(&scene.densities);
        let bindings = Bindings::new()
            .buffer("Vertices", &vertices)
            .buffer("Indices", &indices)
            .buffer("Instances", &instance_records)
            .buffer("Materials", &Buffer::from_slice(device, "scene materials", &materials)?)
            .buffer("Media", &Buffer::from_slice(device, "scene media", &media)?)
            .buffer("DensityGrids", &Buffer::from_slice(device, "density grids", &grids)?)
            .buffer("Voxels", &Buffer::from_slice(device, "density voxels", &voxels)?)
            .buffer("Lights", &light_records)
            .buffer("Textures", &Buffer::from_slice(device, "scene textures", &textures)?)
            .buffer("Texels", &Buffer::from_slice(device, "scene texels", &texels)?);
        let bounds = scene.bounds();
        Ok(GpuScene { bindings, vertices, indices, meshes, instances, instance_records, light_records, bounds })
    }

    /// The instances' records as they are in `scene` now.
    pub fn instances_of(&self, scene: &Scene) -> Vec<records::Instance> {
        pack_instances(scene, &self.meshes)
    }

    /// Follows instances and lights that have moved. Vertices are left to whoever moves them.
    pub fn follow(&mut self, scene: &Scene) -> Result<(), GpuError> {
        self.instances = self.instances_of(scene);
        self.bounds = scene.bounds();
        let lights: Vec<_> = scene.lights.iter().map(pack_light).collect();
        self.instance_records.upload(bytemuck::cast_slice(&self.instances))?;
        self.light_records.upload(bytemuck::cast_slice(&lights))
    }
}

/// Acceleration structures are built from these buffers where there are any.
fn geometry_usage(device: &Device) -> ash::vk::BufferUsageFlags {
    crate::trace::geometry_usage(device)
}

fn pack_meshes(meshes: &[Mesh]) -> (Vec<Vertex>, Vec<u32>, Vec<MeshRange>) {
    let (mut vertices, mut indices, mut ranges) = (Vec::new(), Vec::new(), Vec::new());
    for mesh in meshes {
        ranges.push(MeshRange {
            first_vertex: vertices.len() as u32,
            vertices: mesh.positions.len() as u32,
            first_index: indices.len() as u32,
            triangles: mesh.triangles.len() as u32,
        });
        vertices.extend(mesh.positions.iter().enumerate().map(|(i, position)| {
            let normal = mesh.normals.get(i).copied().unwrap_or(Vec3::Y);
            let uv = mesh.uvs.get(i).copied().unwrap_or_default();
            Vertex { position: position.to_array(), u: uv.x, normal: normal.to_array(), v: uv.y }
        }));
        indices.extend(mesh.triangles.iter().flatten());
    }
    (vertices, indices, ranges)
}

fn pack_instances(scene: &Scene, meshes: &[MeshRange]) -> Vec<records::Instance> {
    let pack = |instance: &crate::scene::Instance| {
        let range = meshes[instance.mesh];
        let specular = scene.materials[instance.material].surface.is_specular();
        records::Instance {
            to_world: rows(instance.transform),
            to_object: rows(instance.transform.inverse()),
            first_vertex: range.first_vertex,
            first_index: range.first_index,
            triangles: range.triangles,
            material: instance.material as u32,
            mask: if specular { MASK_SPECULAR } else { MASK_DIFFUSE },
            mirrored: u32::from(instance.transform.matrix3.determinant() < 0.0),
            padding0: 0,
            padding1: 0,
        }
    };
    scene.instances.iter().map(pack).collect()
}

fn rows(transform: Affine3A) -> [[f32; 4]; 3] {
    let matrix = Mat4::from(transform);
    [matrix.row(0).to_array(), matrix.row(1).to_array(), matrix.row(2).to_array()]
}

fn pack_material(material: &Material) -> records::Material {
    let empty = records::Material { kind: 0, front: 0, back: 0, texture: NO_TEXTURE, color: [0.0; 3], alpha: 0.0 };
    match material.surface {
        Surface::Diffuse { albedo, texture } => {
            records::Material { texture: texture.map_or(NO_TEXTURE, |t| t as u32), color: albedo.to_array(), ..empty }
        }
        Surface::Dielectric { front, back } => {
            records::Material { kind: 1, front: front as u32, back: back as u32, ..empty }
        }
        Surface::Mirror { reflectance } => records::Material { kind: 2, color: reflectance.to_array(), ..empty },
        Surface::Rough { reflectance, roughness } => {
            records::Material { kind: 3, color: reflectance.to_array(), alpha: roughness * roughness, ..empty }
        }
    }
}

fn pack_medium(medium: &Medium) -> records::Medium {
    records::Medium {
        absorption: medium.absorption.to_array(),
        index: medium.index,
        scattering: medium.scattering.to_array(),
        asymmetry: medium.asymmetry,
        grid: medium.density.map_or(NO_GRID, |grid| grid as u32),
        padding0: 0,
        padding1: 0,
        padding2: 0,
    }
}

/// The grids' records, and what they hold, one after the other.
fn pack_densities(densities: &[DensityGrid]) -> (Vec<records::DensityGrid>, Vec<f32>) {
    let (mut grids, mut voxels) = (Vec::new(), Vec::new());
    for grid in densities {
        let cells = (UVec3::from(grid.points) - 1).as_vec3();
        grids.push(records::DensityGrid {
            lower: grid.bounds.min.to_array(),
            first_voxel: voxels.len() as u32,
            cells_per_metre: (cells / (grid.bounds.max - grid.bounds.min)).to_array(),
            padding0: 0,
            points: grid.points,
            padding1: 0,
        });
        voxels.extend_from_slice(&grid.values);
    }
    (grids, voxels)
}

fn pack_light(light: &Light) -> records::Light {
    let empty = records::Light {
        position: [0.0; 3],
        kind: 0,
        direction: [0.0, -1.0, 0.0],
        medium: light.medium as u32,
        intensity: [0.0; 3],
        cos_inner: -1.0,
        cos_outer: -1.0,
        image: NO_TEXTURE,
        half_width: 0.0,
        padding0: 0,
        up: [0.0; 3],
        padding1: 0,
    };
    match light.emitter {
        Emitter::Point { position, intensity } => {
            records::Light { position: position.to_array(), intensity: intensity.to_array(), ..empty }
        }
        Emitter::Spot { position, direction, intensity, inner, outer, image } => records::Light {
            kind: 1,
            position: position.to_array(),
            direction: direction.to_array(),
            intensity: intensity.to_array(),
            cos_inner: inner.cos(),
            cos_outer: outer.cos(),
            image: image.map_or(NO_TEXTURE, |image| image.texture as u32),
            half_width: outer.tan(),
            up: image.map_or(Vec3::ZERO, |image| image.axes(direction.as_dvec3())[1].as_vec3()).to_array(),
            ..empty
        },
        Emitter::Directional { direction, irradiance } => {
            records::Light { kind: 2, direction: direction.to_array(), intensity: irradiance.to_array(), ..empty }
        }
    }
}

fn pack_textures(textures: &[Texture]) -> (Vec<records::Texture>, Vec<u32>) {
    let (mut infos, mut texels) = (Vec::new(), Vec::new());
    for texture in textures {
        infos.push(records::Texture {
            first_texel: texels.len() as u32,
            width: texture.width,
            height: texture.height,
            padding0: 0,
        });
        texels.extend(texture.texels.iter().map(|&texel| pack_texel(texel)));
    }
    (infos, texels)
}

/// Ten bits a channel of the square root: steps below what an 8-bit sRGB source distinguishes.
fn pack_texel(texel: [f32; 3]) -> u32 {
    let bits = texel.map(|c| (c.clamp(0.0, 1.0).sqrt() * 1023.0).round() as u32);
    bits[0] | bits[1] << 10 | bits[2] << 20
}

/// What kernels read for a texel: it has been rounded.
pub(crate) fn stored_texel(texel: [f32; 3]) -> DVec3 {
    let bits = pack_texel(texel);
    let root = [bits & 1023, bits >> 10 & 1023, bits >> 20].map(|bits| f64::from(bits) / 1023.0);
    DVec3::from(root) * DVec3::from(root)
}
