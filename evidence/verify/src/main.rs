//! `cargo verify`: writes reports/verification.md.

use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use support::run::checkout;
use verify::laws::properties::{PROPERTIES, check};
use verify::report;
use verify::rows::{catalogue, measured};

#[derive(Parser)]
#[command(about = "Checks the engine against everything known, and writes reports/verification.md")]
struct Arguments {
    /// Only the page of other people's measurements
    #[arg(long)]
    measured: bool,
    /// Only the page of hammers of a catalogue
    #[arg(long)]
    catalogue: bool,
    /// Only the report's section on drawn scenes, from the results that `cargo compare --keep` stored
    #[arg(long)]
    compared: bool,
    /// Scenes drawn for each property
    #[arg(long, default_value_t = 1000)]
    cases: u32,
}

/// Why the report could not be made.
#[derive(Debug, thiserror::Error)]
enum Failure {
    #[error(transparent)]
    Engine(#[from] hammer::Error),
    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: std::io::Error },
    #[error(transparent)]
    Datasheet(#[from] hammer::datasheet::DatasheetError),
    #[error("the report has no such section: cargo verify makes it whole")]
    Section,
    #[error("{0} checks do not hold; the report says which")]
    Checks(usize),
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let root = checkout();
    let folder = root.join("reports/verification");
    match run(&root, &folder, &arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::FAILURE
        }
    }
}

fn run(root: &Path, folder: &Path, asked: &Arguments) -> Result<(), Failure> {
    if asked.measured {
        write(root.join("reports/measured.md"), &measured::page()?)
    } else if asked.catalogue {
        write(root.join("reports/catalogue.md"), &catalogue::page()?)
    } else if asked.compared {
        compared(&root.join("reports/verification.md"), folder)
    } else {
        write_report(root, folder, asked.cases)
    }
}

fn bar(length: u64) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {msg} {elapsed} (left {eta})");
    ProgressBar::new(length).with_style(style.expect("a valid template"))
}

fn write(path: PathBuf, text: &str) -> Result<(), Failure> {
    std::fs::write(&path, text).map_err(|source| Failure::File { path, source })
}

/// The section on the results that `cargo compare` stored.
fn account(folder: &Path) -> String {
    let mut text = String::new();
    let stored = |name: &str| std::fs::read_to_string(folder.join(name)).ok();
    let found = stored("compared.json").and_then(|text| serde_json::from_str(&text).ok());
    report::compared(&mut text, found);
    report::asked(&mut text, stored("asked.txt"));
    text
}

/// Replaces that section in the report.
fn compared(report: &Path, folder: &Path) -> Result<(), Failure> {
    let text = std::fs::read_to_string(report)
        .map_err(|source| Failure::File { path: report.into(), source })?;
    let section = account(folder);
    let heading: String = section.split_inclusive('\n').take(2).collect();
    let (before, rest) = text.split_once(&heading).ok_or(Failure::Section)?;
    let after = rest.find("\n## ").map_or("", |next| &rest[next..]);
    write(report.into(), &format!("{before}{section}{after}"))
}

fn write_report(root: &Path, folder: &Path, cases: u32) -> Result<(), Failure> {
    let count = report::SECTIONS.len() + PROPERTIES.len();
    let progress = bar(count as u64);
    let step = |what: &str| {
        progress.set_message(what.to_string());
        progress.inc(1);
    };
    let (mut body, mut checks, mut failed) = (String::new(), 0, 0);
    for section in &report::SECTIONS {
        step(section.0);
        let rows = section.2()?;
        checks += rows.len();
        failed += rows.iter().filter(|r| !r.holds()).count();
        report::rows(&mut body, section, &rows);
    }
    body += PROPERTIES_HEAD;
    for property in &PROPERTIES {
        step("properties");
        let outcome = check(property, cases);
        checks += 1;
        failed += usize::from(!outcome.failures.is_empty());
        report::property(&mut body, property, &outcome);
    }
    progress.finish_and_clear();
    body += &account(folder);
    let head = format!(
        "{HEAD}\n{} of {checks} checks hold.\n\n## Closed forms, benchmarks, cycles\n{}",
        checks - failed,
        report::ROWS
    );
    write(root.join("reports/verification.md"), &(head + &body + report::LIMITS))?;
    println!("{} of {checks} checks hold: reports/verification.md", checks - failed);
    if failed > 0 { Err(Failure::Checks(failed)) } else { Ok(()) }
}

const HEAD: &str = "# Verification: `cargo verify`\n\n\
    Every row is asserted by the test named with it. References \
    are none of this project's engine: closed forms, exact waves by characteristics \
    (`evidence/oracles/src/waves/`), a solution in double-double arithmetic (`evidence/oracles/`), a published manual, \
    two earlier solvers of this project. Error against cost of the time integration, beside general solvers, \
    is in [speed against error](speed-against-error.md).\n";
const PROPERTIES_HEAD: &str = "\n## Properties\n\n\
    `PROPTEST_CASES=5000 cargo test -p verify --test all properties::`\n\n\
    Scenes drawn over the domain, log-uniformly: modulus 1e9 to 1e12 Pa, lengths 0.01 to 10 m, \
    1 to 15 elements or rigid, half of the bodies of 1 to 8 sections, half of the meshes of \
    splines of degree 2 to 7, `KC` 1e7 to 1e14, `KR` 1e5 to 1e11, `gamma` - 1 from 1e-6 to \
    1e4, `CR` 0 or to 1e9, `WR` 0 or to 1e6, `beta` 0 or to 1e-4, loads of both signs. The \
    engine may refuse a scene, by name and where *Limits* says; how many it refused is counted.\n\n\
    | property | scenes | refused | outcome |\n|---|---|---|---|\n";
