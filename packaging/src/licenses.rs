//! Licences of everything that is linked into the library.

use crate::binary::{anonymous, cargo, output};
use crate::{About, Failure};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use support::run::target;

/// Path of the licences in the archive, as FMI defines it.
pub const PLACE: &str = "documentation/licenses/license.txt";

/// Packages of the FMU's library, and of a wheel with its native module.
pub const FMU: [&str; 1] = ["dth-fmu"];
const WHEEL: [&str; 2] = ["dth-fmu", "dth-native"];

/// Licence of one package.
#[derive(Clone, Serialize)]
pub struct License {
    /// Package and version.
    pub name: String,
    /// SPDX expression.
    pub terms: String,
    /// Its texts.
    #[serde(skip)]
    texts: Vec<String>,
}

/// `cargo metadata`, as far as it matters here.
#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Package>,
}

#[derive(Deserialize)]
struct Package {
    name: String,
    version: String,
    license: Option<String>,
    manifest_path: PathBuf,
}

/// Writes down for `wheels.py` the contents of a wheel of this machine, and their licences.
pub fn note_wheel(root: &Path) -> Result<(), Failure> {
    let licenses = collect(root, &WHEEL, &[&host(root)?], Vec::new())?;
    let folder = target(root).join("wheel");
    fs::create_dir_all(&folder).about(&folder)?;
    let write = |name, text: String| {
        let path = folder.join(name);
        fs::write(&path, text).about(&path)
    };
    write("licenses.txt", text(&licenses))?;
    write("rustflags.txt", anonymous()?.join("\u{1f}"))?;
    write("contents.json", serde_json::to_string(&licenses)?)
}

/// The licences of everything in these packages for the given targets, and of `others`, sorted by name.
pub fn collect(
    root: &Path,
    packages: &[&str],
    triples: &[&str],
    mut licenses: Vec<License>,
) -> Result<Vec<License>, Failure> {
    licenses.push(License {
        name: "Rust standard library".into(),
        terms: "MIT OR Apache-2.0".into(),
        texts: Vec::new(),
    });
    for triple in triples {
        let mut command = cargo(root);
        let shape = ["metadata", "--locked", "--format-version", "1", "--filter-platform"];
        let metadata: Metadata = serde_json::from_slice(&output(command.args(shape).arg(triple))?)?;
        let linked = linked(root, packages, triple)?;
        for package in &metadata.packages {
            if linked.contains(&format!("{} v{}", package.name, package.version)) {
                licenses.push(license(root, package)?);
            }
        }
    }
    licenses.sort_by(|a, b| a.name.cmp(&b.name));
    licenses.dedup_by(|a, b| a.name == b.name);
    Ok(licenses)
}

/// Packages with their versions that are compiled into these: their normal dependencies with their features.
/// Procedural macros and dependencies of build scripts run in the compiler, and those of tests are not shipped.
fn linked(root: &Path, packages: &[&str], triple: &str) -> Result<BTreeSet<String>, Failure> {
    let mut command = cargo(root);
    command.args(["tree", "--locked", "--edges", "normal,no-proc-macro"]);
    command.args(packages.iter().flat_map(|package| ["--package", package]));
    let text = output(command.args(["--prefix", "none", "--format", "{p}", "--target", triple]))?;
    let words = |line: &str| line.split(' ').take(2).collect::<Vec<_>>().join(" ");
    Ok(String::from_utf8_lossy(&text).lines().map(words).collect())
}

/// All licences as one file. A text that several packages share appears once.
pub fn text(licenses: &[License]) -> String {
    let mut shared: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    let mut list = String::new();
    for license in licenses {
        list += &format!("{}: {}\n", license.name, license.terms);
        for text in &license.texts {
            shared.entry(text).or_default().push(&license.name);
        }
    }
    let section = |(text, names): (&str, Vec<&str>)| {
        format!("\n{}\n{}\n\n{}\n", "=".repeat(78), names.join(", "), text.trim_end())
    };
    list + &shared.into_iter().map(section).collect::<String>()
}

/// The licence of something that is not a cargo package, with its text if that exists.
pub fn foreign(name: &str, terms: &str, text: &Path) -> Result<License, Failure> {
    let texts = if text.is_file() { vec![read(text)?] } else { Vec::new() };
    Ok(License { name: name.into(), terms: terms.into(), texts })
}

/// The machine's target triple: packages of other platforms are not linked.
pub fn host(root: &Path) -> Result<String, Failure> {
    let mut command = cargo(root);
    let text = output(command.args(["--version", "--verbose"]))?;
    let text = String::from_utf8_lossy(&text);
    let host = text.lines().find_map(|line| line.strip_prefix("host: "));
    let reason = "it does not name its host".into();
    host.map(str::to_owned).ok_or(Failure::Program { program: "cargo --version".into(), reason })
}

fn license(root: &Path, package: &Package) -> Result<License, Failure> {
    let name = format!("{} {}", package.name, package.version);
    let folder = package.manifest_path.parent().unwrap_or(root);
    let texts = texts(folder)?.iter().map(|path| read(path)).collect::<Result<_, _>>()?;
    let terms = package.license.clone().unwrap_or_else(|| "see its texts".into());
    Ok(License { name, terms, texts })
}

/// A text with Unix line ends, so that equal texts compare equal.
fn read(path: &Path) -> Result<String, Failure> {
    let bytes = fs::read(path).about(path)?;
    Ok(String::from_utf8_lossy(&bytes).replace("\r\n", "\n").trim_end().to_owned())
}

fn texts(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    const NAMES: [&str; 5] = ["LICENSE", "LICENCE", "COPYING", "UNLICENSE", "NOTICE"];
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).about(folder)? {
        let path = entry.about(folder)?.path();
        let name = path.file_name().map(|name| name.to_string_lossy().to_uppercase());
        if name.is_some_and(|name| NAMES.iter().any(|n| name.starts_with(n))) && path.is_file() {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}
