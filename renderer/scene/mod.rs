//! What is rendered: the scene as the host sees it, after its file was read and checked.
//!
//! Metres, right-handed, y up; linear Rec.709 RGB. Everything here is plain data; the GPU's copy is made in
//! [`crate::gpu_scene`].

pub mod adjacency;
pub mod animation;
mod camera;
mod density;
pub mod error;
mod file;
pub mod height_field;
mod keyed;
mod light;
mod material;
pub mod mend;
mod motion;
mod mtl;
mod noise;
mod obj;
mod obj_check;
mod object;
mod polygon;
pub mod shapes;
mod technique;
mod texture;
mod transform;
mod value;

use std::path::PathBuf;

use glam::{Affine3A, DVec3, Vec2, Vec3};

use crate::technique::TechniqueKind;

pub use animation::Animation;
pub use error::SceneError;
pub use file::{FPS, load, load_at, parse};
pub use transform::Placement;

/// Index into [`Scene::meshes`].
pub type MeshId = usize;
/// Index into [`Scene::materials`].
pub type MaterialId = usize;
/// Index into [`Scene::media`]. Medium 0 is always `air`: index 1, empty.
pub type MediumId = usize;
/// Index into [`Scene::textures`].
pub type TextureId = usize;
/// Index into [`Scene::densities`].
pub type DensityId = usize;

/// A scene, complete and valid: every id is in range and every number finite.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The scene file.
    pub path: PathBuf,
    pub film: FilmSettings,
    /// At least one; the first is used where none is named.
    pub cameras: Vec<Camera>,
    pub meshes: Vec<Mesh>,
    pub instances: Vec<Instance>,
    pub materials: Vec<Material>,
    pub textures: Vec<Texture>,
    pub media: Vec<Medium>,
    pub densities: Vec<DensityGrid>,
    pub lights: Vec<Light>,
    pub animation: Animation,
    /// What the scene file sets of techniques, each of them once.
    pub settings: Vec<SceneSetting>,
    /// What was mended while loading (degenerate triangles dropped, say), a sentence each.
    pub warnings: Vec<String>,
}

/// A setting of a technique, allowed by the technique's table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SceneSetting {
    pub technique: TechniqueKind,
    pub key: &'static str,
    /// As `--set` has it.
    pub value: String,
}

