//! Faults that are put in on purpose, in test builds alone, to show that a case finds each of them.

/// A behaviour that a driver may get wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// Commands on both sides of a barrier change places, as they may where it is left out.
    Barrier,
    /// Ray queries and trees answer with the barycentrics of a triangle whose corners go the other way round.
    Barycentrics,
    /// Rays see instances of every mask.
    Mask,
    /// Numbers too small to be normal become zero on their way through a kernel.
    Denormals,
    /// One float addition of a thousand is lost.
    FloatAtomics,
}

impl Fault {
    pub const ALL: [Fault; 5] =
        [Fault::Barrier, Fault::Barycentrics, Fault::Mask, Fault::Denormals, Fault::FloatAtomics];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Fault::Barrier => "barrier",
            Fault::Barycentrics => "barycentrics",
            Fault::Mask => "mask",
            Fault::Denormals => "denormals",
            Fault::FloatAtomics => "float-atomics",
        }
    }

    /// The fault of that name.
    pub fn named(name: &str) -> Option<Fault> {
        Fault::ALL.into_iter().find(|fault| fault.name() == name)
    }
}

#[cfg(feature = "faults")]
static ACTIVE: std::sync::OnceLock<Fault> = std::sync::OnceLock::new();

/// Puts a fault in for the rest of the process; the first one stays.
#[cfg(feature = "faults")]
pub fn inject(fault: Fault) {
    let _ = ACTIVE.set(fault);
}

/// Whether that fault was put in.
#[cfg(feature = "faults")]
pub(crate) fn injected(fault: Fault) -> bool {
    ACTIVE.get() == Some(&fault)
}

/// Never, in a build without faults.
#[cfg(not(feature = "faults"))]
pub(crate) fn injected(_fault: Fault) -> bool {
    false
}

/// The order in which `count` commands run that barriers part.
pub(crate) fn in_order(count: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    if injected(Fault::Barrier) {
        order.chunks_exact_mut(2).for_each(|pair| pair.swap(0, 1));
    }
    order
}
