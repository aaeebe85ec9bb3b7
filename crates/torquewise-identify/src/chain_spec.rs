//! Block cross-validation of one chain specification.

use crate::drive_terms::Gravity;
use crate::learn::residual_rms;
use crate::{DriveTerm, geometric_mean};
use rayon::prelude::*;
use torquewise_rigid::search::SearchWatch;
use torquewise_rigid::{Chain, ChainRows, Search, refine};
use torquewise_stepwise::IdentifyError;
use torquewise_stepwise::held_out::{BLOCKS, CvScore, split};

pub(crate) use torquewise_stepwise::held_out::record_worth;

/// What a fit is made of, beside the geometry.
#[derive(Clone, Debug)]
pub(crate) struct ChainSpec {
    pub(crate) drive: Vec<DriveTerm>,
    pub(crate) search: Search,
    /// Parameters of the geometry that move.
    pub(crate) free: Vec<usize>,
    /// What friction under load is in proportion to: that of the chain so far.
    pub(crate) gravity: Option<Gravity>,
}

impl ChainSpec {
    pub(crate) fn has_friction(&self) -> bool {
        self.drive.iter().any(|drive| matches!(drive, DriveTerm::Friction(_)))
    }
}

/// Errors below this are rounding.
const LEAST_ERROR: f64 = 1e-12;

/// Rounds of refinement on all but a held-out block.
const ROUNDS: usize = 6;

/// Fits a specification with each block left out, and scores it there.
pub(crate) fn trial(
    label: String,
    spec: &ChainSpec,
    rows: &ChainRows,
    start: &Chain,
    watch: SearchWatch<'_>,
) -> Result<CvScore, IdentifyError> {
    let search = Search { rounds: ROUNDS, weighings: 1, ..spec.search.clone() };
    let errors = (0..BLOCKS)
        .into_par_iter()
        .map(|block| {
            let (held, rest) = split(rows.len(), block);
            let chain = refine(&rows.select(&rest), start, &spec.free, &search, watch)?;
            Ok(error(&chain, &rows.select(&held), rows))
        })
        .collect::<Result<Vec<f64>, IdentifyError>>()?;
    let complexity = start.inertial.len() + spec.drive.len();
    Ok(CvScore { label, complexity, errors })
}

/// Geometric mean over the joints of RMSE on `held` over the spread of the torque in `all`: a joint
/// whose torque is mostly noise counts no more than the others.
pub(crate) fn error(chain: &Chain, held: &ChainRows, all: &ChainRows) -> f64 {
    let errors = residual_rms(chain, held).into_iter().enumerate();
    let parts: Vec<f64> = errors
        .map(|(joint, rms)| (rms, all.deviation_of(joint)))
        .filter(|(_, spread)| *spread > 0.0)
        .map(|(rms, spread)| (rms / spread).max(LEAST_ERROR))
        .collect();
    geometric_mean(&parts)
}
