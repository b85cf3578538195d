//! The program exports what the loaded library calls of the sanitizer and the fuzzer, but not its own
//! copy of the FMI functions, which would stand in place of the library's.

fn main() {
    let map = concat!(env!("CARGO_MANIFEST_DIR"), "/exports.map");
    println!("cargo::rerun-if-changed={map}");
    println!("cargo::rustc-link-arg-bins=-Wl,--version-script={map}");
}
