//! Energies and friction as columns, each of size one over the limits.

use crate::{Bounds, Part, Result, State, States, between, check_between};
use faer::Mat;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use torquewise_model::library::energy_library_size;
use torquewise_model::{FrictionLaw, FrictionTerm};
use torquewise_regression::{Design, Samples};
use torquewise_rigid::JointKind;
use torquewise_stepwise::candidates::SIGNALS;
use torquewise_stepwise::rows::fill_in;
use torquewise_stepwise::{Candidates, IdentifyError, LibraryKind, Regression};

/// Columns at most: a factorisation takes about a second then.
const MOST_COLUMNS: f64 = 3e3;
/// Columns at most where no interaction order is asked for.
const EASY_COLUMNS: usize = 1_400;
/// Interaction order where none is asked for, and the columns allow it.
const INTERACTION: usize = 2;
/// States over which the size of a column is measured.
const REFERENCE: usize = 512;

/// The columns of a regression for the torque of n joints at once.
#[derive(Clone, Debug)]
pub(crate) struct Library {
    design: Design,
    /// Columns asked for at standstill, then at uniform velocity (14)(15).
    offered: [Vec<usize>; 2],
    /// Offset of each joint, then viscous and dry friction: the last of all columns.
    friction: Vec<FrictionTerm>,
    /// Root mean square of each column over states within the limits.
    scale: Vec<f64>,
    pub(crate) interaction: usize,
}

/// A recording, by the part of the library that it is there for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Stage {
    /// V and offsets: poses held for so many seconds; dry friction too where joints creep, that is pass
    /// each pose slowly in both directions for as long.
    Standstill { dwell: f64, creep: bool },
    /// V, what of M depends on q, and friction: sweeps at constant speed.
    Uniform,
    /// All of it: sines.
    Variable,
}

impl Library {
    pub(crate) fn new(
        kinds: &[JointKind],
        limits: &[Bounds],
        interaction: Option<usize>,
    ) -> Result<Self> {
        let n = kinds.len();
        let mut order = interaction.unwrap_or(INTERACTION).clamp(1, n.max(1));
        if interaction.is_none() && energy_library_size(kinds, Some(order)) > EASY_COLUMNS {
            order = 1;
        }
        // Before they are listed, which might take all memory.
        let columns = energy_library_size(kinds, Some(order)).saturating_add(3 * n);
        let expected = "at most 3000: lower the interaction order or lock joints";
        check_between("number of columns", columns as f64, [0.0, MOST_COLUMNS], expected)?;
        let kind = LibraryKind::Energy { interaction: Some(order) };
        let laws = [FrictionLaw::Offset, FrictionLaw::Viscous, FrictionLaw::Coulomb { width: 0.0 }];
        let of_law = |law| (0..n).map(move |joint| FrictionTerm::of_joint(n, joint, law));
        let friction = laws.into_iter().flat_map(of_law).collect();
        let Candidates { design, offered: [still, uniform, _], friction, .. } =
            Candidates::new(kinds, kind, Regression::Stepwise, friction)?;
        let (offered, scale) = ([still, uniform], vec![1.0; columns]);
        let mut library = Self { design, offered, friction, scale, interaction: order };
        let values = library.rows(&reference(limits))?;
        for (j, scale) in library.scale.iter_mut().enumerate() {
            let square = values.col(j).squared_norm_l2() / values.nrows() as f64;
            *scale = if square > 0.0 { square.sqrt() } else { 1.0 };
        }
        Ok(library)
    }

    pub(crate) fn n_columns(&self) -> usize {
        self.scale.len()
    }

    pub(crate) fn share(&self, stage: Stage) -> Self {
        let [still, uniform] = &self.offered;
        let (all, n) = (self.n_columns(), self.design.n_equations());
        let energies = all - self.friction.len();
        let still_below = |end| still.iter().copied().filter(move |&column| column < end);
        let columns: Vec<usize> = match stage {
            Stage::Standstill { creep: true, .. } => still.clone(),
            Stage::Standstill { creep: false, .. } => still_below(energies + n).collect(),
            Stage::Uniform => still_below(energies).chain(uniform.iter().copied()).collect(),
            Stage::Variable => return self.clone(),
        };
        let scale = columns.iter().map(|&column| self.scale[column]).collect();
        Self { design: self.design.subset(&columns), scale, ..self.clone() }
    }

