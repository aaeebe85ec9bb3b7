//! Beyond the paper: what each choice buys, more noise, less data, more joints.

use crate::charts::{chart, colour};
use crate::error::PaperError;
use crate::method::{Method, lasso, threshold};
use crate::results::{Figure, Spread, Study, Table, Timed};
use crate::scenario::{Decibels, Scenario, Settings, outside};
use crate::trial::{Trial, TrialPlan, Trials, steps};
use crate::truth::true_energies;
use torquewise_identify::plan::{LibraryOptions, Regression};
use torquewise_identify::{PatternPlan, Plan};
use torquewise_model::library::{angle_functions, energy_library};
use torquewise_model::{Form, Model};
use torquewise_report::html::number::significant;
use torquewise_report::html::{Axis, Chart, Mark, Series};
use torquewise_sim::Arm;
use torquewise_stepwise::activation::Scaling;

/// All trials, the longest first.
pub(crate) fn plans(settings: &Settings) -> [Vec<TrialPlan>; 2] {
    let variants = variants().into_iter().flat_map(|variant| variant_seeds(settings, &variant));
    let points = points(settings).concat();
    let points = points.iter().flat_map(|point| point_seeds(settings, point));
    [arm_plans(settings), variants.chain(points).collect()]
}

/// The row with the paper's constants of the activation index.
const PRINTED: &str = "activation index as printed";
/// The row that is judged after the last step, before the refit.
const BEFORE_REFIT: &str = "no refit after the last step";

