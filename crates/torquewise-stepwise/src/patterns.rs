//! Clusters of rows, named by the part of the torque they activate.

use crate::activation::{Activation, Scaling};
use crate::{IdentifyError, Survey};
use serde::{Deserialize, Serialize};
use torquewise_motion::{Motion, Pattern};
use torquewise_regression::kmeans::{elbow, kmeans};

const MOST_CLUSTERS: usize = 9;
/// An index above this means that the joints are switched on.
const HALF: f64 = 0.5;
/// A pattern of fewer rows of the sample than this part of it is not there.
pub(crate) const LEAST_SHARE: f64 = 0.005;
/// What should be zero may be this many times the noise, or this part of the joint's range.
const OF_NOISE: f64 = 3.0;
const OF_RANGE: f64 = 0.04;
/// Slow motion: at most this part of the range, so that what grows with q̇² is a hundredth.
const SLOW: f64 = 0.1;

/// How rows are clustered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PatternPlan {
    /// Constants of the activation index.
    pub scaling: Scaling,
    /// Number of clusters; `None` for the elbow.
    pub clusters: Option<usize>,
    /// Whether slow motion of constant speed passes for standstill: where there is friction, which
    /// may be anything at rest, it tells more of gravity.
    pub slow: bool,
    /// Seed of k-means.
    pub seed: u64,
}

/// Clusters of rows in the plane \[I(q̇) I(q̈)\] and the pattern each stands for.
#[derive(Clone, Debug, PartialEq)]
pub struct Patterns {
    /// The index rows are clustered by.
    pub activation: Activation,
    /// Cluster centres, k.
    pub centres: Vec<[f64; 2]>,
    /// Pattern of each cluster, k; several clusters may share one.
    pub names: Vec<Pattern>,
    /// Where I(q̇) and I(q̈) switch on; `None` with the printed index.
    pub switches: Option<[f64; 2]>,
    /// Squares within clusters for 1, 2, … of them, the inertia of k-means: the elbow curve.
    pub inertia: Vec<f64>,
    /// Patterns that are there: of some rows, and truly at rest or without acceleration.
    pub present: Vec<Pattern>,
}

/// Clusters the sample of a survey (algorithm 1 of the paper).
///
/// A cluster whose centre has I(q̈) above one half is variable velocity, else one with I(q̇) above
/// one half uniform velocity, else standstill.
///
/// # Errors
/// [`IdentifyError::Clusters`] if a number of clusters out of range is asked for.
pub fn find_patterns(survey: &Survey, plan: &PatternPlan) -> Result<Patterns, IdentifyError> {
    if let Some(wanted) = plan.clusters.filter(|k| !(1..=MOST_CLUSTERS).contains(k)) {
        return Err(IdentifyError::Clusters(wanted));
    }
    let activation = match plan.scaling {
        Scaling::Scaled => Activation::scaled(&survey.sample),
        Scaling::Paper => Activation::paper(survey.joints.len()),
    };
    let points = activation.over(&survey.sample);
    let most = MOST_CLUSTERS.min(points.len());
    let mut clusterings =
        (1..=most).map(|k| kmeans(&points, k, plan.seed)).collect::<Result<Vec<_>, _>>()?;
    if clusterings.is_empty() {
        return Err(IdentifyError::TooFewRows { rows: 0, needed: 1, joints: survey.joints.len() });
    }
    let inertia: Vec<f64> = clusterings.iter().map(|clustering| clustering.inertia).collect();
    let chosen = plan.clusters.unwrap_or_else(|| elbow(&inertia)).clamp(1, most);
    let centres = clusterings.swap_remove(chosen - 1).centres;
    let names = centres.iter().map(|[dq, ddq]| Pattern::when(*dq > HALF, *ddq > HALF)).collect();
    let switches = (plan.scaling == Scaling::Scaled).then(|| switches(&centres));
    let present = Pattern::ALL.to_vec();
    let mut patterns = Patterns { activation, centres, names, switches, inertia, present };
    if plan.scaling == Scaling::Scaled && survey.stands_still() {
        // What is left of an arm that stands still is the noise of its encoders.
        patterns.names.fill(Pattern::Standstill);
        patterns.present = vec![Pattern::Standstill];
        patterns.switches = Some([f64::INFINITY; 2]);
        return Ok(patterns);
    }
    let labels = patterns.label(&survey.sample);
    let is_genuine = |&pattern: &Pattern| patterns.is_genuine(survey, &labels, pattern, plan.slow);
    patterns.present = Pattern::ALL.into_iter().filter(is_genuine).collect();
    Ok(patterns)
}

