//! Diagnosis of a model: its residuals, and which terms carry the torque.

use crate::turning::Turning;
use crate::{Scores, score};
use faer::Mat;
use std::collections::VecDeque;
use torquewise_model::print::weighted_friction;
use torquewise_model::shaft_friction::ShaftFriction;
use torquewise_model::{FrictionTerm, Model, Term, Torque, Weighted};
use torquewise_motion::motion::Memory;
use torquewise_motion::{Motion, Path, Pattern, Recording, whole};
use torquewise_stepwise::{IdentifyError, Patterns};

/// An even sample of a log, measured and predicted.
#[derive(Clone, Debug)]
pub struct Trace {
    /// The sampled rows, with the measured torque.
    pub motion: Motion,
    /// τ̂ \[N·m\], rows × n.
    pub tau_hat: Mat<f64>,
    /// Between which the measured torque is expected \[N·m\], rows × n each; none if nobody asked.
    pub bounds: Option<[Mat<f64>; 2]>,
    /// Pattern of each row.
    pub patterns: Vec<Pattern>,
    /// Way of each joint since its last reversal \[rad\], rows × n, above zero forward; NaN where
    /// its friction has no travel, and after reversals before friction had turned.
    pub since_reversal: Mat<f64>,
}

/// Counts of residuals between equally spaced edges.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// Left edge of the first bin \[N·m\].
    pub start: f64,
    /// Width of a bin \[N·m\].
    pub width: f64,
    /// Rows in each bin; the first and last also hold what lies beyond.
    pub counts: Vec<usize>,
}

/// How much of a joint's torque a term carries.
#[derive(Clone, Debug, PartialEq)]
pub struct Importance {
    /// Name of the term: of the equation, or of its friction.
    pub name: String,
    /// RMS of its share of the torque \[N·m\].
    pub rms: f64,
}

/// Diagnosis of the residuals of a model.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// RMSE, NRMSE, R² of each joint.
    pub scores: Scores,
    /// An even sample of the log.
    pub trace: Trace,
    /// Residuals of each joint, n.
    pub histograms: Vec<Histogram>,
    /// Autocorrelation of the residual of each joint at lags 0, 1, 2, … rows, n.
    pub autocorrelation: Vec<Vec<f64>>,
    /// Terms of each joint, the most important first, n.
    pub importance: Vec<Vec<Importance>>,
}

/// Rows of a trace at most.
const TRACE_ROWS: usize = 4096;
const BINS: usize = 61;
/// Histograms reach this many RMSE to either side.
const REACH: f64 = 4.0;
const LAGS: usize = 50;

/// Friction counts as turned after so many travels, 99 % of one element.
const TURNED: f64 = 2.0;

/// Looks at the residuals of a model over a recording, in two passes and fixed memory.
///
/// # Errors
/// [`IdentifyError`]: the reader's message, missing torque, or a model of another arm.
pub fn diagnose(
    model: &Model,
    patterns: &Patterns,
    recording: &(impl Recording + ?Sized),
) -> Result<Diagnosis, IdentifyError> {
    let scores = score(model, recording)?;
    let mut look = Look::new(model, &scores);
    recording.read(&mut |trajectory, block| look.add(trajectory, block, patterns))?;
    look.finish(scores)
}

struct Look<'m> {
    model: &'m Model,
    torque: Torque,
    path: Path,
    /// Of each joint whose friction has a travel, at its place.
    turning: Vec<Option<Turning>>,
    trajectory: usize,
    stride: usize,
    rows: usize,
    /// Rows alone, τ̂, the ways since the last reversals, patterns.
    sampled: Vec<(Motion, Vec<f64>, Vec<f64>, Pattern)>,
    histograms: Vec<Histogram>,
    /// Per joint: the last residuals, newest first, and sums of products at each lag.
    recent: Vec<VecDeque<f64>>,
    products: Vec<Vec<f64>>,
}

