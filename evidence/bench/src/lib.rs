//! Speed: general solvers of others beside the engine, and the cost of the faces.
//!
//! The solvers use the model of the crate `oracles`, which shares nothing with the engine; errors are measured
//! against the reference of that crate. Nothing that ships depends on this crate.

#[cfg(feature = "contest")]
pub mod diffsol_peer;
pub mod engine;
pub mod heyoka;
pub mod library;
pub mod schema;
pub mod sundials;

/// Why something could not be measured.
pub type Failure = Box<dyn std::error::Error>;

/// The processor's name, and the vectors that the engine uses on it.
pub fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("model name"));
    let name = line.map_or("unknown".into(), |l| l.trim_matches([' ', '\t', ':']).to_string());
    format!("{name}, {} vectors", hammer::Vectors::in_use())
}