impl Patterns {
    /// Number of clusters k.
    pub fn n_clusters(&self) -> usize {
        self.centres.len()
    }

    /// Whether a pattern has rows, and what should be zero in them is: the velocity at standstill,
    /// the acceleration at uniform velocity, but for noise and a small part of the range.
    ///
    /// The printed index is taken at its word, to show what it does.
    fn is_genuine(&self, survey: &Survey, labels: &[Pattern], own: Pattern, slow: bool) -> bool {
        let Activation { velocity, acceleration } = &self.activation;
        let (sample, noise) = (&survey.sample, &survey.noise);
        let rows: Vec<usize> = (0..labels.len()).filter(|&row| labels[row] == own).collect();
        if (rows.len() as f64) <= LEAST_SHARE * labels.len() as f64 {
            return false;
        }
        let range = if slow && own == Pattern::Standstill { SLOW } else { OF_RANGE };
        let (rates, noise, scale) = match own {
            Pattern::Standstill => (sample.dq(), &noise.dq, &velocity.scale),
            Pattern::UniformVelocity => (sample.ddq(), &noise.ddq, &acceleration.scale),
            Pattern::VariableVelocity => return true,
        };
        self.switches.is_none()
            || (0..survey.joints.len()).all(|joint| {
                let squares: f64 = rows.iter().map(|&row| rates[(row, joint)].powi(2)).sum();
                let limit = (OF_NOISE * noise[joint]).max(range * scale[joint]);
                (squares / rows.len() as f64).sqrt() <= limit
            })
    }

    /// Pattern of each row of a motion, m.
    ///
    /// With the scaled index, each of I(q̈) and I(q̇) is a switch that is on beyond the middle
    /// between the clusters on its two sides; with the printed one, the nearest centre names the
    /// row. Rows of a pattern that is not genuine count as variable velocity, which assumes
    /// nothing.
    pub fn label(&self, motion: &Motion) -> Vec<Pattern> {
        let name = |point: &[f64; 2]| {
            if let Some([velocity, acceleration]) = self.switches {
                return Pattern::when(point[0] > velocity, point[1] > acceleration);
            }
            let distance =
                |own: &[f64; 2]| (own[0] - point[0]).powi(2) + (own[1] - point[1]).powi(2);
            let clusters = self.centres.iter().zip(&self.names);
            let near = clusters.min_by(|(a, _), (b, _)| distance(a).total_cmp(&distance(b)));
            near.map_or(Pattern::VariableVelocity, |(_, &name)| name)
        };
        let genuine = |name| {
            if self.present.contains(&name) { name } else { Pattern::VariableVelocity }
        };
        self.activation.over(motion).iter().map(|point| genuine(name(point))).collect()
    }
}

/// Where each index switches: between the clusters below and above one half, or at one half where
/// there are none on a side.
///
/// A row at rest that begins to accelerate lies far from the centre of the rows that move and
/// accelerate, and nearer to standstill, though its acceleration is plain.
fn switches(centres: &[[f64; 2]]) -> [f64; 2] {
    std::array::from_fn(|axis| {
        let all = centres.iter().map(|centre| centre[axis]);
        let (on, off): (Vec<f64>, Vec<f64>) = all.partition(|&x| x > HALF);
        let off = off.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let on = on.into_iter().fold(f64::INFINITY, f64::min);
        if off.is_finite() && on.is_finite() { 0.5 * (off + on) } else { HALF }
    })
}
