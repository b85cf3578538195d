//! `cargo lab`: the laboratory, one page with the engine in it.
//!
//! The engine is the FMU's own library, compiled to WebAssembly: the page calls the same C
//! functions as any host, and takes names, units and start values from the same description.

use crate::licenses::{self, License};
use crate::{About, Failure, presets, tell};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::fs;
use std::path::Path;
use std::time::Instant;

/// Builds the engine and writes the page.
///
/// # Errors
/// Names what a person must install; or it does not build.
pub fn write(root: &Path, output: &Path) -> Result<(), Failure> {
    let begun = Instant::now();
    tell("Building", "the engine for browsers");
    let engine = engine(root)?;
    let page = page(&root.join("lab"), &engine, &terms(root)?)?;
    if let Some(folder) = output.parent() {
        fs::create_dir_all(folder).about(folder)?;
    }
    fs::write(output, &page).about(output)?;
    let shown = output.strip_prefix(root).unwrap_or(output).display().to_string();
    let seconds = begun.elapsed().as_secs_f64();
    tell("Wrote", &format!("{shown} ({} kB, {seconds:.1} s)", page.len() / 1000));
    Ok(())
}

#[cfg(unix)]
fn engine(root: &Path) -> Result<Vec<u8>, Failure> {
    crate::cross::Workshop::build_for_browser(root)
}

#[cfg(not(unix))]
fn engine(_: &Path) -> Result<Vec<u8>, Failure> {
    Err(Failure::Missing("the laboratory is built on Linux or macOS".into()))
}

/// The page with everything in it: it loads nothing.
fn page(folder: &Path, engine: &[u8], terms: &str) -> Result<String, Failure> {
    let read = |name: &str| {
        let path = folder.join(name);
        fs::read_to_string(&path).about(&path)
    };
    let mut page = String::new();
    for line in read("page.html")?.lines() {
        if let Some(name) = between(line, "<link rel=\"stylesheet\" href=\"", "\">") {
            page += &format!("<style>\n{}\n</style>", read(name)?);
        } else if let Some(name) = between(line, "<script src=\"", "\"></script>") {
            page += &format!("<script>\n{}\n</script>", read(name)?);
        } else {
            page += line;
        }
        page.push('\n');
    }
    let worker = read("engine.js")? + &read("worker.js")?;
    for (mark, text) in [
        ("@DESCRIPTION@", dth_hammer::MODEL_DESCRIPTION),
        ("@PRESETS@", &presets::all()?),
        ("@ENGINE@", &STANDARD.encode(engine)),
        ("@WORKER@", &worker),
        ("@LICENCES@", terms),
    ] {
        // It would end the element that the text stands in.
        let text = if mark == "@LICENCES@" { &text.replace("</", "< /") } else { text };
        if text.contains("</script") {
            let reason = format!("what stands for {mark} ends a script");
            return Err(Failure::Unfit { name: "the laboratory".into(), reason });
        }
        page = page.replace(mark, text);
    }
    Ok(page)
}

/// What stands in a line between its two ends.
fn between<'a>(line: &'a str, begin: &str, end: &str) -> Option<&'a str> {
    line.trim().strip_prefix(begin)?.strip_suffix(end)
}

/// The licences of all that is in the page, as text.
fn terms(root: &Path) -> Result<String, Failure> {
    Ok(parts(root)?.iter().map(text).collect())
}

/// The licences of all that is in the page.
///
/// # Errors
/// If a text cannot be read.
pub fn parts(root: &Path) -> Result<Vec<License>, Failure> {
    let plots = root.join("lab/vendor/LICENSE-uPlot.txt");
    let more = vec![licenses::foreign("uPlot", "MIT", &plots)?];
    licenses::collect(root, &["wasm32-unknown-unknown"], more)
}

fn text(license: &License) -> String {
    let mut text = format!("== {}: {}\n\n", license.name, license.terms);
    for file in &license.files {
        text += &String::from_utf8_lossy(&file.bytes);
        text += "\n\n";
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn made(engine: &[u8], terms: &str) -> Result<String, Failure> {
        page(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../lab"), engine, terms)
    }

    #[test]
    fn the_page_loads_nothing_and_keeps_no_mark() {
        let page = made(b"engine", "terms </script>").unwrap();
        for word in ["<script src", "<link", "@import", "url(http", "@DESCRIPTION@", "@ENGINE@"] {
            assert!(!page.contains(word), "{word}");
        }
        assert!(page.contains(&STANDARD.encode(b"engine")) && page.contains("terms < /script>"));
        assert_eq!(page.matches("<script").count(), page.matches("</script>").count());
    }
}
