//! Imports: no crate of the repository has a cycle of importing files, and the imports between the engine's folders
//! are those that `ARCHITECTURE.md` shows.

use hammer::variables::VARIABLES;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

type Arrows = BTreeMap<String, BTreeSet<String>>;

/// This crate's folder. It comes from the run: a compiled test may have been moved together with its checkout.
fn here() -> PathBuf {
    PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").expect("cargo runs the tests"))
}

fn source() -> PathBuf {
    here().join("src")
}

/// The Rust and Python files of a folder.
fn sources(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").path()) {
        if entry.is_dir() {
            sources(&entry, files);
        } else if entry.extension().is_some_and(|e| e == "rs" || e == "py") {
            files.push(entry);
        }
    }
}

/// The repository.
fn root() -> PathBuf {
    here().join("..")
}

/// Engine and faces.
const SHIPPED: [&str; 3] = ["hammer/src", "src", "python/native/src"];

/// The files of some folders, with their lines that are not comments.
fn lines(folders: &[&str]) -> Vec<(PathBuf, Vec<String>)> {
    let mut files = Vec::new();
    folders.iter().for_each(|folder| sources(&root().join(folder), &mut files));
    let read = |file: PathBuf| {
        let text = fs::read_to_string(&file).expect("a source file");
        let lines = text.lines().filter(|line| !line.trim_start().starts_with(['/', '#']));
        (file, lines.map(str::to_string).collect())
    };
    files.into_iter().map(read).collect()
}

/// The words of a line.
fn words(line: &str) -> Vec<&str> {
    let words = line.split(|c: char| !c.is_alphanumeric() && c != '_');
    words.filter(|word| !word.is_empty()).collect()
}

/// `modal::model` for `src/modal/model.rs`, `motion` for `src/motion/mod.rs`.
fn module(root: &Path, file: &Path) -> String {
    let inside = file.strip_prefix(root).expect("a source file").with_extension("");
    let mut parts: Vec<_> = inside.iter().map(|p| p.to_str().expect("a name in UTF-8")).collect();
    if parts.last() == Some(&"mod") {
        parts.pop();
    }
    parts.join("::")
}

/// The code of a file, without tests and comments.
fn code(text: &str) -> String {
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    lines.collect::<Vec<_>>().join("\n")
}

/// The paths at the start of a text: `a::b` of `a::b;`, and two of `a::{b::c, d}`.
fn imported(text: &str) -> Vec<String> {
    let end = text.find(|c: char| !c.is_alphanumeric() && !"_:".contains(c)).unwrap_or(text.len());
    let (head, rest) = text.split_at(end);
    if !rest.starts_with('{') || !(head.is_empty() || head.ends_with("::")) {
        return vec![head.to_string()];
    }
    let (mut paths, mut depth) = (Vec::new(), 0);
    for (at, c) in rest.char_indices() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        if depth == 0 {
            break;
        }
        if depth == 1 && "{,".contains(c) {
            let inner = imported(rest[at + 1..].trim_start());
            paths.extend(inner.into_iter().map(|path| format!("{head}{path}")));
        }
    }
    paths
}

/// The modules that a file names after `crate::` or `super::`, outside its tests and comments.
fn imports(text: &str, importer: &str, modules: &BTreeSet<String>) -> BTreeSet<String> {
    let code = code(text);
    let parent = importer.rsplit_once("::").map_or("", |(parent, _)| parent);
    let after = |key: &str, prefix: &str| -> Vec<String> {
        let paths = code.split(key).skip(1).flat_map(imported);
        paths.map(|path| format!("{prefix}{path}")).collect()
    };
    let named = [after("crate::", ""), after("super::", &format!("{parent}::"))].concat();
    let module_of = |path: String| {
        let words: Vec<&str> = path.split("::").filter(|word| !word.is_empty()).collect();
        (1..=words.len()).rev().map(|n| words[..n].join("::")).find(|m| modules.contains(m))
    };
    named.into_iter().filter_map(module_of).filter(|module| module != importer).collect()
}

/// Imports by module. A crate's root is left out, since it declares the modules and is `crate` to all of them.
fn arrows(root: &Path) -> Arrows {
    let mut files = Vec::new();
    sources(root, &mut files);
    let named = files.iter().map(|file| (module(root, file), file));
    let files: BTreeMap<_, _> =
        named.filter(|(name, _)| !["lib", "main"].contains(&name.as_str())).collect();
    let modules = files.keys().cloned().collect();
    let read = |(name, file): (&String, &&PathBuf)| {
        let text = fs::read_to_string(file).expect("a source file");
        (name.clone(), imports(&text, name, &modules))
    };
    files.iter().map(read).collect()
}

