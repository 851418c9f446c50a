//! What a device can do beyond the portable core, and how to pose as a lesser device.

use super::GpuError;

/// Something a device may lack; each has a fallback.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Capability {
    /// `VK_KHR_ray_query`; else compute traversal of a BVH.
    RayQuery,
    /// A queue with graphics, and dynamic rendering; else compute rays.
    Graphics,
    /// Eight bits of sub-pixel position in the rasteriser; else visibility is by compute rays. Vulkan asks for four only,
    /// which moves edges by 1/32 pixel: enough to see another surface along a whole horizontal edge.
    PreciseRaster,
    /// Geometry shaders; else vertices written by compute.
    GeometryShader,
    /// 32-bit float atomic adds in storage buffers; else fixed-point integers.
    FloatAtomics,
    /// Timestamps on the queue; else passes are not timed.
    Timestamps,
}

impl Capability {
    pub const ALL: [Capability; 6] = [
        Capability::RayQuery,
        Capability::Graphics,
        Capability::PreciseRaster,
        Capability::GeometryShader,
        Capability::FloatAtomics,
        Capability::Timestamps,
    ];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Capability::RayQuery => "ray-query",
            Capability::Graphics => "graphics",
            Capability::PreciseRaster => "precise-raster",
            Capability::GeometryShader => "geometry-shader",
            Capability::FloatAtomics => "float-atomics",
            Capability::Timestamps => "timestamps",
        }
    }
}

/// A set of capabilities.
#[derive(Debug, Clone, Default, PartialEq, Eq, serde::Serialize)]
#[serde(transparent)]
pub struct Capabilities(Vec<Capability>);

impl Capabilities {
    pub fn new(all: impl IntoIterator<Item = Capability>) -> Self {
        let mut list = Vec::new();
        for capability in all {
            if !list.contains(&capability) {
                list.push(capability);
            }
        }
        Capabilities(list)
    }

    /// Reads `ray-query,graphics`.
    pub fn parse(list: &str) -> Result<Self, GpuError> {
        let names = list.split(',').map(str::trim).filter(|name| !name.is_empty());
        Ok(Self::new(names.map(parse_one).collect::<Result<Vec<_>, _>>()?))
    }

    pub fn has(&self, capability: Capability) -> bool {
        self.0.contains(&capability)
    }

    pub fn remove(&mut self, capability: Capability) {
        self.0.retain(|&c| c != capability);
    }

    /// What is in `self` and not in `other`. Without graphics there is no raster and there are no geometry shaders.
    pub fn without(&self, other: &Capabilities) -> Self {
        let kept = self.0.iter().copied().filter(|&c| !other.has(c));
        let mut kept = Self::new(kept);
        if !kept.has(Capability::Graphics) {
            kept.remove(Capability::PreciseRaster);
            kept.remove(Capability::GeometryShader);
        }
        kept
    }

    pub fn names(&self) -> Vec<&'static str> {
        self.0.iter().map(|c| c.name()).collect()
    }
}

fn parse_one(name: &str) -> Result<Capability, GpuError> {
    // Named so that the answer is a reason instead of "unknown".
    if name == "compute" {
        return Err(GpuError::NoFallback("compute"));
    }
    Capability::ALL.into_iter().find(|c| c.name() == name).ok_or_else(|| GpuError::UnknownCapability {
        found: name.to_string(),
        allowed: Capability::ALL.map(Capability::name).join(", "),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_read_and_unknown_names_refused() {
        let list = Capabilities::parse("ray-query, graphics").unwrap();
        assert!(list.has(Capability::RayQuery) && list.has(Capability::Graphics));
        assert!(Capabilities::parse("").unwrap().names().is_empty());
        assert_eq!(
            Capabilities::parse("ray-qeury").unwrap_err().to_string(),
            "unknown capability \"ray-qeury\" in the list of what to disable; allowed are: ray-query, graphics, \
             precise-raster, geometry-shader, float-atomics, timestamps"
        );
        assert_eq!(
            Capabilities::parse("compute").unwrap_err().to_string(),
            "the capability compute cannot be disabled: it has no fallback"
        );
    }

    #[test]
    fn geometry_shaders_go_with_graphics() {
        let all = Capabilities::new(Capability::ALL);
        let left = all.without(&Capabilities::parse("graphics").unwrap());
        assert!(!left.has(Capability::GeometryShader) && left.has(Capability::RayQuery));
    }
}
