//! Options of a fit as words and numbers, for programs in other languages.

use crate::{Error, FitOptions, Library, Result};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Map, Value, json};
use std::ops::RangeInclusive;
use torquewise_identify::{FrictionKind, Refine, Regression};
use torquewise_model::JointKind;
use torquewise_regression::Selector;
use torquewise_regression::select::criterion::Criterion;
use torquewise_regression::select::lasso::Lasso;
use torquewise_regression::select::stlsq::Stlsq;
use torquewise_stepwise::activation::Scaling;

/// Options that are whole numbers, their bounds, and what they are set to.
type Whole = (&'static str, RangeInclusive<u64>, fn(&FitOptions) -> Option<u64>);

const WHOLE: [Whole; 6] = [
    ("n_bootstrap", 0..=1_000, |own| own.n_bootstrap.map(|count| count as u64)),
    ("interaction", 1..=16, |own| own.interaction.map(|count| count as u64)),
    ("trig_order", 1..=8, |own| own.trig_order.map(u64::from)),
    ("gravity_order", 1..=8, |own| own.gravity_order.map(u64::from)),
    ("clusters", 1..=9, |own| own.clusters.map(|count| count as u64)),
    ("seed", 0..=u64::MAX, |own| Some(own.seed)),
];

/// An option of a fit as other languages give it: what their own lists are written from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Keyword {
    /// Its name.
    pub name: &'static str,
    /// What it is set to.
    #[serde(flatten)]
    pub takes: Takes,
}

/// What an option is set to.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Takes {
    /// One of these.
    Word(Vec<&'static str>),
    /// A whole number within bounds.
    Whole(RangeInclusive<u64>),
    /// A number, zero or more.
    Number,
    /// True or false.
    Switch,
    /// A text.
    Text,
    /// Texts.
    Texts,
}

impl FitOptions {
    /// All options that are plain values.
    pub fn keywords() -> Vec<Keyword> {
        let others = [
            ("library", words::<Library>()),
            ("method", words::<Regression>()),
            ("friction", words::<FrictionKind>()),
            ("kinds", Takes::Text),
            ("counterbalance", Takes::Texts),
            ("refine", words::<Refine>()),
            ("select", words::<Selector>()),
            ("threshold", Takes::Number),
            ("noise_correction", Takes::Switch),
            ("activation", words::<Scaling>()),
        ];
        let whole = WHOLE.map(|(name, bounds, _)| (name, Takes::Whole(bounds)));
        others.into_iter().chain(whole).map(|(name, takes)| Keyword { name, takes }).collect()
    }

    /// The options that keywords of another language say; those left out are the usual ones.
    ///
    /// # Errors
    /// [`Error::NoOption`], [`Error::WrongValue`].
    pub fn of_keywords(keywords: &Map<String, Value>) -> Result<Self> {
        for (name, value) in keywords {
            let setting = names().into_iter().find(|setting| setting == name);
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
        for (setting, bounds, of) in WHOLE {
            if of(self).is_some_and(|count| !bounds.contains(&count)) {
                let [least, most] = [bounds.start(), bounds.end()];
                let reason = format!("expected a number from {least} to {most}");
                return Err(Error::WrongValue { setting, reason });
            }
        }
        if self.threshold.is_none_or(|x| x >= 0.0 && x.is_finite()) {
            return Ok(());
        }
        let reason = "expected a number that is zero or more".to_owned();
        Err(Error::WrongValue { setting: "threshold", reason })
    }
}

pub(crate) trait Word: Clone {
    fn all() -> Vec<(&'static str, Self)>;
}

macro_rules! word {
    ($($kind:ident: $($word:expr => $value:expr),+;)+) => {
        $(impl Word for $kind {
            fn all() -> Vec<(&'static str, Self)> {
                vec![$(($word, $value)),+]
            }
        })+
    };
}
word! {
    Library: "energy" => Self::Energy, "product" => Self::Product, "chain" => Self::Chain;
    Regression: "stepwise" => Self::Stepwise, "sindy" => Self::OneShot;
    FrictionKind: "none" => Self::None, "linear" => Self::Linear, "stribeck" => Self::Stribeck,
        "auto" => Self::Auto;
    Refine: "rollout" => Self::Rollout;
    Selector: "bic" => Self::Criterion(Criterion::default()),
        "lasso" => Self::Lasso(Lasso::default()), "stlsq" => Self::Stlsq(Stlsq::default());
    Scaling: "scaled" => Self::Scaled, "paper" => Self::Paper;
}

pub(crate) fn names() -> Vec<&'static str> {
    FitOptions::keywords().iter().map(|own| own.name).collect()
}

fn words<T: Word>() -> Takes {
    Takes::Word(T::all().into_iter().map(|(word, _)| word).collect())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_has_its_keyword() {
        let told = FitOptions::deserialize(json!({ "": 0 })).unwrap_err().to_string();
        let mut fields: Vec<&str> = told.split('`').skip(3).step_by(2).collect();
        let mut keywords = names();
        fields.sort_unstable();
        keywords.sort_unstable();

        assert_eq!(fields, keywords, "{told}");
    }
}
