//! Models drawn from the uncertainty of one: other arms that its log may as well be of, all of them
//! physical. What a simulator randomises a robot by, and what errors are propagated with.

use crate::basis::Wanted;
use faer::Mat;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;
use torquewise_model::checks::laws_of_shafts;
use torquewise_model::{Form, Model, RigidChain, Torque};
use torquewise_motion::{Motion, Signals};
use torquewise_regression::SparseError;
use torquewise_stepwise::IdentifyError;

/// Sweeps of the chain of draws between two models that are kept: they forget where they began.
const SWEEPS: usize = 10;
/// What changes the torque's squares by less, in parts of what changes them most, changes nothing but
/// rounding; and a parameter that changes the torque by less.
const UNTOLD: f64 = 1e-8;
/// Rows of states, in parts of the parameters.
const STATES: usize = 4;
/// Speeds that friction is looked at, in each direction, each so much slower than the one before.
const SPEEDS: i32 = 60;
const SLOWER: f64 = 0.9;

/// Independent directions, a standard deviation long, in which the parameters of a chain scatter
/// and its torque changes where it was trained, p×r.
///
/// What changes no torque is left as it is: masses may move from link to link by kilograms, and a
/// place that the log tells would have to follow them along a curve.
/// Friction scatters as a whole: states apart tell nothing of what it does within a short travel.
fn directions(model: &Model, chain: &RigidChain) -> Result<Mat<f64>, IdentifyError> {
    let (training, n) = (&model.training, model.n_joints());
    let p = chain.n_parameters(model.friction.len());
    let known = [training.torque_std.len(), training.q_range.len(), training.dq_peak.len()];
    if known != [n; 3] || training.ddq_peak.len() != n {
        return Err(IdentifyError::NoScatter);
    }
    let states = trained_states(model, p)?;
    let laws = Torque::new(model).laws(&states)?;
    let mut gram = Mat::<f64>::zeros(p, p);
    for row in 0..states.n_rows() {
        let state = states.state(row);
        let laws: Vec<f64> = laws.row(row).iter().copied().collect();
        let state = state.each_ref().map(Vec::as_slice);
        let rows = chain.sensitivities((&model.friction, &laws), state)?;
        for (row, std) in rows.row_iter().zip(&training.torque_std) {
            if *std > 0.0 {
                gram += row.transpose() * row * faer::Scale(std.powi(-2));
            }
        }
    }
    let size: Vec<f64> = (0..p).map(|k| gram[(k, k)].sqrt()).collect();
    let most = size.iter().copied().fold(0.0, f64::max);
    if most == 0.0 {
        return Err(IdentifyError::NoScatter);
    }
    let size: Vec<f64> = size.iter().map(|size| size.max(UNTOLD * most)).collect();
    let last = p - chain.fitted.len();
    let rubs = |k: usize| (last - model.friction.len()..last).contains(&k);
    let unit = |i: usize, j: usize| {
        let is_whole = rubs(i) || rubs(j);
        if is_whole { f64::from(u8::from(i == j)) } else { gram[(i, j)] / (size[i] * size[j]) }
    };
    let (values, vectors) = eigen(&Mat::from_fn(p, p, unit))?;
    let told: Vec<usize> = (0..p).filter(|&k| values[k] > UNTOLD * values[p - 1]).collect();
    let told = Mat::from_fn(p, told.len(), |i, k| vectors[(i, told[k])]);
    let scaled = Mat::from_fn(p, told.ncols(), |i, k| size[i] * told[(i, k)]);
    let (values, vectors) = eigen(&chain.covariance_of(&scaled.transpose().to_owned()))?;
    let along = told * vectors;
    let long = |i, k| along[(i, k)] * f64::max(values[k], 0.0).sqrt() / size[i];
    Ok(Mat::from_fn(p, along.ncols(), long))
}

/// Eigenvalues, the smallest first, and vectors.
fn eigen(of: &Mat<f64>) -> Result<(Vec<f64>, Mat<f64>), IdentifyError> {
    let eigen = of.self_adjoint_eigen(faer::Side::Lower).map_err(|_| SparseError::NotSolvable)?;
    Ok((eigen.S().column_vector().iter().copied().collect(), eigen.U().to_owned()))
}

/// States within the range that a model was trained in, enough for p parameters.
fn trained_states(model: &Model, p: usize) -> Result<Motion, IdentifyError> {
    let (training, n) = (&model.training, model.n_joints());
    let rows = STATES * p.div_ceil(n.max(1));
    let mut random = ChaCha8Rng::seed_from_u64(0);
    let mut between = |ranges: Vec<[f64; 2]>| {
        Mat::from_fn(rows, n, |_, joint| {
            let [low, high] = ranges[joint];
            low + (high - low) * random.random_range(0.0..1.0)
        })
    };
    let peaks = |peaks: &[f64]| peaks.iter().map(|peak| [-peak, *peak]).collect();
    Ok(Motion::new(Signals {
        joints: model.joints.clone(),
        t: (0..rows).map(|row| row as f64).collect(),
        q: between(training.q_range.clone()),
        dq: between(peaks(&training.dq_peak)),
        ddq: between(peaks(&training.ddq_peak)),
        tau: None,
    })?)
}

