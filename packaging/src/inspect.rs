//! Reads a finished shared library: what it exports and what it needs.

use crate::Failure;
use dth_hammer::symbols;
use object::read::elf::{ElfFile64, Sym};
use object::{BinaryFormat, Endianness, Object, ObjectSymbol};
use std::collections::BTreeSet;

/// Functions of the C library whose last bits differ between machines, and which must not be used.
const ELEMENTARY: [&str; 12] = [
    "sin", "cos", "tan", "sincos", "exp", "exp2", "expm1", "log", "log2", "pow", "hypot", "_hypot",
];

/// Libraries of every 64-bit Windows since Windows 10; the last is a prefix of further system libraries.
const WINDOWS: [&str; 7] = [
    "kernel32.dll",
    "ntdll.dll",
    "msvcrt.dll",
    "userenv.dll",
    "ws2_32.dll",
    "bcryptprimitives.dll",
    "api-ms-win-core-",
];

/// Libraries of every Linux with glibc; the last is a prefix of the loader's name.
const LINUX: [&str; 6] =
    ["libc.so.6", "libm.so.6", "libpthread.so.0", "libdl.so.2", "libgcc_s.so.1", "ld-linux-"];

/// A version of glibc.
pub type Version = (u32, u32);

/// Checks what every library must fulfil, and finds the glibc that it needs.
pub fn check(name: &str, bytes: &[u8]) -> Result<Option<Version>, Failure> {
    let unfit = |reason: String| Failure::Unfit { name: name.into(), reason };
    let file = object::File::parse(bytes)?;
    let (offered, allowed) = match file.format() {
        BinaryFormat::Elf => (elf_exports(&file), &LINUX[..]),
        BinaryFormat::Pe => (pe_exports(&file)?, &WINDOWS[..]),
        _ => return Ok(None),
    };
    if let Some(name) = offered.symmetric_difference(&symbols()).next() {
        let what = if offered.contains(name) { "exports" } else { "does not export" };
        return Err(unfit(format!("it {what} {name}")));
    }
    for import in file.imports()? {
        let name = String::from_utf8_lossy(import.name());
        if ELEMENTARY.contains(&&*name) {
            return Err(unfit(format!("it takes {name} from the C library")));
        }
        let library = String::from_utf8_lossy(import.library()).to_lowercase();
        if file.format() == BinaryFormat::Pe && !allowed.iter().any(|a| library.starts_with(a)) {
            return Err(unfit(format!("it needs {name} of {library}, which Windows has not")));
        }
    }
    match file.format() {
        BinaryFormat::Elf => glibc(bytes, allowed).map(|found| found.map(|f| f.0)).map_err(unfit),
        _ => Ok(None),
    }
}

/// Fails if a Linux library needs a glibc newer than this.
pub fn check_glibc(name: &str, bytes: &[u8], newest: Version) -> Result<(), Failure> {
    let unfit = |reason: String| Failure::Unfit { name: name.into(), reason };
    match glibc(bytes, &LINUX).map_err(unfit)? {
        Some((found, symbol)) if found > newest => {
            let [(a, b), (c, d)] = [found, newest];
            Err(unfit(format!("its {symbol} needs glibc {a}.{b}, and {c}.{d} must do")))
        }
        _ => Ok(()),
    }
}

fn elf_exports(file: &object::File) -> BTreeSet<String> {
    let defined = file.dynamic_symbols().filter(|symbol| symbol.is_definition());
    defined.filter_map(|symbol| symbol.name().ok().map(str::to_owned)).collect()
}

fn pe_exports(file: &object::File) -> Result<BTreeSet<String>, Failure> {
    let name = |export: &object::Export| String::from_utf8_lossy(export.name()).into_owned();
    Ok(file.exports()?.iter().map(name).collect())
}

/// The newest glibc version of a symbol, and that symbol.
fn glibc(bytes: &[u8], allowed: &[&str]) -> Result<Option<(Version, String)>, String> {
    let found = versioned(bytes).map_err(|error| error.to_string())?;
    let mut newest = None;
    for (symbol, version, library) in found {
        if !allowed.iter().any(|name| library.starts_with(name)) {
            return Err(format!("its {symbol} needs {library}, which not every Linux has"));
        }
        newest = newest.max(version_of(&version).map(|version| (version, symbol)));
    }
    Ok(newest)
}

/// Symbols with a required version: name, version, library.
fn versioned(bytes: &[u8]) -> object::Result<Vec<(String, String, String)>> {
    let file = ElfFile64::<Endianness>::parse(bytes)?;
    let (endian, sections) = (file.endian(), file.elf_section_table());
    let Some(versions) = sections.versions(endian, bytes)? else { return Ok(Vec::new()) };
    let symbols = file.elf_dynamic_symbol_table();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let mut found = Vec::new();
    for (index, symbol) in symbols.enumerate().filter(|(_, s)| s.is_undefined(endian)) {
        let place = versions.version_index(endian, index);
        if let Some(version) = versions.version(place)? {
            let name = text(symbols.symbol_name(endian, symbol)?);
            found.push((name, text(version.name()), text(version.file().unwrap_or_default())));
        }
    }
    Ok(found)
}

/// `GLIBC_2.17` as numbers; none for other names such as `GCC_3.0`.
fn version_of(name: &str) -> Option<Version> {
    let mut parts = name.strip_prefix("GLIBC_")?.split('.').map(str::parse);
    Some((parts.next()?.ok()?, parts.next()?.ok()?))
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    /// This test's own program, which is not an FMU.
    fn program() -> Vec<u8> {
        std::fs::read(std::env::current_exe().unwrap()).unwrap()
    }

    #[test]
    fn what_is_no_fmu_is_refused_by_the_name_of_what_it_lacks() {
        let error = check("binaries/x", &program()).unwrap_err().to_string();
        let begin = "binaries/x is not fit to be shipped: it does not export fmi2";
        assert!(error.starts_with(begin), "{error}");
    }

    #[test]
    fn a_symbol_of_too_new_a_glibc_is_named() {
        let error = check_glibc("x", &program(), (1, 0)).unwrap_err().to_string();
        assert!(error.contains("needs glibc 2.") && error.ends_with("1.0 must do"), "{error}");
        check_glibc("x", &program(), (99, 0)).unwrap();
    }

    #[test]
    fn versions_are_compared_as_numbers() {
        assert!(version_of("GLIBC_2.2.5") < version_of("GLIBC_2.17"));
        assert_eq!(version_of("GCC_3.0"), None);
    }
}
