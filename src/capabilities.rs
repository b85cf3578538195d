//! The capabilities that this FMU declares; `description.rs` writes them.
//!
//! Each names the code that implements it, and `tests/capabilities.rs` tests it.

use hammer::MAX_INPUT_ORDER;

/// Highest derivative that `fmi2GetRealOutputDerivatives` accepts: it returns the first of every
/// output, the second of some, and otherwise 0 (`instance/values.rs`).
pub const MAX_OUTPUT_ORDER: usize = 1;

/// Value references from here on are unknowns of derivatives: by how much the output whose reference is this much
/// lower depends on an input over the last communication step (`instance/derivatives.rs`).
pub const OVER_STEP: u32 = 2_000_000;
/// Their description.
pub const OVER_STEP_DESCRIPTION: &str = "As unknowns of directional derivatives, these value \
    references are the outputs' own and firstValueReference more: the derivative of an output at the \
    end of the last communication step by a constant added to an input during it";

/// Attributes of the `CoSimulation` element, in the schema's names.
pub fn attributes() -> [(&'static str, String); 9] {
    let flag = |claimed: bool| claimed.to_string();
    [
        // `Instance::step` integrates to any point.
        ("canHandleVariableCommunicationStepSize", flag(true)),
        // `instance/inputs.rs` hands the polynomial to the engine.
        ("canInterpolateInputs", flag(MAX_INPUT_ORDER > 0)),
        ("maxOutputDerivativeOrder", MAX_OUTPUT_ORDER.to_string()),
        // A step is over when `fmi2DoStep` returns.
        ("canRunAsynchronuously", flag(false)),
        // No globals but the handle table: any number of instances (`registry.rs`).
        ("canBeInstantiatedOnlyOncePerProcess", flag(false)),
        // The host's allocator is never called, so it may be null.
        ("canNotUseMemoryManagementFunctions", flag(true)),
        // `instance/snapshot.rs`.
        ("canGetAndSetFMUstate", flag(true)),
        ("canSerializeFMUstate", flag(true)),
        // `instance/derivatives.rs`.
        ("providesDirectionalDerivative", flag(true)),
    ]
}

/// Attributes of the `CoSimulation` element of FMI 3.0.
pub fn attributes_3() -> [(&'static str, String); 9] {
    let flag = |claimed: bool| claimed.to_string();
    [
        ("canBeInstantiatedOnlyOncePerProcess", flag(false)),
        ("canGetAndSetFMUState", flag(true)),
        ("canSerializeFMUState", flag(true)),
        ("providesDirectionalDerivatives", flag(true)),
        ("providesAdjointDerivatives", flag(true)),
        ("canHandleVariableCommunicationStepSize", flag(true)),
        ("maxOutputDerivativeOrder", MAX_OUTPUT_ORDER.to_string()),
        // `instance/events.rs`: steps end at blows and at positions.
        ("mightReturnEarlyFromDoStep", flag(true)),
        ("hasEventMode", flag(true)),
    ]
}
