//! From noisy motions to purity of the patterns, with the scaled and with the printed index (Fig.
//! 1–3).

use crate::error::{ExperimentError, within};
use crate::scenario::Decibels;
use crate::settings::Settings;
use serde::Serialize;
use torquewise_identify::{PatternPlan, Patterns, Survey, find_patterns, survey};
use torquewise_motion::{Motion, Pattern};
use torquewise_stepwise::activation::Scaling;

/// The clusters of the paper.
const CLUSTERS: usize = 3;
/// Rows of a cloud at most.
const CLOUD_ROWS: usize = 1_500;
/// Part of the motion that is shown \[s\].
const SHOWN_SECONDS: f64 = 16.0;

/// All about the patterns.
#[derive(Clone, Debug, Serialize)]
pub struct PatternResults {
    /// One per level of noise and index.
    pub studies: Vec<PatternStudy>,
    /// The activation plane at the first level, with the scaled index.
    pub scaled: Plane,
    /// The same with the printed one.
    pub printed: Plane,
    /// A part of the motion, with the patterns that the scaled index finds.
    pub shown: ShownMotion,
}

/// How well the patterns are found.
#[derive(Clone, Debug, Serialize)]
pub struct PatternStudy {
    /// `scaled` or `printed`.
    pub index: &'static str,
    pub noise: Decibels,
    /// Clusters at the elbow.
    pub elbow: usize,
    /// Inertia of 1, 2, … clusters.
    pub inertia: Vec<f64>,
    /// With three clusters, how pure each pattern is.
    pub purities: Vec<Purity>,
}

/// One pattern: what is true, what is found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Purity {
    /// Name of the pattern.
    pub pattern: &'static str,
    /// Rows that truly show it.
    pub rows: usize,
    /// Rows taken for it.
    pub labelled: usize,
    /// Rows rightly taken for it.
    pub right: usize,
}

impl Purity {
    /// Share of the rows taken for the pattern that truly show it \[%\]; 0 if there are none.
    pub fn percent(&self) -> f64 {
        100.0 * self.right as f64 / self.labelled.max(1) as f64
    }

    /// Share of the rows that truly show the pattern that are found \[%\].
    pub fn found_percent(&self) -> f64 {
        100.0 * self.right as f64 / self.rows.max(1) as f64
    }
}

/// Rows in the plane of I(q̇) and I(q̈).
#[derive(Clone, Debug, Serialize)]
pub struct Plane {
    /// The indices of some rows.
    pub points: Vec<[f64; 2]>,
    /// The pattern each of them truly shows: its place in [`Pattern::ALL`].
    pub truth: Vec<usize>,
    /// Centres of three clusters.
    pub centres: Vec<[f64; 2]>,
}

/// Some seconds of a motion.
#[derive(Clone, Debug, Serialize)]
pub struct ShownMotion {
    /// Instants \[s\], m.
    pub t: Vec<f64>,
    /// Speed of each joint \[rad/s\], n×m.
    pub dq: Vec<Vec<f64>>,
    /// Stretches of one pattern: its place in [`Pattern::ALL`], from and to \[s\].
    pub stretches: Vec<(usize, f64, f64)>,
}

/// Finds and judges the patterns at three levels of noise.
pub(crate) fn study_patterns(settings: &Settings) -> Result<PatternResults, ExperimentError> {
    let mut scenario = settings.scenario(Decibels::CLUSTERING, settings.seed);
    let simulation = scenario.simulate()?;
    let log = scenario.record(&simulation)?;
    let look = survey(&log).map_err(within("patterns"))?;
    let scaled = clustered(&look, Scaling::Scaled)?;
    let printed = clustered(&look, Scaling::Paper)?;
    let truth = &simulation.truth;
    let (scaled_plane, printed_plane) =
        (plane(&scaled.0, &log, truth), plane(&printed.0, &log, truth));
    let shown = shown(&scaled.0, &log);
    let mut studies = vec![
        judged("scaled", scenario.noise, &scaled, &log, truth),
        judged("printed", scenario.noise, &printed, &log, truth),
    ];
    for noise in [Decibels::case(2), Decibels::case(3)] {
        scenario.noise = noise;
        let log = scenario.record(&simulation)?;
        let look = survey(&log).map_err(within("patterns"))?;
        for (index, scaling) in [("scaled", Scaling::Scaled), ("printed", Scaling::Paper)] {
            studies.push(judged(index, noise, &clustered(&look, scaling)?, &log, truth));
        }
    }
    Ok(PatternResults { studies, scaled: scaled_plane, printed: printed_plane, shown })
}

