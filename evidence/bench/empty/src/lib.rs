//! All functions of FMI 2.0 co-simulation, and those of FMI 3.0 that a step takes, none of which does
//! anything.

use std::ffi::{c_char, c_void};
use std::ptr::without_provenance_mut;

type Handle = *mut c_void;
type Text = *const c_char;

/// Declares functions that return `fmi2OK`.
macro_rules! ok {
    ($($name:ident($($kind:ty),*);)*) => {$(
        #[unsafe(no_mangle)]
        extern "C" fn $name($(_: $kind),*) -> i32 {
            0
        }
    )*};
}

ok! {
    fmi2SetDebugLogging(Handle, i32, usize, *const Text);
    fmi2SetupExperiment(Handle, i32, f64, f64, i32, f64);
    fmi2EnterInitializationMode(Handle);
    fmi2ExitInitializationMode(Handle);
    fmi2Terminate(Handle);
    fmi2Reset(Handle);
    fmi2GetReal(Handle, *const u32, usize, *mut f64);
    fmi2GetInteger(Handle, *const u32, usize, *mut i32);
    fmi2GetBoolean(Handle, *const u32, usize, *mut i32);
    fmi2GetString(Handle, *const u32, usize, *mut Text);
    fmi2SetReal(Handle, *const u32, usize, *const f64);
    fmi2SetInteger(Handle, *const u32, usize, *const i32);
    fmi2SetBoolean(Handle, *const u32, usize, *const i32);
    fmi2SetString(Handle, *const u32, usize, *const Text);
    fmi2GetFMUstate(Handle, *mut Handle);
    fmi2SetFMUstate(Handle, Handle);
    fmi2FreeFMUstate(Handle, *mut Handle);
    fmi2SerializedFMUstateSize(Handle, Handle, *mut usize);
    fmi2SerializeFMUstate(Handle, Handle, *mut u8, usize);
    fmi2DeSerializeFMUstate(Handle, *const u8, usize, *mut Handle);
    fmi2GetDirectionalDerivative(
        Handle, *const u32, usize, *const u32, usize, *const f64, *mut f64);
    fmi2SetRealInputDerivatives(Handle, *const u32, usize, *const i32, *const f64);
    fmi2GetRealOutputDerivatives(Handle, *const u32, usize, *const i32, *mut f64);
    fmi2DoStep(Handle, f64, f64, i32);
    fmi2CancelStep(Handle);
    fmi2GetStatus(Handle, i32, *mut i32);
    fmi2GetRealStatus(Handle, i32, *mut f64);
    fmi2GetIntegerStatus(Handle, i32, *mut i32);
    fmi2GetBooleanStatus(Handle, i32, *mut i32);
    fmi2GetStringStatus(Handle, i32, *mut Text);
    fmi3EnterInitializationMode(Handle, bool, f64, f64, bool, f64);
    fmi3ExitInitializationMode(Handle);
    fmi3DoStep(Handle, f64, f64, bool, *mut bool, *mut bool, *mut bool, *mut f64);
    fmi3SetFloat64(Handle, *const u32, usize, *const f64, usize);
    fmi3GetFloat64(Handle, *const u32, usize, *mut f64, usize);
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetTypesPlatform() -> Text {
    c"default".as_ptr()
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetVersion() -> Text {
    c"2.0".as_ptr()
}

#[unsafe(no_mangle)]
extern "C" fn fmi2Instantiate(
    _: Text,
    _: i32,
    _: Text,
    _: Text,
    _: Handle,
    _: i32,
    _: i32,
) -> Handle {
    without_provenance_mut(1)
}

#[unsafe(no_mangle)]
extern "C" fn fmi2FreeInstance(_: Handle) {}

#[unsafe(no_mangle)]
extern "C" fn fmi3InstantiateCoSimulation(
    _: Text,
    _: Text,
    _: Text,
    _: bool,
    _: bool,
    _: bool,
    _: bool,
    _: *const u32,
    _: usize,
    _: Handle,
    _: *const c_void,
    _: *const c_void,
) -> Handle {
    without_provenance_mut(1)
}

#[unsafe(no_mangle)]
extern "C" fn fmi3FreeInstance(_: Handle) {}
