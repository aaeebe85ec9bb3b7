//! Chains with sliding joints: closed forms, energies, derivatives, and what torque cannot tell.

use approx::assert_relative_eq;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use torquewise_rigid::base_parameters::base_parameters;
use torquewise_rigid::geometry::{GRAVITY, PER_JOINT};
use torquewise_rigid::inertia::seen_from;
use torquewise_rigid::{
    Geometry, JointKinds, Kinematics, MotionState, Moved, PER_BASE, PER_BODY, Placement,
};

pub(crate) fn numbers(random: &mut ChaCha8Rng, count: usize) -> Vec<f64> {
    (0..count).map(|_| random.random_range(-1.5..1.5)).collect()
}

/// Positions, velocities and accelerations.
pub(crate) type State = [Vec<f64>; 3];
/// A chain, the inertial parameters of its bodies, and a state of it.
pub(crate) type Drawn = (Geometry, Vec<f64>, State);

/// A random chain of such joints.
pub(crate) fn drawn(kinds: &str, random: &mut ChaCha8Rng) -> Drawn {
    let n = kinds.len();
    let geometry = Geometry::new(&numbers(random, PER_BASE + PER_JOINT * (n - 1))).unwrap();
    let geometry = geometry.of_kinds(JointKinds::read(kinds).unwrap());
    let state = std::array::from_fn(|_| numbers(random, n));
    (geometry, numbers(random, PER_BODY * n), state)
}

pub(crate) fn torque_of(geometry: &Geometry, inertial: &[f64], [q, dq, ddq]: &State) -> Vec<f64> {
    let mut torque = vec![0.0; q.len()];
    let state = MotionState { q, dq, ddq };
    let mut moved = Moved::default();
    Kinematics::new(geometry).move_into(state, &mut moved);
    moved.torque(inertial, &mut torque);
    torque
}

pub(crate) const ARMS: [&str; 6] = ["p", "rp", "pr", "ppp", "rrpr", "rrprrr"];

#[test]
fn a_point_mass_on_a_turning_slide_obeys_its_closed_form() {
    // Turns about z, then slides along x: τ = m s² α + 2 m s ṡ ω and f = m (s̈ − s ω²).
    let kinds = JointKinds::read("RP").unwrap();
    let [s, ds, dds, w, a, m] = [0.7, -0.4, 1.3, 2.1, -0.6, 3.0];
    let quarter = std::f64::consts::FRAC_PI_2;
    let geometry = Geometry::new(&[0.0, 0.0, 0.0, quarter, 0.0, 0.0]).unwrap().of_kinds(kinds);
    let mut inertial = vec![0.0; 20];
    inertial[10] = m;

    let torque = torque_of(&geometry, &inertial, &[vec![0.4, s], vec![w, ds], vec![a, dds]]);

    assert_relative_eq!(torque[0], m * s * s * a + 2.0 * m * s * ds * w, max_relative = 1e-12);
    assert_relative_eq!(torque[1], m * (dds - s * w * w), max_relative = 1e-12);
}

#[test]
fn torque_follows_from_the_energies_by_lagrange() {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    for kinds in ARMS.into_iter().chain(["rrrr"]) {
        let n = kinds.len();
        let (geometry, inertial, state) = drawn(kinds, &mut random);
        let [q, dq, ddq] = &state;
        let kinematics = Kinematics::new(&geometry);
        let mass = |q: &[f64]| {
            let mut mass = vec![vec![0.0; n]; n];
            let mut moved = Moved::default();
            kinematics.place_into(q, &mut moved);
            moved.mass_matrix(&inertial, |i, j, value| {
                (mass[i][j], mass[j][i]) = (value, value);
            });
            mass
        };
        let momentum = |h: f64| -> Vec<f64> {
            let at: Vec<f64> = q.iter().zip(dq).map(|(q, dq)| q + h * dq).collect();
            mass(&at).iter().map(|row| row.iter().zip(dq).map(|(m, v)| m * v).sum()).collect()
        };
        let lagrangian = |joint: usize, h: f64| {
            let mut at = q.clone();
            at[joint] += h;
            let moving: f64 = (mass(&at).iter().zip(dq))
                .map(|(row, v)| v * row.iter().zip(dq).map(|(m, v)| m * v).sum::<f64>())
                .sum();
            0.5 * moving - kinematics.potential_energy(&at, &inertial)
        };
        let h = 1e-5;

        let torque = torque_of(&geometry, &inertial, &state);
        let mut at_once = vec![0.0; n];
        kinematics.torque(MotionState { q, dq, ddq }, &inertial, &mut at_once);

        let (ahead, behind, own) = (momentum(h), momentum(-h), mass(q));
        for joint in 0..n {
            let rate = (ahead[joint] - behind[joint]) / (2.0 * h);
            let slope = (lagrangian(joint, h) - lagrangian(joint, -h)) / (2.0 * h);
            let pushed: f64 = own[joint].iter().zip(ddq).map(|(m, a)| m * a).sum();
            let size = pushed.abs() + rate.abs() + slope.abs();
            assert_relative_eq!(torque[joint], pushed + rate - slope, epsilon = 1e-8 * size);
            assert_relative_eq!(at_once[joint], torque[joint], epsilon = 1e-12 * size);
        }
    }
}

