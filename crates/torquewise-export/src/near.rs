//! Links as near to those of a URDF as the log allows.

use faer::{Mat, Side};
use torquewise_model::{Drive, Model, ModelError, RigidChain};
use torquewise_rigid::PER_BODY;
use torquewise_rigid::base_parameters::base_parameters;
use torquewise_rigid::feasible::{Prior, Quadratic, minimise};
use torquewise_rigid::inertia::{Inertial, is_feasible};

/// Weight of a link of the file against the log, as if it were known to ten times its size: what the
/// log tells stays within a small part of its errors, so that the torque stays.
const WEIGHT: f64 = 0.01;
/// What a combination of parameters is known to at best, squared, in errors of each alone: beyond
/// it the covariance is rounding.
const LEAST: f64 = 1e-6;

/// The model with links and rotors of the least log-det divergence \[E14\] from those of a file,
/// weighed against the covariance of what torque determines. So base parameters that the log tells
/// stay, and what it does not tell of a link is that of the file. As it is without a covariance.
///
/// - `nominal`: inertial parameters of each link in its frame; `None` where the file has no body
pub(crate) fn near(model: &Model, nominal: &[Option<Inertial>]) -> Result<Model, ModelError> {
    let mut model = model.clone();
    if let Some(chain) = &mut model.chain
        && !chain.covariance_root.is_empty()
    {
        let learned = chain.parameters(&[]);
        let n_known = PER_BODY * chain.links.len() + chain.drives.len();
        let learned = &learned[..n_known];
        let hessian = information(chain, learned)?;
        let product = |i| (0..n_known).map(|j| hessian[(i, j)] * learned[j]).sum();
        let right: Vec<f64> = (0..n_known).map(product).collect();
        let cost = Quadratic { hessian: &hessian, right: &right };
        // Bodies of the file, or as learned; rotors as learned.
        let body = |(own, file): (&Inertial, &Option<Inertial>)| {
            file.filter(|file| is_feasible(file)).unwrap_or(*own)
        };
        let rotor = |(k, drive): (usize, &Drive)| match drive {
            Drive::Rotor { inertia, .. } if *inertia > 0.0 => {
                Some((PER_BODY * chain.links.len() + k, *inertia))
            }
            _ => None,
        };
        let bodies = chain.links.iter().zip(nominal).map(body).collect();
        let rotors = chain.drives.iter().enumerate().filter_map(rotor).collect();
        let prior = Prior { bodies, rotors, ..Prior::default() };
        if let Ok(found) = minimise(cost, &prior, WEIGHT, learned) {
            *chain = chain.at(&found, 0);
        }
    }
    Ok(model)
}

/// Inverse covariance of base parameters and drives as a quadratic form of all links and drives:
/// zero along what torque does not notice.
fn information(chain: &RigidChain, at: &[f64]) -> Result<Mat<f64>, ModelError> {
    let (p, links) = (at.len(), PER_BODY * chain.links.len());
    let axes = chain.axes()?;
    let column = |k: usize| {
        let mut unit = vec![0.0; p];
        unit[k] = 1.0;
        [base_parameters(&axes, &unit[..links]), unit[links..].to_vec()].concat()
    };
    let columns: Vec<Vec<f64>> = (0..p).map(column).collect();
    let is_noticed = |row: &usize| columns.iter().any(|column| column[*row].abs() > 1e-9);
    let noticed: Vec<usize> = (0..p).filter(is_noticed).collect();
    let r = noticed.len();
    let map = Mat::from_fn(r, p, |i, k| columns[k][noticed[i]]);
    let spread = chain.covariance_of(&map);
    // What is exact in the model is so to rounding.
    let sizes: Vec<f64> = (0..r).map(|i| spread[(i, i)].max(1e-18).sqrt()).collect();
    let scaled = Mat::from_fn(r, r, |i, j| spread[(i, j)] / (sizes[i] * sizes[j]));
    let fail = || ModelError::Chain { reason: "its covariance is not finite".to_owned() };
    let eigen = scaled.self_adjoint_eigen(Side::Lower).map_err(|_| fail())?;
    let (vectors, values) = (eigen.U(), eigen.S().column_vector());
    let root =
        Mat::from_fn(r, r, |i, j| vectors[(j, i)] / (sizes[j] * values[i].max(LEAST).sqrt()));
    let root = root * map;
    Ok(root.transpose() * &root)
}
