//! `cargo ship`: an .fmu of each standard for each platform, and one for all platforms.
//!
//! On Linux on x86-64 these are for Linux and Windows, on macOS for macOS. `release.py` makes the wheels, the bill of
//! materials and the hashes from them.

use crate::binary::Binary;
use crate::cross::{self, AARCH64, LINUX, MACOS, WINDOWS, Workshop};
use crate::licenses::{self, License};
use crate::reference::Reference;
use crate::{About, Failure, Standard, archive, lab, tell};
use dth_hammer::MODEL_IDENTIFIER;
use serde::Serialize;
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;
use std::time::Instant;
use support::run::target;
use zip::ZipArchive;

/// Name of macOS in file names; one library has the code of both processors.
const OF_MACOS: &str = "macos-universal2";

/// Components of an .fmu, for the bill of materials.
#[derive(Serialize)]
struct Contents {
    file: String,
    parts: Vec<License>,
}

impl Contents {
    fn of(file: &str, licenses: &[License]) -> Self {
        Self { file: file.into(), parts: licenses.to_vec() }
    }

    /// Contents of the archives of both standards.
    fn of_both(file: &str, licenses: &[License]) -> [Self; 2] {
        let three = crate::of_three(Path::new(file));
        [Self::of(file, licenses), Self::of(&three.to_string_lossy(), licenses)]
    }
}

/// Writes all archives that this machine can build.
pub fn write(root: &Path, folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder).about(folder)?;
    licenses::note_wheel(root)?;
    let made = if cfg!(target_os = "macos") { macos(root, folder)? } else { others(root, folder)? };
    let list = target(root).join("contents.json");
    fs::write(&list, serde_json::to_string_pretty(&made)?).about(&list)
}

/// File name of the laboratory.
const LABORATORY: &str = "dth-hammer-laboratory.html";

fn macos(root: &Path, folder: &Path) -> Result<Vec<Contents>, Failure> {
    let begun = Instant::now();
    tell("Building", "for macOS");
    let library = cross::build_for_macos(root)?;
    let licenses = licenses::collect(root, &licenses::FMU, &MACOS, Vec::new())?;
    let name = format!("{MODEL_IDENTIFIER}-{OF_MACOS}.fmu");
    crate::write_both(&folder.join(&name), &[library], &licenses, begun)?;
    Ok(Contents::of_both(&name, &licenses).into())
}

fn others(root: &Path, folder: &Path) -> Result<Vec<Contents>, Failure> {
    let begun = Instant::now();
    let workshop = Workshop::open(root)?;
    let [mut all, mut apart] = [Vec::new(), Vec::new()];
    let (mut made, mut parts) = (Vec::new(), Vec::new());
    for (platform, label) in
        [(LINUX, "linux-x86_64"), (WINDOWS, "windows-x86_64"), (AARCH64, "linux-aarch64")]
    {
        tell("Building", &format!("for {}", platform.triple));
        let libraries = [workshop.build(&platform)?];
        let name = format!("{MODEL_IDENTIFIER}-{label}.fmu");
        // FMI 2.0 has no place for it beside the other Linux.
        let joins = platform.triple != AARCH64.triple;
        let licenses = workshop.licenses(&[platform])?;
        made.extend(Contents::of_both(&name, &licenses));
        crate::write_both(&folder.join(&name), &libraries, &licenses, begun)?;
        (if joins { &mut all } else { &mut apart }).extend(libraries);
        parts.extend(licenses);
    }
    let apple = folder.join(format!("{MODEL_IDENTIFIER}-{OF_MACOS}.fmu"));
    if apple.is_file() {
        all.push(library_of(&apple)?);
        let licenses = licenses::collect(root, &licenses::FMU, &MACOS, Vec::new())?;
        made.extend(Contents::of_both(&format!("{MODEL_IDENTIFIER}-{OF_MACOS}.fmu"), &licenses));
        parts.extend(licenses);
    } else {
        tell("Skipped", &format!("macOS: no {}, which only macOS can build", apple.display()));
    }
    parts.sort_by(|a, b| a.name.cmp(&b.name));
    parts.dedup_by(|a, b| a.name == b.name);
    let name = format!("{MODEL_IDENTIFIER}.fmu");
    let output = folder.join(&name);
    crate::write(&output, Standard::Two, &all, &parts, begun)?;
    all.extend(apart);
    crate::write(&crate::of_three(&output), Standard::Three, &all, &parts, begun)?;
    made.extend(Contents::of_both(&name, &parts));
    made.push(Contents::of(LABORATORY, &lab::parts(root)?));
    cross_check(folder)?;
    Ok(made)
}

/// Writes what the FMI cross-check asks of an exporting tool, one archive to unpack in its repository.
fn cross_check(folder: &Path) -> Result<(), Failure> {
    let reference = Reference::new()?;
    let mut files = Vec::new();
    for (label, [two, three]) in [
        ("linux-x86_64", ["linux64", "x86_64-linux"]),
        ("windows-x86_64", ["win64", "x86_64-windows"]),
    ] {
        let path = folder.join(format!("{MODEL_IDENTIFIER}-{label}.fmu"));
        for (standard, platform, path) in
            [(Standard::Two, two, path.clone()), (Standard::Three, three, crate::of_three(&path))]
        {
            let fmu = fs::read(&path).about(&path)?;
            files.extend(reference.of_cross_check(standard, platform, fmu));
        }
    }
    let output = folder.join(format!("{MODEL_IDENTIFIER}-fmi-cross-check.zip"));
    let size = archive::write(&output, files)?;
    tell("Packaged", &format!("{} ({} kB)", output.display(), size / 1000));
    Ok(())
}

/// The library in an .fmu that macOS has built.
fn library_of(path: &Path) -> Result<Binary, Failure> {
    let mut archive = ZipArchive::new(File::open(path).about(path)?)?;
    let mut bytes = Vec::new();
    let place = cross::macos_binary(Vec::new()).place;
    archive.by_name(&place)?.read_to_end(&mut bytes).about(path)?;
    Ok(cross::macos_binary(bytes))
}
