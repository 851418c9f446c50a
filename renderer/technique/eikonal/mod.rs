//! Wave fronts in a grid (Mercier, Eikonal Approximation for Real-Time Height Field Caustics): the optical path from a light
//! to every cell under a refracting surface. Not offered to users yet: nothing makes pictures of it.

pub mod device;
pub mod grid;
pub mod marching;
pub mod path;
pub mod solver;
pub mod volume;
pub mod wave;

pub use grid::Grid;
pub use solver::{Settled, Solver, SolverOptions};
pub use volume::{Kernels, Volume, VolumeOptions};
pub use wave::{Start, Sum, Wave, WaveKernels, WaveOptions};
