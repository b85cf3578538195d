//! What a module of Python is linked with: nothing of Python itself.

fn main() {
    pyo3_build_config::add_extension_module_link_args();
}