impl<'m> Look<'m> {
    fn new(model: &'m Model, scores: &Scores) -> Self {
        let histogram = |rmse: f64| {
            let reach = if rmse > 0.0 { REACH * rmse } else { f64::MIN_POSITIVE };
            Histogram { start: -reach, width: 2.0 * reach / BINS as f64, counts: vec![0; BINS] }
        };
        let (n, torque) = (model.n_joints(), Torque::new(model));
        Self {
            model,
            path: torque.path(),
            turning: turning(model),
            trajectory: 0,
            torque,
            stride: scores.rows.div_ceil(TRACE_ROWS).max(1),
            rows: 0,
            sampled: Vec::new(),
            histograms: scores.joints.iter().map(|joint| histogram(joint.rmse)).collect(),
            recent: vec![VecDeque::with_capacity(LAGS + 1); n],
            products: vec![vec![0.0; LAGS + 1]; n],
        }
    }

    fn add(
        &mut self,
        trajectory: usize,
        block: &Motion,
        patterns: &Patterns,
    ) -> Result<(), torquewise_motion::ReadError> {
        let block = &*self.path.follow(trajectory, block);
        let tau_hat = self.torque.over(block)?;
        let tau = block.require_tau()?;
        let labels = patterns.label(block);
        if self.trajectory != trajectory {
            (self.trajectory, self.turning) = (trajectory, turning(self.model));
        }
        for row in 0..block.n_rows() {
            let since: Vec<f64> = (self.turning.iter_mut().enumerate())
                .map(|(joint, own)| {
                    own.as_mut().map_or(f64::NAN, |t| t.step(block.q()[(row, joint)]))
                })
                .collect();
            for joint in 0..block.n_joints() {
                self.add_residual(joint, tau[(row, joint)] - tau_hat[(row, joint)]);
            }
            if self.rows.is_multiple_of(self.stride) {
                let tau_hat = tau_hat.row(row).iter().copied().collect();
                self.sampled.push((block.select(&[row]), tau_hat, since, labels[row]));
            }
            self.rows += 1;
        }
        Ok(())
    }

    fn add_residual(&mut self, joint: usize, residual: f64) {
        let histogram = &mut self.histograms[joint];
        let place = ((residual - histogram.start) / histogram.width).clamp(0.0, BINS as f64 - 1.0);
        histogram.counts[whole(place)] += 1;

        let recent = &mut self.recent[joint];
        recent.push_front(residual);
        recent.truncate(LAGS + 1);
        for (product, before) in self.products[joint].iter_mut().zip(recent.iter()) {
            *product += residual * before;
        }
    }

    fn finish(self, scores: Scores) -> Result<Diagnosis, IdentifyError> {
        let (model, rows, n) = (self.model, self.sampled.len(), self.model.n_joints());
        let remembered = self.sampled.iter().map(|(motion, ..)| {
            motion.memory().into_iter().flat_map(|memory| memory.row(0)).collect::<Vec<f64>>()
        });
        let (travels, remembered) = (model.travels(), remembered.collect::<Vec<_>>());
        let states = Mat::from_fn(rows, travels.len() * n, |row, k| remembered[row][k]);
        let motions: Vec<Motion> = self.sampled.iter().map(|(motion, ..)| motion.clone()).collect();
        let motion = Motion::joined(&model.joints, &motions)?
            .with_memory(Some(Memory::new(travels, states)));
        let normalised = |products: Vec<f64>| -> Vec<f64> {
            let own = products[0].max(f64::MIN_POSITIVE);
            products.into_iter().map(|product| product / own).collect()
        };
        let importance = importance(model, &motion)?;
        let patterns = self.sampled.iter().map(|(.., pattern)| *pattern).collect();
        Ok(Diagnosis {
            scores,
            trace: Trace {
                tau_hat: Mat::from_fn(rows, n, |row, joint| self.sampled[row].1[joint]),
                bounds: None,
                motion,
                patterns,
                since_reversal: Mat::from_fn(rows, n, |row, joint| self.sampled[row].2[joint]),
            },
            histograms: self.histograms,
            autocorrelation: self.products.into_iter().map(normalised).collect(),
            importance,
        })
    }
}

