//! A shared library, called through its C symbols; the only unsafe code of this crate.
//!
//! Every pointer passed is that of a Rust reference or slice that outlives the call; a handle lives from
//! `fmi2Instantiate` to `fmi2FreeInstance`. This is the C side's contract (FMI 2.0.4, section 2.1).

#![allow(unsafe_code, reason = "calls the C functions of an FMU")]

use crate::Failure;
use libloading::Library;
use std::ffi::{CStr, c_char, c_void};
use std::path::Path;
use std::ptr::null;

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
                // SAFETY: these are the types of FMI 2.0, and the addresses are kept no
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
}

/// Callbacks, all null, which a host may do.
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

#[inline]
fn check(status: i32) {
    assert_eq!(status, OK, "a call that is measured must succeed");
}

impl Fmu {
    /// Loads a shared library and finds its functions.
    ///
    /// # Errors
    /// If it cannot be loaded or lacks a function.
    pub fn load(path: &Path) -> Result<Self, Failure> {
        // SAFETY: the library was built for this test, and has no initialisers.
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

impl Instance<'_> {
    /// Everything from instantiation to the start of stepping, at time 0.
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
}

impl Drop for Instance<'_> {
    fn drop(&mut self) {
        // SAFETY: the last use of a live handle.
        unsafe { (self.fmu.functions.free)(self.handle) };
    }
}
