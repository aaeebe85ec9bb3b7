//! A library in coordinates, as sparse sums over numbered atoms.

use crate::atom::{Atom, Monomial, Numbering, Wave};
use crate::error::SparseError;

/// One candidate: a sum of atoms, empty where the column is zero in an equation.
pub type Column = Vec<Atom>;

/// A library of p columns for one or several equations.
///
/// With one equation, each response has coefficients of its own. With several, equation e explains
/// response e and all equations share one coefficient vector, so that a column has one expression
/// per equation.
#[derive(Clone, Debug)]
pub struct Design {
    pub(crate) waves: Vec<Wave>,
    pub(crate) monomials: Vec<Monomial>,
    /// (wave, monomial) of each atom, sorted by wave.
    pub(crate) atoms: Vec<(usize, usize)>,
    /// `[equation][column]` → (atom, weight)
    pub(crate) equations: Vec<Vec<Vec<(usize, f64)>>>,
    n_angles: usize,
    n_variables: usize,
}

impl Design {
    /// Numbers the atoms of `equations[e][j]`, the expression of column j in equation e.
    ///
    /// # Errors
    /// [`SparseError::Shape`] if equations differ in their number of columns or an atom in its
    /// number of angles or variables.
    pub fn new(
        n_angles: usize,
        n_variables: usize,
        equations: &[Vec<Column>],
    ) -> Result<Self, SparseError> {
        let n_columns = equations.first().map_or(0, Vec::len);
        for columns in equations {
            expect("the columns of an equation", columns.len(), n_columns)?;
            for atom in columns.iter().flatten() {
                expect("the multiples of a wave", atom.wave.multiples().len(), n_angles)?;
                expect("the powers of a monomial", atom.monomial.powers().len(), n_variables)?;
            }
        }
        let all = || equations.iter().flatten().flatten();
        let (mut waves, mut monomials, mut atoms) =
            (Numbering::new(), Numbering::new(), Numbering::new());
        let mut pairs: Vec<(usize, usize)> =
            all().map(|a| (waves.place(&a.wave), monomials.place(&a.monomial))).collect();
        pairs.sort_unstable();
        for pair in &pairs {
            atoms.place(pair);
        }
        let mut place = |a: &Atom| {
            (atoms.place(&(waves.place(&a.wave), monomials.place(&a.monomial))), a.weight)
        };
        let numbered = equations
            .iter()
            .map(|columns| columns.iter().map(|c| c.iter().map(&mut place).collect()).collect())
            .collect();
        Ok(Self {
            waves: waves.into_values(),
            monomials: monomials.into_values(),
            atoms: atoms.into_values(),
            equations: numbered,
            n_angles,
            n_variables,
        })
    }

    /// Number of columns p.
    pub fn n_columns(&self) -> usize {
        self.equations.first().map_or(0, Vec::len)
    }

    /// Number of equations.
    pub fn n_equations(&self) -> usize {
        self.equations.len()
    }

    /// Number of angles θ.
    pub fn n_angles(&self) -> usize {
        self.n_angles
    }

    /// Number of variables x.
    pub fn n_variables(&self) -> usize {
        self.n_variables
    }

    /// The library of the columns named by `columns`, in that order.
    ///
    /// # Errors
    /// None in practice: the atoms of a design fit it.
    pub fn subset(&self, columns: &[usize]) -> Result<Self, SparseError> {
        let spell = |entries: &Vec<(usize, f64)>| -> Column {
            entries
                .iter()
                .map(|&(atom, weight)| {
                    let (wave, monomial) = self.atoms[atom];
                    Atom {
                        weight,
                        wave: self.waves[wave].clone(),
                        monomial: self.monomials[monomial].clone(),
                    }
                })
                .collect()
        };
        let equations: Vec<Vec<Column>> = self
            .equations
            .iter()
            .map(|all| columns.iter().map(|&j| spell(&all[j])).collect())
            .collect();
        Self::new(self.n_angles, self.n_variables, &equations)
    }
}

fn expect(what: &'static str, found: usize, expected: usize) -> Result<(), SparseError> {
    if found == expected { Ok(()) } else { Err(SparseError::Shape { what, found, expected }) }
}
