//! The C interface: the only unsafe code.
//!
//! This file has every unsafe block, function and implementation: reading arrays, strings and callbacks, writing
//! elements, calling the logger, asking the system to keep the library loaded, and the processor's floating-point
//! settings. The functions of the standards, in [`fmi2`] and [`fmi3`], are safe Rust. No function lets a panic reach
//! the host, or follows a handle that is not live. All return only OK and Error, because some hosts repeat a discarded
//! step for ever and others end a run on a warning.

#[cfg(any(target_family = "wasm", test))]
mod browser;
mod fmi2;
mod fmi3;

use crate::c::{self, In, Out, Text};
use crate::error::CallError;
use crate::instance::Line;
use crate::variant::{MARK, RESERVED};
use std::ffi::{CStr, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

/// Text at the start of a configured unit's section. The rest is written into the finished file.
#[used]
static SECTION: [u8; RESERVED] = {
    let mut section = [0; RESERVED];
    let mut at = 0;
    while at < MARK.len() {
        section[at] = MARK[at];
        at += 1;
    }
    section
};

/// The text in the section; empty in the plain library.
pub fn section() -> String {
    let byte = |at: usize| {
        // SAFETY: within the array. The read is volatile, because the finished file differs from the compiled one.
        unsafe { std::ptr::from_ref(&SECTION).cast::<u8>().add(at).read_volatile() }
    };
    let text: Vec<u8> = (MARK.len()..RESERVED).map(byte).take_while(|byte| *byte != 0).collect();
    String::from_utf8_lossy(&text).into_owned()
}

/// Runs when the library is unloaded. Otherwise shared data ends with the process.
#[cfg(target_os = "linux")]
#[used]
#[unsafe(link_section = ".fini_array")]
static AT_UNLOAD: extern "C" fn() = at_unload;

/// Empties what instances share, so that nothing outlives the library.
#[cfg(target_os = "linux")]
extern "C" fn at_unload() {
    let _ = quietly(hammer::forget_shared_systems);
}

/// Runs `work` with Rust's floating-point settings, and lets no panic reach the host.
pub fn quietly<T>(work: impl FnOnce() -> T) -> Option<T> {
    let _host = Environment::leave();
    guarded(work)
}

/// Not inlined, so that no calculation moves behind [`Environment::leave`].
#[inline(never)]
pub fn guarded<T>(work: impl FnOnce() -> T) -> Option<T> {
    catch_unwind(AssertUnwindSafe(work)).ok()
}

/// The host's function that writes log lines.
#[derive(Clone, Copy)]
enum Function {
    /// FMI 2.0: the text is a format.
    Format(c::LoggerFunction),
    /// FMI 3.0: the text is literal.
    Message(c::LogMessage),
}

/// Where log lines are written.
#[derive(Clone)]
pub struct Logger {
    function: Option<Function>,
    environment: *mut c_void,
    name: Arc<CStr>,
}

// Unsafe code follows. The pointers exist only as arguments that C passed, so the standard's contract applies to them:
// they are null, or point to what the call announces.

impl<T: Copy> In<T> {
    /// The array of `count` elements. If `count` is 0, the pointer may be anything.
    pub fn array(&self, count: usize, name: &'static str) -> Result<&[T], CallError> {
        if count == 0 {
            return Ok(&[]);
        }
        let fits = count.checked_mul(size_of::<T>()).is_some_and(|n| isize::try_from(n).is_ok());
        if self.0.is_null() || !self.0.is_aligned() || !fits {
            return Err(CallError::Pointer(name));
        }
        // SAFETY: not null, aligned, of a size that can exist, and `count` long by contract.
        Ok(unsafe { std::slice::from_raw_parts(self.0, count) })
    }
}

impl<T: Copy> Out<T> {
    fn checked(&self, name: &'static str) -> Result<*mut T, CallError> {
        let usable = !self.0.is_null() && self.0.is_aligned();
        if usable { Ok(self.0) } else { Err(CallError::Pointer(name)) }
    }

    pub fn write(&self, index: usize, value: T, name: &'static str) -> Result<(), CallError> {
        let start = self.checked(name)?;
        // SAFETY: not null, aligned, and by contract longer than `index`; it may be uninitialised.
        unsafe { start.add(index).write(value) };
        Ok(())
    }

    /// The value, for arguments that are both read and written.
    pub fn read(&self, name: &'static str) -> Result<T, CallError> {
        let start = self.checked(name)?;
        // SAFETY: not null, aligned, and initialised by contract.
        Ok(unsafe { start.read() })
    }
}

impl Text {
    pub fn read(&self) -> Option<&CStr> {
        // SAFETY: not null, and by contract a C string that outlives the call.
        (!self.0.is_null()).then(|| unsafe { CStr::from_ptr(self.0) })
    }
}

// SAFETY: the environment is only ever passed back to the host's logger, in the thread in which the host itself called.
unsafe impl Send for Logger {}

impl Logger {
    pub fn of(functions: &In<c::Callbacks>, name: Text) -> Self {
        let callbacks = functions.array(1, "functions").ok().and_then(<[_]>::first).copied();
        Self {
            function: callbacks.and_then(|callbacks| callbacks.logger).map(Function::Format),
            environment: callbacks.map_or(std::ptr::null_mut(), |callbacks| callbacks.environment),
            name: name.read().unwrap_or(c"").into(),
        }
    }

    /// The logger of FMI 3.0, whose messages do not name the instance.
    pub fn of_messages(function: Option<c::LogMessage>, environment: *mut c_void) -> Self {
        Self { function: function.map(Function::Message), environment, name: c"".into() }
    }

    /// Passes a line to the host.
    pub fn log(&self, line: &Line) {
        let Some(function) = self.function else { return };
        let status = c::Severity::of(line.category) as i32;
        // SAFETY: it is the host's own function; all strings live until it returns, and a text that is a format needs
        // no argument.
        match function {
            Function::Format(function) => {
                let [category, text] = line.to_c(true);
                let name = self.name.as_ptr();
                unsafe {
                    function(self.environment, name, status, category.as_ptr(), text.as_ptr());
                }
            }
            Function::Message(function) => {
                let [category, text] = line.to_c(false);
                unsafe { function(self.environment, status, category.as_ptr(), text.as_ptr()) };
            }
        }
    }
}

/// The host's floating-point settings, which are restored when this is dropped.
///
/// A host may let floating-point exceptions end the program, use another rounding, or flush small numbers to zero;
/// Rust assumes the default settings. Exception flags raised here must not reach the host either. On x86-64 this
/// takes 11 instructions a call (callgrind, `fmi2GetReal`), and two more if the host's settings differ.
#[derive(Debug)]
pub struct Environment {
    #[cfg(target_arch = "x86_64")]
    control: u32,
    #[cfg(target_arch = "aarch64")]
    control_and_status: [u64; 2],
}

#[cfg(target_arch = "x86_64")]
impl Environment {
    /// All exceptions masked, round to nearest, with subnormal numbers. The six lowest bits are flags.
    const OWN: u32 = 0x1f80;

    /// Replaces the host's settings.
    #[inline]
    pub fn leave() -> Self {
        let mut control = 0_u32;
        // SAFETY: stores the control and status register in a variable, or loads it from one, with the value that
        // compiled code assumes.
        unsafe {
            std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut control, options(nostack, preserves_flags));
            if control & !0x3f != Self::OWN {
                std::arch::asm!("ldmxcsr [{}]", in(reg) &Self::OWN, options(nostack, preserves_flags));
            }
        }
        Self { control }
    }
}

