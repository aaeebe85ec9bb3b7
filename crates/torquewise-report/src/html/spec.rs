//! A chart as JSON for the script of a page: thinned columns of short numbers.

use crate::html::chart::{Axis, Chart, Guide, Series, Stretches};
use crate::html::number::rounded;
use crate::html::thin::{rows_of, sorted};
use crate::{Result, script_json};
use serde_json::{Value, json};
use torquewise_motion::grouped;

pub(crate) fn spec_json(chart: &Chart) -> Result<String> {
    let mut columns: Vec<Vec<Value>> = Vec::new();
    let mut series = vec![Value::Null; chart.series.len()];
    for group in groups(chart) {
        let rows = rows_of(&group.iter().map(|(_, own)| own).collect::<Vec<_>>());
        let first = &group[0].1.points;
        let x: Vec<f64> = rows.iter().map(|&row| first[row][0]).collect();
        for (place, own) in &group {
            // The logarithm of what is not positive is a gap.
            let height = |y: f64| if chart.y.log && y <= 0.0 { f64::NAN } else { y };
            let pick = |end: usize| -> Vec<Value> {
                let ends = rows.iter().filter_map(|&row| own.spread.get(row));
                rounded(&ends.map(|ends| height(ends[end])).collect::<Vec<f64>>())
            };
            let y: Vec<f64> = rows.iter().map(|&row| height(own.points[row][1])).collect();
            series[*place] = json!({
                "label": own.label,
                "colour": own.colour.variable(),
                "mark": own.mark,
                "column": columns.len(),
                "y": rounded(&y),
                "low": pick(0),
                "high": pick(1),
            });
        }
        columns.push(rounded(&x));
    }
    let band = |band: &Stretches| {
        let spans: Vec<_> = band.spans.iter().map(|span| rounded(span)).collect();
        json!({ "colour": band.colour.variable(), "spans": spans })
    };
    let guides = chart.guides.iter().filter(|guide| guide.at.is_finite());
    let guide = |own: &Guide| json!({ "axis": if own.is_level { "y" } else { "x" }, "at": own.at });
    script_json(&json!({
        "x": drawable(&chart.x),
        "y": drawable(&chart.y),
        "columns": columns,
        "series": series,
        "bands": chart.bands.iter().map(band).collect::<Vec<_>>(),
        "guides": guides.map(guide).collect::<Vec<_>>(),
        "linked": chart.linked,
    }))
}

/// Places and drawn points of series: those that are lines over the same abscissae stay together,
/// every other one is alone.
fn groups(chart: &Chart) -> Vec<Vec<(usize, Series)>> {
    let all = chart.series.iter().map(|series| sorted(series, chart.x.log)).enumerate();
    grouped(all, |(_, other), (_, own)| {
        let mut pairs = other.points.iter().zip(&own.points);
        other.mark.is_line()
            && own.mark.is_line()
            && other.points.len() == own.points.len()
            && pairs.all(|(a, b)| a[0].total_cmp(&b[0]).is_eq())
    })
}

/// The axis without a range that cannot be.
fn drawable(axis: &Axis) -> Axis {
    let usable = |range: &[f64; 2]| {
        range.iter().all(|end| end.is_finite() && (!axis.log || *end > 0.0)) && range[0] < range[1]
    };
    Axis { range: axis.range.filter(usable), ..axis.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::html::chart::{Mark, Series};
    use crate::html::colour::Colour;

    fn spec(chart: &Chart) -> Value {
        serde_json::from_str(&spec_json(chart).unwrap()).unwrap()
    }

    #[test]
    fn curves_over_the_same_abscissae_share_a_column() {
        let points = |scale: f64| vec![[2.0, scale], [1.0, f64::NAN], [f64::NAN, 1.0]];
        let cloud = Series::new("c", Mark::Cloud, Colour::Faded, vec![[1.0, 0.25]]);
        let series = vec![Series::line("a", points(3.0)), Series::line("b", points(4.0)), cloud];

        let spec = spec(&Chart { series, ..Chart::default() });

        assert_eq!(spec["columns"], json!([[1, 2], [1]]));
        let columns: Vec<&Value> =
            spec["series"].as_array().unwrap().iter().map(|s| &s["column"]).collect();
        assert_eq!(columns, [&json!(0), &json!(0), &json!(1)]);
        assert_eq!(spec["series"][1]["y"], json!([null, 4]));
    }

    #[test]
    fn a_logarithmic_axis_has_no_zeros() {
        let series = Series {
            spread: vec![[0.0, 2.0], [1.0, 3.0]],
            ..Series::line("a", vec![[1.0, 0.0], [2.0, 2.0]])
        };
        let chart = Chart { y: Axis::log("error"), series: vec![series], ..Chart::default() };

        let spec = spec(&chart);

        assert_eq!(spec["series"][0]["y"], json!([null, 2]));
        assert_eq!(spec["series"][0]["low"], json!([null, 1]));
    }
}
