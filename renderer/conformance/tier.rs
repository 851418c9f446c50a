//! What of a device cases get to use.

use crate::gpu::{Capabilities, Capability, DeviceInfo};

/// A device posing as a lesser one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tier {
    /// Its name on the command line.
    pub name: &'static str,
    /// What is disabled.
    pub without: &'static [Capability],
}

/// All that the device offers.
const FULL: &str = "full";

/// Every tier: everything, everything but one capability, nothing but compute.
pub const TIERS: &[Tier] = &[
    Tier { name: FULL, without: &[] },
    Tier { name: "no-ray-query", without: &[Capability::RayQuery] },
    Tier { name: "no-graphics", without: &[Capability::Graphics] },
    Tier { name: "no-precise-raster", without: &[Capability::PreciseRaster] },
    Tier { name: "no-geometry-shader", without: &[Capability::GeometryShader] },
    Tier { name: "no-float-atomics", without: &[Capability::FloatAtomics] },
    Tier { name: "no-timestamps", without: &[Capability::Timestamps] },
    Tier { name: "compute", without: &Capability::ALL },
];

impl Tier {
    /// The tiers in which `device` differs from itself.
    pub fn offered_by(device: &DeviceInfo) -> Vec<Tier> {
        let differs = |tier: &&Tier| tier.is_full() || tier.without.iter().any(|c| device.capabilities.has(*c));
        TIERS.iter().filter(differs).copied().collect()
    }

    /// The tier of that name.
    pub fn named(name: &str) -> Option<Tier> {
        TIERS.iter().find(|tier| tier.name == name).copied()
    }

    /// Whether nothing is disabled.
    pub fn is_full(self) -> bool {
        self.without.is_empty()
    }

    /// Whether it is compute and nothing else.
    pub fn is_compute(self) -> bool {
        self.without.len() == Capability::ALL.len()
    }

    /// What to disable.
    pub fn disabled(self) -> Capabilities {
        Capabilities::new(self.without.iter().copied())
    }
}
