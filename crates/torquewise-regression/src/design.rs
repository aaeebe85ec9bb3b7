//! A library in coordinates, as sparse sums over numbered atoms.

use crate::atom::{Atom, Monomial, Numbering, Wave};
use crate::{Result, ascending, expect};

/// One candidate: a sum of atoms, empty where the column is zero in an equation.
pub type AtomSum = Vec<Atom>;

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
    pub(crate) n_angles: usize,
    pub(crate) n_variables: usize,
}

impl Design {
    /// Numbers the atoms of `equations[e][j]`, the expression of column j in equation e.
    ///
    /// # Errors
    /// [`SparseError::Shape`](crate::SparseError::Shape) if equations differ in their number of columns or an atom in its
    /// number of angles or variables.
    pub fn new(n_angles: usize, n_variables: usize, equations: &[Vec<AtomSum>]) -> Result<Self> {
        let n_columns = equations.first().map_or(0, Vec::len);
        for columns in equations {
            expect("the columns of an equation", columns.len(), n_columns)?;
            for atom in columns.iter().flatten() {
                expect("the multiples of a wave", atom.wave.multiples().len(), n_angles)?;
                expect("the powers of a monomial", atom.monomial.powers.len(), n_variables)?;
            }
        }
        Ok(Self::numbered(n_angles, n_variables, equations))
    }

    fn numbered(n_angles: usize, n_variables: usize, equations: &[Vec<AtomSum>]) -> Self {
        let (mut waves, mut monomials) = (Numbering::default(), Numbering::default());
        let mut pair = |Atom { wave, monomial, .. }: &Atom| {
            (waves.place(wave.clone()), monomials.place(monomial.clone()))
        };
        let atoms = ascending(equations.iter().flatten().flatten().map(&mut pair).collect());
        let mut numbered = |a: &Atom| Some((atoms.binary_search(&pair(a)).ok()?, a.weight));
        let mut column = |column: &AtomSum| column.iter().filter_map(&mut numbered).collect();
        let equations =
            equations.iter().map(|columns| columns.iter().map(&mut column).collect()).collect();
        let (waves, monomials) = (waves.into_values(), monomials.into_values());
        Self { waves, monomials, atoms, equations, n_angles, n_variables }
    }

    /// Number of columns p.
    pub fn n_columns(&self) -> usize {
        self.equations.first().map_or(0, Vec::len)
    }

    /// Number of equations.
    pub fn n_equations(&self) -> usize {
        self.equations.len()
    }

    /// The library of the columns named by `columns`, in that order.
    pub fn subset(&self, columns: &[usize]) -> Self {
        let spell = |&(atom, weight): &(usize, f64)| {
            let (wave, monomial) = self.atoms[atom];
            let (wave, monomial) = (self.waves[wave].clone(), self.monomials[monomial].clone());
            Atom { weight, wave, monomial }
        };
        let equation = |all: &Vec<Vec<(usize, f64)>>| -> Vec<AtomSum> {
            columns.iter().map(|&j| all[j].iter().map(spell).collect()).collect()
        };
        let equations: Vec<_> = self.equations.iter().map(equation).collect();
        Self::numbered(self.n_angles, self.n_variables, &equations)
    }
}
