//! Gaps in time, where one trajectory ends and the next begins.

use torquewise_motion::median;

/// Steps that the first estimate of the usual step is the median of.
pub(crate) const FIRST_STEPS: usize = 32;

/// A longer step than this many usual ones is a gap, …
const GAP_STEPS: f64 = 5.0;
/// … if it is also longer than this \[s\]: a motion of a few hertz bridges shorter ones.
const LEAST_GAP: f64 = 0.06;

/// How far one step moves the usual step.
const GAIN: f64 = 1.01;

/// The usual step between two rows of a trajectory.
///
/// It begins as the median of the trajectory's first 32 steps (the larger of two middle ones); each
/// later step that is longer raises it by 1 %, each shorter one lowers it as much, so that it stays
/// near the median. It depends on the time stamps alone, not on how they are read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct UsualStep(pub(crate) f64);

impl UsualStep {
    /// From the first time stamps of a trajectory; those after the first 33 are not looked at.
    pub(crate) fn new(t: &[f64]) -> Self {
        let mut steps: Vec<f64> =
            t.windows(2).take(FIRST_STEPS).map(|pair| pair[1] - pair[0]).collect();
        Self(if steps.is_empty() { f64::INFINITY } else { median(&mut steps) })
    }

    /// Whether `step` is a gap; if not, it is learned from.
    pub(crate) fn is_gap(&mut self, step: f64) -> bool {
        if step > (GAP_STEPS * self.0).max(LEAST_GAP) {
            return true;
        }
        if step > self.0 {
            self.0 *= GAIN;
        } else if step < self.0 {
            self.0 /= GAIN;
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::UsualStep;

    #[test]
    fn long_steps_are_gaps_and_short_pauses_drift_and_jitter_are_none() {
        let with = |place: usize, step: f64| {
            let mut steps = vec![0.001; 200];
            steps[place] = step;
            steps
        };
        let after = |first: f64| std::iter::once(first).chain([0.01; 40]).collect();
        let drift = (0..2_000).map(|row| 0.001 * 10_f64.powf(f64::from(row) / 1_000.0));
        let jitter = (0..500).map(|row| 0.01 + 0.005 * f64::from(row * row).sin());
        let cases: [(&str, Vec<f64>, &[usize]); 8] = [
            ("four usual steps", with(50, 0.004), &[]),
            ("over 60 ms", with(120, 0.061), &[121]),
            ("a short pause", with(50, 0.05), &[]),
            ("a gap at the start", after(10.0), &[1]),
            ("a short step at the start", after(1e-9), &[]),
            ("a rate that drifts tenfold", drift.collect(), &[]),
            ("jitter of half a step", jitter.collect(), &[]),
            ("no step at all", Vec::new(), &[]),
        ];
        for (what, steps, expected) in cases {
            let mut t = vec![7.0];
            t.extend(steps.into_iter().scan(7.0, |t, step| {
                *t += step;
                Some(*t)
            }));
            let mut usual = UsualStep::new(&t);
            let gaps = (1..t.len()).filter(|row| usual.is_gap(t[*row] - t[row - 1]));
            assert_eq!(gaps.collect::<Vec<_>>(), expected, "{what}");
        }
    }
}
