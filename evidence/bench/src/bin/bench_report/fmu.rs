//! The shared library of the .fmu, called as a host calls it.

use crate::{Failure, root, target};
use bench::library::{self, Fmu, State};
use std::ffi::CString;
use std::path::PathBuf;
use std::process::Command;

/// What is known of the .fmu.
pub struct Unpacked {
    library: Fmu,
    description: String,
}

/// Builds the .fmu and unpacks its library.
pub fn unpack() -> Result<Unpacked, Failure> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    if !Command::new(cargo).current_dir(root()).arg("fmu").status()?.success() {
        return Err("cargo fmu failed".into());
    }
    let file = std::fs::File::open(root().join("dist/dth_hammer.fmu"))?;
    let mut archive = zip::ZipArchive::new(file)?;
    let mut entry = |name: &str, path: PathBuf| -> Result<PathBuf, Failure> {
        let mut out = std::fs::File::create(&path)?;
        std::io::copy(&mut archive.by_name(name)?, &mut out)?;
        Ok(path)
    };
    let folder = target().join("bench-report");
    std::fs::create_dir_all(&folder)?;
    let description = entry("modelDescription.xml", folder.join("modelDescription.xml"))?;
    let library = entry("binaries/linux64/dth_hammer.so", folder.join("dth_hammer.so"))?;
    Ok(Unpacked {
        library: Fmu::load(&library)?,
        description: std::fs::read_to_string(description)?,
    })
}

/// The value of `key="..."` after the first occurrence of `after`.
fn attribute<'a>(text: &'a str, after: &str, key: &str) -> Option<&'a str> {
    let rest = &text[text.find(after)?..];
    let start = rest.find(&format!("{key}=\""))? + key.len() + 2;
    rest[start..].split('"').next()
}

impl Unpacked {
    /// Value reference of a variable.
    ///
    /// # Panics
    /// There is none of that name.
    pub fn reference(&self, name: &str) -> u32 {
        attribute(&self.description, &format!("<ScalarVariable name=\"{name}\""), "valueReference")
            .and_then(|text| text.parse().ok())
            .unwrap_or_else(|| panic!("no variable {name}"))
    }
}

/// An instance that is ready to step.
pub struct Instance<'a> {
    inner: library::Instance<'a>,
    /// Until it is dropped.
    start: Option<State>,
}

impl<'a> Instance<'a> {
    /// The reference hammer at rest.
    pub fn new(unpacked: &'a Unpacked) -> Result<Self, Failure> {
        let guid = attribute(&unpacked.description, "<fmiModelDescription", "guid");
        let inner = unpacked.library.instantiate(&CString::new(guid.ok_or("no guid")?)?)?;
        inner.initialise();
        let start = inner.save();
        Ok(Self { inner, start: Some(start) })
    }

    /// Back to rest at time 0; what has been decomposed is kept by the library or not.
    pub fn rewind(&mut self) {
        self.start.iter().for_each(|start| self.inner.restore(start));
    }

    /// `fmi2DoStep`.
    pub fn step(&self, time: f64, size: f64) {
        self.inner.step(time, size);
    }

    /// `fmi2GetReal`.
    pub fn read(&self, references: &[u32], values: &mut [f64]) {
        self.inner.get(references, values);
    }
}

impl Drop for Instance<'_> {
    fn drop(&mut self) {
        self.start.take().into_iter().for_each(|start| self.inner.forget(start));
    }
}
