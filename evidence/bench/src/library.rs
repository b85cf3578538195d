//! A shared library through its C symbols: the only unsafe code here.
//!
//! Every pointer handed over is that of a Rust reference or slice that outlives the call; a
//! handle lives from `fmi2Instantiate` to `fmi2FreeInstance`, a state from the call that
//! made it to `fmi2FreeFMUstate`. That is the C side's contract (FMI 2.0.4, section 2.1), and that of
//! FMI 3.0 (section 2.2) alike.

#![allow(unsafe_code, reason = "calls the C functions of an FMU")]

use crate::Failure;
use libloading::Library;
use std::ffi::{CStr, c_char, c_void};
use std::path::Path;
use std::ptr::{null, null_mut};

type Pointer = *mut c_void;
const OK: i32 = 0;

/// Declares the functions used, with their types.
macro_rules! functions {
    ($($field:ident = $name:literal: fn($($kind:ty),*) $(-> $out:ty)?;)*) => {
        /// Addresses of the functions used.
        struct Functions {
            $($field: unsafe extern "C" fn($($kind),*) $(-> $out)?,)*
        }

        impl Functions {
            fn of(library: &Library) -> Result<Self, libloading::Error> {
                // SAFETY: these are the types of FMI 2.0 and 3.0, and the addresses are kept no
                // longer than the library.
                Ok(unsafe { Self { $($field: *library.get($name)?,)* } })
            }
        }
    };
}

functions! {
    instantiate = b"fmi2Instantiate":
        fn(*const c_char, i32, *const c_char, *const c_char, *const Callbacks, i32, i32) -> Pointer;
    free = b"fmi2FreeInstance": fn(Pointer);
    set_up = b"fmi2SetupExperiment": fn(Pointer, i32, f64, f64, i32, f64) -> i32;
    enter = b"fmi2EnterInitializationMode": fn(Pointer) -> i32;
    leave = b"fmi2ExitInitializationMode": fn(Pointer) -> i32;
    step = b"fmi2DoStep": fn(Pointer, f64, f64, i32) -> i32;
    set = b"fmi2SetReal": fn(Pointer, *const u32, usize, *const f64) -> i32;
    get = b"fmi2GetReal": fn(Pointer, *const u32, usize, *mut f64) -> i32;
    save = b"fmi2GetFMUstate": fn(Pointer, *mut Pointer) -> i32;
    restore = b"fmi2SetFMUstate": fn(Pointer, Pointer) -> i32;
    forget = b"fmi2FreeFMUstate": fn(Pointer, *mut Pointer) -> i32;
    size = b"fmi2SerializedFMUstateSize": fn(Pointer, Pointer, *mut usize) -> i32;
    write = b"fmi2SerializeFMUstate": fn(Pointer, Pointer, *mut u8, usize) -> i32;
    read = b"fmi2DeSerializeFMUstate": fn(Pointer, *const u8, usize, *mut Pointer) -> i32;
    instantiate3 = b"fmi3InstantiateCoSimulation":
        fn(*const c_char, *const c_char, *const c_char, bool, bool, bool, bool, *const u32, usize,
            Pointer, *const c_void, *const c_void) -> Pointer;
    free3 = b"fmi3FreeInstance": fn(Pointer);
    enter3 = b"fmi3EnterInitializationMode": fn(Pointer, bool, f64, f64, bool, f64) -> i32;
    leave3 = b"fmi3ExitInitializationMode": fn(Pointer) -> i32;
    step3 = b"fmi3DoStep":
        fn(Pointer, f64, f64, bool, *mut bool, *mut bool, *mut bool, *mut f64) -> i32;
    set3 = b"fmi3SetFloat64": fn(Pointer, *const u32, usize, *const f64, usize) -> i32;
    get3 = b"fmi3GetFloat64": fn(Pointer, *const u32, usize, *mut f64, usize) -> i32;
}

