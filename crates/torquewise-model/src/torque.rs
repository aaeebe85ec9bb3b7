//! Model → torque: at one state, over a motion, whole or in parts.

use crate::error::ModelError;
use crate::model::Model;
use crate::term::{Factor, Kind, Sum};
use faer::Mat;
use std::collections::BTreeMap;
use torquewise_motion::Motion;

/// The parts of the torque (1).
#[derive(Clone, Debug)]
pub struct Parts {
    /// M(q)q̈ \[N·m\], m×n.
    pub inertia: Mat<f64>,
    /// C(q,q̇)q̇ \[N·m\], m×n.
    pub coriolis: Mat<f64>,
    /// G(q) \[N·m\], m×n.
    pub gravity: Mat<f64>,
}

impl Parts {
    /// The whole torque τ̂ \[N·m\], m×n.
    pub fn total(&self) -> Mat<f64> {
        &(&self.inertia + &self.coriolis) + &self.gravity
    }
}

/// A model made ready for evaluation: each sine and cosine is computed once per state.
///
/// ```
/// use torquewise_model::{Form, Model, Term, Torque, Training, Trig, Weighted};
///
/// let gravity = Term::one(1).times(Trig::Sin, 0, 1, 1);
/// let pendulum = Model {
///     joints: vec!["pivot".into()],
///     form: Form::Torque(vec![vec![Weighted {
///         term: gravity,
///         coefficient: 3.3,
///         std_error: 0.0,
///         inclusion: None,
///     }]]),
///     stages: vec![],
///     training: Training::default(),
/// };
/// let tau = Torque::new(&pendulum).at(&[0.5], &[0.0], &[0.0])?;
/// assert_eq!(tau, [3.3 * 0.5_f64.sin()]);
/// # Ok::<(), torquewise_model::ModelError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Torque {
    n_joints: usize,
    factors: Vec<Factor>,
    joints: Vec<Vec<Product>>,
}

/// One term with its functions looked up by place.
#[derive(Clone, Debug)]
struct Product {
    coefficient: f64,
    kind: Kind,
    factors: Vec<usize>,
    /// Places in \[q̇ q̈\], each as often as its power.
    rates: Vec<usize>,
}

impl Torque {
    /// Makes a model ready.
    pub fn new(model: &Model) -> Self {
        Self::of_equations(model.n_joints(), &model.equations())
    }

    fn of_equations(n_joints: usize, equations: &[Sum]) -> Self {
        let mut places: BTreeMap<Factor, usize> = BTreeMap::new();
        let mut joints = Vec::with_capacity(equations.len());
        for equation in equations {
            let mut products = Vec::with_capacity(equation.len());
            for (coefficient, term) in equation {
                let mut factors = Vec::with_capacity(term.factors.len());
                for factor in &term.factors {
                    let next = places.len();
                    factors.push(*places.entry(factor.clone()).or_insert(next));
                }
                let powers = term.dq.iter().chain(&term.ddq);
                let rates = powers
                    .enumerate()
                    .flat_map(|(place, &power)| std::iter::repeat_n(place, power.into()))
                    .collect();
                let kind = term.kind();
                products.push(Product { coefficient: *coefficient, kind, factors, rates });
            }
            joints.push(products);
        }
        let mut numbered: Vec<(Factor, usize)> = places.into_iter().collect();
        numbered.sort_by_key(|(_, place)| *place);
        let factors = numbered.into_iter().map(|(factor, _)| factor).collect();
        Self { n_joints, factors, joints }
    }

    /// τ̂ \[N·m\] at one state: q \[rad\], dq \[rad/s\], ddq \[rad/s²\], n each.
    ///
    /// # Errors
    /// [`ModelError::Shape`] if one has another length than the model has joints.
    pub fn at(&self, q: &[f64], dq: &[f64], ddq: &[f64]) -> Result<Vec<f64>, ModelError> {
        let mut tau = vec![0.0; self.n_joints];
        self.visit(q, dq, ddq, |joint, _, value| tau[joint] += value)?;
        Ok(tau)
    }

    /// τ̂ = M̂q̈ + Ĉq̇ + Ĝ \[N·m\] over a motion, in parts, m×n each.
    ///
    /// # Errors
    /// [`ModelError::JointCount`] if the motion is of another arm.
    pub fn parts(&self, motion: &Motion) -> Result<Parts, ModelError> {
        let (m, n) = (motion.n_rows(), self.n_joints);
        if motion.n_joints() != n {
            return Err(ModelError::JointCount { model: n, log: motion.n_joints() });
        }
        let zeros = || Mat::zeros(m, n);
        let mut parts = Parts { inertia: zeros(), coriolis: zeros(), gravity: zeros() };
        let row_of = |signal: faer::MatRef<'_, f64>, row| -> Vec<f64> {
            (0..n).map(|joint| signal[(row, joint)]).collect()
        };
        for row in 0..m {
            let (q, dq) = (row_of(motion.q(), row), row_of(motion.dq(), row));
            let ddq = row_of(motion.ddq(), row);
            self.visit(&q, &dq, &ddq, |joint, kind, value| {
                let part = match kind {
                    Kind::Inertia => &mut parts.inertia,
                    Kind::Coriolis => &mut parts.coriolis,
                    Kind::Gravity => &mut parts.gravity,
                };
                part[(row, joint)] += value;
            })?;
        }
        Ok(parts)
    }

    /// τ̂ \[N·m\] over a motion, m×n.
    ///
    /// # Errors
    /// [`ModelError::JointCount`] if the motion is of another arm.
    pub fn over(&self, motion: &Motion) -> Result<Mat<f64>, ModelError> {
        Ok(self.parts(motion)?.total())
    }

    /// M(q) \[kg·m²\], n×n: the torque per unit acceleration of each joint.
    ///
    /// # Errors
    /// [`ModelError::Shape`] if `q` has another length than the model has joints.
    pub fn mass_matrix(&self, q: &[f64]) -> Result<Mat<f64>, ModelError> {
        let n = self.n_joints;
        let (rest, mut unit) = (vec![0.0; n], vec![0.0; n]);
        let mut matrix = Mat::zeros(n, n);
        for column in 0..n {
            unit[column] = 1.0;
            self.visit(q, &rest, &unit, |joint, kind, value| {
                if kind == Kind::Inertia {
                    matrix[(joint, column)] += value;
                }
            })?;
            unit[column] = 0.0;
        }
        Ok(matrix)
    }

    fn visit(
        &self,
        q: &[f64],
        dq: &[f64],
        ddq: &[f64],
        mut add: impl FnMut(usize, Kind, f64),
    ) -> Result<(), ModelError> {
        let n = self.n_joints;
        for (what, values) in [("q", q), ("dq", dq), ("ddq", ddq)] {
            if values.len() != n {
                return Err(ModelError::Shape { what, found: values.len(), expected: n });
            }
        }
        let factors: Vec<f64> = self.factors.iter().map(|factor| factor.value(q)).collect();
        let rate = |place: usize| if place < n { dq[place] } else { ddq[place - n] };
        for (joint, products) in self.joints.iter().enumerate() {
            for product in products {
                let angles: f64 = product.factors.iter().map(|&place| factors[place]).product();
                let rates: f64 = product.rates.iter().map(|&place| rate(place)).product();
                add(joint, product.kind, product.coefficient * angles * rates);
            }
        }
        Ok(())
    }
}
