//! Rows of joint states, sorted by time.

use crate::bag::Messages;
use crate::bag::survey::{Aligned, Survey, decoded};
use crate::error::{Result, RowPlace};
use crate::log_input::LogInput;
use crate::rows::Rows;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// The rows of a bag: columns `t`, then `NAME.position` of each joint, then `NAME.velocity` and
/// `NAME.effort` where the messages have them.
pub(crate) struct BagRows {
    file: PathBuf,
    survey: Survey,
    names: Vec<String>,
    messages: Box<dyn Messages>,
    aligned: Aligned,
    chosen: Vec<usize>,
    in_order: InOrder,
    n_messages: u64,
    n_passed_over: u64,
    ended: bool,
    /// Number of the message that the row last read was.
    row: u64,
}

impl BagRows {
    pub(crate) fn open(file: &LogInput, survey: Survey) -> Result<Self> {
        let of_joints = |signal: &'static str| {
            survey.joints.iter().map(move |joint| format!("{joint}.{signal}"))
        };
        let mut names = vec!["t".to_owned()];
        names.extend(of_joints("position"));
        for (signal, is_known) in [("velocity", survey.has_velocity), ("effort", survey.has_effort)]
        {
            names.extend(of_joints(signal).filter(|_| is_known));
        }
        Ok(Self {
            file: file.into(),
            names,
            messages: survey.messages(file)?,
            aligned: Aligned::new(&survey.joints, survey.passes_over),
            survey,
            chosen: Vec::new(),
            in_order: InOrder::default(),
            n_messages: 0,
            n_passed_over: 0,
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
        while !self.ended && !self.in_order.is_full(self.chosen.len()) {
            let Some(message) = self.messages.next()? else {
                self.ended = true;
                break;
            };
            self.n_messages += 1;
            let (file, number) = (&self.file, self.n_messages);
            let place = || RowPlace { file: file.clone(), row: number, line: None };
            let state = decoded(&message.bytes, place)?;
            let Some(places) = self.aligned.find(&state, place)? else {
                self.n_passed_over += 1;
                continue;
            };
            let stamp = self.survey.stamp(&state, message.received);
            let n = places.len();
            let mut signals = vec![&state.position];
            signals.extend(self.survey.has_velocity.then_some(&state.velocity));
            signals.extend(self.survey.has_effort.then_some(&state.effort));
            let value = |column: &usize| match column.checked_sub(1) {
                None => stamp as f64 / 1e9,
                Some(k) => signals[k / n].get(places[k % n]).copied().unwrap_or(f64::NAN),
            };
            let values = self.chosen.iter().map(value).collect();
            self.in_order.push(stamp, number, values);
        }
        let Some(((_, number), values)) = self.in_order.waiting.pop_first() else {
            return Ok(false);
        };
        self.row = number;
        row.copy_from_slice(&values);
        Ok(true)
    }

    fn place(&self) -> RowPlace {
        RowPlace { file: self.file.clone(), row: self.row, line: None }
    }

    fn irregular(&self) -> [u64; 2] {
        [self.in_order.n_late, self.n_passed_over]
    }
}

/// Values that a window holds at most, about 16 MB; it is never shorter than 1 024 rows.
const WINDOW_VALUES: usize = 1 << 21;

/// Rows that wait until no earlier one can come.
#[derive(Debug, Default)]
struct InOrder {
    /// By time stamp \[ns\] and number of the message, 1 for the first.
    waiting: BTreeMap<(i64, u64), Vec<f64>>,
    latest: Option<i64>,
    /// Rows that came after one with a later stamp.
    n_late: u64,
}

impl InOrder {
    /// Whether a row may go out while others are still to come.
    fn is_full(&self, columns: usize) -> bool {
        self.waiting.len() >= (WINDOW_VALUES / (columns + 4)).clamp(1_024, 1 << 16)
    }

    fn push(&mut self, stamp: i64, number: u64, values: Vec<f64>) {
        self.n_late += u64::from(self.latest.is_some_and(|latest| stamp < latest));
        self.latest = self.latest.max(Some(stamp));
        self.waiting.insert((stamp, number), values);
    }
}

#[cfg(test)]
mod tests {
    use super::InOrder;

    #[test]
    fn a_window_is_bounded_whatever_the_width() {
        let mut rows = InOrder::default();
        for number in 0..1_024 {
            assert!(!rows.is_full(1_000_000));
            rows.push(0, number, Vec::new());
        }

        assert!(rows.is_full(1_000_000) && !rows.is_full(30));
    }
}
