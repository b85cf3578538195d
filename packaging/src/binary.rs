//! Builds a shared library with the cargo that runs this program.

use crate::archive::File;
use crate::{About, Failure, Standard};
use dth_hammer::MODEL_IDENTIFIER;
use serde::Deserialize;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::{env, fs};

/// A line of `cargo build --message-format=json`, with the fields that are used.
#[derive(Deserialize)]
struct Message {
    reason: String,
    target: Option<Target>,
    #[serde(default)]
    filenames: Vec<PathBuf>,
}

#[derive(Deserialize)]
struct Target {
    name: String,
}

/// The profile that this program and the native module of a checkout are built in.
pub const QUICK: &str = "native";

/// Cargo, the one that started us.
pub fn cargo(root: &Path) -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root);
    command
}

/// Output of a program.
pub fn output(command: &mut Command) -> Result<Vec<u8>, Failure> {
    let program = format!("{command:?}");
    let fail = |reason: String| Failure::Program { program: program.clone(), reason };
    let output = command
        .stdin(Stdio::null())
        .stderr(Stdio::inherit())
        .output()
        .map_err(|error| fail(error.to_string()))?;
    if output.status.success() { Ok(output.stdout) } else { Err(fail(output.status.to_string())) }
}

/// A shared library for some machine.
pub struct Binary {
    /// Its path in an archive of FMI 2.0.
    pub place: String,
    /// Its folders in an archive of FMI 3.0: processor and system.
    pub folders: Vec<String>,
    /// The machine that it runs on.
    pub runs_on: String,
    /// Content.
    pub bytes: Vec<u8>,
}

impl Binary {
    /// Its paths in the archive of a standard.
    pub fn places(&self, standard: Standard) -> Vec<String> {
        let name = self.place.rsplit('/').next().unwrap_or_default();
        match standard {
            Standard::Two => vec![self.place.clone()],
            Standard::Three => {
                self.folders.iter().map(|folder| format!("binaries/{folder}/{name}")).collect()
            }
        }
    }

    /// Its files in that archive.
    pub fn files(&self, standard: Standard) -> impl Iterator<Item = File> {
        self.places(standard).into_iter().map(|place| File::new(place, &*self.bytes))
    }
}

/// Builds the library with this cargo, in its own profile and with `flags` for the compiler, and reads it.
pub fn compile(mut cargo: Command, flags: &[String], extension: &str) -> Result<Vec<u8>, Failure> {
    let flags = [flags, &anonymous()?].concat();
    cargo.env("CARGO_ENCODED_RUSTFLAGS", flags.join("\u{1f}"));
    cargo.args(["build", "--locked", "--profile", "fmu", "--package", "dth-fmu", "--lib"]);
    made(cargo, extension)
}

/// Builds a library with cargo, and reads it.
pub fn made(mut cargo: Command, extension: &str) -> Result<Vec<u8>, Failure> {
    cargo.arg("--message-format=json-render-diagnostics");
    let program = format!("{cargo:?}");
    let messages = output(&mut cargo)?;
    let path = shared_library(&messages, extension)?
        .ok_or_else(|| Failure::Program { program, reason: "it made no shared library".into() })?;
    fs::read(&path).about(&path)
}

/// Flags that keep this machine's folders out of the library. A panic's message names its source file, including
/// files of the standard library if its sources are installed.
pub fn anonymous() -> Result<Vec<String>, Failure> {
    let home = env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| Some(env::home_dir()?.join(".cargo"))).unwrap_or_default();
    let sources = home.join("registry/src");
    let mut flags = Vec::new();
    for entry in fs::read_dir(&sources).about(&sources)? {
        let folder = entry.about(&sources)?.path();
        flags.push(format!("--remap-path-prefix={}=crates", folder.display()));
    }
    let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let printed = output(Command::new(rustc).args(["--print", "sysroot"]))?;
    let toolchain = String::from_utf8_lossy(&printed).trim().to_owned();
    flags.push(format!("--remap-path-prefix={toolchain}/lib/rustlib/src/rust=rust"));
    Ok(flags)
}

fn shared_library(messages: &[u8], extension: &str) -> Result<Option<PathBuf>, Failure> {
    let wanted = Some(OsStr::new(extension));
    for line in messages.split(|byte| *byte == b'\n').filter(|line| !line.is_empty()) {
        let message: Message = serde_json::from_slice(line)?;
        let ours = message.target.is_some_and(|target| target.name == MODEL_IDENTIFIER);
        if message.reason == "compiler-artifact" && ours {
            return Ok(message.filenames.into_iter().find(|f| f.extension() == wanted));
        }
    }
    Ok(None)
}
