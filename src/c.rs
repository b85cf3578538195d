//! The C types of FMI 2.0 and 3.0 that the library exchanges with hosts.
//!
//! Pointers are wrapped: only `abi.rs` can dereference them, and only C can create them.

use crate::category::Category;
use std::ffi::{CStr, c_char, c_void};

/// The values of `fmi2Status` and `fmi3Status` that this library returns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum Status {
    /// `fmi2OK`.
    Ok = 0,
    /// `fmi2Error`.
    Error = 3,
}

/// `fmi2Status` of a log line.
#[derive(Clone, Copy, Debug)]
#[repr(i32)]
pub enum Severity {
    /// `fmi2OK`.
    Ok = 0,
    /// `fmi2Warning`.
    Warning = 1,
    /// `fmi2Error`.
    Error = 3,
}

impl Severity {
    /// Severity of a line of this category.
    pub fn of(category: Category) -> Self {
        match category {
            Category::Error => Self::Error,
            Category::Warning => Self::Warning,
            Category::Events | Category::Modes => Self::Ok,
        }
    }
}

/// `fmi2CoSimulation` of `fmi2Type`.
pub const CO_SIMULATION: i32 = 1;

/// `fmi2DoStepStatus` of `fmi2StatusKind`.
pub const DO_STEP_STATUS: i32 = 0;
/// `fmi2PendingStatus`.
pub const PENDING_STATUS: i32 = 1;
/// `fmi2LastSuccessfulTime`.
pub const LAST_SUCCESSFUL_TIME: i32 = 2;
/// `fmi2Terminated`.
pub const TERMINATED: i32 = 3;

/// `fmi2Component` or `fmi2FMUstate`. `registry.rs` describes what it points at.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Handle(*mut c_void);

impl Handle {
    /// The handle of no object.
    pub const NULL: Self = Self(std::ptr::null_mut());

    /// The handle with this number.
    pub fn of(number: usize) -> Self {
        Self(std::ptr::with_exposed_provenance_mut(number))
    }

    /// The handle's number; 0 for no object.
    pub fn number(self) -> usize {
        self.0.addr()
    }
}

/// An array that the host lends to be read.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub struct In<T>(pub(super) *const T);

/// An array that the host lends to be written.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub struct Out<T>(pub(super) *mut T);

/// A C string that the host lends.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub struct Text(pub(super) *const c_char);

impl Text {
    /// Lends a text to the host without time limit.
    pub fn of(text: &'static CStr) -> Self {
        Self(text.as_ptr())
    }
}

/// `fmi2CallbackLogger`.
pub type LoggerFunction = unsafe extern "C" fn(
    environment: *mut c_void,
    name: *const c_char,
    status: i32,
    category: *const c_char,
    message: *const c_char,
    ...
);

/// `fmi3LogMessageCallback`.
pub type LogMessage = unsafe extern "C" fn(
    environment: *mut c_void,
    status: i32,
    category: *const c_char,
    message: *const c_char,
);

/// `fmi2CallbackFunctions`. The allocator and `stepFinished` are never called.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct Callbacks {
    /// The function that receives log lines.
    pub logger: Option<LoggerFunction>,
    allocate_memory: *const c_void,
    free_memory: *const c_void,
    step_finished: *const c_void,
    /// Passed to the logger.
    pub environment: *mut c_void,
}
