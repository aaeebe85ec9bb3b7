//! A rigid chain as parameters: geometry, inertial parameters, drives, and their covariance.

use crate::Weighted;
use crate::{EnergyTerm, FrictionTerm, ModelError, Place, Term};
use faer::{Mat, RowRef, Side};
use serde::{Deserialize, Serialize};
use torquewise_rigid::{Geometry, Kinematics, MotionState, Moved, PER_BODY, inertia};

pub use torquewise_rigid::coupling::{Coupled, Coupling};
pub use torquewise_rigid::joint::{JointKind, JointKinds};

/// A chain of n rigid bodies with what turns on its shafts.
///
/// Axis 1 is z of the base; axis i + 1 is fixed in the frame of link i, see
/// [`torquewise_rigid::Geometry`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RigidChain {
    /// Tilt of gravity (2, rad), then direction (2, rad) and place (2, m) of each axis from the
    /// second on.
    pub geometry: Vec<f64>,
    /// Indices of the parameters of the geometry that were fitted; the others are exact.
    pub fitted: Vec<usize>,
    /// Of each link: mass \[kg\], first moment \[kg·m\] (3), moments about the origin of its frame
    /// \[kg·m²\] xx, yy, zz, xy, xz, yz.
    pub links: Vec<[f64; PER_BODY]>,
    /// Rotors and springs, on shafts that turn with the logged coordinates.
    pub drives: Vec<Drive>,
    /// How the logged coordinates turn the joints of the chain \[E18\].
    #[serde(default, skip_serializing_if = "Coupling::is_none")]
    pub coupling: Coupling,
    /// Which of its joints turn and which slide \[E26\]; all turn where none are given.
    #[serde(default, skip_serializing_if = "JointKinds::all_turn")]
    pub kinds: JointKinds,
    /// What a URDF calls its parts, where one gave the geometry.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<RobotNames>,
    /// Root L of the covariance L Lᵀ of all parameters, its lower triangle row by row: inertial
    /// parameters, drives, friction of the model, fitted geometry. Empty where it is not known.
    #[serde(with = "rows", default)]
    pub covariance_root: Vec<Vec<f64>>,
}

/// What a URDF calls an arm and its parts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotNames {
    /// The robot.
    pub robot: String,
    /// The link that does not move.
    pub base: String,
    /// The joints, base to tip, n.
    pub joints: Vec<String>,
    /// The links that they turn, n.
    pub links: Vec<String>,
    /// The frame of each link of the chain in that of the file, n.
    pub frames: Vec<LinkFrame>,
}

/// A frame in another.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinkFrame {
    /// Rotation, row by row.
    pub rotation: [[f64; 3]; 3],
    /// Origin \[m\].
    pub origin: [f64; 3],
}

/// A part of the energy that no link has.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum Drive {
    /// A rotor: T = ½ inertia (Σ shaft\[j\] q̇ⱼ)².
    Rotor {
        /// Speed of the rotor per speed of each joint, n.
        shaft: Vec<f64>,
        /// Inertia seen by the joint \[kg·m²\].
        inertia: f64,
    },
    /// A spring, a counterbalance: a term of V or M with its coefficient.
    Energy {
        /// The term.
        term: EnergyTerm,
        /// Its coefficient.
        coefficient: f64,
    },
}

impl Drive {
    /// The energy terms that it is, with their coefficients.
    pub fn energy_terms(&self) -> Vec<(EnergyTerm, f64)> {
        match self {
            Self::Energy { term, coefficient } => vec![(term.clone(), *coefficient)],
            Self::Rotor { shaft, inertia } => {
                let n = shaft.len();
                let pairs = (0..n).flat_map(|i| (i..n).map(move |j| (i, j)));
                let of_pair = |(i, j)| {
                    let term = EnergyTerm { place: Place::Inertia(i, j), function: Term::one(n) };
                    (term, inertia * shaft[i] * shaft[j])
                };
                pairs.filter(|&(i, j)| shaft[i] * shaft[j] != 0.0).map(of_pair).collect()
            }
        }
    }

    /// What it loads the joints with per unit of its coefficient, n.
    fn loads(&self, q: &[f64], dq: &[f64], ddq: &[f64]) -> Vec<f64> {
        match self {
            Self::Rotor { shaft, .. } => {
                let turning: f64 = shaft.iter().zip(ddq).map(|(s, a)| s * a).sum();
                shaft.iter().map(|s| s * turning).collect()
            }
            Self::Energy { term, .. } => {
                let value = |(weight, term): &(f64, Term)| weight * term.value(q, dq, ddq);
                (0..q.len()).map(|joint| term.torque(joint).iter().map(value).sum()).collect()
            }
        }
    }
}

impl RigidChain {
    /// Number of joints n.
    pub fn n_joints(&self) -> usize {
        self.links.len()
    }

    /// Inertial parameters of all links, 10n.
    pub fn inertial(&self) -> Vec<f64> {
        self.links.iter().flatten().copied().collect()
    }

