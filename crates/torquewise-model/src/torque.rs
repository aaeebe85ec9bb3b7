//! Torque of a model: at one state, over a motion, whole or in parts.

mod laws;

use crate::error::expect;
use crate::links::Links;
use crate::products::{Product, numbered};
use crate::{Drive, Factor, Form, FrictionTerm, Kind, Model, ModelError, Weighted};
use faer::{Mat, prelude::Solve};
use torquewise_motion::{Motion, Path};
use torquewise_rigid::{MotionState, Moved};

/// The parts of the torque (1) and (17).
#[derive(Clone, Debug)]
pub struct Parts {
    /// M(q)q̈ \[N·m\], m×n.
    pub inertia: Mat<f64>,
    /// C(q,q̇)q̇ \[N·m\], m×n.
    pub coriolis: Mat<f64>,
    /// G(q) \[N·m\], m×n.
    pub gravity: Mat<f64>,
    /// F(q, q̇) \[N·m\], m×n.
    pub friction: Mat<f64>,
}

impl Parts {
    /// The whole torque τ̂ \[N·m\], m×n.
    pub fn total(&self) -> Mat<f64> {
        &(&(&self.inertia + &self.coriolis) + &self.gravity) + &self.friction
    }
}

/// A model made ready for evaluation: each sine and cosine is computed once per state.
///
/// ```
/// use torquewise_model::{Form, Model, Term, Torque, Trig, Weighted};
///
/// let gravity = Term::one(1).times(Trig::Sin, 0, 1, 1);
/// let pendulum = Model {
///     joints: vec!["pivot".into()],
///     form: Form::Torque(vec![vec![Weighted::new(gravity, 3.3)]]),
///     ..Model::default()
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
    pub(crate) friction: Vec<Weighted<FrictionTerm>>,
    /// Travels of the elements by which friction remembers the path \[rad\].
    travels: Vec<f64>,
    /// Speeds below which joints rest \[rad/s\], n.
    rest_speeds: Vec<f64>,
    /// Whether friction depends on the load of a gear.
    is_load_dependent: bool,
    /// The links, where a chain was learned; the terms are then those of its drives.
    links: Option<Links>,
}

/// State of the element of a joint with a travel, where it is known.
type Remembered<'a> = &'a dyn Fn(usize, f64) -> Option<f64>;

impl Torque {
    /// Makes a model ready.
    pub fn new(model: &Model) -> Self {
        let links = model.chain.as_ref().and_then(Links::of);
        let equations = match (&model.chain, &links) {
            (Some(chain), Some(_)) => {
                let terms = chain.drives.iter().flat_map(Drive::energy_terms);
                let weighted = terms.map(|(term, weight)| Weighted::new(term, weight));
                Form::Energy(weighted.collect()).equations(model.n_joints())
            }
            _ => model.equations(),
        };
        let (factors, joints) = numbered(&equations);
        let friction = model.friction.clone();
        let (n_joints, travels) = (model.n_joints(), model.travels());
        let is_load_dependent = friction.iter().any(|weighted| weighted.term.load);
        let rest_speeds = model.rest_speeds();
        Self { n_joints, factors, joints, friction, travels, rest_speeds, is_load_dependent, links }
    }

    /// Elements by which friction remembers the path, before the first sample. Feed them every
    /// sample of a trajectory, then ask [`Self::after`].
    pub fn path(&self) -> Path {
        Path::new(self.n_joints, &self.travels)
    }

    /// τ̂ \[N·m\] at one state: q \[rad\], dq \[rad/s\], ddq \[rad/s²\], n each. Friction that
    /// remembers the path is as after a long way in the direction of dq.
    ///
    /// # Errors
    /// [`ModelError::Shape`] if one has another length than the model has joints.
    pub fn at(&self, q: &[f64], dq: &[f64], ddq: &[f64]) -> Result<Vec<f64>, ModelError> {
        self.sum(None, MotionState { q, dq, ddq }, &|_, _| None)
    }

    /// The same at the end of a path, whose last sample is q.
    ///
    /// # Errors
    /// As [`Self::at`].
    pub fn after(&self, path: &Path, dq: &[f64], ddq: &[f64]) -> Result<Vec<f64>, ModelError> {
        let state = MotionState { q: path.q(), dq, ddq };
        self.sum(None, state, &|joint, travel| path.state(joint, travel))
    }

    /// The torque at one state \[N·m\], n, whole or a part of it.
    fn sum(
        &self,
        part: Option<Kind>,
        state: MotionState<'_, f64>,
        memory: Remembered<'_>,
    ) -> Result<Vec<f64>, ModelError> {
        let mut tau = vec![0.0; self.n_joints];
        self.visit_terms(state, memory, |joint, kind, value| {
            if part.is_none_or(|part| part == kind) {
                tau[joint] += value;
            }
        })?;
        if let Some(links) = &self.links {
            links.add_torque(part, state, &mut tau);
        }
        Ok(tau)
    }

