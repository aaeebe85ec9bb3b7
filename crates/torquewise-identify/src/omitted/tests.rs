//! What a term would explain, against least squares solved anew with the torque of the term.

use super::{Candidate, OmittedTermTests, Tried, candidates, test_omitted_terms};
use crate::chain_spec::ChainSpec;
use crate::learn::{Learned, TRIED_ROWS};
use crate::plan::FrictionKind;
use crate::warning::{UntriedTerm, Warning};
use faer::Mat;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use torquewise_model::expansion::energy_terms;
use torquewise_model::{EnergyTerm, Form, Model, Place, Term, Torque, Training, Trig, Weighted};
use torquewise_motion::{Motion, Signals};
use torquewise_rigid::search::all_parameters;
use torquewise_rigid::{Chain, Geometry, Rows, Search};
use torquewise_stepwise::friction::FrictionLibrary;
use torquewise_stepwise::survey::{Survey, survey, thinned};

const N: usize = 3;
const NOISE: f64 = 0.05;

/// A chain with axes at no particular angles.
fn chain() -> Chain {
    let parameters = [0.02, -0.03, 1.5, 0.1, 0.05, -0.1, 0.2, -0.1, 0.4, 0.05];
    let geometry = Geometry::new(&parameters).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let inertial = (0..10 * N).map(|_| random.random_range(0.1..2.0)).collect();
    Chain { geometry, inertial, drive: vec![], residual_rms: vec![NOISE; N], cost: 0.0 }
}

fn model(terms: &[(EnergyTerm, f64)]) -> Model {
    let weighted = |(term, coefficient): &(EnergyTerm, f64)| Weighted {
        term: term.clone(),
        coefficient: *coefficient,
        std_error: 0.0,
        inclusion: None,
    };
    Model {
        joints: (1..=N).map(|joint| format!("joint{joint}")).collect(),
        form: Form::Energy(terms.iter().map(weighted).collect()),
        friction: vec![],
        chain: None,
        stages: vec![],
        training: Training::default(),
        choices: vec![],
    }
}

/// A smooth motion with the torque of the chain, of further terms, and noise.
fn motion(rows: usize, more: &[(EnergyTerm, f64)], noise: f64) -> Motion {
    let wave = |row: usize, joint: usize, k: usize| {
        let rate = 0.7 + 0.37 * joint as f64 + 1.1 * k as f64;
        (rate, rate * 0.02 * row as f64 + (joint + 2 * k) as f64)
    };
    let signal = |of: fn(f64, f64) -> f64| {
        Mat::from_fn(rows, N, |row, joint| {
            (0..2)
                .map(|k| {
                    let (rate, x) = wave(row, joint, k);
                    of(rate, x)
                })
                .sum()
        })
    };
    let mut signals = Signals {
        joints: (1..=N).map(|joint| format!("joint{joint}")).collect(),
        t: (0..rows).map(|row| 0.02 * row as f64).collect(),
        q: signal(|_, x| x.sin()),
        dq: signal(|rate, x| rate * x.cos()),
        ddq: signal(|rate, x| -rate * rate * x.sin()),
        tau: None,
    };
    let chain = chain();
    let mut terms = energy_terms(&chain.geometry, &chain.inertial).unwrap();
    terms.extend(more.iter().cloned());
    let clean = Motion::new(signals.clone()).unwrap();
    let mut tau = Torque::new(&model(&terms)).over(&clean).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for joint in 0..N {
        for tau in tau.col_as_slice_mut(joint) {
            let unit: f64 = StandardNormal.sample(&mut random);
            *tau += noise * unit;
        }
    }
    signals.tau = Some(tau);
    Motion::new(signals).unwrap()
}

/// The same with viscous friction in joint 2.
fn rubbing(more: &[(EnergyTerm, f64)], friction: f64) -> Motion {
    let mut signals = motion(1_000, more, NOISE).into_signals();
    let tau = signals.tau.as_mut().unwrap();
    for (tau, dq) in tau.col_as_slice_mut(1).iter_mut().zip(signals.dq.col(1).iter()) {
        *tau += friction * dq;
    }
    Motion::new(signals).unwrap()
}

