//! Which columns give which signal in SI units, multiplied by what and added.

use torquewise_motion::Signal;

#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Mapping {
    pub(crate) n_joints: usize,
    /// Signals that rows have, in the order of [`Signal::ALL`]: the slots of a row are t, then q1…qn,
    /// then dq, ddq and tau as far as they are known.
    pub(crate) present: Vec<Signal>,
    /// The columns of the file that are read, in the order they are read.
    pub(crate) chosen: Vec<usize>,
    pub(crate) time: Time,
    /// One per slot after t.
    pub(crate) slots: Vec<Slot>,
    /// First and last rows that are read, 1 for the first of the file; all if it is empty.
    pub(crate) rows: Vec<[u64; 2]>,
    /// Begins and ends \[s\] of what is read, 0 for the first row of the file; all if it is empty.
    pub(crate) seconds: Vec<[f64; 2]>,
    pub(crate) joints: Option<Vec<String>>,
    /// Columns with names that mean nothing here.
    pub(crate) ignored: Vec<String>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Time {
    /// The first chosen column, in units of so many seconds.
    Column(f64),
    /// The number of the row, at so many rows per second.
    Rate(f64),
}

impl Default for Time {
    fn default() -> Self {
        Self::Column(1.0)
    }
}

/// A value of a row: Σ factor · column + offset.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Slot {
    pub(crate) terms: Vec<(usize, f64)>,
    pub(crate) offset: f64,
}

impl Mapping {
    pub(crate) fn n_slots(&self) -> usize {
        1 + self.present.len() * self.n_joints
    }

    pub(crate) fn forget(&mut self, signal: Signal) {
        if let Some(first) = self.slot(signal) {
            self.slots.drain(first - 1..first - 1 + self.n_joints);
            self.present.retain(|present| *present != signal);
        }
    }

    /// The slot of joint 1 of a signal; the other joints follow.
    pub(crate) fn slot(&self, signal: Signal) -> Option<usize> {
        let place = self.present.iter().position(|present| *present == signal)?;
        Some(1 + place * self.n_joints)
    }

    /// The trajectory of a row, by the ranges it is in; `None` if it is in none.
    pub(crate) fn part(&self, row: u64, seconds: f64) -> Option<usize> {
        let of_rows = place(&self.rows, row)?;
        let of_seconds = place(&self.seconds, seconds)?;
        Some(of_rows * self.seconds.len().max(1) + of_seconds)
    }
}

impl Slot {
    /// A column that is in SI units already.
    pub(crate) fn as_it_stands(place: usize) -> Self {
        Self { terms: vec![(place, 1.0)], offset: 0.0 }
    }

    pub(crate) fn value(&self, row: &[f64]) -> f64 {
        let products = self.terms.iter().map(|(place, factor)| row[*place] * factor);
        let sum = products.reduce(|sum, product| sum + product).unwrap_or(0.0);
        // 0 is not added, for it would turn -0 into 0.
        if self.offset == 0.0 { sum } else { sum + self.offset }
    }
}

fn place<T: PartialOrd + Copy>(ranges: &[[T; 2]], value: T) -> Option<usize> {
    if ranges.is_empty() {
        return Some(0);
    }
    ranges.iter().position(|[first, last]| *first <= value && value <= *last)
}

#[cfg(test)]
mod tests {
    use super::Mapping;

    #[test]
    fn rows_belong_to_the_ranges_they_are_in() {
        let (rows, seconds) = (vec![[2, 3], [5, 9]], vec![[0.0, 0.4], [0.6, 1.0]]);
        let ranges = Mapping { rows, seconds, ..Mapping::default() };

        let parts: Vec<_> = (1..=9).map(|row| ranges.part(row, 0.1 * row as f64)).collect();

        assert_eq!(parts[..3], [None, Some(0), Some(0)]);
        assert_eq!(parts[3..], [None, None, Some(3), Some(3), Some(3), Some(3)]);
        assert_eq!(Mapping::default().part(7, -1.0), Some(0));
    }
}
