//! Options of a fit as words and numbers, for programs in other languages.

use crate::error::{Error, Result};
use crate::options::{FitOptions, Library};
use crate::setting::OF_FIT;
use serde::{Deserialize, Deserializer};
use serde_json::{Map, Value, json};
use torquewise_identify::plan::{FrictionKind, Refine, Regression};
use torquewise_model::JointKind;
use torquewise_regression::select::Selector;
use torquewise_regression::select::criterion::Criterion;
use torquewise_regression::select::lasso::Lasso;
use torquewise_regression::select::stlsq::Stlsq;
use torquewise_stepwise::activation::Scaling;

impl FitOptions {
    /// The options that keywords of another language say; those left out are the usual ones.
    ///
    /// # Errors
    /// [`Error::NoOption`], [`Error::WrongValue`].
    pub fn of_keywords(keywords: &Map<String, Value>) -> Result<Self> {
        for (name, value) in keywords {
            let setting = OF_FIT.into_iter().find(|setting| setting == name);
            let setting = setting.ok_or_else(|| Error::NoOption { name: name.clone() })?;
            let wrong = |reason| Error::WrongValue { setting, reason };
            // One by one, so that a complaint names the option.
            Self::deserialize(json!({ name: value })).map_err(|error| wrong(error.to_string()))?;
        }
        let options = Self::deserialize(Value::Object(keywords.clone()));
        let wrong = |reason: String| Error::WrongValue { setting: "library", reason };
        let options = options.map_err(|error| wrong(error.to_string()))?;
        options.check_bounds()?;
        Ok(options)
    }

    /// Fails where a number is out of its bounds.
    pub(crate) fn check_bounds(&self) -> Result<()> {
        let counts = [
            ("interaction", self.interaction, 1..=16),
            ("trig_order", self.trig_order.map(usize::from), 1..=8),
            ("gravity_order", self.gravity_order.map(usize::from), 1..=8),
            ("clusters", self.clusters, 1..=9),
            ("n_bootstrap", self.n_bootstrap, 0..=1_000),
        ];
        for (setting, count, bounds) in counts {
            if count.is_some_and(|count| !bounds.contains(&count)) {
                let [least, most] = [bounds.start(), bounds.end()];
                let reason = format!("expected a number from {least} to {most}");
                return Err(Error::WrongValue { setting, reason });
            }
        }
        match self.threshold {
            Some(x) if !(x >= 0.0 && x.is_finite()) => Err(Error::WrongValue {
                setting: "threshold",
                reason: "expected a number that is zero or more".to_owned(),
            }),
            _ => Ok(()),
        }
    }
}

pub(crate) trait Word: Clone {
    fn all() -> Vec<(&'static str, Self)>;
}

impl Word for Library {
    fn all() -> Vec<(&'static str, Self)> {
        vec![("energy", Self::Energy), ("product", Self::Product), ("chain", Self::Chain)]
    }
}

impl Word for Regression {
    fn all() -> Vec<(&'static str, Self)> {
        vec![("stepwise", Self::Stepwise), ("sindy", Self::OneShot)]
    }
}

impl Word for FrictionKind {
    fn all() -> Vec<(&'static str, Self)> {
        [Self::None, Self::Linear, Self::Stribeck, Self::Auto].map(|k| (k.name(), k)).to_vec()
    }
}

impl Word for Refine {
    fn all() -> Vec<(&'static str, Self)> {
        vec![("rollout", Self::Rollout)]
    }
}

impl Word for Selector {
    fn all() -> Vec<(&'static str, Self)> {
        vec![
            ("bic", Self::Criterion(Criterion::default())),
            ("lasso", Self::Lasso(Lasso::default())),
            ("stlsq", Self::Stlsq(Stlsq::default())),
        ]
    }
}

impl Word for Scaling {
    fn all() -> Vec<(&'static str, Self)> {
        vec![("scaled", Self::Scaled), ("paper", Self::Paper)]
    }
}

pub(crate) fn word<'de, D: Deserializer<'de>, T: Word>(deserializer: D) -> Result<T, D::Error> {
    let word = String::deserialize(deserializer)?;
    let all = T::all();
    all.iter().find(|(own, _)| *own == word).map(|(_, value)| value.clone()).ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|(own, _)| *own).collect();
        serde::de::Error::custom(format!("{word:?}: expected one of {}", names.join(", ")))
    })
}

/// `r,r,p,r`: a letter for each joint.
pub(crate) fn joint_kinds<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<Vec<JointKind>>, D::Error> {
    let text = String::deserialize(deserializer)?;
    let wrong = || format!("{text:?}: expected r or p for each joint, as r,r,p,r");
    JointKind::read_all(&text).map(Some).ok_or_else(|| serde::de::Error::custom(wrong()))
}

pub(crate) fn some_word<'de, D: Deserializer<'de>, T: Word>(
    deserializer: D,
) -> Result<Option<T>, D::Error> {
    word(deserializer).map(Some)
}
