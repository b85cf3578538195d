//! The shared library of the .fmu, called as a host calls it: the only unsafe code here.
//!
//! Every pointer handed over is that of a Rust reference or slice that outlives the call,
//! and the handle lives from `fmi2Instantiate` to `fmi2FreeInstance`; that is the C side's
//! contract (FMI 2.0.4, section 2.1).

#![allow(unsafe_code, reason = "calls the C functions of the FMU")]

use crate::{Failure, root, target};
use libloading::{Library, Symbol};
use std::ffi::{CString, c_char, c_void};
use std::path::PathBuf;
use std::process::Command;
use std::ptr::{null, null_mut};

type Handle = *mut c_void;
const OK: i32 = 0;

/// What is known of the .fmu.
pub struct Unpacked {
    library: Library,
    description: String,
}

#[repr(C)]
struct Callbacks {
    logger: extern "C" fn(Handle, *const c_char, i32, *const c_char, *const c_char),
    allocate: Option<extern "C" fn(usize, usize) -> Handle>,
    free: Option<extern "C" fn(Handle)>,
    step_finished: Option<extern "C" fn(Handle, i32)>,
    environment: Handle,
}

extern "C" fn ignore(_: Handle, _: *const c_char, _: i32, _: *const c_char, _: *const c_char) {}

extern "C" fn allocate(count: usize, size: usize) -> Handle {
    // SAFETY: calloc takes any arguments.
    unsafe { calloc(count, size) }
}

extern "C" fn release(memory: Handle) {
    // SAFETY: the FMU frees what `allocate` gave it.
    unsafe { free(memory) }
}

unsafe extern "C" {
    fn calloc(count: usize, size: usize) -> Handle;
    fn free(memory: Handle);
}

/// Builds the .fmu and unpacks its library.
pub fn unpack() -> Result<Unpacked, Failure> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    if !Command::new(cargo).current_dir(root()).arg("fmu").status()?.success() {
        return Err("cargo fmu failed".into());
    }
    let file = std::fs::File::open(root().join("dist/dth_hammer.fmu"))?;
    let mut archive = zip::ZipArchive::new(file)?;
    let mut entry = |name: &str, path: PathBuf| -> Result<PathBuf, Failure> {
        let mut out = std::fs::File::create(&path)?;
        std::io::copy(&mut archive.by_name(name)?, &mut out)?;
        Ok(path)
    };
    let folder = target().join("bench-report");
    std::fs::create_dir_all(&folder)?;
    let description = entry("modelDescription.xml", folder.join("modelDescription.xml"))?;
    let library = entry("binaries/linux64/dth_hammer.so", folder.join("dth_hammer.so"))?;
    // SAFETY: our own library; it has no initialisers.
    let library = unsafe { Library::new(library)? };
    Ok(Unpacked { library, description: std::fs::read_to_string(description)? })
}

/// The value of `key="..."` after the first occurrence of `after`.
fn attribute<'a>(text: &'a str, after: &str, key: &str) -> Option<&'a str> {
    let rest = &text[text.find(after)?..];
    let start = rest.find(&format!("{key}=\""))? + key.len() + 2;
    rest[start..].split('"').next()
}

impl Unpacked {
    /// Value reference of a variable.
    ///
    /// # Panics
    /// There is none of that name.
    pub fn reference(&self, name: &str) -> u32 {
        attribute(&self.description, &format!("<ScalarVariable name=\"{name}\""), "valueReference")
            .and_then(|text| text.parse().ok())
            .unwrap_or_else(|| panic!("no variable {name}"))
    }

    /// The signature is the caller's to state.
    fn symbol<T>(&self, name: &str) -> Symbol<'_, T> {
        // SAFETY: `name` is a function of FMI 2.0 and `T` its type in the standard's header.
        unsafe { self.library.get(name.as_bytes()) }.expect("an FMI 2.0 co-simulation library")
    }
}

/// An instance that is ready to step.
pub struct Instance<'a> {
    do_step: Symbol<'a, unsafe extern "C" fn(Handle, f64, f64, i32) -> i32>,
    get_real: Symbol<'a, unsafe extern "C" fn(Handle, *const u32, usize, *mut f64) -> i32>,
    library: &'a Unpacked,
    handle: Handle,
    start: Handle,
    _callbacks: Box<Callbacks>,
}

