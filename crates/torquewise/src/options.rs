//! What is fitted to a log unless it is said otherwise, and which options go with it.

use crate::keywords::{joint_kinds, some_word, word};
use crate::{Error, Remedy, Result, Wording};
use serde::Deserialize;
use torquewise_identify::plan::KnownGeometry;
use torquewise_identify::settings::SumSettings;
use torquewise_identify::{
    ChainOptions, FrictionKind, LibraryKind, LibraryOptions, Method, PatternPlan, Plan, Refine,
    Regression,
};
use torquewise_model::JointKind;
use torquewise_model::expansion::check_joints;
use torquewise_regression::Selector;
use torquewise_stepwise::activation::Scaling;

/// Joints up to which the whole energy library is offered.
pub(crate) const MOST_WHOLE: usize = 4;
/// Joints of which the terms predict a noisy log as well as a chain does; of four they err twenty times
/// as much.
pub(crate) const MOST_BY_TERMS: usize = 3;

/// Which equations are offered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Library {
    /// M(q) and V(q), shared by all joints: exact for rigid arms; all terms for up to four joints
    /// or with an interaction order, else those of a chain.
    Energy,
    /// Products of sines, cosines, velocities and accelerations, for each joint on its own.
    Product,
    /// Energies of a chain of rigid bodies whose geometry is learned too: for noisy logs, friction
    /// and many joints.
    Chain,
}

/// What is fitted and how; what is left out is chosen by the log.
///
/// Programs in other languages give them as an object of the same fields, by [`Self::of_keywords`].
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FitOptions {
    /// By default a chain for filtered logs, friction, four joints and more, or where it misses less
    /// than terms that are not good, else the energy library; the product library with one-shot SINDy.
    #[serde(deserialize_with = "some_word")]
    pub library: Option<Library>,
    /// Standstill, uniform and variable velocity in turn, or all rows at once as SINDy does.
    #[serde(rename = "method", deserialize_with = "word")]
    pub regression: Regression,
    /// By default whichever predicts held-out rows best for a chain, none for a library.
    #[serde(deserialize_with = "some_word")]
    pub friction: Option<FrictionKind>,
    /// Energy library: at most this many joint angles in a term.
    pub interaction: Option<usize>,
    /// Product library: factors of sine and cosine in a term.
    pub trig_order: Option<u8>,
    /// Product library: the same for the gravity step.
    pub gravity_order: Option<u8>,
    /// Which terms of a library stay.
    #[serde(rename = "select", deserialize_with = "some_word")]
    pub selector: Option<Selector>,
    /// Coefficients of a library that are at most this large are dropped.
    pub threshold: Option<f64>,
    /// Bootstrap resamples, to count in how many each term of a library stays.
    pub n_bootstrap: Option<usize>,
    /// Where the axes of a chain lie, as [`crate::urdf::known_geometry`] reads it; else it is
    /// learned too.
    #[serde(skip)]
    pub geometry: Option<KnownGeometry>,
    /// Which joints of a chain turn and which slide; else it is learned too.
    #[serde(deserialize_with = "joint_kinds")]
    pub kinds: Option<Vec<JointKind>>,
    /// Joints of a chain that a spring or a weight is known to balance.
    #[serde(rename = "counterbalance")]
    pub counterbalanced: Vec<String>,
    /// Whether the bias that noise in q, q̇, q̈ leaves is taken out (E7): it is but by one-shot SINDy,
    /// which never does.
    pub noise_correction: Option<bool>,
    /// What a chain is refined by once its torque is fitted, if by anything (E23).
    #[serde(deserialize_with = "some_word")]
    pub refine: Option<Refine>,
    /// Constants of the activation index.
    #[serde(deserialize_with = "word")]
    pub activation: Scaling,
    /// Clusters of rows; the elbow of their inertia without.
    pub clusters: Option<usize>,
    /// Random seed.
    pub seed: u64,
}

/// What is fitted, as far as its options differ; a chain is always stepwise.
type Fitted = (Library, Regression);

impl FitOptions {
    /// One-shot SINDy over the product library: the baseline.
    pub fn sindy() -> Self {
        Self { regression: Regression::OneShot, ..Self::default() }
    }

    /// How rows are clustered.
    pub fn patterns(&self) -> PatternPlan {
        let Self { activation: scaling, clusters, seed, .. } = *self;
        PatternPlan { scaling, clusters, slow: false, seed }
    }

    /// Fails where options contradict each other, before a log is read.
    ///
    /// # Errors
    /// [`Error::UnusedOption`], [`Error::SindyOfChain`], [`Error::WrongValue`].
    pub fn check(&self) -> Result<()> {
        self.check_bounds()?;
        self.plan(0, false).map(drop)
    }

