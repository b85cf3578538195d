//! The .fmu: a zip whose bytes depend only on its content.

use crate::{About, Failure};
use std::fs;
use std::io::Write;
use std::path::Path;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// A file of the archive.
pub struct File {
    /// Path in the archive, with `/`.
    pub path: String,
    /// Content.
    pub bytes: Vec<u8>,
}

impl File {
    /// A file of the archive.
    pub fn new(path: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Self {
        Self { path: path.into(), bytes: bytes.into() }
    }
}

/// Writes the archive and returns its size in bytes.
pub fn write(output: &Path, mut files: Vec<File>) -> Result<usize, Failure> {
    files.sort_by(|a, b| a.path.cmp(&b.path));
    // The oldest time of a zip: with the time of packaging, every archive would differ.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    let mut writer = ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for file in &files {
        let executable = file.path.starts_with("binaries/");
        // Hosts unpack the library for every simulation, which takes half the time if it is not compressed; a wheel
        // compresses it anyway.
        let library = options.unix_permissions(0o755).compression_method(CompressionMethod::Stored);
        let options = if executable { library } else { options };
        writer.start_file(&file.path, options)?;
        writer.write_all(&file.bytes).about(output)?;
    }
    let bytes = writer.finish()?.into_inner();
    if let Some(folder) = output.parent() {
        fs::create_dir_all(folder).about(folder)?;
    }
    // A host may have the old archive open, so the file is replaced as a whole.
    let partial = output.with_extension("fmu.partial");
    fs::write(&partial, &bytes).about(&partial)?;
    fs::rename(&partial, output).about(output)?;
    Ok(bytes.len())
}
