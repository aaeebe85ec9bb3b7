//! Chains fitted on every row: intervals, longer logs, physics, rounds through files.

use crate::chain::{FRICTION, linear, rubbing};
use crate::support::{chain, fit, motion, noisy, normals, reference_arm};
use crate::truth::energies_in;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::LazyLock;
use torquewise_identify::rounds::Request;
use torquewise_identify::summary::summarise_again;
use torquewise_identify::{
    FrictionKind, IdentifyError, Plan, Reconstruction, Solution, Summary, UNWATCHED, score, solve,
    summarise,
};
use torquewise_logs::{ConditionedLogs, Logs};
use torquewise_model::checks::driving_friction;
use torquewise_model::{
    EnergyTerm, Factor, Form, FrictionLaw, Model, Place, Term, Torque, Trig, to_json,
};
use torquewise_motion::{Conditioning, Motion};
use torquewise_sim::{MotionKind, Noise, add_noise};

/// A normal variable is within this many standard deviations in 90 of 100 cases.
const NINETY_PERCENT: f64 = 1.645;
/// Logs over which intervals are counted.
const LOGS: u64 = 20;

/// Sines of the arm with friction, and the noise of a case in q, q̇ and q̈.
fn log(seconds: f64, seed: u64) -> Motion {
    noisy(&with_friction(&sines(seconds, 100.0, seed)), 2, seed)
}

fn sines(seconds: f64, rate: f64, seed: u64) -> Motion {
    motion(&reference_arm(), MotionKind::Sines, seconds, rate, seed)
}

fn with_friction(clean: &Motion) -> Motion {
    rubbing(clean, &linear(clean, &FRICTION), 0.0)
}

fn plan() -> Plan {
    chain(FrictionKind::Linear)
}

/// The harmonics of sums of angles up to twice each, of all joints.
fn harmonics() -> Vec<Term> {
    let all = (0_i8..125).map(|k| [k / 25, k / 5 % 5, k % 5].map(|digit| digit - 2));
    // cos(−x) and sin(−x) are no others.
    let once = all.filter(|all| all.iter().find(|k| **k != 0).is_some_and(|k| *k > 0));
    let both = |multiples: [i8; 3]| {
        [Trig::Cos, Trig::Sin].map(|function| {
            let factor = Factor { multiples: multiples.to_vec(), function, power: 1 };
            Term { factors: vec![factor], ..Term::one(3) }
        })
    };
    once.flat_map(both).collect()
}

/// Products of 1, cos kq and sin kq of each joint.
fn products() -> Vec<Term> {
    let mut all = vec![Term::one(3)];
    for joint in 0..3 {
        let more = all.iter().flat_map(|term| {
            [(Trig::Cos, 1), (Trig::Sin, 1), (Trig::Cos, 2), (Trig::Sin, 2)]
                .map(|(trig, multiple)| term.clone().times(trig, joint, multiple, 1))
        });
        all = all.iter().cloned().chain(more.collect::<Vec<_>>()).collect();
    }
    all
}

/// The true coefficients of M and V, by name, in products and in sums of angles.
static TRUTH: LazyLock<BTreeMap<String, f64>> = LazyLock::new(|| {
    let sums = std::iter::once(Term::one(3)).chain(harmonics()).collect();
    let inertia = (0..3).flat_map(|i| (i..3).map(move |j| Place::Inertia(i, j)));
    let places: Vec<Place> = std::iter::once(Place::Potential).chain(inertia).collect();
    let mut truth = BTreeMap::new();
    for basis in [sums, products()] {
        let functions = places.iter().flat_map(|&place| {
            let known =
                basis.iter().filter(move |f| place != Place::Potential || **f != Term::one(3));
            known.map(move |function| EnergyTerm { place, function: function.clone() })
        });
        let found = energies_in(&reference_arm(), functions.collect());
        truth.extend(found.into_iter().map(|(term, weight)| (term.name(), weight)));
    }
    truth
});

