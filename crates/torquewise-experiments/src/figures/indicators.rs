//! From indicators to figure: the error of every way to sort and weight rows, against noise.

use crate::figures::Figure;
use crate::figures::looks::{beside, noise_axis, spread_series, worst_joint};
use crate::method::Method;
use crate::scenario::Decibels;
use crate::study::indicators::{IndicatorResults, IndicatorRow, Sorting};
use torquewise_report::html::{Axis, Chart, Colour, Mark, Series};

/// One chart for each library, with the noise correction.
pub(super) fn figure(results: &IndicatorResults) -> Figure {
    let (x, place) = noise_axis(results.rows.iter().map(|row| row.noise));
    let chart = |method: Method, title: &str| Chart {
        title: title.into(),
        x: x.clone(),
        y: Axis::log("RMSE / std(torque), worst joint [%]"),
        series: series(results, method, &place),
        ..Chart::default()
    };
    Figure {
        name: "beyond_indicators".into(),
        title: "Rows sorted by activation, noise and leverage".into(),
        caption: format!(
            "Error of the worst joint outside the training log of {} s, median with range over the \
             seeds, bias of the noise taken out.",
            results.log_length
        ),
        charts: vec![
            chart(Method::Energy, "Rows sorted, energy library"),
            chart(Method::Product, "Rows sorted, product library"),
        ],
        columns: 2,
    }
}

fn series(
    results: &IndicatorResults,
    method: Method,
    place: &impl Fn(Decibels) -> usize,
) -> Vec<Series> {
    let of = |(k, sorting): (usize, Sorting)| {
        let own = results
            .rows
            .iter()
            .filter(|row| row.method == method && row.sorting == sorting && row.noise_correction);
        let point = |row: &IndicatorRow| {
            let x = beside(place(row.noise), k, Sorting::ALL.len());
            (x, worst_joint(&row.nrmse_percent))
        };
        spread_series(sorting.name(), Colour::Series(k), Mark::Rings, own.map(point))
    };
    Sorting::ALL.into_iter().enumerate().map(of).collect()
}
