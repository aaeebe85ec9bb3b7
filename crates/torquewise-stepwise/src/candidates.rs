//! The terms offered, as columns of a regression, and the step that offers each.

use crate::error::IdentifyError;
use crate::plan::{LibraryKind, MOST_CANDIDATES, Regression};
use torquewise_model::friction::FrictionLaw;
use torquewise_model::library::{
    Degree, energy_library, energy_library_size, product_library, product_library_size,
};
use torquewise_model::{EnergyTerm, FrictionTerm, Kind, Place, Term, Trig};
use torquewise_motion::Pattern;
use torquewise_regression::atom::{Atom, Monomial, Phase, Wave};
use torquewise_regression::design::{Column, Design};

/// What is offered, in the order of the columns.
#[derive(Clone, Debug)]
pub enum Terms {
    /// Each joint has coefficients of its own.
    Torque(Vec<Term>),
    /// All joints share the coefficients.
    Energy(Vec<EnergyTerm>),
}

/// A library with its columns and the step in which each is offered.
#[derive(Clone, Debug)]
pub struct Candidates {
    /// The terms of M, C and G.
    pub terms: Terms,
    /// Laws of friction, whose columns come after those of the terms.
    pub friction: Vec<FrictionTerm>,
    /// The columns of both, p.
    pub design: Design,
    /// Whether a column is found in a step: one list per pattern, least active first.
    pub offered: [Vec<usize>; 3],
    pub(crate) n_joints: usize,
}

/// Coefficients that are found together: which equation explains which response.
#[derive(Clone, Debug)]
pub struct Group {
    /// (equation of the design, response) pairs.
    pub equations: Vec<(usize, usize)>,
    /// Columns it has no use for: friction of other joints.
    pub of_other_joints: Vec<usize>,
}

impl Candidates {
    /// Lists the library of a plan for n joints.
    ///
    /// # Errors
    /// [`IdentifyError::LibraryTooLarge`] if its sums would not fit into memory.
    pub fn new(
        n_joints: usize,
        library: LibraryKind,
        regression: Regression,
    ) -> Result<Self, IdentifyError> {
        Self::with_friction(n_joints, library, regression, Vec::new())
    }

    /// The same with laws of friction, which every step is asked for.
    ///
    /// Values of the laws join the variables of a row: q̇, q̈, then one per law.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_friction(
        n_joints: usize,
        library: LibraryKind,
        regression: Regression,
        mut friction: Vec<FrictionTerm>,
    ) -> Result<Self, IdentifyError> {
        check_library(n_joints, library, regression)?;
        let terms = match library {
            LibraryKind::Energy { interaction } => Terms::Energy(match interaction {
                Some(limit) => energy_library(n_joints, Some(limit)),
                None => largest_energy_library(n_joints, MOST_CANDIDATES),
            }),
            LibraryKind::Product { gravity_order, trig_order } => {
                let parts = product_parts(gravity_order, trig_order, regression);
                let terms = parts.iter().map(|(order, own)| product_library(n_joints, *order, own));
                Terms::Torque(terms.flatten().collect())
            }
        };
        let mut equations = match &terms {
            Terms::Torque(terms) => columns_of_terms(terms),
            Terms::Energy(terms) => columns_of_energies(terms, n_joints),
        };
        if matches!(terms, Terms::Torque(_)) {
            // Every joint has a constant among its own terms.
            friction.retain(|term| term.law != FrictionLaw::Offset);
        }
        let of_friction = columns_of_friction(&friction, n_joints, equations.len());
        for (columns, more) in equations.iter_mut().zip(of_friction) {
            for column in columns.iter_mut() {
                for atom in column.iter_mut() {
                    atom.monomial = wider(&atom.monomial, &friction);
                }
            }
            columns.extend(more);
        }
        let p = terms.len() + friction.len();
        check_size(p, equations.len())?;
        let design = Design::new(n_joints, 2 * n_joints + friction.len(), &equations)?;
        let mut offered = Pattern::ALL.map(|pattern| terms.offered(pattern));
        for (pattern, columns) in Pattern::ALL.iter().zip(&mut offered) {
            // Slow motion tells dry friction; what it said of the rest would be far off elsewhere.
            let dry = |law: &FrictionTerm| {
                matches!(law.law, FrictionLaw::Offset | FrictionLaw::Coulomb { .. })
            };
            let asked = friction.iter().enumerate();
            let asked = asked.filter(|(_, law)| *pattern != Pattern::Standstill || dry(law));
            columns.extend(asked.map(|(place, _)| terms.len() + place));
        }
        Ok(Self { terms, friction, design, offered, n_joints })
    }

    /// Offers of an energy library the terms of at most as many joint angles as a smaller one has.
    pub(crate) fn limit_to(&mut self, library: LibraryKind) {
        let LibraryKind::Energy { interaction: Some(most) } = library else { return };
        let Terms::Energy(terms) = &self.terms else { return };
        let small = |column: &usize| {
            terms.get(*column).is_none_or(|term| term.function.interaction() <= most)
        };
        for columns in &mut self.offered {
            columns.retain(small);
        }
    }

    /// Readable name of a candidate.
    pub fn name(&self, column: usize) -> String {
        match self.law(column) {
            Some(law) => law.name(),
            None => self.terms.name(column),
        }
    }

    /// The law of friction that a column is, if it is one.
    pub fn law(&self, column: usize) -> Option<&FrictionTerm> {
        self.friction.get(column.checked_sub(self.terms.len())?)
    }

    /// Number of candidates p.
    pub fn len(&self) -> usize {
        self.terms.len() + self.friction.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The coefficients that are found together.
    pub fn groups(&self) -> Vec<Group> {
        let n = self.n_joints;
        match self.terms {
            Terms::Torque(_) => (0..n)
                .map(|joint| Group {
                    equations: vec![(0, joint)],
                    of_other_joints: self.of_other_joints(joint),
                })
                .collect(),
            Terms::Energy(_) => {
                let equations = (0..n).map(|joint| (joint, joint)).collect();
                vec![Group { equations, of_other_joints: Vec::new() }]
            }
        }
    }

    /// Columns of friction that do not load a joint.
    fn of_other_joints(&self, joint: usize) -> Vec<usize> {
        let first = self.terms.len();
        let elsewhere = self.friction.iter().enumerate().filter(|(_, law)| !law.acts_on(joint));
        elsewhere.map(|(place, _)| first + place).collect()
    }
}

