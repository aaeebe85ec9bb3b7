//! Options that messages name, in the words of whoever asked: fields, flags or keywords.

use std::fmt;

/// How a front end words an option of a fit or an export by its name, or one with its value.
pub type Wording = fn(&str, Option<&str>) -> String;

/// The neutral wording: the name, and a value after a space.
pub(crate) fn plain(name: &str, value: Option<&str>) -> String {
    value.map_or_else(|| name.to_owned(), |value| format!("{name} {value}"))
}

/// What would use an option that is not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say what to choose")]
pub enum Remedy {
    Terms,
    Energy,
    Product,
    ProductByStep,
    Chain,
    Stepwise,
}

impl Remedy {
    pub(crate) fn worded(self, word: Wording) -> String {
        let library = |name| word("library", Some(name));
        let stepwise = || word("method", Some("stepwise"));
        match self {
            Self::Terms => format!(
                "{} or {} (energy needs {} beyond four joints)",
                library("energy"),
                library("product"),
                word("interaction", None)
            ),
            Self::Energy => library("energy"),
            Self::Product => library("product"),
            Self::ProductByStep => format!("{} with {}", library("product"), stepwise()),
            Self::Chain => library("chain"),
            Self::Stepwise => stepwise(),
        }
    }
}

impl fmt::Display for Remedy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.worded(plain))
    }
}
