//! The C functions of the shared library; the only unsafe code of the tests.
//!
//! Each method passes pointers of Rust references or slices, so the C side's contract is kept. `Option` and `Raw`
//! stand for the null and dangling pointers that the contract allows.

#![allow(unsafe_code, dead_code, reason = "calls C; each test uses its part")]

use libloading::Library as Loaded;
use std::ffi::{CStr, CString, c_char, c_void};
use std::path::{Path, PathBuf};
use std::ptr::{null, null_mut};
use std::sync::Mutex;

/// `fmi2OK`.
pub const OK: i32 = 0;
/// `fmi2Error`.
pub const ERROR: i32 = 3;

/// A handle as the library gives it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Handle(pub usize);

/// Log lines: status, category, text.
pub type Log = Mutex<Vec<(i32, String, String)>>;

/// Callbacks that a host may leave out.
#[repr(C)]
pub struct Callbacks {
    logger: *const c_void,
    allocate: *const c_void,
    free: *const c_void,
    step_finished: *const c_void,
    environment: *const c_void,
}

impl Callbacks {
    /// Only a logger.
    pub fn logging(log: &Log) -> Self {
        Self {
            logger: collect as *const c_void,
            environment: std::ptr::from_ref(log).cast(),
            ..Self::none()
        }
    }

    /// No callbacks.
    pub fn none() -> Self {
        Self {
            logger: null(),
            allocate: null(),
            free: null(),
            step_finished: null(),
            environment: null(),
        }
    }
}

/// The logger is variadic in C, but this FMU passes nothing after the format. A function of five arguments therefore
/// receives everything, and expands the format as `printf` does without arguments.
extern "C" fn collect(
    log: *const Log,
    _name: *const c_char,
    status: i32,
    category: *const c_char,
    format: *const c_char,
) {
    // SAFETY: the library hands back the environment, and C strings, as FMI says.
    let (log, category, format) =
        unsafe { (&*log, CStr::from_ptr(category), CStr::from_ptr(format)) };
    let [category, format] = [category, format].map(|text| text.to_string_lossy().into_owned());
    let text = format.replace("%%", "\0");
    assert!(!text.contains('%'), "{format} asks for an argument");
    let text = text.replace('\0', "%");
    log.lock().unwrap().push((status, category, text));
}

/// A loaded library.
pub struct Library(pub(super) Loaded);

/// Calls a function of the library by its name and signature.
macro_rules! c {
    ($library:expr, $name:expr, ($($argument:expr => $kind:ty),*) -> $result:ty) => {{
        type Function = unsafe extern "C" fn($($kind),*) -> $result;
        // SAFETY: the name has this signature in FMI 2.0; for pointers see the head of this file.
        unsafe {
            let function = $library.0.get::<Function>($name).expect("exported");
            function($($argument),*)
        }
    }};
}

pub(super) use c;

pub(super) type Pointer = *mut c_void;

pub(super) fn pointer(handle: Handle) -> Pointer {
    std::ptr::without_provenance_mut(handle.0)
}

/// A text for C, or null.
pub(super) fn text(text: Option<&str>) -> (Option<CString>, *const c_char) {
    let owned = text.map(|text| CString::new(text).expect("no NUL"));
    let pointer = owned.as_ref().map_or(null(), |text| text.as_ptr());
    (owned, pointer)
}

impl Library {
    /// Closes the library while an instance lives, and frees that by a function that was looked up before.
    pub fn close_and_free(self, handle: Handle, function: &[u8]) {
        type Free = unsafe extern "C" fn(Pointer);
        // SAFETY: the signature is that of both standards; the library stays until its last instance is freed.
        unsafe {
            let free = *self.0.get::<Free>(function).expect("exported");
            self.0.close().expect("it can be closed");
            free(pointer(handle));
        }
    }

