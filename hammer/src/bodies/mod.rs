//! The bodies: sections, meshes, and the modes of a free body.

pub mod bar;
pub(crate) mod cache;
mod damping;
mod meeting;
mod pencil;
pub mod resolution;
pub mod spline;
