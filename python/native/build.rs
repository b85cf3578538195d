//! Linker flags of a Python module, which links no part of Python itself, and a hash that identifies the engine among
//! builds of the same version.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::{fs, io};

/// Sources that determine the numbers of a run: the engine, and the code that calls it.
const SOURCES: [&str; 2] = ["../../hammer/src", "src"];

fn main() -> io::Result<()> {
    pyo3_build_config::add_extension_module_link_args();
    let mut hasher = DefaultHasher::new();
    for source in SOURCES {
        println!("cargo::rerun-if-changed={source}");
        hash(Path::new(source), &mut hasher)?;
    }
    println!("cargo::rustc-env=DTH_ENGINE={:016x}", hasher.finish());
    Ok(())
}

/// Hashes the files below a folder, in the order of their names.
fn hash(folder: &Path, hasher: &mut DefaultHasher) -> io::Result<()> {
    let paths = fs::read_dir(folder)?.map(|entry| Ok(entry?.path()));
    let mut paths: Vec<PathBuf> = paths.collect::<io::Result<_>>()?;
    paths.sort();
    for path in paths {
        if path.is_dir() {
            hash(&path, hasher)?;
        } else {
            (path.file_name(), fs::read(&path)?).hash(hasher);
        }
    }
    Ok(())
}
