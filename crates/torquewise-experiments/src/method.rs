//! Name → plan: the methods that are compared, and the one choice in which variants differ.

use serde::Serialize;
use torquewise_identify::activation::Scaling;
use torquewise_identify::{Method as Steps, Plan};
use torquewise_sparse::select::Selector;
use torquewise_sparse::select::lasso::Lasso;
use torquewise_sparse::select::stlsq::Stlsq;

/// A coefficient larger than this counts as active in the paper.
pub const ACTIVE: f64 = 0.1;

/// The methods compared in every experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Stepwise over the energy library \[E4\], terms judged against the noise \[E5\].
    Energy,
    /// Stepwise over the paper's product library, everything else the same.
    Product,
    /// One-shot SINDy whose terms are chosen by LASSO (5) at the best information criterion, then
    /// refitted.
    SindyLasso,
    /// The stepwise product plan in a single step: what is left of it without the steps.
    SindyCriterion,
    /// One-shot SINDy as it is usually run: thresholded least squares at the paper's 0.1.
    Sindy,
}

impl Method {
    /// Those of cases 1–3, ours first.
    pub const ALL: [Self; 4] = [Self::Energy, Self::Product, Self::SindyLasso, Self::Sindy];
    /// Those of the sweeps. In strong noise LASSO with BIC keeps thousands of terms, whose refit
    /// takes minutes.
    pub const SWEPT: [Self; 4] = [Self::Energy, Self::Product, Self::SindyCriterion, Self::Sindy];

    /// Its name in tables and figures.
    pub fn name(self) -> &'static str {
        match self {
            Self::Energy => "stepwise, energy library",
            Self::Product => "stepwise, product library",
            Self::SindyLasso => "one-shot SINDy, LASSO + BIC + refit",
            Self::SindyCriterion => "one-shot SINDy, our rule",
            Self::Sindy => "one-shot SINDy, |c| > 0.1",
        }
    }

    /// The plan behind it.
    pub fn plan(self) -> Plan {
        let plan = match self {
            Self::Energy => Plan::default(),
            Self::Product => Plan::product(),
            Self::SindyLasso => Plan { selector: lasso(), ..Plan::sindy() },
            Self::SindyCriterion => in_one_step(Plan::product()),
            Self::Sindy => Plan::sindy(),
        };
        // How often a term stays in resampled logs is not asked here.
        Plan { bags: 0, ..plan }
    }
}

/// LASSO, the point of its path by the Bayesian information criterion, refitted.
pub fn lasso() -> Selector {
    Selector::Lasso(Lasso::default())
}

/// The paper's rule for active terms, |coefficient| > 0.1.
pub fn threshold() -> Selector {
    Selector::Stlsq(Stlsq { threshold: ACTIVE, ..Stlsq::default() })
}

/// The same plan with another rule for which terms stay.
pub fn selecting(plan: &Plan, selector: Selector) -> Plan {
    Plan { selector, ..plan.clone() }
}

/// The same plan in a single step on all rows.
pub fn in_one_step(plan: Plan) -> Plan {
    Plan { method: Steps::Sindy, ..plan }
}

/// The same plan with or without the correction for noise in q, q̇ and q̈ \[E7\].
pub fn correcting_noise(plan: Plan, noise_correction: bool) -> Plan {
    Plan { noise_correction, ..plan }
}

/// The same plan with the activation index as printed, in place of the scaled one \[E1\].
pub fn with_printed_index(mut plan: Plan) -> Plan {
    plan.patterns.scaling = Scaling::Paper;
    plan.patterns.clusters = Some(3);
    plan
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_methods_differ_in_library_steps_and_rule_only() {
        let [energy, product, lasso, sindy] = Method::ALL.map(Method::plan);

        assert_eq!(Plan { library: product.library, ..energy }, product);
        assert_eq!(Plan { selector: sindy.selector.clone(), ..lasso.clone() }, sindy);
        assert_eq!((sindy.method, lasso.noise_correction), (Steps::Sindy, false));
    }
}