    /// τ̂ = M̂q̈ + Ĉq̇ + Ĝ + F̂ \[N·m\] over a motion, in parts, m×n each.
    ///
    /// # Errors
    /// [`ModelError::JointCount`] if the motion is of another arm.
    pub fn parts(&self, motion: &Motion) -> Result<Parts, ModelError> {
        let (m, n) = (motion.n_rows(), self.n_joints);
        self.check_joints(motion)?;
        let zeros = || Mat::zeros(m, n);
        let (inertia, coriolis, gravity, friction) = (zeros(), zeros(), zeros(), zeros());
        let mut parts = Parts { inertia, coriolis, gravity, friction };
        let mut add = |row, joint, kind, value| {
            let part = match kind {
                Kind::Inertia => &mut parts.inertia,
                Kind::Coriolis => &mut parts.coriolis,
                Kind::Gravity => &mut parts.gravity,
                Kind::Friction => &mut parts.friction,
            };
            part[(row, joint)] += value;
        };
        self.visit_rows(motion, &mut add)?;
        if let Some(links) = &self.links {
            links.visit_parts(motion, add);
        }
        Ok(parts)
    }

    /// τ̂ \[N·m\] over a motion, m×n.
    ///
    /// # Errors
    /// [`ModelError::JointCount`] if the motion is of another arm.
    pub fn over(&self, motion: &Motion) -> Result<Mat<f64>, ModelError> {
        let Some(links) = &self.links else { return Ok(self.parts(motion)?.total()) };
        self.check_joints(motion)?;
        let mut tau = Mat::zeros(motion.n_rows(), self.n_joints);
        self.visit_rows(motion, |row, joint, _, value| tau[(row, joint)] += value)?;
        let signals = [motion.q(), motion.dq(), motion.ddq()].map(Some);
        let add = |row, joint, value: f64| tau[(row, joint)] += value;
        links.kinematics.torques(signals, &links.inertial, add);
        Ok(tau)
    }

    fn check_joints(&self, motion: &Motion) -> Result<(), ModelError> {
        let (model, log) = (self.n_joints, motion.n_joints());
        if model == log { Ok(()) } else { Err(ModelError::JointCount { model, log }) }
    }

    /// Hands over every term at every row: row, joint, part, value.
    fn visit_rows(
        &self,
        motion: &Motion,
        mut add: impl FnMut(usize, usize, Kind, f64),
    ) -> Result<(), ModelError> {
        // What friction remembers, followed from the first row where it was not.
        let motion = self.path().follow(0, motion);
        let mut state = [(); 3].map(|()| vec![0.0; self.n_joints]);
        for row in 0..motion.n_rows() {
            for (own, x) in state.iter_mut().zip([motion.q(), motion.dq(), motion.ddq()]) {
                own.iter_mut().zip(x.row(row).iter()).for_each(|(own, x)| *own = *x);
            }
            let [q, dq, ddq] = state.each_ref().map(Vec::as_slice);
            let memory = |joint, travel| motion.memory()?.state(row, joint, travel);
            let add = |joint, kind, value| add(row, joint, kind, value);
            self.visit_terms(MotionState { q, dq, ddq }, &memory, add)?;
        }
        Ok(())
    }

    /// M(q) \[kg·m²\], n×n: the torque per unit acceleration of each joint.
    ///
    /// # Errors
    /// [`ModelError::Shape`] if `q` has another length than the model has joints.
    pub fn mass_matrix(&self, q: &[f64]) -> Result<Mat<f64>, ModelError> {
        expect("q", q.len(), self.n_joints)?;
        let mut factors = vec![None; self.factors.len()];
        let mut value = |&k: &usize| *factors[k].get_or_insert_with(|| self.factors[k].value(q));
        let mut matrix = Mat::zeros(self.n_joints, self.n_joints);
        for (row, products) in self.joints.iter().enumerate() {
            for Product { coefficient, factors, column, .. } in products {
                let Some(column) = *column else { continue };
                let angles: f64 = factors.iter().map(&mut value).product();
                matrix[(row, column)] += coefficient * angles;
            }
        }
        if let Some(links) = &self.links {
            let mut moved = Moved::default();
            links.kinematics.place_into(q, &mut moved);
            moved.mass_matrix(&links.inertial, |i, j, value| {
                matrix[(i, j)] += value;
                if i != j {
                    matrix[(j, i)] += value;
                }
            });
        }
        Ok(matrix)
    }

    /// C(q, q̇)q̇ \[N·m\], n: q \[rad\], dq \[rad/s\], n each.
    ///
    /// # Errors
    /// [`ModelError::Shape`] if one has another length than the model has joints.
    pub fn coriolis(&self, q: &[f64], dq: &[f64]) -> Result<Vec<f64>, ModelError> {
        self.part(Kind::Coriolis, (q, dq), &|_, _| None)
    }

