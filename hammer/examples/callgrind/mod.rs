//! Counts the instructions of an example that is run with the word `count`.

use std::process::Command;

/// Instructions of this program with these arguments, by callgrind (whose processor has no AVX-512).
pub fn instructions(count: u64, more: &[String]) -> Result<u64, Box<dyn std::error::Error>> {
    let mut command = Command::new("valgrind");
    command.args(["--tool=callgrind", "--callgrind-out-file=/dev/null"]);
    command.arg(std::env::current_exe()?).arg(count.to_string()).args(more);
    let output = command.output().map_err(|error| format!("valgrind: {error}"))?;
    let text = String::from_utf8_lossy(&output.stderr);
    let count = text.lines().find_map(|line| line.split("Collected :").nth(1));
    Ok(count.ok_or("valgrind gave no count")?.trim().parse()?)
}
