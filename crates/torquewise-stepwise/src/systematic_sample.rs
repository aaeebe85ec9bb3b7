//! Every k-th of some records, k a power of two: even samples of logs that add up.

use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// Every k-th record of each log, k the least power of two that keeps all logs together within a
/// limit.
///
/// What is kept depends on the logs alone, not on the order in which they come or are merged. As
/// the first record of a log always stays, there are more than the limit once there are more logs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SystematicSample {
    most: usize,
    width: usize,
    stride: u64,
    logs: Vec<Kept>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Kept {
    places: Vec<u64>,
    values: Vec<f64>,
}

impl SystematicSample {
    pub(crate) fn new(width: usize, most: usize) -> Self {
        Self { most, width, stride: 1, logs: vec![Kept::default()] }
    }

    /// Hands over the record at a place of the log, which is made if it is to be kept.
    pub(crate) fn push<V: IntoIterator<Item = f64>>(
        &mut self,
        place: u64,
        values: impl FnOnce() -> V,
    ) {
        if let Some(log) = self.logs.last_mut().filter(|_| place.is_multiple_of(self.stride)) {
            log.places.push(place);
            log.values.extend(values());
            self.thin();
        }
    }

    /// Whether a record at this place is kept so far.
    pub(crate) fn is_sampled(&self, place: u64) -> bool {
        place.is_multiple_of(self.stride)
    }

    pub(crate) fn merge(&mut self, other: &Self) {
        let mut other = other.clone();
        let stride = self.stride.max(other.stride);
        self.thin_to(stride);
        other.thin_to(stride);
        self.logs.append(&mut other.logs);
        self.thin();
    }

    fn thin(&mut self) {
        while self.len() > self.most && self.logs.iter().any(|log| log.places.len() > 1) {
            self.thin_to(2 * self.stride);
        }
    }

    fn thin_to(&mut self, stride: u64) {
        if stride == self.stride {
            return;
        }
        self.stride = stride;
        for log in &mut self.logs {
            let records = log.places.iter().zip(log.values.chunks_exact(self.width.max(1)));
            let kept = records.filter(|(place, _)| place.is_multiple_of(stride));
            let (places, values): (Vec<u64>, Vec<&[f64]>) = kept.unzip();
            *log = Kept { places, values: values.concat() };
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.logs.iter().map(|log| log.places.len()).sum()
    }

    /// Puts the logs in an order that depends on what they hold alone.
    pub(crate) fn sort(&mut self) {
        self.logs.retain(|log| !log.places.is_empty());
        self.logs.sort_by(|a, b| {
            let pairs = a.values.iter().zip(&b.values).map(|(a, b)| a.total_cmp(b));
            pairs.fold(Ordering::Equal, Ordering::then).then(a.values.len().cmp(&b.values.len()))
        });
    }

    pub(crate) fn records(&self) -> impl Iterator<Item = &[f64]> {
        self.logs.iter().flat_map(|log| log.values.chunks_exact(self.width.max(1)))
    }

    /// Whether it is of records of this many numbers and holds what it should.
    pub(crate) fn is_sound(&self, width: usize, most: usize) -> bool {
        let whole = |log: &Kept| log.values.len() == width * log.places.len();
        let finite = |log: &Kept| log.values.iter().all(|value| value.is_finite());
        self.width == width
            && self.most == most
            && self.stride.is_power_of_two()
            && self.logs.iter().all(|log| whole(log) && finite(log))
    }
}

#[cfg(test)]
mod tests {
    use super::SystematicSample;

    fn log(first: f64, count: u32) -> SystematicSample {
        let mut even = SystematicSample::new(2, 100);
        (0..count).for_each(|k| even.push(k.into(), || [first + f64::from(k), 0.5]));
        even
    }

    #[test]
    fn what_is_kept_does_not_depend_on_the_order() {
        let logs = [log(0.0, 90), log(1e3, 1), log(2e3, 777), log(3e3, 130)];
        let together = |order: [usize; 4]| {
            let mut all = logs[order[0]].clone();
            order[1..].iter().for_each(|&k| all.merge(&logs[k]));
            all.sort();
            all
        };

        let one = together([0, 1, 2, 3]);
        assert_eq!(one, together([3, 1, 0, 2]));
        let (mut left, mut right) = (logs[3].clone(), logs[0].clone());
        left.merge(&logs[1]);
        right.merge(&logs[2]);
        right.merge(&left);
        right.sort();
        assert_eq!(one, right);
        // 998 records: every 16th of each log, 63 and a bit.
        assert_eq!((one.stride, one.len()), (16, 6 + 1 + 49 + 9));
    }

    #[test]
    fn many_logs_take_no_more_room_than_is_kept() {
        let mut all = log(0.0, 100);
        (1..200).for_each(|k| all.merge(&log(f64::from(k), 100)));

        let room: usize = all.logs.iter().map(|log| log.values.capacity()).sum();

        assert_eq!(all.len(), 200);
        assert!(room <= 4 * 2 * all.len(), "{room} numbers");
    }

    #[test]
    fn a_single_log_keeps_its_order() {
        let even = log(0.0, 101);
        let firsts: Vec<f64> = even.records().map(|record| record[0]).collect();
        assert_eq!(firsts.len(), 51);
        assert!(firsts.windows(2).all(|pair| (pair[1] - pair[0] - 2.0).abs() < 1e-12));
    }
}
