//! The engine as a native module of Python, `dth_hammer._native`: a face as thin as the others.
//!
//! Every object may be used from any thread, by the rule of `turn.rs`; other threads of Python run
//! while the engine works. What the engine refuses, and a panic too, is an
//! exception of `dth_hammer.errors`.

mod batch;
mod derivatives;
mod driller;
mod failure;
mod interrupt;
mod machine;
mod scene;
mod session;
mod snapshot;
mod table;
mod turn;

/// The engine for Python.
#[pyo3::pymodule]
mod _native {
    use pyo3::prelude::*;
    use pyo3::types::IntoPyDict;

    #[pymodule_export]
    use crate::batch::{Batch, averages, means, wanted};
    #[pymodule_export]
    use crate::derivatives::{arguments, derivatives};
    #[pymodule_export]
    use crate::driller::{
        damping, datasheet, datasheet_numbers, ground, ground_of, ground_rows, ground_under,
        inserts, rocks, spread, usual_hole,
    };
    #[pymodule_export]
    use crate::machine::Machine;
    #[pymodule_export]
    use crate::scene::{
        elastic_bodies, force_error, mesh, mesh_readings, nodes, sections, starved, unlikely,
        unread, wave_names,
    };
    #[pymodule_export]
    use crate::snapshot::Snapshot;
    #[pymodule_export]
    use crate::table::{
        Selection, blow_names, experiment, instead_of, presets, variables, wave_families,
    };
    #[pymodule_export]
    use crate::turn::forked;

    /// What tells this engine from another of the same version: a hash of its sources.
    #[pymodule_export]
    const ENGINE: &str = env!("DTH_ENGINE");

    /// The diameter of the hole that the reference's rock is taken for, m.
    #[pymodule_export]
    const REFERENCE_HOLE: f64 = hammer::presets::REFERENCE_HOLE;

    /// Advance of a hole per turn of the bit, m: the middle of what makers recommend.
    #[pymodule_export]
    const TURN: f64 = hammer::datasheet::TURN;

    /// Without its exceptions nothing here may be called.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        let errors = module.py().import("dth_hammer.errors")?;
        for name in ["DomainError", "RefusedError", "UnknownNameError"] {
            errors.getattr(name)?;
        }
        // Windows has no forks.
        if let Ok(register) = module.py().import("os")?.getattr("register_at_fork") {
            let after = [("after_in_child", module.getattr("forked")?)];
            register.call((), Some(&after.into_py_dict(module.py())?))?;
        }
        Ok(())
    }
}
