//! The C face: the only file with unsafe code.
//!
//! All that is unsafe are five things done with what C hands over, at the end of
//! this file: reading an array, writing an element, reading a string, reading the
//! callbacks, calling the logger; and a sixth: asking the system to keep the library
//! loaded. The functions themselves are safe Rust around them. None lets a panic reach
//! the host, none follows a handle that is not live, and none returns anything but
//! `fmi2OK` and `fmi2Error`: some hosts repeat a discarded step for ever, others end a
//! run on a warning.

use crate::c;
use crate::fault::Fault;
use crate::instance::{Instance, Line, Snapshot};
use crate::session::{self, call, sane};
use std::ffi::{CStr, c_char, c_void};
use std::sync::Arc;

use c::{Handle, In, Out, Status, Text};

/// Run as the library is unloaded; elsewhere what is shared goes with the process.
#[cfg(target_os = "linux")]
#[used]
#[unsafe(link_section = ".fini_array")]
static AT_UNLOAD: extern "C" fn() = session::at_unload;

/// There are none.
const STRING: &str = "a string variable";

/// Where log lines go.
#[derive(Clone)]
pub struct Logger {
    function: Option<c::LoggerFunction>,
    environment: *mut c_void,
    name: Arc<CStr>,
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
    session::quietly(|| {
        let logger = Logger::of(&functions, name);
        let texts = [&name, &guid].map(|text| text.read().map(CStr::to_string_lossy));
        session::open(texts, kind, logging != 0, &logger, Residence::take)
    })
    .flatten()
    .map_or(Handle::NULL, Handle::of)
}

#[unsafe(no_mangle)]
extern "C" fn fmi2FreeInstance(me: Handle) {
    // A panic while dropping is a bug, but the host must not see it.
    let _ = session::quietly(|| session::close(me.number()));
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

fn keep(known: Handle, snapshot: Snapshot, state: &Out<Handle>) -> Result<(), Fault> {
    let kept = session::keep(known.number(), snapshot)?;
    state.write(0, Handle::of(kept), "FMUstate")
}

#[unsafe(no_mangle)]
extern "C" fn fmi2SetFMUstate(me: Handle, state: Handle) -> Status {
    call(me, |instance| instance.restore(&*session::state(state.number())?))
}

#[unsafe(no_mangle)]
extern "C" fn fmi2FreeFMUstate(me: Handle, state: Out<Handle>) -> Status {
    call(me, |_| {
        // Freeing nothing is allowed, as with free(3).
        let Ok(handle) = state.read("FMUstate") else { return Ok(()) };
        session::forget(handle.number())?;
        state.write(0, Handle::NULL, "FMUstate")
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi2SerializedFMUstateSize(me: Handle, state: Handle, size: Out<usize>) -> Status {
    call(me, |_| {
        let snapshot = session::state(state.number())?;
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
        let snapshot = session::state(state.number())?;
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
    call(me, |instance| instance.step(point, size))
}

#[unsafe(no_mangle)]
extern "C" fn fmi2CancelStep(me: Handle) -> Status {
    call(me, |_| Err(Fault::NothingToCancel))
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

    /// Hands a line to the host.
    pub fn log(&self, line: &Line) {
        let Some(function) = self.function else { return };
        let (status, [category, text]) = (c::Severity::of(line.category), line.to_c());
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

/// A reference of the library on itself. Some hosts close the library and open it again
/// while instances live: without one, their memory would be gone and a new, empty table
/// give the same handles out.
///
/// The host that frees an instance has the library open, so this is never the last one.
#[cfg_attr(not(any(unix, windows)), expect(dead_code))]
pub struct Residence(*mut c_void);

// SAFETY: the system's reference counts are its own to guard.
unsafe impl Send for Residence {}

#[cfg(windows)]
#[link(name = "kernel32")]
unsafe extern "system" {
    fn GetModuleHandleExW(flags: u32, address: *const c_void, module: *mut *mut c_void) -> i32;
    fn FreeLibrary(module: *mut c_void) -> i32;
}

impl Residence {
    /// `None` in a program that this library is part of.
    pub fn take() -> Option<Self> {
        let here = (fmi2GetVersion as extern "C" fn() -> _) as *const c_void;
        // SAFETY: any address may be asked for. The name that is found is a C string and stays
        // as long as the library; opening what is open runs no code and reads no file.
        #[cfg(unix)]
        let handle = unsafe {
            let mut found = std::mem::MaybeUninit::<libc::Dl_info>::zeroed();
            if libc::dladdr(here, found.as_mut_ptr()) == 0 {
                return None;
            }
            let name = found.assume_init_ref().dli_fname;
            libc::dlopen(name, libc::RTLD_LAZY | libc::RTLD_NOLOAD)
        };
        #[cfg(windows)]
        let handle = {
            const FROM_ADDRESS: u32 = 4;
            let mut module = std::ptr::null_mut();
            // SAFETY: an address of this module; its handle's place is left null if refused.
            unsafe { GetModuleHandleExW(FROM_ADDRESS, here, &raw mut module) };
            module
        };
        #[cfg(not(any(unix, windows)))] // a browser's WebAssembly is never closed
        let handle = here.map_addr(|_| 0).cast_mut();
        (!handle.is_null()).then_some(Self(handle))
    }
}

#[cfg(any(unix, windows))]
impl Drop for Residence {
    fn drop(&mut self) {
        // SAFETY: taken once, given back once.
        unsafe {
            #[cfg(unix)]
            libc::dlclose(self.0);
            #[cfg(windows)]
            FreeLibrary(self.0);
        }
    }
}