/// Draws models whose parameters scatter around those of a learned chain by their covariance,
/// of those that an arm can have: links are bodies, no rotor is negative, friction brakes. They are
/// draws of a Markov chain, by slices through ellipses, one direction at a time:
/// what ends soon at arms that cannot be does not hold the others.
///
/// - `returns`: models without a covariance of their own
///
/// Source: I. Murray, R. P. Adams, D. J. C. `MacKay`, AISTATS 9 (2010).
///
/// # Errors
/// [`IdentifyError::NoScatter`] if the model has no covariance or is no physical arm itself.
pub fn samples(model: &Model, count: usize, seed: u64) -> Result<Vec<Model>, IdentifyError> {
    let chain = model.chain.as_ref().filter(|chain| !chain.covariance_root.is_empty());
    let chain = chain.filter(|chain| chain.is_feasible()).ok_or(IdentifyError::NoScatter)?;
    let (along, friction) = (directions(model, chain)?, model.friction.len());
    let chain = &RigidChain { covariance_root: Vec::new(), ..chain.clone() };
    let centre = chain.parameters(&model.friction);
    let first = centre.len() - friction - chain.fitted.len();
    let powers = Powers::of(model);
    let at =
        |change: &[f64]| -> Vec<f64> { centre.iter().zip(change).map(|(x, d)| x + d).collect() };
    let is_arm = |change: &[f64]| {
        let moved = at(change);
        // Friction takes power at all speeds, or hardly less than that of the model.
        let mut taken = powers.taken(&moved[first..first + friction]).zip(&powers.least);
        taken.all(|(power, least)| power >= *least) && chain.at(&moved, friction).is_feasible()
    };
    let wanted = match &model.form {
        Form::Energy(terms) => Some(Wanted::of(terms.iter().map(|own| &own.term))),
        Form::Torque(_) => None,
    };
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (mut place, mut point) = (vec![0.0; along.ncols()], vec![0.0; centre.len()]);
    (0..count)
        .map(|_| {
            for _ in 0..SWEEPS {
                sweep(&along, &mut place, &mut point, is_arm, &mut random);
            }
            model_at(model, chain, (&at(&point), first), wanted.as_ref())
        })
        .collect()
}

/// What friction of coefficient 1 takes of a shaft, at speeds in both directions: laws of one shaft
/// and load together, offsets left aside.
struct Powers {
    /// For each shaft: places of its laws, and the power of each at each speed \[W\].
    shafts: Vec<(Vec<usize>, Vec<Vec<f64>>)>,
    /// The least that the model itself takes of each, where that is below zero.
    least: Vec<f64>,
}

impl Powers {
    fn of(model: &Model) -> Self {
        let term = |k: usize| &model.friction[k].term;
        let shafts = laws_of_shafts(model).into_iter().map(|(laws, peak)| {
            let speeds = (0..SPEEDS).flat_map(|k| {
                let speed = peak * SLOWER.powi(k);
                [speed, -speed]
            });
            let at = |v: f64| laws.iter().map(|&k| term(k).at_speed(v) * v).collect();
            let powers = speeds.map(at).collect();
            (laws, powers)
        });
        let mut powers = Self { shafts: shafts.collect(), least: Vec::new() };
        let own: Vec<f64> = model.friction.iter().map(|own| own.coefficient).collect();
        powers.least = powers.taken(&own).map(|power| power.min(0.0)).collect();
        powers
    }

    /// The least power that each shaft takes at coefficients of all laws \[W\].
    fn taken<'a>(&'a self, coefficients: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        self.shafts.iter().map(|(laws, powers)| {
            let at = |own: &Vec<f64>| -> f64 {
                own.iter().zip(laws).map(|(power, &k)| power * coefficients[k]).sum()
            };
            powers.iter().map(at).fold(f64::INFINITY, f64::min)
        })
    }
}

/// Draws anew how far a point is along each direction, of what is allowed there.
fn sweep(
    along: &Mat<f64>,
    place: &mut [f64],
    point: &mut [f64],
    is_allowed: impl Fn(&[f64]) -> bool,
    random: &mut impl RngExt,
) {
    for (k, here) in place.iter_mut().enumerate() {
        let other: f64 = StandardNormal.sample(random);
        let mut angle = random.random_range(0.0..TAU);
        let (mut low, mut high) = (angle - TAU, angle);
        loop {
            let there = *here * angle.cos() + other * angle.sin();
            let step = there - *here;
            let moved = point.iter().zip(along.col_as_slice(k)).map(|(x, a)| x + step * a);
            let moved: Vec<f64> = moved.collect();
            if is_allowed(&moved) {
                *here = there;
                point.copy_from_slice(&moved);
                break;
            }
            (low, high) = if angle < 0.0 { (angle, high) } else { (low, angle) };
            angle = random.random_range(low..high);
        }
    }
}

/// The model at other parameters, of which those of friction begin at `first`.
fn model_at(
    model: &Model,
    chain: &RigidChain,
    (parameters, first): (&[f64], usize),
    wanted: Option<&Wanted>,
) -> Result<Model, IdentifyError> {
    let mut model = model.clone();
    let chain = chain.at(parameters, model.friction.len());
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
