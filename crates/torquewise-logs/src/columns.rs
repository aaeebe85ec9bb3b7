//! From names and values to columns: what a table is made of.

/// What a column of a table holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnKind {
    /// Floating-point numbers, read back to the same bits.
    Number,
    /// Whole numbers, such as a row number.
    Count,
    /// Text, such as the name of a pattern.
    Text,
}

impl ColumnKind {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Number => "numbers",
            Self::Count => "counts",
            Self::Text => "text",
        }
    }
}

/// The name and kind of a column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Name, as it stands in the header.
    pub name: String,
    /// What it holds.
    pub kind: ColumnKind,
}

impl Column {
    /// A column of `kind`.
    pub fn new(name: impl Into<String>, kind: ColumnKind) -> Self {
        Self { name: name.into(), kind }
    }
}

/// Some rows of one column.
#[derive(Clone, Copy, Debug)]
pub enum Values<'a> {
    /// For [`ColumnKind::Number`].
    Numbers(&'a [f64]),
    /// For [`ColumnKind::Count`].
    Counts(&'a [u64]),
    /// For [`ColumnKind::Text`].
    Texts(&'a [&'a str]),
}

impl Values<'_> {
    pub(crate) fn kind(self) -> ColumnKind {
        match self {
            Self::Numbers(_) => ColumnKind::Number,
            Self::Counts(_) => ColumnKind::Count,
            Self::Texts(_) => ColumnKind::Text,
        }
    }

    /// Number of rows.
    pub fn len(self) -> usize {
        match self {
            Self::Numbers(values) => values.len(),
            Self::Counts(values) => values.len(),
            Self::Texts(values) => values.len(),
        }
    }

    /// Whether there are no rows.
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }
}
