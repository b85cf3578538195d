//! The library as part of a program, instead of loaded by it.

#![allow(unsafe_code, reason = "calls C")]

use dth_hammer::GUID;
use std::ffi::{CString, c_char, c_int, c_void};
use std::ptr::null;

unsafe extern "C" {
    fn fmi2Instantiate(
        name: *const c_char,
        kind: c_int,
        guid: *const c_char,
        resources: *const c_char,
        callbacks: *const c_void,
        visible: c_int,
        logging: c_int,
    ) -> *mut c_void;
    fn fmi2Reset(instance: *mut c_void) -> c_int;
    fn fmi2FreeInstance(instance: *mut c_void);
}

/// Then there is no library to keep loaded.
#[test]
fn an_instance_lives_and_is_freed_where_the_library_is_linked_into_the_program() {
    let guid = CString::new(GUID).unwrap();
    // SAFETY: as FMI 2.0 demands; the strings live until the call returns.
    unsafe {
        let name = c"a hammer".as_ptr();
        let instance = fmi2Instantiate(name, 1, guid.as_ptr(), null(), null(), 0, 0);
        assert!(!instance.is_null());
        assert_eq!(fmi2Reset(instance), 0);
        fmi2FreeInstance(instance);
        assert_eq!(fmi2Reset(instance), 3, "it is gone");
    }
}
