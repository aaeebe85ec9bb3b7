//! Interaction order, friction and strictness, chosen on held-out blocks.

use crate::candidates::{Candidates, Group};
use crate::error::IdentifyError;
use crate::friction::{FrictionKind, FrictionLibrary, REVERSAL, WIDTHS, WORTH, reversal_label};
use crate::held_out::{BLOCKS, CvScore, choose_worth, split};
use crate::plan::{LibraryKind, LibraryOptions, MOST_CANDIDATES, Regression};
use crate::rows::{clear_of_reversals, samples_of};
use crate::step::{self, Step};
use crate::survey::Survey;
use rayon::prelude::*;
use torquewise_model::FrictionTerm;
use torquewise_model::model::Choice;
use torquewise_regression::normal_equations::NormalEquations;
use torquewise_regression::row_sums::{Prepared, RowAdder};
use torquewise_regression::select::Selector;
use torquewise_regression::select::criterion::Criterion;

/// What a plan leaves open, as it is settled on the sample of a survey: fitted without a block of
/// time and judged on it.
pub(crate) struct ModelSelection<'a> {
    survey: &'a Survey,
    options: &'a LibraryOptions,
    pub(crate) library: LibraryKind,
    pub(crate) friction: Vec<FrictionTerm>,
    pub(crate) selector: Selector,
    pub(crate) choices: Vec<Choice>,
}

/// Times the γ of a plan that are tried, the strictest first.
const STRICTER: [f64; 3] = [4.0, 2.0, 1.0];
/// A block of fewer rows judges nothing.
const LEAST_ROWS: usize = 40;
/// Held-out errors below this are rounding of the normal equations.
const LEAST_ERROR: f64 = 1e-6;

/// Chooses the laws of friction that candidates hold, on the sample of a survey of all logs.
///
/// They depend on how fast the joints move, so they are chosen before rows are summed.
pub(crate) fn choose_laws(
    survey: &Survey,
    options: &LibraryOptions,
) -> Result<(Vec<FrictionTerm>, Vec<Choice>), IdentifyError> {
    if options.friction == FrictionKind::None {
        return Ok((Vec::new(), Vec::new()));
    }
    let kind = match options.friction {
        FrictionKind::Auto => FrictionKind::Linear,
        asked => asked,
    };
    let friction = FrictionLibrary::new(survey.dq_peak.clone()).of(kind);
    let mut settled = ModelSelection::start(survey, options, friction);
    if is_short(survey) {
        return Ok((settled.friction, settled.choices));
    }
    if options.library == (LibraryKind::Energy { interaction: None }) {
        settled.grow()?;
        // It is chosen, and recorded, once more when the laws are known.
        settled.choices.clear();
    }
    let (validation, laws) = settled.choose_reversal()?;
    if options.friction == FrictionKind::Auto {
        settled.choose_friction(&validation, &laws)?;
    }
    Ok((settled.friction, settled.choices))
}

/// Settles what a plan leaves open on the sample of a survey.
///
/// - `friction`: the laws among the candidates, and how they were chosen
///
/// Interaction orders grow one at a time, and no further once a higher one predicts no better. All
/// rows of the sample are one step here: the steps tell terms apart, which does not change what
/// the log can tell.
pub(crate) fn select_model<'a>(
    survey: &'a Survey,
    options: &'a LibraryOptions,
    (friction, choices): (&[FrictionTerm], &[Choice]),
) -> Result<ModelSelection<'a>, IdentifyError> {
    let mut settled = ModelSelection::start(survey, options, friction.to_vec());
    settled.choices.extend_from_slice(choices);
    if options.regression != Regression::Stepwise || is_short(survey) {
        return Ok(settled);
    }
    let grown = if options.library == (LibraryKind::Energy { interaction: None }) {
        settled.grow()?
    } else {
        None
    };
    if let Selector::Criterion(criterion) = settled.selector {
        let validation = match grown {
            Some(validation) => validation,
            None => settled.validation(settled.library, settled.friction.clone())?,
        };
        settled.choose_ebic_gamma(criterion, &validation)?;
    }
    Ok(settled)
}

fn is_short(survey: &Survey) -> bool {
    survey.sample.n_rows() < BLOCKS * LEAST_ROWS
}

