//! Log lines. They are stored until the host's logger can be called, which is not allowed while the instance is locked.

use crate::category::{Category, LOG_ALL};
use crate::error::CallError;
use std::ffi::CString;

/// A finished log line.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// The line's category.
    pub category: Category,
    /// The line's text, without a line break at its end.
    pub text: String,
}

impl Line {
    /// Category and text as C strings. In FMI 2.0 the text is a `format` string, and some hosts pass no arguments for
    /// it.
    /// Therefore `%` is doubled, and so is `#`, which begins a variable in FMI 2.0.
    pub fn to_c(&self, format: bool) -> [CString; 2] {
        let mut text = self.text.replace('\0', " ");
        if format {
            text = text.replace('#', "##").replace('%', "%%");
        }
        [self.category.name(), &text].map(|part| CString::new(part).unwrap_or_default())
    }
}

/// The selected categories, and the lines that are not written yet.
#[derive(Debug)]
pub struct Journal {
    selected: [bool; Category::ALL.len()],
    lines: Vec<Line>,
}

impl Journal {
    /// A journal in which errors and warnings are selected if it is `on`, and all categories if `debug`.
    pub fn new(debug: bool, on: bool) -> Self {
        Self { selected: Category::ALL.map(|c| debug || on && !c.is_debug()), lines: Vec::new() }
    }

    /// True if this category is selected.
    pub fn wants(&self, category: Category) -> bool {
        self.selected[category as usize]
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

    /// Takes all lines out of the journal.
    pub fn take(&mut self) -> Vec<Line> {
        std::mem::take(&mut self.lines)
    }

    /// Switches the named categories on or off; without names, all of them. A host that needs only errors and warnings
    /// switches the debug categories off by their names, or never switches logging on.
    ///
    /// # Errors
    ///
    /// A name is not that of a category. Nothing is then switched.
    pub fn switch(&mut self, on: bool, names: &[String]) -> Result<(), CallError> {
        let known =
            |name: &String| name == LOG_ALL || Category::ALL.iter().any(|c| c.name() == name);
        if let Some(name) = names.iter().find(|name| !known(name)) {
            return Err(CallError::Argument(format!("there is no log category {name:?}")));
        }
        for category in Category::ALL {
            let named = names.iter().any(|name| name == LOG_ALL || name == category.name());
            if named || names.is_empty() {
                self.selected[category as usize] = on;
            } else if on && category.is_debug() {
                // If some debug categories are switched on by name, the other debug categories are switched off.
                self.selected[category as usize] = false;
            }
        }
        Ok(())
    }
}
