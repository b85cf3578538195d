//! The functions of FMI 3.0. Functions with the same meaning in FMI 2.0 share its code.

use super::{Logger, fmi2, free_instance};
use crate::c::{self, Handle, In, Out, Status, Text};
use crate::error::CallError;
use crate::instance::{Face, Instance};
use crate::session::{self, call, sane};
use std::ffi::{CStr, c_char, c_void};

const CO_SIMULATION_ONLY: &str = "this FMU is for co-simulation only";

#[unsafe(no_mangle)]
extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

fn instantiate(
    [name, token]: [Text; 2],
    logging: u8,
    face: Result<Face, &str>,
    environment: *mut c_void,
    log: Option<c::LogMessage>,
) -> Handle {
    let logger = Logger::of_messages(log, environment);
    let texts = [&name, &token].map(|text| text.read().map(CStr::to_string_lossy));
    let face = face.map_err(str::to_owned);
    session::open(texts, face, logging != 0, &logger).map_or(Handle::NULL, Handle::of)
}

#[unsafe(no_mangle)]
extern "C" fn fmi3InstantiateModelExchange(
    name: Text,
    token: Text,
    _resources: Text,
    _visible: u8,
    logging: u8,
    environment: *mut c_void,
    log: Option<c::LogMessage>,
) -> Handle {
    instantiate([name, token], logging, Err(CO_SIMULATION_ONLY), environment, log)
}

#[unsafe(no_mangle)]
extern "C" fn fmi3InstantiateCoSimulation(
    name: Text,
    token: Text,
    _resources: Text,
    _visible: u8,
    logging: u8,
    event_mode: u8,
    early_return: u8,
    _intermediate: In<u32>,
    _intermediates: usize,
    environment: *mut c_void,
    log: Option<c::LogMessage>,
    _update: *const c_void,
) -> Handle {
    let face = Face::Three { event_mode: event_mode != 0, early_return: early_return != 0 };
    instantiate([name, token], logging, Ok(face), environment, log)
}

#[unsafe(no_mangle)]
extern "C" fn fmi3InstantiateScheduledExecution(
    name: Text,
    token: Text,
    _resources: Text,
    _visible: u8,
    logging: u8,
    environment: *mut c_void,
    log: Option<c::LogMessage>,
    _clock_update: *const c_void,
    _lock: *const c_void,
    _unlock: *const c_void,
) -> Handle {
    instantiate([name, token], logging, Err(CO_SIMULATION_ONLY), environment, log)
}

free_instance!(fmi3FreeInstance, fmi2::free);

#[unsafe(no_mangle)]
extern "C" fn fmi3SetDebugLogging(me: Handle, on: u8, n: usize, names: In<Text>) -> Status {
    fmi2::fmi2SetDebugLogging(me, i32::from(on != 0), n, names)
}

#[unsafe(no_mangle)]
extern "C" fn fmi3EnterInitializationMode(
    me: Handle,
    _tolerance_defined: u8,
    _tolerance: f64,
    start: f64,
    stop_defined: u8,
    stop: f64,
) -> Status {
    call(me, |instance| {
        instance.leave_configuration_first()?;
        instance.set_up(start, (stop_defined != 0).then_some(stop))?;
        instance.enter_initialization()
    })
}

/// Functions whose only argument is the instance.
macro_rules! plain {
    ($($name:ident: $work:expr;)*) => {$(
        #[unsafe(no_mangle)]
        extern "C" fn $name(me: Handle) -> Status {
            call(me, $work)
        }
    )*};
}

plain! {
    fmi3ExitInitializationMode: Instance::exit_initialization;
    fmi3EnterEventMode: Instance::enter_event_mode;
    fmi3EnterStepMode: Instance::enter_step_mode;
    fmi3EnterConfigurationMode: Instance::enter_configuration;
    fmi3ExitConfigurationMode: Instance::exit_configuration;
    fmi3EvaluateDiscreteStates: |instance| instance.demand_event_mode("EvaluateDiscreteStates");
    fmi3EnterContinuousTimeMode: |_| Err(foreign("EnterContinuousTimeMode"));
    fmi3Terminate: Instance::terminate;
    fmi3Reset: |instance| { instance.reset(); Ok(()) };
}

