//! What a kernel's pipeline is made for.

use ash::vk;

use super::reflect::constants;

/// Which of a kernel's modules a pipeline is made of, and what of it is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Variant {
    /// The tracing back-end's module; empty for a kernel that traces no rays.
    pub module: &'static str,
    pub parts: Parts,
}

impl From<&'static str> for Variant {
    /// That module, for any scene.
    fn from(module: &'static str) -> Self {
        Variant { module, parts: Parts::default() }
    }
}

/// What a scene may have. Where it has not, kernels leave its code out, by specialization constants: software drivers
/// compile each part for seconds, and run it for invocations that do not need it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Parts {
    /// Media with density grids.
    pub grids: bool,
    /// Rough mirrors.
    pub rough: bool,
}

impl Default for Parts {
    /// Those of any scene.
    fn default() -> Self {
        Parts { grids: true, rough: true }
    }
}

impl Parts {
    /// Names of the constants in `kernels/shared/parts.glsl`, by their ids.
    pub const NAMES: [&'static str; 2] = ["HAS_GRIDS", "HAS_ROUGH"];

    /// Those that the module asks for; the others count as there, so that they make no pipelines of their own.
    pub(crate) fn asked_by(self, words: &[u32]) -> Parts {
        let asked = constants(words);
        let [grids, rough] = [0, 1].map(|wanted| asked.iter().all(|(id, _)| *id != wanted));
        Parts { grids: self.grids || grids, rough: self.rough || rough }
    }

    /// Values of the constants, by their ids.
    pub(crate) fn values(self) -> [vk::Bool32; 2] {
        [self.grids, self.rough].map(vk::Bool32::from)
    }
}

/// Where each constant's value is in [`Parts::values`].
pub(crate) fn entries() -> [vk::SpecializationMapEntry; 2] {
    [0, 1].map(|id| vk::SpecializationMapEntry { constant_id: id, offset: 4 * id, size: 4 })
}
