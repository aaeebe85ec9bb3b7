//! The best physically consistent parameters of normal equations (E14).

use crate::inertia::{Inertial, divergence, divergence_slopes};
use crate::{ChainError, PER_BODY, Result};
use faer::{ColRef, Mat};

mod factored;

pub use factored::Factored;

/// Prior of the parameters of a chain, whatever the log.
///
/// It is one convex function Ψ: zero at the nominal values, and unbounded towards bodies and sums that
/// are not physical.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Prior {
    /// Nominal inertial parameters of each body; the first parameters are theirs, 10 each.
    pub bodies: Vec<Inertial>,
    /// Rotors, (index, usual inertia): as likely to be so many times smaller as larger.
    pub rotors: Vec<(usize, f64)>,
    /// Sums of parameters that must be positive: friction at a speed.
    pub positive: Vec<Positive>,
    /// Parameters with a Gaussian prior at zero: (index, standard deviation in its unit).
    pub small: Vec<(usize, f64)>,
}

/// Σ weight · parameter > least.
#[derive(Clone, Debug, PartialEq)]
pub struct Positive {
    /// What the sum must exceed, 0 or a little more.
    pub least: f64,
    /// Parameters by ascending index, with their weights.
    pub terms: Vec<(usize, f64)>,
    /// Usual excess of the sum over `least`, above 0: the barrier is zero there.
    pub nominal: f64,
    /// Weight of this barrier in Ψ; the divergence of a body has weight 1.
    pub weight: f64,
}

/// ½ xᵀHx − bᵀx: half the weighted sum of squares, but for a constant.
#[derive(Clone, Copy, Debug)]
pub struct Quadratic<'a> {
    /// H, p×p, symmetric.
    pub hessian: &'a Mat<f64>,
    /// b, p.
    pub right: &'a [f64],
}

impl Quadratic<'_> {
    /// At x.
    pub fn value(&self, x: &[f64]) -> f64 {
        let hx = self.hessian * ColRef::from_slice(x);
        let pairs = x.iter().zip(hx.iter()).zip(self.right);
        pairs.map(|((x, hx), b)| x * (0.5 * hx - b)).sum()
    }
}

impl Positive {
    fn value(&self, x: &[f64]) -> f64 {
        self.terms.iter().map(|&(k, weight)| weight * x[k]).sum::<f64>() - self.least
    }
}

impl Prior {
    /// What Ψ pulls each rotor up by at x, 0 for a large one, and the place of the rotor.
    pub fn pulls_of_rotors(&self, x: &[f64]) -> impl Iterator<Item = (usize, f64)> {
        let pull = |usual: f64, x: f64| (usual / (x * x) - 1.0 / usual).max(0.0);
        self.rotors.iter().map(move |&(k, usual)| (k, pull(usual, x[k])))
    }

    /// Ψ(x); `None` outside of what physics allows.
    pub fn value(&self, x: &[f64]) -> Option<f64> {
        let mut sum = 0.0;
        for (k, nominal) in self.bodies.iter().enumerate() {
            sum += divergence(&x[PER_BODY * k..PER_BODY * (k + 1)], nominal)?;
        }
        for &(k, usual) in &self.rotors {
            let ratio = x[k] / usual;
            if ratio <= 0.0 {
                return None;
            }
            sum += ratio + 1.0 / ratio - 2.0;
        }
        for positive in &self.positive {
            let ratio = positive.value(x) / positive.nominal;
            if ratio <= 0.0 {
                return None;
            }
            sum += positive.weight * (ratio - ratio.ln() - 1.0);
        }
        sum += self.small.iter().map(|&(k, sigma)| 0.5 * (x[k] / sigma).powi(2)).sum::<f64>();
        sum.is_finite().then_some(sum)
    }

