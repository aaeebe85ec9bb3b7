//! From costs to Fig. 6: candidates and computing time.

use crate::figures::Figure;
use crate::figures::looks::{places, spread_series};
use crate::spread::Spread;
use crate::study::cost::MethodCost;
use torquewise_report::html::{Axis, Chart, Colour, Mark, Series};

/// Candidates beside time.
pub(crate) fn figure(costs: &[MethodCost]) -> Figure {
    Figure {
        name: "fig6_cost".into(),
        title: "Fig. 6: candidates and computing time".into(),
        caption:
            "Each method with its rule for which terms stay. Above: candidates of all steps and \
                  of the largest regression. Below: CPU time of one thread, median with the range \
                  over the timed runs. The regression is normal equations and selection; the whole \
                  adds survey, clusters and the last refit on all rows. The third mark is the \
                  paper's way to the normal equations alone: every column evaluated on every row, \
                  in place of sums of moments [E3]."
                .into(),
        charts: vec![candidates(costs), times(costs)],
        columns: 1,
    }
}

fn names(costs: &[MethodCost]) -> Axis {
    let short = |cost: &MethodCost| {
        let library = cost.name.trim_start_matches("stepwise, ").trim_start_matches("one-shot ");
        format!("{library}: {}", cost.rule)
    };
    places("", costs.iter().map(short))
}

fn candidates(costs: &[MethodCost]) -> Chart {
    let series = |label: &str, place: usize, count: fn(&MethodCost) -> usize| {
        let points = costs.iter().enumerate();
        let points = points.map(|(k, cost)| [k as f64, count(cost) as f64]).collect();
        Series::new(label, Mark::Rings, Colour::Series(place), points)
    };
    Chart {
        title: "Candidates".into(),
        x: names(costs),
        y: Axis::log("candidate functions"),
        series: vec![
            series("all steps", 1, |cost| cost.candidates),
            series("largest regression", 0, |cost| {
                cost.candidates_by_step.iter().copied().max().unwrap_or(0)
            }),
        ],
        ..Chart::default()
    }
}

fn times(costs: &[MethodCost]) -> Chart {
    let series = |label: &str, place: usize, time: fn(&MethodCost) -> Spread| {
        let points = costs.iter().enumerate().map(|(k, cost)| (k as f64, time(cost)));
        spread_series(label, Colour::Series(place), Mark::Rings, points)
    };
    let evaluated = |cost: &MethodCost| Spread::of([cost.seconds.evaluated]);
    Chart {
        title: "CPU time".into(),
        x: names(costs),
        y: Axis::log("CPU time [s]"),
        series: vec![
            series("regression", 0, |cost| cost.seconds.regression),
            series("whole reconstruction", 1, |cost| cost.seconds.total),
            series("normal equations, columns evaluated", 2, evaluated),
        ],
        ..Chart::default()
    }
}
