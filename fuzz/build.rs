//! The program exports the symbols of the sanitizer and the fuzzer that the loaded library calls. It must not export
//! its own copy of the FMI functions, which would replace the library's.

fn main() {
    let map = concat!(env!("CARGO_MANIFEST_DIR"), "/exports.map");
    println!("cargo::rerun-if-changed={map}");
    println!("cargo::rustc-link-arg-bins=-Wl,--version-script={map}");
}
