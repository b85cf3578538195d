//! The engine as a native Python module, `dth_hammer._native`.
//!
//! Every object may be used from any thread, by the rules of `turn.rs`; other Python threads run while the engine
//! works. Errors of the engine, and panics, become exceptions of `dth_hammer.errors`.

mod batch;
mod derivatives;
mod driller;
mod failure;
mod interrupt;
mod machine;
mod response;
mod scene;
mod session;
mod snapshot;
mod table;
mod turn;

/// The engine for Python.
#[pyo3::pymodule]
mod _native {
    use crate::table::blow_columns;
    use hammer::Reading;
    use hammer::means::Averages;
    use hammer::presets::Ground;
    use hammer::sensitivity::Argument;
    use hammer::variables::{ALONG, Along, OfBlow, STEP_SIZE, STOP_TIME};
    use pyo3::prelude::*;
    use pyo3::types::IntoPyDict;

    #[pymodule_export]
    use crate::{
        batch::{Batch, wanted},
        derivatives::derivatives,
        driller::{
            damping, datasheet, datasheet_numbers, ground, ground_of, ground_under, inserts,
            ratios, refused_change, rocks, spread, usual_hole,
        },
        machine::Machine,
        scene::{bodies, diagnostics, mesh, mesh_errors, unread, wave_names},
        snapshot::Snapshot,
        table::{Selection, instead_of, presets, variables},
        turn::forked,
    };

    /// A hash of the engine's sources, which distinguishes builds of the same version.
    #[pymodule_export]
    const ENGINE: &str = env!("DTH_ENGINE");

    /// Loads the exceptions, which every call needs.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        let errors = module.py().import("dth_hammer.errors")?;
        for name in ["DomainError", "RefusedError", "UnknownNameError"] {
            errors.getattr(name)?;
        }
        // Diameter of the reference rock's hole, and advance of a hole per turn of the bit that makers recommend, m;
        // default communication step and duration, s.
        let (hole, turn) = (hammer::presets::REFERENCE_HOLE, hammer::datasheet::TURN);
        for (name, number) in
            [("REFERENCE_HOLE", hole), ("TURN", turn), ("STEP", STEP_SIZE), ("UNTIL", STOP_TIME)]
        {
            module.add(name, number)?;
        }
        module.add("THROUGH", hammer::datasheet::THROUGH)?;
        module.add("COMPARED", hammer::datasheet::COMPARED)?;
        // Possible arguments of derivatives, names of means, a blow's columns (name, unit, display unit, and whether it
        // must be recorded), values along the bodies, numbers
        // of a rock's file with their units, purposes of a mesh with their usual errors.
        module.add("ARGUMENTS", Argument::all().map(Argument::name).collect::<Vec<_>>())?;
        module.add("MEANS", Averages::names().collect::<Vec<_>>())?;
        let none = hammer::Blow::default();
        let recorded = |f: &OfBlow| (f.value)(&none).is_nan();
        let blow =
            blow_columns().map(|f| (f.output(), f.quantity.unit, f.quantity.display, recorded(f)));
        module.add("BLOW", blow.collect::<Vec<_>>())?;
        let along = |f: &Along| (f.name, f.description, f.quantity.unit, f.quantity.display);
        module.add("ALONG", ALONG.iter().map(along).collect::<Vec<_>>())?;
        module.add("GROUND", Ground::ROWS.map(|(name, unit, _)| (name, unit)))?;
        module.add("READINGS", Reading::ALL.map(|of| (of.name(), of.usual_error())))?;
        // Windows has no forks.
        if let Ok(register) = module.py().import("os")?.getattr("register_at_fork") {
            let after = [("after_in_child", module.getattr("forked")?)];
            register.call((), Some(&after.into_py_dict(module.py())?))?;
        }
        Ok(())
    }
}