/// Finds the reversals of each joint whose friction has a travel.
fn turning(model: &Model) -> Vec<Option<Turning>> {
    let mut all = vec![None; model.n_joints()];
    for shaft in ShaftFriction::all(model) {
        if let (Some(joint), Some(travel)) = (shaft.joint(), shaft.parameters().travel) {
            all[joint] = Some(Turning::new(TURNED * travel.value));
        }
    }
    all
}

/// RMS of each term of each joint, friction too, over the rows of a motion.
fn importance(model: &Model, motion: &Motion) -> Result<Vec<Vec<Importance>>, IdentifyError> {
    let states: Vec<[Vec<f64>; 3]> = (0..motion.n_rows()).map(|row| motion.state(row)).collect();
    let rms =
        |weight: f64, squares: f64| weight.abs() * (squares / states.len().max(1) as f64).sqrt();
    let of_equation = |(weight, term): (f64, Term)| {
        let squares = states.iter().map(|[q, dq, ddq]| term.value(q, dq, ddq).powi(2)).sum();
        Importance { name: term.name(), rms: rms(weight, squares) }
    };
    let laws = Torque::new(model).laws(motion)?;
    let of_friction = |w: Weighted<FrictionTerm>| {
        let place = model.friction.iter().position(|own| own.term == w.term);
        let squares = place.map_or(0.0, |place| laws.col(place).squared_norm_l2());
        Importance { name: w.term.name(), rms: rms(w.coefficient, squares) }
    };
    let all = (model.equations().into_iter().zip(weighted_friction(model)))
        .map(|(equation, friction)| {
            let friction = friction.into_iter().map(of_friction);
            let mut terms: Vec<_> = equation.into_iter().map(of_equation).chain(friction).collect();
            terms.sort_by(|a, b| b.rms.total_cmp(&a.rms));
            terms
        })
        .collect();
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::importance;
    use faer::Mat;
    use torquewise_model::friction::FrictionLaw;
    use torquewise_model::{Form, FrictionTerm, Model, Term, Trig, Weighted};
    use torquewise_motion::{Motion, Signals};

    #[test]
    fn friction_is_weighed_among_the_terms_of_its_joint() {
        let law = FrictionLaw::Coulomb { width: 0.0 };
        let dry = |joint, c| Weighted::new(FrictionTerm::of_joint(2, joint, law), c);
        let gravity = Term::one(2).times(Trig::Cos, 0, 1, 1);
        let model = Model {
            joints: vec!["a".into(), "b".into()],
            form: Form::Torque(vec![vec![Weighted::new(gravity.clone(), 3.0)], vec![]]),
            friction: vec![dry(0, -5.0), dry(1, 0.7)],
            ..Model::default()
        };
        // Forward, backward, and half the rows at rest.
        let speeds = [1.0, 0.0, -2.0, 0.0];
        let zeros = Mat::<f64>::zeros(4, 2);
        let motion = Motion::new(Signals {
            joints: model.joints.clone(),
            t: vec![0.0, 0.1, 0.2, 0.3],
            q: zeros.clone(),
            dq: Mat::from_fn(4, 2, |row, _| speeds[row]),
            ddq: zeros,
            tau: None,
        })
        .unwrap();

        let found = importance(&model, &motion).unwrap();

        let names = |joint: usize| -> Vec<String> {
            found[joint].iter().map(|found| found.name.clone()).collect()
        };
        assert_eq!(names(0), ["sign(dq1)".to_owned(), gravity.name()]);
        assert!((found[0][0].rms - 5.0 * 0.5_f64.sqrt()).abs() < 1e-12);
        assert_eq!(names(1), ["sign(dq2)"]);
        assert!((found[1][0].rms - 0.7 * 0.5_f64.sqrt()).abs() < 1e-12);
    }
}
