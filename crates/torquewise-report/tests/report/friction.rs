//! A report of a model with friction shows it as a part of its own, and loops where it remembers.

use crate::{findings, fitted};
use torquewise_model::{FrictionLaw, FrictionTerm, Weighted};
use torquewise_report::{Findings, fit_report};

/// The report of a fit in which the second joint rubs by a law, if by any.
fn report(law: Option<FrictionLaw>) -> String {
    let term = |law| FrictionTerm::of_joint(2, 1, law);
    let rubs = |law| Weighted { std_error: 0.01, ..Weighted::new(term(law), 0.7) };
    let friction: Vec<_> = law.into_iter().map(rubs).collect();
    let (found, diagnosis) = fitted(10.0, |found| found.model.friction.clone_from(&friction));
    fit_report(&Findings { test: Some(&diagnosis), ..findings(&found, &diagnosis) }).unwrap()
}

#[test]
fn friction_is_drawn_written_and_weighed() {
    let (without, with) = (report(None), report(Some(FrictionLaw::Coulomb { width: 0.0 })));

    let [before, after] = [&without, &with].map(|html| html.matches("\"friction\"").count());
    // One curve for the joint that rubs, in the log, in the other motion and among the parts of its
    // torque; none for the first.
    assert_eq!(after, before + 3);
    assert!(!without.contains("<div class=\"part\">friction</div>"));
    assert_eq!(with.matches("<div class=\"part\">friction</div>").count(), 1);
    assert!(with.contains("One term is friction.") && with.contains("∂q + friction"));
    // The section: its numbers, and a curve of the joint that rubs.
    assert!(with.contains("0.700 ± 0.010") && with.contains("F_c [N·m]"));
    let curves = |html: &str| html.matches("\"label\":\"− 2 errors\"").count();
    assert_eq!([curves(&without), curves(&with)], [0, 1]);
    // Beside the energies, in the torque that follows and among the shares of the torque.
    assert_eq!(with.matches("<mi>sign</mi>").count(), 3);
    assert!(with.contains("friction of joint2 [N·m]") && !with.contains("friction of joint1"));
}

#[test]
fn friction_that_remembers_is_drawn_as_a_loop_beside_the_log() {
    let html = report(Some(FrictionLaw::Dahl { travel: 0.01 }));

    let of_loop = html.split("\"position [rad]\"").find(|chart| chart.contains("model, backward"));
    let measured = of_loop.unwrap().split("\"mark\":\"rings\"").nth(1).unwrap();
    let heights = measured.split("\"y\":[").nth(1).unwrap().split(']').next().unwrap();
    assert!(heights.split(',').count() > 4, "{heights}");
    assert!(html.contains("0.02302585093"), "the travel, ln 10 of that of the element");
}
