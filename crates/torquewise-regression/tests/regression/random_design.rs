//! Random designs, and what their formulas say at random rows.

use faer::Mat;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use torquewise_regression::atom::{Atom, Monomial, Phase, Wave};
use torquewise_regression::row_sums::Route;
use torquewise_regression::{AtomSum, Design, PreparedDesign, Samples};

/// weight · cos or sin (k·θ) · x^α, k of any sign: weight, k, which of the two, α.
type Letter = (f64, Vec<i8>, Phase, Vec<u8>);

/// Letters of each column of each equation.
#[derive(Clone, Debug)]
pub(crate) struct RandomDesign {
    n_angles: usize,
    n_variables: usize,
    equations: Vec<Vec<Vec<Letter>>>,
}

/// Up to three angles, variables and equations; up to nine columns of up to four letters, some of
/// them empty.
pub(crate) fn any_design() -> impl Strategy<Value = RandomDesign> {
    (1..=3_usize, 1..=3_usize, 1..=3_usize, 1..10_usize).prop_flat_map(
        |(n_angles, n_variables, n_equations, n_columns)| {
            let phase = prop_oneof![Just(Phase::Cos), Just(Phase::Sin)];
            let multiples = prop::collection::vec(-3..=3_i8, n_angles);
            let powers = prop::collection::vec(0..=2_u8, n_variables);
            let letter = (-2.0..2.0_f64, multiples, phase, powers);
            let column = prop::collection::vec(letter, 0..=4);
            let columns = prop::collection::vec(column, n_columns);
            let equations = prop::collection::vec(columns, n_equations);
            equations.prop_map(move |equations| RandomDesign { n_angles, n_variables, equations })
        },
    )
}

/// Angles within ±π, variables and responses within ±1.
pub(crate) fn samples(random: &RandomDesign, seed: u64, rows: usize) -> Samples {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = |columns, size: f64| {
        Mat::from_fn(rows, columns, |_, _| size * rng.random_range(-1.0..1.0_f64))
    };
    Samples {
        angles: uniform(random.n_angles, std::f64::consts::PI),
        variables: uniform(random.n_variables, 1.0),
        responses: uniform(random.n_responses(), 1.0),
    }
}

impl RandomDesign {
    /// One equation for two responses: all products of seven waves and six monomials.
    pub(crate) fn fixed() -> Self {
        let waves = [[0, 0], [1, 0], [0, 1], [1, 1], [2, -1], [0, 2], [3, 1]];
        let powers = [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]];
        let letter = |k: [i8; 2], alpha: [u8; 2]| (1.5, k.to_vec(), Phase::Cos, alpha.to_vec());
        let with_all = |k| powers.map(|alpha| vec![letter(k, alpha)]);
        let columns = waves.into_iter().flat_map(with_all).collect();
        Self { n_angles: 2, n_variables: 2, equations: vec![columns] }
    }

    pub(crate) fn design(&self) -> Design {
        let column =
            |letters: &Vec<Letter>| -> AtomSum { letters.iter().filter_map(atom).collect() };
        let equations: Vec<Vec<AtomSum>> =
            self.equations.iter().map(|columns| columns.iter().map(column).collect()).collect();
        Design::new(self.n_angles, self.n_variables, &equations).expect("letters of one length")
    }

    pub(crate) fn prepared(&self, route: Route) -> PreparedDesign {
        PreparedDesign::new(&self.design(), self.n_responses(), route)
    }

    pub(crate) fn n_columns(&self) -> usize {
        self.equations[0].len()
    }

    /// One for each equation, or two where there is one.
    pub(crate) fn n_responses(&self) -> usize {
        self.equations.len().max(2)
    }

    /// The responses that an equation explains.
    pub(crate) fn responses_of(&self, equation: usize, block: &Samples) -> Mat<f64> {
        if self.equations.len() == 1 {
            block.responses.clone()
        } else {
            block.responses.subcols(equation, 1).to_owned()
        }
    }

    /// The largest value each column can have where no variable exceeds 1.
    pub(crate) fn bounds(&self, equation: usize) -> Vec<f64> {
        let bound = |letters: &Vec<Letter>| letters.iter().map(|letter| letter.0.abs()).sum();
        self.equations[equation].iter().map(bound).collect()
    }

    /// The columns of an equation, straight from their formula.
    pub(crate) fn naive(&self, equation: usize, block: &Samples) -> Mat<f64> {
        let columns = &self.equations[equation];
        Mat::from_fn(block.n_rows(), columns.len(), |row, j| {
            columns[j].iter().map(|letter| value(letter, block, row)).sum()
        })
    }
}

fn atom((weight, multiples, phase, powers): &Letter) -> Option<Atom> {
    let (sign, wave) = Wave::canonical(multiples.clone(), *phase)?;
    Some(Atom { weight: sign * weight, wave, monomial: Monomial { powers: powers.clone() } })
}

fn value((weight, multiples, phase, powers): &Letter, block: &Samples, row: usize) -> f64 {
    let multiples = multiples.iter().enumerate();
    let angle: f64 = multiples.map(|(j, &k)| f64::from(k) * block.angles[(row, j)]).sum();
    let wave = if *phase == Phase::Cos { angle.cos() } else { angle.sin() };
    let powers = powers.iter().enumerate();
    let monomial: f64 =
        powers.map(|(j, &power)| block.variables[(row, j)].powi(i32::from(power))).product();
    weight * wave * monomial
}
