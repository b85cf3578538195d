//! The bodies: sections, meshes, and the modes of a body that is held by nothing.

pub mod bar;
pub(crate) mod cache;
mod damping;
mod meeting;
mod pencil;
pub mod resolution;
pub mod spline;
