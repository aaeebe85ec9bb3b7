//! From time stamps to gaps: where one trajectory ends and the next begins.

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
pub(crate) struct UsualStep(f64);

impl UsualStep {
    /// From the first time stamps of a trajectory; those after the first 33 are not looked at.
    pub(crate) fn new(t: &[f64]) -> Self {
        let mut steps: Vec<f64> =
            t.windows(2).take(FIRST_STEPS).map(|pair| pair[1] - pair[0]).collect();
        steps.sort_by(f64::total_cmp);
        Self(steps.get(steps.len() / 2).copied().unwrap_or(f64::INFINITY))
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

    fn gaps(t: &[f64]) -> Vec<usize> {
        let mut usual = UsualStep::new(t);
        (1..t.len()).filter(|row| usual.is_gap(t[*row] - t[row - 1])).collect()
    }

    fn stamps(steps: impl IntoIterator<Item = f64>) -> Vec<f64> {
        let mut t = vec![7.0];
        t.extend(steps.into_iter().scan(7.0, |t, step| {
            *t += step;
            Some(*t)
        }));
        t
    }

    #[test]
    fn a_long_step_is_a_gap_and_four_usual_ones_are_not() {
        let mut steps = vec![0.001; 200];
        steps[50] = 0.004;
        steps[120] = 0.061;

        assert_eq!(gaps(&stamps(steps)), [121]);
    }

    #[test]
    fn a_short_pause_is_bridged() {
        let mut steps = vec![0.001; 200];
        steps[50] = 0.05;

        assert_eq!(gaps(&stamps(steps)), [0; 0]);
    }

    #[test]
    fn a_gap_or_a_short_step_at_the_start_does_not_spoil_the_estimate() {
        for first in [10.0, 1e-9] {
            let steps = std::iter::once(first).chain([0.01; 40]);
            let expected: &[usize] = if first > 1.0 { &[1] } else { &[] };
            assert_eq!(gaps(&stamps(steps)), expected, "{first}");
        }
    }

    #[test]
    fn a_rate_that_drifts_tenfold_is_followed() {
        let steps = (0..2_000).map(|row| 0.001 * 10_f64.powf(f64::from(row) / 1_000.0));

        assert_eq!(gaps(&stamps(steps)), [0; 0]);
    }

    #[test]
    fn jitter_of_half_a_step_is_no_gap() {
        let steps = (0..500).map(|row| 0.01 + 0.005 * f64::from(row * row).sin());

        assert_eq!(gaps(&stamps(steps)), [0; 0]);
    }
}
