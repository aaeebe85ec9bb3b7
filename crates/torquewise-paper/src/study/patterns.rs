//! Purity of the patterns in noisy motions, with the scaled and with the printed index (Fig. 1–3).

use crate::{Result, Settings, Study, within};
use torquewise_identify::{PatternPlan, Patterns, find_patterns, survey};
use torquewise_motion::{Motion, Pattern};
use torquewise_report::{Axis, Chart, Colour, Guide, Mark, Series, pattern_bands, significant};
use torquewise_sim::Noise;
use torquewise_stepwise::activation::Scaling;

const CLUSTERS: usize = 3;
const CLOUD_ROWS: usize = 1_500;
/// Part of the motion that is shown \[s\].
const SHOWN_SECONDS: f64 = 16.0;
/// A pattern is found if so many percent of its rows are truly of it.
const PURE: f64 = 95.0;

/// Three clusters by one index, and how many the elbow asks for.
struct Clustered {
    index: &'static str,
    patterns: Patterns,
    elbow: usize,
    /// Share of the rows taken for the least pure pattern that truly show it \[%\].
    least_percent: f64,
}

pub(crate) fn study(settings: &Settings) -> Result<Study> {
    // The noise of the clustering figures.
    let clustering = Noise::from_db(f64::INFINITY, 60.0, 50.0)?;
    let mut scenario = settings.scenario(clustering);
    let simulation = scenario.simulate()?;
    let truth = &simulation.truth;
    let mut study = Study::described("patterns", 0);
    let Study { claims, tables, figures, .. } = &mut study;
    for noise in [clustering, Noise::CASES[1], Noise::CASES[2]] {
        scenario.noise = noise;
        let log = scenario.record(&simulation)?;
        let look = survey(&log).map_err(within("patterns"))?;
        let mut judged = |index: &'static str, scaling| -> Result<Clustered> {
            let find = |clusters| {
                let plan = PatternPlan { scaling, clusters, ..PatternPlan::default() };
                find_patterns(&look, &plan).map_err(within("patterns"))
            };
            let (elbow, patterns) = (find(None)?.n_clusters(), find(Some(CLUSTERS))?);
            let labels = patterns.label(&log);
            let mut least_percent = f64::INFINITY;
            for pattern in Pattern::ALL {
                let count = |all: &[Pattern]| all.iter().filter(|own| **own == pattern).count();
                let (rows, labelled) = (count(truth), count(&labels));
                let both = labels.iter().zip(truth).filter(|both| *both == (&pattern, &pattern));
                let right = both.count();
                let percent = |whole: usize| 100.0 * right as f64 / whole.max(1) as f64;
                let head = [noise.to_string().into(), index.into(), elbow.into()];
                let counts = [pattern.name().into(), rows.into(), labelled.into()];
                tables[0].push(&[head, counts].concat(), [labelled, rows].map(percent));
                least_percent = least_percent.min(percent(labelled));
            }
            Ok(Clustered { index, patterns, elbow, least_percent })
        };
        let both = [judged("scaled", Scaling::Scaled)?, judged("printed", Scaling::Paper)?];
        if noise == clustering {
            let [scaled, printed] = &both;
            let show = |own: &Clustered| [own.elbow.to_string(), significant(own.least_percent, 3)];
            let is_found = |own: &Clustered| own.elbow == CLUSTERS && own.least_percent >= PURE;
            let values = [show(printed), show(scaled)].concat();
            let found = [printed, scaled].map(is_found);
            claims[0].judge(values, &[found[0], found[0] || found[1]]);
            figures[0].charts = both.iter().map(|own| plane(own, &log, truth)).collect();
            figures[1].charts = vec![elbow(&both)];
            figures[2].charts = vec![motion(&both[0], &log)];
        }
    }
    Ok(study)
}