impl<'a> Instance<'a> {
    /// The reference hammer at rest.
    pub fn new(library: &'a Unpacked) -> Result<Self, Failure> {
        type Instantiate = unsafe extern "C" fn(
            *const c_char,
            i32,
            *const c_char,
            *const c_char,
            *const Callbacks,
            i32,
            i32,
        ) -> Handle;
        let guid = attribute(&library.description, "<fmiModelDescription", "guid");
        let (name, guid) = (CString::new("hammer")?, CString::new(guid.ok_or("no guid")?)?);
        let callbacks = Box::new(Callbacks {
            logger: ignore,
            allocate: Some(allocate),
            free: Some(release),
            step_finished: None,
            environment: null_mut(),
        });
        let instantiate: Symbol<Instantiate> = library.symbol("fmi2Instantiate");
        // SAFETY: strings and callbacks outlive the call, the callbacks the instance.
        let handle = unsafe {
            instantiate(name.as_ptr(), 1, guid.as_ptr(), null(), &raw const *callbacks, 0, 0)
        };
        if handle.is_null() {
            return Err("fmi2Instantiate refused".into());
        }
        let mut instance = Self {
            do_step: library.symbol("fmi2DoStep"),
            get_real: library.symbol("fmi2GetReal"),
            library,
            handle,
            start: null_mut(),
            _callbacks: callbacks,
        };
        instance.initialise()?;
        Ok(instance)
    }

    fn initialise(&mut self) -> Result<(), Failure> {
        type SetUp = unsafe extern "C" fn(Handle, i32, f64, f64, i32, f64) -> i32;
        type Plain = unsafe extern "C" fn(Handle) -> i32;
        type Save = unsafe extern "C" fn(Handle, *mut Handle) -> i32;
        let set_up: Symbol<SetUp> = self.library.symbol("fmi2SetupExperiment");
        let enter: Symbol<Plain> = self.library.symbol("fmi2EnterInitializationMode");
        let leave: Symbol<Plain> = self.library.symbol("fmi2ExitInitializationMode");
        let save: Symbol<Save> = self.library.symbol("fmi2GetFMUstate");
        // SAFETY: a live handle; `start` is null, which asks for a new state.
        let statuses = unsafe {
            [
                set_up(self.handle, 0, 0.0, 0.0, 0, 0.0),
                enter(self.handle),
                leave(self.handle),
                save(self.handle, &raw mut self.start),
            ]
        };
        if statuses == [OK; 4] { Ok(()) } else { Err(format!("{statuses:?} at the start").into()) }
    }

    /// Back to rest at time 0; what has been decomposed is kept by the library or not.
    pub fn rewind(&mut self) {
        type Restore = unsafe extern "C" fn(Handle, Handle) -> i32;
        let restore: Symbol<Restore> = self.library.symbol("fmi2SetFMUstate");
        // SAFETY: a state of this very instance.
        assert_eq!(unsafe { restore(self.handle, self.start) }, OK, "fmi2SetFMUstate");
    }

    /// `fmi2DoStep`.
    pub fn step(&self, time: f64, size: f64) {
        // SAFETY: a live handle.
        assert_eq!(unsafe { (self.do_step)(self.handle, time, size, 1) }, OK, "fmi2DoStep");
    }

    /// `fmi2GetReal`.
    pub fn read(&self, references: &[u32], values: &mut [f64]) {
        assert_eq!(references.len(), values.len());
        let (from, to) = (references.as_ptr(), values.as_mut_ptr());
        // SAFETY: two slices of the length stated.
        let status = unsafe { (self.get_real)(self.handle, from, references.len(), to) };
        assert_eq!(status, OK, "fmi2GetReal");
    }
}

impl Drop for Instance<'_> {
    fn drop(&mut self) {
        type Free = unsafe extern "C" fn(Handle);
        type FreeState = unsafe extern "C" fn(Handle, *mut Handle) -> i32;
        let free_state: Symbol<FreeState> = self.library.symbol("fmi2FreeFMUstate");
        let free: Symbol<Free> = self.library.symbol("fmi2FreeInstance");
        // SAFETY: the last use of both.
        unsafe {
            free_state(self.handle, &raw mut self.start);
            free(self.handle);
        }
    }
}
