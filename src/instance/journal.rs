//! Log lines, stored until the host's logger can be called while the instance is not locked.

use crate::category::{Category, LOG_ALL};
use crate::error::CallError;
use std::ffi::CString;

/// A finished log line.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Its subject.
    pub category: Category,
    /// Text without a line break at its end.
    pub text: String,
}

impl Line {
    /// Category and text as C strings. In FMI 2.0 the text is a `format`, and some hosts pass no arguments, so `%` is
    /// doubled, and so is `#`, which begins a variable there.
    pub fn to_c(&self, format: bool) -> [CString; 2] {
        let mut text = self.text.replace('\0', " ");
        if format {
            text = text.replace('#', "##").replace('%', "%%");
        }
        [self.category.name(), &text].map(|part| CString::new(part).unwrap_or_default())
    }
}

/// The selected categories, and the lines not yet written.
#[derive(Debug)]
pub struct Journal {
    wanted: [bool; Category::ALL.len()],
    lines: Vec<Line>,
}

impl Journal {
    /// A log that is on begins with errors and warnings, and with the other categories if `debug`.
    pub fn new(debug: bool, on: bool) -> Self {
        Self { wanted: Category::ALL.map(|c| debug || on && !c.is_debug()), lines: Vec::new() }
    }

    /// True if any category is selected.
    pub fn wants(&self, category: Category) -> bool {
        self.wanted[category as usize]
    }

    /// True if a debug category is selected.
    pub fn wants_debug(&self) -> bool {
        self.wants(Category::Events) || self.wants(Category::Modes)
    }

    /// Stores a line if its category is selected.
    pub fn write(&mut self, category: Category, text: impl FnOnce() -> String) {
        if self.wants(category) {
            self.lines.push(Line { category, text: text() });
        }
    }

    /// Takes all lines.
    pub fn take(&mut self) -> Vec<Line> {
        std::mem::take(&mut self.lines)
    }

    /// Switches the named categories, or all without names. A host that wants only errors names the
    /// debug categories to switch off, or never switches logging on.
    ///
    /// # Errors
    ///
    /// A name that is no category; nothing is switched then.
    pub fn switch(&mut self, on: bool, names: &[String]) -> Result<(), CallError> {
        let known =
            |name: &String| name == LOG_ALL || Category::ALL.iter().any(|c| c.name() == name);
        if let Some(name) = names.iter().find(|name| !known(name)) {
            return Err(CallError::Argument(format!("there is no log category {name:?}")));
        }
        for category in Category::ALL {
            let named = names.iter().any(|name| name == LOG_ALL || name == category.name());
            if named || names.is_empty() {
                self.wanted[category as usize] = on;
            } else if on && category.is_debug() {
                // Naming some debug categories selects only those.
                self.wanted[category as usize] = false;
            }
        }
        Ok(())
    }
}
