//! Which terms of an equation are printed, and in which form.

use crate::harmonic::summed_angles;
use crate::{Kind, Place, Term};
use crate::{LEAST_T, Weighted};
use std::collections::BTreeMap;
use std::ops::Range;
use torquewise_motion::grouped;

/// Part of the largest coefficient of a sum below which one is rounding.
const ROUNDING: f64 = 1e-12;

/// Which equations and terms are printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// Those of one joint, counted from 0.
    pub joint: Option<usize>,
    /// One part of the torque.
    pub part: Option<Kind>,
    /// So many terms of each sum, those with the largest coefficients.
    pub top: Option<usize>,
    /// Also terms that do not differ from zero significantly.
    pub all: bool,
}

impl Selection {
    /// Whether equations of a joint, counted from 0, are printed.
    pub fn has_joint(&self, joint: usize) -> bool {
        self.joint.is_none_or(|wanted| wanted == joint)
    }

    /// Whether a part of the torque is printed.
    pub fn has_part(&self, part: Kind) -> bool {
        self.part.is_none_or(|wanted| wanted == part)
    }

    /// Whether an energy is printed: M of a joint, or V.
    pub fn has_energy(&self, place: Place) -> bool {
        match place {
            Place::Potential => self.has_part(Kind::Gravity),
            Place::Inertia(i, j) => {
                self.has_part(Kind::Inertia) && (self.has_joint(i) || self.has_joint(j))
            }
        }
    }

    /// The terms that are printed, and how many were left out.
    pub(crate) fn of<T>(&self, terms: Vec<Weighted<T>>) -> (Vec<Weighted<T>>, usize) {
        let found = terms.len();
        let largest = largest(&terms);
        let mut kept = terms;
        kept.retain(|weighted| self.all || is_resolved(weighted, largest));
        if let Some(top) = self.top {
            let mut sizes: Vec<f64> = kept.iter().map(|w| w.coefficient.abs()).collect();
            sizes.sort_by(|a, b| b.total_cmp(a));
            let least = sizes.get(top.saturating_sub(1)).copied().unwrap_or(0.0);
            kept.retain(|weighted| weighted.coefficient.abs() >= least);
            kept.truncate(top);
        }
        let left_out = found - kept.len();
        (kept, left_out)
    }
}

fn largest<T>(terms: &[Weighted<T>]) -> f64 {
    terms.iter().map(|w| w.coefficient.abs()).fold(0.0, f64::max)
}

/// Whether a coefficient differs from zero significantly.
fn is_resolved<T>(weighted: &Weighted<T>, largest: f64) -> bool {
    let size = weighted.coefficient.abs();
    size >= LEAST_T * weighted.std_error && size > ROUNDING * largest
}

/// The same sum with angles added up, as in sin(q1 + q2), where that takes fewer terms that can be
/// told from zero; terms with the same velocities and accelerations are taken together.
///
/// - `correlated`: whether errors of the terms follow from the same few parameters, so that those
///   of a sum add up; else they are independent
pub fn shortest(terms: Vec<Weighted<Term>>, correlated: bool) -> Vec<Weighted<Term>> {
    let groups = grouped(terms, |a, b| (&a.term.dq, &a.term.ddq) == (&b.term.dq, &b.term.ddq));
    let resolved = |terms: &[Weighted<Term>]| {
        let largest = largest(terms);
        terms.iter().filter(|weighted| is_resolved(weighted, largest)).count()
    };
    // The range of joints whose angles are added that leaves the fewest terms.
    let shorter = |own: Vec<Weighted<Term>>| {
        let n = own[0].term.n_joints();
        let ranges = (0..n).flat_map(|first| (first + 2..=n).map(move |end| first..end));
        let summed = ranges.filter_map(|joints| summed(&own, &joints, correlated));
        let shortest = summed.map(|sum| (resolved(&sum), sum)).min_by_key(|(count, _)| *count);
        shortest.filter(|(count, _)| *count < resolved(&own)).map_or(own, |(_, sum)| sum)
    };
    groups.into_iter().flat_map(shorter).collect()
}

/// Functions that one product may become at most.
const MOST_SUMMED: usize = 10_000;

