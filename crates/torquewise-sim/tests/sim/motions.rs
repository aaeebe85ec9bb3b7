//! Simulated motions: exact derivatives, true patterns, and the shares, speeds and gaps promised.
use faer::MatRef;
use std::sync::LazyLock;
use torquewise_motion::{Pattern, Recording, ends};
use torquewise_sim::{
    Arm, MotionKind, MotionPlan, SimError, SimulatedLog, Simulation, arms, simulate,
};

const KINDS: [MotionKind; 3] = [MotionKind::Moves, MotionKind::Sines, MotionKind::Staged];

fn plan(kind: MotionKind) -> MotionPlan {
    MotionPlan { kind, seed: 5, ..MotionPlan::default() }
}

static PUMA: LazyLock<[Simulation; 3]> = LazyLock::new(|| {
    let arm = Arm::builtin("puma560-3").unwrap();
    KINDS.map(|kind| simulate(&arm, &plan(kind)).unwrap())
});

fn share(simulation: &Simulation, pattern: Pattern) -> f64 {
    let rows = simulation.truth.iter().filter(|&&found| found == pattern).count();
    rows as f64 / simulation.truth.len() as f64
}

#[test]
fn velocity_and_acceleration_are_the_derivatives_of_position_which_never_jumps() {
    for (kind, Simulation { motion, truth }) in KINDS.iter().zip(&*PUMA) {
        let (t, q, dq, ddq) = (motion.t(), motion.q(), motion.dq(), motion.ddq());
        let mut checked = 0;

        for (row, i) in (1..motion.n_rows()).flat_map(|row| (0..3).map(move |i| (row, i))) {
            let dt = t[row] - t[row - 1];
            let change = |x: MatRef<'_, f64>| x[(row, i)] - x[(row - 1, i)];
            let mean = |x: MatRef<'_, f64>| f64::midpoint(x[(row, i)], x[(row - 1, i)]);
            let (moved, gained, mean, push) = (change(q), change(dq), mean(dq), mean(ddq));
            // Transfers between staged recordings are gaps.
            if *kind != MotionKind::Staged {
                let smooth = moved.abs() < 2.1 / 250.0 && gained.abs() < 6.1 / 250.0;
                assert!(smooth, "{kind:?}: row {row}");
            }
            if truth[row] == truth[row - 1] && dt < 1.5 / 250.0 {
                // One acceleration per phase, so the trapezoid is exact, but for a switch between
                // accelerating and braking (none without cruise) and the third derivative of sines.
                let [moved, gained] = [moved - dt * mean, gained - dt * push];
                assert!(moved.abs() < 1e-6, "{kind:?} q: row {row}, {moved:e}");
                assert!(gained.abs() < 1e-6, "{kind:?} dq: row {row}, {gained:e}");
                checked += 1;
            }
        }
        assert!(checked > 90_000, "{kind:?}: {checked}");
    }
}

#[test]
fn truth_says_which_signals_are_zero() {
    for (kind, Simulation { motion, truth }) in KINDS.iter().zip(&*PUMA) {
        for (row, &pattern) in truth.iter().enumerate() {
            let moves = (0..3).any(|i| motion.dq()[(row, i)] != 0.0);
            let accelerates = (0..3).any(|i| motion.ddq()[(row, i)] != 0.0);
            let expected = match (moves, accelerates) {
                (false, false) => Pattern::Standstill,
                (true, false) => Pattern::UniformVelocity,
                (_, true) => Pattern::VariableVelocity,
            };
            assert_eq!(pattern, expected, "{kind:?}: row {row}");
        }
    }
}

#[test]
fn moves_hold_all_three_patterns_in_the_shares_promised() {
    for summary in arms() {
        let arm = Arm::builtin(summary.name).unwrap();
        let simulation = simulate(&arm, &plan(MotionKind::Moves)).unwrap();

        let standstill = share(&simulation, Pattern::Standstill);
        let uniform = share(&simulation, Pattern::UniformVelocity);

        assert!((0.14..0.21).contains(&standstill), "{}: {standstill}", summary.name);
        assert!((0.35..0.46).contains(&uniform), "{}: {uniform}", summary.name);
    }
}

