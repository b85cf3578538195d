//! FMI 2.0 co-simulation face of the down-the-hole hammer.
//!
//! Hosts see only the C functions of `abi`, which hand every call to one
//! `Instance`, which hands the physics to the crate `hammer`. What is public
//! here is for packaging and tests.

#[allow(unsafe_code, reason = "the C boundary is here and nowhere else")]
mod abi;
pub mod blows;
mod c;
pub mod capabilities;
pub mod category;
mod fault;
mod instance;
mod registry;
mod session;
pub mod variant;
pub mod waves;

pub use registry::{CAPACITY, READABLE};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// The model description that this library was built with.
pub const MODEL_DESCRIPTION: &str = include_str!(concat!(env!("OUT_DIR"), "/modelDescription.xml"));
/// Fingerprint of the model description: a host and a state must come with the same.
pub const GUID: &str = env!("DTH_GUID");

/// Name of the shared library, without what the platform adds to it.
pub const MODEL_IDENTIFIER: &str = "dth_hammer";
/// The functions that it exports: those of FMI 2.0 for co-simulation, without their `fmi2`.
pub const FUNCTIONS: &str = "
    GetTypesPlatform GetVersion SetDebugLogging Instantiate FreeInstance SetupExperiment
    EnterInitializationMode ExitInitializationMode Terminate Reset GetReal GetInteger
    GetBoolean GetString SetReal SetInteger SetBoolean SetString GetFMUstate SetFMUstate
    FreeFMUstate SerializedFMUstateSize SerializeFMUstate DeSerializeFMUstate
    GetDirectionalDerivative SetRealInputDerivatives GetRealOutputDerivatives DoStep
    CancelStep GetStatus GetRealStatus GetIntegerStatus GetBooleanStatus GetStringStatus";
