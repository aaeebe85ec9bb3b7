//! Which columns are summed, and these made ready.

use crate::candidates::Candidates;
use crate::error::IdentifyError;
use crate::friction::FrictionKind;
use crate::model_selection::choose_laws;
use crate::plan::{LibraryKind, LibraryOptions, Regression};
use crate::progress::Progress;
use crate::survey::survey;
use serde::{Deserialize, Serialize};
use torquewise_model::FrictionTerm;
use torquewise_model::model::Choice;
use torquewise_motion::{Pattern, Recording};
use torquewise_regression::row_sums::Prepared;

/// Which columns are summed, and over which rows together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SummedLibrary {
    /// Candidates.
    pub kind: LibraryKind,
    /// One-shot or stepwise: one sum over all rows, or one for each pattern.
    pub regression: Regression,
    /// Laws of friction among the candidates. They follow from the speeds of all logs together, so
    /// that summaries with friction are neither written nor merged.
    #[serde(skip)]
    pub friction: Vec<FrictionTerm>,
}

/// The candidates of a library, made ready to be summed.
pub struct Basis {
    /// The terms offered.
    pub candidates: Candidates,
    /// Their columns, as sums over rows want them.
    pub prepared: Prepared,
}

/// Rows that the route to the sums is chosen for. One number for all logs, lest parts of different
/// size use different routes and do not add up.
const USUAL_ROWS: usize = 1 << 18;

impl SummedLibrary {
    /// The library of a fit with laws of friction that suit a recording, and how these were chosen.
    ///
    /// # Errors
    /// [`IdentifyError`]: the reader's message, missing torque, or a library too large.
    pub fn of(
        recording: &(impl Recording + ?Sized),
        options: &LibraryOptions,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<(Self, Vec<Choice>), IdentifyError> {
        let LibraryOptions { library: kind, regression, friction, .. } = *options;
        let (friction, choices) = if friction == FrictionKind::None {
            (Vec::new(), Vec::new())
        } else {
            progress(Progress::Survey);
            let survey = survey(recording)?;
            survey.sample.require_tau()?;
            choose_laws(&survey, options)?
        };
        Ok((Self { kind, regression, friction }, choices))
    }

    /// Its candidates for n joints.
    ///
    /// # Errors
    /// [`IdentifyError::LibraryTooLarge`] if its sums would not fit into memory.
    pub fn basis(&self, n_joints: usize) -> Result<Basis, IdentifyError> {
        let laws = self.friction.clone();
        let candidates = Candidates::new(n_joints, self.kind, self.regression, laws)?;
        let prepared = Prepared::cheaper(&candidates.design, n_joints, USUAL_ROWS);
        Ok(Basis { candidates, prepared })
    }

    /// The patterns whose rows are summed apart; `None` stands for all rows.
    pub fn parts(&self) -> Vec<Option<Pattern>> {
        match self.regression {
            Regression::Stepwise => Pattern::ALL.map(Some).into(),
            Regression::OneShot => vec![None],
        }
    }
}
