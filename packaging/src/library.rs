//! Builds the shared library for this machine.

use crate::binary::{Binary, cargo, compile};
#[cfg(unix)]
use crate::cross;
use crate::licenses::License;
use crate::{Failure, inspect};
use dth_hammer::MODEL_IDENTIFIER;
use std::env;
use std::path::Path;

/// What the machine that this runs on is called in the names of folders: in FMI 2.0, in FMI 3.0.
const PLATFORM: [&str; 2] = if cfg!(target_os = "windows") {
    ["win64", "windows"]
} else if cfg!(target_os = "macos") {
    ["darwin64", "darwin"]
} else {
    ["linux64", "linux"]
};

/// Builds the library for this machine, on Linux for old ones too if zig is there; and what others have
/// in it.
///
/// # Errors
/// If it does not build, or is not what it should be.
pub fn build(root: &Path) -> Result<(Binary, Vec<License>), Failure> {
    let extension = env::consts::DLL_EXTENSION;
    let mut command = cargo(root);
    #[cfg(unix)]
    let of_linker = cross::link_for_old_linux(root, &mut command)?;
    #[cfg(not(unix))]
    let of_linker = None;
    let bytes = compile(command, &[], extension)?;
    let [folder, system] = PLATFORM;
    let place = format!("binaries/{folder}/{MODEL_IDENTIFIER}.{extension}");
    let folders = vec![format!("{}-{system}", env::consts::ARCH)];
    let needs = inspect::check(&place, &bytes)?;
    #[cfg(unix)]
    if of_linker.is_some() {
        cross::check_old_linux(&place, &bytes)?;
    }
    let glibc = needs.map(|(major, minor)| format!(" with glibc {major}.{minor} or newer"));
    let (system, processor) = (env::consts::OS, env::consts::ARCH);
    let runs_on = format!("{system} on {processor}{}", glibc.unwrap_or_default());
    Ok((Binary { place, folders, runs_on, bytes }, of_linker.into_iter().collect()))
}
