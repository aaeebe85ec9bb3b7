//! May a model be used, and why.

use serde::{Deserialize, Serialize};
use std::fmt;

/// May a model be used?
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Grade {
    /// As it is.
    Good,
    /// With the reasons in mind.
    Usable,
    /// Not without a better log.
    Unusable,
}

/// A grade, and what it rests on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Verdict {
    /// The grade.
    pub grade: Grade,
    /// Why, the gravest first; one sentence part each.
    pub because: Vec<String>,
}

impl Verdict {
    /// The worse grade of two, for the reasons of both, each once.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        let [mut worse, better] =
            if other.grade > self.grade { [other, self] } else { [self, other] };
        for reason in better.because {
            if !worse.because.contains(&reason) {
                worse.because.push(reason);
            }
        }
        worse
    }
}

impl fmt::Display for Grade {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(["good", "usable", "unusable"][*self as usize])
    }
}

impl fmt::Display for Verdict {
    /// One line, without a line break.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.grade, self.because.join("; "))
    }
}