/// Three clusters, and how many the elbow asks for.
fn clustered(look: &Survey, scaling: Scaling) -> Result<(Patterns, usize), ExperimentError> {
    let plan = PatternPlan { scaling, ..PatternPlan::default() };
    let free = find_patterns(look, &plan).map_err(within("patterns"))?;
    let elbow = free.n_clusters();
    if elbow == CLUSTERS {
        return Ok((free, elbow));
    }
    let three = PatternPlan { clusters: Some(CLUSTERS), ..plan };
    Ok((find_patterns(look, &three).map_err(within("patterns"))?, elbow))
}

fn judged(
    index: &'static str,
    noise: Decibels,
    (patterns, elbow): &(Patterns, usize),
    log: &Motion,
    truth: &[Pattern],
) -> PatternStudy {
    let labels = patterns.label(log);
    let purity = |pattern: Pattern| {
        let labelled = labels.iter().zip(truth).filter(|(label, _)| **label == pattern);
        Purity {
            pattern: pattern.name(),
            rows: truth.iter().filter(|truth| **truth == pattern).count(),
            labelled: labelled.clone().count(),
            right: labelled.filter(|(_, truth)| **truth == pattern).count(),
        }
    };
    let purities = Pattern::ALL.into_iter().map(purity).collect();
    PatternStudy { index, noise, elbow: *elbow, inertia: patterns.inertia.clone(), purities }
}

fn plane(patterns: &Patterns, log: &Motion, truth: &[Pattern]) -> Plane {
    let stride = log.n_rows().div_ceil(CLOUD_ROWS).max(1);
    let rows: Vec<usize> = (0..log.n_rows()).step_by(stride).collect();
    Plane {
        points: patterns.activation.over(&log.select(&rows)),
        truth: rows.iter().map(|&row| place_of(truth[row])).collect(),
        centres: patterns.centres.clone(),
    }
}

fn place_of(pattern: Pattern) -> usize {
    Pattern::ALL.iter().position(|known| *known == pattern).unwrap_or(0)
}

fn shown(patterns: &Patterns, log: &Motion) -> ShownMotion {
    let rows: Vec<usize> =
        (0..log.n_rows()).take_while(|&row| log.t()[row] <= SHOWN_SECONDS).collect();
    let part = log.select(&rows);
    let (t, labels) = (part.t(), patterns.label(&part));
    let mut stretches: Vec<(usize, f64, f64)> = Vec::new();
    for (&t, &label) in t.iter().zip(&labels) {
        let place = place_of(label);
        match stretches.last_mut() {
            Some((last, _, end)) if *last == place => *end = t,
            Some((_, _, end)) => {
                *end = t;
                stretches.push((place, t, t));
            }
            None => stretches.push((place, t, t)),
        }
    }
    let dq = (0..part.n_joints()).map(|joint| part.dq().col(joint).iter().copied().collect());
    ShownMotion { t: t.to_vec(), dq: dq.collect(), stretches }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scaled_index_finds_every_pattern_and_the_printed_one_loses_standstill() {
        let settings = Settings { arm: "puma560-3", seconds: 120.0, ..Settings::quick(1) };

        let results = study_patterns(&settings).unwrap();

        for study in &results.studies {
            let least = study.purities.iter().map(Purity::percent).fold(100.0, f64::min);
            if study.index == "scaled" {
                assert_eq!(study.elbow, 3);
                assert!(least >= 99.0, "{study:?}");
            } else {
                assert!(least < 90.0, "{study:?}");
            }
        }
        assert!(results.shown.stretches.len() > 4);
        assert_eq!(results.scaled.points.len(), results.scaled.truth.len());
    }
}
