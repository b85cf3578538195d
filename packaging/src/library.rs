//! Builds the shared library for this machine.

use crate::binary::{Binary, QUICK, cargo, compile, made};
#[cfg(unix)]
use crate::cross;
use crate::licenses::License;
use crate::{Failure, inspect};
use dth_hammer::MODEL_IDENTIFIER;
use std::env;
use std::path::Path;

/// Folder names of this machine in FMI 2.0 and in FMI 3.0.
const PLATFORM: [&str; 2] = if cfg!(target_os = "windows") {
    ["win64", "windows"]
} else if cfg!(target_os = "macos") {
    ["darwin64", "darwin"]
} else {
    ["linux64", "linux"]
};

/// Builds the library for this machine (on Linux also for old systems, if zig is there), and returns the licences of
/// linked code of others.
pub fn build(root: &Path) -> Result<(Binary, Vec<License>), Failure> {
    let extension = env::consts::DLL_EXTENSION;
    let mut command = cargo(root);
    #[cfg(unix)]
    let of_linker = cross::link_for_old_linux(root, &mut command)?;
    #[cfg(not(unix))]
    let of_linker = None;
    let bytes = compile(command, &[], extension)?;
    let library = of_this_machine(bytes)?;
    anonymous(&library)?;
    #[cfg(unix)]
    if of_linker.is_some() {
        cross::check_old_linux(&library.place, &library.bytes)?;
    } else if cfg!(target_os = "linux") {
        crate::tell("For old Linux", "`pip install ziglang`, and it runs with glibc 2.17 or newer");
    }
    Ok((library, of_linker.into_iter().collect()))
}

/// The library that cargo has built together with this program, in the same profile.
pub fn quick(root: &Path) -> Result<Binary, Failure> {
    let mut command = cargo(root);
    command.args(["build", "--locked", "--quiet", "--profile", QUICK]);
    // The same features as for that build, or the library would be built again.
    command.args(["--package", "packaging", "--package", "dth-fmu"]);
    of_this_machine(made(command, env::consts::DLL_EXTENSION)?)
}

fn of_this_machine(bytes: Vec<u8>) -> Result<Binary, Failure> {
    let [folder, system] = PLATFORM;
    let place = format!("binaries/{folder}/{MODEL_IDENTIFIER}.{}", env::consts::DLL_EXTENSION);
    let folders = vec![format!("{}-{system}", env::consts::ARCH)];
    let glibc = inspect::check(&place, &bytes)?;
    let glibc = glibc.map(|(major, minor)| format!(" with glibc {major}.{minor} or newer"));
    let (system, processor) = (env::consts::OS, env::consts::ARCH);
    let runs_on = format!("{system} on {processor}{}", glibc.unwrap_or_default());
    Ok(Binary { place, folders, runs_on, bytes })
}

/// Fails if a library contains the folder in which it was built.
fn anonymous(library: &Binary) -> Result<(), Failure> {
    let here = [env::home_dir(), Some(support::run::checkout()), Some("registry/src".into())];
    for folder in here.into_iter().flatten() {
        let path = format!("{}/", folder.display());
        if library.bytes.windows(path.len()).any(|part| part == path.as_bytes()) {
            let reason = format!("it names {path}");
            return Err(Failure::Unfit { name: library.place.clone(), reason });
        }
    }
    Ok(())
}
