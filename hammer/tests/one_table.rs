//! A variable is named in one row of the table; the engine and its faces name none of them again,
//! but for what is listed here. `CONTRIBUTING.md` says what else a new one touches.

use hammer::variables::VARIABLES;
use std::fs;
use std::path::{Path, PathBuf};

/// The table, whose rows are all names.
const TABLE: [&str; 3] = [
    "hammer/src/quantities/table.rs",
    "hammer/src/quantities/inputs.rs",
    "hammer/src/variables.rs",
];

/// Files that name a variable for a second time, and why.
const SECOND: [(&str, &str); 7] = [
    ("hammer/src/families.rs", "the figures of each blow, by the outputs that have the last one's"),
    ("hammer/src/datasheet/quantity.rs", "what a datasheet says goes by the outputs it is held to"),
    ("hammer/src/periodic/averages.rs", "means over blows bear the names of what they average"),
    ("python/native/src/cycles.rs", "so do the numbers of a cycle"),
    ("src/events.rs", "`rop_mean` changes at blows but is no figure of one"),
    ("src/variant.rs", "a description of a certain mesh refuses rigid bodies by `fidelity`"),
    ("src/instance/values.rs", "reading `energy_residual` may log a warning"),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").path()) {
        if entry.is_dir() {
            sources(&entry, found);
        } else if entry.extension().is_some_and(|e| e == "rs") {
            found.push(entry);
        }
    }
}

/// What a file says in code, without comments and tests.
fn code(file: &Path) -> String {
    let text = fs::read_to_string(file).expect("a source file");
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn no_variable_is_named_beside_the_table() {
    let mut files = Vec::new();
    for folder in ["hammer/src", "src", "python/native/src"] {
        sources(&root().join(folder), &mut files);
    }
    let texts: Vec<(String, String)> = files
        .iter()
        .map(|file| {
            let name = file.strip_prefix(root()).expect("a file of the project");
            (name.to_string_lossy().replace('\\', "/"), code(file))
        })
        .collect();
    let mut wrong = Vec::new();
    for variable in VARIABLES.iter() {
        let quoted = format!("\"{}\"", variable.name);
        let named = texts.iter().filter(|(_, text)| text.contains(&quoted));
        let beyond = named.map(|(file, _)| file.as_str()).filter(|file| !TABLE.contains(file));
        let second = |file: &&str| SECOND.iter().any(|(known, _)| known == file);
        let surplus: Vec<&str> = beyond.filter(|file| !second(file)).collect();
        if !surplus.is_empty() {
            wrong.push((variable.name, surplus));
        }
        let rows = TABLE.iter().map(|file| {
            let text = texts.iter().find(|(name, _)| name == file);
            text.expect("the table's file").1.matches(&quoted).count()
        });
        // Names of sections are made by a macro.
        assert!(rows.sum::<usize>() <= 1, "{} has one row", variable.name);
    }
    assert!(wrong.is_empty(), "named again: {wrong:#?}");
    let listed = texts.iter().filter(|(name, text)| {
        SECOND.iter().any(|(file, _)| file == name)
            && VARIABLES.iter().any(|v| text.contains(&format!("\"{}\"", v.name)))
    });
    assert_eq!(listed.count(), SECOND.len(), "a file in the list names no variable any more");
}