fn foreign(name: &str) -> CallError {
    CallError::Argument(format!("fmi3{name}: {CO_SIMULATION_ONLY}"))
}

/// Writes the values that were read. Their number must be the one that the host expects.
fn hand_over<T: Copy>(found: &[T], values: &Out<T>, room: usize) -> Result<(), CallError> {
    fits(found.len(), room)?;
    found.iter().enumerate().try_for_each(|(index, value)| values.write(index, *value, "values"))
}

fn fits(needed: usize, room: usize) -> Result<(), CallError> {
    if needed == room {
        return Ok(());
    }
    let text = format!("nValues = {room}, but these variables have {needed} values");
    Err(CallError::Argument(text))
}

/// The getter and the setter of a type.
macro_rules! typed {
    ($($get:ident, $set:ident: $kind:ty, $read:expr, $write:expr;)*) => {$(
        #[unsafe(no_mangle)]
        extern "C" fn $get(
            me: Handle, vr: In<u32>, n: usize, values: Out<$kind>, count: usize,
        ) -> Status {
            call(me, |instance| {
                let references = vr.array(sane(n)?, "valueReferences")?;
                // Checked before reading, because arrays are long and a call may name them many times.
                fits(references.iter().map(|reference| instance.count(*reference)).sum(), count)?;
                let mut found = Vec::with_capacity(count);
                for reference in references {
                    $read(instance, *reference, &mut found)?;
                }
                hand_over(&found, &values, count)
            })
        }

        #[unsafe(no_mangle)]
        extern "C" fn $set(
            me: Handle, vr: In<u32>, n: usize, values: In<$kind>, count: usize,
        ) -> Status {
            call(me, |instance| {
                let references = vr.array(sane(n)?, "valueReferences")?;
                // Arrays cannot be set.
                scalars(count, n, "nValues")?;
                $write(instance, references, values.array(n, "values")?)
            })
        }
    )*};
}

fn none_to_get<T>(reference: u32, wanted: &'static str) -> Result<T, CallError> {
    Err(CallError::Reference { reference, wanted })
}

fn none_to_set(references: &[u32], wanted: &'static str) -> Result<(), CallError> {
    references.first().map_or(Ok(()), |reference| none_to_get(*reference, wanted))
}

/// Functions for types that no variable has.
macro_rules! none {
    ($($get:ident, $set:ident: $kind:ty, $wanted:literal;)*) => {
        typed! {$(
            $get, $set: $kind,
                |_: &mut Instance, vr, _: &mut Vec<$kind>| none_to_get::<()>(vr, $wanted),
                |_: &mut Instance, vr: &[u32], _: &[$kind]| none_to_set(vr, $wanted);
        )*}
    };
}

typed! {
    fmi3GetFloat64, fmi3SetFloat64: f64, Instance::float64s, Instance::set_float64s;
    fmi3GetInt32, fmi3SetInt32: i32, Instance::int32, Instance::set_int32s;
    fmi3GetInt64, fmi3SetInt64: i64, Instance::int64, Instance::set_int64s;
    fmi3GetUInt64, fmi3SetUInt64: u64, Instance::uint64, Instance::set_uint64s;
    fmi3GetBoolean, fmi3SetBoolean: u8, Instance::truth, Instance::set_truths;
}

none! {
    fmi3GetFloat32, fmi3SetFloat32: f32, "a Float32 variable";
    fmi3GetInt8, fmi3SetInt8: i8, "an Int8 variable";
    fmi3GetUInt8, fmi3SetUInt8: u8, "a UInt8 variable";
    fmi3GetInt16, fmi3SetInt16: i16, "an Int16 variable";
    fmi3GetUInt16, fmi3SetUInt16: u16, "a UInt16 variable";
    fmi3GetUInt32, fmi3SetUInt32: u32, "a UInt32 variable";
    fmi3GetString, fmi3SetString: Text, "a String variable";
}

#[unsafe(no_mangle)]
extern "C" fn fmi3GetBinary(
    me: Handle,
    vr: In<u32>,
    n: usize,
    _sizes: Out<usize>,
    _values: Out<*const u8>,
    _count: usize,
) -> Status {
    call(me, |_| none_to_set(vr.array(sane(n)?, "valueReferences")?, "a Binary variable"))
}