    pub(crate) fn rows_of<'a>(
        &self,
        parts: impl IntoIterator<Item = &'a Part>,
        density: u8,
    ) -> Result<Vec<Mat<f64>>> {
        parts.into_iter().map(|part| self.rows(&part.states(density))).collect()
    }

    /// The columns at some states, n·m rows by p: the joints below each other, each row times the
    /// root of the seconds it stands for.
    pub(crate) fn rows(&self, states: &States) -> Result<Mat<f64>> {
        let (m, n, at) = (states.seconds.len(), self.design.n_equations(), &states.at);
        let variables = Mat::from_fn(m, SIGNALS * n + self.friction.len(), |row, column| {
            let State { dq, ddq, .. } = &at[row];
            [dq, ddq].get(column / n).map_or(0.0, |rates| rates[column % n])
        });
        let angles = Mat::from_fn(m, n, |row, joint| at[row].q[joint]);
        let mut samples = Samples { angles, variables, responses: Mat::zeros(m, 0) };
        fill_in(&mut samples, &self.friction);
        let mut rows = Mat::zeros(n * m, self.n_columns());
        for (joint, values) in
            self.design.columns(&samples).map_err(IdentifyError::from)?.iter().enumerate()
        {
            rows.subrows_mut(joint * m, m).copy_from(values);
        }
        for (j, scale) in self.scale.iter().enumerate() {
            for (place, value) in rows.col_as_slice_mut(j).iter_mut().enumerate() {
                *value *= states.seconds[place % m].sqrt() / scale;
            }
        }
        Ok(rows)
    }
}

/// States all over the limits, the same for every plan: what columns are measured by.
fn reference(limits: &[Bounds]) -> States {
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let mut draw = |ends: fn(&Bounds) -> [f64; 2]| {
        limits.iter().map(|limits| between(&mut rng, ends(limits))).collect()
    };
    let mut state = || State {
        q: draw(|limits| limits.position),
        dq: draw(|limits| [-limits.velocity, limits.velocity]),
        ddq: draw(|limits| [-limits.acceleration, limits.acceleration]),
    };
    let at = (0..REFERENCE).map(|_| state()).collect();
    States { at, seconds: vec![1.0; REFERENCE] }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TURN: [JointKind; 3] = [JointKind::Revolute; 3];
    const LIMITS: [Bounds; 3] =
        [Bounds { position: [-2.0, 2.0], velocity: 1.0, acceleration: 2.0 }; 3];

    #[test]
    fn every_column_has_size_one_over_the_limits() {
        let library = Library::new(&TURN, &LIMITS, Some(3)).unwrap();

        let rows = library.rows(&reference(&LIMITS)).unwrap();

        for j in 0..library.n_columns() {
            let square = rows.col(j).squared_norm_l2() / rows.nrows() as f64;
            assert!((square - 1.0).abs() < 1e-12, "{j}: {square}");
        }
    }

    #[test]
    fn a_share_has_the_columns_of_the_whole() {
        let library = Library::new(&TURN, &LIMITS, None).unwrap();
        let share = library.share(Stage::Standstill { dwell: 0.5, creep: true });
        let states = reference(&LIMITS);

        let (whole, part) = (library.rows(&states).unwrap(), share.rows(&states).unwrap());

        for (place, &j) in library.offered[0].iter().enumerate() {
            assert!((whole.col(j) - part.col(place)).norm_max() < 1e-14);
        }
        for joint in 0..3 {
            let (offset, dry) = (76 + joint, 76 + 6 + joint);
            assert!((whole.col(offset) - part.col(18 + joint)).norm_max() < 1e-14);
            assert!((whole.col(dry) - part.col(21 + joint)).norm_max() < 1e-14);
        }
    }

    #[test]
    fn many_joints_get_a_lower_order_and_too_many_columns_are_refused() {
        let (turn, seven) = ([JointKind::Revolute; 7], [LIMITS[0]; 7]);

        assert_eq!(Library::new(&turn, &seven, None).unwrap().interaction, 1);
        for order in [3, 16] {
            let refused = Library::new(&turn, &seven, Some(order)).unwrap_err();
            assert!(refused.to_string().starts_with("number of columns"), "{refused}");
        }
    }
}
