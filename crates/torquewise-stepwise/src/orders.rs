//! Residual against the order of the library, and the orders a recording asks for (Fig. 5 of the
//! paper).

use crate::candidates::{SIGNALS, columns_of_energies, columns_of_terms};
use crate::{IdentifyError, PatternPlan, PatternSums, find_patterns, samples_of, step, survey};
use faer::Mat;
use rayon::prelude::*;
use serde::Serialize;
use torquewise_model::library::{
    Degree, energy_library, energy_library_size, product_library, product_library_size,
};
use torquewise_model::{JointKind, JointKinds, Kind, Term};
use torquewise_motion::{BLOCK_ROWS, Motion, Pattern, ReadError, Recording};
use torquewise_regression::{
    AtomSum, Design, NormalEquations, PreparedDesign, RowAdder, SparseError,
};

/// What is tried.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OrderPlan {
    /// Which joints turn and which slide.
    pub kinds: JointKinds,
    /// Largest N₁.
    pub trig_order: u8,
    /// Largest N₁ of the whole library, which grows fastest.
    pub whole_order: u8,
    /// Largest interaction order of the energy library; at most one per joint.
    pub interaction: usize,
    /// Clustering.
    pub patterns: PatternPlan,
}

impl Default for OrderPlan {
    /// N₁ up to 5, and up to 4 for the whole library, interaction up to 4.
    fn default() -> Self {
        let (kinds, patterns) = (JointKinds::default(), PatternPlan::default());
        Self { kinds, trig_order: 5, whole_order: 4, interaction: 4, patterns }
    }
}

/// The residual of one library at one order.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OrderPoint {
    /// N₁, or the interaction order of the energy library.
    pub order: u8,
    /// N₂: degree in velocities and accelerations together; 0 where it is fixed.
    pub motion_order: u8,
    /// Candidates.
    pub candidates: usize,
    /// Held-out RMS residual of each joint over the standard deviation of its torque, n.
    pub residual: Vec<f64>,
    /// The same on the rows that were fitted, which is what Fig. 5 shows, n.
    pub fitted: Vec<f64>,
}

impl OrderPoint {
    /// Whether it explains more than half of the torque of each joint.
    pub fn suffices(&self) -> bool {
        self.residual.iter().all(|residual| *residual <= 0.5)
    }
}

/// The residual of one library against its order.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OrderCurve {
    /// Whose: `SINDy`, a pattern's name, or `energy`.
    pub name: String,
    /// Rows.
    pub rows: usize,
    /// One point per order, from low to high.
    pub points: Vec<OrderPoint>,
    /// Place of the point chosen: the first that no later one improves by more than
    /// [`WORTHWHILE`], in the product of the residuals of all joints.
    pub chosen: usize,
}

/// Libraries larger than this are not tried: least squares on all of one would take minutes.
pub const MOST_COLUMNS: usize = 4_000;
/// Pieces that a log is dealt out in at least, so that both halves of a short one hold all motions.
const PIECES: usize = 64;
/// Largest N₁ of the parts of the library that the earlier steps have found.
const BEFORE: u8 = 4;
/// A higher order must take this part off the residual of one joint, without a loss elsewhere that
/// outweighs it.
pub const WORTHWHILE: f64 = 0.1;
/// Residuals below this part of the torque are rounding: normal equations resolve no less.
const RESOLUTION: f64 = 1e-6;

