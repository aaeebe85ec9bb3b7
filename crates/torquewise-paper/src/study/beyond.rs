//! Beyond the paper: what each choice buys, more noise, less data, more joints.

use crate::method::Method;
use crate::scenario::{Scenario, outside};
use crate::trial::{Row, Trials, steps};
use crate::truth::true_energies;
use crate::{Cell, Result, Settings, Spread, Study};
use torquewise_identify::{LibraryOptions, PatternPlan, Plan, Regression};
use torquewise_model::library::{Degree, energy_library_size, product_library_size};
use torquewise_model::{JointKind, Kind, Model};
use torquewise_report::{Axis, Chart, Mark, Series, significant};
use torquewise_sim::{Arm, Noise};
use torquewise_stepwise::activation::Scaling;

/// The row with the paper's constants of the activation index.
const PRINTED: &str = "activation index as printed";
/// The row that is judged after the last step, before the refit.
const BEFORE_REFIT: &str = "no refit after the last step";

/// One choice changed at a time: family, what is changed, the equation that this puts to the test.
pub(crate) fn variants(settings: &Settings) -> Vec<Row> {
    let scenario = settings.scenario(Noise::CASES[2]);
    let row = |family: &str, change: &str, equation: &str, plan: Plan| {
        // The printed index leaves the product library with so many terms that its refit takes
        // longest of all: one seed says it.
        let seeds = if change == PRINTED { 1 } else { settings.sweep_seeds };
        Row::new(&[family, change, equation].map(Cell::from), &scenario, plan, seeds)
    };
    let mut rows = Vec::new();
    let uncorrected = |options| LibraryOptions { noise_correction: false, ..options }.into();
    for method in [Method::Energy, Method::Product] {
        let (name, options) = (method.name(), method.options());
        let ruled = |other| method.with_rule_of(other).into();
        let patterns =
            PatternPlan { scaling: Scaling::Paper, clusters: Some(3), ..PatternPlan::default() };
        let one_step = LibraryOptions { regression: Regression::OneShot, ..options.clone() };
        let plan = Plan::from(options.clone());
        rows.extend([
            row(name, "as it is", "", plan.clone()),
            row(name, PRINTED, "[E1]", Plan { patterns, ..plan.clone() }),
            row(name, "one step, all rows", "", one_step.into()),
            row(name, "terms chosen by LASSO + BIC", "[E5]", ruled(Method::SindyLasso)),
            row(name, "terms chosen by |c| > 0.1", "[E5]", ruled(Method::Sindy)),
            row(name, BEFORE_REFIT, "[E6]", plan),
            row(name, "no noise correction", "[E7]", uncorrected(options)),
        ]);
    }
    let (name, chosen) = ("one-shot SINDy", Method::SindyCriterion.options());
    rows.extend([
        row(name, "terms chosen by |c| > 0.1", "", Method::Sindy.options().into()),
        row(name, "terms chosen by LASSO + BIC", "", Method::SindyLasso.options().into()),
        row(name, "terms chosen by the criterion", "[E5]", uncorrected(chosen.clone())),
        row(name, "criterion, noise correction", "[E7]", chosen.into()),
    ]);
    rows
}

pub(crate) fn ablation(settings: &Settings, trials: &Trials) -> Result<Study> {
    let test = outside(settings.arm, settings.seed)?;
    let mut study = Study::described("ablation", test.n_joints());
    for row in variants(settings) {
        let runs = trials.of(&row);
        let mut cells = runs.cells();
        if row.head[1] == BEFORE_REFIT.into() {
            let last = runs.0.iter().map(|trial| steps(&trial.model, Model::clone, &test));
            let last = last.collect::<Result<Vec<_>>>()?;
            let last = last.iter().filter_map(|steps| Some(&steps.last()?.nrmse_percent[..]));
            cells.truncate(2);
            cells.extend(Spread::of_columns(last).into_iter().map(Cell::from));
        }
        study.tables[0].push(&row.head, cells);
    }
    Ok(study)
}

/// Each level of noise; then each length of the log, with the noise of case 3, for the methods that
/// are not ruined by it. One-shot SINDy with its threshold, the slowest, has one seed.
pub(crate) fn points(settings: &Settings) -> [Vec<Row>; 2] {
    let row = |log: &Scenario, method: Method| {
        let seeds = if method == Method::Sindy { 1 } else { settings.sweep_seeds };
        let head = [method.name().into(), log.noise.to_string().into(), log.seconds.into()];
        Row::new(&head, log, method.options(), seeds)
    };
    let long = |&seconds| Scenario { seconds, ..settings.scenario(Noise::CASES[2]) };
    let levels = settings.noise_levels.iter().map(|&noise| settings.scenario(noise));
    let lengths = settings.lengths.iter().map(long);
    let unruined = [Method::Energy, Method::Product, Method::SindyCriterion];
    [
        levels.flat_map(|log| Method::SWEPT.map(|method| row(&log, method))).collect(),
        lengths.flat_map(|log| unruined.map(|method| row(&log, method))).collect(),
    ]
}