#[test]
fn the_torque_is_the_same_with_fewer_parameters() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for kinds in ARMS.into_iter().chain(["rrr"]) {
        let (geometry, inertial, state) = drawn(kinds, &mut random);

        let base = base_parameters(&geometry, &inertial);

        let [whole, fewer] = [&inertial, &base].map(|own| torque_of(&geometry, own, &state));
        assert_relative_eq!(whole[..], fewer[..], max_relative = 1e-10, epsilon = 1e-10);
        for (link, own) in base.chunks(PER_BODY).enumerate() {
            if geometry.kinds().slides(link) {
                assert!(own[4..].iter().all(|x| *x == 0.0), "{own:?}");
            } else {
                assert!(own[0].abs() + own[3].abs() + own[5].abs() < 1e-12, "{own:?}");
            }
        }
    }
}

#[test]
fn the_geometry_of_given_frames_moves_as_they_do() {
    let mut random = ChaCha8Rng::seed_from_u64(9);
    for kinds in ARMS.into_iter().chain(["rrrr"]) {
        let n = kinds.len();
        let frame = |random: &mut ChaCha8Rng| {
            let x = numbers(random, 6);
            let rotation = *nalgebra::Rotation3::from_euler_angles(x[0], x[1], x[2]).matrix();
            Placement { rotation, origin: nalgebra::Vector3::new(x[3], x[4], x[5]) }
        };
        let placements: Vec<Placement> = (0..n).map(|_| frame(&mut random)).collect();
        let of_kinds = JointKinds::read(kinds).unwrap();
        let down = [0.0, 0.0, -GRAVITY];
        let (geometry, frames) = Geometry::of_joints(&placements, &of_kinds, down);
        let state: State = std::array::from_fn(|_| numbers(&mut random, n));
        let [q, dq, ddq] = &state;
        let own = numbers(&mut random, PER_BODY * n);
        let given = Kinematics::of_frames(placements, of_kinds, down);
        let mut expected = vec![0.0; n];
        // A body in the frame of the geometry is that body in the given one.
        let bodies = own.chunks(PER_BODY).zip(&frames);
        let moved: Vec<f64> = bodies.flat_map(|(body, frame)| seen_from(body, frame)).collect();
        given.torque(MotionState { q, dq, ddq }, &moved, &mut expected);

        let torque = torque_of(&geometry, &own, &state);

        assert_relative_eq!(torque[..], expected[..], max_relative = 1e-9, epsilon = 1e-9);
    }
}

#[test]
fn places_that_torque_cannot_tell_are_no_parameters() {
    let of = |kinds: &str| JointKinds::read(kinds).unwrap();
    let geometry = |kinds: &str| Geometry::straight(kinds.len()).of_kinds(of(kinds));
    let places = |kinds: &str| -> Vec<usize> {
        let geometry = geometry(kinds);
        (0..kinds.len()).filter(|&joint| geometry.has_place(joint)).collect()
    };

    assert_eq!(places("rrrr"), [1, 2, 3]);
    assert_eq!(places("rrpr"), [1, 3]);
    assert_eq!(places("pprr"), [3], "what has not turned feels no place");
    assert_eq!(geometry("rpr").movable(), [0, 1, 2, 3, 6, 7, 8, 9]);
    assert_eq!(geometry("rr").movable(), [0, 1, 2, 3, 4, 5]);
}
