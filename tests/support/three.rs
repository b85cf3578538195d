//! A correct host of FMI 3.0, with variables by value reference, and the C functions that it uses.

#![allow(unsafe_code, dead_code, reason = "calls C; each test uses its part")]

use super::host::vr;
use super::library::{ERROR, Handle, Library, OK, Pointer, c, pointer, text};
use dth_hammer::TOKEN;
use dth_hammer::events::Extra;
use dth_hammer::variant::ARRAYS;
use std::ffi::{CStr, c_char, c_void};
use std::ptr::null;
use std::sync::Mutex;

/// Log lines: status, text.
type Lines = Mutex<Vec<(i32, String)>>;

extern "C" fn collect(log: *const Lines, status: i32, _: *const c_char, message: *const c_char) {
    // SAFETY: the library hands back the environment, and C strings, as FMI says.
    let (log, message) = unsafe { (&*log, CStr::from_ptr(message)) };
    log.lock().unwrap().push((status, message.to_string_lossy().into_owned()));
}

/// How a step ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ended {
    pub event: bool,
    pub early: bool,
    pub time: f64,
}

/// An instance, and its log.
pub struct Three<'a> {
    pub library: &'a Library,
    pub handle: Handle,
    log: Box<Lines>,
}

impl<'a> Three<'a> {
    /// An instance with arrays, before initialization, that logs errors and warnings. `events` and `early` say
    /// whether the host handles events and early returns.
    pub fn new(library: &'a Library, events: bool, early: bool) -> Self {
        let host = Self::silent(library, &format!("{TOKEN}{ARRAYS}"), [events, early]);
        let names = ["logStatusError", "logStatusWarning"].map(|name| text(Some(name)));
        let names = names.each_ref().map(|(_, name)| *name);
        let status = c!(library, b"fmi3SetDebugLogging", (pointer(host.handle) => Pointer,
            1 => u8, names.len() => usize, names.as_ptr() => *const *const c_char) -> i32);
        assert_eq!(status, OK);
        host
    }

    /// An instance of a token without logging.
    pub fn silent(library: &'a Library, token: &str, modes: [bool; 2]) -> Self {
        let log = Box::new(Lines::default());
        let handle = Self::made(library, "InstantiateCoSimulation", token, modes, (0, &log));
        assert_ne!(handle.0, 0, "{:?}", log.lock());
        Self { library, handle, log }
    }

    fn made(
        library: &Library,
        call: &str,
        token: &str,
        [events, early]: [bool; 2],
        (logging, log): (u8, &Lines),
    ) -> Handle {
        let (_name, name) = text(Some("a hammer"));
        let (_token, token) = text(Some(token));
        let (none, log): (*const c_void, _) = (null(), std::ptr::from_ref(log));
        let call = format!("fmi3{call}");
        let made = c!(library, call.as_bytes(), (
            name => *const c_char, token => *const c_char, null() => *const c_char,
            0 => u8, logging => u8, events.into() => u8, early.into() => u8, null() => *const u32,
            0 => usize, log => *const Lines, collect as *const c_void => *const c_void,
            none => *const c_void) -> Pointer);
        Handle(made.addr())
    }

    /// The line that is logged when an instance with this token is refused.
    pub fn refused(library: &Library, token: &str) -> String {
        let log = Lines::default();
        let made = Self::made(library, "InstantiateCoSimulation", token, [false; 2], (1, &log));
        assert_eq!(made.0, 0);
        log.into_inner().unwrap().remove(0).1
    }

    /// Calls a function whose only argument is the instance.
    pub fn plain(&self, call: &str) -> i32 {
        let call = format!("fmi3{call}");
        c!(self.library, call.as_bytes(), (pointer(self.handle) => Pointer) -> i32)
    }

    /// Calls that must succeed.
    pub fn calls(&self, calls: &[&str]) {
        for call in calls {
            assert_eq!(self.plain(call), OK, "{call}: {:?}", self.log.lock());
        }
    }

    /// `fmi3EnterInitializationMode`.
    pub fn enter_initialization(&self, start: f64) -> i32 {
        c!(self.library, b"fmi3EnterInitializationMode", (
            pointer(self.handle) => Pointer, 0 => u8, 0.0 => f64, start => f64, 0 => u8,
            0.0 => f64) -> i32)
    }