/// Callbacks: a host may leave all of them out.
#[repr(C)]
struct Callbacks([*const c_void; 5]);

// SAFETY: five null pointers.
unsafe impl Sync for Callbacks {}

static CALLBACKS: Callbacks = Callbacks([null(); 5]);

/// A loaded FMU.
pub struct Fmu {
    functions: Functions,
    _library: Library,
}

/// An instance of it.
pub struct Instance<'a> {
    fmu: &'a Fmu,
    handle: Pointer,
}

/// An instance by the functions of FMI 3.0.
pub struct Instance3<'a> {
    functions: &'a Functions,
    handle: Pointer,
}

/// A saved state.
pub struct State(Pointer);

#[inline]
fn check(status: i32) {
    assert_eq!(status, OK, "a call that is measured must succeed");
}

impl Fmu {
    /// Loads a shared library and looks its functions up.
    ///
    /// # Errors
    /// If it cannot be loaded or lacks a function.
    pub fn load(path: &Path) -> Result<Self, Failure> {
        // SAFETY: one of the two libraries built for this; neither has initialisers.
        let library = unsafe { Library::new(path) }?;
        Ok(Self { functions: Functions::of(&library)?, _library: library })
    }

    /// A new instance.
    ///
    /// # Errors
    /// If the FMU refuses.
    pub fn instantiate(&self, guid: &CStr) -> Result<Instance<'_>, Failure> {
        let (name, guid) = (c"hammer".as_ptr(), guid.as_ptr());
        // SAFETY: strings and callbacks outlive the call, the callbacks the instance too.
        let handle =
            unsafe { (self.functions.instantiate)(name, 1, guid, null(), &CALLBACKS, 0, 0) };
        if handle.is_null() { Err("refused".into()) } else { Ok(Instance { fmu: self, handle }) }
    }
}

impl Fmu {
    /// A new instance by FMI 3.0, without event mode, at time 0.
    ///
    /// # Errors
    /// If the FMU refuses.
    pub fn start3(&self, token: &CStr) -> Result<Instance3<'_>, Failure> {
        let Functions { instantiate3, enter3, leave3, .. } = self.functions;
        let (name, token, none) = (c"hammer".as_ptr(), token.as_ptr(), null::<c_void>());
        // SAFETY: the strings outlive the call; no callback is given.
        let handle = unsafe {
            instantiate3(
                name,
                token,
                null(),
                false,
                false,
                false,
                false,
                null(),
                0,
                null_mut(),
                none,
                none,
            )
        };
        if handle.is_null() {
            return Err("refused".into());
        }
        // SAFETY: a live handle.
        unsafe {
            check(enter3(handle, false, 0.0, 0.0, false, 0.0));
            check(leave3(handle));
        }
        Ok(Instance3 { functions: &self.functions, handle })
    }
}

impl Instance3<'_> {
    /// `fmi3DoStep`.
    #[inline]
    pub fn step(&self, time: f64, size: f64) {
        let ([mut event, mut end, mut early], mut last) = ([false; 3], 0.0);
        let [event, end, early] = [&raw mut event, &raw mut end, &raw mut early];
        let step = self.functions.step3;
        // SAFETY: a live handle; places for what is told.
        check(unsafe { step(self.handle, time, size, true, event, end, early, &raw mut last) });
    }

    /// `fmi3SetFloat64`, of scalars.
    #[inline]
    pub fn set(&self, references: &[u32], values: &[f64]) {
        assert_eq!(references.len(), values.len());
        let (which, from, n) = (references.as_ptr(), values.as_ptr(), values.len());
        // SAFETY: a live handle, two slices of the length stated.
        check(unsafe { (self.functions.set3)(self.handle, which, n, from, n) });
    }

    /// `fmi3GetFloat64`, of scalars.
    #[inline]
    pub fn get(&self, references: &[u32], values: &mut [f64]) {
        assert_eq!(references.len(), values.len());
        let (which, to, n) = (references.as_ptr(), values.as_mut_ptr(), values.len());
        // SAFETY: a live handle, two slices of the length stated.
        check(unsafe { (self.functions.get3)(self.handle, which, n, to, n) });
    }
}

