//! Summaries as bytes: versioned, checksummed, the same for the same logs.

use crate::framed::{damaged, framed, unframed};
use crate::settings::Settings;
use crate::summary::{Pass, Summary};
use serde::{Deserialize, Serialize};
use torquewise_regression::normal_sums::FOLDS;
use torquewise_regression::row_sums::RowSums;
use torquewise_stepwise::error::IdentifyError;
use torquewise_stepwise::noise::NoiseSum;
use torquewise_stepwise::survey::SurveySum;

/// First bytes of a file.
const MAGIC: [u8; 8] = *b"twmoment";

/// A summary as it is written.
#[derive(Serialize, Deserialize)]
struct Saved {
    settings: Settings,
    logs: usize,
    survey: SurveySum,
    still: NoiseSum,
    sums: Vec<RowSums>,
    pass: Option<Pass>,
}

impl Summary {
    /// The summary as the bytes of a file.
    ///
    /// # Errors
    /// [`IdentifyError::Moments`] if it holds friction.
    pub fn to_bytes(&self) -> Result<Vec<u8>, IdentifyError> {
        self.settings.refuse_friction()?;
        let saved = Saved {
            settings: self.settings.clone(),
            logs: self.logs,
            survey: self.survey.clone(),
            still: self.still.clone(),
            sums: self.sums.clone(),
            pass: self.pass.clone(),
        };
        framed(MAGIC, &saved)
    }

    /// The summary that [`Self::to_bytes`] wrote.
    ///
    /// # Errors
    /// [`IdentifyError::Moments`] if the bytes are not a summary, are of another version, or were
    /// damaged or cut short.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, IdentifyError> {
        let Saved { settings, logs, survey, still, sums, pass } = unframed(MAGIC, bytes)?;
        let n = settings.joints.len();
        let fits = settings.joints == survey.joints()
            && survey.is_sound()
            && still.is_sound(n)
            && sums.len() == settings.parts().len();
        let is_sound = |pass: &Pass| {
            let at = pass.request.linearisation();
            at.is_sound(n) && pass.sums.is_sound(at.n_parameters(), n, FOLDS)
        };
        if !fits || !pass.as_ref().is_none_or(is_sound) {
            return Err(damaged("its parts do not fit each other"));
        }
        let basis = settings.basis()?;
        let prepared = basis.as_ref().map(|basis| &basis.prepared);
        if !sums.iter().all(|sums| prepared.is_some_and(|own| sums.is_sound(own))) {
            return Err(damaged("its sums are not those of its library"));
        }
        Ok(Self { settings, logs, survey, still, sums, choices: Vec::new(), pass })
    }
}
