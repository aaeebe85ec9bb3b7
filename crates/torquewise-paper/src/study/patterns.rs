//! Purity of the patterns in noisy motions, with the scaled and with the printed index (Fig. 1–3).

use crate::charts::{chart, points};
use crate::error::{PaperError, within};
use crate::results::{Cell, Claim, Figure, Study, Table};
use crate::scenario::{Decibels, Settings};
use torquewise_identify::{PatternPlan, Patterns, Survey, find_patterns, survey};
use torquewise_motion::{Motion, Pattern};
use torquewise_report::html::number::significant;
use torquewise_report::html::{Axis, Band, Chart, Colour, Guide, Mark, Series};
use torquewise_stepwise::activation::Scaling;

/// The clusters of the paper.
const CLUSTERS: usize = 3;
/// Rows of a cloud at most.
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

/// Finds and judges the patterns at three levels of noise.
pub(crate) fn study(settings: &Settings) -> Result<Study, PaperError> {
    let mut scenario = settings.scenario(Decibels::CLUSTERING, settings.seed);
    let simulation = scenario.simulate()?;
    let truth = &simulation.truth;
    let mut table = Table::new(
        "Purity: share of the labelled rows that truly show the pattern. Found: share of the true \
         rows that are labelled so. Three clusters in every row of the table.",
        "noise on q/dq/ddq;index;k at the elbow;pattern;rows, true;rows, labelled;purity [%];\
         found [%]",
    );
    let (mut figures, mut claims) = (Vec::new(), Vec::new());
    for noise in [Decibels::CLUSTERING, Decibels::case(2), Decibels::case(3)] {
        scenario.noise = noise;
        let log = scenario.record(&simulation)?;
        let look = survey(&log).map_err(within("patterns"))?;
        let mut judged = |index: &'static str, scaling| -> Result<Clustered, PaperError> {
            let (patterns, elbow) = clustered(&look, scaling)?;
            let labels = patterns.label(&log);
            let mut least_percent = f64::INFINITY;
            for pattern in Pattern::ALL {
                let rows = truth.iter().filter(|truth| **truth == pattern).count();
                let labelled = labels.iter().filter(|label| **label == pattern).count();
                let both = labels.iter().zip(truth).filter(|(label, _)| **label == pattern);
                let right = both.filter(|(label, truth)| label == truth).count();
                let percent = |whole: usize| 100.0 * right as f64 / whole.max(1) as f64;
                let head = [noise.name().into(), index.into(), elbow.into()];
                let counts = [pattern.name().into(), rows.into(), labelled.into()];
                let shares = [percent(labelled), percent(rows)].map(Cell::from);
                table.push(head.into_iter().chain(counts).chain(shares));
                least_percent = least_percent.min(percent(labelled));
            }
            Ok(Clustered { index, patterns, elbow, least_percent })
        };
        let both = [judged("scaled", Scaling::Scaled)?, judged("printed", Scaling::Paper)?];
        if noise == Decibels::CLUSTERING {
            claims.push(claim(&both));
            figures = vec![plane(&both, &log, truth), elbow(&both), motion(&both[0], &log)];
        }
    }
    let text = "Why the printed index fails: it was made for motion in one direction. For motion \
                the other way the sum of the rates is negative and I = 1 − W‖a‖₁, which passes \
                through 0, the place of standstill, where ‖a‖₁ = 1/W. Scaling each joint by its \
                range and keeping W below 1/n leaves the switch S(a) to decide [E1].";
    let heading = "Patterns (Fig. 1–3)";
    Ok(Study { heading, text, claims, tables: vec![table], figures, ..Study::default() })
}

/// Three clusters, and how many the elbow asks for.
fn clustered(look: &Survey, scaling: Scaling) -> Result<(Patterns, usize), PaperError> {
    let plan = PatternPlan { scaling, ..PatternPlan::default() };
    let free = find_patterns(look, &plan).map_err(within("patterns"))?;
    let elbow = free.n_clusters();
    if elbow == CLUSTERS {
        return Ok((free, elbow));
    }
    let three = PatternPlan { clusters: Some(CLUSTERS), ..plan };
    Ok((find_patterns(look, &three).map_err(within("patterns"))?, elbow))
}

fn claim([scaled, printed]: &[Clustered; 2]) -> Claim {
    let measured = format!(
        "Noise {}: with the index as printed the elbow is at k = {} and the least pure of three \
         clusters holds {} % rows of its pattern; with the scaled index [E1] k = {} and {} %.",
        Decibels::CLUSTERING.name(),
        printed.elbow,
        significant(printed.least_percent, 3),
        scaled.elbow,
        significant(scaled.least_percent, 3),
    );
    Claim::new(
        "Fig. 1–3",
        "Clustering the activation index gives three clusters, chosen by the elbow, that are \
         standstill, uniform and variable velocity.",
        measured,
        [printed, scaled].map(|own| own.elbow == CLUSTERS && own.least_percent >= PURE),
    )
}