impl Drop for Instance3<'_> {
    fn drop(&mut self) {
        // SAFETY: the last use of a live handle.
        unsafe { (self.functions.free3)(self.handle) };
    }
}

impl Instance<'_> {
    /// From instantiation to the start of stepping, at time 0.
    pub fn initialise(&self) {
        let Functions { set_up, enter, leave, .. } = self.fmu.functions;
        // SAFETY: a live handle.
        unsafe {
            check(set_up(self.handle, 0, 0.0, 0.0, 0, 0.0));
            check(enter(self.handle));
            check(leave(self.handle));
        }
    }

    /// `fmi2DoStep`.
    #[inline]
    pub fn step(&self, time: f64, size: f64) {
        // SAFETY: a live handle.
        check(unsafe { (self.fmu.functions.step)(self.handle, time, size, 1) });
    }

    /// `fmi2SetReal`.
    #[inline]
    pub fn set(&self, references: &[u32], values: &[f64]) {
        assert_eq!(references.len(), values.len());
        let (which, from, n) = (references.as_ptr(), values.as_ptr(), values.len());
        // SAFETY: a live handle, two slices of the length stated.
        check(unsafe { (self.fmu.functions.set)(self.handle, which, n, from) });
    }

    /// `fmi2GetReal`.
    #[inline]
    pub fn get(&self, references: &[u32], values: &mut [f64]) {
        assert_eq!(references.len(), values.len());
        let (which, to, n) = (references.as_ptr(), values.as_mut_ptr(), values.len());
        // SAFETY: a live handle, two slices of the length stated.
        check(unsafe { (self.fmu.functions.get)(self.handle, which, n, to) });
    }

    /// `fmi2GetFMUstate`, into a new state.
    pub fn save(&self) -> State {
        let mut state = State(null_mut());
        // SAFETY: a live handle; null asks for a new state.
        check(unsafe { (self.fmu.functions.save)(self.handle, &raw mut state.0) });
        state
    }

    /// `fmi2SetFMUstate`.
    pub fn restore(&self, state: &State) {
        // SAFETY: a live handle and a live state.
        check(unsafe { (self.fmu.functions.restore)(self.handle, state.0) });
    }

    /// `fmi2FreeFMUstate`.
    pub fn forget(&self, mut state: State) {
        // SAFETY: a live handle and a live state, used for the last time.
        check(unsafe { (self.fmu.functions.forget)(self.handle, &raw mut state.0) });
    }

    /// `fmi2SerializedFMUstateSize` and `fmi2SerializeFMUstate`.
    pub fn serialise(&self, state: &State, bytes: &mut Vec<u8>) {
        let mut size = 0;
        // SAFETY: a live handle and a live state; room for what is written.
        unsafe {
            check((self.fmu.functions.size)(self.handle, state.0, &raw mut size));
            bytes.resize(size, 0);
            check((self.fmu.functions.write)(self.handle, state.0, bytes.as_mut_ptr(), size));
        }
    }

    /// `fmi2DeSerializeFMUstate`, into a new state.
    pub fn deserialise(&self, bytes: &[u8]) -> State {
        let mut state = State(null_mut());
        let (from, n) = (bytes.as_ptr(), bytes.len());
        // SAFETY: a live handle, a slice of the length stated; null asks for a new state.
        check(unsafe { (self.fmu.functions.read)(self.handle, from, n, &raw mut state.0) });
        state
    }
}

impl Drop for Instance<'_> {
    fn drop(&mut self) {
        // SAFETY: the last use of a live handle.
        unsafe { (self.fmu.functions.free)(self.handle) };
    }
}
