//! Rule broken → one line: where, what was found, and what to do.

use std::fmt;

/// One broken rule. Ordered by place, so that a list of them reads file by file.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Violation {
    /// File, relative to the workspace root.
    pub(crate) path: String,
    /// Line, from 1.
    pub(crate) line: usize,
    /// What was found and what to do.
    pub(crate) message: String,
}

impl Violation {
    /// A broken rule at a line (from 1) of a file.
    pub(crate) fn new(path: &str, line: usize, message: impl Into<String>) -> Self {
        Self { path: path.to_owned(), line, message: message.into() }
    }
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}", self.path, self.line, self.message)
    }
}