fn plane(both: &[Clustered; 2], log: &Motion, truth: &[Pattern]) -> Figure {
    let stride = log.n_rows().div_ceil(CLOUD_ROWS).max(1);
    let rows: Vec<usize> = (0..log.n_rows()).step_by(stride).collect();
    let part = log.select(&rows);
    let plane = |found: &Clustered| {
        let indices = found.patterns.activation.over(&part);
        let cloud = |pattern: Pattern| {
            let own = indices.iter().zip(&rows).filter(|(_, row)| truth[**row] == pattern);
            let points = own.map(|(point, _)| *point).collect();
            Series::new(pattern.name(), Mark::Cloud, Colour::Pattern(pattern), points)
        };
        let mut series: Vec<Series> = Pattern::ALL.into_iter().map(cloud).collect();
        let centres = found.patterns.centres.clone();
        series.push(Series::new("cluster centres", Mark::Rings, Colour::Series(1), centres));
        let x = Axis::named("activation of the velocity, I(dq) [–]");
        let y = Axis::named("activation of the acceleration, I(ddq) [–]");
        chart(format!("The {} index", found.index), x, y, series)
    };
    Figure::new(
        "fig1_activation",
        "Fig. 1: each dot is a row of the log, coloured by what the arm truly does; rings are the \
         centres of three clusters.",
        both.iter().map(plane).collect(),
    )
}

fn elbow(both: &[Clustered; 2]) -> Figure {
    let (mut series, mut guides) = (Vec::new(), Vec::new());
    for (place, Clustered { index, patterns, elbow, .. }) in both.iter().enumerate() {
        let whole = patterns.inertia.first().copied().unwrap_or(1.0);
        let points = (1..).zip(&patterns.inertia);
        let points = points.map(|(k, inertia)| [f64::from(k), inertia / whole]).collect();
        let label = format!("{index} index");
        series.push(Series::new(label, Mark::DottedLine, Colour::Series(place), points));
        guides.push(Guide::at_x(*elbow as f64, format!("elbow, {index}")));
    }
    let y = Axis::log("inertia over that of one cluster [–]");
    let chart = chart("Inertia of k clusters", Axis::whole("clusters k"), y, series);
    Figure::new(
        "fig2_elbow",
        "Fig. 2: what is left of the sum of squared distances to the centres with 1, 2, … clusters.",
        vec![Chart { guides, ..chart }],
    )
}

fn motion(scaled: &Clustered, log: &Motion) -> Figure {
    let rows: Vec<usize> =
        (0..log.n_rows()).take_while(|&row| log.t()[row] <= SHOWN_SECONDS).collect();
    let part = log.select(&rows);
    let (t, labels) = (part.t(), scaled.patterns.label(&part));
    let joint = |joint: usize| {
        let dq: Vec<f64> = part.dq().col(joint).iter().copied().collect();
        let points = points(t, &dq);
        Series::new(format!("joint {}", joint + 1), Mark::Line, Colour::Series(joint), points)
    };
    let band = |pattern: Pattern| {
        let mut spans: Vec<[f64; 2]> = Vec::new();
        for row in (0..t.len()).filter(|&row| labels[row] == pattern) {
            let until = t.get(row + 1).copied().unwrap_or(t[row]);
            match spans.last_mut() {
                Some([_, end]) if end.total_cmp(&t[row]).is_eq() => *end = until,
                _ => spans.push([t[row], until]),
            }
        }
        Band { label: pattern.name().into(), colour: Colour::Pattern(pattern), spans }
    };
    let (x, y) = (Axis::named("time [s]"), Axis::named("joint speed [rad/s]"));
    let series = (0..part.n_joints()).map(joint).collect();
    let chart = chart("Joint speeds, coloured by the pattern found", x, y, series);
    Figure::new(
        "fig3_patterns",
        "Fig. 3: the clusters of the scaled index over time: dwell, acceleration, cruise and \
         braking, told apart from noisy velocities and accelerations alone.",
        vec![Chart { bands: Pattern::ALL.into_iter().map(band).collect(), ..chart }],
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::Verdict;

    #[test]
    fn the_scaled_index_finds_every_pattern_and_the_printed_one_loses_standstill() {
        let settings = Settings { arm: "puma560-3", seconds: 120.0, ..Settings::quick(1) };

        let found = study(&settings).unwrap();

        assert_eq!(found.claims[0].verdict, Verdict::HoldsInPart, "{:?}", found.claims);
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
