//! Summaries as bytes: versioned, checksummed, the same for the same logs.

use crate::framed::{damaged, framed, unframed};
use crate::summary::{Pass, Summary};
use torquewise_regression::normal_sums::FOLDS;
use torquewise_stepwise::error::IdentifyError;

/// First bytes of a file.
const MAGIC: [u8; 8] = *b"twmoment";

impl Summary {
    /// The summary as the bytes of a file.
    ///
    /// # Errors
    /// [`IdentifyError::Moments`] if it holds friction.
    pub fn to_bytes(&self) -> Result<Vec<u8>, IdentifyError> {
        self.settings.refuse_friction()?;
        framed(MAGIC, self)
    }

    /// The summary that [`Self::to_bytes`] wrote.
    ///
    /// # Errors
    /// [`IdentifyError::Moments`] if the bytes are not a summary, are of another version, or were
    /// damaged or cut short.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, IdentifyError> {
        let summary: Self = unframed(MAGIC, bytes)?;
        let Self { settings, survey, still, sums, pass, .. } = &summary;
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
        Ok(summary)
    }
}
