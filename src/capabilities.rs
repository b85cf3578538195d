//! The capabilities that this FMU declares. `description.rs` writes them.
//!
//! A comment at each names the code that implements it, and `tests/capabilities.rs` tests it.

use hammer::MAX_INPUT_ORDER;

/// Highest order of derivative that every output has. `fmi2GetRealOutputDerivatives` returns the first derivative of
/// every output, the second of some, and otherwise 0 (`instance/values.rs`).
pub const MAX_OUTPUT_ORDER: usize = 1;

/// The value reference of an output plus this number is an unknown of derivatives. It represents the dependence of the
/// output at the end of the last communication step on an input during that step (`instance/derivatives.rs`).
pub const OVER_STEP: u32 = 2_000_000;
/// Description of these value references.
pub const OVER_STEP_DESCRIPTION: &str = "As unknowns of directional derivatives, these value \
    references are the outputs' own and firstValueReference more: the derivative of an output at the \
    end of the last communication step by a constant added to an input during it";

/// Attributes of the `CoSimulation` element of FMI 2.0, with the names of the schema.
pub fn attributes() -> [(&'static str, String); 9] {
    let flag = |claimed: bool| claimed.to_string();
    [
        // `Instance::step` integrates to any communication point.
        ("canHandleVariableCommunicationStepSize", flag(true)),
        // `instance/inputs.rs` hands the polynomial to the engine.
        ("canInterpolateInputs", flag(MAX_INPUT_ORDER > 0)),
        ("maxOutputDerivativeOrder", MAX_OUTPUT_ORDER.to_string()),
        // A step is over when `fmi2DoStep` returns.
        ("canRunAsynchronuously", flag(false)),
        // The handle table is the only global, so there can be many instances (`registry.rs`).
        ("canBeInstantiatedOnlyOncePerProcess", flag(false)),
        // The host's allocator is never called, so it may be null.
        ("canNotUseMemoryManagementFunctions", flag(true)),
        // `instance/snapshot.rs` takes and restores states.
        ("canGetAndSetFMUstate", flag(true)),
        ("canSerializeFMUstate", flag(true)),
        // `instance/derivatives.rs` computes them.
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
        // Steps may end at blows and at positions (`instance/events.rs`).
        ("mightReturnEarlyFromDoStep", flag(true)),
        ("hasEventMode", flag(true)),
    ]
}
