//! The terms offered, as columns of a regression, and the step that offers each.

use crate::{IdentifyError, LibraryKind, MOST_CANDIDATES, Regression};
use torquewise_model::harmonic::waves_of;
use torquewise_model::library::{
    Degree, energy_library, energy_library_size, product_library, product_library_size,
};
use torquewise_model::{EnergyTerm, FrictionLaw, FrictionTerm, JointKind, Kind, Place, Term, Trig};
use torquewise_motion::Pattern;
use torquewise_regression::atom::{Atom, Monomial, Wave};
use torquewise_regression::{AtomSum, Design};

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

impl Candidates {
    /// Lists the library of a plan for joints that turn or slide, with laws of friction, which every
    /// step is asked for.
    ///
    /// The variables of a row are q̇, q̈, q as it is, for joints that slide, then one per law.
    ///
    /// # Errors
    /// [`IdentifyError::LibraryTooLarge`] if its sums would not fit into memory.
    pub fn new(
        kinds: &[JointKind],
        library: LibraryKind,
        regression: Regression,
        mut friction: Vec<FrictionTerm>,
    ) -> Result<Self, IdentifyError> {
        let (n_joints, terms) = (kinds.len(), Terms::new(kinds, library, regression)?);
        if matches!(terms, Terms::Torque(_)) {
            // Every joint has a constant among its own terms.
            friction.retain(|term| term.law != FrictionLaw::Offset);
        }
        let mut equations = match &terms {
            Terms::Torque(terms) => columns_of_terms(terms, friction.len()),
            Terms::Energy(terms) => columns_of_energies(terms, n_joints, friction.len()),
        };
        let n_equations = equations.len();
        let n_variables = SIGNALS * n_joints + friction.len();
        for (equation, columns) in equations.iter_mut().enumerate() {
            // In one equation per joint each law loads its joints, in the one equation of all joints
            // it stands bare.
            columns.extend(friction.iter().enumerate().map(|(place, law)| {
                let weight = if n_equations > 1 { law.shaft[equation] } else { 1.0 };
                let mut powers = vec![0; n_variables];
                powers[SIGNALS * n_joints + place] = 1;
                let (wave, monomial) = (Wave::one(n_joints), Monomial { powers });
                if weight == 0.0 { Vec::new() } else { vec![Atom { weight, wave, monomial }] }
            }));
        }
        check_size(terms.len() + friction.len(), n_equations)?;
        let design = Design::new(n_joints, n_variables, &equations)?;
        let offered = Pattern::ALL.map(|pattern| {
            // Slow motion tells dry friction; what it said of the rest would be far off elsewhere.
            let is_asked = |law: &FrictionTerm| {
                pattern != Pattern::Standstill
                    || matches!(law.law, FrictionLaw::Offset | FrictionLaw::Coulomb { .. })
            };
            let mut columns = terms.offered(pattern);
            let asked = (0..friction.len()).filter(|&place| is_asked(&friction[place]));
            columns.extend(asked.map(|place| terms.len() + place));
            columns
        });
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
        match (self.law(column), &self.terms) {
            (Some(law), _) => law.name(),
            (None, Terms::Torque(terms)) => terms[column].name(),
            (None, Terms::Energy(terms)) => terms[column].name(),
        }
    }

    /// The law of friction that a column is, if it is one.
    pub fn law(&self, column: usize) -> Option<&FrictionTerm> {
        self.friction.get(column.checked_sub(self.terms.len())?)
    }

    /// Number of candidates p.
    pub fn n_columns(&self) -> usize {
        self.terms.len() + self.friction.len()
    }

    /// Joints whose torque is explained by the same coefficients, which are found together.
    pub fn groups(&self) -> Vec<Vec<usize>> {
        let joints = 0..self.n_joints;
        match self.terms {
            Terms::Torque(_) => joints.map(|joint| vec![joint]).collect(),
            Terms::Energy(_) => vec![joints.collect()],
        }
    }

    /// Whether a column may explain the torque of some of these joints: it is no friction of others.
    pub(crate) fn is_of(&self, joints: &[usize], column: usize) -> bool {
        self.law(column).is_none_or(|law| joints.iter().any(|&joint| law.acts_on(joint)))
    }
}

/// Orders and degrees of the parts of a product library, one after the other.
fn product_parts((gravity, trig): (u8, u8), regression: Regression) -> Vec<(u8, Vec<Degree>)> {
    let of = |kind| vec![Degree::of(kind)];
    match regression {
        Regression::OneShot => vec![(trig, Degree::up_to(2))],
        Regression::Stepwise => vec![
            (gravity, of(Kind::Gravity)),
            (trig, of(Kind::Coriolis)),
            (trig, of(Kind::Inertia)),
        ],
    }
}

