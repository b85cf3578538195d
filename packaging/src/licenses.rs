//! Licences of everything that is linked into the library.

use crate::archive::File;
use crate::library::{cargo, output};
use crate::{About, Failure};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Licence of one package.
pub struct License {
    /// Package and version.
    pub name: String,
    /// SPDX expression.
    pub terms: String,
    /// The texts, for the archive.
    pub files: Vec<File>,
}

/// `cargo metadata`, as far as it matters here.
#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Package>,
    resolve: Resolve,
}

#[derive(Deserialize)]
struct Package {
    id: String,
    name: String,
    version: String,
    license: Option<String>,
    manifest_path: PathBuf,
    targets: Vec<Target>,
}

#[derive(Deserialize)]
struct Target {
    kind: Vec<String>,
}

#[derive(Deserialize)]
struct Resolve {
    nodes: Vec<Node>,
}

#[derive(Deserialize)]
struct Node {
    id: String,
    deps: Vec<Dependency>,
}

#[derive(Deserialize)]
struct Dependency {
    pkg: String,
    dep_kinds: Vec<DependencyKind>,
}

#[derive(Deserialize)]
struct DependencyKind {
    kind: Option<String>,
}

/// The licences of what is linked for the given targets, and of what else is, sorted by name.
///
/// # Errors
/// If cargo fails or a text cannot be read.
pub fn collect(
    root: &Path,
    triples: &[&str],
    mut licenses: Vec<License>,
) -> Result<Vec<License>, Failure> {
    licenses.push(License {
        name: "Rust standard library".into(),
        terms: "MIT OR Apache-2.0".into(),
        files: Vec::new(),
    });
    for triple in triples {
        let mut command = cargo(root);
        command.args(["metadata", "--format-version", "1", "--filter-platform", triple]);
        let metadata: Metadata = serde_json::from_slice(&output(&mut command)?)?;
        let linked = linked(&metadata);
        for package in metadata.packages.iter().filter(|p| linked.contains(&*p.id)) {
            licenses.push(license(root, package)?);
        }
    }
    licenses.sort_by(|a, b| a.name.cmp(&b.name));
    licenses.dedup_by(|a, b| a.name == b.name);
    Ok(licenses)
}

/// The licence of something that is no package of cargo's, with its text if that is there.
///
/// # Errors
/// If the text is there but cannot be read.
pub fn foreign(name: &str, terms: &str, text: &Path) -> Result<License, Failure> {
    let mut files = Vec::new();
    if text.is_file() {
        let place = format!("documentation/licenses/{}/LICENSE.txt", name.replace(' ', "-"));
        files.push(File::new(place, fs::read(text).about(text)?));
    }
    Ok(License { name: name.into(), terms: terms.into(), files })
}

/// The machine's target triple: other platforms' packages are not linked.
///
/// # Errors
/// If cargo does not name it.
pub fn host(root: &Path) -> Result<String, Failure> {
    let mut command = cargo(root);
    let text = output(command.args(["--version", "--verbose"]))?;
    let text = String::from_utf8_lossy(&text);
    let host = text.lines().find_map(|line| line.strip_prefix("host: "));
    let reason = "it does not name its host".into();
    host.map(str::to_owned).ok_or(Failure::Program { program: "cargo --version".into(), reason })
}

/// What the library is made of: normal dependencies, and theirs. Procedural macros
/// run in the compiler and are not part of it.
fn linked(metadata: &Metadata) -> BTreeSet<&str> {
    let is_macro = |package: &&Package| {
        package.targets.iter().any(|target| target.kind.iter().any(|kind| kind == "proc-macro"))
    };
    let macros: BTreeSet<&str> =
        metadata.packages.iter().filter(is_macro).map(|package| &*package.id).collect();
    let nodes: BTreeMap<&str, &Node> =
        metadata.resolve.nodes.iter().map(|node| (&*node.id, node)).collect();
    let first = metadata.packages.iter().find(|package| package.name == "dth-fmu");
    let mut open: Vec<&str> = first.map(|package| &*package.id).into_iter().collect();
    let mut found = BTreeSet::new();
    while let Some(id) = open.pop() {
        if !macros.contains(id) && found.insert(id) {
            let deps = nodes.get(id).map(|node| &*node.deps).unwrap_or_default();
            let normal = deps.iter().filter(|d| d.dep_kinds.iter().any(|k| k.kind.is_none()));
            open.extend(normal.map(|dependency| &*dependency.pkg));
        }
    }
    found
}

fn license(root: &Path, package: &Package) -> Result<License, Failure> {
    let name = format!("{} {}", package.name, package.version);
    let folder = package.manifest_path.parent().unwrap_or(root);
    let mut files = Vec::new();
    for path in texts(folder)? {
        let file = path.file_name().map(|name| name.to_string_lossy()).unwrap_or_default();
        let place = format!("documentation/licenses/{}-{}/{file}", package.name, package.version);
        files.push(File::new(place, fs::read(&path).about(&path)?));
    }
    let terms = package.license.clone().unwrap_or_else(|| "see its texts".into());
    Ok(License { name, terms, files })
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
