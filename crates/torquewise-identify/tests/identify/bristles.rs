//! LuGre friction, which is no law of the learner, is known at rest and at reversal.

use crate::support::{chain, fit, reference_arm};
use torquewise_identify::{FrictionKind, Reconstruction};
use torquewise_model::Torque;
use torquewise_model::learned::joint_geometry;
use torquewise_model::shaft_friction::{Estimated, ShaftFriction};
use torquewise_motion::Motion;
use torquewise_sim::{Friction, MotionKind, MotionPlan, SimulatedLog};

/// Slower than this \[rad/s\] a joint is at rest or turns round.
const SLOW: f64 = 0.05;

/// Coulomb friction of the joints \[N·m\], and how much viscous friction \[s/rad\] goes with it.
const COULOMB: [f64; 3] = [12.0, 15.0, 6.0];
const VISCOUS: f64 = 0.2;
/// \[N·m/rad\]: the bristles slip after 5 to 13 mrad, those of the first joint after 10.
const STIFFNESS: f64 = 1_200.0;

fn log(seconds: f64, seed: u64) -> Motion {
    let arm = reference_arm();
    let row = |(name, coulomb): (&String, f64)| {
        let (stiction, viscous) = (1.3 * coulomb, VISCOUS * coulomb);
        format!(
            "[{name}]\ncoulomb = {coulomb:?}\nstiction = {stiction:?}\nspeed = 0.05\n\
             viscous = {viscous:?}\nstiffness = {STIFFNESS:?}\n"
        )
    };
    let text: String = arm.joints().iter().zip(COULOMB).map(row).collect();
    let friction = Friction::from_toml(&text, arm.joints()).unwrap();
    let plan = MotionPlan { kind: MotionKind::Moves, seconds, rate: 250.0, seed };
    let log = SimulatedLog::new(&arm, &plan).unwrap();
    log.with_friction(friction).unwrap().whole().unwrap().motion
}

/// RMS error of each joint at the rows at which it is slow \[N·m\].
fn slow_errors(found: &Reconstruction, test: &Motion) -> Vec<f64> {
    let (tau, predicted) = (test.tau().unwrap(), Torque::new(&found.model).over(test).unwrap());
    (0..test.n_joints())
        .map(|joint| {
            let slow = (0..test.n_rows()).filter(|&row| test.dq()[(row, joint)].abs() < SLOW);
            let squares: Vec<f64> =
                slow.map(|row| (tau[(row, joint)] - predicted[(row, joint)]).powi(2)).collect();
            (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
        })
        .collect()
}

#[test]
fn friction_at_rest_and_reversal_is_remembered_and_reads_as_it_was_planted() {
    let (train, test) = (log(60.0, 1), log(20.0, 7));

    let found = fit(&train, &chain(FrictionKind::Auto));
    let with = slow_errors(&found, &test);
    let without = slow_errors(&fit(&train, &chain(FrictionKind::Stribeck)), &test);

    let halved = with.iter().zip(&without).all(|(with, without)| *with <= 0.5 * without);
    assert!(halved, "{with:?} with memory, {without:?} without");
    let joints = ShaftFriction::all(&found.model);
    let is_near = |found: Option<Estimated>, planted: f64, part: f64| {
        found.is_some_and(|found| (found.value / planted - 1.0).abs() < part)
    };

    // Laws without a memory are averaged in, and stiffer; 5 mrad lie midway between two travels.
    for ((joint, coulomb), part) in joints.iter().zip(COULOMB).zip([0.25, 0.25, 0.4]) {
        let found = joint.parameters();
        assert!(is_near(found.forward.coulomb, coulomb, 0.1), "{found:?}");
        assert!(is_near(found.forward.viscous, VISCOUS * coulomb, 0.1), "{found:?}");
        assert!(is_near(found.stiffness, STIFFNESS, part), "{found:?}");
    }
    // No axis makes up for what friction remembers: the third stands as the second does.
    let axes = joint_geometry(&found.model).unwrap();
    let angles = axes.iter().filter_map(|axis| Some(axis.angle_to_previous_deg?.value));
    assert_eq!(angles.collect::<Vec<f64>>(), [90.0, 0.0]);
}