/// What learning ends with, had it found the chain.
fn learned(survey: &Survey) -> Learned {
    let motion = thinned(&survey.sample, TRIED_ROWS);
    let none = vec![Mat::zeros(motion.n_rows(), 0); N];
    let tau = motion.require_tau().unwrap();
    let rows = Rows::new([motion.q(), motion.dq(), motion.ddq(), tau], &none).unwrap();
    let laws = FrictionLibrary::new(vec![2.0; N]);
    let (search, free) = (Search::default(), all_parameters(N));
    let spec = ChainSpec { drive: vec![], search, free, gravity: None };
    Learned { chain: chain(), spec, choices: vec![], rows, laws }
}

fn spring() -> EnergyTerm {
    let function = Term::one(N).times(Trig::Cos, 0, 1, 1).times(Trig::Sin, 2, 1, 1);
    EnergyTerm { place: Place::Potential, function }
}

fn said(warning: Option<UntriedTerm>) -> String {
    Warning::OmittedTerm(warning.unwrap()).to_string()
}

/// What least squares leaves, squared, of columns of any rank.
fn left(columns: &Mat<f64>, residual: &[f64]) -> f64 {
    let lengths: Vec<f64> = (0..columns.ncols()).map(|j| columns.col(j).norm_l2()).collect();
    let unit = Mat::from_fn(columns.nrows(), columns.ncols(), |i, j| {
        if lengths[j] > 0.0 { columns[(i, j)] / lengths[j] } else { 0.0 }
    });
    let svd = unit.thin_svd().unwrap();
    let mut rest = faer::ColRef::from_slice(residual).to_owned();
    for j in 0..svd.S().column_vector().nrows() {
        if svd.S()[j] > 1e-6 * svd.S()[0] {
            let side = svd.U().col(j);
            let along = side.transpose() * &rest;
            rest -= side * faer::Scale(along);
        }
    }
    rest.squared_norm_l2()
}

#[test]
fn a_share_is_what_solving_least_squares_with_the_term_gains() {
    let motion = motion(300, &[(spring(), 0.2)], NOISE);
    let survey = survey(&motion).unwrap();
    let learned = learned(&survey);
    let all = candidates(&learned, FrictionKind::Linear);
    let gains = OmittedTermTests::new(&learned, &survey).unwrap().gains(&all).unwrap();

    // Another way: all rows at once, the torque of a term as a model predicts it.
    let noise = learned.chain.weights(&learned.rows);
    let tangent = learned.chain.tangent(&learned.rows, &noise).unwrap();
    let p = tangent.columns.ncols();
    let before = left(&tangent.columns, &tangent.residual);
    for (candidate, gain) in all.iter().zip(&gains).step_by(5) {
        let mut torque = model(&[]);
        match candidate {
            Candidate::Energy(term) => torque = model(&[(term.clone(), 1.0)]),
            Candidate::Friction(term) => {
                let (term, coefficient) = (term.clone(), 1.0);
                torque.friction =
                    vec![Weighted { term, coefficient, std_error: 0.0, inclusion: None }];
            }
        }
        let load = Torque::new(&torque).over(&motion).unwrap();
        let m = motion.n_rows();
        let columns = Mat::from_fn(N * m, p + 1, |k, j| {
            if j < p { tangent.columns[(k, j)] } else { noise[k / m] * load[(k % m, k / m)] }
        });

        let expected = 1.0 - left(&columns, &tangent.residual) / before;

        assert!((gain.share - expected).abs() < 1e-8, "{candidate:?}: {} {expected}", gain.share);
    }
}

