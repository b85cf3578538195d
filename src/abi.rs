//! The C face: the only file with unsafe code.
//!
//! All that is unsafe are five things done with what C hands over, at the end of
//! this file: reading an array, writing an element, reading a string, reading the
//! callbacks, calling the logger. The functions themselves are safe Rust around
//! them. None lets a panic reach the host, none follows a handle that is not live,
//! and none returns anything but `fmi2OK` and `fmi2Error`: some hosts repeat a
//! discarded step for ever, others end a run on a warning.

use crate::category::Category;
use crate::fault::Fault;
use crate::instance::{Instance, Line, Snapshot};
use crate::registry::{CAPACITY, Shelf, Table};
use crate::variables::VARIABLES;
use crate::waves::{self, Variant};
use crate::{GUID, c};
use std::ffi::{CStr, CString, c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use c::{Handle, In, Out, Status, Text};

static INSTANCES: Table<Entry> = Table::new();
static STATES: Shelf<Snapshot> = Shelf::new();

/// There are none.
const STRING: &str = "a string variable";

struct Entry {
    instance: Instance,
    logger: Logger,
}

/// Where log lines go.
#[derive(Clone)]
struct Logger {
    function: Option<c::LoggerFunction>,
    environment: *mut c_void,
    name: Arc<CStr>,
}

/// Runs `work` on a live instance; then, without holding it, tells the host what was logged.
fn call(me: Handle, work: impl FnOnce(&mut Instance) -> Result<(), Fault>) -> Status {
    let guarded = catch_unwind(AssertUnwindSafe(|| {
        let Some(mut held) = INSTANCES.hold(me.number()) else { return Status::Error };
        let Some(entry) = held.get() else { return Status::Error };
        let instance = &mut entry.instance;
        let result = match catch_unwind(AssertUnwindSafe(|| work(instance))) {
            Ok(result) => result,
            Err(payload) => {
                instance.give_up();
                Err(Fault::of_panic(&*payload))
            }
        };
        if let Err(fault) = &result {
            instance.complain(fault);
        }
        let lines = instance.take_lines();
        if !lines.is_empty() {
            let logger = entry.logger.clone();
            drop(held);
            lines.iter().for_each(|line| logger.log(line));
        }
        if result.is_ok() { Status::Ok } else { Status::Error }
    }));
    guarded.unwrap_or(Status::Error)
}

/// A count that a host can mean. Beyond it lies memory that is not the host's array.
fn sane(count: usize) -> Result<usize, Fault> {
    let variables = VARIABLES.len() + waves::CAPACITY;
    if count <= 4 * variables { Ok(count) } else { Err(Fault::TooMany { count, variables }) }
}

fn get<T: Copy>(
    me: Handle,
    references: In<u32>,
    count: usize,
    values: Out<T>,
    mut read: impl FnMut(&mut Instance, u32) -> Result<T, Fault>,
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
extern "C" fn fmi2GetVersion() -> *const c_char {
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
    let made = catch_unwind(AssertUnwindSafe(|| {
        let logger = Logger::of(&functions, name);
        let refuse = |text: String| {
            logger.log(&Line { category: Category::Error, text });
            Handle::NULL
        };
        if name.read().is_none() {
            return refuse("instanceName is null".into());
        }
        if kind != c::CO_SIMULATION {
            return refuse(format!("fmuType = {kind}: this FMU is for co-simulation (1) only"));
        }
        let Some(given) = guid.read() else { return refuse("fmuGUID is null".into()) };
        let Some(variant) = Variant::named(&given.to_string_lossy(), GUID) else {
            return refuse(format!("fmuGUID is {given:?}, not {GUID:?}"));
        };
        let instance = Instance::new(variant, logging != 0);
        let entry = Entry { instance, logger: logger.clone() };
        match INSTANCES.insert(entry) {
            Some(number) => Handle::of(number),
            None => refuse(format!("{CAPACITY} instances live already")),
        }
    }));
    made.unwrap_or(Handle::NULL)
}

#[unsafe(no_mangle)]
extern "C" fn fmi2FreeInstance(me: Handle) {
    // A panic while dropping is a bug, but the host must not see it.
    let _ = catch_unwind(AssertUnwindSafe(|| {
        INSTANCES.hold(me.number()).and_then(|mut held| held.remove())
    }));
}

#[unsafe(no_mangle)]
extern "C" fn fmi2SetDebugLogging(
    me: Handle,
    on: i32,
    count: usize,
    categories: In<Text>,
) -> Status {
    call(me, |instance| {
        let names = categories.array(sane(count)?, "categories")?;
        let names: Option<Vec<String>> =
            names.iter().map(|n| n.read().map(|n| n.to_string_lossy().into_owned())).collect();
        instance.switch_logging(on != 0, &names.ok_or(Fault::Pointer("categories"))?)
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
    get(me, vr, n, value, |_, reference| Err(Fault::Reference { reference, wanted: STRING }))
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
        Some(vr) => Err(Fault::Reference { reference: *vr, wanted: STRING }),
        None => Ok(()),
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetFMUstate(me: Handle, state: Out<Handle>) -> Status {
    call(me, |instance| {
        let known = state.read("FMUstate")?;
        keep(known, instance.snapshot(), &state)
    })
}

/// Keeps a state under the handle that the host holds already, or a new one.
fn keep(known: Handle, snapshot: Snapshot, state: &Out<Handle>) -> Result<(), Fault> {
    match known.number() {
        0 => state.write(0, Handle::of(STATES.insert(snapshot)), "FMUstate"),
        known if STATES.replace(known, snapshot) => Ok(()),
        _ => Err(Fault::UnknownState),
    }
}

#[unsafe(no_mangle)]
extern "C" fn fmi2SetFMUstate(me: Handle, state: Handle) -> Status {
    call(me, |instance| instance.restore(&*STATES.get(state.number()).ok_or(Fault::UnknownState)?))
}

#[unsafe(no_mangle)]
extern "C" fn fmi2FreeFMUstate(me: Handle, state: Out<Handle>) -> Status {
    call(me, |_| {
        // Freeing nothing is allowed, as with free(3).
        let Ok(handle) = state.read("FMUstate") else { return Ok(()) };
        if handle.number() != 0 && !STATES.remove(handle.number()) {
            return Err(Fault::UnknownState);
        }
        state.write(0, Handle::NULL, "FMUstate")
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi2SerializedFMUstateSize(me: Handle, state: Handle, size: Out<usize>) -> Status {
    call(me, |_| {
        let snapshot = STATES.get(state.number()).ok_or(Fault::UnknownState)?;
        size.write(0, snapshot.bytes()?.len(), "size")
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi2SerializeFMUstate(
    me: Handle,
    state: Handle,
    bytes: Out<u8>,
    size: usize,
) -> Status {
    call(me, |_| {
        let snapshot = STATES.get(state.number()).ok_or(Fault::UnknownState)?;
        let source = snapshot.bytes()?;
        if size < source.len() {
            let text = format!("{size} bytes are too few for a state of {}", source.len());
            return Err(Fault::Argument(text));
        }
        source.iter().enumerate().try_for_each(|(i, byte)| bytes.write(i, *byte, "serializedState"))
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi2DeSerializeFMUstate(
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
    _unknown: In<u32>,
    _unknowns: usize,
    _known: In<u32>,
    _knowns: usize,
    _direction: In<f64>,
    _derivative: Out<f64>,
) -> Status {
    call(me, |_| Err(Fault::NotProvided("fmi2GetDirectionalDerivative")))
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
    call(me, |instance| instance.step(point, size))
}

#[unsafe(no_mangle)]
extern "C" fn fmi2CancelStep(me: Handle) -> Status {
    call(me, |_| Err(Fault::NotProvided("fmi2CancelStep")))
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
        // The hammer never asks to end the simulation.
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

fn unknown_kind(call: &'static str, kind: i32) -> Fault {
    Fault::Argument(format!("{call} does not know a status of kind {kind}"))
}

// What is unsafe. The pointers below exist only as arguments that C passed, so the
// standard's contract holds for them: null, or pointing to what the call announces.

impl<T: Copy> In<T> {
    /// The array of `count`; with `count` 0 the pointer may be anything.
    fn array(&self, count: usize, name: &'static str) -> Result<&[T], Fault> {
        if count == 0 {
            return Ok(&[]);
        }
        let fits = count.checked_mul(size_of::<T>()).is_some_and(|n| isize::try_from(n).is_ok());
        if self.0.is_null() || !self.0.is_aligned() || !fits {
            return Err(Fault::Pointer(name));
        }
        // SAFETY: not null, aligned, of a size that can exist, and `count` long by contract.
        Ok(unsafe { std::slice::from_raw_parts(self.0, count) })
    }
}

impl<T: Copy> Out<T> {
    fn checked(&self, name: &'static str) -> Result<*mut T, Fault> {
        let usable = !self.0.is_null() && self.0.is_aligned();
        if usable { Ok(self.0) } else { Err(Fault::Pointer(name)) }
    }

    fn write(&self, index: usize, value: T, name: &'static str) -> Result<(), Fault> {
        let start = self.checked(name)?;
        // SAFETY: not null, aligned, and by contract longer than `index`; it may be uninitialised.
        unsafe { start.add(index).write(value) };
        Ok(())
    }

    /// What stands there, for arguments that are both read and written.
    fn read(&self, name: &'static str) -> Result<T, Fault> {
        let start = self.checked(name)?;
        // SAFETY: not null, aligned, and initialised by contract.
        Ok(unsafe { start.read() })
    }
}

impl Text {
    fn read(&self) -> Option<&CStr> {
        // SAFETY: not null, and by contract a C string that outlives the call.
        (!self.0.is_null()).then(|| unsafe { CStr::from_ptr(self.0) })
    }
}

// SAFETY: the environment is only ever handed back to the host's logger, from the
// thread on which the host itself called.
unsafe impl Send for Logger {}

impl Logger {
    fn of(functions: &In<c::Callbacks>, name: Text) -> Self {
        let callbacks = functions.array(1, "functions").ok().and_then(<[_]>::first).copied();
        Self {
            function: callbacks.and_then(|callbacks| callbacks.logger),
            environment: callbacks.map_or(std::ptr::null_mut(), |callbacks| callbacks.environment),
            name: name.read().unwrap_or(c"").into(),
        }
    }

    fn log(&self, line: &Line) {
        let Some(function) = self.function else { return };
        let status = match line.category {
            Category::Error => c::Severity::Error,
            Category::Warning => c::Severity::Warning,
            Category::Events | Category::Modes => c::Severity::Ok,
        };
        let category = CString::new(line.category.name()).unwrap_or_default();
        let text = CString::new(line.text.replace('\0', " ")).unwrap_or_default();
        // SAFETY: the host's own function; all strings live until it returns, and "%s"
        // keeps whatever is in the text from being read as a format.
        unsafe {
            function(
                self.environment,
                self.name.as_ptr(),
                status as i32,
                category.as_ptr(),
                c"%s".as_ptr(),
                text.as_ptr(),
            );
        }
    }
}
