//! Options that messages name, in the words of whoever asked: fields, flags or keywords.

use std::fmt;

/// An option of a fit or an export, as errors name it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "explained at the fields of `FitOptions` and `ExportOptions`")]
pub enum Setting {
    Library,
    Method,
    Friction,
    Interaction,
    TrigOrder,
    GravityOrder,
    Select,
    Threshold,
    Bootstrap,
    Counterbalance,
    NoiseCorrection,
    Activation,
    Clusters,
    Seed,
    /// The geometry of the arm, from a URDF.
    Urdf,
    /// Export of a model that is flawed.
    Force,
    /// An FMU of sources alone.
    NoBinary,
}

/// How a front end words an option, or one with its value.
pub type Wording = fn(Setting, Option<&str>) -> String;

impl Setting {
    /// Those of a fit that are plain values.
    pub const OF_FIT: [Self; 14] = [
        Self::Library,
        Self::Method,
        Self::Friction,
        Self::Interaction,
        Self::TrigOrder,
        Self::GravityOrder,
        Self::Select,
        Self::Threshold,
        Self::Bootstrap,
        Self::Counterbalance,
        Self::NoiseCorrection,
        Self::Activation,
        Self::Clusters,
        Self::Seed,
    ];

    /// Its name, words joined by underscores.
    pub fn name(self) -> &'static str {
        match self {
            Self::Library => "library",
            Self::Method => "method",
            Self::Friction => "friction",
            Self::Interaction => "interaction",
            Self::TrigOrder => "trig_order",
            Self::GravityOrder => "gravity_order",
            Self::Select => "select",
            Self::Threshold => "threshold",
            Self::Bootstrap => "n_bootstrap",
            Self::Counterbalance => "counterbalance",
            Self::NoiseCorrection => "noise_correction",
            Self::Activation => "activation",
            Self::Clusters => "clusters",
            Self::Seed => "seed",
            Self::Urdf => "urdf",
            Self::Force => "force",
            Self::NoBinary => "binary",
        }
    }

    /// The neutral wording: its name, and its value after a space.
    pub fn plain(self, value: Option<&str>) -> String {
        value.map_or_else(|| self.name().to_owned(), |value| format!("{} {value}", self.name()))
    }

    /// Names of the options of a fit, for messages.
    pub(crate) fn names() -> String {
        Self::OF_FIT.map(Self::name).join(", ")
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
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
    /// In the words of a front end.
    pub fn worded(self, word: Wording) -> String {
        let library = |name| word(Setting::Library, Some(name));
        let stepwise = || word(Setting::Method, Some("stepwise"));
        match self {
            Self::Terms => format!(
                "{} or {} (energy needs {} beyond four joints)",
                library("energy"),
                library("product"),
                word(Setting::Interaction, None)
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
        f.write_str(&self.worded(Setting::plain))
    }
}