/// A cycle through `at`, if the imports from there lead back to a visited module.
fn circle(
    arrows: &Arrows,
    at: &str,
    path: &mut Vec<String>,
    done: &mut BTreeSet<String>,
) -> Option<String> {
    if let Some(start) = path.iter().position(|m| m == at) {
        return Some([&path[start..], &[at.to_string()]].concat().join(" -> "));
    }
    if !done.insert(at.to_string()) {
        return None;
    }
    path.push(at.to_string());
    let next_circle = arrows[at].iter().find_map(|next| circle(arrows, next, path, done));
    path.pop();
    next_circle
}

/// The roots of the crates; one crate has two.
const CRATES: [&str; 10] = [
    "hammer/src",
    "src",
    "python/native/src",
    "packaging/src",
    "support/src",
    "xtask/src",
    "evidence/oracles/src",
    "evidence/verify/src",
    "evidence/bench/src",
    "evidence/bench/src/report",
];

#[test]
fn no_file_imports_itself_in_a_circle() {
    let mut circles = Vec::new();
    for crate_root in CRATES {
        let arrows = arrows(&root().join(crate_root));
        assert!(!arrows.is_empty(), "{crate_root} has no modules");
        let mut done = BTreeSet::new();
        let of_crate = arrows.keys().filter_map(|m| circle(&arrows, m, &mut Vec::new(), &mut done));
        circles.extend(of_crate.map(|circle| format!("{crate_root}: {circle}")));
    }
    assert!(circles.is_empty(), "{}", circles.join("\n"));
}

#[test]
fn the_folders_arrows_are_those_that_the_architecture_draws() {
    let folder = |module: &str| module.split("::").next().unwrap_or_default().to_string();
    let mut actual: Arrows = BTreeMap::new();
    for (module, targets) in arrows(&source()) {
        let from = actual.entry(folder(&module)).or_default();
        from.extend(targets.iter().map(|t| folder(t)).filter(|t| *t != folder(&module)));
    }
    let page = fs::read_to_string(root().join("ARCHITECTURE.md")).expect("the page");
    let drawing = page.split("<!-- arrows of hammer/src -->").nth(1).expect("the drawing");
    let drawing = drawing.split("```").nth(1).expect("a block");
    let drawn: Arrows = drawing
        .lines()
        .filter_map(|line| line.split_once("->"))
        .map(|(from, to)| {
            (from.trim().to_string(), to.split_whitespace().map(str::to_string).collect())
        })
        .collect();
    assert_eq!(actual, drawn);
}

/// Rows of the tables of steps read ``| step | `file` `words` | why |``: the file contains these words exactly once.
#[test]
fn the_walks_name_words_that_their_files_have_once() {
    let root = root();
    let page = fs::read_to_string(root.join("ARCHITECTURE.md")).expect("the page");
    let walks = page.split("## Two walks").nth(1).expect("the walks");
    let walks = walks.split("\n## ").next().expect("their end");
    let mut steps = 0;
    for row in walks.lines().filter(|l| l.starts_with('|') && l.contains(".rs`")) {
        let quoted: Vec<&str> = row.split('`').collect();
        let at = quoted.iter().position(|q| q.ends_with(".rs")).expect("a file");
        let (file, words) = (quoted[at], quoted[at + 2]);
        let text = fs::read_to_string(root.join(file)).expect("a file of the walk");
        assert_eq!(text.matches(words).count(), 1, "{file}: {words}");
        steps += 1;
    }
    assert!(steps > 10, "{steps} steps");
}

/// Words in back quotes that contain a slash.
fn paths(page: &str) -> Vec<&str> {
    let plain = |c: char| c.is_alphanumeric() || "_-./{},".contains(c);
    // Text between fences is not prose.
    let prose = page.split("```").step_by(2);
    let quoted = prose.flat_map(|text| text.split('`').skip(1).step_by(2));
    quoted.filter(|word| word.contains('/') && word.chars().all(plain)).collect()
}

/// `a/{b,c}.rs` as `a/b.rs` and `a/c.rs`.
fn spelled(path: &str) -> Vec<String> {
    let Some((before, rest)) = path.split_once('{') else { return vec![path.to_string()] };
    let (choices, after) = rest.split_once('}').expect("a closed brace");
    choices.split(',').map(|choice| format!("{before}{choice}{after}")).collect()
}

