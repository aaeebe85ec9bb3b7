//! Rows for a payload: what each counts, the columns of the last body, what the model leaves.

use crate::AT_REST;
use crate::drive_terms::SHARE_AT_REST;
use faer::{ColRef, Mat};
use torquewise_model::{Model, RigidChain, Torque, Training};
use torquewise_motion::Recording;
use torquewise_rigid::{Kinematics, MotionState, Moved, PER_BODY};
use torquewise_stepwise::IdentifyError;

/// Rows between two at which the uncertainty of the arm is taken in.
const SPARSE: usize = 8;

/// One over the noise of each joint, and its speed at rest.
pub(super) struct Weights {
    weight: Vec<f64>,
    rest: Vec<f64>,
}

impl Weights {
    pub(super) fn of(model: &Model) -> Self {
        let rest = |joint: usize| {
            let laws = model.friction.iter().filter(|own| own.term.acts_on(joint));
            AT_REST * laws.fold(0.0_f64, |most, own| most.max(own.term.law.width()))
        };
        let Training { held_out_rms, residual_rms, .. } = &model.training;
        let noise = if held_out_rms.is_empty() { residual_rms } else { held_out_rms };
        let one = |joint: usize| match noise.get(joint) {
            Some(rms) if *rms > 0.0 => 1.0 / rms,
            _ => 1.0,
        };
        let n = model.n_joints();
        Self { weight: (0..n).map(one).collect(), rest: (0..n).map(rest).collect() }
    }

    /// The weight of the square of a row of a joint.
    pub(super) fn square(&self, joint: usize, speed: f64) -> f64 {
        let share = if speed.abs() < self.rest[joint] { SHARE_AT_REST } else { 1.0 };
        share * self.weight[joint].powi(2)
    }
}

/// Columns of all bodies at a state, n×10n.
pub(super) struct Columns {
    kinematics: Kinematics,
    moved: Moved<f64>,
}

impl Columns {
    pub(super) fn of(chain: &RigidChain) -> Result<Self, IdentifyError> {
        Ok(Self { kinematics: Kinematics::new(&chain.axes()?), moved: Moved::default() })
    }

    pub(super) fn at(&mut self, [q, dq, ddq]: [&[f64]; 3], out: &mut Mat<f64>) {
        self.kinematics.move_into(MotionState { q, dq, ddq }, &mut self.moved);
        out.fill(0.0);
        self.moved.regressor(|joint, parameter, value| out[(joint, parameter)] = value);
    }
}

/// Blocks of a log, what a model leaves of their torque, and what each of its laws of friction is.
pub(super) type Visit<'a> =
    dyn FnMut(&torquewise_motion::Motion, &Mat<f64>, &Mat<f64>) -> Result<(), IdentifyError> + 'a;

pub(super) fn visit(
    model: &Model,
    recording: &(impl Recording + ?Sized),
    see: &mut Visit<'_>,
) -> Result<(), IdentifyError> {
    let torque = Torque::new(model);
    let mut path = torque.path();
    recording.read(&mut |trajectory, block| {
        let followed = path.follow(trajectory, block);
        let laws = torque.laws(&followed)?;
        let left = block.require_tau()? - torque.over(&followed)?;
        see(block, &left, &laws)?;
        Ok(())
    })?;
    Ok(())
}

/// What one pass over the rows adds up to, once the load is known.
pub(super) struct WithLoad {
    /// Squares of what is left of each joint, n.
    pub(super) squares: Vec<f64>,
    /// Σ Yᵀ w J, J the derivatives of the torque with the load by the parameters of the arm: the load
    /// pulls elsewhere where an axis lies elsewhere. 10×p, n.
    pub(super) arm: Vec<Mat<f64>>,
}

impl WithLoad {
    /// - `link`, `load`, `per`: what carries it, its inertial parameters, and how much of its torque
    ///   each column shows, n
    pub(super) fn over(
        model: &Model,
        chain: &RigidChain,
        recording: &(impl Recording + ?Sized),
        (link, load, per): (usize, &[f64], &[f64]),
    ) -> Result<Self, IdentifyError> {
        let n = model.n_joints();
        let (weights, mut columns) = (Weights::of(model), Columns::of(chain)?);
        let mut loaded = chain.clone();
        if let Some(link) = loaded.links.get_mut(link) {
            link.iter_mut().zip(load).for_each(|(own, load)| *own += load);
        }
        let p = chain.n_parameters(model.friction.len());
        let mut all = Self { squares: vec![0.0; n], arm: vec![Mat::zeros(PER_BODY, p); n] };
        let (mut all_y, mut rows) = (Mat::zeros(n, PER_BODY * n), 0_usize);
        visit(model, recording, &mut |block, left, laws| {
            for row in 0..block.n_rows() {
                let state = block.state(row);
                let at = state.each_ref().map(Vec::as_slice);
                columns.at(at, &mut all_y);
                let y = all_y.subcols(PER_BODY * link, PER_BODY);
                let loads = y * ColRef::from_slice(load);
                for joint in 0..n {
                    all.squares[joint] += (left[(row, joint)] - per[joint] * loads[joint]).powi(2);
                }
                if rows.is_multiple_of(SPARSE) && !chain.covariance_root.is_empty() {
                    let laws: Vec<f64> = laws.row(row).iter().copied().collect();
                    let bare = chain.sensitivities((&model.friction, &laws), at)?;
                    let whole = loaded.sensitivities((&model.friction, &laws), at)?;
                    for (joint, arm) in all.arm.iter_mut().enumerate() {
                        let counts = SPARSE as f64 * weights.square(joint, state[1][joint]);
                        for (j, bare) in bare.row(joint).iter().enumerate() {
                            let own = bare + per[joint] * (whole[(joint, j)] - bare);
                            for k in 0..PER_BODY {
                                arm[(k, j)] += counts * y[(joint, k)] * own;
                            }
                        }
                    }
                }
                rows += 1;
            }
            Ok(())
        })?;
        Ok(all)
    }
}
