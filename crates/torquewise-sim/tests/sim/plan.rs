//! Plans: within all limits at every instant, at rest at both ends, the same for the same seed.

use std::collections::BTreeSet;
use std::sync::LazyLock;
use torquewise_motion::Recording;
use torquewise_sim::excite::{
    Excitation, ExcitationPlan, JointValues, Limits, State, Torques, Wishes, excite,
    joint_trajectory, limits, waypoints,
};
use torquewise_sim::{Arm, SimError};

/// Three joints of different ranges, speeds and accelerations.
fn three_joints() -> Vec<Limits> {
    let each = |values: &[f64]| JointValues(values.iter().map(|value| (None, *value)).collect());
    let wishes = Wishes {
        range: JointValues(vec![(None, [-2.5, 2.0]), (None, [0.3, 1.9]), (None, [-0.8, 2.4])]),
        velocity: each(&[1.5, 2.0, 3.0]),
        acceleration: each(&[2.0, 1.0, 4.0]),
        ..Wishes::default()
    };
    limits(&Arm::builtin("puma560-3").unwrap(), &wishes).unwrap()
}

fn quick() -> ExcitationPlan {
    ExcitationPlan { seconds: [30.0, 100.0, 40.0], tries: 6, seed: 4, ..ExcitationPlan::default() }
}

fn planned(plan: &ExcitationPlan) -> Excitation {
    excite(&three_joints(), None, plan, &mut |_, _| {}).unwrap()
}

static POSES: LazyLock<Excitation> = LazyLock::new(|| planned(&quick()));
static CREEPS: LazyLock<Excitation> =
    LazyLock::new(|| planned(&ExcitationPlan { slow_sweeps: true, seed: 5, ..quick() }));

/// Time and state of each row, as a reader sees them.
fn rows(recording: &impl Recording) -> Vec<(f64, State)> {
    let mut rows = Vec::new();
    let read = recording.read(&mut |_, block| {
        for row in 0..block.n_rows() {
            let [q, dq, ddq] = block.state(row);
            rows.push((block.t()[row], State { q, dq, ddq }));
        }
        Ok(())
    });
    read.unwrap();
    rows
}

/// Whether no joint accelerates.
fn is_steady(state: &State) -> bool {
    state.ddq.iter().all(|ddq| *ddq == 0.0)
}

#[test]
fn rows_begin_and_end_at_rest_at_home_and_have_the_peaks_told() {
    // Joint 2 cannot be at zero: the middle of its range.
    let home = [0.0, 1.1, 0.0];
    for (recording, peaks) in POSES.recordings.iter().zip(&POSES.peaks) {
        let rows = rows(recording);

        for (_, state) in [&rows[0], rows.last().unwrap()] {
            assert!(state.q.iter().zip(home).all(|(q, home)| (q - home).abs() < 1e-12));
            assert_eq!(*state, State::at_rest(&state.q));
        }
        assert_eq!(rows.len(), recording.n_rows());
        assert!(rows.last().unwrap().0 - recording.seconds < 0.01);
        for (joint, peak) in peaks.iter().enumerate() {
            let largest = rows.iter().map(|(_, state)| state.dq[joint].abs()).fold(0.0, f64::max);
            assert!(largest <= peak.velocity && largest > 0.99 * peak.velocity, "{peak:?}");
        }
    }
}

#[test]
fn every_instant_is_within_the_limits_and_derivatives_are_those_of_what_never_jumps() {
    let limits = three_joints();
    for recording in POSES.recordings.iter().chain(&CREEPS.recordings) {
        let step = 1e-4;
        let steps = (recording.seconds / step).ceil();
        let (mut before, mut k, mut bends) = (recording.state_at(0.0), 1.0, 0);
        while k <= steps {
            let state = recording.state_at(k * step);
            for (joint, limits) in limits.iter().enumerate() {
                let most = limits.planned;
                let ([lower, upper], slack) = (most.position, 1e-12);
                let [q, dq, ddq] = [&state.q, &state.dq, &state.ddq].map(|x| x[joint]);
                assert!(lower - slack <= q && q <= upper + slack, "{k} {q}");
                assert!(dq.abs() <= most.velocity + slack, "{k} {state:?}");
                assert!(ddq.abs() <= most.acceleration + slack, "{k} {state:?}");

                let pushed = ddq - before.ddq[joint];
                // Slow strokes ramp up in a hundredth of a second.
                let jerk = 600.0 * most.acceleration;
                assert!(pushed.abs() <= jerk * step * 1.001 + slack, "{k} {joint} {pushed}");
                // Trapezoids miss h³/12 of the second derivative of what they sum, and h²/8 of a jump
                // of its first one, where a ramp begins or ends.
                let missed = |now: f64, last: f64, rates: [f64; 2]| {
                    (now - last - step * f64::midpoint(rates[0], rates[1])).abs()
                };
                assert!(missed(q, before.q[joint], [before.dq[joint], dq]) < 1e-9, "{k} {joint}");
                bends += usize::from(missed(dq, before.dq[joint], [before.ddq[joint], ddq]) > 1e-7);
            }
            before = state;
            k += 1.0;
        }
        assert!(bends as f64 <= 0.01 * steps, "{bends} of {steps} instants");
    }
}