    /// Initialises, up to the first step.
    pub fn start(&self, events: bool) {
        assert_eq!(self.enter_initialization(0.0), OK);
        self.calls(&["ExitInitializationMode"]);
        if events {
            self.update();
            self.calls(&["EnterStepMode"]);
        }
    }

    /// `fmi3UpdateDiscreteStates`, which need not be repeated.
    pub fn update(&self) {
        assert_eq!(self.try_update(), OK, "{:?}", self.log.lock());
    }

    /// The same, if it is allowed.
    pub fn try_update(&self) -> i32 {
        let (mut flags, mut next) = ([9_u8; 5], f64::NAN);
        let [a, b, c, d, e] = flags.each_mut().map(std::ptr::from_mut);
        let status = c!(self.library, b"fmi3UpdateDiscreteStates", (
            pointer(self.handle) => Pointer, a => *mut u8, b => *mut u8, c => *mut u8,
            d => *mut u8, e => *mut u8, &raw mut next => *mut f64) -> i32);
        assert!(status != OK || flags == [0; 5]);
        status
    }

    /// `fmi3DoStep`.
    pub fn try_step(&self, point: f64, size: f64) -> (i32, Ended) {
        let ([mut event, mut end, mut early], mut time) = ([9_u8; 3], f64::NAN);
        let status = c!(self.library, b"fmi3DoStep", (
            pointer(self.handle) => Pointer, point => f64, size => f64, 1 => u8,
            &raw mut event => *mut u8, &raw mut end => *mut u8, &raw mut early => *mut u8,
            &raw mut time => *mut f64) -> i32);
        assert_eq!(end, 0);
        (status, Ended { event: event != 0, early: early != 0, time })
    }

    /// Makes a step, which must succeed.
    pub fn step(&self, point: f64, size: f64) -> Ended {
        let (status, ended) = self.try_step(point, size);
        assert_eq!(status, OK, "{:?}", self.log.lock());
        ended
    }

    /// Handles an event. `work` is given the blow and the number of the position.
    pub fn event(&self, work: impl FnOnce(&Self, [f64; 2])) {
        self.calls(&["EnterEventMode"]);
        work(self, self.happened().unwrap());
        self.update();
        self.calls(&["EnterStepMode"]);
    }

    /// Steps to an instant and handles the events on the way; `each` gets the end of a step, and its event.
    pub fn run(&self, mut from: f64, to: f64, mut each: impl FnMut(Ended, Option<[f64; 2]>)) {
        loop {
            let (ended, mut happened) = (self.step(from, to - from), None);
            if ended.event {
                self.event(|_, event| happened = Some(event));
            }
            each(ended, happened);
            if !ended.early {
                break;
            }
            from = ended.time;
        }
    }

    /// `event_kind` and `event_position`.
    pub fn happened(&self) -> Option<[f64; 2]> {
        let mut values = [9.0; 2];
        let references = ["event_kind", "event_position"].map(extra);
        (self.access("GetFloat64", &references, &mut values) == OK).then_some(values)
    }

    /// A getter or setter for `T`, by the name of its type.
    pub fn access<T>(&self, call: &str, vr: &[u32], values: &mut [T]) -> i32 {
        let call = format!("fmi3{call}");
        c!(self.library, call.as_bytes(), (pointer(self.handle) => Pointer,
            vr.as_ptr() => *const u32, vr.len() => usize, values.as_mut_ptr().cast() => Pointer,
            values.len() => usize) -> i32)
    }

    /// Sets a value of the type with this name.
    pub fn set<T>(&self, kind: &str, vr: u32, value: T) {
        let status = self.access(&format!("Set{kind}"), &[vr], &mut [value]);
        assert_eq!(status, OK, "{:?}", self.log.lock());
    }

    /// A real variable.
    pub fn get(&self, vr: u32) -> f64 {
        let mut value = [f64::NAN];
        let status = self.access("GetFloat64", &[vr], &mut value);
        assert_eq!(status, OK, "{:?}", self.log.lock());
        value[0]
    }

    /// As the host of FMI 2.0 does.
    pub fn fingerprint(&self, names: &[&str]) -> Vec<u64> {
        names.iter().map(|name| self.get(vr(name)).to_bits()).collect()
    }

