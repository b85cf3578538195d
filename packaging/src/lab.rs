//! `cargo lab`: the laboratory, one page that contains the engine.
//!
//! The engine is the FMU's own library, compiled to WebAssembly. The page calls the same C functions as any host, and
//! takes names, units and start values from the same description.

use crate::licenses::{self, License};
use crate::{About, Failure, presets, tell};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use hammer::datasheet::{Entry, Quantity};
use hammer::presets::ROCKS;
use sha2::{Digest, Sha256};
use std::ffi::OsStr;
use std::fs;
use std::path::Path;
use std::time::Instant;

/// The files of the workers, in order.
const WORKER: [&str; 4] = ["engine.js", "worker.js", "means.js", "exploring.js"];

/// Builds the engine and writes the page.
pub fn write(root: &Path, output: &Path) -> Result<(), Failure> {
    let begun = Instant::now();
    tell("Building", "the engine for browsers (some minutes the first time, then seconds)");
    let engine = engine(root)?;
    let page = page(&root.join("lab"), &engine, &terms(root)?)?;
    if let Some(folder) = output.parent() {
        fs::create_dir_all(folder).about(folder)?;
    }
    fs::write(output, &page).about(output)?;
    let path = output.strip_prefix(root).unwrap_or(output).display().to_string();
    let seconds = begun.elapsed().as_secs_f64();
    tell("Wrote", &format!("{path} ({} kB, {seconds:.1} s)", page.len() / 1000));
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

/// The complete page, which loads nothing else.
fn page(folder: &Path, engine: &[u8], terms: &str) -> Result<String, Failure> {
    let read = |name: &str| {
        let path = folder.join(name);
        fs::read_to_string(&path).about(&path)
    };
    let (mut page, mut styles, mut scripts) = (String::new(), String::new(), String::new());
    for line in read("page.html")?.lines() {
        if let Some(name) = between(line, "<link rel=\"stylesheet\" href=\"", "\">") {
            page += &inline("style", &read(name)?, &mut styles);
        } else if let Some(name) = between(line, "<script src=\"", "\"></script>") {
            page += &inline("script", &read(name)?, &mut scripts);
        } else {
            page += line;
        }
        page.push('\n');
    }
    let worker = WORKER.iter().map(|name| read(name)).collect::<Result<String, _>>()?;
    let policy = format!(
        "default-src 'none'; base-uri 'none'; form-action 'none'; worker-src blob:; \
         script-src 'wasm-unsafe-eval'{scripts}; style-src{styles}"
    );
    for (mark, text) in [
        ("@POLICY@", policy.as_str()),
        ("@DESCRIPTION@", dth_hammer::MODEL_DESCRIPTION),
        ("@PRESETS@", &presets::all()?),
        ("@CHOICES@", &choices()?),
        ("@TEXTS@", &texts(&folder.join("text"))?),
        ("@ENGINE@", &STANDARD.encode(engine)),
        ("@WORKER@", &worker),
        ("@LICENCES@", terms),
    ] {
        // `</` would end the element that contains the text.
        let text = if mark == "@LICENCES@" { &text.replace("</", "< /") } else { text };
        if text.contains("</script") {
            let reason = format!("what stands for {mark} ends a script");
            return Err(Failure::Unfit { name: "the laboratory".into(), reason });
        }
        page = page.replace(mark, text);
    }
    Ok(page)
}

/// The words of the page in each language, as JSON; each language has a file.
fn texts(folder: &Path) -> Result<String, Failure> {
    let mut languages = serde_json::Map::new();
    for entry in fs::read_dir(folder).about(folder)? {
        let path = entry.about(folder)?.path();
        let Some(name) = path.file_stem().and_then(OsStr::to_str) else { continue };
        let text = fs::read_to_string(&path).about(&path)?;
        languages.insert(name.to_owned(), serde_json::from_str(&text)?);
    }
    Ok(serde_json::to_string(&languages)?)
}

/// What a datasheet may give, as JSON: numbers, and the rock by name.
fn choices() -> Result<String, Failure> {
    let rows = Quantity::all().map(|quantity| {
        let Entry { name, meaning, field: (unit, factor), .. } = quantity.entry();
        serde_json::json!({ "name": name, "meaning": meaning, "field_unit": unit, "factor": factor })
    });
    let rocks: Vec<_> = ROCKS.iter().map(|rock| rock.name).collect();
    let meaning = "A name, a class as R5, or a strength as 180 MPa; if empty, the scene's rock";
    let rock = serde_json::json!({ "name": "rock", "meaning": meaning, "words": rocks });
    Ok(serde_json::to_string(&rows.chain([rock]).collect::<Vec<_>>())?)
}

/// An element with its text, whose hash is added to those that the page's policy permits.
fn inline(element: &str, text: &str, hashes: &mut String) -> String {
    let text = format!("\n{text}\n");
    *hashes += &format!(" 'sha256-{}'", STANDARD.encode(Sha256::digest(&text)));
    format!("<{element}>{text}</{element}>")
}

/// The part of a line between two texts.
fn between<'a>(line: &'a str, begin: &str, end: &str) -> Option<&'a str> {
    line.trim().strip_prefix(begin)?.strip_suffix(end)
}

/// The licences of everything in the page, as text.
fn terms(root: &Path) -> Result<String, Failure> {
    Ok(licenses::text(&parts(root)?))
}

/// The licences of everything in the page.
pub fn parts(root: &Path) -> Result<Vec<License>, Failure> {
    let plots = root.join("lab/vendor/LICENSE-uPlot.txt");
    let more = vec![licenses::foreign("uPlot", "MIT", &plots)?];
    licenses::collect(root, &licenses::FMU, &["wasm32-unknown-unknown"], more)
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
        for word in
            ["<script src", "<link", "@import", "url(http", "style=", "@POLICY@", "@ENGINE@"]
        {
            assert!(!page.contains(word), "{word}");
        }
        assert!(page.contains(&STANDARD.encode(b"engine")) && page.contains("terms < /script>"));
        assert_eq!(page.matches("<script").count(), page.matches("</script>").count());
    }
}