/// Residuals of all orders from one pass over the data after the survey.
///
/// Rows are dealt out in turn, in pieces of the log, to two halves; each half is fitted by least
/// squares and judged on the other. All orders are columns of the largest library, so one Gram
/// matrix per half serves them all.
///
/// # Errors
/// [`IdentifyError`]: the reader's message, missing torque, or a library too large.
pub fn orders(
    recording: &(impl Recording + ?Sized),
    plan: &OrderPlan,
) -> Result<Vec<OrderCurve>, IdentifyError> {
    let survey = survey(recording)?;
    survey.sample.require_tau()?;
    if let Some(joint) = survey.torque_std.iter().position(|&std| std == 0.0) {
        return Err(IdentifyError::ConstantTorque(survey.joints[joint].clone()));
    }
    IdentifyError::check_kinds(&plan.kinds, &survey.joints)?;
    let patterns = find_patterns(&survey, &plan.patterns)?;
    let (n, rows) = (survey.joints.len(), survey.rows);
    let kinds = &plan.kinds.all(n);
    let mut ladders = vec![whole_ladder(kinds, plan.whole_order)?];
    for &pattern in &patterns.present {
        ladders.push(step_ladder(kinds, plan.trig_order, pattern)?);
    }
    let interaction = u8::try_from(plan.interaction.min(n)).unwrap_or(u8::MAX);
    ladders.push(energy_ladder(kinds, interaction)?);
    let prepared: Vec<PreparedDesign> =
        ladders.iter().map(|ladder| PreparedDesign::cheaper(&ladder.design, n, rows)).collect();
    // Pieces of one size, or one half would get all the remainders.
    let piece = BLOCK_ROWS.div_ceil((PIECES * BLOCK_ROWS).div_ceil(rows.max(1)));
    let empty = |(ladder, prepared): (&Ladder, _)| {
        let halves = vec![RowAdder::in_order(prepared), RowAdder::in_order(prepared)];
        PatternSums::new(ladder.pattern, (n, 0), piece, halves)
    };
    let mut sums: Vec<PatternSums<'_>> = ladders.iter().zip(&prepared).map(empty).collect();
    let mut add = |block: &Motion| -> Result<(), ReadError> {
        let (samples, labels) = (samples_of(block, &[])?, patterns.label(block));
        Ok(sums.par_iter_mut().try_for_each(|sums| sums.add(&samples, &labels))?)
    };
    recording.read(&mut |_, block| add(block)).map_err(IdentifyError::Read)?;
    (ladders.iter().zip(&prepared).zip(sums))
        .map(|((ladder, prepared), sums)| {
            let halves = sums.finish()?;
            let rows = halves.iter().map(|half| half.rows).sum();
            let halves: Vec<_> = halves.iter().map(|half| half.all_grams(prepared)).collect();
            ladder.climb(rows, &halves, &survey.torque_std)
        })
        .collect()
}

/// A library with the columns of each of its orders.
struct Ladder {
    name: &'static str,
    pattern: Option<Pattern>,
    design: Design,
    /// (order, motion order, columns)
    rungs: Vec<(u8, u8, Vec<usize>)>,
}

/// The highest order up to `largest` whose library is small enough to be fitted whole.
fn feasible(largest: u8, size: impl Fn(u8) -> usize) -> u8 {
    (2..=largest).take_while(|order| size(*order) <= MOST_COLUMNS).last().unwrap_or(1)
}

/// One-shot SINDy: N₁ at N₂ ≤ 1, then at N₂ ≤ 2.
fn whole_ladder(kinds: &[JointKind], largest: u8) -> Result<Ladder, IdentifyError> {
    let degrees = Degree::up_to(2);
    let largest = feasible(largest, |order| product_library_size(kinds, order, &degrees));
    let terms = product_library(kinds, largest, &degrees);
    let rungs = (1..=2).flat_map(|motion| (1..=largest).map(move |order| (order, motion)));
    let equations = columns_of_terms(&terms, 0);
    Ladder::new(kinds.len(), ("SINDy", None), &equations, rungs, |column, order, motion| {
        let Term { dq, ddq, .. } = &terms[column];
        trig_order(&terms[column]) <= order && dq.iter().chain(ddq).sum::<u8>() <= motion
    })
}

/// One step: its own part of the library at N₁, beside the parts of the steps before at the
/// largest.
fn step_ladder(
    kinds: &[JointKind],
    largest: u8,
    pattern: Pattern,
) -> Result<Ladder, IdentifyError> {
    let parts = &[Kind::Gravity, Kind::Coriolis, Kind::Inertia][..=pattern as usize];
    let own = parts[parts.len() - 1];
    // What an order adds to the step before shows only if the step before is not short of it.
    let degrees: Vec<Degree> = parts.iter().map(|&kind| Degree::of(kind)).collect();
    let (before, added) = degrees.split_at(degrees.len() - 1);
    let size = |order: u8| {
        let earlier = product_library_size(kinds, order.min(BEFORE), before);
        earlier.saturating_add(product_library_size(kinds, order, added))
    };
    let largest = feasible(largest, size);
    let mut terms = product_library(kinds, largest.min(BEFORE), before);
    terms.extend(product_library(kinds, largest, added));
    let (equations, rungs) = (columns_of_terms(&terms, 0), (1..=largest).map(|order| (order, 0)));
    Ladder::new(
        kinds.len(),
        (pattern.name(), Some(pattern)),
        &equations,
        rungs,
        |column, order, _| terms[column].kind() != own || trig_order(&terms[column]) <= order,
    )
}