#[unsafe(no_mangle)]
extern "C" fn fmi3SetBinary(
    me: Handle,
    vr: In<u32>,
    n: usize,
    _sizes: In<usize>,
    _values: In<*const u8>,
    _count: usize,
) -> Status {
    call(me, |_| none_to_set(vr.array(sane(n)?, "valueReferences")?, "a Binary variable"))
}

/// Functions for clocks, which do not exist here.
macro_rules! clocks {
    ($($name:ident: $($kind:ty),*;)*) => {$(
        #[unsafe(no_mangle)]
        extern "C" fn $name(me: Handle, vr: In<u32>, n: usize $(, _: $kind)*) -> Status {
            call(me, |_| none_to_set(vr.array(sane(n)?, "valueReferences")?, "a clock"))
        }
    )*};
}

clocks! {
    fmi3GetClock: Out<u8>;
    fmi3SetClock: In<u8>;
    fmi3GetIntervalDecimal: Out<f64>, Out<i32>;
    fmi3GetIntervalFraction: Out<u64>, Out<u64>, Out<i32>;
    fmi3GetShiftDecimal: Out<f64>;
    fmi3GetShiftFraction: Out<u64>, Out<u64>;
    fmi3SetIntervalDecimal: In<f64>;
    fmi3SetIntervalFraction: In<u64>, In<u64>;
    fmi3SetShiftDecimal: In<f64>;
    fmi3SetShiftFraction: In<u64>, In<u64>;
}

/// Functions that this FMU does not offer, according to its description.
macro_rules! foreign {
    ($($name:ident: $($kind:ty),*;)*) => {$(
        #[unsafe(no_mangle)]
        extern "C" fn $name(me: Handle $(, _: $kind)*) -> Status {
            call(me, |_| Err(foreign(stringify!($name).trim_start_matches("fmi3"))))
        }
    )*};
}

foreign! {
    fmi3CompletedIntegratorStep: u8, Out<u8>, Out<u8>;
    fmi3SetTime: f64;
    fmi3SetContinuousStates: In<f64>, usize;
    fmi3GetContinuousStateDerivatives: Out<f64>, usize;
    fmi3GetEventIndicators: Out<f64>, usize;
    fmi3GetContinuousStates: Out<f64>, usize;
    fmi3GetNominalsOfContinuousStates: Out<f64>, usize;
    fmi3GetNumberOfEventIndicators: Out<usize>;
    fmi3GetNumberOfContinuousStates: Out<usize>;
    fmi3ActivateModelPartition: u32, f64;
}

#[unsafe(no_mangle)]
extern "C" fn fmi3GetNumberOfVariableDependencies(
    me: Handle,
    _reference: u32,
    _count: Out<usize>,
) -> Status {
    call(me, |_| Err(no_dependencies()))
}

#[unsafe(no_mangle)]
extern "C" fn fmi3GetVariableDependencies(
    me: Handle,
    _dependent: u32,
    _elements: Out<usize>,
    _independents: Out<u32>,
    _independent_elements: Out<usize>,
    _kinds: Out<i32>,
    _count: usize,
) -> Status {
    call(me, |_| Err(no_dependencies()))
}

fn no_dependencies() -> CallError {
    let text = "providesPerElementDependencies is false: the description has all dependencies";
    CallError::Argument(text.into())
}

#[unsafe(no_mangle)]
extern "C" fn fmi3GetFMUState(me: Handle, state: Out<Handle>) -> Status {
    fmi2::fmi2GetFMUstate(me, state)
}

#[unsafe(no_mangle)]
extern "C" fn fmi3SetFMUState(me: Handle, state: Handle) -> Status {
    fmi2::fmi2SetFMUstate(me, state)
}

#[unsafe(no_mangle)]
extern "C" fn fmi3FreeFMUState(me: Handle, state: Out<Handle>) -> Status {
    fmi2::fmi2FreeFMUstate(me, state)
}

#[unsafe(no_mangle)]
extern "C" fn fmi3SerializedFMUStateSize(me: Handle, state: Handle, size: Out<usize>) -> Status {
    fmi2::fmi2SerializedFMUstateSize(me, state, size)
}

#[unsafe(no_mangle)]
extern "C" fn fmi3SerializeFMUState(
    me: Handle,
    state: Handle,
    bytes: Out<u8>,
    size: usize,
) -> Status {
    fmi2::fmi2SerializeFMUstate(me, state, bytes, size)
}