    /// C(q, q̇) \[N·m·s\] by Christoffel symbols, n×n, for controllers that use Ṁ − 2C being skew.
    ///
    /// # Errors
    /// As [`Self::coriolis`].
    pub fn coriolis_matrix(&self, q: &[f64], dq: &[f64]) -> Result<Mat<f64>, ModelError> {
        let (n, whole) = (self.n_joints, self.coriolis(q, dq)?);
        let mut matrix = Mat::zeros(n, n);
        // C(q, v)v = B(v, v) with a symmetric B, whose columns are C: B(v, e) from v + e, v and e.
        for column in 0..n {
            let (mut more, mut unit) = (dq.to_vec(), vec![0.0; n]);
            more[column] += 1.0;
            unit[column] = 1.0;
            let (both, own) = (self.coriolis(q, &more)?, self.coriolis(q, &unit)?);
            for row in 0..n {
                matrix[(row, column)] = 0.5 * (both[row] - whole[row] - own[row]);
            }
        }
        Ok(matrix)
    }

    /// q̈ \[rad/s²\], n, of an arm whose motors give τ: M(q)⁻¹(τ − C(q, q̇)q̇ − G(q) − F(q, q̇)).
    ///
    /// - `q` \[rad\], `dq` \[rad/s\], `tau` \[N·m\]: n each
    ///
    /// # Errors
    /// [`ModelError::Shape`] if one has another length than the model has joints.
    pub fn forward_dynamics(&self, [q, dq, tau]: [&[f64]; 3]) -> Result<Vec<f64>, ModelError> {
        let n = self.n_joints;
        expect("tau", tau.len(), n)?;
        let held = self.at(q, dq, &vec![0.0; n])?;
        let free = Mat::from_fn(n, 1, |joint, _| tau[joint] - held[joint]);
        let solved = self.mass_matrix(q)?.partial_piv_lu().solve(free);
        Ok((0..n).map(|joint| solved[(joint, 0)]).collect())
    }

    /// G(q) \[N·m\], n: q \[rad\], n.
    ///
    /// # Errors
    /// [`ModelError::Shape`] if `q` has another length than the model has joints.
    pub fn gravity(&self, q: &[f64]) -> Result<Vec<f64>, ModelError> {
        self.part(Kind::Gravity, (q, &vec![0.0; self.n_joints]), &|_, _| None)
    }

    /// F(q, q̇) \[N·m\], n: q \[rad\], which matters to friction under load alone, and dq
    /// \[rad/s\], n each.
    ///
    /// # Errors
    /// [`ModelError::Shape`] if one has another length than the model has joints.
    pub fn friction(&self, q: &[f64], dq: &[f64]) -> Result<Vec<f64>, ModelError> {
        self.part(Kind::Friction, (q, dq), &|_, _| None)
    }

    /// The same at the end of a path, whose last sample is q.
    ///
    /// # Errors
    /// As [`Self::friction`].
    pub fn friction_after(&self, path: &Path, dq: &[f64]) -> Result<Vec<f64>, ModelError> {
        self.part(Kind::Friction, (path.q(), dq), &|joint, travel| path.state(joint, travel))
    }

    /// One part of the torque of an arm that does not accelerate.
    fn part(
        &self,
        wanted: Kind,
        (q, dq): (&[f64], &[f64]),
        memory: Remembered<'_>,
    ) -> Result<Vec<f64>, ModelError> {
        let ddq = &vec![0.0; self.n_joints];
        self.sum(Some(wanted), MotionState { q, dq, ddq }, memory)
    }

    fn visit_terms(
        &self,
        MotionState { q, dq, ddq }: MotionState<'_, f64>,
        memory: Remembered<'_>,
        mut add: impl FnMut(usize, Kind, f64),
    ) -> Result<(), ModelError> {
        let n = self.n_joints;
        for (what, values) in [("q", q), ("dq", dq), ("ddq", ddq)] {
            expect(what, values.len(), n)?;
        }
        let factors: Vec<f64> = self.factors.iter().map(|factor| factor.value(q)).collect();
        let rate = |place: usize| if place < n { dq[place] } else { ddq[place - n] };
        let mut gravity = vec![0.0; n];
        for (joint, products) in self.joints.iter().enumerate() {
            for product in products {
                let angles: f64 = product.factors.iter().map(|&place| factors[place]).product();
                let rates: f64 = product.rates.iter().map(|&place| rate(place)).product();
                let value = product.coefficient * angles * rates;
                add(joint, product.kind, value);
                if product.kind == Kind::Gravity {
                    gravity[joint] += value;
                }
            }
        }
        if let (true, Some(links)) = (self.is_load_dependent, &self.links) {
            links.add_torque(Some(Kind::Gravity), MotionState { q, dq, ddq }, &mut gravity);
        }
        self.visit_laws((&gravity, dq), memory, |k, [value, load]| {
            let Weighted { term, coefficient, .. } = &self.friction[k];
            for (joint, &shaft) in term.shaft.iter().enumerate().filter(|(_, s)| **s != 0.0) {
                add(joint, Kind::Friction, shaft * coefficient * (value * load));
            }
        });
        Ok(())
    }
}