impl SceneSetting {
    /// `technique.key=value`.
    pub fn item(&self) -> String {
        format!("{}.{}={}", self.technique.name(), self.key, self.value)
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct FilmSettings {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Samples a pixel where the command line names none.
    pub samples: u32,
    /// Stops: display output is multiplied by 2^exposure before the tone curve.
    pub exposure: f32,
    pub tone_curve: ToneCurve,
    /// Radiance of rays that leave the scene, W/(m2 sr). It is seen; it does not light anything.
    pub background: Vec3,
    /// Points on each stretch of a camera path in a medium that scatters at which light is found.
    pub volume_samples: u32,
}

/// How linear radiance becomes a display value in the PNG; EXR files stay linear.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ToneCurve {
    /// Clamped to 1, then sRGB.
    Linear,
    /// Reinhard's extended curve on luminance, white at 4, then sRGB.
    Reinhard,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    pub name: String,
    pub position: Vec3,
    pub target: Vec3,
    pub up: Vec3,
    /// Vertical field of view, degrees, in (0, 180).
    pub fov_y: f32,
    /// The medium the camera is in.
    pub medium: MediumId,
}

/// An indexed triangle mesh in its own space.
#[derive(Debug, Clone, Default)]
pub struct Mesh {
    pub name: String,
    pub positions: Vec<Vec3>,
    /// Unit shading normals, one a position; on the side of the front (counter-clockwise) face.
    pub normals: Vec<Vec3>,
    /// One a position; zero where the source has none.
    pub uvs: Vec<Vec2>,
    pub triangles: Vec<[u32; 3]>,
}

/// One placed mesh.
#[derive(Debug, Clone)]
pub struct Instance {
    pub name: String,
    pub mesh: MeshId,
    pub material: MaterialId,
    /// Object space to world space; invertible.
    pub transform: Affine3A,
}

#[derive(Debug, Clone)]
pub struct Material {
    pub name: String,
    pub surface: Surface,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Surface {
    /// Lambertian, two-sided. The albedo is multiplied by the texture where there is one.
    Diffuse { albedo: Vec3, texture: Option<TextureId> },
    /// A smooth interface between two media; `front` is on the side the geometric normal points to.
    Dielectric { front: MediumId, back: MediumId },
    /// A smooth mirror on both sides.
    Mirror { reflectance: Vec3 },
    /// A rough mirror (GGX with Smith masking, alpha = roughness^2) on both sides.
    Rough { reflectance: Vec3, roughness: f32 },
}

impl Surface {
    /// Whether light that meets it goes on as part of the S+ of a caustic path.
    pub fn is_specular(&self) -> bool {
        !matches!(self, Surface::Diffuse { .. })
    }
}

/// A medium; homogeneous where it has no density grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Medium {
    pub name: String,
    /// Refractive index relative to vacuum, at least 1.
    pub index: f32,
    /// Absorption coefficient, 1/m.
    pub absorption: Vec3,
    /// Scattering coefficient, 1/m.
    pub scattering: Vec3,
    /// Henyey-Greenstein g in (-1, 1): mean cosine between the directions before and after.
    pub asymmetry: f32,
    /// What multiplies absorption and scattering; 1 everywhere if `None`.
    pub density: Option<DensityId>,
}

/// Density at points on a box's corners, edges and inside, evenly spread along each axis; trilinear between them and zero
/// outside.
#[derive(Debug, Clone, PartialEq)]
pub struct DensityGrid {
    /// World space, metres.
    pub bounds: Bounds,
    /// Along each axis, at least 2.
    pub points: [u32; 3],
    /// At least 0; x counts up first, then y.
    pub values: Vec<f32>,
}

impl Medium {
    /// Absorption plus scattering, 1/m.
    pub fn extinction(&self) -> Vec3 {
        self.absorption + self.scattering
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct Light {
    pub name: String,
    pub emitter: Emitter,
    /// The medium the light is in.
    pub medium: MediumId,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Emitter {
    /// `intensity`: W/sr.
    Point { position: Vec3, intensity: Vec3 },
    /// `intensity`: W/sr on the axis; full inside `inner`, none outside `outer`, smoothstep in the angle's cosine
    /// between. Both are half angles in radians, 0 <= inner <= outer <= pi/2.
    Spot { position: Vec3, direction: Vec3, intensity: Vec3, inner: f32, outer: f32, image: Option<SpotImage> },
    /// `direction`: unit, the way the light travels; `irradiance`: W/m2 on a plane perpendicular to it.
    Directional { direction: Vec3, irradiance: Vec3 },
}

/// What a spot light projects, like a slide: a picture that multiplies its intensity, on the square that just holds the
/// outer cone. Only where `outer` is below pi/2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpotImage {
    pub texture: TextureId,
    /// Unit: the picture's top is on this side.
    pub up: Vec3,
}

impl SpotImage {
    /// Unit vectors across the light's unit `direction`, to the picture's right and to its top, as seen from the light.
    pub fn axes(&self, direction: DVec3) -> [DVec3; 2] {
        let up = self.up.as_dvec3().reject_from_normalized(direction);
        let up = up.try_normalize().unwrap_or_else(|| direction.any_orthonormal_vector());
        [direction.cross(up), up]
    }
}

/// An image that multiplies an albedo, or what a spot light sends out.
#[derive(Debug, Clone)]
pub struct Texture {
    pub name: String,
    pub width: u32,
    pub height: u32,
    /// Linear RGB, row 0 on top, in [0, 1]. v = 0 is the bottom of the image, as in OBJ.
    pub texels: Vec<[f32; 3]>,
}

/// A box in world space, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    pub min: Vec3,
    pub max: Vec3,
}

impl Bounds {
    pub const EMPTY: Bounds = Bounds { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    pub fn include(&mut self, point: Vec3) {
        self.min = self.min.min(point);
        self.max = self.max.max(point);
    }

    /// Metres.
    pub fn diagonal(&self) -> f32 {
        (self.max - self.min).length()
    }
}

impl Scene {
    /// What holds every instance.
    pub fn bounds(&self) -> Bounds {
        self.bounds_of(|_| true)
    }

    /// What holds the instances that are wanted.
    pub fn bounds_of(&self, wanted: impl Fn(&Instance) -> bool) -> Bounds {
        let mut bounds = Bounds::EMPTY;
        for instance in self.instances.iter().filter(|instance| wanted(instance)) {
            for &position in &self.meshes[instance.mesh].positions {
                bounds.include(instance.transform.transform_point3(position));
            }
        }
        bounds
    }

    /// Whether any medium scatters.
    pub fn scatters(&self) -> bool {
        self.media.iter().any(|medium| medium.scattering.max_element() > 0.0)
    }

    /// Metres that rays which meet nothing are followed through a medium: camera paths, photons and beams alike. Twice the
    /// diagonal of the box of all instances, densities, cameras and lights.
    pub fn reach(&self) -> f32 {
        let mut bounds = self.bounds();
        for camera in &self.cameras {
            bounds.include(camera.position);
        }
        for light in &self.lights {
            if let Emitter::Point { position, .. } | Emitter::Spot { position, .. } = light.emitter {
                bounds.include(position);
            }
        }
        for grid in &self.densities {
            bounds.include(grid.bounds.min);
            bounds.include(grid.bounds.max);
        }
        // A scene without a single point has an infinite box.
        let diagonal = bounds.diagonal();
        if diagonal.is_finite() { 2.0 * diagonal } else { 0.0 }
    }

    /// Whether an instance is an interface between two media.
    pub fn refracts(&self, instance: &Instance) -> bool {
        matches!(self.materials[instance.material].surface, Surface::Dielectric { .. })
    }

    /// World-space surface area of an instance, m2.
    pub fn area(&self, instance: &Instance) -> f32 {
        let mesh = &self.meshes[instance.mesh];
        let corner = |index: u32| instance.transform.transform_point3(mesh.positions[index as usize]);
        let doubled = |&[a, b, c]: &[u32; 3]| (corner(b) - corner(a)).cross(corner(c) - corner(a)).length();
        0.5 * mesh.triangles.iter().map(doubled).sum::<f32>()
    }
}