#[test]
fn a_term_that_is_at_work_is_the_best_and_warned_of() {
    let survey = survey(&motion(1_000, &[(spring(), 0.5)], NOISE)).unwrap();

    let Tried { certificate: found, warning, .. } =
        test_omitted_terms(&learned(&survey), &survey, FrictionKind::Auto, &[]).unwrap();

    // 84 terms of the library, 2 springs of each joint and 12 of each pair.
    assert_eq!(found.candidates, 84 + 6 + 36);
    assert_eq!(found.best[0].term, "V: cos(q1)*sin(q3)");
    assert!(found.best[0].share > 0.8, "{found}");
    let warning = said(warning);
    assert!(warning.starts_with("V: cos(q1)*sin(q3) would lower the residual of joint"));
}

#[test]
fn where_the_chain_is_all_there_is_no_term_holds() {
    for noise in [0.0, 1e-6, NOISE, 1.0] {
        let survey = survey(&motion(1_000, &[], noise)).unwrap();

        let Tried { certificate: found, warning, .. } =
            test_omitted_terms(&learned(&survey), &survey, FrictionKind::None, &[]).unwrap();

        assert_eq!(warning, None, "{noise}: {found}");
        // The best of 177 by chance: 2 ln 177 over 3000 equations, twice that to be safe.
        assert!(noise < NOISE || found.best[0].share < 0.007, "{noise}: {found}");
    }
}

#[test]
fn friction_that_was_not_asked_for_is_found() {
    let survey = survey(&rubbing(&[], 0.8)).unwrap();

    let Tried { certificate: found, warning, .. } =
        test_omitted_terms(&learned(&survey), &survey, FrictionKind::None, &[]).unwrap();

    assert_eq!((found.best[0].term.as_str(), found.best[0].joint.as_str()), ("dq2", "joint2"));
    assert!(said(warning).ends_with("try --friction auto"));
}

#[test]
fn an_energy_is_missing_though_friction_explains_more() {
    let survey = survey(&rubbing(&[(spring(), 1.0)], 0.6)).unwrap();

    let tried = test_omitted_terms(&learned(&survey), &survey, FrictionKind::None, &[]).unwrap();

    assert_eq!(tried.certificate.best[0].term, "dq2");
    assert!(said(tried.warning).ends_with("try --friction auto"));
    assert_eq!(tried.missing, Some(spring()));
}

#[test]
fn a_refused_term_is_warned_of_and_not_missing() {
    let survey = survey(&motion(1_000, &[(spring(), 0.5)], NOISE)).unwrap();

    let tried =
        test_omitted_terms(&learned(&survey), &survey, FrictionKind::Auto, &[spring()]).unwrap();

    assert!(said(tried.warning).ends_with("a longer log would tell"));
    assert_ne!(tried.missing, Some(spring()));
}

#[test]
fn a_term_at_work_is_taken_in_with_its_coefficient() {
    let survey = survey(&motion(1_000, &[(spring(), 0.5)], NOISE)).unwrap();
    let mut learned = learned(&survey);

    assert!(learned.offer(&spring(), &survey.sample).unwrap());

    // Noise of 0.05 in 3000 equations on a column of about unit size.
    assert!((learned.chain.drive[0] - 0.5).abs() < 0.01, "{}", learned.chain.drive[0]);
    assert_eq!(learned.choices.last().unwrap().chosen, spring().name());
}

#[test]
fn a_term_that_is_not_at_work_is_refused() {
    let survey = survey(&motion(1_000, &[], NOISE)).unwrap();
    let mut learned = learned(&survey);

    assert!(!learned.offer(&spring(), &survey.sample).unwrap());

    assert_eq!((learned.spec.drive.len(), learned.chain.drive.len()), (0, 0));
    assert_eq!(learned.choices.last().unwrap().chosen, "none");
}

#[test]
fn the_same_bits_at_any_number_of_threads() {
    let survey = survey(&motion(400, &[(spring(), 0.1)], NOISE)).unwrap();
    let learned = learned(&survey);
    let found_with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            test_omitted_terms(&learned, &survey, FrictionKind::Linear, &[]).unwrap().certificate
        })
    };

    assert_eq!(found_with(1), found_with(2));
}
