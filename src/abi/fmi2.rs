//! The functions of FMI 2.0.

use super::{Logger, Residence, free_instance};
use crate::c::{self, Handle, In, Out, Status, Text};
use crate::error::CallError;
use crate::instance::{Face, Instance, Snapshot};
use crate::session::{self, call, sane};
use std::ffi::{CStr, c_char, c_void};

/// There are no string variables.
const STRING: &str = "a string variable";

fn get<T: Copy>(
    me: Handle,
    references: In<u32>,
    count: usize,
    values: Out<T>,
    mut read: impl FnMut(&mut Instance, u32) -> Result<T, CallError>,
) -> Status {
    call(me, |instance| {
        for (index, reference) in references.array(sane(count)?, "vr")?.iter().enumerate() {
            values.write(index, read(instance, *reference)?, "value")?;
        }
        Ok(())
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

#[unsafe(no_mangle)]
extern "C" fn fmi2Instantiate(
    name: Text,
    kind: i32,
    guid: Text,
    _resources: Text,
    functions: In<c::Callbacks>,
    _visible: i32,
    logging: i32,
) -> Handle {
    let logger = Logger::of(&functions, name);
    let texts = [&name, &guid].map(|text| text.read().map(CStr::to_string_lossy));
    let face = match kind {
        c::CO_SIMULATION => Ok(Face::Two),
        _ => Err(format!("fmuType = {kind}: this FMU is for co-simulation (1) only")),
    };
    session::open(texts, face, logging != 0, &logger).map_or(Handle::NULL, Handle::of)
}

/// Frees an instance. Returns its reference to the library, or null.
pub(super) extern "C" fn free(me: Handle) -> *mut c_void {
    session::close(me.number()).map_or(std::ptr::null_mut(), Residence::into_raw)
}

free_instance!(fmi2FreeInstance, free);

#[unsafe(no_mangle)]
pub extern "C" fn fmi2SetDebugLogging(
    me: Handle,
    on: i32,
    count: usize,
    categories: In<Text>,
) -> Status {
    call(me, |instance| {
        let names = categories.array(sane(count)?, "categories")?;
        let names: Option<Vec<String>> =
            names.iter().map(|n| n.read().map(|n| n.to_string_lossy().into_owned())).collect();
        instance.switch_logging(on != 0, &names.ok_or(CallError::Pointer("categories"))?)
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi2SetupExperiment(
    me: Handle,
    _tolerance_defined: i32,
    _tolerance: f64,
    start: f64,
    stop_defined: i32,
    stop: f64,
) -> Status {
    call(me, |instance| instance.set_up(start, (stop_defined != 0).then_some(stop)))
}

#[unsafe(no_mangle)]
extern "C" fn fmi2EnterInitializationMode(me: Handle) -> Status {
    call(me, Instance::enter_initialization)
}

#[unsafe(no_mangle)]
extern "C" fn fmi2ExitInitializationMode(me: Handle) -> Status {
    call(me, Instance::exit_initialization)
}

#[unsafe(no_mangle)]
extern "C" fn fmi2Terminate(me: Handle) -> Status {
    call(me, Instance::terminate)
}

#[unsafe(no_mangle)]
extern "C" fn fmi2Reset(me: Handle) -> Status {
    call(me, |instance| {
        instance.reset();
        Ok(())
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetReal(me: Handle, vr: In<u32>, n: usize, value: Out<f64>) -> Status {
    get(me, vr, n, value, Instance::real)
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetInteger(me: Handle, vr: In<u32>, n: usize, value: Out<i32>) -> Status {
    get(me, vr, n, value, Instance::integer)
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetBoolean(me: Handle, vr: In<u32>, n: usize, value: Out<i32>) -> Status {
    get(me, vr, n, value, |instance, vr| instance.boolean(vr).map(i32::from))
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetString(me: Handle, vr: In<u32>, n: usize, value: Out<Text>) -> Status {
    get(me, vr, n, value, |_, reference| Err(CallError::Reference { reference, wanted: STRING }))
}

#[unsafe(no_mangle)]
extern "C" fn fmi2SetReal(me: Handle, vr: In<u32>, n: usize, value: In<f64>) -> Status {
    call(me, |instance| instance.set_reals(vr.array(sane(n)?, "vr")?, value.array(n, "value")?))
}

#[unsafe(no_mangle)]
extern "C" fn fmi2SetInteger(me: Handle, vr: In<u32>, n: usize, value: In<i32>) -> Status {
    call(me, |instance| instance.set_integers(vr.array(sane(n)?, "vr")?, value.array(n, "value")?))
}

#[unsafe(no_mangle)]
extern "C" fn fmi2SetBoolean(me: Handle, vr: In<u32>, n: usize, value: In<i32>) -> Status {
    call(me, |instance| {
        value.array(sane(n)?, "value")?;
        instance.set_booleans(vr.array(n, "vr")?)
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi2SetString(me: Handle, vr: In<u32>, n: usize, _value: In<Text>) -> Status {
    call(me, |_| match vr.array(sane(n)?, "vr")?.first() {
        Some(vr) => Err(CallError::Reference { reference: *vr, wanted: STRING }),
        None => Ok(()),
    })
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetFMUstate(me: Handle, state: Out<Handle>) -> Status {
    call(me, |instance| {
        let known = state.read("FMUstate")?;
        keep(known, instance.snapshot(), &state)
    })
}

fn keep(known: Handle, snapshot: Snapshot, state: &Out<Handle>) -> Result<(), CallError> {
    let stored = session::keep(known.number(), snapshot)?;
    state.write(0, Handle::of(stored), "FMUstate")
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2SetFMUstate(me: Handle, state: Handle) -> Status {
    call(me, |instance| instance.restore(&*session::state(state.number())?))
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2FreeFMUstate(me: Handle, state: Out<Handle>) -> Status {
    call(me, |_| {
        // Freeing nothing is allowed, as with free(3).
        let Ok(handle) = state.read("FMUstate") else { return Ok(()) };
        session::forget(handle.number())?;
        state.write(0, Handle::NULL, "FMUstate")
    })
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2SerializedFMUstateSize(
    me: Handle,
    state: Handle,
    size: Out<usize>,
) -> Status {
    call(me, |_| {
        let snapshot = session::state(state.number())?;
        size.write(0, snapshot.bytes()?.len(), "size")
    })
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2SerializeFMUstate(
    me: Handle,
    state: Handle,
    bytes: Out<u8>,
    size: usize,
) -> Status {
    call(me, |_| {
        let snapshot = session::state(state.number())?;
        let source = snapshot.bytes()?;
        if size < source.len() {
            let text = format!("{size} bytes are too few for a state of {}", source.len());
            return Err(CallError::Argument(text));
        }
        source.iter().enumerate().try_for_each(|(i, byte)| bytes.write(i, *byte, "serializedState"))
    })
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2DeSerializeFMUstate(
    me: Handle,
    bytes: In<u8>,
    size: usize,
    state: Out<Handle>,
) -> Status {
    call(me, |_| {
        let known = state.read("FMUstate")?;
        keep(known, Snapshot::from_bytes(bytes.array(size, "serializedState")?)?, &state)
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetDirectionalDerivative(
    me: Handle,
    unknown: In<u32>,
    unknowns: usize,
    known: In<u32>,
    knowns: usize,
    direction: In<f64>,
    derivative: Out<f64>,
) -> Status {
    call(me, |instance| {
        let unknown = unknown.array(sane(unknowns)?, "vUnknown_ref")?;
        let known = known.array(sane(knowns)?, "vKnown_ref")?;
        let direction = direction.array(knowns, "dvKnown")?;
        let found = instance.directional(unknown, known, direction)?;
        for (index, value) in found.into_iter().enumerate() {
            derivative.write(index, value, "dvUnknown")?;
        }
        Ok(())
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi2SetRealInputDerivatives(
    me: Handle,
    vr: In<u32>,
    n: usize,
    order: In<i32>,
    value: In<f64>,
) -> Status {
    call(me, |instance| {
        let references = vr.array(sane(n)?, "vr")?;
        instance.set_input_derivatives(
            references,
            order.array(n, "order")?,
            value.array(n, "value")?,
        )
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetRealOutputDerivatives(
    me: Handle,
    vr: In<u32>,
    n: usize,
    order: In<i32>,
    value: Out<f64>,
) -> Status {
    call(me, |instance| {
        let orders = order.array(sane(n)?, "order")?;
        let pairs = vr.array(n, "vr")?.iter().zip(orders);
        for (index, (reference, order)) in pairs.enumerate() {
            value.write(index, instance.output_derivative(*reference, *order)?, "value")?;
        }
        Ok(())
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi2DoStep(me: Handle, point: f64, size: f64, _no_set_state: i32) -> Status {
    call(me, |instance| instance.step(point, size).map(drop))
}

#[unsafe(no_mangle)]
extern "C" fn fmi2CancelStep(me: Handle) -> Status {
    if session::cancel(me) { Status::Ok } else { call(me, |_| Err(CallError::NothingToCancel)) }
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetStatus(me: Handle, kind: i32, value: Out<i32>) -> Status {
    call(me, |instance| match kind {
        c::DO_STEP_STATUS => {
            let last = if instance.last_step_failed() { Status::Error } else { Status::Ok };
            value.write(0, last as i32, "value")
        }
        _ => Err(unknown_kind("fmi2GetStatus", kind)),
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetRealStatus(me: Handle, kind: i32, value: Out<f64>) -> Status {
    call(me, |instance| match kind {
        c::LAST_SUCCESSFUL_TIME => value.write(0, instance.time(), "value"),
        _ => Err(unknown_kind("fmi2GetRealStatus", kind)),
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetIntegerStatus(me: Handle, kind: i32, _value: Out<i32>) -> Status {
    call(me, |_| Err(unknown_kind("fmi2GetIntegerStatus", kind)))
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetBooleanStatus(me: Handle, kind: i32, value: Out<i32>) -> Status {
    call(me, |_| match kind {
        // The hammer never ends the simulation itself.
        c::TERMINATED => value.write(0, 0, "value"),
        _ => Err(unknown_kind("fmi2GetBooleanStatus", kind)),
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetStringStatus(me: Handle, kind: i32, value: Out<Text>) -> Status {
    call(me, |_| match kind {
        c::PENDING_STATUS => value.write(0, Text::of(c"no step is pending"), "value"),
        _ => Err(unknown_kind("fmi2GetStringStatus", kind)),
    })
}

fn unknown_kind(call: &'static str, kind: i32) -> CallError {
    CallError::Argument(format!("{call} does not know a status of kind {kind}"))
}