pub(crate) fn sweeps(settings: &Settings, trials: &Trials) -> Result<Study> {
    let mut study = Study::described("sweeps", Arm::builtin(settings.arm)?.n_joints());
    for (table, rows) in study.tables.iter_mut().zip(points(settings)) {
        study.figures[0].charts.push(sweep(&table.caption, &rows, trials));
        for row in rows {
            table.push(&row.head, trials.of(&row).cells());
        }
    }
    Ok(study)
}

fn sweep(caption: &str, rows: &[Row], trials: &Trials) -> Chart {
    let mut places: Vec<String> =
        rows.iter().map(|row| row.scenarios[0].noise.to_string()).collect();
    places.dedup();
    let is_noise = places.len() > 1;
    let line = |method: Method| {
        let own = rows.iter().filter(|row| row.head[0] == method.name().into());
        let point = |(place, row): (usize, &Row)| {
            let x = if is_noise { place as f64 } else { row.scenarios[0].seconds };
            let worst = trials.of(row).worst();
            ([x, worst.median], [worst.least, worst.greatest])
        };
        let (points, spread) = own.enumerate().map(point).unzip();
        Series { spread, ..Series::new(method.name(), Mark::DottedLine, method.colour(), points) }
    };
    let x = if is_noise {
        Axis { places, ..Axis::named("signal-to-noise ratio of q/dq/ddq") }
    } else {
        Axis::log("recorded time [s]")
    };
    let y = Axis::log("RMSE / std(torque), worst joint [%]");
    let series = Method::SWEPT.into_iter().map(line).collect();
    Chart::new(caption.trim_end_matches('.'), [x, y], series)
}

/// N₁ of the product libraries that are counted, and of their gravity step.
const TRIG_ORDER: u8 = 4;
const GRAVITY_ORDER: u8 = 2;

/// Every arm with the noise of case 3.
pub(crate) fn arm_rows(settings: &Settings) -> Vec<Row> {
    let row = |&(arm, seconds): &(&'static str, f64)| {
        let scenario = Scenario { arm, seconds, noise: Noise::CASES[2], seed: settings.seed };
        Row::new(&[arm.into(), seconds.into()], &scenario, Method::Energy.options(), 1)
    };
    settings.arms.iter().map(row).collect()
}

/// How the energy library does for each arm, and how large the others would be.
pub(crate) fn arms(settings: &Settings, trials: &Trials) -> Result<Study> {
    let mut study = Study::described("arms", 0);
    for row in arm_rows(settings) {
        let (runs, arm) = (trials.of(&row), Arm::builtin(row.scenarios[0].arm)?);
        let (trial, truth) = (runs.first(), true_energies(&arm));
        let energies = trial.energies();
        let right = energies.iter().filter(|w| truth.contains_key(&w.term)).count();
        let errors: Vec<String> = trial.nrmse_percent.iter().map(|x| significant(*x, 2)).collect();
        let found = [format!("{right} of {}", truth.len()).into(), (energies.len() - right).into()];
        let errors = [errors.join(" / ").into(), runs.worst().median.into()];
        let sizes = candidates(&arm.kinds().all(arm.n_joints())).map(Cell::from);
        study.timed.tables[0].push(&row.head[..1], [trial.cost[1]]);
        study.tables[0].push(&row.head, sizes.into_iter().chain(found).chain(errors));
    }
    Ok(study)
}

/// Candidates of the energy library, of the steps over products, and of one-shot SINDy.
fn candidates(kinds: &[JointKind]) -> [usize; 3] {
    let products = |order, degrees: &[Degree]| product_library_size(kinds, order, degrees);
    let gravity = products(GRAVITY_ORDER, &[Degree::of(Kind::Gravity)]);
    let moving = products(TRIG_ORDER, &[Kind::Coriolis, Kind::Inertia].map(Degree::of));
    [energy_library_size(kinds, None), gravity + moving, products(TRIG_ORDER, &Degree::up_to(2))]
}

#[cfg(test)]
mod tests {
    #[test]
    fn libraries_are_as_large_as_the_results_say() {
        let arm = [super::JointKind::Revolute; 3];
        assert_eq!(super::candidates(&arm), [84, 1186, 3612], "as docs/results.md has them");
    }
}