/// The same sum with products of sines and cosines of a range of joints as functions of summed
/// angles; `None` where a multiple of an angle is too large for a term, or there would be too many.
fn summed(
    terms: &[Weighted<Term>],
    joints: &Range<usize>,
    correlated: bool,
) -> Option<Vec<Weighted<Term>>> {
    // Coefficient, sum of errors or of their squares, least share of resampled logs.
    let mut sums: BTreeMap<Term, (f64, f64, Option<f64>)> = BTreeMap::new();
    for Weighted { term, coefficient, std_error, inclusion } in terms {
        for (share, function) in summed_angles(term, joints, MOST_SUMMED)? {
            let sum = sums.entry(function).or_insert((0.0, 0.0, *inclusion));
            let error = (share * std_error).abs();
            sum.0 += share * coefficient;
            sum.1 += if correlated { error } else { error * error };
            sum.2 = sum.2.zip(*inclusion).map(|(a, b)| a.min(b));
        }
    }
    let weighted = |(term, (coefficient, error, inclusion)): (Term, (f64, f64, Option<f64>))| {
        let std_error = if correlated { error } else { error.sqrt() };
        Weighted { term, coefficient, std_error, inclusion }
    };
    Some(sums.into_iter().map(weighted).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::term::Trig::{Cos, Sin};

    fn weighted(coefficient: f64, std_error: f64, term: Term) -> Weighted<Term> {
        Weighted { term, coefficient, std_error, inclusion: None }
    }

    fn value(terms: &[Weighted<Term>], q: &[f64]) -> f64 {
        terms.iter().map(|w| w.coefficient * w.term.value(q, &[1.3, 0.4], &[0.0, 2.0])).sum()
    }

    #[test]
    fn products_of_equal_weight_become_the_sine_of_a_sum() {
        let one = || Term::one(2);
        let sum = shortest(
            vec![
                weighted(3.924, 0.001, one().times(Cos, 0, 1, 1).times(Sin, 1, 1, 1)),
                weighted(3.925, 0.001, one().times(Sin, 0, 1, 1).times(Cos, 1, 1, 1)),
            ],
            false,
        );
        let (shown, left_out) = Selection::default().of(sum);

        assert_eq!((shown.len(), left_out), (1, 1));
        assert_eq!(shown[0].term.name(), "sin(q1+q2)");
        assert!((shown[0].coefficient - 3.9245).abs() < 1e-12);
        assert!((shown[0].std_error - 0.001 / 2_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn the_sum_is_the_same_at_any_state() {
        let one = || Term::one(2);
        let terms = vec![
            weighted(0.7, 0.0, one().times(Cos, 0, 1, 2).times_dq(1)),
            weighted(-1.4, 0.0, one().times(Sin, 0, 1, 2).times_dq(1)),
            weighted(0.3, 0.0, one().times(Sin, 0, 1, 1).times(Cos, 0, 1, 1).times_dq(1)),
            weighted(2.0, 0.0, one().times(Sin, 1, 2, 1)),
        ];
        let other = summed(&terms, &(0..2), true).unwrap();

        for k in 0..50 {
            let q = [0.37 * f64::from(k), 1.0 - 0.61 * f64::from(k)];
            assert!((value(&terms, &q) - value(&other, &q)).abs() < 1e-12);
            assert!((value(&terms, &q) - value(&shortest(terms.clone(), true), &q)).abs() < 1e-12);
        }
    }

    #[test]
    fn what_cannot_be_told_from_zero_is_left_out_unless_all_is_asked_for() {
        let terms = || {
            let sine = |joint| Term::one(2).times(Sin, joint, 1, 1);
            vec![weighted(1.0, 0.1, sine(0)), weighted(0.1, 0.1, sine(1))]
        };
        let all = Selection { all: true, ..Selection::default() };
        let top = Selection { top: Some(1), all: true, ..Selection::default() };

        assert_eq!(Selection::default().of(terms()).1, 1);
        assert_eq!(all.of(terms()).1, 0);
        assert_eq!(top.of(terms()).0[0].term.name(), "sin(q1)");
    }
}