    /// Where its axes lie.
    ///
    /// # Errors
    /// [`ModelError::Chain`] if these are no parameters of a geometry.
    pub fn axes(&self) -> Result<Geometry, ModelError> {
        Geometry::new(&self.geometry)
            .map(|geometry| geometry.coupled(self.coupling.clone()).of_kinds(self.kinds.clone()))
            .map_err(|error| ModelError::Chain { reason: error.to_string() })
    }

    /// Whether every link is a body that can be and no rotor is negative, so that M(q) is positive
    /// definite at every q (E14).
    pub fn is_feasible(&self) -> bool {
        let rotors = self.drives.iter().all(|drive| match drive {
            Drive::Rotor { inertia, .. } => *inertia >= 0.0,
            Drive::Energy { term, .. } => term.place == Place::Potential,
        });
        rotors && self.links.iter().all(|link| inertia::is_feasible(link))
    }

    /// Number of parameters of its covariance, with so many laws of friction.
    pub fn n_parameters(&self, friction: usize) -> usize {
        PER_BODY * self.links.len() + self.drives.len() + friction + self.fitted.len()
    }

    /// Derivatives of the torques by all parameters, n×p, in the order of the covariance. The load
    /// of a gear is taken as known.
    ///
    /// - `friction`: the laws of the model
    /// - `laws`: what each of them comes to at the state, as [`crate::Torque::laws`] has it
    ///
    /// # Errors
    /// [`ModelError::Chain`] if its geometry is none.
    pub fn sensitivities(
        &self,
        (friction, laws): (&[Weighted<FrictionTerm>], &[f64]),
        [q, dq, ddq]: [&[f64]; 3],
    ) -> Result<Mat<f64>, ModelError> {
        let n = self.n_joints();
        let axes = self.axes()?;
        let mut jacobian = Mat::zeros(n, self.n_parameters(friction.len()));
        let (mut moved, mut torque) = (Moved::default(), vec![0.0; n]);
        Kinematics::new(&axes).move_into(MotionState { q, dq, ddq }, &mut moved);
        moved.torque(&self.inertial(), &mut torque);
        moved.regressor(|joint, parameter, value| jacobian[(joint, parameter)] = value);
        let mut next = PER_BODY * n;
        for drive in &self.drives {
            for (joint, load) in drive.loads(q, dq, ddq).into_iter().enumerate() {
                jacobian[(joint, next)] = load;
            }
            next += 1;
        }
        for (law, value) in friction.iter().zip(laws) {
            for (joint, shaft) in law.term.shaft.iter().enumerate().take(n) {
                jacobian[(joint, next)] = shaft * value;
            }
            next += 1;
        }
        let derivatives = axes.derivatives();
        for &parameter in &self.fitted {
            moved.geometry_derivative(&derivatives[parameter], &mut torque);
            jacobian.col_as_slice_mut(next).copy_from_slice(&torque);
            next += 1;
        }
        Ok(jacobian)
    }

