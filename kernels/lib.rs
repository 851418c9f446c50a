//! The table of Nephroid's kernels: SPIR-V made from the GLSL beside this file.
//!
//! A kernel that traces rays is here once per tracing back-end, under `variant`.

use std::path::Path;

/// One SPIR-V module.
#[derive(Debug, Clone, Copy)]
pub struct KernelSource {
    /// Path below the kernel folder without `technique/` and the file's ending: `reference/emit`.
    pub name: &'static str,
    /// `comp`, `vert`, `geom` or `frag`.
    pub stage: &'static str,
    /// `ray_query`, `cwbvh` or `bvh2`; empty for a kernel that traces no rays.
    pub variant: &'static str,
    /// Little-endian words, as bytes.
    pub spirv: &'static [u8],
}

impl KernelSource {
    /// The module as words.
    pub fn words(&self) -> Vec<u32> {
        self.spirv.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
    }
}

include!(concat!(env!("OUT_DIR"), "/table.rs"));

/// The module of that name, stage and variant.
pub fn find(name: &str, stage: &str, variant: &str) -> Option<&'static KernelSource> {
    KERNELS.iter().find(|k| k.name == name && k.stage == stage && k.variant == variant)
}

/// Where the kernels' sources were when the program was built.
pub fn source_folder() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}
