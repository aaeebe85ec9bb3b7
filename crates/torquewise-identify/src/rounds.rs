//! A chain in rounds: a search on a sample, then passes over every row (E8) (E11).
//!
//! A [`Request`] is all that the next pass needs. It can be saved, so that the logs of a pass may
//! be read apart and their sums merged.

use crate::estimate::{Passes, refine, weights};
use crate::learn::{LAST_ROWS, Learned, learn};
use crate::regions::Regions;
use crate::{AT_REST, ChainOptions, Fitted, Linearisation, Progress, Sizes, Warning, Watch};
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;
use torquewise_model::{Choice, GeometryFound};
use torquewise_regression::NormalSums;
use torquewise_regression::normal_sums::FOLDS;
use torquewise_stepwise::{IdentifyError, Survey, thinned};

/// Passes over all rows at most.
const MOST_PASSES: usize = 5;
/// Rows of a block of time, of which there should be many.
const BLOCK_ROWS: [usize; 2] = [16, 256];
/// Blocks that a log should have.
const BLOCKS: usize = 100;
/// First bytes of the file of a request.
const REQUEST: [u8; 8] = *b"twreques";

/// A chain as it was searched on the sample of a survey.
pub(crate) struct Searched<'a> {
    survey: &'a Survey,
    options: &'a ChainOptions,
    pub(crate) learned: Learned,
    pub(crate) at: Linearisation,
}

impl<'a> Searched<'a> {
    /// - `filtered`, `seed`: whether the logs are filtered, and a seed
    /// - `before`: the same arm at another bandwidth, whose joints stay what they were found to be
    pub(crate) fn of(
        survey: &'a Survey,
        options: &'a ChainOptions,
        (filtered, seed): (bool, u64),
        before: Option<Learned>,
        watch: Watch<'_>,
    ) -> Result<Self, IdentifyError> {
        Progress::Geometry.tell(watch)?;
        let learned = learn(&survey.sample, options, (seed, before), watch)?;
        let sample = thinned(&survey.sample, LAST_ROWS);
        let Learned { chain, spec, laws, .. } = &learned;
        let rest = if spec.has_friction() { AT_REST } else { 0.0 };
        let rest = laws.width.iter().map(|width| rest * width).collect();
        let at = Linearisation::of(chain, (spec.drive.clone(), &chain.drive), rest);
        // The noise of filtered rows is not white: it is drawn before the filter.
        let is_white = options.noise_correction && !filtered;
        let at = Linearisation {
            weights: weights(&chain.residual_rms, &Sizes::of(survey)),
            robot: options.geometry.as_ref().and_then(|known| known.robot.clone()),
            free: spec.free.clone(),
            noise: if is_white { survey.noise.clone() } else { at.noise },
            raw_noise: options.noise_correction && filtered,
            regions: Regions::of(&sample, FOLDS),
            seed,
            ..at
        };
        let at = cut_for(at.scaled_by(&sample)?, sample.n_rows());
        Ok(Self { survey, options, learned, at })
    }

    /// Refines it on the sample, and asks for the first pass over all rows.
    pub(crate) fn refined(self, watch: Watch<'_>) -> Result<Request, IdentifyError> {
        let Self { survey, options, learned, at } = self;
        Progress::Refit.tell(watch)?;
        let (sizes, sample) = (Sizes::of(survey), thinned(&survey.sample, LAST_ROWS));
        let (at, mut searched_part) = refine(&sample, &at, &sizes, watch)?;
        // Of a joint that never moves nothing is told.
        survey.constant_joints().into_iter().for_each(|joint| searched_part[joint] = 0.0);
        let at = at.widened(&learned.offered, &sample)?;
        let mut passes = Passes::over_all(cut_for(at, survey.rows), MOST_PASSES);
        passes.may_release = options.geometry.is_none();
        let Learned { choices, found, .. } = learned;
        let joints = survey.joints.clone();
        let searched_rms = Vec::new();
        Ok(Request { joints, passes, sizes, choices, found, searched_part, searched_rms })
    }
}