impl Terms {
    /// Number of candidates.
    fn len(&self) -> usize {
        match self {
            Self::Torque(terms) => terms.len(),
            Self::Energy(terms) => terms.len(),
        }
    }

    /// Readable name of a candidate.
    pub fn name(&self, column: usize) -> String {
        match self {
            Self::Torque(terms) => terms[column].name(),
            Self::Energy(terms) => terms[column].name(),
        }
    }

    /// Columns that the rows of a pattern are asked for (14)–(16): of the energies, V at
    /// standstill, at uniform velocity the part of M that depends on q, and all of M at variable
    /// velocity.
    fn offered(&self, pattern: Pattern) -> Vec<usize> {
        let kind = match pattern {
            Pattern::Standstill => Kind::Gravity,
            Pattern::UniformVelocity => Kind::Coriolis,
            Pattern::VariableVelocity => Kind::Inertia,
        };
        let wanted = |column: &usize| match self {
            Self::Torque(terms) => terms[*column].kind() == kind,
            Self::Energy(terms) => match (terms[*column].place, kind) {
                (place, Kind::Gravity) => place == Place::Potential,
                (Place::Potential, _) | (_, Kind::Friction) => false,
                (_, Kind::Coriolis) => !terms[*column].function.factors.is_empty(),
                (_, Kind::Inertia) => true,
            },
        };
        (0..self.len()).filter(wanted).collect()
    }
}

/// The energy library of the highest interaction order that holds at most `most` terms.
pub fn largest_energy_library(n_joints: usize, most: usize) -> Vec<EnergyTerm> {
    let fits = |limit: &usize| energy_library_size(n_joints, Some(*limit)) <= most;
    let limit = (2..=n_joints).take_while(fits).last().unwrap_or(1);
    energy_library(n_joints, Some(limit))
}

/// Refuses a library that is too large before it is listed.
fn check_library(
    n_joints: usize,
    library: LibraryKind,
    regression: Regression,
) -> Result<(), IdentifyError> {
    match library {
        LibraryKind::Energy { interaction } => {
            let limit = interaction.unwrap_or(1);
            check_size(energy_library_size(n_joints, Some(limit)), n_joints)
        }
        LibraryKind::Product { gravity_order, trig_order } => {
            let parts = product_parts(gravity_order, trig_order, regression);
            let sizes =
                parts.iter().map(|(order, own)| product_library_size(n_joints, *order, own));
            check_size(sizes.fold(0, usize::saturating_add), 1)
        }
    }
}