impl<'a> ModelSelection<'a> {
    fn start(survey: &'a Survey, options: &'a LibraryOptions, friction: Vec<FrictionTerm>) -> Self {
        let (library, selector) = (options.library, options.selector.clone());
        Self { survey, options, library, friction, selector, choices: Vec::new() }
    }

    /// Candidates of a library with laws of friction, ready to be judged.
    fn validation(
        &self,
        library: LibraryKind,
        laws: Vec<FrictionTerm>,
    ) -> Result<CrossValidation<'a>, IdentifyError> {
        let (n, regression) = (self.survey.joints.len(), self.options.regression);
        let candidates = Candidates::with_friction(n, library, regression, laws)?;
        CrossValidation::new(self.survey, candidates)
    }

    /// Chooses among trials, simplest first, and puts the choice on record; returns its place.
    fn choose(&mut self, what: &str, worth: f64, trials: &[CvScore]) -> Option<usize> {
        let (place, choice) = choose_worth(what, trials, worth)?;
        self.choices.push(choice);
        Some(place)
    }

    /// Adds joint angles to a term, one at a time, while held-out rows are predicted better.
    fn grow(&mut self) -> Result<Option<CrossValidation<'a>>, IdentifyError> {
        let (mut trials, mut validations) = (Vec::<CvScore>::new(), Vec::new());
        for order in 1..=self.survey.joints.len() {
            let library = LibraryKind::Energy { interaction: Some(order) };
            let (n, regression) = (self.survey.joints.len(), self.options.regression);
            let laws = self.friction.clone();
            let candidates = Candidates::with_friction(n, library, regression, laws)?;
            if order > 1 && candidates.len() > MOST_CANDIDATES {
                break;
            }
            let validation = CrossValidation::new(self.survey, candidates)?;
            trials.push(validation.trial(format!("{order}"), None, &self.selector)?);
            validations.push(validation);
            // One more look: a pair of orders may help where one alone does not.
            let best = |trials: &[CvScore]| {
                trials.iter().map(CvScore::error).fold(f64::INFINITY, f64::min)
            };
            if order > 2 && best(&trials[order - 2..]) >= best(&trials[..order - 2]) {
                break;
            }
        }
        let Some(place) = self.choose("joint angles in a term", 0.0, &trials) else {
            return Ok(None);
        };
        self.library = LibraryKind::Energy { interaction: Some(place + 1) };
        Ok(Some(validations.swap_remove(place)))
    }

    /// Chooses how sharply friction reverses, with all laws of its kind.
    fn choose_reversal(&mut self) -> Result<(CrossValidation<'a>, FrictionLibrary), IdentifyError> {
        let (mut ways, mut trials) = (Vec::new(), Vec::new());
        for part in WIDTHS {
            let laws = FrictionLibrary::with_width(self.survey.dq_peak.clone(), part);
            let validation = self.validation(self.library, laws.of(self.options.friction))?;
            trials.push(validation.trial(reversal_label(part), None, &self.selector)?);
            ways.push((validation, laws));
        }
        let place = self.choose(REVERSAL, 0.0, &trials).unwrap_or(0);
        let (validation, laws) = ways.swap_remove(place);
        self.friction = laws.of(self.options.friction);
        Ok((validation, laws))
    }

    fn choose_friction(
        &mut self,
        validation: &CrossValidation<'_>,
        laws: &FrictionLibrary,
    ) -> Result<(), IdentifyError> {
        let stribeck = laws.of(FrictionKind::Stribeck);
        let alike = stribeck.iter().filter(|law| law.direction.is_both()).cloned().collect();
        let ways = [
            ("none", Vec::new()),
            ("linear", laws.of(FrictionKind::Linear)),
            ("stribeck", alike),
            ("stribeck, forward and backward apart", stribeck),
        ];
        let trial = |(label, laws): &(&str, Vec<FrictionTerm>)| {
            validation.trial((*label).into(), Some(laws), &self.selector)
        };
        let trials = ways.iter().map(trial).collect::<Result<Vec<_>, _>>()?;
        if let Some(place) = self.choose("friction", WORTH, &trials) {
            self.friction.clone_from(&ways[place].1);
        }
        Ok(())
    }

    fn choose_ebic_gamma(
        &mut self,
        criterion: Criterion,
        validation: &CrossValidation<'_>,
    ) -> Result<(), IdentifyError> {
        let gammas = STRICTER.map(|times| times * criterion.gamma);
        let stricter = |gamma| Selector::Criterion(Criterion { gamma });
        let trial = |&gamma: &f64| {
            validation.trial(format!("{gamma}"), Some(&self.friction), &stricter(gamma))
        };
        let trials = gammas.iter().map(trial).collect::<Result<Vec<_>, _>>()?;
        if let Some(place) = self.choose("EBIC gamma", 0.0, &trials) {
            self.selector = stricter(gammas[place]);
        }
        Ok(())
    }
}