#[test]
fn the_paths_that_contributing_and_architecture_name_are_there() {
    let root = root();
    // Paths that commands make, or that the FMI standard names.
    let made = ["dist/", "target/", "binaries/", "target"];
    for page in ["CONTRIBUTING.md", "ARCHITECTURE.md"] {
        let text = fs::read_to_string(root.join(page)).expect("the page");
        let named: Vec<String> = paths(&text).into_iter().flat_map(spelled).collect();
        assert!(named.len() > 10, "{page} names {} paths", named.len());
        let homes = ["", "hammer/src", "evidence/verify/src", "evidence/bench", "tests"];
        let there = |path: &str| homes.iter().any(|home| root.join(home).join(path).exists());
        let gone: Vec<&String> = named
            .iter()
            .filter(|path| !made.iter().any(|m| path.starts_with(m)) && !there(path))
            .collect();
        assert!(gone.is_empty(), "{page} names what is not there: {gone:?}");
    }
}

#[test]
fn no_line_of_the_laboratory_is_longer_than_120_columns() {
    let mut files = 0;
    for entry in fs::read_dir(root().join("lab")).expect("the laboratory") {
        let file = entry.expect("an entry").path();
        if file.extension().is_some_and(|kind| kind == "js" || kind == "css" || kind == "html") {
            files += 1;
            let text = fs::read_to_string(&file).expect("a file of the page");
            let long = text.lines().position(|line| line.chars().count() > 120);
            assert!(long.is_none(), "{}: after line {long:?}", file.display());
        }
    }
    assert!(files > 20, "{files} files");
}

/// Words that once had a private meaning in this project, and still tempt.
const HOUSE_WORDS: [&str; 13] = [
    "told",
    "seen",
    "shown",
    "kept",
    "owe",
    "owed",
    "doubt",
    "doubts",
    "laps",
    "spot",
    "keeper",
    "undecided",
    "waypoint",
];

/// Names after a keyword that declares, or before a lone `=`.
#[test]
fn no_name_is_a_house_word() {
    let files =
        lines(&["hammer", "src", "evidence", "python", "packaging", "tests", "examples", "guide"]);
    let declares = ["fn", "let", "mut", "struct", "enum", "mod", "type", "const", "def", "class"];
    let mut names = Vec::new();
    for (file, lines) in &files {
        for line in lines {
            let words = words(line);
            let declared = words.windows(2).filter(|w| declares.contains(&w[0])).map(|w| w[1]);
            let assigned = line.trim_start().split_once(" = ").map(|(name, _)| name);
            let house = declared.chain(assigned).filter(|word| HOUSE_WORDS.contains(word));
            names.extend(house.map(|word| format!("{}: {word}", file.display())));
        }
    }
    assert!(files.len() > 300 && names.is_empty(), "{} files: {names:#?}", files.len());
}

/// Otherwise the word occurs only as the attribute of a C function that keeps its name, or as the type of a host's
/// function, which cannot be called outside an unsafe block.
#[test]
fn unsafe_blocks_functions_and_implementations_are_in_one_file() {
    let (mut inside, mut outside) = (0, Vec::new());
    for (file, lines) in lines(&SHIPPED) {
        let of = |line: &&String| {
            let is_type =
                line.starts_with("pub type ") && line.contains(" = unsafe extern \"C\" fn(");
            words(line).contains(&"unsafe") && !is_type
        };
        let uses = lines.iter().filter(of);
        if file == root().join("src/abi.rs") {
            inside = uses.count();
        } else {
            outside.extend(uses.map(|line| format!("{}: {line}", file.display())));
        }
    }
    assert!(inside > 5 && outside.is_empty(), "{inside} there, elsewhere {outside:#?}");
}

/// Engine and faces never touch files or the network, whatever a host or a file contains.
#[test]
fn neither_engine_nor_faces_name_files_network_or_programs() {
    let (files, mut found) = (lines(&SHIPPED), Vec::new());
    let outer = ["fs", "net", "File", "Command", "TcpStream", "UdpSocket"];
    for (file, lines) in &files {
        let names = |line: &&String| words(line).iter().any(|word| outer.contains(word));
        let reaches = lines.iter().filter(|line| line.contains("::")).filter(names);
        found.extend(reaches.map(|line| format!("{}: {line}", file.display())));
    }
    assert!(files.len() > 100 && found.is_empty(), "{} files: {found:#?}", files.len());
}

/// The files of the table, whose rows are names.
const TABLE: [&str; 3] = [
    "hammer/src/quantities/table.rs",
    "hammer/src/quantities/inputs.rs",
    "hammer/src/variables.rs",
];

