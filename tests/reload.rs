//! Hosts that close the library and open it again while instances live.

use crate::support::host::Host;
use crate::support::library::{ERROR, Library, OK};
use std::fs;
use std::path::{Path, PathBuf};

/// A copy of the library that only this test opens.
struct Copy(PathBuf);

impl Copy {
    fn new(name: &str) -> Self {
        let path = Library::path().with_file_name(format!("reload_{name}_{}", std::process::id()));
        fs::copy(Library::path(), &path).unwrap();
        Self(path)
    }

    /// Whether the system has the library in memory; only Linux tells.
    fn is_loaded(&self) -> Option<bool> {
        let maps = fs::read_to_string("/proc/self/maps").ok()?;
        Some(maps.contains(self.0.file_name().unwrap().to_str().unwrap()))
    }
}

impl AsRef<Path> for Copy {
    fn as_ref(&self) -> &Path {
        &self.0
    }
}

impl Drop for Copy {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.0);
    }
}

/// fmi4c, and so ecos, closes and opens the library at each instantiation.
#[test]
fn instances_outlive_the_loads_that_made_them() {
    let copy = Copy::new("outlive");
    let first = Library::load_from(copy.as_ref());
    let one = Host::new(&first).detach();
    drop(first);
    let library = Library::load_from(copy.as_ref());
    let two = Host::new(&library).detach();
    assert_ne!(one.handle, two.handle);
    let [one, two] = [one, two].map(|instance| instance.attach(&library));
    one.set("feed_force", 4e3);
    two.set("feed_force", 9e3);
    assert_eq!([one.get("feed_force"), two.get("feed_force")], [4e3, 9e3]);
    for host in [&one, &two] {
        host.start(0.0);
        host.step(0.0, 0.05);
    }
    let alone = Host::running(&library, &[("feed_force", 4e3)]);
    alone.step(0.0, 0.05);
    assert_eq!(one.fingerprint(), alone.fingerprint());
    assert_ne!(two.fingerprint(), alone.fingerprint());
}

#[test]
fn the_library_goes_with_its_last_instance() {
    let copy = Copy::new("goes");
    let library = Library::load_from(copy.as_ref());
    // A refused instance must not keep it loaded either.
    assert_eq!(library.instantiate(Some("x"), 1, Some("wrong"), None, None, false).0, 0);
    let hosts: Vec<Host> = (0..3).map(|_| Host::running(&library, &[])).collect();
    hosts[1].step(0.0, 0.05);
    drop(hosts);
    drop(library);
    assert_ne!(copy.is_loaded(), Some(true));
}

#[test]
fn the_last_instance_is_freed_after_its_host_has_closed_the_library() {
    for (name, function) in [("two", b"fmi2FreeInstance\0"), ("three", b"fmi3FreeInstance\0")] {
        let copy = Copy::new(&format!("last_{name}"));
        let library = Library::load_from(copy.as_ref());
        let handle = Host::running(&library, &[]).detach().handle;
        // The call returns here, though no code of the library is left to return from.
        library.close_and_free(handle, function);
        assert_ne!(copy.is_loaded(), Some(true));
    }
}

#[test]
fn the_reference_is_found_though_file_and_folder_are_gone() {
    let copy = Copy::new("gone");
    let first = Library::load_from(copy.as_ref());
    fs::remove_file(copy.as_ref()).unwrap();
    let one = Host::new(&first).detach();
    drop(first);
    assert_ne!(copy.is_loaded(), Some(false));
    // It may be opened by any name, here by one that the system has in memory.
    let library = Library::load_from(copy.as_ref());
    one.attach(&library).start(0.0);
}

#[test]
fn a_handle_taken_for_a_pointer_does_no_harm() {
    let library = Library::load();
    let host = Host::running(&library, &[]);
    host.step(0.0, 1e-3);
    let state = host.state();
    for handle in [host.handle, state] {
        assert_eq!(handle.0 % align_of::<u64>(), 0);
        assert_eq!(library.peek(handle, 0), handle.0, "it points at itself");
        for word in 0..dth_hammer::READABLE / size_of::<usize>() {
            library.peek(handle, word);
        }
    }
    // A handle that is passed instead of a pointer to it has the intended effect.
    assert_eq!(library.free_state_by_value(host.handle, state), OK);
    assert_eq!(library.set_state(host.handle, state), ERROR, "it is freed");
    assert_eq!(library.free_state_by_value(host.handle, state), OK, "and free as null is");
    host.only_error();
    host.step(1e-3, 1e-3);
}
