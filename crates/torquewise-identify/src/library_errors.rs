//! Held-out error of the terms of a library.

use crate::{DriveTerm, HeldOut, States, Unseen, both_ways};
use faer::Mat;
use torquewise_model::{Form, FrictionTerm, Model, Term, Weighted};
use torquewise_motion::Motion;
use torquewise_stepwise::{IdentifyError, thinned};

/// Rows that the terms are fitted to, at most.
const ROWS: usize = 2_000;

/// RMS of what the terms of a model, fitted anew without them, leave of the torque of each joint
/// \[N·m\] on whole logs or blocks of time, n, and on regions of configuration, n (E20). Nothing
/// where there are too few rows.
pub(crate) fn held_out_rms(model: &Model, sample: &Motion) -> Result<[Vec<f64>; 2], IdentifyError> {
    let few = thinned(sample, ROWS);
    let tau = few.require_tau()?.to_owned();
    let columns = columns(model, &few);
    // A joint without any residual weighs as much as the best of the others.
    let residuals = model.training.residual_rms.iter().copied();
    let least = residuals.filter(|rms| *rms > 0.0).fold(f64::INFINITY, f64::min);
    let rms = |blocks: Vec<HeldOut>| -> Vec<f64> {
        let of = |(joints, columns): &(std::ops::Range<usize>, Mat<f64>)| {
            let own = tau.subcols(joints.start, joints.len()).to_owned();
            let target = [(&own, &own)];
            let weight = |row: usize| {
                let rms = model.training.residual_rms[joints.start + row / few.n_rows()];
                if least.is_finite() { 1.0 / rms.max(least) } else { 1.0 }
            };
            let weights: Vec<f64> = (0..columns.nrows()).map(weight).collect();
            let weighed = Mat::from_fn(columns.nrows(), columns.ncols(), |row, k| {
                weights[row] * columns[(row, k)]
            });
            let unseen = Unseen::of_columns((weighed, weights), few.n_rows(), &target, &blocks)?;
            Some(unseen.errors_of_all()?.first()?.rms_by_joint())
        };
        let all: Option<Vec<Vec<f64>>> = columns.iter().map(of).collect();
        all.unwrap_or_default().concat()
    };
    Ok(both_ways(&few, sample).map(rms))
}

/// Columns of the terms of a model that are fitted together, and to which joints, each once;
/// (m·joints)×p, joint by joint.
fn columns(model: &Model, motion: &Motion) -> Vec<(std::ops::Range<usize>, Mat<f64>)> {
    let (m, n, states) = (motion.n_rows(), model.n_joints(), States::of(motion));
    let law = |own: &Weighted<FrictionTerm>| DriveTerm::Friction(own.term.clone()).loads(&states);
    let laws = model.friction.iter().map(law);
    match &model.form {
        Form::Torque(joints) => {
            let rows: Vec<[Vec<f64>; 3]> = (0..m).map(|row| motion.state(row)).collect();
            let laws: Vec<Mat<f64>> = laws.collect();
            let of_joint = |(joint, terms): (usize, &Vec<Weighted<Term>>)| {
                let value = |row: usize, k: usize| match k.checked_sub(terms.len()) {
                    None => {
                        let [q, dq, ddq] = &rows[row];
                        terms[k].term.value(q, dq, ddq)
                    }
                    Some(law) => laws[law][(row, joint)],
                };
                (joint..joint + 1, Mat::from_fn(m, terms.len() + laws.len(), value))
            };
            joints.iter().enumerate().map(of_joint).collect()
        }
        Form::Energy(terms) => {
            let terms = terms.iter().map(|own| states.loads(&own.term, 1.0));
            let loads: Vec<Mat<f64>> = terms.chain(laws).collect();
            let value = |row: usize, k: usize| loads[k][(row % m, row / m)];
            vec![(0..n, Mat::from_fn(m * n, loads.len(), value))]
        }
    }
}
