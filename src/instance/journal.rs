//! Log lines, kept until the host's logger can be called without holding the instance.

use crate::category::{Category, LOG_ALL};
use crate::error::CallError;
use std::ffi::CString;

/// A finished log line.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// What it is about.
    pub category: Category,
    /// Text without a line break at its end.
    pub text: String,
}

impl Line {
    /// Category and text as C strings. In FMI 2.0 the text is a `format` without arguments, as
    /// some hosts read none: `%` is written twice, and `#`, which begins a variable there.
    pub fn to_c(&self, format: bool) -> [CString; 2] {
        let mut text = self.text.replace('\0', " ");
        if format {
            text = text.replace('#', "##").replace('%', "%%");
        }
        [self.category.name(), &text].map(|part| CString::new(part).unwrap_or_default())
    }
}

/// Which categories are wanted, and the lines not yet handed over.
#[derive(Debug)]
pub struct Journal {
    wanted: [bool; Category::ALL.len()],
    lines: Vec<Line>,
}

impl Journal {
    /// Errors and warnings are always wanted at first, the rest if `debug`.
    pub fn new(debug: bool) -> Self {
        Self { wanted: Category::ALL.map(|c| debug || !c.is_debug()), lines: Vec::new() }
    }

    /// True if somebody listens.
    pub fn wants(&self, category: Category) -> bool {
        self.wanted[category as usize]
    }

    /// True if somebody listens to more than errors and warnings.
    pub fn wants_debug(&self) -> bool {
        self.wants(Category::Events) || self.wants(Category::Modes)
    }

    /// Keeps a line if its category is wanted.
    pub fn write(&mut self, category: Category, text: impl FnOnce() -> String) {
        if self.wants(category) {
            self.lines.push(Line { category, text: text() });
        }
    }

    /// Takes the lines out.
    pub fn take(&mut self) -> Vec<Line> {
        std::mem::take(&mut self.lines)
    }

    /// Switches the named categories. Without names: all. Who wants to hear of errors alone
    /// names the debug categories to switch off, or never switches logging on.
    ///
    /// # Errors
    /// A name that is no category; nothing is switched then.
    pub fn switch(&mut self, on: bool, names: &[String]) -> Result<(), CallError> {
        let known =
            |name: &String| name == LOG_ALL || Category::ALL.iter().any(|c| c.name() == name);
        if let Some(name) = names.iter().find(|name| !known(name)) {
            return Err(CallError::Argument(format!("there is no log category {name:?}")));
        }
        for category in Category::ALL {
            let named = names.iter().any(|name| name == LOG_ALL || name == category.name());
            let by_default = names.is_empty();
            // Naming some to switch on means only those, of the debug ones.
            let left_out = on && !named && category.is_debug();
            if named || by_default {
                self.wanted[category as usize] = on;
            } else if left_out {
                self.wanted[category as usize] = false;
            }
        }
        Ok(())
    }
}