    /// What is fitted to a log.
    ///
    /// - `joints`: number of its joints, 0 before they are read
    /// - `is_filtered`: whether its signals go through a filter
    pub(crate) fn plan(&self, joints: usize, is_filtered: bool) -> Result<Plan> {
        let kinds = self.kinds.as_ref();
        if let Some(kinds) = kinds.filter(|own| joints > 0 && own.len() != joints) {
            let letters: String = kinds.iter().map(|kind| kind.letter).collect();
            let found = kinds.len();
            let own = if found == 1 { "joint" } else { "joints" };
            let reason = format!("{letters} is of {found} {own}, the log has {joints}");
            return Err(Error::WrongValue { setting: "kinds", reason });
        }
        let (library, because) = self.fitted(joints, is_filtered);
        if library == Library::Chain {
            if self.regression == Regression::OneShot {
                return Err(Error::SindyOfChain);
            }
            check_joints(joints)?;
        }
        let fitted = (library, self.regression);
        self.refuse_unused(fitted, &because, &[])?;
        Ok(self.plan_of(fitted))
    }

    /// Plans for stepwise reconstruction, and for one-shot SINDy over the product library.
    pub(crate) fn plans_to_compare(&self) -> Result<[Plan; 2]> {
        let library = self.library.unwrap_or(Library::Energy);
        if library == Library::Chain {
            return Err(Error::CompareChain);
        }
        let stepwise = (library, Regression::Stepwise);
        let because = "one-shot SINDy is compared with it";
        self.refuse_unused(stepwise, because, &["trig_order"])?;
        Ok([stepwise, (Library::Product, Regression::OneShot)].map(|fitted| self.plan_of(fitted)))
    }

    /// The plan for sums that were made under `settings`, which go before these options.
    pub(crate) fn plan_for_sums(&self, settings: &SumSettings) -> Result<Plan> {
        let fitted = match &settings.library {
            None => (Library::Chain, Regression::Stepwise),
            Some(library) => match library.kind {
                LibraryKind::Energy { .. } => (Library::Energy, library.regression),
                LibraryKind::Product { .. } => (Library::Product, library.regression),
            },
        };
        if settings.library.is_some() && self.has_friction() {
            return Err(Error::FrictionOfSums);
        }
        self.refuse_unused(fitted, "the logs were summed for it", &[])?;
        let mut plan = self.plan_of(fitted);
        if let (Method::Library(options), Some(library)) = (&mut plan.method, &settings.library) {
            options.library = library.kind;
        }
        Ok(Plan { patterns: settings.patterns, ..plan })
    }

    fn fitted(&self, joints: usize, is_filtered: bool) -> (Library, String) {
        let many = joints > MOST_WHOLE && self.interaction.is_none();
        let stepwise = self.regression == Regression::Stepwise;
        let too_many = format!("the log has {joints} joints");
        let slides = self.kinds.iter().flatten().any(|kind| !kind.turns());
        let of_terms = self.selector.is_some()
            || self.threshold.is_some()
            || self.n_bootstrap.is_some()
            || self.interaction.is_some();
        let for_chain = [
            (self.geometry.is_some(), "the geometry of the arm is given"),
            (slides, "a joint slides"),
            (is_filtered, "the log is filtered"),
            (self.refine.is_some(), "it is to be refined"),
            (self.has_friction(), "friction was asked for"),
            (many || joints > MOST_BY_TERMS && !of_terms, &too_many),
            (!self.counterbalanced.is_empty(), "a joint is counterbalanced"),
        ];
        match self.library {
            // Its terms are too many to be listed: they are grown along a chain.
            Some(Library::Energy) if many && stepwise => (Library::Chain, too_many),
            Some(library) => (library, "the library was chosen".into()),
            None if !stepwise => (Library::Product, "SINDy was chosen".into()),
            None => match for_chain.into_iter().find(|(holds, _)| *holds) {
                Some((_, because)) => (Library::Chain, because.to_owned()),
                None => (Library::Energy, "no other library was chosen".into()),
            },
        }
    }

    fn has_friction(&self) -> bool {
        self.friction.is_some_and(|friction| friction != FrictionKind::None)
    }

    /// Fails at the first option given that `fitted` does not use.
    fn refuse_unused(&self, fitted: Fitted, because: &str, spared: &[&str]) -> Result<()> {
        let [energy, product, chain] =
            [Library::Energy, Library::Product, Library::Chain].map(|own| fitted.0 == own);
        let by_step = fitted == (Library::Product, Regression::Stepwise);
        let one_shot = fitted == (Library::Product, Regression::OneShot);
        let all: [(_, _, _, Remedy); 10] = [
            ("friction", self.has_friction(), !one_shot, STEPWISE),
            ("interaction", self.interaction.is_some(), energy, ENERGIES),
            ("trig_order", self.trig_order.is_some(), product, PRODUCTS),
            ("gravity_order", self.gravity_order.is_some(), by_step, PRODUCTS_BY_STEP),
            ("select", self.selector.is_some(), !chain, terms),
            ("threshold", self.threshold.is_some(), !chain, terms),
            ("n_bootstrap", self.n_bootstrap.is_some(), !chain, terms),
            ("urdf", self.geometry.is_some(), chain, CHAINS),
            ("counterbalance", !self.counterbalanced.is_empty(), chain, CHAINS),
            ("refine", self.refine.is_some(), chain, CHAINS),
        ];
        for (setting, is_given, is_used, remedy) in all {
            if is_given && !is_used && !spared.contains(&setting) {
                let (fitted, because) = (name(fitted), because.to_owned());
                return Err(Error::UnusedOption { setting, fitted, because, remedy });
            }
        }
        Ok(())
    }