/// Candidates with the normal equations of each block of time.
struct CrossValidation<'a> {
    survey: &'a Survey,
    candidates: Candidates,
    groups: Vec<Group>,
    /// `[block][equation]`
    blocks: Vec<Vec<NormalEquations>>,
}

impl<'a> CrossValidation<'a> {
    fn new(survey: &'a Survey, candidates: Candidates) -> Result<Self, IdentifyError> {
        let (m, n) = (survey.sample.n_rows(), survey.joints.len());
        let prepared = Prepared::cheaper(&candidates.design, n, m / BLOCKS);
        let blocks = (0..BLOCKS)
            .into_par_iter()
            .map(|block| {
                let rows = survey.sample.select(&split(m, block).0);
                let rows = clear_of_reversals(&rows, &candidates.friction);
                let mut sums = RowAdder::new(&prepared);
                sums.push(samples_of(&rows, &candidates.friction)?)?;
                Ok(sums.finish()?.all_grams(&prepared))
            })
            .collect::<Result<_, IdentifyError>>()?;
        let groups = candidates.groups();
        Ok(Self { survey, candidates, groups, blocks })
    }

    /// Selects among all terms and some laws of friction, all of them by default, with each block
    /// left out, and judges the block by it.
    fn trial(
        &self,
        label: String,
        laws: Option<&Vec<FrictionTerm>>,
        selector: &Selector,
    ) -> Result<CvScore, IdentifyError> {
        let columns: Vec<usize> = (0..self.candidates.len()).collect();
        let is_offered = |&column: &usize| match (laws, self.candidates.law(column)) {
            (Some(laws), Some(law)) => laws.contains(law),
            _ => true,
        };
        let offered: Vec<usize> = columns.iter().copied().filter(is_offered).collect();
        let complexity = offered.len();
        let step = Step { pattern: None, offered, columns };
        let errors = (0..BLOCKS)
            .map(|block| self.error(block, &step, selector))
            .collect::<Result<_, _>>()?;
        Ok(CvScore { label, complexity, errors })
    }

    /// Geometric mean over the joints of RMSE on a block over the spread of the torque.
    fn error(&self, block: usize, step: &Step, selector: &Selector) -> Result<f64, IdentifyError> {
        let rest = self.equations((0..BLOCKS).filter(|&other| other != block))?;
        let judge = self.equations(std::iter::once(block))?;
        let errors: Vec<f64> = self
            .groups
            .par_iter()
            .map(|group| {
                let mut known = vec![0.0; self.candidates.len()];
                for (column, weight) in step::select(step, &rest, group, &known, selector)? {
                    known[column] = weight;
                }
                Ok(group
                    .equations
                    .iter()
                    .filter_map(|&(equation, joint)| {
                        let left = step::unexplained(&judge, equation, joint, &known);
                        let spread = self.survey.torque_std[joint];
                        let rms = (left / judge[equation].rows.max(1.0)).sqrt();
                        (spread > 0.0).then(|| (rms / spread).max(LEAST_ERROR).ln())
                    })
                    .collect::<Vec<f64>>())
            })
            .collect::<Result<Vec<_>, torquewise_regression::SparseError>>()?
            .concat();
        Ok((errors.iter().sum::<f64>() / errors.len().max(1) as f64).exp())
    }

    /// The normal equations of some blocks together.
    fn equations(
        &self,
        blocks: impl Iterator<Item = usize>,
    ) -> Result<Vec<NormalEquations>, IdentifyError> {
        let mut blocks = blocks.map(|block| &self.blocks[block]);
        let mut sums = blocks.next().cloned().unwrap_or_default();
        for block in blocks {
            sums.iter_mut().zip(block).try_for_each(|(sum, more)| sum.add(more, 1.0))?;
        }
        Ok(sums)
    }
}
