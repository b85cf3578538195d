//! `cargo fmu --all-platforms`: the library for other machines.
//!
//! zig links for Linux, since it knows the symbols of every glibc; it comes from PyPI. mingw-w64 links for Windows.
//! Rust's standard library for Windows and aarch64 is built here, from the sources in Debian's package, since a
//! rustup toolchain may be unable to fetch it.

use crate::binary::{Binary, cargo, compile, output};
use crate::licenses::{self, License};
use crate::{About, Failure, inspect, tell};
use dth_hammer::MODEL_IDENTIFIER;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};
use support::python::{Environment, Needs};
use support::run::target;
use support::toolchain::{BROWSER, Toolchain, browser_lacks, has_browser_library, to_install};

/// The glibc of the oldest Linux still seen at companies (RHEL 7).
const OLDEST_GLIBC: inspect::Version = (2, 17);

/// A platform that a library is built for.
pub struct Platform {
    /// Its name in Rust.
    pub triple: &'static str,
    /// Folders of `binaries/`: in FMI 2.0, in FMI 3.0.
    folders: [&'static str; 2],
    /// Extension of the library.
    extension: &'static str,
    linker: Linker,
    /// Whether Rust's standard library must be built for it.
    build_library: bool,
    runs_on: &'static str,
}

/// The linker.
enum Linker {
    /// Zig, for this target.
    Zig(&'static str),
    /// A program on the path.
    Program(&'static str),
}

/// Linux on x86-64, including old systems.
pub const LINUX: Platform = Platform {
    triple: "x86_64-unknown-linux-gnu",
    folders: ["linux64", "x86_64-linux"],
    extension: "so",
    linker: Linker::Zig("x86_64-linux-gnu.2.17"),
    build_library: false,
    runs_on: "Linux on x86-64 with glibc 2.17 or newer",
};

/// Windows on x86-64.
pub const WINDOWS: Platform = Platform {
    triple: "x86_64-pc-windows-gnu",
    folders: ["win64", "x86_64-windows"],
    extension: "dll",
    linker: Linker::Program("x86_64-w64-mingw32-gcc"),
    build_library: true,
    runs_on: "Windows 10 or newer on x86-64",
};

/// Linux on 64-bit ARM. FMI 2.0 has no folder for it, and hosts there (fmpy, the crate fmi) look in `linux64`, so it
/// needs a file of its own.
pub const AARCH64: Platform = Platform {
    triple: "aarch64-unknown-linux-gnu",
    folders: ["linux64", "aarch64-linux"],
    extension: "so",
    linker: Linker::Zig("aarch64-linux-gnu.2.17"),
    build_library: true,
    runs_on: "Linux on aarch64 with glibc 2.17 or newer",
};

/// macOS, with both of its processors in one file. It is built only there, since the linker is Apple's.
pub const MACOS: [&str; 2] = ["aarch64-apple-darwin", "x86_64-apple-darwin"];
/// Its oldest version that has both processors.
const OLDEST_MACOS: &str = "11.0";
const MACOS_PLACE: &str = "binaries/darwin64/dth_hammer.dylib";

/// The library for macOS.
pub fn macos_binary(bytes: Vec<u8>) -> Binary {
    let runs_on = format!("macOS {OLDEST_MACOS} or newer on arm64 and x86-64");
    let folders = vec!["aarch64-darwin".into(), "x86_64-darwin".into()];
    Binary { place: MACOS_PLACE.into(), folders, runs_on, bytes }
}

/// Builds the library for macOS, on macOS, with the targets of `rustup target add`.
pub fn build_for_macos(root: &Path) -> Result<Binary, Failure> {
    let folder = target(root).join("universal");
    fs::create_dir_all(&folder).about(&folder)?;
    let whole = folder.join("dth_hammer.dylib");
    let mut join = Command::new("lipo");
    join.arg("-create").arg("-output").arg(&whole);
    for triple in MACOS {
        let mut command = cargo(root);
        command.env("CARGO_BUILD_TARGET", triple).env("MACOSX_DEPLOYMENT_TARGET", OLDEST_MACOS);
        let part = folder.join(triple);
        fs::write(&part, compile(command, &[], "dylib")?).about(&part)?;
        join.arg(part);
    }
    output(&mut join)?;
    Ok(macos_binary(fs::read(&whole).about(&whole)?))
}

/// Everything needed to build for other machines.
pub struct Workshop {
    root: PathBuf,
    zig: PathBuf,
    toolchain: Toolchain,
}

impl Workshop {
    /// Finds or installs everything needed.
    pub fn open(root: &Path) -> Result<Self, Failure> {
        if !cfg!(all(target_os = "linux", target_arch = "x86_64")) {
            return Err(Failure::Missing("that takes Linux on x86-64".into()));
        }
        let (toolchain, mingw) = (Toolchain::find(), starts("x86_64-w64-mingw32-gcc"));
        let rust = toolchain.is_some();
        let Some(toolchain) = toolchain.filter(|_| mingw) else {
            return Err(Failure::Missing(to_install(rust, mingw)));
        };
        let zig = Environment::prepare(root, Needs::Cross)?.program("python");
        Ok(Self { root: root.into(), zig, toolchain })
    }

    /// The library for a browser, by the toolchain in use if it has the standard library for that, otherwise as for
    /// other machines.
    pub fn build_for_browser(root: &Path) -> Result<Vec<u8>, Failure> {
        let name = BROWSER.to_uppercase().replace('-', "_");
        if let Some(how) = browser_lacks() {
            return Err(Failure::Missing(how));
        }
        let mut command = cargo(root);
        if let Some(toolchain) = Toolchain::find().filter(|_| !has_browser_library()) {
            let zig = Environment::prepare(root, Needs::Cross)?.program("python");
            let linker = zig_program(root, &zig, "wasm-ld", "wasm-ld", 2)?;
            command = toolchain.command(root);
            command.arg("-Zbuild-std=std,panic_abort");
            command.env("CARGO_TARGET_DIR", target(root).join("cross"));
            command.env(format!("CARGO_TARGET_{name}_LINKER"), linker);
        }
        // Vectors of two numbers, which every browser has, and a table for functions that the page passes to the
        // library.
        let mut flags = vec!["-Ctarget-feature=+simd128".to_owned()];
        flags.extend(["--export-table", "--growable-table"].map(|f| format!("-Clink-arg={f}")));
        command.env("CARGO_BUILD_TARGET", BROWSER);
        compile(command, &flags, "wasm")
    }

    /// Builds the library for a machine, and checks it.
    pub fn build(&self, platform: &Platform) -> Result<Binary, Failure> {
        let linker = match platform.linker {
            Linker::Zig(triple) => zig_linker(&self.root, &self.zig, triple)?,
            Linker::Program(program) => program.into(),
        };
        let mut command = cargo(&self.root);
        if platform.build_library {
            command = self.toolchain.command(&self.root);
            command.arg("-Zbuild-std=std,panic_unwind");
            // This is another compiler; in a common folder, each would rebuild everything after the other.
            command.env("CARGO_TARGET_DIR", target(&self.root).join("cross"));
        }
        link_by(&mut command, platform, &linker);
        let bytes = compile(command, &[], platform.extension)?;
        let [folder, of_three] = platform.folders;
        let place = format!("binaries/{folder}/{MODEL_IDENTIFIER}.{}", platform.extension);
        inspect::check(&place, &bytes)?;
        if platform.extension == "so" {
            inspect::check_glibc(&place, &bytes, OLDEST_GLIBC)?;
        }
        let (folders, runs_on) = (vec![of_three.into()], platform.runs_on.into());
        Ok(Binary { place, folders, runs_on, bytes })
    }

    /// The licences of everything in the libraries for these platforms.
    pub fn licenses(&self, platforms: &[Platform]) -> Result<Vec<License>, Failure> {
        let mut more = Vec::new();
        for platform in platforms {
            if matches!(platform.linker, Linker::Zig(_)) {
                more.push(license_of_zig(&self.zig)?);
                continue;
            }
            for (name, terms, package) in [
                ("GCC runtime", "GPL-3.0-or-later WITH GCC-exception-3.1", "gcc-mingw-w64-base"),
                ("mingw-w64 runtime", "ZPL-2.1 AND MIT AND others", "mingw-w64-x86-64-dev"),
            ] {
                let text = Path::new("/usr/share/doc").join(package).join("copyright");
                more.push(licenses::foreign(name, terms, &text)?);
            }
        }
        let triples: Vec<&str> = platforms.iter().map(|platform| platform.triple).collect();
        licenses::collect(&self.root, &licenses::FMU, &triples, more)
    }
}

/// Makes cargo link for every glibc since 2.17, if this is Linux and a Python has zig. Returns the licence of what
/// zig adds to the library.
pub fn link_for_old_linux(root: &Path, cargo: &mut Command) -> Result<Option<License>, Failure> {
    let here = |platform: &Platform| {
        platform.triple.strip_prefix(env::consts::ARCH) == Some("-unknown-linux-gnu")
    };
    let is_linux = cfg!(all(target_os = "linux", target_env = "gnu"));
    let Some(platform) = [LINUX, AARCH64].into_iter().filter(|_| is_linux).find(here) else {
        return Ok(None);
    };
    let (Linker::Zig(triple), Some((python, version))) =
        (&platform.linker, Environment::with_zig(root))
    else {
        return Ok(None);
    };
    tell("Linking", &format!("by zig {version}, for {}", platform.runs_on));
    link_by(cargo, &platform, &zig_linker(root, &python, triple)?);
    license_of_zig(&python).map(Some)
}

/// Fails if a library that zig linked needs a newer glibc.
pub fn check_old_linux(place: &str, bytes: &[u8]) -> Result<(), Failure> {
    inspect::check_glibc(place, bytes, OLDEST_GLIBC)
}

fn link_by(cargo: &mut Command, platform: &Platform, linker: &Path) {
    let name = platform.triple.to_uppercase().replace('-', "_");
    cargo.env(format!("CARGO_TARGET_{name}_LINKER"), linker);
    cargo.env("CARGO_BUILD_TARGET", platform.triple);
}

/// The licence of the code that zig links into a library for Linux.
fn license_of_zig(python: &Path) -> Result<License, Failure> {
    let mut command = Command::new(python);
    let folder = output(command.args(["-c", "import ziglang; print(*ziglang.__path__)"]))?;
    let folder = PathBuf::from(String::from_utf8_lossy(&folder).trim());
    let text = folder.join("lib/libunwind/LICENSE.TXT");
    licenses::foreign("LLVM libunwind", "Apache-2.0 WITH LLVM-exception", &text)
}

fn zig_linker(root: &Path, python: &Path, triple: &str) -> Result<PathBuf, Failure> {
    zig_program(root, python, triple, &format!("cc -target {triple}"), 0)
}

/// A program that calls zig as a linker, without the first arguments (rustc passes `-flavor wasm` to LLVM's linker).
/// Its caches are in the target folder.
fn zig_program(
    root: &Path,
    python: &Path,
    name: &str,
    task: &str,
    without: usize,
) -> Result<PathBuf, Failure> {
    let folder = target(root).join("linkers");
    fs::create_dir_all(&folder).about(&folder)?;
    let cache = folder.join("cache").display().to_string();
    let python = python.display();
    let script = format!(
        "#!/bin/sh\nexport ZIG_GLOBAL_CACHE_DIR='{cache}' ZIG_LOCAL_CACHE_DIR='{cache}'\n\
         shift {without}\nexec '{python}' -m ziglang {task} \"$@\"\n"
    );
    let path = folder.join(name);
    fs::write(&path, script).about(&path)?;
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).about(&path)?;
    Ok(path)
}

fn starts(program: &str) -> bool {
    output(Command::new(program).arg("--version")).is_ok()
}