#[cfg(target_arch = "x86_64")]
impl Drop for Environment {
    #[inline]
    fn drop(&mut self) {
        // SAFETY: loads the stored value, on the way back to the host.
        unsafe {
            std::arch::asm!("ldmxcsr [{}]", in(reg) &self.control, options(nostack, preserves_flags));
        }
    }
}

#[cfg(target_arch = "aarch64")]
impl Environment {
    /// Replaces the host's settings.
    #[inline]
    pub fn leave() -> Self {
        let [control, status]: [u64; 2];
        // SAFETY: reads both registers; zero is the value that compiled code assumes.
        unsafe {
            std::arch::asm!("mrs {}, fpcr", "mrs {}, fpsr", out(reg) control, out(reg) status,
                options(nostack, preserves_flags));
            if control != 0 {
                std::arch::asm!("msr fpcr, {}", in(reg) 0_u64, options(nostack, preserves_flags));
            }
        }
        Self { control_and_status: [control, status] }
    }
}

#[cfg(target_arch = "aarch64")]
impl Drop for Environment {
    #[inline]
    fn drop(&mut self) {
        let [control, status] = self.control_and_status;
        // SAFETY: writes the values that were read, on the way back to the host.
        unsafe {
            std::arch::asm!("msr fpsr, {}", "msr fpcr, {}", in(reg) status, in(reg) control,
                options(nostack, preserves_flags));
        }
    }
}

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
impl Environment {
    /// WebAssembly has no such settings.
    pub fn leave() -> Self {
        Self {}
    }
}

