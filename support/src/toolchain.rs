//! A Rust toolchain that can build for other machines.

use crate::run::{answer, cargo};
use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A browser. It is not a platform of FMI: the library for it is put into a page.
pub const BROWSER: &str = "wasm32-unknown-unknown";

/// A Rust that has the sources of its standard library.
pub struct Toolchain {
    cargo: PathBuf,
    rustc: PathBuf,
}

impl Toolchain {
    /// The toolchain in use if it has the sources, otherwise Debian's.
    #[must_use]
    pub fn find() -> Option<Self> {
        let here = cargo(Path::new(".")).get_program().into();
        [(here, "rustc"), ("/usr/bin/cargo".into(), "/usr/bin/rustc")]
            .map(|(cargo, rustc)| Self { cargo, rustc: rustc.into() })
            .into_iter()
            .find(Self::has_sources)
    }

    fn has_sources(&self) -> bool {
        let library = sysroot(Command::new(&self.rustc).stderr(Stdio::null()));
        let sources = library.map(|root| root.join("lib/rustlib/src/rust/library/std"));
        sources.is_some_and(|sources| sources.is_dir()) && self.cargo.exists()
    }

    /// Its cargo, in the workspace.
    #[must_use]
    pub fn command(&self, root: &Path) -> Command {
        let mut command = Command::new(&self.cargo);
        command.current_dir(root).env("RUSTC", &self.rustc);
        // The sources of the standard library may be built only by its own compiler; no other unstable feature is
        // used.
        command.env("RUSTC_BOOTSTRAP", "1");
        // The path of the running cargo's libraries, which belong to another compiler.
        command.env_remove("LD_LIBRARY_PATH");
        command
    }
}

/// Whether the toolchain in use has the standard library for a browser.
#[must_use]
pub fn has_browser_library() -> bool {
    let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let root = sysroot(&mut Command::new(rustc));
    root.is_some_and(|root| root.join("lib/rustlib").join(BROWSER).join("lib").is_dir())
}

fn sysroot(rustc: &mut Command) -> Option<PathBuf> {
    answer(rustc.args(["--print", "sysroot"])).map(PathBuf::from)
}

/// What must be installed to build for a browser; none if nothing is missing.
#[must_use]
pub fn browser_lacks() -> Option<String> {
    if cfg!(not(unix)) {
        return Some("the laboratory is built on Linux or macOS".into());
    }
    let able = has_browser_library() || Toolchain::find().is_some();
    (!able).then(|| to_install(false, true) + ", or `rustup target add wasm32-unknown-unknown`")
}

/// What must be installed for other machines: the sources of Rust, or a linker for Windows.
#[must_use]
pub fn to_install(rust: bool, mingw: bool) -> String {
    let mut packages = Vec::new();
    if !rust {
        packages.extend(["rustc-web", "rust-web-src", "cargo-web"]);
    }
    if !mingw {
        packages.push("gcc-mingw-w64-x86-64");
    }
    let more = if rust { "" } else { ", or `rustup component add rust-src` for the first three" };
    format!("first `apt install {}`{more}", packages.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_missing_is_asked_for() {
        assert!(to_install(true, false).ends_with("`apt install gcc-mingw-w64-x86-64`"));
        assert!(!to_install(false, true).contains("mingw"));
        assert!(to_install(false, false).contains("rust-web-src cargo-web gcc-mingw-w64-x86-64`"));
    }
}