    /// Adds `strength` times the Hessian of Ψ at x as information. Near its limit the curvature of a
    /// barrier is none: where a sum is below its nominal value, the curvature there is taken.
    pub fn add_hessian(&self, x: &[f64], strength: f64, hessian: &mut Mat<f64>) {
        let mut own = Mat::zeros(x.len(), x.len());
        self.add_certainty(x, strength, &mut own);
        *hessian += Mat::from_fn(x.len(), x.len(), |i, j| own[(i.max(j), i.min(j))]);
    }

    /// The lower triangle of [`Self::add_hessian`].
    fn add_certainty(&self, x: &[f64], strength: f64, hessian: &mut Mat<f64>) {
        let at = f64::max;
        self.add_slopes(x, [strength; 2], at, (&mut vec![0.0; x.len()], hessian));
    }

    /// Adds strengths times the gradient of Ψ at x and the lower triangle of its Hessian.
    ///
    /// - `strengths`: that of the gradient, that of the Hessian
    /// - `at`: where what must be positive is taken to be, from its value and its usual one
    fn add_slopes(
        &self,
        x: &[f64],
        [strength, stiffness]: [f64; 2],
        at: impl Fn(f64, f64) -> f64,
        (gradient, hessian): (&mut [f64], &mut Mat<f64>),
    ) {
        for (body, nominal) in self.bodies.iter().enumerate() {
            let first = PER_BODY * body;
            let slopes = divergence_slopes(&x[first..first + PER_BODY], nominal);
            let Some((slope, curvature)) = slopes else { continue };
            for i in 0..PER_BODY {
                gradient[first + i] += strength * slope[i];
                for j in 0..=i {
                    hessian[(first + i, first + j)] += stiffness * curvature[i][j];
                }
            }
        }
        for &(k, usual) in &self.rotors {
            let value = at(x[k], usual);
            gradient[k] += strength * (1.0 / usual - usual / (value * value));
            hessian[(k, k)] += stiffness * 2.0 * usual / value.powi(3);
        }
        for positive in &self.positive {
            let value = at(positive.value(x), positive.nominal);
            let slope = strength * positive.weight * (1.0 / positive.nominal - 1.0 / value);
            let curvature = stiffness * positive.weight / (value * value);
            for (place, &(j, b)) in positive.terms.iter().enumerate() {
                gradient[j] += slope * b;
                let column = hessian.col_as_slice_mut(j);
                positive.terms[place..].iter().for_each(|&(i, a)| column[i] += curvature * a * b);
            }
        }
        for &(k, sigma) in &self.small {
            gradient[k] += strength * x[k] / (sigma * sigma);
            hessian[(k, k)] += stiffness / (sigma * sigma);
        }
    }
}

/// Rounds of Newton's method at most.
const ROUNDS: usize = 60;
/// Halvings of a step at most.
const HALVINGS: usize = 30;
/// Squared Newton decrement gᵀH⁻¹g, in units of the cost, below which the minimum is reached.
const SETTLED: f64 = 1e-7;
/// Part of the promised gain that a step must bring.
const ARMIJO: f64 = 1e-4;
/// Factor from one strength of the prior to the next.
const FALL: f64 = 0.4;
/// Largest number of intermediate strengths.
const STRENGTHS: usize = 40;
/// Squared Newton decrement, in strengths of the prior, at which an intermediate strength is left.
const NEAR: f64 = 0.1;

