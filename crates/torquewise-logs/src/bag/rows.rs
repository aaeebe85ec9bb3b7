//! Rows of joint states, sorted by time.

use crate::bag::survey::{JointStates, Survey};
use crate::{LogInput, Result, RowPlace, Rows};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// The rows of a bag: columns `t`, then `NAME.position` of each joint, then `NAME.velocity` and
/// `NAME.effort` where the messages have them.
pub(crate) struct BagRows {
    file: PathBuf,
    survey: Survey,
    names: Vec<String>,
    states: JointStates,
    chosen: Vec<usize>,
    /// Rows until no earlier one can come, by time stamp \[ns\] and number of the message.
    waiting: BTreeMap<(i64, u64), Vec<f64>>,
    ended: bool,
    /// Number of the message that the row last read was.
    row: u64,
}

impl BagRows {
    pub(crate) fn open(file: &LogInput, survey: Survey) -> Result<Self> {
        let (velocity, effort) = (("velocity", survey.has_velocity), ("effort", survey.has_effort));
        let mut names = vec!["t".to_owned()];
        for (signal, _) in [("position", true), velocity, effort].iter().filter(|own| own.1) {
            names.extend(survey.joints.iter().map(|joint| format!("{joint}.{signal}")));
        }
        Ok(Self {
            file: file.into(),
            names,
            states: survey.states(file)?,
            survey,
            chosen: Vec::new(),
            waiting: BTreeMap::new(),
            ended: false,
            row: 0,
        })
    }
}

impl Rows for BagRows {
    fn header(&self) -> (&[String], Option<&[String]>) {
        (&self.names, Some(&self.survey.joints))
    }

    fn choose(&mut self, columns: &[usize]) -> Result<()> {
        self.chosen = columns.to_vec();
        Ok(())
    }

    fn next(&mut self, row: &mut [f64]) -> Result<bool> {
        // Messages are read until the next row in order is known.
        while !self.ended && self.waiting.len() < window(self.chosen.len()) {
            let Some((state, received)) = self.states.next()? else {
                self.ended = true;
                break;
            };
            let stamp = self.survey.stamp(&state, received);
            let places = &self.states.places;
            let n = places.len();
            let mut signals = vec![&state.position];
            signals.extend(self.survey.has_velocity.then_some(&state.velocity));
            signals.extend(self.survey.has_effort.then_some(&state.effort));
            let value = |column: &usize| match column.checked_sub(1) {
                None => stamp as f64 / 1e9,
                Some(k) => signals[k / n].get(places[k % n]).copied().unwrap_or(f64::NAN),
            };
            let values = self.chosen.iter().map(value).collect();
            self.waiting.insert((stamp, self.states.n_messages), values);
        }
        let Some(((_, number), values)) = self.waiting.pop_first() else {
            return Ok(false);
        };
        self.row = number;
        row.copy_from_slice(&values);
        Ok(true)
    }

    fn place(&self) -> RowPlace {
        RowPlace { file: self.file.clone(), row: self.row, line: None }
    }
}

/// Values that a window holds at most, about 16 MB; it is never shorter than 1 024 rows.
const WINDOW_VALUES: usize = 1 << 21;

/// Rows that wait at most.
fn window(columns: usize) -> usize {
    (WINDOW_VALUES / (columns + 4)).clamp(1_024, 1 << 16)
}

#[cfg(test)]
mod tests {
    use super::window;

    #[test]
    fn a_window_is_bounded_whatever_the_width() {
        assert_eq!(window(1_000_000), 1_024);
        assert!(window(30) > 1_024);
    }
}