    fn plan_of(&self, (library, regression): Fitted) -> Plan {
        let energy = LibraryKind::Energy { interaction: self.interaction };
        let method = match library {
            Library::Energy => self.library_options(energy, regression),
            Library::Product => self.library_options(self.product(), regression),
            Library::Chain => {
                let usual = ChainOptions::default();
                Method::Chain(ChainOptions {
                    geometry: self.geometry.clone(),
                    kinds: self.kinds.clone().map(Into::into),
                    friction: self.friction.unwrap_or(usual.friction),
                    counterbalanced: self.counterbalanced.clone(),
                    noise_correction: usual.noise_correction
                        && self.noise_correction.unwrap_or(true),
                    refine: self.refine,
                })
            }
        };
        Plan { method, seed: self.seed, patterns: self.patterns() }
    }

    fn library_options(&self, library: LibraryKind, regression: Regression) -> Method {
        let usual = match regression {
            Regression::OneShot => LibraryOptions::sindy(),
            Regression::Stepwise => LibraryOptions::default(),
        };
        Method::Library(LibraryOptions {
            library,
            kinds: self.kinds.clone().unwrap_or_default().into(),
            regression,
            friction: self.friction.unwrap_or(usual.friction),
            selector: self.selector(usual.selector),
            threshold: self.threshold.or(usual.threshold),
            noise_correction: usual.noise_correction && self.noise_correction.unwrap_or(true),
            bags: self.n_bootstrap.unwrap_or(usual.bags),
        })
    }

    fn selector(&self, usual: Selector) -> Selector {
        let mut selector = self.selector.clone().unwrap_or(usual);
        if let Some(asked) = self.threshold {
            match &mut selector {
                Selector::Lasso(lasso) => lasso.threshold = asked,
                Selector::Stlsq(stlsq) => stlsq.threshold = asked,
                _ => {}
            }
        }
        selector
    }

    fn product(&self) -> LibraryKind {
        match LibraryKind::PRODUCT {
            LibraryKind::Product { gravity_order, trig_order } => LibraryKind::Product {
                gravity_order: self.gravity_order.unwrap_or(gravity_order),
                trig_order: self.trig_order.unwrap_or(trig_order),
            },
            other @ LibraryKind::Energy { .. } => other,
        }
    }
}

fn name(fitted: Fitted) -> &'static str {
    match fitted {
        (Library::Energy, Regression::Stepwise) => "the energy library",
        (Library::Energy, Regression::OneShot) => "one-shot SINDy over the energy library",
        (Library::Product, Regression::Stepwise) => "the product library",
        (Library::Product, Regression::OneShot) => "one-shot SINDy over the product library",
        (Library::Chain, _) => "a learned chain of rigid bodies",
    }
}

const ENERGIES: Remedy = |word| word("library", Some("energy"));
const PRODUCTS: Remedy = |word| word("library", Some("product"));
const CHAINS: Remedy = |word| word("library", Some("chain"));
const STEPWISE: Remedy = |word| word("method", Some("stepwise"));
const PRODUCTS_BY_STEP: Remedy = |word| format!("{} with {}", PRODUCTS(word), STEPWISE(word));

fn terms(word: Wording) -> String {
    let [energies, products, interaction] =
        [ENERGIES(word), PRODUCTS(word), word("interaction", None)];
    format!("{energies} or {products} (energy needs {interaction} beyond four joints)")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_that_are_used_pass() {
        let chain = FitOptions {
            friction: Some(FrictionKind::Auto),
            counterbalanced: vec!["axis_2".into()],
            noise_correction: Some(false),
            ..FitOptions::default()
        };
        let product = FitOptions {
            library: Some(Library::Product),
            n_bootstrap: Some(3),
            trig_order: Some(2),
            gravity_order: Some(2),
            ..FitOptions::default()
        };
        let sindy = FitOptions { regression: Regression::OneShot, ..product.clone() };

        assert!(chain.check().is_ok() && product.check().is_ok());
        assert!(sindy.check().is_err());
        let turning = FitOptions { kinds: Some(vec![JointKind::default(); 4]), ..chain };
        let error = turning.plan(6, true).unwrap_err();
        assert_eq!(error.to_string(), "kinds: rrrr is of 4 joints, the log has 6");
    }
}