#[test]
fn every_joint_sweeps_alone_fast_and_slow_in_both_directions_without_acceleration() {
    let rows = rows(&POSES.recordings[1]);
    let steady = || rows.iter().map(|(_, state)| state).filter(|state| is_steady(state));
    let uniform = steady().filter(|state| state.dq.iter().any(|dq| *dq != 0.0)).count();
    assert!(uniform * 3 > rows.len(), "{uniform} of {}", rows.len());
    for joint in 0..3 {
        let alone = |state: &&State| (0..3).all(|k| (state.dq[k] == 0.0) == (k != joint));
        #[expect(clippy::cast_possible_truncation, reason = "a few rad/s")]
        let speed = |state: &State| (state.dq[joint] * 1e6).round() as i64;
        let speeds: BTreeSet<i64> = steady().filter(alone).map(speed).collect();
        assert!(speeds.len() >= 4, "{joint}: {speeds:?}");
        assert!(speeds.iter().all(|speed| speeds.contains(&-speed)), "{joint}: {speeds:?}");
    }
    assert_eq!(POSES.not_alone, [""; 0]);
}

#[test]
fn creeping_joints_pass_their_poses_slowly_in_both_directions() {
    let most: Vec<f64> = three_joints().iter().map(|limits| limits.planned.velocity).collect();
    let mut directions = [[0_usize; 2]; 3];
    for (_, state) in rows(&CREEPS.recordings[0]) {
        let mut speeds = state.dq.iter().zip(&most);
        if is_steady(&state) && speeds.all(|(dq, most)| *dq != 0.0 && dq.abs() < 0.021 * most) {
            for (joint, counts) in directions.iter_mut().enumerate() {
                counts[usize::from(state.dq[joint] > 0.0)] += 1;
            }
        }
    }

    for [back, there] in directions {
        assert!(back > 300 && back.abs_diff(there) < back / 10, "{directions:?}");
    }
}

#[test]
fn a_plan_tells_more_than_a_random_one() {
    for found in [&*POSES, &*CREEPS] {
        for (planned, random) in found.criteria.iter().zip(&found.random) {
            assert!(planned.information > random.information, "{planned:?} {random:?}");
        }
        let [planned, random] = [found.criteria[2], found.random[2]].map(|own| own.condition);
        assert!(planned.is_finite() && planned <= random, "{planned} {random}");
    }
    // 76 energies, of which V holds 18 and M six constants, and three laws of each joint.
    let shares = |found: &Excitation| found.criteria.map(|criterion| criterion.columns);
    assert_eq!([shares(&POSES), shares(&CREEPS)], [[21, 79, 85], [24, 79, 85]]);
}

/// A plan of two links in a vertical plane, with limits of the torque \[N·m\].
fn limited(most: [f64; 2]) -> Result<Excitation, SimError> {
    let arm = Arm::builtin("planar-2").unwrap();
    let most = JointValues(most.map(|most| (None, most)).to_vec());
    let torques = Torques::of_arm(&arm, &most)?;
    let plan = ExcitationPlan { home: Some(vec![-1.5, 0.0]), ..quick() };
    excite(&limits(&arm, &Wishes::default())?, torques.as_ref(), &plan, &mut |_, _| {})
}

#[test]
fn torques_of_a_plan_stay_within_those_of_the_drives() {
    let arm = Arm::builtin("planar-2").unwrap();
    let free = limited([1e3; 2]).unwrap();
    let most = free.torques.as_ref().unwrap().iter().map(|peak| 0.9 * peak).collect::<Vec<_>>();

    let weak = limited([most[0], most[1]]).unwrap();

    let mut peaks = [0.0_f64; 2];
    for (_, State { q, dq, ddq }) in weak.recordings.iter().flat_map(rows) {
        let tau = arm.inverse_dynamics(&q, &dq, &ddq);
        peaks.iter_mut().zip(tau).for_each(|(peak, tau)| *peak = peak.max(tau.abs()));
    }
    assert!(peaks[0] <= most[0] && peaks[1] <= most[1], "{peaks:?} {most:?}");
    assert!(peaks[0] > 0.5 * most[0], "{peaks:?} {most:?}: what there is, is used");
    assert!(weak.speed <= free.speed, "{}", weak.speed);
    assert!(weak.criteria[2].condition.is_finite());
}

#[test]
fn torques_that_do_not_hold_the_arm_are_refused_with_the_joint() {
    let error = limited([1e3, 0.01]).unwrap_err();
    assert!(matches!(&error, SimError::Weak { joint, .. } if joint == "joint2"), "{error}");
    let error = limited([1.0, -1.0]).unwrap_err();
    assert!(error.to_string().contains("torque limit of joint `joint2`"), "{error}");
}