/// Rows of the log, coloured by what the arm truly does, and the centres of the clusters.
fn plane(found: &Clustered, log: &Motion, truth: &[Pattern]) -> Chart {
    let stride = log.n_rows().div_ceil(CLOUD_ROWS).max(1);
    let rows: Vec<usize> = (0..log.n_rows()).step_by(stride).collect();
    let indices = found.patterns.activation.over(&log.select(&rows));
    let cloud = |pattern: Pattern| {
        let own = indices.iter().zip(&rows).filter(|(_, row)| truth[**row] == pattern);
        let points = own.map(|(point, _)| *point).collect();
        Series::new(pattern.name(), Mark::Cloud, Colour::Pattern(pattern), points)
    };
    let mut series: Vec<Series> = Pattern::ALL.into_iter().map(cloud).collect();
    let centres = found.patterns.centres.clone();
    series.push(Series::new("cluster centres", Mark::Rings, Colour::Series(1), centres));
    let axes =
        ["activation of the velocity, I(dq) [–]", "activation of the acceleration, I(ddq) [–]"];
    Chart::new(format!("The {} index", found.index), axes.map(Axis::named), series)
}

/// What is left of the sum of squared distances to the centres of k clusters.
fn elbow(both: &[Clustered; 2]) -> Chart {
    let (mut series, mut guides) = (Vec::new(), Vec::new());
    for (place, Clustered { index, patterns, elbow, .. }) in both.iter().enumerate() {
        let whole = patterns.inertia.first().copied().unwrap_or(1.0);
        let points = (1..).zip(&patterns.inertia);
        let points = points.map(|(k, inertia)| [f64::from(k), inertia / whole]).collect();
        let label = format!("{index} index");
        series.push(Series::new(label, Mark::DottedLine, Colour::Series(place), points));
        guides.push(Guide::at_x(*elbow as f64, format!("elbow, {index}")));
    }
    let axes = [Axis::whole("clusters k"), Axis::log("inertia over that of one cluster [–]")];
    Chart { guides, ..Chart::new("Inertia of k clusters", axes, series) }
}

/// Joint speeds over time, and the pattern that each row is taken for.
fn motion(scaled: &Clustered, log: &Motion) -> Chart {
    let rows: Vec<usize> =
        (0..log.n_rows()).take_while(|&row| log.t()[row] <= SHOWN_SECONDS).collect();
    let part = log.select(&rows);
    let joint = |joint: usize| {
        let points = part.t().iter().zip(part.dq().col(joint).iter()).map(|(&t, &dq)| [t, dq]);
        let label = format!("joint {}", joint + 1);
        Series::new(label, Mark::Line, Colour::Series(joint), points.collect())
    };
    let (title, axes) =
        ("Joint speeds, coloured by the pattern found", ["time [s]", "joint speed [rad/s]"]);
    let chart = Chart::over(title, axes, (0..part.n_joints()).map(joint).collect());
    Chart { bands: pattern_bands(part.t(), &scaled.patterns.label(&part)), ..chart }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::{Cell, ClaimVerdict};

    #[test]
    fn the_scaled_index_finds_every_pattern_and_the_printed_one_loses_standstill() {
        let settings = Settings { arm: "puma560-3", seconds: 120.0, ..Settings::quick(1) };

        let found = study(&settings).unwrap();

        assert_eq!(found.claims[0].verdict, ClaimVerdict::HoldsInPart, "{:?}", found.claims);
        let rows = &found.tables[0].rows;
        assert_eq!(rows.len(), 3 * 2 * 3);
        for patterns in rows.chunks(3) {
            let below =
                |bound| move |row: &Vec<Cell>| matches!(row[6], Cell::Number(x) if x < bound);
            if patterns[0][1] == "scaled".into() {
                assert_eq!(patterns[0][2], 3.into());
                assert!(!patterns.iter().any(below(99.0)), "{patterns:?}");
            } else {
                assert!(patterns.iter().any(below(90.0)), "{patterns:?}");
            }
        }
    }
}