/// Family, what is changed, the equation that this puts to the test, the plan.
type Variant = (&'static str, &'static str, &'static str, Plan);

fn variants() -> Vec<Variant> {
    let mut variants = Vec::new();
    let uncorrected = |options| LibraryOptions { noise_correction: false, ..options };
    for method in [Method::Energy, Method::Product] {
        let (name, options) = (method.name(), method.options());
        let selecting = |selector| LibraryOptions { selector, ..options.clone() }.into();
        let patterns =
            PatternPlan { scaling: Scaling::Paper, clusters: Some(3), ..PatternPlan::default() };
        let one_step = LibraryOptions { regression: Regression::OneShot, ..options.clone() };
        let plan = Plan::from(options.clone());
        variants.extend([
            (name, "as it is", "", plan.clone()),
            (name, PRINTED, "[E1]", Plan { patterns, ..plan.clone() }),
            (name, "one step, all rows", "", one_step.into()),
            (name, "terms chosen by LASSO + BIC", "[E5]", selecting(lasso())),
            (name, "terms chosen by |c| > 0.1", "[E5]", selecting(threshold())),
            (name, BEFORE_REFIT, "[E6]", plan),
            (name, "no noise correction", "[E7]", uncorrected(options.clone()).into()),
        ]);
    }
    let (name, chosen) = ("one-shot SINDy", Method::SindyCriterion.options());
    variants.extend([
        (name, "terms chosen by |c| > 0.1", "", Method::Sindy.options().into()),
        (name, "terms chosen by LASSO + BIC", "", Method::SindyLasso.options().into()),
        (name, "terms chosen by the criterion", "[E5]", uncorrected(chosen.clone()).into()),
        (name, "criterion, noise correction", "[E7]", chosen.into()),
    ]);
    variants
}

/// The trials of a variant. The printed index leaves the product library with so many terms that
/// its refit takes longest of all: one seed says it.
fn variant_seeds(settings: &Settings, (_, change, _, plan): &Variant) -> Vec<TrialPlan> {
    let scenario = settings.scenario(Decibels::case(3), settings.seed);
    let seeds = if *change == PRINTED { 1 } else { settings.sweep_seeds };
    TrialPlan::seeds(&scenario, plan.clone(), seeds)
}

/// The error of every variant.
pub(crate) fn ablation(settings: &Settings, trials: &Trials) -> Result<Study, PaperError> {
    let test = outside(settings.arm, settings.seed)?;
    let mut table = Table::new(
        "Error outside the training log, median and range over the seeds.",
        "method;changed;tests;runs;terms",
    )
    .with_joints("error [%]", test.n_joints());
    for variant in variants() {
        let runs = trials.runs(&variant_seeds(settings, &variant))?;
        let (family, change, equation, _) = variant;
        let mut errors = runs.errors();
        if change == BEFORE_REFIT {
            let last = |trial: &&Trial| Ok(steps(&trial.model, Model::clone, &test)?.pop());
            let last = runs.0.iter().map(last).collect::<Result<Vec<_>, PaperError>>()?;
            errors = Spread::of_columns(last.iter().flatten().map(|step| &step.nrmse_percent[..]));
        }
        let (count, terms) = (runs.0.len().into(), runs.terms().into());
        table.push_with([family.into(), change.into(), equation.into(), count, terms], errors);
    }
    let text = "One choice of a stepwise method is changed at a time, in case 3. The two libraries \
                beside each other test [E4]; “one step” takes the steps away and leaves everything \
                else.";
    let heading = "What each choice buys";
    Ok(Study { heading, text, tables: vec![table], ..Study::default() })
}

/// One method at one point.
type Point = (Method, Scenario);

/// Each level of noise; then each length of the log, with the noise of case 3, for the methods that
/// are not ruined by it.
fn points(settings: &Settings) -> [Vec<Point>; 2] {
    let noisy = |noise| settings.scenario(noise, settings.seed);
    let levels = settings.noise_levels.iter().map(|&noise| noisy(noise));
    let long = |&seconds| Scenario { seconds, ..noisy(Decibels::case(3)) };
    let every = |scenario: Scenario, methods: &[Method]| -> Vec<Point> {
        methods.iter().map(|&method| (method, scenario.clone())).collect()
    };
    let unruined = [Method::Energy, Method::Product, Method::SindyCriterion];
    [
        levels.flat_map(|scenario| every(scenario, &Method::SWEPT)).collect(),
        settings.lengths.iter().map(long).flat_map(|log| every(log, &unruined)).collect(),
    ]
}

/// The trials of a point; one-shot SINDy with its threshold, the slowest, has one seed.
fn point_seeds(settings: &Settings, (method, scenario): &Point) -> Vec<TrialPlan> {
    let seeds = if *method == Method::Sindy { 1 } else { settings.sweep_seeds };
    TrialPlan::seeds(scenario, method.options(), seeds)
}

/// More noise, less data.
pub(crate) fn sweeps(settings: &Settings, trials: &Trials) -> Result<Study, PaperError> {
    let captions = ["More and more noise.", "Longer and longer logs, noise of case 3."];
    let (mut tables, mut charts) = (Vec::new(), Vec::new());
    for (caption, points) in captions.into_iter().zip(points(settings)) {
        let mut table = Table::new(caption, "method;noise;log [s];runs;terms")
            .with_joints("error [%]", Arm::builtin(settings.arm)?.n_joints());
        let mut worst = Vec::new();
        for point in &points {
            let runs = trials.runs(&point_seeds(settings, point))?;
            let (method, Scenario { noise, seconds, .. }) = point;
            let (count, terms) = (runs.0.len().into(), runs.terms().into());
            table.push_with(
                [method.name().into(), noise.name().into(), (*seconds).into(), count, terms],
                runs.errors(),
            );
            worst.push(runs.worst());
        }
        charts.push(sweep(caption, &points, &worst));
        tables.push(table);
    }
    let figure = Figure::new(
        "beyond_sweeps",
        "Error of the worst joint outside the training log, median with range over the seeds; \
         one-shot SINDy with its threshold has one seed.",
        charts,
    );
    let heading = "More noise, less data";
    Ok(Study { heading, tables, figures: vec![figure], ..Study::default() })
}

fn sweep(caption: &str, points: &[Point], worst: &[Spread]) -> Chart {
    let mut levels: Vec<Decibels> = points.iter().map(|(_, scenario)| scenario.noise).collect();
    levels.dedup();
    let is_noise = levels.len() > 1;
    let x = |scenario: &Scenario| {
        let level = levels.iter().position(|level| *level == scenario.noise).unwrap_or(0);
        if is_noise { level as f64 } else { scenario.seconds }
    };
    let line = |method: Method| {
        let own = points.iter().zip(worst).filter(|((other, _), _)| *other == method);
        let own = own.map(|((_, scenario), error)| {
            ([x(scenario), error.median], [error.least, error.greatest])
        });
        let (points, spread) = own.unzip();
        Series { spread, ..Series::new(method.name(), Mark::DottedLine, colour(method), points) }
    };
    let axis = if is_noise {
        let places = levels.iter().map(Decibels::name).collect();
        Axis { places, ..Axis::named("signal-to-noise ratio of q/dq/ddq") }
    } else {
        Axis::log("recorded time [s]")
    };
    let y = Axis::log("RMSE / std(torque), worst joint [%]");
    chart(caption.trim_end_matches('.'), axis, y, Method::SWEPT.into_iter().map(line).collect())
}

/// N₁ of the product libraries that are counted, and of their gravity step.
const TRIG_ORDER: u8 = 4;
const GRAVITY_ORDER: u8 = 2;

/// Every arm with the noise of case 3, the largest first.
fn arm_plans(settings: &Settings) -> Vec<TrialPlan> {
    let plan = |&(arm, seconds): &(&'static str, f64)| TrialPlan {
        scenario: Scenario { arm, seconds, noise: Decibels::case(3), seed: settings.seed },
        plan: Method::Energy.options().into(),
    };
    settings.arms.iter().rev().map(plan).collect()
}

/// How the energy library does for each arm, and how large the others would be.
pub(crate) fn arms(settings: &Settings, trials: &Trials) -> Result<Study, PaperError> {
    let mut table = Table::new(
        "Candidates of each library at N₁ = 4 and N₂ ≤ 2, and what the energy library finds in one \
         log with the noise of case 3.",
        "arm;log [s];energy library;product library;one-shot SINDy;true terms found;other terms;\
         error [%], joint 1 / 2 / …;error of the worst joint [%]",
    );
    let mut times = Table::new("CPU time of the energy library.", "arm;[s]");
    for plan in arm_plans(settings).iter().rev() {
        let runs = trials.runs(std::slice::from_ref(plan))?;
        let trial = runs.first();
        let arm = Arm::builtin(plan.scenario.arm)?;
        let [energy, product, sindy] = candidates(arm.n_joints());
        let truth = true_energies(&arm);
        let right = match &trial.model.form {
            Form::Energy(terms) => terms.iter().filter(|w| truth.contains_key(&w.term)).count(),
            Form::Torque(_) => 0,
        };
        let errors: Vec<String> = trial.nrmse_percent.iter().map(|x| significant(*x, 2)).collect();
        table.push([
            plan.scenario.arm.into(),
            plan.scenario.seconds.into(),
            energy.into(),
            product.into(),
            sindy.into(),
            format!("{right} of {}", truth.len()).into(),
            (trial.terms - right).into(),
            errors.join(" / ").into(),
            runs.worst().median.into(),
        ]);
        times.push_with([plan.scenario.arm.into()], [trial.cost.total]);
    }
    Ok(Study {
        heading: "More joints",
        tables: vec![table],
        timed: Timed { tables: vec![times], ..Timed::default() },
        ..Study::default()
    })
}

/// Candidates of the energy library, of the steps over products, and of one-shot SINDy.
fn candidates(n: usize) -> [usize; 3] {
    let [angles, gravity] =
        [TRIG_ORDER, GRAVITY_ORDER].map(|order| angle_functions(n, order).len());
    // Monomials of degree 2 in some variables.
    let squares = |variables: usize| variables * (variables + 1) / 2;
    let product = gravity + angles * (squares(n) + n);
    [energy_library(n, None).len(), product, angles * (1 + 2 * n + squares(2 * n))]
}

#[cfg(test)]
mod tests {
    use super::*;
    use torquewise_model::library::{Degree, product_library};

    #[test]
    fn libraries_are_counted_as_they_are_listed() {
        for n in 2..=3 {
            let listed = product_library(n, TRIG_ORDER, &Degree::up_to(2)).len();

            assert_eq!(candidates(n)[2], listed);
        }
        assert_eq!(candidates(3), [84, 1186, 3612], "as docs/results.md has them");
    }
}