/// Files that name a variable a second time, with the reason.
const SECOND: [(&str, &str); 6] = [
    (
        "hammer/src/quantities/warnings.rs",
        "numbers in another unit show by how large some usually are",
    ),
    ("hammer/src/datasheet/quantity.rs", "what a datasheet says goes by the outputs it is held to"),
    ("hammer/src/datasheet/drilled.rs", "what a datasheet tells is read from means by their names"),
    ("hammer/src/means/averages.rs", "means over blows bear the names of what they average"),
    ("src/instance/snapshot.rs", "a state that was made under a higher limit of work is refused"),
    ("src/instance/values.rs", "reading `energy_residual` may log a warning"),
];

/// Each variable is named in one row of the table, and nowhere else in the engine and its faces, except in the files
/// above. `CONTRIBUTING.md` says what else a new variable touches.
#[test]
fn no_variable_is_named_beside_the_table() {
    let (root, mut files) = (root(), Vec::new());
    SHIPPED.iter().for_each(|folder| sources(&root.join(folder), &mut files));
    let texts: Vec<(String, String)> = files
        .iter()
        .map(|file| {
            let name = file.strip_prefix(&root).expect("a file of the project");
            let text = fs::read_to_string(file).expect("a source file");
            (name.to_string_lossy().replace('\\', "/"), code(&text))
        })
        .collect();
    let mut wrong = Vec::new();
    for variable in VARIABLES.iter() {
        let quoted = format!("\"{}\"", variable.name);
        let named = texts.iter().filter(|(_, text)| text.contains(&quoted));
        let beyond = named.map(|(file, _)| file.as_str()).filter(|file| !TABLE.contains(file));
        let second = |file: &&str| SECOND.iter().any(|(listed, _)| listed == file);
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

/// Files of the engine that name the tie of bit and casing or of rods, or the casing itself, with the reason.
const TIED: [(&str, &str); 16] = [
    ("quantities/sections.rs", "the bodies' names"),
    ("quantities/parameters.rs", "the numbers of ties and bodies"),
    ("quantities/drill.rs", "those of rods and of what joins them"),
    ("quantities/table.rs", "their rows"),
    ("quantities/inputs.rs", "what the feed acts on, in the row of the input"),
    ("quantities/validation.rs", "their limits"),
    ("quantities/warnings.rs", "what is out of proportion among them"),
    ("laws/mode.rs", "the ties, with their ends"),
    ("laws/tie.rs", "their laws"),
    ("machine/outputs.rs", "what their outputs read"),
    ("variables.rs", "the rows of their outputs"),
    ("variables/arrays.rs", "values along the casing, and the chuck's force at a blow"),
    ("presets/air.rs", "hammers with a casing"),
    ("datasheet/drilled.rs", "whether a feed holds the casing"),
    ("datasheet/answer.rs", "what is printed, of a casing that is held"),
    ("datasheet/limits.rs", "what is told of a casing that is not held"),
];

/// Other code uses bodies, groups and ties of any kind, so that another tie touches no more files than
/// `ARCHITECTURE.md` says.
#[test]
fn ties_are_named_where_their_laws_and_numbers_are_alone() {
    let mut files = Vec::new();
    sources(&source(), &mut files);
    let names_one = |file: &&PathBuf| {
        let text = code(&fs::read_to_string(file).expect("a source file")).to_lowercase();
        // `adjoint` contains `joint`.
        let text = text.replace("adjoint", "");
        ["casing", "chuck", "joint"].iter().any(|word| text.contains(word))
    };
    let name = |file: &PathBuf| {
        let inside = file.strip_prefix(source()).expect("a source file");
        inside.to_string_lossy().replace('\\', "/")
    };
    let actual: BTreeSet<String> = files.iter().filter(names_one).map(name).collect();
    let listed = TIED.iter().map(|(file, _)| (*file).to_string()).collect();
    assert_eq!(actual, listed);
}

/// A test file that no program includes would never run.
#[test]
fn every_file_of_tests_is_in_a_program() {
    let root = root();
    let mut count = 0;
    for home in ["", "hammer", "evidence/verify"] {
        let read = |file: &str| fs::read_to_string(root.join(home).join(file)).expect("a file");
        let (all, manifest) = (read("tests/all.rs"), read("Cargo.toml"));
        let folder = fs::read_dir(root.join(home).join("tests")).expect("a folder");
        let files = folder.map(|entry| entry.expect("an entry").path());
        for file in files.filter(|file| file.extension().is_some_and(|end| end == "rs")) {
            let name = file.file_stem().expect("a name").to_string_lossy().into_owned();
            let named = all.contains(&format!("mod {name};\n"))
                || manifest.contains(&format!("[[test]]\nname = \"{name}\"\n"));
            assert!(named, "{} is in no program of tests", file.display());
            count += 1;
        }
    }
    assert!(count > 40, "{count} files");
}
