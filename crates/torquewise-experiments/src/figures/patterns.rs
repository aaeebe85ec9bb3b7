//! From patterns to Fig. 1–3: activation plane, elbow, motion by pattern.

use crate::figures::Figure;
use crate::study::patterns::{PatternResults, Plane};
use torquewise_motion::Pattern;
use torquewise_report::html::{Axis, Band, Chart, Colour, Guide, Mark, Series};

/// The three figures.
pub(crate) fn figures(results: &PatternResults) -> Vec<Figure> {
    vec![activation(results), elbow(results), motion(results)]
}

fn activation(results: &PatternResults) -> Figure {
    let charts = vec![
        plane("Scaled index [E1]", &results.scaled),
        plane("Index as printed (6)(7)", &results.printed),
    ];
    Figure {
        name: "fig1_activation".into(),
        title: "Fig. 1: the activation plane".into(),
        caption:
            "Each dot is a row of the log, coloured by what the arm truly does; rings are the \
                  centres of three clusters. With the scaled index the three patterns are three \
                  heaps. With the printed one, uniform and variable motion spread over the whole \
                  plane: for motion in the negative direction I = 1 − W‖a‖₁, which falls back to \
                  0, the place of standstill, where ‖a‖₁ = 1/W."
                .into(),
        charts,
        columns: 2,
    }
}

fn plane(title: &str, plane: &Plane) -> Chart {
    let cloud = |(place, pattern): (usize, Pattern)| {
        let rows = plane.points.iter().zip(&plane.truth).filter(|(_, truth)| **truth == place);
        let points = rows.map(|(point, _)| *point).collect();
        Series::new(pattern.name(), Mark::Cloud, Colour::Pattern(pattern), points)
    };
    let mut series: Vec<Series> = Pattern::ALL.into_iter().enumerate().map(cloud).collect();
    let centres = plane.centres.clone();
    series.push(Series::new("cluster centres", Mark::Rings, Colour::Series(1), centres));
    Chart {
        title: title.into(),
        x: Axis::named("activation of the velocity, I(dq) [–]"),
        y: Axis::named("activation of the acceleration, I(ddq) [–]"),
        series,
        ..Chart::default()
    }
}

fn elbow(results: &PatternResults) -> Figure {
    let (mut series, mut guides, mut told) = (Vec::new(), Vec::new(), Vec::new());
    let first_noise = results.studies.first().map(|study| study.noise);
    let shown = results.studies.iter().filter(|study| Some(study.noise) == first_noise);
    for (place, study) in shown.enumerate() {
        let whole = study.inertia.first().copied().unwrap_or(1.0);
        let points = (1..).zip(&study.inertia);
        let points = points.map(|(k, inertia)| [f64::from(k), inertia / whole]).collect();
        let label = format!("{} index", study.index);
        series.push(Series::new(label, Mark::DottedLine, Colour::Series(place), points));
        guides.push(Guide::at_x(study.elbow as f64, format!("elbow, {}", study.index)));
        told.push(format!("k = {} with the {} index", study.elbow, study.index));
    }
    Figure {
        name: "fig2_elbow".into(),
        title: "Fig. 2: the elbow".into(),
        caption: format!(
            "What is left of the sum of squared distances to the centres with 1, 2, … clusters. \
             The rule for the elbow takes {}.",
            told.join(" and ")
        ),
        charts: vec![Chart {
            title: "Inertia of k clusters".into(),
            x: Axis::whole("clusters k"),
            y: Axis::log("inertia over that of one cluster [–]"),
            series,
            guides,
            ..Chart::default()
        }],
        columns: 1,
    }
}

fn motion(results: &PatternResults) -> Figure {
    let shown = &results.shown;
    let joint = |(place, dq): (usize, &Vec<f64>)| {
        let points = shown.t.iter().zip(dq).map(|(&t, &dq)| [t, dq]).collect();
        let label = format!("joint {}", place + 1);
        Series::new(label, Mark::Line, Colour::Series(place), points)
    };
    let band = |(place, pattern): (usize, Pattern)| Band {
        label: pattern.name().into(),
        colour: Colour::Pattern(pattern),
        spans: shown
            .stretches
            .iter()
            .filter(|(label, _, _)| *label == place)
            .map(|(_, from, to)| [*from, *to])
            .collect(),
    };
    Figure {
        name: "fig3_patterns".into(),
        title: "Fig. 3: what the clusters are".into(),
        caption: "The same clusters over time: dwell, acceleration, cruise and braking of \
                  positioning moves, told apart from the noisy velocities and accelerations alone."
            .into(),
        charts: vec![Chart {
            title: "Joint speeds, coloured by the pattern found".into(),
            x: Axis::named("time [s]"),
            y: Axis::named("joint speed [rad/s]"),
            series: shown.dq.iter().enumerate().map(joint).collect(),
            bands: Pattern::ALL.into_iter().enumerate().map(band).collect(),
            ..Chart::default()
        }],
        columns: 1,
    }
}