#[test]
fn every_joint_crosses_most_of_its_range_both_ways_within_the_limits() {
    for kind in KINDS {
        let arm = Arm::builtin("generic-7").unwrap();
        let motion = simulate(&arm, &plan(kind)).unwrap().motion;

        for (i, [lower, upper]) in arm.ranges().into_iter().enumerate() {
            let [[left, right], [back, forth], [brake, gain]] =
                [motion.q(), motion.dq(), motion.ddq()].map(|x| ends(x.col(i).iter().copied()));
            let crossed = (right - left) / (upper - lower);

            assert!(left >= lower - 1e-9 && right <= upper + 1e-9, "{kind:?}: joint {i}");
            assert!(crossed > 0.4, "{kind:?}: joint {i} crosses {crossed}");
            assert!(back < -0.8 && forth > 0.8, "{kind:?}: joint {i}: {back} {forth}");
            assert!(back > -2.0 - 1e-9 && forth < 2.0 + 1e-9, "{kind:?}: joint {i}");
            assert!(brake < -2.0 && gain > 2.0, "{kind:?}: joint {i}: {brake} {gain}");
            assert!(brake > -6.0 - 1e-9 && gain < 6.0 + 1e-9, "{kind:?}: joint {i}");
        }
    }
}

#[test]
fn staged_recordings_follow_one_another_with_gaps_between_transfers() {
    let simulation = &PUMA[2];
    let thirds: Vec<&[Pattern]> = simulation.truth.chunks(13_334).collect();
    let t = simulation.motion.t();
    let gaps: Vec<f64> =
        t.windows(2).map(|pair| pair[1] - pair[0]).filter(|dt| *dt > 1.001 / 250.0).collect();

    for pattern in [Pattern::Standstill, Pattern::UniformVelocity, Pattern::VariableVelocity] {
        let third = share(simulation, pattern);
        assert!((third - 1.0 / 3.0).abs() < 1e-3, "{pattern:?}: {third}");
    }
    assert!(thirds[0][..13_333].iter().all(|&p| p == Pattern::Standstill));
    assert!(thirds[2][1..].iter().all(|&p| p == Pattern::VariableVelocity));
    assert!(gaps.len() > 400, "{} transfers", gaps.len());
    assert!(gaps.iter().all(|&gap| gap > 0.49), "a transfer takes half a second at least");
    assert!(t.windows(2).all(|pair| pair[1] > pair[0]));
}

#[test]
fn torque_is_the_inverse_dynamics_of_its_row() {
    let arm = Arm::builtin("generic-6").unwrap();
    let motion = simulate(&arm, &plan(MotionKind::Moves)).unwrap().motion;

    for row in (0..motion.n_rows()).step_by(997) {
        let of = |x: MatRef<'_, f64>| (0..6).map(|i| x[(row, i)]).collect::<Vec<_>>();
        let expected = arm.inverse_dynamics(&of(motion.q()), &of(motion.dq()), &of(motion.ddq()));
        assert_eq!(of(motion.require_tau().unwrap()), expected);
    }
}

#[test]
fn a_log_read_block_by_block_is_the_log_made_at_once_and_another_seed_gives_another() {
    let arm = Arm::builtin("puma560-3").unwrap();

    for kind in KINDS {
        let plan = MotionPlan { seconds: 10.0, ..plan(kind) };
        let whole = simulate(&arm, &plan).unwrap().motion;
        let other = simulate(&arm, &MotionPlan { seed: 6, ..plan }).unwrap().motion;
        assert_ne!(whole.q(), other.q(), "{kind:?}");
        let mut first = 0;
        let read = SimulatedLog::new(&arm, &plan).unwrap().read(&mut |trajectory, block| {
            assert_eq!(trajectory, 0);
            let rows = first..first + block.n_rows();
            let expected = whole.select(&rows.clone().collect::<Vec<_>>());
            assert_eq!((block.t(), block.q()), (expected.t(), expected.q()));
            assert_eq!((block.ddq(), block.tau()), (expected.ddq(), expected.tau()));
            first = rows.end;
            Ok(())
        });

        read.unwrap();
        assert_eq!(first, 2500);
    }
}

#[test]
fn a_plan_or_an_arm_out_of_bounds_is_refused() {
    let heavy = "name = 'heavy'\n[[joints]]\nname = 'joint1'\na = 1e200\nalpha = 0.0\nd = 0.0\n\
                 mass = 1e200\ncom = [0.0, 0.0, 0.0]\ninertia = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]\n";
    let heavy = Arm::from_dh_toml(heavy).unwrap();

    let endless = MotionPlan { seconds: f64::INFINITY, ..MotionPlan::default() };
    let [endless, overflow] = [endless, MotionPlan::default()].map(|plan| simulate(&heavy, &plan));

    assert!(matches!(endless, Err(SimError::Setting { .. })));
    assert!(matches!(overflow, Err(SimError::Motion(_))));
}
