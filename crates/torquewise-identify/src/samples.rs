//! Models drawn from the uncertainty of one: other arms that its log may as well be of, all of them
//! physical. What a simulator randomises a robot by, and what errors are propagated with.

use crate::basis::Wanted;
use faer::{ColRef, Mat};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use torquewise_model::{Form, Model, RigidChain};
use torquewise_regression::SparseError;
use torquewise_stepwise::error::IdentifyError;

/// Moves of the chain of draws between two models that are kept: they forget where they began.
const MOVES: usize = 40;

/// How the parameters of a chain scatter: a square root of their covariance.
pub(crate) struct Scatter {
    vectors: Mat<f64>,
    deviations: Vec<f64>,
}

impl Scatter {
    /// # Errors
    /// [`IdentifyError::Sparse`] if the covariance has no eigenvalues.
    pub(crate) fn of(chain: &RigidChain) -> Result<Self, IdentifyError> {
        let eigen = chain.covariance_matrix().self_adjoint_eigen(faer::Side::Lower);
        let eigen = eigen.map_err(|_| SparseError::NotSolvable)?;
        let values = eigen.S().column_vector().iter();
        let deviations = values.map(|value| value.max(0.0).sqrt()).collect();
        Ok(Self { vectors: eigen.U().to_owned(), deviations })
    }

    /// Changes of all parameters, `size` standard deviations large, p.
    pub(crate) fn draw(&self, size: f64, random: &mut impl Rng) -> Vec<f64> {
        let unit = |deviation: &f64| {
            let unit: f64 = StandardNormal.sample(random);
            size * deviation * unit
        };
        let units: Vec<f64> = self.deviations.iter().map(unit).collect();
        (&self.vectors * ColRef::from_slice(&units)).iter().copied().collect()
    }
}

/// Draws models whose parameters scatter around those of a learned chain by their covariance,
/// of those that an arm can have: links are bodies, no rotor is negative, friction brakes where it
/// did. They are draws of a Markov chain, by slices through an ellipse.
///
/// - `returns`: models without a covariance of their own
///
/// Source: I. Murray, R. P. Adams, D. J. C. `MacKay`, AISTATS 9 (2010).
///
/// # Errors
/// [`IdentifyError::NoScatter`] if the model has no covariance or is no physical arm itself.
pub fn samples(model: &Model, count: usize, seed: u64) -> Result<Vec<Model>, IdentifyError> {
    let chain = model.chain.as_ref().filter(|chain| !chain.covariance.is_empty());
    let chain = chain.filter(|chain| chain.is_feasible()).ok_or(IdentifyError::NoScatter)?;
    let (scatter, friction) = (Scatter::of(chain)?, model.friction.len());
    let centre = chain.parameters(&model.friction);
    let first = centre.len() - friction - chain.fitted.len();
    let at =
        |change: &[f64]| -> Vec<f64> { centre.iter().zip(change).map(|(x, d)| x + d).collect() };
    let is_arm = |change: &[f64]| {
        let moved = at(change);
        let brakes = |k: usize| moved[k] * centre[k] >= 0.0;
        (first..first + friction).all(brakes) && chain.at(&moved, friction).is_feasible()
    };
    let wanted = match &model.form {
        Form::Energy(terms) => Some(Wanted::of(terms.iter().map(|own| &own.term))),
        Form::Torque(_) => None,
    };
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut here = vec![0.0; centre.len()];
    (0..count)
        .map(|_| {
            for _ in 0..MOVES {
                let other = scatter.draw(1.0, &mut random);
                here = moved(&here, &other, is_arm, &mut random);
            }
            model_at(model, chain, (&at(&here), first), wanted.as_ref())
        })
        .collect()
}

/// A point on the ellipse through two that is allowed, as the first is.
fn moved(
    here: &[f64],
    other: &[f64],
    is_allowed: impl Fn(&[f64]) -> bool,
    random: &mut impl RngExt,
) -> Vec<f64> {
    let mut angle = random.random_range(0.0..std::f64::consts::TAU);
    let (mut low, mut high) = (angle - std::f64::consts::TAU, angle);
    loop {
        let (sin, cos) = angle.sin_cos();
        let found: Vec<f64> = here.iter().zip(other).map(|(a, b)| a * cos + b * sin).collect();
        if is_allowed(&found) {
            return found;
        }
        if angle < 0.0 {
            low = angle;
        } else {
            high = angle;
        }
        angle = random.random_range(low..high);
    }
}

/// The model at other parameters, of which those of friction begin at `first`.
///
/// - `wanted`: the terms of its equations
fn model_at(
    model: &Model,
    chain: &RigidChain,
    (parameters, first): (&[f64], usize),
    wanted: Option<&Wanted>,
) -> Result<Model, IdentifyError> {
    let mut model = model.clone();
    let chain = RigidChain { covariance: Vec::new(), ..chain.at(parameters, model.friction.len()) };
    for (law, coefficient) in model.friction.iter_mut().zip(&parameters[first..]) {
        (law.coefficient, law.std_error) = (*coefficient, 0.0);
    }
    if let (Form::Energy(terms), Some(wanted)) = (&mut model.form, wanted) {
        for (own, coefficient) in terms.iter_mut().zip(wanted.coefficients_in(&chain)?) {
            (own.coefficient, own.std_error) = (coefficient, 0.0);
        }
    }
    model.chain = Some(chain);
    Ok(model)
}
