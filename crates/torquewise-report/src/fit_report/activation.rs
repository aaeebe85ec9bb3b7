//! From findings to charts of the patterns: the activation plane, the elbow, the motion in their
//! colours.

use crate::fit_report::Findings;
use crate::fit_report::clock::{self, Clock};
use crate::fit_report::torques::LINK;
use crate::html::number::{count, significant};
use crate::html::{Axis, Chart, Colour, Column, Guide, Item, Label, Mark, Section, Series, Table};
use torquewise_motion::Pattern;

/// Points of the activation plane: a cloud of more is a blot.
const MOST_POINTS: usize = 3_000;

/// How rows were told apart, and where they lie in time.
pub(crate) fn section(findings: &Findings<'_>) -> Section {
    let n_clusters = findings.found.patterns.n_clusters();
    let words = format!(
        "Each row is a point in the plane of the activation indices of velocity and acceleration. \
         K-means at the elbow of its inertia gives {n_clusters} clusters, each named by what it \
         activates: gravity alone at standstill, Coriolis torque at uniform velocity, inertia at \
         variable velocity."
    );
    let charts = vec![
        Item::Charts(vec![plane(findings), elbow(findings)]),
        Item::Charts(vec![motion(findings)]),
    ];
    let summary = "Activation plane, elbow, and motion in the colours of its patterns".into();
    let items = vec![Item::Text(words), table(findings), Item::Details { summary, items: charts }];
    Section { heading: "Patterns".into(), items }
}

/// Rows of a pattern in percent.
fn share(findings: &Findings<'_>, pattern: Pattern) -> f64 {
    let patterns = &findings.diagnosis.trace.patterns;
    let own = patterns.iter().filter(|&&row| row == pattern).count();
    100.0 * own as f64 / patterns.len().max(1) as f64
}

fn plane(findings: &Findings<'_>) -> Chart {
    let (survey, patterns) = (&findings.found.survey, &findings.found.patterns);
    let m = survey.sample.n_rows();
    let taken = m.min(MOST_POINTS);
    let rows: Vec<usize> = (0..taken).map(|place| place * m / taken.max(1)).collect();
    let sample = survey.sample.select(&rows);
    let points = patterns.activation.over(&sample);
    let labels = patterns.label(&sample);
    let of = |pattern: Pattern| {
        let own = points.iter().zip(&labels).filter(|(_, label)| **label == pattern);
        let own: Vec<[f64; 2]> = own.map(|(point, _)| *point).collect();
        Series::new(pattern.name(), Mark::Cloud, Colour::Pattern(pattern), own)
    };
    let clouds = Pattern::ALL.into_iter().map(of).filter(|series| !series.points.is_empty());
    let centres = Series::new("centre", Mark::Rings, Colour::Series(1), patterns.centres.clone());
    let guides = patterns.switches.map(|[velocity, acceleration]| {
        vec![Guide::at_x(velocity, ""), Guide::at_y(acceleration, "")]
    });
    Chart {
        title: "Activation plane".into(),
        caption: "Dashed lines: where velocity and acceleration count as switched on.".into(),
        x: Axis::named("activation of velocity, I(q̇)"),
        y: Axis::named("activation of acceleration, I(q̈)"),
        series: clouds.chain([centres]).collect(),
        guides: guides.unwrap_or_default(),
        ..Chart::default()
    }
}

fn elbow(findings: &Findings<'_>) -> Chart {
    let patterns = &findings.found.patterns;
    let places = patterns.inertia.iter().enumerate();
    let points = places.map(|(place, &inertia)| [place as f64 + 1.0, inertia]).collect();
    let chosen = patterns.n_clusters();
    let can_be_log = patterns.inertia.iter().all(|inertia| *inertia > 0.0);
    let y = "inertia: sum of squared distances";
    Chart {
        title: "Elbow".into(),
        caption: "Beyond the elbow, one more cluster makes little difference.".into(),
        x: Axis::whole("clusters"),
        y: if can_be_log { Axis::log(y) } else { Axis::named(y) },
        series: vec![Series::new("inertia", Mark::DottedLine, Colour::Series(0), points)],
        guides: vec![Guide::at_x(chosen as f64, "chosen")],
        ..Chart::default()
    }
}

fn motion(findings: &Findings<'_>) -> Chart {
    let trace = &findings.diagnosis.trace;
    let clock = Clock::new(trace.motion.t());
    let dq = trace.motion.dq();
    let line = |(joint, name): (usize, &String)| {
        let points = clock.curve(|row| dq[(row, joint)]);
        Series::new(name, Mark::Line, Colour::Series(joint), points)
    };
    Chart {
        title: "Motion, coloured by pattern".into(),
        x: Axis::named(clock::LABEL),
        y: Axis::named("velocity [rad/s]"),
        series: findings.joints().iter().enumerate().map(line).collect(),
        bands: clock.bands(&trace.patterns),
        linked: Some(LINK.into()),
        ..Chart::default()
    }
}

fn table(findings: &Findings<'_>) -> Item {
    let patterns = &findings.found.patterns;
    let row = |pattern: Pattern| -> Vec<Label> {
        let clusters = patterns.names.iter().filter(|name| **name == pattern).count();
        let used = if patterns.present.contains(&pattern) { "yes" } else { "no" };
        vec![
            pattern.name().into(),
            significant(share(findings, pattern), 3).into(),
            count(clusters).into(),
            used.into(),
        ]
    };
    Item::Table(Table {
        caption: "A pattern is used if it has enough rows and what should be zero in them is."
            .into(),
        columns: vec![
            Column::words("pattern"),
            Column::numbers("rows [%]"),
            Column::numbers("clusters"),
            Column::words("used"),
        ],
        rows: Pattern::ALL.into_iter().map(row).collect(),
    })
}