/// A reference of the library to itself. Some hosts close the library and open it again while instances live. Without
/// this reference, the memory of these instances would be gone, and a new, empty table would give out the same handles.
///
/// A host may have closed the library before it frees its last instance. [`free_instance`] then drops the last
/// reference.
pub struct Residence(*mut c_void);

/// Declares the function of a standard that frees an instance. `$free` frees it and returns its reference to the
/// library, or null; the function then drops this reference.
///
/// No code of the library may run after the last reference is dropped, not even a return. So the last instruction jumps
/// to the system's function that drops it, which returns directly to the host.
macro_rules! free_instance {
    ($name:ident, $free:path) => {
        #[cfg(any(unix, windows))]
        #[unsafe(naked)]
        #[unsafe(no_mangle)]
        pub extern "C" fn $name(me: $crate::c::Handle) {
            #[cfg(all(unix, target_arch = "x86_64"))]
            std::arch::naked_asm!(
                "sub rsp, 8", "call {free}", "add rsp, 8", "test rax, rax", "jz 2f", "mov rdi, rax",
                "jmp {close}", "2:", "ret",
                free = sym $free, close = sym libc::dlclose
            );
            #[cfg(all(windows, target_arch = "x86_64"))]
            std::arch::naked_asm!(
                "sub rsp, 40", "call {free}", "add rsp, 40", "test rax, rax", "jz 2f", "mov rcx, rax",
                "jmp {close}", "2:", "ret",
                free = sym $free, close = sym $crate::abi::FreeLibrary
            );
            #[cfg(all(unix, target_arch = "aarch64"))]
            std::arch::naked_asm!(
                "stp x29, x30, [sp, #-16]!", "bl {free}", "ldp x29, x30, [sp], #16", "cbz x0, 2f",
                "b {close}", "2:", "ret",
                free = sym $free, close = sym libc::dlclose
            );
        }

        #[cfg(not(any(unix, windows)))]
        #[unsafe(no_mangle)]
        pub extern "C" fn $name(me: $crate::c::Handle) {
            let _ = $free(me);
        }
    };
}
use free_instance;

// SAFETY: the system protects its own reference counts.
unsafe impl Send for Residence {}

#[cfg(windows)]
#[link(name = "kernel32")]
unsafe extern "system" {
    fn GetModuleHandleExW(flags: u32, address: *const c_void, module: *mut *mut c_void) -> i32;
    fn FreeLibrary(module: *mut c_void) -> i32;
}

impl Residence {
    /// The system's handle of the library. A system function must release it.
    fn into_raw(self) -> *mut c_void {
        std::mem::ManuallyDrop::new(self).0
    }

    /// `None` if this library is linked into a program.
    pub fn take() -> Option<Self> {
        // Not a C function, since another FMU's function may replace it.
        let here = (Self::take as fn() -> _) as *const c_void;
        // SAFETY: any address may be queried. The name that is found is a C string and stays as long as the library.
        // Opening a library that is open runs no code and reads no file.
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
            // SAFETY: an address in this module; the handle stays null if the call fails.
            unsafe { GetModuleHandleExW(FROM_ADDRESS, here, &raw mut module) };
            module
        };
        #[cfg(not(any(unix, windows)))] // a browser's WebAssembly is never closed
        let handle = here.map_addr(|_| 0).cast_mut();
        (!handle.is_null()).then(|| Self(handle))
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
