//! From positions, velocities, accelerations to columns of rough models of any arm.

use faer::Mat;

/// Half widths of reversals, relative to the peak speed: sums of such curves are close to any
/// friction that changes its sign with the velocity.
const WIDTHS: [f64; 5] = [0.003, 0.01, 0.03, 0.1, 0.3];

/// How much of an inertia that turns with the arm a model knows; each knows more than the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Detail {
    /// Constant.
    Constant,
    /// With the angle of each joint, and Coriolis torques alike.
    Angles,
    /// With twice the angles and sums of neighbours too.
    Sums,
}

impl Detail {
    /// From coarse to fine.
    pub(crate) const ALL: [Self; 3] = [Self::Constant, Self::Angles, Self::Sums];

    /// Angles that an inertia of n joints turns with, as multiples of q.
    fn angles(self, n: usize) -> Vec<Vec<f64>> {
        let mut angles = Vec::new();
        // No inertia turns with the first joint.
        for joint in 1..n {
            match self {
                Self::Constant => {}
                Self::Angles => angles.push(multiple(n, &[(joint, 1.0)])),
                Self::Sums => {
                    angles.push(multiple(n, &[(joint, 1.0)]));
                    angles.push(multiple(n, &[(joint, 2.0)]));
                    for (before, own) in [(1.0, 1.0), (2.0, 1.0), (2.0, 2.0)] {
                        if joint > 1 {
                            angles.push(multiple(n, &[(joint - 1, before), (joint, own)]));
                        }
                    }
                }
            }
        }
        angles
    }
}

fn multiple(n: usize, of: &[(usize, f64)]) -> Vec<f64> {
    let mut multiples = vec![0.0; n];
    for &(joint, k) in of {
        multiples[joint] = k;
    }
    multiples
}

/// Angles that gravity turns with: of each joint, of two neighbours and of three.
fn gravity_angles(n: usize) -> Vec<Vec<f64>> {
    let mut angles: Vec<Vec<f64>> = (0..n).map(|joint| multiple(n, &[(joint, 1.0)])).collect();
    for joint in 1..n {
        for sign in [1.0, -1.0] {
            angles.push(multiple(n, &[(joint - 1, 1.0), (joint, sign)]));
        }
    }
    let three = |joint| multiple(n, &[(joint - 2, 1.0), (joint - 1, 1.0), (joint, 1.0)]);
    angles.extend((2..n).map(three));
    angles
}

/// 1, sines and cosines of angles, a column each.
fn harmonics(q: &Mat<f64>, angles: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut columns = vec![vec![1.0; q.nrows()]];
    for multiples in angles {
        let angle = |row: usize| -> f64 {
            multiples.iter().enumerate().map(|(joint, k)| k * q[(row, joint)]).sum()
        };
        let pairs: Vec<(f64, f64)> = (0..q.nrows()).map(|row| angle(row).sin_cos()).collect();
        columns.push(pairs.iter().map(|pair| pair.0).collect());
        columns.push(pairs.iter().map(|pair| pair.1).collect());
    }
    columns
}

/// Columns of rigid bodies: all are even in time, so that what is missing among them does not look
/// like a delay, which is odd.
///
/// - `q`, `dq`, `ddq`: m×n
pub(crate) fn rigid(q: &Mat<f64>, dq: &Mat<f64>, ddq: &Mat<f64>, detail: Detail) -> Vec<Vec<f64>> {
    let n = q.ncols();
    let mut columns = harmonics(q, &gravity_angles(n));
    let turning = harmonics(q, &detail.angles(n));
    let mut add = |motion: &dyn Fn(usize) -> f64| {
        for column in &turning {
            columns.push(column.iter().enumerate().map(|(row, x)| x * motion(row)).collect());
        }
    };
    for joint in 0..n {
        add(&|row| ddq[(row, joint)]);
    }
    if detail != Detail::Constant {
        for first in 0..n {
            for second in first..n {
                add(&|row| dq[(row, first)] * dq[(row, second)]);
            }
        }
    }
    columns
}

/// Number of those columns.
pub(crate) fn n_rigid(n: usize, detail: Detail) -> usize {
    let turning = 1 + 2 * detail.angles(n).len();
    let coriolis = if detail == Detail::Constant { 0 } else { n * (n + 1) / 2 };
    1 + 2 * gravity_angles(n).len() + turning * (n + coriolis)
}

/// Columns of friction of a joint: viscous, and smooth signs of several widths; none for a joint
/// that does not move.
pub(crate) fn friction(dq: &[f64]) -> Vec<Vec<f64>> {
    let peak = dq.iter().fold(0.0_f64, |peak, dq| peak.max(dq.abs()));
    if peak <= 0.0 {
        return Vec::new();
    }
    let sign = |width: f64| dq.iter().map(|dq| (dq / (width * peak)).tanh()).collect();
    std::iter::once(dq.to_vec()).chain(WIDTHS.map(sign)).collect()
}