fn energy_ladder(kinds: &[JointKind], largest: u8) -> Result<Ladder, IdentifyError> {
    let largest = feasible(largest, |order| energy_library_size(kinds, Some(order.into())));
    let terms = energy_library(kinds, Some(largest.into()));
    let equations = columns_of_energies(&terms, kinds.len(), 0);
    let rungs = (1..=largest).map(|order| (order, 0));
    Ladder::new(kinds.len(), ("energy", None), &equations, rungs, |column, order, _| {
        terms[column].function.interaction() <= usize::from(order)
    })
}

fn trig_order(term: &Term) -> u8 {
    term.factors.iter().map(|factor| factor.power).sum()
}

impl Ladder {
    /// - `rungs`: (order, motion order), of columns that `fits` accepts at these
    fn new(
        n: usize,
        (name, pattern): (&'static str, Option<Pattern>),
        equations: &[Vec<AtomSum>],
        rungs: impl Iterator<Item = (u8, u8)>,
        fits: impl Fn(usize, u8, u8) -> bool,
    ) -> Result<Self, IdentifyError> {
        let design = Design::new(n, SIGNALS * n, equations)?;
        let all = 0..design.n_columns();
        let columns =
            |order, motion| all.clone().filter(|&column| fits(column, order, motion)).collect();
        let rungs = rungs.map(|(order, motion)| (order, motion, columns(order, motion))).collect();
        Ok(Self { name, pattern, design, rungs })
    }

    /// - `halves`: the normal equations of each equation over the even and the odd pieces
    fn climb(
        &self,
        rows: usize,
        halves: &[Vec<NormalEquations>],
        torque_std: &[f64],
    ) -> Result<OrderCurve, IdentifyError> {
        let relative = |(joint, sum): (usize, f64)| {
            (sum / rows.max(1) as f64).sqrt() / torque_std[joint].max(f64::MIN_POSITIVE)
        };
        let mut points = Vec::with_capacity(self.rungs.len());
        for (order, motion_order, columns) in &self.rungs {
            let in_columns = |half: &Vec<NormalEquations>| -> Vec<_> {
                half.iter().map(|part| part.restricted(columns)).collect()
            };
            let halves: Vec<_> = halves.iter().map(in_columns).collect();
            let mut squares = [vec![0.0; torque_std.len()], vec![0.0; torque_std.len()]];
            for own in 0..2 {
                let weights = fit(&halves[own], torque_std)?;
                for (sums, half) in squares.iter_mut().zip([&halves[1 - own], &halves[own]]) {
                    for (joint, sum) in sums.iter_mut().enumerate() {
                        // Weights are shared by all joints, or each has its own.
                        let own = weights.col_as_slice(joint.min(weights.ncols() - 1));
                        let (gram, response) = step::of_joint(half, joint);
                        *sum += gram.residual_energy(own, response);
                    }
                }
            }
            let [residual, fitted] =
                squares.map(|sums| sums.into_iter().enumerate().map(relative).collect());
            let (order, motion_order, candidates) = (*order, *motion_order, columns.len());
            points.push(OrderPoint { order, motion_order, candidates, residual, fitted });
        }
        // Ratios of all joints are multiplied, so that what one gains can be lost in another.
        let improves = |from: &OrderPoint, to: &OrderPoint| {
            let ratios = from.residual.iter().zip(&to.residual);
            let ratio =
                |(before, after): (&f64, &f64)| after.max(RESOLUTION) / before.max(RESOLUTION);
            ratios.map(ratio).product::<f64>() < 1.0 - WORTHWHILE
        };
        let is_enough = |place: &usize| {
            !points[place + 1..].iter().any(|later| improves(&points[*place], later))
        };
        let chosen = (0..points.len()).find(is_enough).unwrap_or(0);
        Ok(OrderCurve { name: self.name.into(), rows, points, chosen })
    }
}

/// Least-squares weights for each joint, a column each; one column where all joints share them.
fn fit(half: &[NormalEquations], torque_std: &[f64]) -> Result<Mat<f64>, SparseError> {
    if let [joints] = half {
        // A half may have no rows.
        let rows = joints.rows.max(1.0);
        return Ok(NormalEquations { rows, ..joints.clone() }.checked()?.weights());
    }
    let joints: Vec<usize> = (0..half.len()).collect();
    let weight = |std: &f64| std.max(f64::MIN_POSITIVE).powi(-2);
    let weights: Vec<f64> = torque_std.iter().map(weight).collect();
    let all: Vec<usize> = (0..half[0].n_columns()).collect();
    let none = vec![0.0; all.len()];
    Ok(step::weighted_problem(half, &joints, &weights, &none, &all)?.weights())
}
