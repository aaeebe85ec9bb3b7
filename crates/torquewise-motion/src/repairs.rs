//! What was repaired in a log before its rows became motion.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::iter::Sum;

/// What was left out of a log, replaced in it or moved, and where it was split (E12).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Repairs {
    /// Rows left out since they had the time stamp of the row before.
    pub repeated_stamps: u64,
    /// Rows left out since their time stamp was earlier than that of a row before.
    pub earlier_stamps: u64,
    /// Rows left out since a value was missing, NaN or infinite.
    pub not_finite: u64,
    /// Rows left out since a value, or their stamp, was absurd: far beyond its neighbours.
    pub absurd: u64,
    /// Rows left out since they were all zeros and the arm was elsewhere before: what they held was lost.
    pub zeros: u64,
    /// Rows left out since they repeated the row before: the device was slower than its logger, or did
    /// not answer.
    pub held_rows: u64,
    /// Rows left out since their trajectory was too short for the filter.
    pub too_short: u64,
    /// Values replaced since they were spikes, by signal: q, dq, ddq, tau.
    pub spikes: BTreeMap<String, u64>,
    /// Jumps of positions by whole turns that were taken out: they were wrapped.
    pub whole_turns: u64,
    /// Time stamps of late receipt that were put on the clock of the device.
    pub late_stamps: u64,
    /// Gaps of over two usual steps that were interpolated.
    pub gaps: u64,
    /// The longest of them \[s\].
    pub longest_gap: f64,
    /// Gaps that were too long for that: the log was split there.
    pub splits: u64,
}

impl Repairs {
    /// Whether nothing was done.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Counts values that were replaced in a signal.
    pub fn add_spikes(&mut self, signal: &str, count: u64) {
        if count > 0 {
            *self.spikes.entry(signal.to_owned()).or_default() += count;
        }
    }

    /// Counts a gap that was interpolated \[s\].
    pub fn add_gap(&mut self, seconds: f64) {
        self.gaps += 1;
        self.longest_gap = self.longest_gap.max(seconds);
    }

    /// Adds what else was repaired; of gaps the longest stays.
    pub fn add(&mut self, other: &Self) {
        self.repeated_stamps += other.repeated_stamps;
        self.earlier_stamps += other.earlier_stamps;
        self.not_finite += other.not_finite;
        self.absurd += other.absurd;
        self.zeros += other.zeros;
        self.held_rows += other.held_rows;
        self.too_short += other.too_short;
        other.spikes.iter().for_each(|(signal, &count)| self.add_spikes(signal, count));
        self.whole_turns += other.whole_turns;
        self.late_stamps += other.late_stamps;
        self.gaps += other.gaps;
        self.longest_gap = self.longest_gap.max(other.longest_gap);
        self.splits += other.splits;
    }
}

fn told(counts: &[(u64, &str, &str)]) -> Vec<String> {
    let any = counts.iter().filter(|(count, ..)| *count > 0);
    any.map(|(count, noun, what)| counted(*count, noun, what)).collect()
}

/// `2 rows left out`, `1 row left out`: so many of a noun, whose plural has an s more, and what of them.
pub fn counted(count: u64, noun: &str, what: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{plural} {what}")
}

impl<'a> Sum<&'a Self> for Repairs {
    fn sum<I: Iterator<Item = &'a Self>>(all: I) -> Self {
        let mut sum = Self::default();
        all.for_each(|one| sum.add(one));
        sum
    }
}

impl fmt::Display for Repairs {
    /// Rows left out, then what was changed in the others; nothing if nothing was done.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let left_out = told(&[
            (self.repeated_stamps, "row", "with the time stamp of the row before"),
            (self.earlier_stamps, "row", "with an earlier time stamp than a row before"),
            (self.not_finite, "row", "without a number"),
            (self.absurd, "row", "with a value far beyond its neighbours"),
            (self.zeros, "row", "of zeros alone, far from where the arm was"),
            (self.held_rows, "row", "that repeat the one before, though the joints move"),
            (self.too_short, "row", "of trajectories too short for the filter"),
        ]);
        let spikes: u64 = self.spikes.values().sum();
        let by_signal: Vec<String> =
            self.spikes.iter().map(|(signal, count)| format!("{signal} {count}")).collect();
        let longest = 1e3 * self.longest_gap;
        let repaired = told(&[
            (spikes, "spike", &format!("replaced ({})", by_signal.join(", "))),
            (self.whole_turns, "jump", "of a position by whole turns taken out"),
            (self.gaps, "gap", &format!("bridged (the longest {longest:.1} ms)")),
            (self.late_stamps, "late time stamp", "put on the clock of the device"),
            (self.splits, "longer gap", "at which a log was split"),
        ]);
        let parts = [("left out", left_out), ("repaired", repaired)];
        let sentence =
            |(what, parts): &(&str, Vec<String>)| format!("{what}: {}", parts.join(", "));
        let any = parts.iter().filter(|(_, parts)| !parts.is_empty());
        f.write_str(&any.map(sentence).collect::<Vec<_>>().join("; "))
    }
}

#[cfg(test)]
mod tests {
    use super::Repairs;

    fn spoilt() -> Repairs {
        let mut repairs =
            Repairs { repeated_stamps: 3, whole_turns: 1, splits: 1, ..Repairs::default() };
        repairs.add_spikes("tau", 12);
        repairs.add_spikes("q", 0);
        repairs.add_gap(0.008);
        repairs
    }

    #[test]
    fn repairs_of_logs_add_up_and_two_sentences_tell_them() {
        let mut other = Repairs { held_rows: 7, ..Repairs::default() };
        other.add_spikes("tau", 1);
        other.add_gap(0.02);
        let mut none = Repairs::default();

        let sum: Repairs = [spoilt(), other].iter().sum();
        none.add(&Repairs::default());

        assert_eq!((sum.repeated_stamps, sum.held_rows, sum.gaps, sum.splits), (3, 7, 2, 1));
        assert_eq!((sum.spikes["tau"], sum.spikes.len(), sum.longest_gap), (13, 1, 0.02));
        assert!(none.is_none() && !spoilt().is_none(), "a longest gap of zero is none");
        assert_eq!(
            spoilt().to_string(),
            "left out: 3 rows with the time stamp of the row before; repaired: 12 spikes replaced \
             (tau 12), 1 jump of a position by whole turns taken out, 1 gap bridged (the longest 8.0 ms), 1 longer gap at which a log was split"
        );
        assert!(Repairs::default().to_string().is_empty());
    }
}
