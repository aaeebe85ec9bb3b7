//! The plan of a fit: a method with its own options, clusters and a seed.

use nalgebra::Vector3;
use torquewise_model::RobotNames;
use torquewise_rigid::{Geometry, JointKinds};
use torquewise_stepwise::PatternPlan;

pub use torquewise_stepwise::friction::FrictionKind;
pub use torquewise_stepwise::plan::{LibraryKind, LibraryOptions, MOST_CANDIDATES, Regression};

/// How a chain of rigid bodies is learned.
#[derive(Clone, Debug, PartialEq)]
pub struct ChainOptions {
    /// Where the joint axes lie, if that is known, as from a URDF; else it is learned too.
    pub geometry: Option<KnownGeometry>,
    /// Which joints turn and which slide, where that is known and the geometry is not; else it is
    /// learned too (E26).
    pub kinds: Option<JointKinds>,
    /// Friction beside M, C and G (17).
    pub friction: FrictionKind,
    /// Names of joints that a spring or a weight is known to balance: they are given functions of
    /// their angle in V(q) that no mass has. Without, they are looked for.
    pub counterbalanced: Vec<String>,
    /// Whether the bias that noise in q, q̇, q̈ leaves in the normal equations is to be taken out
    /// (E7).
    pub noise_correction: bool,
    /// What the chain is refined by once its torque is fitted, if by anything.
    pub refine: Option<Refine>,
}

/// What a fitted chain is refined by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refine {
    /// Windows of the log, simulated from a measured state with the measured torque (E23).
    Rollout,
}

/// Where the joint axes of an arm lie, known beforehand.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownGeometry {
    /// The axes, those of the joints of the log in their order.
    pub geometry: Geometry,
    /// What the file it stands in calls the parts of the arm.
    pub robot: Option<RobotNames>,
    /// Turns components in the base of the geometry into those in the base of the file, row by row.
    pub base: [[f64; 3]; 3],
}

/// Cosine of 15°, from which on gravity pulls elsewhere than was said.
const ELSEWHERE: f64 = 0.966;

impl KnownGeometry {
    /// The same joints where things fall along ±x, ±y and ±z of the base of the file: those about as
    /// was said, and others.
    pub(crate) fn mounted(&self) -> [Vec<Geometry>; 2] {
        let ways = [1.0, -1.0].into_iter().flat_map(|sign| [0, 1, 2].map(|axis| (sign, axis)));
        let of = |(sign, axis): (f64, usize)| {
            self.geometry.clone().falling(self.base[axis].map(|part| sign * part))
        };
        let (said, others) = ways.map(of).partition(|own| self.is_as_said(own));
        [said, others]
    }

    /// Whether gravity pulls about where it was said to.
    pub(crate) fn is_as_said(&self, own: &Geometry) -> bool {
        self.as_said(own) > ELSEWHERE
    }

    /// Cosine of the angle between gravity and where it was said to pull.
    fn as_said(&self, own: &Geometry) -> f64 {
        let [said, own] = [&self.geometry, own].map(|own| Vector3::from(own.gravity()));
        said.angle(&own).cos()
    }

    /// The line along which gravity pulls by a fit, in the base of the file, as one writes it: gravity
    /// that is turned round is explained as well by first moments that are. Where it was said to pull
    /// the other way along it, the way.
    pub(crate) fn line_of_gravity(&self, found: &Geometry) -> String {
        let pull = Vector3::from(found.gravity()).normalize();
        let down = self.base.map(|row| Vector3::from(row).dot(&pull));
        let (line, sign) = if self.as_said(found) < -ELSEWHERE {
            ("", 1.0)
        } else {
            ("±", down[Vector3::from(down).iamax()].signum())
        };
        // As it is printed, without -0.00.
        let [x, y, z] = down.map(|x| (100.0 * x * sign).round() / 100.0 + 0.0);
        format!("{line}({x:.2}, {y:.2}, {z:.2})")
    }
}

/// The two methods from rows to equations, each with its options.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "a plan is made once for a fit")]
pub enum Method {
    /// Terms are selected from a library, in three regressions or in one.
    Library(LibraryOptions),
    /// The energy of a chain of rigid bodies whose geometry is learned as well (E8).
    Chain(ChainOptions),
}

/// How a log becomes a model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// What is fitted, and how.
    pub method: Method,
    /// Clustering.
    pub patterns: PatternPlan,
    /// Seed of everything random.
    pub seed: u64,
}

impl Default for ChainOptions {
    /// Whichever friction predicts held-out rows best: logs that a chain is learned from are
    /// mostly of real arms.
    fn default() -> Self {
        Self {
            geometry: None,
            kinds: None,
            friction: FrictionKind::Auto,
            counterbalanced: Vec::new(),
            noise_correction: true,
            refine: None,
        }
    }
}

impl Default for Method {
    fn default() -> Self {
        Self::Library(LibraryOptions::default())
    }
}

impl From<LibraryOptions> for Plan {
    fn from(options: LibraryOptions) -> Self {
        Self { method: Method::Library(options), ..Self::default() }
    }
}

impl From<ChainOptions> for Plan {
    fn from(options: ChainOptions) -> Self {
        Self { method: Method::Chain(options), ..Self::default() }
    }
}
