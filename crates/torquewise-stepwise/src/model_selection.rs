//! Interaction order, friction and strictness, chosen on held-out blocks.

use crate::friction::{FrictionLibrary, REVERSAL, WIDTHS, WORTH, reversal_label};
use crate::held_out::{BLOCKS, CvScore, mean, record_worth, split};
use crate::step::{self, Step, of_joint};
use crate::{
    Candidates, FrictionKind, IdentifyError, LibraryKind, LibraryOptions, MOST_CANDIDATES,
    Regression, Survey, clear_of_reversals, samples_of,
};
use rayon::prelude::*;
use torquewise_model::library::energy_library_size;
use torquewise_model::{Choice, FrictionTerm, JointKind};
use torquewise_regression::select::criterion::Criterion;
use torquewise_regression::{NormalEquations, PreparedDesign, RowAdder, Selector, SparseError};

/// What a plan leaves open, as it is settled on the sample of a survey: fitted without a block of
/// time and judged on it.
pub(crate) struct ModelSelection<'a> {
    survey: &'a Survey,
    options: &'a LibraryOptions,
    kinds: Vec<JointKind>,
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
    let kind = match options.friction {
        FrictionKind::Auto => FrictionKind::Linear,
        asked => asked,
    };
    let friction = FrictionLibrary::new(survey.dq_peak.clone()).of(kind);
    let mut settled = ModelSelection::start(survey, options, friction);
    if kind == FrictionKind::None || is_short(survey) {
        return Ok((settled.friction, settled.choices));
    }
    settled.grow()?;
    // The order is chosen, and recorded, once more when the laws are known.
    settled.choices.clear();
    // How sharply friction reverses, with all laws of its kind; then which, where that is open.
    let (mut widths, mut trials) = (Vec::new(), Vec::new());
    for part in WIDTHS {
        let laws = FrictionLibrary::with_width(survey.dq_peak.clone(), part);
        let validation = settled.validation(settled.library, laws.of(options.friction))?;
        trials.push(validation.trial(reversal_label(part), None, &settled.selector)?);
        widths.push((validation, laws));
    }
    let place = record_worth(REVERSAL, &trials, 0.0, &mut settled.choices);
    let (validation, laws) = widths.swap_remove(place);
    if options.friction != FrictionKind::Auto {
        return Ok((laws.of(options.friction), settled.choices));
    }
    let stribeck = laws.of(FrictionKind::Stribeck);
    let alike = stribeck.iter().filter(|law| law.direction.is_both()).cloned().collect();
    let mut offers = vec![
        ("none", Vec::new()),
        ("linear", laws.of(FrictionKind::Linear)),
        ("stribeck", alike),
        ("stribeck, forward and backward apart", stribeck),
    ];
    let trial = |(label, laws): &(&str, Vec<FrictionTerm>)| {
        validation.trial((*label).into(), Some(laws), &settled.selector)
    };
    let trials = offers.iter().map(trial).collect::<Result<Vec<_>, _>>()?;
    let place = record_worth("friction", &trials, WORTH, &mut settled.choices);
    Ok((offers.swap_remove(place).1, settled.choices))
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
    let grown = settled.grow()?;
    if let Selector::Criterion(Criterion { gamma }) = settled.selector {
        let validation = match grown {
            Some(validation) => validation,
            None => settled.validation(settled.library, settled.friction.clone())?,
        };
        let gammas = STRICTER.map(|times| times * gamma);
        let stricter = |gamma| Selector::Criterion(Criterion { gamma });
        let trial = |&gamma: &f64| {
            validation.trial(format!("{gamma}"), Some(&settled.friction), &stricter(gamma))
        };
        let trials = gammas.iter().map(trial).collect::<Result<Vec<_>, _>>()?;
        let place = record_worth("EBIC gamma", &trials, 0.0, &mut settled.choices);
        settled.selector = stricter(gammas[place]);
    }
    Ok(settled)
}

fn is_short(survey: &Survey) -> bool {
    survey.sample.n_rows() < BLOCKS * LEAST_ROWS
}

impl<'a> ModelSelection<'a> {
    fn start(survey: &'a Survey, options: &'a LibraryOptions, friction: Vec<FrictionTerm>) -> Self {
        let (library, selector) = (options.library, options.selector.clone());
        let kinds = options.kinds.all(survey.joints.len());
        Self { survey, options, kinds, library, friction, selector, choices: Vec::new() }
    }