/// Minimises ½ xᵀHx − bᵀx + strength · Ψ(x) from a feasible start.
///
/// The sum is convex in the inertial parameters themselves, so Newton's method comes nearer to its only
/// minimum with each step, and Ψ keeps them feasible: what comes out is a physical arm, whatever H and
/// b are. Where there is much to gain, a weak prior is a wall along which Newton's method crawls: it
/// begins strong enough to count, and falls to its strength step by step.
///
/// # Errors
/// [`ChainError::Singular`] if the start is not feasible or no step can be computed.
pub fn minimise(
    cost: Quadratic<'_>,
    prior: &Prior,
    strength: f64,
    start: &[f64],
) -> Result<Vec<f64>> {
    // Where no prior counts.
    let least = Factored::new(cost.hessian.clone()).map(|factor| factor.solve(cost.right));
    let gain = least.map_or(f64::INFINITY, |least| cost.value(start) - cost.value(&least));
    let stronger = |own: &f64| (gain > own * start.len() as f64).then_some(own / FALL);
    let stronger = std::iter::successors(Some(strength), stronger).take(STRENGTHS).skip(1);
    let on_the_way: Vec<f64> = stronger.collect();
    let falling = on_the_way.iter().rev().map(|own| (*own, NEAR * own));
    let (mut x, mut before) = (start.to_vec(), None);
    for (own, near) in falling.chain([(strength, SETTLED)]) {
        x = descend(cost, prior, (own, before, near), x)?;
        before = Some(own);
    }
    Ok(x)
}

/// Damped Newton steps at one strength, at most 60, until the squared decrement is below what is near.
///
/// - `before`: the strength whose minimum x is. The first step is a predictor along the path of minima,
///   gradient at the new strength, Hessian at the old: a Newton step of the weaker prior would leave the
///   feasible set.
fn descend(
    cost: Quadratic<'_>,
    prior: &Prior,
    (strength, before, near): (f64, Option<f64>, f64),
    mut x: Vec<f64>,
) -> Result<Vec<f64>> {
    let value = |x: &[f64]| prior.value(x).map(|psi| cost.value(x) + strength * psi);
    let mut current = value(&x).ok_or(ChainError::Singular)?;
    for round in 0..ROUNDS {
        let before = before.filter(|_| round == 0);
        let follows = before.is_some();
        let strengths = [strength, before.unwrap_or(strength)];
        let (step, decrement) = newton_step(cost, prior, strengths, &x)?;
        if decrement < near && !follows {
            break;
        }
        let (mut share, mut taken) = (1.0, false);
        for _ in 0..HALVINGS {
            let moved: Vec<f64> = x.iter().zip(&step).map(|(x, d)| x + share * d).collect();
            if let Some(other) = value(&moved)
                && other <= current - ARMIJO * share * decrement
            {
                (x, current, taken) = (moved, other, true);
                break;
            }
            share *= 0.5;
        }
        if !taken && !follows {
            // What is left to gain is rounding.
            break;
        }
    }
    Ok(x)
}

/// The curvature of the whole cost, H + strength · Ψ″ as [`Prior::add_hessian`] has it, factored.
///
/// # Errors
/// [`ChainError::Singular`] if it is not positive definite.
pub fn curvature(cost: Quadratic<'_>, prior: &Prior, strength: f64, x: &[f64]) -> Result<Factored> {
    let mut hessian = cost.hessian.clone();
    prior.add_certainty(x, strength, &mut hessian);
    Factored::new(hessian)
}