    /// `fmi3GetDirectionalDerivative` or `fmi3GetAdjointDerivative`, with room for `count` values.
    pub fn derivative(
        &self,
        call: &str,
        of: &[u32],
        by: &[u32],
        seed: &[f64],
        count: usize,
    ) -> Vec<f64> {
        let mut found = vec![f64::NAN; count];
        let call = format!("fmi3Get{call}Derivative");
        let status = c!(self.library, call.as_bytes(), (pointer(self.handle) => Pointer,
            of.as_ptr() => *const u32, of.len() => usize, by.as_ptr() => *const u32,
            by.len() => usize, seed.as_ptr() => *const f64, seed.len() => usize,
            found.as_mut_ptr() => *mut f64, found.len() => usize) -> i32);
        assert_eq!(status, OK, "{:?}", self.log.lock());
        found
    }

    /// The whole state as bytes: `fmi3GetFMUState`, `fmi3SerializeFMUState`, ...
    pub fn serialized(&self) -> Vec<u8> {
        let (mut state, mut size) = (Handle(0), 0_usize);
        let me = pointer(self.handle);
        let mut statuses = [self.save(&mut state), ERROR, ERROR, ERROR];
        statuses[1] = c!(self.library, b"fmi3SerializedFMUStateSize", (
            me => Pointer, pointer(state) => Pointer, &raw mut size => *mut usize) -> i32);
        let mut bytes = vec![0_u8; size];
        statuses[2] = c!(self.library, b"fmi3SerializeFMUState", (me => Pointer,
            pointer(state) => Pointer, bytes.as_mut_ptr() => *mut u8, size => usize) -> i32);
        statuses[3] = self.forget(&mut state);
        assert_eq!(statuses, [OK; 4], "{:?}", self.log.lock());
        bytes
    }

    /// Adopts a state from bytes: the statuses of `fmi3DeserializeFMUState` and `fmi3SetFMUState`.
    pub fn adopt(&self, bytes: &[u8]) -> [i32; 2] {
        let mut state = Handle(0);
        let read = c!(self.library, b"fmi3DeserializeFMUState", (
            pointer(self.handle) => Pointer, bytes.as_ptr() => *const u8, bytes.len() => usize,
            &raw mut state => *mut Handle) -> i32);
        if read != OK {
            return [read, ERROR];
        }
        let set = self.restore(state);
        assert_eq!(self.forget(&mut state), OK);
        [read, set]
    }

    /// `fmi3GetFMUState`, into a new state or the one given.
    pub fn save(&self, state: &mut Handle) -> i32 {
        c!(self.library, b"fmi3GetFMUState", (
            pointer(self.handle) => Pointer, std::ptr::from_mut(state) => *mut Handle) -> i32)
    }

    /// `fmi3SetFMUState`.
    pub fn restore(&self, state: Handle) -> i32 {
        c!(self.library, b"fmi3SetFMUState", (
            pointer(self.handle) => Pointer, pointer(state) => Pointer) -> i32)
    }

    /// `fmi3FreeFMUState`.
    pub fn forget(&self, state: &mut Handle) -> i32 {
        c!(self.library, b"fmi3FreeFMUState", (
            pointer(self.handle) => Pointer, std::ptr::from_mut(state) => *mut Handle) -> i32)
    }

    /// The texts logged since the last call.
    pub fn lines(&self) -> Vec<String> {
        std::mem::take(&mut *self.log.lock().unwrap()).into_iter().map(|line| line.1).collect()
    }

    /// The text of the one error logged since the last call.
    pub fn only_error(&self) -> String {
        let mut lines = std::mem::take(&mut *self.log.lock().unwrap());
        assert_eq!(lines.len(), 1, "{lines:?}");
        let (status, text) = lines.remove(0);
        assert_eq!(status, 3, "{text}");
        text
    }
}

impl Library {
    /// A function that takes an instance and returns a status, called with null pointers and zeros after the
    /// instance, as many as the longest function takes.
    pub fn with_nothing(&self, name: &str, me: Handle) -> i32 {
        c!(self, name.as_bytes(), (pointer(me) => Pointer, 0 => usize, 0 => usize, 0 => usize,
            0 => usize, 0 => usize, 0 => usize, 0 => usize, 0 => usize, 0.0 => f64, 0.0 => f64,
            0.0 => f64) -> i32)
    }
}

impl Drop for Three<'_> {
    fn drop(&mut self) {
        c!(self.library, b"fmi3FreeInstance", (pointer(self.handle) => Pointer) -> ());
    }
}

/// The value reference of a variable that FMI 2.0 does not have.
pub fn extra(name: &str) -> u32 {
    let found = Extra::all().find(|extra| extra.name() == name);
    found.unwrap_or_else(|| panic!("no variable {name}")).reference()
}