#[unsafe(no_mangle)]
extern "C" fn fmi3DeserializeFMUState(
    me: Handle,
    bytes: In<u8>,
    size: usize,
    state: Out<Handle>,
) -> Status {
    fmi2::fmi2DeSerializeFMUstate(me, bytes, size, state)
}

#[unsafe(no_mangle)]
extern "C" fn fmi3GetDirectionalDerivative(
    me: Handle,
    unknowns: In<u32>,
    unknown_count: usize,
    knowns: In<u32>,
    known_count: usize,
    seed: In<f64>,
    seed_count: usize,
    sensitivity: Out<f64>,
    sensitivity_count: usize,
) -> Status {
    call(me, |instance| {
        let unknowns = unknowns.array(sane(unknown_count)?, "unknowns")?;
        let knowns = knowns.array(sane(known_count)?, "knowns")?;
        scalars(seed_count, known_count, "nSeed")?;
        let found = instance.directional(unknowns, knowns, seed.array(seed_count, "seed")?)?;
        hand_over(&found, &sensitivity, sensitivity_count)
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi3GetAdjointDerivative(
    me: Handle,
    unknowns: In<u32>,
    unknown_count: usize,
    knowns: In<u32>,
    known_count: usize,
    seed: In<f64>,
    seed_count: usize,
    sensitivity: Out<f64>,
    sensitivity_count: usize,
) -> Status {
    call(me, |instance| {
        let unknowns = unknowns.array(sane(unknown_count)?, "unknowns")?;
        let knowns = knowns.array(sane(known_count)?, "knowns")?;
        let values = unknowns.iter().map(|unknown| instance.count(*unknown)).sum();
        scalars(seed_count, values, "nSeed")?;
        let found = instance.adjoint(unknowns, knowns, seed.array(seed_count, "seed")?)?;
        hand_over(&found, &sensitivity, sensitivity_count)
    })
}

fn scalars(count: usize, variables: usize, name: &str) -> Result<(), CallError> {
    if count == variables {
        return Ok(());
    }
    Err(CallError::Argument(format!("{name} = {count} for {variables} scalar variables")))
}

#[unsafe(no_mangle)]
extern "C" fn fmi3UpdateDiscreteStates(
    me: Handle,
    need_update: Out<u8>,
    terminate: Out<u8>,
    nominals_changed: Out<u8>,
    values_changed: Out<u8>,
    next_defined: Out<u8>,
    next: Out<f64>,
) -> Status {
    call(me, |instance| {
        // Events are complete when their step returns, so nothing changes here.
        instance.demand_event_mode("UpdateDiscreteStates")?;
        for flag in [need_update, terminate, nominals_changed, values_changed, next_defined] {
            flag.write(0, 0, "a flag of fmi3UpdateDiscreteStates")?;
        }
        next.write(0, 0.0, "nextEventTime")
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi3GetOutputDerivatives(
    me: Handle,
    vr: In<u32>,
    n: usize,
    orders: In<i32>,
    values: Out<f64>,
    count: usize,
) -> Status {
    call(me, |instance| {
        scalars(count, n, "nValues")?;
        let orders = orders.array(sane(n)?, "orders")?;
        let pairs = vr.array(n, "valueReferences")?.iter().zip(orders);
        for (index, (reference, order)) in pairs.enumerate() {
            values.write(index, instance.output_derivative(*reference, *order)?, "values")?;
        }
        Ok(())
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi3DoStep(
    me: Handle,
    point: f64,
    size: f64,
    _no_set_state: u8,
    event_needed: Out<u8>,
    terminate: Out<u8>,
    early: Out<u8>,
    last: Out<f64>,
) -> Status {
    call(me, |instance| {
        for flag in [&event_needed, &terminate, &early] {
            flag.write(0, 0, "a flag of fmi3DoStep")?;
        }
        last.write(0, instance.time(), "lastSuccessfulTime")?;
        let ended = instance.step_to_event(point, size);
        last.write(0, instance.time(), "lastSuccessfulTime")?;
        let [event, is_early] = ended?;
        event_needed.write(0, u8::from(event), "eventHandlingNeeded")?;
        early.write(0, u8::from(is_early), "earlyReturn")
    })
}
