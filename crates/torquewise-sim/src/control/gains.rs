//! Gains by one rule, so that controllers are compared and not their tuning.

use crate::{Knowledge, Result, State, check_between, check_joints};
use torquewise_motion::Motion;

/// Gains of a PID controller for each joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Gains {
    /// Of the position error \[N·m/rad\], n.
    pub proportional: Vec<f64>,
    /// Of its integral \[N·m/(rad·s)\], n.
    pub integral: Vec<f64>,
    /// Of its derivative \[N·m·s/rad\], n.
    pub derivative: Vec<f64>,
    /// ω \[rad/s\] they were made for, with which feedback linearisation makes its own.
    pub bandwidth: f64,
}

impl Gains {
    /// Kp = 3 m ω², Ki = m ω³, Kd = 3 m ω: a joint of inertia m alone then has the characteristic
    /// polynomial (s + ω)³, critically damped.
    ///
    /// - `bandwidth`: ω \[rad/s\]
    /// - `inertia` \[kg·m²\]: m, n
    pub fn critically_damped(bandwidth: f64, inertia: &[f64]) -> Self {
        let w = bandwidth;
        let of = |factor: f64| inertia.iter().map(|m| factor * m).collect();
        let [proportional, integral, derivative] = [3.0 * w * w, w * w * w, 3.0 * w].map(of);
        Self { proportional, integral, derivative, bandwidth }
    }

    pub(crate) fn check(&self, n_joints: usize) -> Result<()> {
        check_between("the bandwidth [rad/s]", self.bandwidth, [1e-3, 1e4], "0.001 to 10000")?;
        for gains in [&self.proportional, &self.integral, &self.derivative] {
            check_joints("the gains", gains.len(), n_joints)?;
            for &gain in gains {
                let expected = "0 or more: look whether the model's mass matrix is physical";
                check_between("a gain", gain, [0.0, f64::MAX], expected)?;
            }
        }
        Ok(())
    }
}

const STATES: usize = 200;

/// Mean of M̂ᵢᵢ(q) over the desired motion \[kg·m²\], n.
///
/// # Errors
/// That of the knowledge; `SimError::JointCount` if the motion is of another arm.
pub fn mean_inertia(known: &(impl Knowledge + ?Sized), wanted: &Motion) -> Result<Vec<f64>> {
    let n = known.n_joints();
    check_joints("the desired motion", wanted.n_joints(), n)?;
    let every = wanted.n_rows().div_ceil(STATES).max(1);
    let (mut mean, mut count) = (vec![0.0; n], 0.0);
    for row in (0..wanted.n_rows()).step_by(every) {
        for (mean, inertia) in mean.iter_mut().zip(known.inertia(&State::of(wanted, row).q)?) {
            *mean += inertia;
        }
        count += 1.0;
    }
    Ok(mean.into_iter().map(|mean| mean / count).collect())
}
