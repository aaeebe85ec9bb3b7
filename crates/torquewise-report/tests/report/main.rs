//! Reports, read as text; `python/tests/test_report_page.py` opens them in a real browser.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod arm;
mod call_cost;
mod friction;

use torquewise_identify::verdict::judge;
use torquewise_identify::{Diagnosis, Plan, Reconstruction, diagnose, reconstruct};
use torquewise_motion::Motion;
use torquewise_report::{Findings, Origin};
use torquewise_sim::{Arm, MotionPlan, simulate};

/// So many seconds of motion of an arm, 50 rows each.
fn log(arm: &str, seconds: f64) -> Motion {
    let plan = MotionPlan { seconds, rate: 50.0, ..MotionPlan::default() };
    simulate(&Arm::builtin(arm).unwrap(), &plan).unwrap().motion
}

/// What is found in such a log of two joints, changed, with its diagnosis.
fn fitted(seconds: f64, change: impl Fn(&mut Reconstruction)) -> (Reconstruction, Diagnosis) {
    let log = log("planar-2", seconds);
    let mut found = reconstruct(&log, &Plan::default(), torquewise_identify::UNWATCHED).unwrap();
    change(&mut found);
    let diagnosis = diagnose(&found.model, &found.patterns, &log).unwrap();
    (found, diagnosis)
}

/// Findings without test, checks, costs or origin.
fn findings<'a>(found: &'a Reconstruction, diagnosis: &'a Diagnosis) -> Findings<'a> {
    let verdict = Box::leak(Box::new(judge(found)));
    let origin = Origin::default();
    Findings { found, verdict, diagnosis, checks: None, test: None, costs: &[], origin }
}
