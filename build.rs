//! Writes the model description from the variable table and the engine's own defaults.

#![allow(dead_code, reason = "the shared tables also hold what only the library reads")]

#[path = "src/blows.rs"]
mod blows;
#[path = "src/capabilities.rs"]
mod capabilities;
#[path = "src/category.rs"]
mod category;
#[path = "src/description.rs"]
mod description;
#[path = "src/description3.rs"]
mod description3;
#[path = "src/events.rs"]
mod events;
#[path = "src/variant.rs"]
mod variant;
#[path = "src/waves.rs"]
mod waves;

use std::error::Error;
use std::path::PathBuf;
use std::{env, fs};

const TEMPLATE: &str = "modelDescription.xml.in";

fn main() -> Result<(), Box<dyn Error>> {
    for name in [
        "blows",
        "capabilities",
        "category",
        "description",
        "description3",
        "events",
        "waves",
        "variant",
    ] {
        println!("cargo::rerun-if-changed=src/{name}.rs");
    }
    println!("cargo::rerun-if-changed={TEMPLATE}");
    println!("cargo::rerun-if-changed=build.rs");

    let [version, author, license] =
        ["CARGO_PKG_VERSION", "CARGO_PKG_AUTHORS", "CARGO_PKG_LICENSE"].map(env::var);
    let more = [("@VERSION@", &*version?), ("@AUTHOR@", &*author?), ("@LICENSE@", &*license?)];
    let text = description::describe(&fs::read_to_string(TEMPLATE)?, &more)?;
    let guid = text.split("guid=\"").nth(1).and_then(|rest| rest.split('"').next());
    let guid = guid.ok_or("the template has no guid")?;
    println!("cargo::rustc-env=DTH_GUID={guid}");
    let (three, token) = description3::describe(&text)?;
    println!("cargo::rustc-env=DTH_TOKEN={token}");
    let folder = PathBuf::from(env::var("OUT_DIR")?);
    fs::write(folder.join("modelDescription.xml"), text)?;
    fs::write(folder.join("modelDescription3.xml"), three)?;
    Ok(())
}
