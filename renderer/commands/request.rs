//! What a picture was asked to show, as one number: `animate --resume` keeps a frame only if it is of the same request.

use std::fmt::{self, Write};
use std::mem::take;

use crate::image::LayeredImage;
use crate::image::openexr::SOFTWARE;
use crate::render::{RenderError, RenderSettings};
use crate::scene::Scene;
use crate::technique::Settings;

/// The attribute that holds it in pictures.
pub const ATTRIBUTE: &str = "nephroid.request";

/// A hash of everything that decides a picture's content but for the frame's number: the scene with all files it is
/// made of, the frame rate where anything moves, size, samples, seed, technique and settings, and this program's
/// version and kernels. Exposure and tone curve count, though an EXR file is the same without them: a PNG beside it is
/// not. Device and tier are left out: they change roundings.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Request(String);

impl Request {
    /// `scene` as it was loaded, given back as it was.
    ///
    /// # Errors
    /// Settings that are not allowed.
    pub fn new(scene: &mut Scene, settings: &RenderSettings) -> Result<Self, RenderError> {
        let mut hash = Fnv::new();
        for kernel in nephroid_kernels::KERNELS {
            hash.text(format_args!("{} {} {}", kernel.name, kernel.stage, kernel.variant));
            hash.part(kernel.spirv);
        }
        // The large parts go in as bytes. All else goes in as its debug text, which leaves out nothing that a scene may
        // get in future; where the file lies, what was mended and how many frames there are is no part of a picture.
        let (path, warnings) = (take(&mut scene.path), take(&mut scene.warnings));
        let (meshes, textures, film) = (take(&mut scene.meshes), take(&mut scene.textures), scene.film.clone());
        let densities = take(&mut scene.densities);
        (scene.film.width, scene.film.height) = settings.size.unwrap_or((film.width, film.height));
        scene.film.samples = settings.samples.unwrap_or(film.samples);
        let animation = scene.animation.clone();
        scene.animation.frames = None;
        if !animation.moves() {
            scene.animation.fps = 0.0;
        }
        hash.text(format_args!("{SOFTWARE} {scene:?}"));
        for mesh in &meshes {
            hash.part(bytemuck::cast_slice(&mesh.positions));
            hash.part(bytemuck::cast_slice(&mesh.normals));
            hash.part(bytemuck::cast_slice(&mesh.uvs));
            hash.part(bytemuck::cast_slice(&mesh.triangles));
        }
        for texture in &textures {
            hash.text(format_args!("{} {}", texture.width, texture.height));
            hash.part(bytemuck::cast_slice(&texture.texels));
        }
        for grid in &densities {
            hash.text(format_args!("{:?} {:?}", grid.bounds, grid.points));
            hash.part(bytemuck::cast_slice(&grid.values));
        }
        (scene.path, scene.warnings, scene.meshes, scene.textures, scene.film) =
            (path, warnings, meshes, textures, film);
        scene.densities = densities;
        scene.animation = animation;

        let first = scene.cameras.first().map(|camera| camera.name.clone());
        let camera = settings.camera.clone().or(first).unwrap_or_default();
        let technique = Settings::of(settings.technique, scene, &settings.set)?;
        let of_technique: Vec<_> = technique.iter().collect();
        hash.text(format_args!("{camera:?} {} {of_technique:?}", settings.technique.name()));
        hash.text(format_args!("{} {} {}", settings.adaptive, settings.seed, settings.motion));
        hash.text(format_args!("{:?}", settings.taa));
        Ok(Request(hash.hex()))
    }

    /// Writes the request into a picture that fulfils it.
    pub fn mark(&self, image: &mut LayeredImage) {
        image.attributes.insert(ATTRIBUTE.to_owned(), self.0.clone());
    }

    pub fn text(&self) -> &str {
        &self.0
    }
}

/// FNV-1a of 128 bits: short, the same everywhere, and nobody gains by a collision.
struct Fnv(u128);

impl Fnv {
    const START: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;

    fn new() -> Self {
        Fnv(Self::START)
    }

    fn bytes(&mut self, bytes: &[u8]) {
        self.0 = bytes.iter().fold(self.0, |hash, byte| (hash ^ u128::from(*byte)).wrapping_mul(Self::PRIME));
    }

    /// The length goes in too, so that parts cannot run into each other.
    fn part(&mut self, bytes: &[u8]) {
        self.bytes(&(bytes.len() as u64).to_le_bytes());
        self.bytes(bytes);
    }

    fn text(&mut self, text: fmt::Arguments) {
        // Writing into a number cannot fail.
        let _ = self.write_fmt(text);
        self.bytes(&[0]);
    }

    fn hex(&self) -> String {
        format!("{:032x}", self.0)
    }
}

impl Write for Fnv {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.bytes(text.as_bytes());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_fnv_1a() {
        // Of the test vectors published with the algorithm.
        let mut hash = Fnv::new();
        hash.bytes(b"foobar");
        assert_eq!(hash.hex(), "343e1662793c64bf6f0d3597ba446f18");
    }
}