/// - `strengths`: of the prior in the gradient and in the Hessian
/// - returns: the step and its decrement
fn newton_step(
    cost: Quadratic<'_>,
    prior: &Prior,
    strengths: [f64; 2],
    x: &[f64],
) -> Result<(Vec<f64>, f64)> {
    let hx = cost.hessian * ColRef::from_slice(x);
    let mut gradient: Vec<f64> = hx.iter().zip(cost.right).map(|(hx, b)| hx - b).collect();
    let mut hessian = cost.hessian.clone();
    prior.add_slopes(x, strengths, |value, _| value, (&mut gradient, &mut hessian));
    let step: Vec<f64> = Factored::new(hessian)?.solve(&gradient).iter().map(|d| -d).collect();
    let decrement = -step.iter().zip(&gradient).map(|(d, g)| d * g).sum::<f64>();
    if !decrement.is_finite() {
        return Err(ChainError::Singular);
    }
    Ok((step, decrement))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inertia::{is_feasible, plain_link};
    use nalgebra::Vector3;

    fn nominal() -> Inertial {
        plain_link(2.0, &Vector3::new(0.2, 0.0, 0.0), 0.1)
    }

    /// H and b that ask for such parameters of one body, each as strongly, and its prior.
    fn asked_for(asked: &[f64], weight: f64) -> (Mat<f64>, Vec<f64>, Prior) {
        let hessian = Mat::from_fn(10, 10, |i, j| if i == j { weight } else { 0.0 });
        let right = asked.iter().map(|x| weight * x).collect();
        (hessian, right, Prior { bodies: vec![nominal()], ..Prior::default() })
    }

    #[test]
    fn what_is_feasible_and_certain_is_found_however_far_from_the_nominal_body() {
        let near = plain_link(3.0, &Vector3::new(0.1, 0.1, 0.3), 0.05);
        let far = plain_link(7.0, &Vector3::new(0.36, 0.0, 0.0), 0.3);
        let small = plain_link(0.2, &Vector3::new(0.1, 0.0, 0.0), 0.1);
        for (truth, nominal, weight) in [(near, nominal(), 1e8), (far, small, 1e9)] {
            let (hessian, right, mut prior) = asked_for(&truth, weight);
            prior.bodies = vec![nominal];

            let cost = Quadratic { hessian: &hessian, right: &right };
            let found = minimise(cost, &prior, 1e-3, &nominal).unwrap();

            for (found, truth) in found.iter().zip(truth) {
                assert!((found - truth).abs() < 1e-6, "{found} {truth}");
            }
        }
    }

    #[test]
    fn far_from_the_minimum_a_weak_barrier_is_no_wall() {
        // Ten quantities of which noise makes a body that cannot be.
        let asked = [5.0, 3.0, -2.0, 4.0, -1.0, 0.5, 2.0, -0.3, 0.2, -4.0];
        let (hessian, right, prior) = asked_for(&asked, 1e4);
        let (cost, strength) = (Quadratic { hessian: &hessian, right: &right }, 1e-2);

        let found = minimise(cost, &prior, strength, &nominal()).unwrap();
        let direct = descend(cost, &prior, (strength, None, SETTLED), nominal().to_vec()).unwrap();

        let (_, decrement) = newton_step(cost, &prior, [strength; 2], &found).unwrap();
        assert!(decrement < 1e-5 * cost.value(&found).abs(), "{decrement:e}");
        assert!(cost.value(&found) < 1.4 * cost.value(&direct), "{:e}", cost.value(&direct));
    }

    #[test]
    fn what_cannot_be_becomes_the_nearest_that_can() {
        // A negative mass, as noise makes it.
        let mut asked = nominal();
        asked[0] = -1.0;
        let (hessian, right, prior) = asked_for(&asked, 1e4);

        let cost = Quadratic { hessian: &hessian, right: &right };
        let found = minimise(cost, &prior, 1e-4, &nominal()).unwrap();

        assert!(is_feasible(&found));
        assert!(found[0] > 0.0 && found[0] < 1.0, "{}", found[0]);
    }

    #[test]
    fn a_log_that_says_nothing_leaves_the_nominal_arm() {
        let (bodies, rotors) = (vec![nominal()], vec![(10, 0.3)]);
        let prior = Prior { bodies, rotors, small: vec![(11, 2.0)], ..Prior::default() };
        let hessian = Mat::zeros(12, 12);
        let mut start = plain_link(5.0, &Vector3::new(0.0, 0.1, 0.1), 0.2).to_vec();
        start.extend([2.0, 1.0]);

        let cost = Quadratic { hessian: &hessian, right: &[0.0; 12] };
        let found = minimise(cost, &prior, 1.0, &start).unwrap();

        let mut own = Mat::zeros(12, 12);
        prior.add_hessian(&start, 1.0, &mut own);
        assert_eq!(own, own.transpose().to_owned());
        let expected = nominal().into_iter().chain([0.3, 0.0]);
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-4, "{found} {expected}");
        }
    }
}