/// Errors of the coefficients of a model in standard errors, by name; terms that the arm does not
/// have are left out.
fn deviations(model: &Model) -> Vec<(String, f64)> {
    let Form::Energy(terms) = &model.form else { panic!("a chain has energies") };
    let energies = terms.iter().filter_map(|w| {
        let truth = TRUTH.get(&w.term.name())?;
        Some((w.term.name(), (w.coefficient - truth) / w.std_error))
    });
    let friction = model.friction.iter().map(|w| {
        let joint = w.term.shaft.iter().position(|share| *share != 0.0).unwrap();
        let (place, law) = match w.term.law {
            FrictionLaw::Offset => (0, "offset"),
            FrictionLaw::Viscous => (1, "viscous"),
            _ => (2, "dry"),
        };
        let name = format!("{law} friction of joint {}", joint + 1);
        (name, (w.coefficient - FRICTION[joint][place]) / w.std_error)
    });
    energies.chain(friction).collect()
}

/// Positions and torque of a log of the arm with friction, both noisy, as a file has them: rows are
/// derived from them and filtered.
fn fit_filtered(seed: u64) -> Reconstruction {
    let clean = sines(60.0, 250.0, seed);
    let torque = with_friction(&clean);
    let q = add_noise(&clean, &Noise::from_db(70.0, f64::INFINITY, f64::INFINITY).unwrap(), seed);
    let (q, tau) = (q.unwrap(), torque.tau().unwrap());
    let mut normal = normals(1_000 + seed);
    let mut text = String::from("t,q1,q2,q3,tau1,tau2,tau3\n");
    for row in 0..clean.n_rows() {
        let q = (0..3).map(|joint| q.q()[(row, joint)]);
        let noise = [0.5, 2.0, 0.5].map(|spread| spread * normal());
        let tau = (0..3).map(|joint| tau[(row, joint)] + noise[joint]);
        let values: Vec<String> =
            std::iter::once(clean.t()[row]).chain(q).chain(tau).map(|x| format!("{x:?}")).collect();
        writeln!(text, "{}", values.join(",")).unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    std::fs::write(&path, text).unwrap();
    let logs = Logs::open(&[path]).unwrap();
    let rows = ConditionedLogs::new(logs, &Conditioning::default()).unwrap();
    eprintln!("cut-off {:?}", rows.report.cutoff);
    fit(&rows, &plan())
}

/// Counts how many intervals of 90 % hold the truth, over many logs: of energy terms, of friction.
fn intervals_that_hold(fit: impl Fn(u64) -> Reconstruction) -> [(f64, u64); 2] {
    let models: Vec<Model> = (1..=LOGS).map(|seed| fit(seed).model).collect();
    let mut all: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for model in &models {
        assert!(model.chain.as_ref().unwrap().is_feasible());
        for (name, x) in deviations(model) {
            all.entry(name).or_default().push(x);
        }
    }
    let holds = |x: &&f64| x.abs() <= NINETY_PERCENT;
    for (name, x) in &all {
        let rms = (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt();
        let held = x.iter().filter(holds).count();
        eprintln!("{name}: {held} of {}, errors of {rms:.2} standard errors", x.len());
    }
    let (energy, friction): (Vec<_>, Vec<_>) = all.iter().partition(|(name, _)| name.contains(':'));
    [("M and V", energy), ("friction", friction)].map(|(what, part)| {
        let x: Vec<f64> = part.iter().flat_map(|(_, x)| x.iter().copied()).collect();
        let share = x.iter().filter(holds).count() as f64 / x.len() as f64;
        eprintln!("{what}: {share:.3} of {} intervals", x.len());
        (share, x.len() as u64)
    })
}

#[test]
fn intervals_of_ninety_percent_hold_the_truth_in_about_ninety_of_a_hundred_cases() {
    let [(energy, terms), (friction, laws)] =
        intervals_that_hold(|seed| fit(&log(60.0, seed), &plan()));

    assert!(terms >= 15 * LOGS && laws >= 9 * LOGS, "{terms} terms, {laws} laws");
    assert!((0.8..=0.98).contains(&energy), "M and V: {energy}");
    assert!((0.8..=0.98).contains(&friction), "friction: {friction}");
}

/// Dry friction is left out of the count: a filter rounds the corners of its sign, and so the
/// intervals of dry and viscous friction do not hold the truth.
#[test]
fn intervals_of_filtered_rows_hold_the_truth_of_the_links_as_often() {
    let [(energy, terms), _] = intervals_that_hold(fit_filtered);

    assert!(terms >= 12 * LOGS, "{terms} terms");
    assert!((0.8..=0.98).contains(&energy), "M and V: {energy}");
}

/// RMS error of what moves the links of a model over its size, on a motion without noise.
fn error(model: &Model) -> f64 {
    let test = sines(20.0, 50.0, 99);
    let links = Model { friction: vec![], ..model.clone() };
    let tau = test.tau().unwrap();
    let wrong = Torque::new(&links).over(&test).unwrap() - tau;
    wrong.norm_l2() / tau.norm_l2()
}

#[test]
fn a_log_ten_times_as_long_has_at_most_half_the_error() {
    let of = |seconds: f64| -> f64 {
        (1..=3).map(|seed| error(&fit(&log(seconds, seed), &plan()).model)).sum::<f64>() / 3.0
    };

    let [short, long] = [20.0, 200.0].map(of);

    eprintln!("{short:.2e} of a short log, {long:.2e} of a long one");
    assert!(long < 0.5 * short, "{short} of a short log, {long} of a long one");
}

#[test]
fn a_chain_is_a_physical_arm_whose_residual_is_its_score() {
    let log = log(30.0, 1);
    let model = fit(&log, &plan()).model;
    let mut random = ChaCha8Rng::seed_from_u64(3);

    assert!(model.chain.as_ref().unwrap().is_feasible());
    assert_eq!(driving_friction(&model), None);
    let torque = Torque::new(&model);
    for _ in 0..10_000 {
        let q: Vec<f64> = (0..3).map(|_| random.random_range(-10.0..10.0)).collect();
        let mass = torque.mass_matrix(&q).unwrap();
        assert!(mass.llt(faer::Side::Lower).is_ok(), "M at {q:?}");
    }
    let scores = score(&model, &log).unwrap();
    for (joint, rms) in scores.joints.iter().zip(&model.training.residual_rms) {
        assert!((joint.rmse / rms - 1.0).abs() < 1e-9, "{} and {rms}", joint.rmse);
    }
}

/// Sums up parts apart, merges them in some order and solves, round by round, all through the
/// bytes of files.
fn by_files(parts: &[Motion], orders: &[[usize; 3]]) -> String {
    let read = |summary: &Summary| Summary::from_bytes(&summary.to_bytes().unwrap()).unwrap();
    let merged = |parts: Vec<Summary>, order: [usize; 3]| {
        let mut all = read(&parts[order[0]]);
        order[1..].iter().for_each(|&k| all.merge(&read(&parts[k])).unwrap());
        read(&all)
    };
    let first = parts.iter().map(|log| summarise(log, &plan(), "", UNWATCHED).unwrap());
    let mut all = merged(first.collect(), orders[0]);
    for round in 1.. {
        match solve(all, &plan(), UNWATCHED).unwrap() {
            Solution::Model(found) => return to_json(&found.model).unwrap(),
            Solution::Request(request) => {
                let request = Request::from_bytes(&request.to_bytes().unwrap()).unwrap();
                let again = parts
                    .iter()
                    .map(|log| summarise_again(log, &plan(), "", &request, UNWATCHED).unwrap());
                all = merged(again.collect(), orders[round % orders.len()]);
            }
        }
    }
    unreachable!("rounds end")
}

#[test]
fn rounds_through_files_in_any_order_give_the_model_of_a_fit_byte_for_byte() {
    let parts = [log(20.0, 1), log(31.0, 2), log(12.0, 3)];

    let fitted = to_json(&fit(&parts[..], &plan()).model).unwrap();

    assert!(by_files(&parts, &[[2, 0, 1], [0, 1, 2], [1, 2, 0]]) == fitted, "two models");
}

#[test]
fn a_request_of_other_logs_does_not_add_up() {
    let parts = [log(12.0, 1), log(12.0, 2)];
    let [one, other] = parts.each_ref().map(|log| {
        let summary = summarise(log, &plan(), "", UNWATCHED).unwrap();
        let Solution::Request(request) = solve(summary, &plan(), UNWATCHED).unwrap() else {
            panic!("a chain asks for a pass");
        };
        summarise_again(log, &plan(), "", &request, UNWATCHED).unwrap()
    });

    let error = one.clone().merge(&other).unwrap_err();

    assert!(matches!(error, IdentifyError::Apart { what: "requests", .. }), "{error}");
}
