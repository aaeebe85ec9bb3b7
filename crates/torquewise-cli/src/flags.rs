//! Flags given, what is fitted → a refusal of those it does not use.

use crate::error::CliError;
use torquewise::identify::plan::Regression;

/// What is fitted, as far as its flags differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fitted {
    /// The energy library.
    Energy(Regression),
    /// The product library.
    Product(Regression),
    /// A chain of rigid bodies.
    Chain,
}

/// A flag that not every method uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Flag {
    Friction,
    Interaction,
    TrigOrder,
    GravityOrder,
    Counterbalance,
    Select,
    Threshold,
    Bags,
    NoNoiseCorrection,
    Unconstrained,
}

impl Fitted {
    fn name(self) -> &'static str {
        match self {
            Self::Energy(Regression::Stepwise) => "the energy library",
            Self::Energy(Regression::OneShot) => "one-shot SINDy over the energy library",
            Self::Product(Regression::Stepwise) => "the product library",
            Self::Product(Regression::OneShot) => "one-shot SINDy over the product library",
            Self::Chain => "a learned chain of rigid bodies",
        }
    }
}

impl Flag {
    /// As it is typed.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Friction => "--friction",
            Self::Interaction => "--interaction",
            Self::TrigOrder => "--trig-order",
            Self::GravityOrder => "--gravity-order",
            Self::Counterbalance => "--counterbalance",
            Self::Select => "--select",
            Self::Threshold => "--threshold",
            Self::Bags => "--bags",
            Self::NoNoiseCorrection => "--no-noise-correction",
            Self::Unconstrained => "--unconstrained",
        }
    }

    fn is_used_by(self, fitted: Fitted) -> bool {
        match self {
            Self::Friction => fitted != Fitted::Product(Regression::OneShot),
            Self::Interaction => matches!(fitted, Fitted::Energy(_)),
            Self::TrigOrder => matches!(fitted, Fitted::Product(_)),
            Self::GravityOrder => fitted == Fitted::Product(Regression::Stepwise),
            Self::Counterbalance | Self::Unconstrained => fitted == Fitted::Chain,
            Self::Select | Self::Threshold | Self::Bags => fitted != Fitted::Chain,
            Self::NoNoiseCorrection => true,
        }
    }

    /// What uses it.
    fn user(self) -> &'static str {
        match self {
            Self::Friction => "--method stepwise",
            Self::Interaction => "--library energy",
            Self::TrigOrder => "--library product",
            Self::GravityOrder => "--library product with --method stepwise",
            Self::Counterbalance | Self::Unconstrained => "--library chain",
            Self::Select | Self::Threshold | Self::Bags | Self::NoNoiseCorrection => {
                "--library energy|product (energy needs --interaction K beyond four joints)"
            }
        }
    }
}

/// Fails at the first flag that is not used.
///
/// - `because`: why that is fitted, as the end of a sentence
/// - `choose`: how another method is chosen, such as `choose`
///
/// # Errors
/// [`CliError::Usage`] names the flag, what is fitted and why, and what to do.
pub(crate) fn refuse_unused(
    given: &[Flag],
    fitted: Fitted,
    because: &str,
    choose: &str,
) -> Result<(), CliError> {
    let Some(flag) = given.iter().find(|flag| !flag.is_used_by(fitted)) else { return Ok(()) };
    Err(CliError::Usage(format!(
        "{} is not used by {}, which is fitted because {because}: leave it out or {choose} {}",
        flag.name(),
        fitted.name(),
        flag.user(),
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_names_the_flag_the_method_the_reason_and_the_way_out() {
        let given = [Flag::NoNoiseCorrection, Flag::Threshold];
        let refused = refuse_unused(&given, Fitted::Chain, "the log is filtered", "choose");

        let message = refused.unwrap_err().to_string();
        assert_eq!(
            message,
            "--threshold is not used by a learned chain of rigid bodies, which is fitted because \
             the log is filtered: leave it out or choose --library energy|product (energy needs \
             --interaction K beyond four joints)"
        );
    }

    #[test]
    fn flags_that_are_used_pass() {
        let chain = [Flag::Friction, Flag::Counterbalance, Flag::NoNoiseCorrection];
        let product = [Flag::Select, Flag::Bags, Flag::TrigOrder, Flag::GravityOrder];

        assert!(refuse_unused(&chain, Fitted::Chain, "", "").is_ok());
        assert!(refuse_unused(&product, Fitted::Product(Regression::Stepwise), "", "").is_ok());
        assert!(refuse_unused(&product, Fitted::Product(Regression::OneShot), "", "").is_err());
    }
}
