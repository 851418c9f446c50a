//! Adaptive beam tracing (Liktor and Dachsbacher 2011): light between neighbouring rays, in volumes and on surfaces.

pub mod beam;
