//! From sweeps, arms, coefficients to figures beyond the paper.

use crate::figures::Figure;
use crate::figures::looks::{colour, noise_axis, places, spread_series, worst_joint};
use crate::method::Method;
use crate::results::Results;
use crate::study::arms::ArmResults;
use crate::study::coefficients::{CoefficientResults, CoefficientRow, NINETY_PERCENT};
use crate::study::sweeps::Point;
use torquewise_report::html::{Axis, Chart, Colour, Guide, Mark, Series};

/// Noise and data, arms, coefficients.
pub(crate) fn figures(results: &Results) -> Vec<Figure> {
    let mut figures = vec![sweeps(results), arms(&results.arms)];
    figures.extend(results.coefficients.last().map(coefficients));
    figures
}

fn sweeps(results: &Results) -> Figure {
    let (x, place) = noise_axis(results.noise_sweep.iter().map(|point| point.noise));
    let y = || Axis::log("RMSE / std(torque), worst joint [%]");
    let noise = Chart {
        title: "More and more noise".into(),
        x,
        y: y(),
        series: lines(&results.noise_sweep, |point| place(point.noise) as f64),
        ..Chart::default()
    };
    let lengths = Chart {
        title: "Longer and longer logs, noise of case 3".into(),
        x: Axis::log("recorded time [s]"),
        y: y(),
        series: lines(&results.length_sweep, |point| point.log_length),
        ..Chart::default()
    };
    Figure {
        name: "beyond_sweeps".into(),
        title: "Error against noise and against data".into(),
        caption: "Error of the worst joint outside the training log, median with range over the \
                  seeds; one-shot SINDy with its threshold has one seed."
            .into(),
        charts: vec![noise, lengths],
        columns: 2,
    }
}

fn lines(points: &[Point], x: impl Fn(&Point) -> f64) -> Vec<Series> {
    let line = |method: Method| {
        let own = points.iter().filter(|point| point.method == method);
        let own = own.map(|point| (x(point), worst_joint(&point.nrmse_percent)));
        spread_series(method.name(), colour(method), Mark::DottedLine, own)
    };
    Method::SWEPT.into_iter().map(line).collect()
}

fn arms(arms: &[ArmResults]) -> Figure {
    let line = |label: &str, place: usize, y: fn(&ArmResults) -> f64| {
        let points = arms.iter().map(|arm| [arm.joints as f64, y(arm)]).collect();
        Series::new(label, Mark::DottedLine, Colour::Series(place), points)
    };
    let x = || Axis::whole("joints");
    let candidates = Chart {
        title: "Candidates".into(),
        x: x(),
        y: Axis::log("candidate functions"),
        series: vec![
            line("energy library", 0, |arm| arm.energy_candidates as f64),
            line("product library, all steps", 2, |arm| arm.product_candidates as f64),
            line("one-shot SINDy", 1, |arm| arm.sindy_candidates as f64),
            line("true energies", 5, |arm| arm.true_terms as f64),
        ],
        ..Chart::default()
    };
    let errors = Chart {
        title: "Error and time of the energy library".into(),
        x: x(),
        y: Axis::log("error, worst joint [%]; CPU time [s]"),
        series: vec![
            line("RMSE / std(torque), worst joint [%]", 0, |arm| {
                arm.nrmse_percent.iter().copied().fold(0.0, f64::max)
            }),
            line("CPU time, whole reconstruction [s]", 4, |arm| arm.seconds),
        ],
        ..Chart::default()
    };
    Figure {
        name: "beyond_arms".into(),
        title: "Arms of more joints".into(),
        caption: "Left: how the libraries grow at N₁ = 4 and N₂ ≤ 2. Right: the energy library on \
                  logs with the noise of case 3."
            .into(),
        charts: vec![candidates, errors],
        columns: 2,
    }
}

fn coefficients(results: &CoefficientResults) -> Figure {
    let deviation = |row: &CoefficientRow| {
        Some((row.estimate? - row.truth) / row.std_error.filter(|error| *error > 0.0)?)
    };
    let rows = || results.terms.iter().enumerate();
    let points = rows().filter_map(|(place, row)| Some([place as f64, deviation(row)?])).collect();
    let deviations = Chart {
        title: "Error of each coefficient, first seed".into(),
        x: places("", results.terms.iter().map(|row| row.name.clone())),
        y: Axis::named("error over standard error [–]"),
        series: vec![Series::new("", Mark::Rings, Colour::Series(0), points)],
        guides: vec![
            Guide::at_y(NINETY_PERCENT, "90 %"),
            Guide::at_y(-NINETY_PERCENT, ""),
            Guide::at_y(0.0, ""),
        ],
        ..Chart::default()
    };
    Figure {
        name: "beyond_coefficients".into(),
        title: format!("Coefficients beside the truth, case {}", results.case),
        caption: format!(
            "Case {}. If the standard errors are right, nine of ten marks lie between the outer \
             lines; over {} runs {:.0} % do.",
            results.case,
            results.runs,
            results.coverage_percent()
        ),
        charts: vec![deviations],
        columns: 1,
    }
}
