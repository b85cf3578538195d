//! The down-the-hole hammer as a co-simulation unit of FMI 2.0 and 3.0.
//!
//! Hosts call only the C functions of `abi`. These pass every call to an `Instance`, which uses the crate `hammer` for
//! the physics. Public items are for packaging and tests.

#[allow(unsafe_code, reason = "the C boundary is here and nowhere else")]
mod abi;
mod c;
pub mod capabilities;
pub mod category;
#[cfg(any(target_family = "wasm", test))]
mod datasheet;
pub mod description;
pub mod description3;
mod error;
pub mod events;
mod instance;
mod registry;
mod session;
pub mod variant;

pub use registry::{CAPACITY, READABLE};

use std::collections::BTreeSet;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// The model description that this library was built with.
pub const MODEL_DESCRIPTION: &str = include_str!("../modelDescription.xml");
/// Fingerprint of the model description. A host and a stored state must present the same one.
pub const GUID: &str = quoted_after(MODEL_DESCRIPTION, "guid=\"");

/// The model description of FMI 3.0.
pub const MODEL_DESCRIPTION_3: &str = include_str!("../modelDescription3.xml");
/// Fingerprint of the model description of FMI 3.0.
pub const TOKEN: &str = quoted_after(MODEL_DESCRIPTION_3, "instantiationToken=\"");

/// The text between the end of `mark` and the next quotation mark, found at compile time.
const fn quoted_after(text: &'static str, mark: &str) -> &'static str {
    let (bytes, mark) = (text.as_bytes(), mark.as_bytes());
    let (mut start, mut matched) = (0, 0);
    while matched < mark.len() {
        matched = if bytes[start] == mark[matched] { matched + 1 } else { 0 };
        start += 1;
    }
    let mut end = start;
    while bytes[end] != b'"' {
        end += 1;
    }
    text.split_at(end).0.split_at(start).1
}

/// The symbols that the library exports: exactly those of FMI 2.0 and 3.0.
pub fn symbols() -> BTreeSet<String> {
    let prefixed = |functions: &str, prefix: &str| {
        functions.split_whitespace().map(|name| format!("{prefix}{name}")).collect::<Vec<_>>()
    };
    [prefixed(FUNCTIONS, "fmi2"), prefixed(FUNCTIONS_3, "fmi3")].concat().into_iter().collect()
}

/// Name of the shared library, without the platform's prefix and suffix.
pub const MODEL_IDENTIFIER: &str = "dth_hammer";
/// The functions of FMI 2.0 for co-simulation, without the prefix `fmi2`.
const FUNCTIONS: &str = "
    GetTypesPlatform GetVersion SetDebugLogging Instantiate FreeInstance SetupExperiment
    EnterInitializationMode ExitInitializationMode Terminate Reset GetReal GetInteger
    GetBoolean GetString SetReal SetInteger SetBoolean SetString GetFMUstate SetFMUstate
    FreeFMUstate SerializedFMUstateSize SerializeFMUstate DeSerializeFMUstate
    GetDirectionalDerivative SetRealInputDerivatives GetRealOutputDerivatives DoStep
    CancelStep GetStatus GetRealStatus GetIntegerStatus GetBooleanStatus GetStringStatus";
/// The functions of FMI 3.0, without the prefix `fmi3`.
const FUNCTIONS_3: &str = "
    GetVersion SetDebugLogging InstantiateModelExchange InstantiateCoSimulation
    InstantiateScheduledExecution FreeInstance EnterInitializationMode ExitInitializationMode
    EnterEventMode Terminate Reset GetFloat32 GetFloat64 GetInt8 GetUInt8 GetInt16 GetUInt16
    GetInt32 GetUInt32 GetInt64 GetUInt64 GetBoolean GetString GetBinary GetClock SetFloat32
    SetFloat64 SetInt8 SetUInt8 SetInt16 SetUInt16 SetInt32 SetUInt32 SetInt64 SetUInt64
    SetBoolean SetString SetBinary SetClock GetNumberOfVariableDependencies
    GetVariableDependencies GetFMUState SetFMUState FreeFMUState SerializedFMUStateSize
    SerializeFMUState DeserializeFMUState GetDirectionalDerivative GetAdjointDerivative
    EnterConfigurationMode ExitConfigurationMode GetIntervalDecimal GetIntervalFraction
    GetShiftDecimal GetShiftFraction SetIntervalDecimal SetIntervalFraction SetShiftDecimal
    SetShiftFraction EvaluateDiscreteStates UpdateDiscreteStates EnterContinuousTimeMode
    CompletedIntegratorStep SetTime SetContinuousStates GetContinuousStateDerivatives
    GetEventIndicators GetContinuousStates GetNominalsOfContinuousStates
    GetNumberOfEventIndicators GetNumberOfContinuousStates EnterStepMode GetOutputDerivatives
    DoStep ActivateModelPartition";