#[test]
fn a_seed_gives_the_same_bits_and_another_seed_another_plan() {
    let plan = ExcitationPlan { tries: 3, seconds: [10.0, 40.0, 20.0], ..quick() };
    let text = |plan: &ExcitationPlan| {
        let found = planned(plan);
        found.recordings.map(|recording| joint_trajectory(&recording, 20.0).unwrap())
    };

    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let alone = one_thread.install(|| text(&plan));

    assert_eq!(text(&plan), alone);
    assert_ne!(text(&ExcitationPlan { seed: 5, ..plan }), alone);
}

/// The polynomial of order 5 through position, velocity and acceleration at both ends.
fn spline([t, h]: [f64; 2], [q, dq, ddq]: [f64; 3], [to, dto, ddto]: [f64; 3]) -> f64 {
    let x = t / h;
    let (v, a, w, b) = (dq * h, ddq * h * h, dto * h, ddto * h * h);
    let d = to - q;
    let c3 = 10.0 * d - 6.0 * v - 4.0 * w - 1.5 * a + 0.5 * b;
    let c4 = -15.0 * d + 8.0 * v + 7.0 * w + 1.5 * a - b;
    let c5 = 6.0 * d - 3.0 * v - 3.0 * w - 0.5 * a + 0.5 * b;
    q + x * (v + x * (a / 2.0 + x * (c3 + x * (c4 + x * c5))))
}

#[test]
fn splines_through_the_waypoints_make_the_motion_again() {
    for (recording, tolerance) in POSES.recordings.iter().zip([1e-7, 1e-7, 1e-6]) {
        let points = waypoints(recording, 20.0).unwrap();
        for pair in points.windows(2) {
            let [from, to] = pair else { panic!("windows of two") };
            let ends = [from, to].map(|point| point.0 as f64 / 1e9);
            let h = ends[1] - ends[0];
            assert!(h > 0.0 && h <= 0.05 + 2e-6, "{h}");
            for part in [0.25, 0.5, 0.75] {
                let state = recording.state_at(ends[0] + part * h);
                for joint in 0..3 {
                    let of = |s: &State| [s.q[joint], s.dq[joint], s.ddq[joint]];
                    let q = spline([part * h, h], of(&from.1), of(&to.1));
                    assert!((q - state.q[joint]).abs() < tolerance, "{} {ends:?}", recording.name);
                }
            }
        }
        assert_eq!(points[0].0, 0);
        assert_eq!(points.last().unwrap().1, recording.state_at(1e9));
    }
}

#[test]
fn settings_that_make_no_plan_are_refused() {
    let refused =
        |plan: ExcitationPlan| excite(&three_joints(), None, &plan, &mut |_, _| {}).unwrap_err();
    let cases = [
        (ExcitationPlan { seconds: [0.0, 60.0, 60.0], ..quick() }, "standstill"),
        (ExcitationPlan { seconds: [30.0, f64::NAN, 60.0], ..quick() }, "uniform"),
        (ExcitationPlan { seconds: [30.0, 60.0, 1e9], ..quick() }, "variable"),
        (ExcitationPlan { rate: f64::INFINITY, ..quick() }, "rate"),
        (ExcitationPlan { rate: 1e4, seconds: [30.0, 60.0, 300.0], ..quick() }, "number of rows"),
        (ExcitationPlan { dwell: -1.0, ..quick() }, "dwell"),
        (ExcitationPlan { tries: 0, ..quick() }, "tries"),
        (ExcitationPlan { interaction: Some(0), ..quick() }, "interaction"),
        (ExcitationPlan { home: Some(vec![0.0; 3]), ..quick() }, "joint2"),
        (ExcitationPlan { home: Some(vec![0.0, 1.0, -1e300]), ..quick() }, "is -1e300 rad, it may"),
        (ExcitationPlan { home: Some(vec![0.0; 2]), ..quick() }, "expected 3"),
        (ExcitationPlan { home: Some(vec![f64::NAN; 3]), ..quick() }, "joint1"),
        (ExcitationPlan { seconds: [1.2, 60.0, 60.0], ..quick() }, "no room for a single pose"),
        (ExcitationPlan { seconds: [30.0, 2.0, 60.0], ..quick() }, "no room for a single sweep"),
        (ExcitationPlan { seconds: [30.0, 60.0, 1.5], ..quick() }, "single period of sines"),
    ];

    for (plan, word) in cases {
        let error = refused(plan);
        assert!(error.to_string().contains(word), "{word}: {error}");
    }
    for rate in [0.0, f64::NAN, 1e6] {
        let error = waypoints(&POSES.recordings[0], rate).unwrap_err();
        assert!(matches!(error, SimError::Setting { .. }), "{error}");
    }
}