/// Orders and degrees of the parts of a product library, one after the other.
fn product_parts(gravity: u8, order: u8, regression: Regression) -> Vec<(u8, Vec<Degree>)> {
    let of = |kind| vec![Degree::of(kind)];
    match regression {
        Regression::OneShot => vec![(order, Degree::up_to(2))],
        Regression::Stepwise => vec![
            (gravity, of(Kind::Gravity)),
            (order, of(Kind::Coriolis)),
            (order, of(Kind::Inertia)),
        ],
    }
}

/// Bytes of normal equations at most: a p×p matrix per equation.
const MOST_BYTES: usize = 4 << 30;

fn check_size(candidates: usize, equations: usize) -> Result<(), IdentifyError> {
    let bytes = |p: usize| 8_usize.saturating_mul(equations).saturating_mul(p).saturating_mul(p);
    if bytes(candidates) <= MOST_BYTES {
        return Ok(());
    }
    let limit = (MOST_BYTES / (8 * equations)).isqrt();
    let gigabytes = bytes(candidates) >> 30;
    Err(IdentifyError::LibraryTooLarge { candidates, gigabytes, limit })
}

/// The columns of torque terms: one equation that serves all joints.
pub(crate) fn columns_of_terms(terms: &[Term]) -> Vec<Vec<Column>> {
    vec![terms.iter().map(|term| column(&[(1.0, term.clone())])).collect()]
}

/// The columns of energy terms: one equation per joint.
pub(crate) fn columns_of_energies(terms: &[EnergyTerm], n_joints: usize) -> Vec<Vec<Column>> {
    (0..n_joints)
        .map(|joint| terms.iter().map(|term| column(&term.torque(joint))).collect())
        .collect()
}

/// The columns of laws of friction, the values of which are variables of their own: in one equation
/// per joint each law loads its joints, in the one equation of all joints it stands bare.
fn columns_of_friction(
    friction: &[FrictionTerm],
    n_joints: usize,
    n_equations: usize,
) -> Vec<Vec<Column>> {
    let column = |equation: usize, place: usize| -> Column {
        let share = if n_equations > 1 { friction[place].shaft[equation] } else { 1.0 };
        let mut powers = vec![0; 2 * n_joints + friction.len()];
        powers[2 * n_joints + place] = 1;
        let wave = Wave::one(n_joints);
        let atom = Atom { weight: share, wave, monomial: Monomial { powers } };
        if share == 0.0 { Vec::new() } else { vec![atom] }
    };
    (0..n_equations)
        .map(|equation| (0..friction.len()).map(|place| column(equation, place)).collect())
        .collect()
}

/// A monomial in q̇ and q̈ as one in q̇, q̈ and the values of friction.
fn wider(monomial: &Monomial, friction: &[FrictionTerm]) -> Monomial {
    let none = friction.iter().map(|_| 0);
    Monomial { powers: monomial.powers.iter().copied().chain(none).collect() }
}

/// A sum of terms as a sum of harmonic × monomial.
fn column(sum: &[(f64, Term)]) -> Column {
    sum.iter().flat_map(|(weight, term)| atoms(*weight, term)).collect()
}

fn atoms(weight: f64, term: &Term) -> Vec<Atom> {
    let monomial = Monomial { powers: term.dq.iter().chain(&term.ddq).copied().collect() };
    waves_of(weight, term)
        .into_iter()
        .map(|(weight, wave)| Atom { weight, wave, monomial: monomial.clone() })
        .collect()
}

/// The trigonometric part of a term, times a weight, as a sum of harmonics of joint sums.
pub fn waves_of(weight: f64, term: &Term) -> Vec<(f64, Wave)> {
    let mut waves = vec![(weight, Wave::one(term.n_joints()))];
    for factor in &term.factors {
        let phase = if factor.function == Trig::Sin { Phase::Sin } else { Phase::Cos };
        let Some((sign, wave)) = Wave::canonical(factor.multiples.clone(), phase) else {
            return Vec::new();
        };
        for _ in 0..factor.power {
            waves = times(&waves, sign, &wave);
        }
    }
    waves
}

/// A sum of waves times a wave, equal ones joined.
fn times(sum: &[(f64, Wave)], sign: f64, wave: &Wave) -> Vec<(f64, Wave)> {
    let mut out: Vec<(f64, Wave)> = Vec::new();
    for (weight, left) in sum {
        for (flip, product) in left.product(wave).into_iter().flatten() {
            let share = 0.5 * weight * sign * flip;
            match out.iter_mut().find(|(_, known)| *known == product) {
                Some((known, _)) => *known += share,
                None => out.push((share, product)),
            }
        }
    }
    out.retain(|(weight, _)| *weight != 0.0);
    out
}