    /// Candidates of a library with laws of friction, ready to be judged.
    fn validation(
        &self,
        library: LibraryKind,
        laws: Vec<FrictionTerm>,
    ) -> Result<CrossValidation<'a>, IdentifyError> {
        let candidates = Candidates::new(&self.kinds, library, self.options.regression, laws)?;
        CrossValidation::new(self.survey, candidates)
    }

    /// Adds joint angles to a term of an energy library whose order is open, one at a time, while
    /// held-out rows are predicted better.
    fn grow(&mut self) -> Result<Option<CrossValidation<'a>>, IdentifyError> {
        if self.options.library != (LibraryKind::Energy { interaction: None }) {
            return Ok(None);
        }
        let n = self.kinds.len();
        let (mut trials, mut validations) = (Vec::<CvScore>::new(), Vec::new());
        for order in 1..=n {
            let size = energy_library_size(&self.kinds, Some(order)) + self.friction.len();
            if order > 1 && size > MOST_CANDIDATES {
                break;
            }
            let library = LibraryKind::Energy { interaction: Some(order) };
            let validation = self.validation(library, self.friction.clone())?;
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
        let place = record_worth("joint angles in a term", &trials, 0.0, &mut self.choices);
        self.library = LibraryKind::Energy { interaction: Some(place + 1) };
        Ok(Some(validations.swap_remove(place)))
    }
}

/// Candidates with the normal equations of each block of time.
struct CrossValidation<'a> {
    survey: &'a Survey,
    candidates: Candidates,
    /// `[block][equation]`
    blocks: Vec<Vec<NormalEquations>>,
}

impl<'a> CrossValidation<'a> {
    fn new(survey: &'a Survey, candidates: Candidates) -> Result<Self, IdentifyError> {
        let (m, n) = (survey.sample.n_rows(), survey.joints.len());
        let prepared = PreparedDesign::cheaper(&candidates.design, n, m / BLOCKS);
        let of_block = |block| {
            let rows = survey.sample.select(&split(m, block).0);
            let rows = clear_of_reversals(&rows, &candidates.friction);
            let mut sums = RowAdder::new(&prepared);
            sums.push(samples_of(&rows, &candidates.friction)?)?;
            Ok(sums.finish()?.all_grams(&prepared))
        };
        let blocks = (0..BLOCKS).into_par_iter().map(of_block);
        let blocks = blocks.collect::<Result<_, IdentifyError>>()?;
        Ok(Self { survey, candidates, blocks })
    }

    /// Selects among all terms and some laws of friction, all of them by default, with each block
    /// left out, and judges the block by it.
    fn trial(
        &self,
        label: String,
        laws: Option<&Vec<FrictionTerm>>,
        selector: &Selector,
    ) -> Result<CvScore, IdentifyError> {
        let columns: Vec<usize> = (0..self.candidates.n_columns()).collect();
        let is_offered = |&column: &usize| match (laws, self.candidates.law(column)) {
            (Some(laws), Some(law)) => laws.contains(law),
            _ => true,
        };
        let offered: Vec<usize> = columns.iter().copied().filter(is_offered).collect();
        let complexity = offered.len();
        let step = Step { pattern: None, offered, columns };
        let errors = (0..BLOCKS).map(|block| self.error(block, &step, selector));
        let errors = errors.collect::<Result<_, _>>()?;
        Ok(CvScore { label, complexity, errors })
    }

    /// Geometric mean over the joints of RMSE on a block over the spread of the torque.
    fn error(&self, block: usize, step: &Step, selector: &Selector) -> Result<f64, SparseError> {
        let (judge, spread) = (&self.blocks[block], &self.survey.torque_std);
        let others = (0..BLOCKS).filter(|&other| other != block);
        let sum = |equation| others.clone().map(|other| &self.blocks[other][equation]).sum();
        let rest: Vec<NormalEquations> = (0..judge.len()).map(sum).collect();
        let of_group = |joints: &Vec<usize>| {
            let mut known = vec![0.0; self.candidates.n_columns()];
            step::take_step(step, &rest, (&self.candidates, joints), &mut known, selector)?;
            let moving = joints.iter().filter(|joint| spread[**joint] > 0.0);
            let error = |&joint: &usize| {
                let left = step::unexplained(judge, joint, &known);
                let rms = (left / of_joint(judge, joint).0.rows.max(1.0)).sqrt();
                (rms / spread[joint]).max(LEAST_ERROR).ln()
            };
            Ok(moving.map(error).collect::<Vec<f64>>())
        };
        let groups = self.candidates.groups();
        let errors = groups.par_iter().map(of_group);
        Ok(mean(&errors.collect::<Result<Vec<_>, SparseError>>()?.concat()).exp())
    }
}
