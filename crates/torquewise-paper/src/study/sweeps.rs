//! Error of every method against noise and against the length of the log.

use crate::charts::colour;
use crate::error::PaperError;
use crate::method::Method;
use crate::results::{Figure, Study, Table};
use crate::scenario::{Decibels, Scenario};
use crate::settings::Settings;
use crate::spread::Spread;
use crate::trial::{TrialPlan, Trials};
use torquewise_report::html::{Axis, Chart, Mark, Series};
use torquewise_sim::Arm;

/// One method at one point.
type Point = (Method, Scenario);

/// Each level of noise.
fn noise(settings: &Settings) -> Vec<Point> {
    let levels = settings.noise_levels.iter().map(|&noise| settings.scenario(noise, settings.seed));
    levels.flat_map(|scenario| Method::SWEPT.map(|method| (method, scenario.clone()))).collect()
}

/// Each length of the log, with the noise of case 3, for the methods that are not ruined by it.
fn lengths(settings: &Settings) -> Vec<Point> {
    let scenario = settings.scenario(Decibels::case(3), settings.seed);
    let lengths = settings.lengths.iter().map(|&seconds| Scenario { seconds, ..scenario.clone() });
    let methods = [Method::Energy, Method::Product, Method::SindyCriterion];
    lengths.flat_map(|scenario| methods.map(|method| (method, scenario.clone()))).collect()
}

/// The trials of a point; one-shot SINDy with its threshold, the slowest, has one seed.
fn seeds(settings: &Settings, (method, scenario): &Point) -> Vec<TrialPlan> {
    let seeds = if *method == Method::Sindy { 1 } else { settings.sweep_seeds };
    TrialPlan::seeds(scenario, method.options(), seeds)
}

/// All trials.
pub(crate) fn plans(settings: &Settings) -> Vec<TrialPlan> {
    let points = [noise(settings), lengths(settings)].concat();
    points.iter().flat_map(|point| seeds(settings, point)).collect()
}

/// More noise, less data.
pub(crate) fn study(settings: &Settings, trials: &Trials) -> Result<Study, PaperError> {
    let captions = ["More and more noise.", "Longer and longer logs, noise of case 3."];
    let (mut tables, mut charts) = (Vec::new(), Vec::new());
    for (caption, points) in captions.into_iter().zip([noise(settings), lengths(settings)]) {
        let mut table = Table::new(caption, "method;noise;log [s];runs;terms")
            .with_joints("error [%]", Arm::builtin(settings.arm)?.n_joints());
        let mut worst = Vec::new();
        for point in &points {
            let runs = trials.runs(&seeds(settings, point))?;
            let (method, Scenario { noise, seconds, .. }) = point;
            let (count, terms) = (runs.0.len().into(), runs.terms().into());
            table.push_with(
                [method.name().into(), noise.name().into(), (*seconds).into(), count, terms],
                runs.errors(),
            );
            worst.push(runs.worst());
        }
        charts.push(chart(caption, &points, &worst));
        tables.push(table);
    }
    let figure = Figure {
        name: "beyond_sweeps".into(),
        caption: "Error of the worst joint outside the training log, median with range over the \
                  seeds; one-shot SINDy with its threshold has one seed."
            .into(),
        charts,
    };
    let heading = "More noise, less data";
    Ok(Study { heading, tables, figures: vec![figure], ..Study::default() })
}

fn chart(caption: &str, points: &[Point], worst: &[Spread]) -> Chart {
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
    Chart {
        title: caption.trim_end_matches('.').into(),
        x: if is_noise {
            let places = levels.iter().map(Decibels::name).collect();
            Axis { places, ..Axis::named("signal-to-noise ratio of q/dq/ddq") }
        } else {
            Axis::log("recorded time [s]")
        },
        y: Axis::log("RMSE / std(torque), worst joint [%]"),
        series: Method::SWEPT.into_iter().map(line).collect(),
        ..Chart::default()
    }
}