/// Fails where the sums of a library would not fit into memory, before its terms are listed.
///
/// # Errors
/// [`IdentifyError::LibraryTooLarge`]
pub fn check_library(
    kinds: &[JointKind],
    library: LibraryKind,
    regression: Regression,
) -> Result<(), IdentifyError> {
    match library {
        LibraryKind::Energy { interaction } => {
            check_size(energy_library_size(kinds, interaction.or(Some(1))), kinds.len())
        }
        LibraryKind::Product { gravity_order, trig_order } => {
            let parts = product_parts((gravity_order, trig_order), regression);
            let sizes = parts.iter().map(|(order, own)| product_library_size(kinds, *order, own));
            check_size(sizes.fold(0, usize::saturating_add), 1)
        }
    }
}

impl Terms {
    /// Lists the terms of a library, unless their sums are too large.
    fn new(
        kinds: &[JointKind],
        library: LibraryKind,
        regression: Regression,
    ) -> Result<Self, IdentifyError> {
        check_library(kinds, library, regression)?;
        match library {
            LibraryKind::Energy { interaction } => {
                let fits =
                    |order: &usize| energy_library_size(kinds, Some(*order)) <= MOST_CANDIDATES;
                let largest = || (2..=kinds.len()).take_while(fits).last().unwrap_or(1);
                let order = interaction.unwrap_or_else(largest);
                Ok(Self::Energy(energy_library(kinds, Some(order))))
            }
            LibraryKind::Product { gravity_order, trig_order } => {
                let parts = product_parts((gravity_order, trig_order), regression);
                let terms = parts.iter().map(|(order, own)| product_library(kinds, *order, own));
                Ok(Self::Torque(terms.flatten().collect()))
            }
        }
    }

    fn len(&self) -> usize {
        match self {
            Self::Torque(terms) => terms.len(),
            Self::Energy(terms) => terms.len(),
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

/// Bytes of normal equations at most: a p×p matrix per equation; less where no more than 4 GB can be
/// addressed.
const MOST_BYTES: usize = if usize::BITS < 64 { 1 << 30 } else { 4 << 30 };

fn check_size(candidates: usize, equations: usize) -> Result<(), IdentifyError> {
    let bytes = |p: usize| 8_usize.saturating_mul(equations).saturating_mul(p).saturating_mul(p);
    if bytes(candidates) <= MOST_BYTES {
        return Ok(());
    }
    let limit = (MOST_BYTES / (8 * equations)).isqrt();
    let gigabytes = bytes(candidates) >> 30;
    Err(IdentifyError::LibraryTooLarge { candidates, gigabytes, limit })
}

/// q̇, q̈ and q, the variables of each row beside laws of friction.
pub const SIGNALS: usize = 3;

/// The columns of torque terms: one equation that serves all joints.
///
/// - `laws`: variables of a row beside q̇, q̈ and q
pub(crate) fn columns_of_terms(terms: &[Term], laws: usize) -> Vec<Vec<AtomSum>> {
    vec![terms.iter().map(|term| column(&[(1.0, term.clone())], laws)).collect()]
}

/// The columns of energy terms: one equation per joint.
pub(crate) fn columns_of_energies(
    terms: &[EnergyTerm],
    n_joints: usize,
    laws: usize,
) -> Vec<Vec<AtomSum>> {
    (0..n_joints)
        .map(|joint| terms.iter().map(|term| column(&term.torque(joint), laws)).collect())
        .collect()
}

/// A sum of terms as a sum of harmonic × monomial.
fn column(sum: &[(f64, Term)], laws: usize) -> AtomSum {
    let atoms = sum.iter().flat_map(|(weight, term)| {
        let (positions, turns): (Vec<_>, Vec<_>) =
            term.factors.iter().cloned().partition(|own| own.function == Trig::Position);
        let power = |joint: usize| -> u8 {
            let own = positions.iter().filter(|factor| factor.multiples[joint] != 0);
            own.map(|factor| factor.power).sum()
        };
        let slides = (0..term.n_joints()).map(power).chain(std::iter::repeat_n(0, laws));
        let powers = term.dq.iter().chain(&term.ddq).copied().chain(slides).collect();
        let monomial = Monomial { powers };
        let turns = Term { factors: turns, ..term.clone() };
        waves_of(*weight, &turns).into_iter().map(move |(weight, wave)| Atom {
            weight,
            wave,
            monomial: monomial.clone(),
        })
    });
    atoms.collect()
}