    /// Standard error of the torque of each joint \[N·m\] that the uncertainty of the parameters
    /// makes, n; zero where no covariance is known.
    ///
    /// - `friction`, `laws`: as of [`Self::sensitivities`]
    ///
    /// # Errors
    /// [`ModelError::Chain`] if its geometry is none.
    pub fn std_errors(
        &self,
        friction: (&[Weighted<FrictionTerm>], &[f64]),
        state: [&[f64]; 3],
    ) -> Result<Vec<f64>, ModelError> {
        let jacobian = self.sensitivities(friction, state)?;
        let of = |weights: RowRef<'_, f64>| {
            self.std_error_of(&weights.iter().copied().collect::<Vec<f64>>())
        };
        Ok(jacobian.row_iter().map(of).collect())
    }

    /// Standard error of a sum of parameters, by their weights.
    pub fn std_error_of(&self, weights: &[f64]) -> f64 {
        let mut along = vec![0.0; self.covariance_root.len()];
        for (row, weight) in self.covariance_root.iter().zip(weights) {
            along.iter_mut().zip(row).for_each(|(sum, root)| *sum += weight * root);
        }
        along.iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    /// Covariance of functions of the parameters, r×r, by their derivatives by all of them or by
    /// the first, r×p.
    pub fn covariance_of(&self, derivatives: &Mat<f64>) -> Mat<f64> {
        let p = derivatives.ncols();
        let root = |i: usize, j: usize| if j > i { 0.0 } else { self.covariance_root[i][j] };
        let along = derivatives * Mat::from_fn(p, p, root);
        &along * along.transpose()
    }

    /// Keeps a covariance, p×p.
    ///
    /// # Errors
    /// [`ModelError::Chain`] if it is not finite.
    pub fn set_covariance(&mut self, covariance: &Mat<f64>) -> Result<(), ModelError> {
        let p = covariance.nrows();
        let size = |i: usize| Some(covariance[(i, i)].sqrt()).filter(|x| *x > 0.0).unwrap_or(1.0);
        let sizes: Vec<f64> = (0..p).map(size).collect();
        let scaled = Mat::from_fn(p, p, |i, j| covariance[(i, j)] / (sizes[i] * sizes[j]));
        let unknown = |_| ModelError::Chain { reason: "its covariance is not finite".to_owned() };
        let eigen = scaled.self_adjoint_eigen(Side::Lower).map_err(unknown)?;
        let (values, vectors) = (eigen.S().column_vector(), eigen.U());
        let root = Mat::from_fn(p, p, |k, i| values[k].max(0.0).sqrt() * vectors[(i, k)]);
        let upper = root.qr().R().to_owned();
        // To ten digits: files are read by people, but the error of the torque is what remains of
        // much larger ones, of masses that it does not tell.
        let rounded = |x: f64| format!("{x:.9e}").parse().unwrap_or(x);
        let row = |i: usize| (0..=i).map(|j| rounded(sizes[i] * upper[(j, i)])).collect();
        self.covariance_root = (0..p).map(row).collect();
        Ok(())
    }

    /// The same chain at other parameters, in the order of the covariance; friction is passed over.
    pub fn at(&self, parameters: &[f64], friction: usize) -> Self {
        let mut chain = self.clone();
        let mut next = parameters.iter().copied();
        let links = chain.links.iter_mut().flatten();
        links.zip(&mut next).for_each(|(own, x)| *own = x);
        for drive in &mut chain.drives {
            let (Drive::Rotor { inertia: own, .. } | Drive::Energy { coefficient: own, .. }) =
                drive;
            *own = next.next().unwrap_or(*own);
        }
        let mut next = next.skip(friction);
        for &parameter in &chain.fitted {
            chain.geometry[parameter] = next.next().unwrap_or(chain.geometry[parameter]);
        }
        chain
    }

    /// All parameters in the order of the covariance.
    pub fn parameters(&self, friction: &[Weighted<FrictionTerm>]) -> Vec<f64> {
        let drives = self.drives.iter().map(|drive| match drive {
            Drive::Rotor { inertia, .. } => *inertia,
            Drive::Energy { coefficient, .. } => *coefficient,
        });
        let friction = friction.iter().map(|law| law.coefficient);
        let geometry = self.fitted.iter().map(|&k| self.geometry[k]);
        self.inertial().into_iter().chain(drives).chain(friction).chain(geometry).collect()
    }

    /// Whether its parts fit n joints and so many laws of friction, and are finite.
    pub(crate) fn check(&self, n: usize, friction: usize) -> Result<(), ModelError> {
        let fail = |reason: &str| Err(ModelError::Chain { reason: reason.to_owned() });
        if self.links.len() != n || self.axes()?.n_joints() != n {
            return fail("its links are not as many as the joints");
        }
        if !self.coupling.is_sound(n) {
            return fail("its coupling is not one of its joints, each to one before it");
        }
        let slides = |joint: &usize| self.kinds.slides(*joint);
        let coupled = self.coupling.coupled().iter().flat_map(|own| [own.joint, own.driver]);
        if !self.kinds.fit(n) || coupled.into_iter().any(|joint| slides(&joint)) {
            return fail("its kinds are not those of its joints, or one that slides is coupled");
        }
        let numbers = self.geometry.iter().chain(self.links.iter().flatten());
        if !numbers.chain(self.covariance_root.iter().flatten()).all(|x| x.is_finite()) {
            return fail("a number of it is not finite");
        }
        let is_other = |robot: &RobotNames| {
            let numbers = |f: &LinkFrame| {
                f.rotation.as_flattened().iter().chain(&f.origin).all(|x| x.is_finite())
            };
            [robot.joints.len(), robot.links.len(), robot.frames.len()] != [n; 3]
                || !robot.frames.iter().all(numbers)
        };
        if self.robot.as_ref().is_some_and(is_other) {
            return fail("its robot has other joints");
        }
        if self.fitted.iter().any(|&k| k >= self.geometry.len()) {
            return fail("a fitted parameter is not of its geometry");
        }
        let shafts = self.drives.iter().all(|drive| match drive {
            Drive::Rotor { shaft, inertia } => {
                shaft.len() == n && inertia.is_finite() && shaft.iter().all(|s| s.is_finite())
            }
            Drive::Energy { term, coefficient } => {
                term.function.n_joints() == n && coefficient.is_finite()
            }
        });
        if !shafts {
            return fail("a drive is not one of its joints");
        }
        let p = self.n_parameters(friction);
        let triangle = self.covariance_root.iter().enumerate().all(|(i, row)| row.len() == i + 1);
        if !(self.covariance_root.is_empty() || triangle && self.covariance_root.len() == p) {
            return fail("its covariance is not one of its parameters");
        }
        Ok(())
    }
}

/// Rows of numbers, each as one line of text: a matrix of a hundred rows stays readable.
mod rows {
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<S: Serializer>(rows: &[Vec<f64>], to: S) -> Result<S::Ok, S::Error> {
        let line = |row: &Vec<f64>| {
            row.iter().map(|x| format!("{x:e}")).collect::<Vec<String>>().join(" ")
        };
        rows.iter().map(line).collect::<Vec<String>>().serialize(to)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Vec<Vec<f64>>, D::Error> {
        let lines = Vec::<String>::deserialize(from)?;
        let number = |word: &str| word.parse::<f64>().map_err(D::Error::custom);
        lines.iter().map(|line| line.split_whitespace().map(number).collect()).collect()
    }
}
