//! The report of a learned chain of six joints: what comes first, and what is left out.

use crate::{findings, log};
use std::f64::consts::FRAC_PI_2;
use torquewise_identify::verdict::{judge, judge_by};
use torquewise_identify::{PatternPlan, Reconstruction, Warning, diagnose, find_patterns, survey};
use torquewise_model::{Form, FrictionLaw, FrictionTerm, Model, RigidChain, Training, Weighted};
use torquewise_report::{Findings, LogFile, Origin, ReportError, fit_report};

const JOINTS: usize = 6;

/// A chain whose axes stand across each other, 0.3 m apart, with friction at each joint.
fn model(joints: &[String]) -> Model {
    let link = [1.0, 0.1, 0.0, 0.0, 0.1, 0.1, 0.1, 0.0, 0.0, 0.0];
    let across = [[FRAC_PI_2, 0.0, 0.3, 0.0]; JOINTS - 1];
    let chain = RigidChain {
        geometry: [0.0, 0.0].into_iter().chain(across.concat()).collect(),
        fitted: vec![4],
        links: vec![link; JOINTS],
        ..RigidChain::default()
    };
    let laws = [FrictionLaw::Coulomb { width: 0.01 }, FrictionLaw::Viscous];
    let friction = (0..JOINTS).flat_map(|joint| {
        let term = |law| FrictionTerm::of_joint(JOINTS, joint, law);
        laws.map(|law| Weighted { std_error: 0.01, ..Weighted::new(term(law), 0.5) })
    });
    let training = Training {
        residual_rms: vec![0.1; JOINTS],
        torque_std: vec![1.0; JOINTS],
        held_out_rms: vec![0.2; JOINTS],
        held_out_by_region_rms: vec![0.1; JOINTS],
        ..Training::default()
    };
    Model {
        joints: joints.to_vec(),
        form: Form::Energy(Vec::new()),
        chain: Some(chain),
        friction: friction.collect(),
        training,
        ..Model::default()
    }
}

fn report() -> String {
    let log = log("generic-6", 20.0);
    let survey = survey(&log).unwrap();
    let patterns = find_patterns(&survey, &PatternPlan::default()).unwrap();
    let range = Warning::Range { joint: "joint3".into(), range: 0.1 };
    let mut found = Reconstruction {
        model: model(log.joints()),
        noise: survey.noise.clone(),
        survey,
        patterns,
        candidates: 0,
        steps: Vec::new(),
        dropped: Vec::new(),
        warnings: vec![range],
    };
    let diagnosis = diagnose(&found.model, &found.patterns, &log).unwrap();
    let logs = &[LogFile { name: "a.csv".into(), date: "2001-02-03".into() }];
    let command = "torquewise fit a.csv -o 'my model.json'";
    let origin = Origin { logs, tests: logs, model: "m.json", command, date: "2001-02-04" };
    let errors = diagnosis.scores.joints.iter().map(|score| 0.01 * score.nrmse_percent);
    let errors: Vec<f64> = errors.collect();
    found.model.training.verdict = Some(judge(&found));
    let verdict = &judge_by(&found.model, &errors, None);
    let test = Some(&diagnosis);
    fit_report(&Findings { verdict, test, origin, ..findings(&found, &diagnosis) }).unwrap()
}

#[test]
fn residuals_of_another_arm_are_refused() {
    let (mut found, diagnosis) = crate::fitted(10.0, |_| {});
    found.model.joints.pop();

    let refused = fit_report(&findings(&found, &diagnosis));

    assert!(matches!(refused, Err(ReportError::Joints { .. })));
}

#[test]
fn the_verdict_comes_first_and_what_a_chain_does_not_have_is_left_out() {
    let html = report();

    let (at, chart) = (|words: &str| html.find(words), html.find("id=\"chart-1\"").unwrap());
    let first = [
        "<strong>Unusable</strong>",
        "test torque of joint",
        "held-out error 20.00 to 20.00 %",
        ">test log [%]<",
        "swing it further",
        "torquewise evaluate m.json LOG",
    ];
    let places = first.map(|words| at(words).expect(words));
    assert!(places.is_sorted() && places[5] < chart, "{places:?}, charts from {chart}");
    for absent in ["<h2>Method", "<h2>Physics", "<h2>Cost"] {
        assert_eq!(at(absent), None, "{absent}");
    }
    let foot = html.split("<footer>").nth(1).unwrap().split("</footer>").next().unwrap();
    let version = env!("CARGO_PKG_VERSION");
    let made = format!("torquewise {version}. Report: 2001-02-04. Newest log: 2001-02-03.");
    assert!(foot.contains(&made));
    assert!(foot.contains("fit a.csv -o &#x27;my model.json&#x27;"), "{foot}");
}
