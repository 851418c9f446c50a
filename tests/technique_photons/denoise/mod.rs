//! The filter of photons' irradiance: on fields and surfaces made up here, against closed forms, and in pictures.

mod bed;
pub mod history;
pub mod pictures;
pub mod space;