/// What a pass over the logs is asked for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Request {
    joints: Vec<String>,
    pub(crate) passes: Passes,
    pub(crate) sizes: Sizes,
    choices: Vec<Choice>,
    found: Option<GeometryFound>,
    /// What the search left of each joint over what the chain of the first pass does, n; 0 where that
    /// is not asked.
    searched_part: Vec<f64>,
    /// The same \[N·m\], in the band of the logs; empty before their first pass.
    searched_rms: Vec<f64>,
}

impl Request {
    /// The same for logs of so many rows.
    pub(crate) fn over(mut self, rows: usize) -> Self {
        self.passes.at = cut_for(self.passes.at, rows);
        self
    }

    /// Its identity: the pass it is for, and a checksum.
    pub fn name(&self) -> String {
        let bytes = postcard::to_stdvec(self).unwrap_or_default();
        format!("pass {} ({:08x})", self.pass(), crc32fast::hash(&bytes))
    }

    /// The pass over the logs that is asked for, counted from 1.
    pub fn pass(&self) -> usize {
        self.passes.made + 1
    }

    /// Fails unless it is for an arm of these joints.
    pub(crate) fn check_joints(&self, joints: &[String]) -> Result<(), IdentifyError> {
        if joints == self.joints {
            return Ok(());
        }
        let (expected, found) = (self.joints.join(", "), joints.join(", "));
        Err(IdentifyError::Apart { what: "joints", expected, found })
    }

    /// The request as the bytes of a file.
    ///
    /// # Errors
    /// [`IdentifyError::Moments`] if it cannot be written.
    pub fn to_bytes(&self) -> Result<Vec<u8>, IdentifyError> {
        crate::framed::framed(REQUEST, self)
    }

    /// The request that [`Self::to_bytes`] wrote.
    ///
    /// # Errors
    /// [`IdentifyError::Moments`] if the bytes are no request or were damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, IdentifyError> {
        let request: Self = crate::framed::unframed(REQUEST, bytes)?;
        if request.passes.at.is_sound(request.joints.len()) {
            return Ok(request);
        }
        Err(IdentifyError::Moments("its parts do not fit each other".into()))
    }

    /// Takes the step that a pass asks for, and asks for another; breaks where it is next to nothing.
    pub(crate) fn take(
        mut self,
        sums: &NormalSums,
    ) -> Result<ControlFlow<Fitted, Self>, IdentifyError> {
        if self.searched_rms.is_empty() {
            let left = self.searched_part.iter().zip(sums.weighted_rms());
            self.searched_rms = left.map(|(part, rms)| part * rms).collect();
        }
        Ok(match self.passes.clone().take(sums, &self.sizes)? {
            ControlFlow::Continue(passes) => ControlFlow::Continue(Self { passes, ..self }),
            ControlFlow::Break(solved) => {
                let residual_rms = sums.residual_rms();
                let mut spread = residual_rms.iter().zip(&self.sizes.torque);
                let at = &self.passes.at;
                let is_corrected = at.raw_noise || !at.noise.is_none();
                if is_corrected && spread.any(|(rms, std)| rms > std) {
                    // So much noise that correcting for it leaves nothing to solve.
                    let passes = self.passes.without_noise_correction(MOST_PASSES);
                    return Ok(ControlFlow::Continue(Self { passes, ..self }));
                }
                let Self { choices, found, searched_rms, sizes, .. } = self;
                let left = sums.weighted_rms();
                let warning = Warning::of_refit(&searched_rms, &left, &sizes.torque);
                ControlFlow::Break(Fitted { solved, sizes, residual_rms, choices, found, warning })
            }
        })
    }
}

/// Blocks for a log of so many rows.
fn cut_for(at: Linearisation, rows: usize) -> Linearisation {
    let [least, most] = BLOCK_ROWS;
    let block_rows = (rows / BLOCKS).next_power_of_two().clamp(least, most);
    Linearisation { block_rows, ..at }
}