    /// Path of the library that cargo built for this test.
    pub fn path() -> PathBuf {
        let name =
            format!("{}dth_hammer{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
        let test = std::env::current_exe().expect("a test is a program");
        let folder = test.parent().expect("in a folder");
        folder.join(name)
    }

    /// Loads the library.
    pub fn load() -> Self {
        Self::load_from(&Self::path())
    }

    /// Loads a copy of the library, which the system treats as another library.
    pub fn load_from(path: &Path) -> Self {
        // SAFETY: our own library; it has no initialisers.
        Self(unsafe { Loaded::new(path) }.expect("cargo builds it with this test"))
    }

    /// A word behind a handle, as read by a host that takes the handle for a pointer.
    pub fn peek(&self, handle: Handle, word: usize) -> usize {
        let place = std::ptr::with_exposed_provenance::<usize>(handle.0);
        // SAFETY: this is under test: some words behind a live handle can be read.
        unsafe { place.add(word).read() }
    }

    /// `fmi2FreeFMUstate` by a host that passes the handle instead of a pointer to it.
    pub fn free_state_by_value(&self, h: Handle, state: Handle) -> i32 {
        c!(self, b"fmi2FreeFMUstate", (pointer(h) => Pointer, pointer(state) => Pointer) -> i32)
    }

    /// `fmi2GetVersion` and `fmi2GetTypesPlatform`.
    pub fn version(&self) -> [String; 2] {
        let version = c!(self, b"fmi2GetVersion", () -> *const c_char);
        let platform = c!(self, b"fmi2GetTypesPlatform", () -> *const c_char);
        // SAFETY: both return a static C string.
        [version, platform].map(|p| unsafe { CStr::from_ptr(p) }.to_string_lossy().into_owned())
    }

    /// `fmi2Instantiate`. The callbacks' environment must outlive the instance.
    pub fn instantiate(
        &self,
        name: Option<&str>,
        kind: i32,
        guid: Option<&str>,
        resources: Option<&str>,
        callbacks: Option<&Callbacks>,
        logging: bool,
    ) -> Handle {
        let (_name, name) = text(name);
        let (_guid, guid) = text(guid);
        let (_resources, resources) = text(resources);
        let callbacks = callbacks.map_or(null(), std::ptr::from_ref);
        let made = c!(self, b"fmi2Instantiate", (
            name => *const c_char, kind => i32, guid => *const c_char,
            resources => *const c_char, callbacks => *const Callbacks,
            0 => i32, i32::from(logging) => i32) -> Pointer);
        Handle(made.addr())
    }

    /// `fmi2FreeInstance`.
    pub fn free(&self, h: Handle) {
        c!(self, b"fmi2FreeInstance", (pointer(h) => Pointer) -> ());
    }

    /// A function whose only argument is the instance.
    pub fn plain(&self, name: &str, h: Handle) -> i32 {
        const NAMES: [&str; 5] = [
            "fmi2EnterInitializationMode",
            "fmi2ExitInitializationMode",
            "fmi2Terminate",
            "fmi2Reset",
            "fmi2CancelStep",
        ];
        assert!(NAMES.contains(&name));
        c!(self, name.as_bytes(), (pointer(h) => Pointer) -> i32)
    }

    /// `fmi2SetupExperiment`.
    pub fn set_up(&self, h: Handle, start: f64, stop: Option<f64>) -> i32 {
        c!(self, b"fmi2SetupExperiment", (
            pointer(h) => Pointer, 0 => i32, 0.0 => f64, start => f64,
            i32::from(stop.is_some()) => i32, stop.unwrap_or(f64::NAN) => f64) -> i32)
    }

    /// `fmi2DoStep`.
    pub fn step(&self, h: Handle, point: f64, size: f64) -> i32 {
        c!(self, b"fmi2DoStep", (
            pointer(h) => Pointer, point => f64, size => f64, 1 => i32) -> i32)
    }

    /// `fmi2SetDebugLogging`.
    pub fn set_logging(&self, h: Handle, on: bool, categories: &[&str]) -> i32 {
        let owned: Vec<CString> =
            categories.iter().map(|text| CString::new(*text).expect("no NUL")).collect();
        let pointers: Vec<*const c_char> = owned.iter().map(|text| text.as_ptr()).collect();
        c!(self, b"fmi2SetDebugLogging", (
            pointer(h) => Pointer, i32::from(on) => i32,
            pointers.len() => usize, pointers.as_ptr() => *const *const c_char) -> i32)
    }

    /// `fmi2GetReal`.
    pub fn get_reals(&self, h: Handle, vr: &[u32], values: &mut [f64]) -> i32 {
        assert_eq!(vr.len(), values.len());
        c!(self, b"fmi2GetReal", (pointer(h) => Pointer, vr.as_ptr() => *const u32,
            vr.len() => usize, values.as_mut_ptr() => *mut f64) -> i32)
    }

    /// `fmi2GetInteger`, or `fmi2GetBoolean`.
    pub fn get_ints(&self, boolean: bool, h: Handle, vr: &[u32], values: &mut [i32]) -> i32 {
        assert_eq!(vr.len(), values.len());
        let name: &[u8] = if boolean { b"fmi2GetBoolean" } else { b"fmi2GetInteger" };
        c!(self, name, (pointer(h) => Pointer, vr.as_ptr() => *const u32,
            vr.len() => usize, values.as_mut_ptr() => *mut i32) -> i32)
    }

    /// `fmi2SetReal`.
    pub fn set_reals(&self, h: Handle, vr: &[u32], values: &[f64]) -> i32 {
        assert_eq!(vr.len(), values.len());
        c!(self, b"fmi2SetReal", (pointer(h) => Pointer, vr.as_ptr() => *const u32,
            vr.len() => usize, values.as_ptr() => *const f64) -> i32)
    }

    /// `fmi2SetInteger`, or `fmi2SetBoolean`.
    pub fn set_ints(&self, boolean: bool, h: Handle, vr: &[u32], values: &[i32]) -> i32 {
        assert_eq!(vr.len(), values.len());
        let name: &[u8] = if boolean { b"fmi2SetBoolean" } else { b"fmi2SetInteger" };
        c!(self, name, (pointer(h) => Pointer, vr.as_ptr() => *const u32,
            vr.len() => usize, values.as_ptr() => *const i32) -> i32)
    }

    /// A getter or setter with null arrays of `count`, which it may read only if `count` is 0.
    pub fn null_arrays(&self, name: &str, h: Handle, count: usize) -> i32 {
        const NAMES: [&str; 8] = [
            "fmi2GetReal",
            "fmi2GetInteger",
            "fmi2GetBoolean",
            "fmi2GetString",
            "fmi2SetReal",
            "fmi2SetInteger",
            "fmi2SetBoolean",
            "fmi2SetString",
        ];
        assert!(NAMES.contains(&name));
        c!(self, name.as_bytes(), (pointer(h) => Pointer, null() => *const u32,
            count => usize, null_mut() => Pointer) -> i32)
    }

    /// `fmi2SetRealInputDerivatives`.
    pub fn set_derivatives(&self, h: Handle, vr: &[u32], orders: &[i32], values: &[f64]) -> i32 {
        assert!(vr.len() == orders.len() && vr.len() == values.len());
        c!(self, b"fmi2SetRealInputDerivatives", (pointer(h) => Pointer,
            vr.as_ptr() => *const u32, vr.len() => usize,
            orders.as_ptr() => *const i32, values.as_ptr() => *const f64) -> i32)
    }

    /// `fmi2GetRealOutputDerivatives`.
    pub fn derivatives(&self, h: Handle, vr: &[u32], orders: &[i32], values: &mut [f64]) -> i32 {
        assert!(vr.len() == orders.len() && vr.len() == values.len());
        c!(self, b"fmi2GetRealOutputDerivatives", (pointer(h) => Pointer,
            vr.as_ptr() => *const u32, vr.len() => usize,
            orders.as_ptr() => *const i32, values.as_mut_ptr() => *mut f64) -> i32)
    }

    /// `fmi2GetDirectionalDerivative`.
    pub fn directional_by(
        &self,
        h: Handle,
        unknown: &[u32],
        known: &[u32],
        by: &[f64],
        out: &mut [f64],
    ) -> i32 {
        c!(self, b"fmi2GetDirectionalDerivative", (pointer(h) => Pointer,
            unknown.as_ptr() => *const u32, unknown.len() => usize,
            known.as_ptr() => *const u32, known.len() => usize,
            by.as_ptr() => *const f64, out.as_mut_ptr() => *mut f64) -> i32)
    }

    /// `fmi2GetDirectionalDerivative` of nothing by nothing.
    pub fn directional(&self, h: Handle) -> i32 {
        c!(self, b"fmi2GetDirectionalDerivative", (pointer(h) => Pointer,
            null() => *const u32, 0 => usize, null() => *const u32, 0 => usize,
            null() => *const f64, null_mut() => *mut f64) -> i32)
    }

    /// `fmi2GetFMUstate`.
    pub fn get_state(&self, h: Handle, state: Option<&mut Handle>) -> i32 {
        let state = state.map_or(null_mut(), std::ptr::from_mut);
        c!(self, b"fmi2GetFMUstate", (pointer(h) => Pointer, state => *mut Handle) -> i32)
    }

    /// `fmi2SetFMUstate`.
    pub fn set_state(&self, h: Handle, state: Handle) -> i32 {
        c!(self, b"fmi2SetFMUstate", (pointer(h) => Pointer, pointer(state) => Pointer) -> i32)
    }

    /// `fmi2FreeFMUstate`.
    pub fn free_state(&self, h: Handle, state: Option<&mut Handle>) -> i32 {
        let state = state.map_or(null_mut(), std::ptr::from_mut);
        c!(self, b"fmi2FreeFMUstate", (pointer(h) => Pointer, state => *mut Handle) -> i32)
    }

    /// `fmi2SerializedFMUstateSize` and `fmi2SerializeFMUstate`.
    pub fn serialize(&self, h: Handle, state: Handle) -> Option<Vec<u8>> {
        let mut size = 0;
        let status = c!(self, b"fmi2SerializedFMUstateSize", (pointer(h) => Pointer,
            pointer(state) => Pointer, &raw mut size => *mut usize) -> i32);
        let mut bytes = vec![0; size];
        (status == OK && self.serialize_into(h, state, &mut bytes) == OK).then_some(bytes)
    }

    /// `fmi2SerializeFMUstate`.
    pub fn serialize_into(&self, h: Handle, state: Handle, bytes: &mut [u8]) -> i32 {
        c!(self, b"fmi2SerializeFMUstate", (pointer(h) => Pointer, pointer(state) => Pointer,
            bytes.as_mut_ptr() => *mut u8, bytes.len() => usize) -> i32)
    }

    /// `fmi2DeSerializeFMUstate`.
    pub fn deserialize(&self, h: Handle, bytes: &[u8], state: &mut Handle) -> i32 {
        c!(self, b"fmi2DeSerializeFMUstate", (pointer(h) => Pointer,
            bytes.as_ptr() => *const u8, bytes.len() => usize,
            std::ptr::from_mut(state) => *mut Handle) -> i32)
    }

    /// `fmi2GetRealStatus`: the status and what was written.
    pub fn real_status(&self, h: Handle, kind: i32) -> (i32, f64) {
        let mut value = f64::NAN;
        let status = c!(self, b"fmi2GetRealStatus", (
            pointer(h) => Pointer, kind => i32, &raw mut value => *mut f64) -> i32);
        (status, value)
    }

    /// `fmi2GetStatus`, `fmi2GetIntegerStatus` or `fmi2GetBooleanStatus`.
    pub fn int_status(&self, name: &str, h: Handle, kind: i32) -> (i32, i32) {
        const NAMES: [&str; 3] = ["fmi2GetStatus", "fmi2GetIntegerStatus", "fmi2GetBooleanStatus"];
        assert!(NAMES.contains(&name));
        let mut value = -1;
        let status = c!(self, name.as_bytes(), (
            pointer(h) => Pointer, kind => i32, &raw mut value => *mut i32) -> i32);
        (status, value)
    }

    /// `fmi2GetStringStatus`.
    pub fn string_status(&self, h: Handle, kind: i32) -> (i32, String) {
        let mut value = c"".as_ptr();
        let status = c!(self, b"fmi2GetStringStatus", (
            pointer(h) => Pointer, kind => i32, &raw mut value => *mut *const c_char) -> i32);
        // SAFETY: either the initial text or a text of the library.
        (status, unsafe { CStr::from_ptr(value) }.to_string_lossy().into_owned())
    }
}
