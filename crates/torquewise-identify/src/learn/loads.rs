//! From chain, rows to specification: shafts, counterbalances and friction, chosen beside a known
//! geometry.

use super::{ChainLearner, TRIAL_ROWS};
use crate::chain_spec::{ChainSpec, record, record_worth, trial};
use crate::drive_terms::DriveTerm;
use crate::plan::FrictionKind;
use torquewise_model::model::Choice;
use torquewise_motion::Motion;
use torquewise_rigid::Chain;
use torquewise_stepwise::error::IdentifyError;
use torquewise_stepwise::friction::{FrictionLibrary, REVERSAL, WIDTHS, WORTH, reversal_label};

/// A shared shaft must lower the error on held-out rows to this part: arms seldom have one.
const SHAFT_GAIN: f64 = 0.85;
/// Shared shafts at most.
const MOST_SHAFTS: usize = 2;
/// A counterbalance must lower the error to this part; it is felt by one joint alone.
const SPRING_GAIN: f64 = 0.9;

/// Places of joints that are said to be balanced, each once.
pub(super) fn balanced(motion: &Motion, names: &[String]) -> Result<Vec<usize>, IdentifyError> {
    let joints = motion.joints();
    let place = |name: &String| {
        joints.iter().position(|joint| joint == name).ok_or_else(|| IdentifyError::NoSuchJoint {
            name: name.clone(),
            joints: joints.join(", "),
        })
    };
    let mut places = names.iter().map(place).collect::<Result<Vec<usize>, _>>()?;
    places.sort_unstable();
    places.dedup();
    Ok(places)
}

impl ChainLearner<'_> {
    /// Looks for shafts that two neighbouring joints turn together, as in a coupled wrist.
    pub(super) fn shafts(
        &self,
        spec: &mut ChainSpec,
        chain: &Chain,
        choices: &mut Vec<Choice>,
    ) -> Result<bool, IdentifyError> {
        let n = self.motion.n_joints();
        let mut found = false;
        for _ in 0..MOST_SHAFTS {
            let mut ways = vec![("none".to_owned(), spec.clone())];
            for joint in 1..n {
                for sign in [1.0, -1.0] {
                    let mut shaft = vec![0.0; n];
                    (shaft[joint - 1], shaft[joint]) = (1.0, sign);
                    let mut with = spec.clone();
                    with.drive.extend(DriveTerm::shared_shaft(&shaft, self.laws.width_of(&shaft)));
                    let sign = if sign > 0.0 { '+' } else { '-' };
                    ways.push((format!("dq{joint} {sign} dq{}", joint + 1), with));
                }
            }
            // All are as complex: the best of them against none.
            let trials = self.trials(&ways, chain, 0)?;
            let best =
                (1..ways.len()).min_by(|&a, &b| trials[a].error().total_cmp(&trials[b].error()));
            let Some(best) = best else { break };
            let pair = [trials[0].clone(), trials[best].clone()];
            if trials[best].error() > SHAFT_GAIN * trials[0].error()
                || record("shared shaft", &pair, choices) == 0
            {
                break;
            }
            *spec = ways[best].1.clone();
            found = true;
        }
        Ok(found)
    }

    /// Looks for counterbalances, joint by joint, but for those that are known.
    pub(super) fn counterbalances(
        &self,
        spec: &mut ChainSpec,
        chain: &Chain,
        known: &[usize],
        choices: &mut Vec<Choice>,
    ) -> Result<(), IdentifyError> {
        let n = self.motion.n_joints();
        for &joint in known {
            spec.drive.extend(DriveTerm::counterbalance(n, joint));
            let (what, chosen) = (self.balance_of(joint), "spring".to_owned());
            choices.push(Choice { what, chosen, rule: "as given".to_owned(), from: Vec::new() });
        }
        for joint in (0..n).filter(|joint| !known.contains(joint)) {
            let mut with = spec.clone();
            with.drive.extend(DriveTerm::counterbalance(n, joint));
            let ways = [("none".to_owned(), spec.clone()), ("spring".to_owned(), with)];
            let what = self.balance_of(joint);
            let trials = self.trials(&ways, chain, 0)?;
            if trials[1].error() <= SPRING_GAIN * trials[0].error()
                && record(&what, &trials, choices) == 1
            {
                *spec = ways[1].1.clone();
            }
        }
        Ok(())
    }

    fn balance_of(&self, joint: usize) -> String {
        format!("counterbalance of {}", self.motion.joints()[joint])
    }

    /// Chooses how sharply friction reverses, with all laws of its kind.
    ///
    /// Slow rows are trusted as far as the reversal allows, so they tell of the Stribeck curve
    /// only where it is sharp.
    pub(super) fn reversal(
        &mut self,
        spec: &mut ChainSpec,
        chain: &Chain,
        kind: FrictionKind,
        choices: &mut Vec<Choice>,
    ) -> Result<(), IdentifyError> {
        let (mut ways, mut trials) = (Vec::new(), Vec::new());
        for part in WIDTHS {
            let laws = FrictionLibrary::with_width(self.laws.peak.clone(), part);
            let learner = ChainLearner { laws, ..*self };
            let mut sharp = spec.clone();
            for drive in &mut sharp.drive {
                drive.reverse_within(&learner.laws);
            }
            let mut all = sharp.clone();
            if kind != FrictionKind::Linear {
                all.drive.extend(DriveTerm::friction(learner.laws.stribeck()));
            }
            let rows = learner.rows(&all, TRIAL_ROWS)?;
            trials.push(trial(reversal_label(part), &all, &rows, chain, 0)?);
            ways.push((learner.laws, sharp));
        }
        let place = record(REVERSAL, &trials, choices);
        (self.laws, *spec) = ways.swap_remove(place);
        Ok(())
    }

    /// Chooses the law of friction, or adds the one asked for.
    pub(super) fn friction(
        &self,
        spec: &mut ChainSpec,
        chain: &Chain,
        kind: FrictionKind,
        choices: &mut Vec<Choice>,
    ) -> Result<(), IdentifyError> {
        let mut stribeck = spec.clone();
        stribeck.drive.extend(DriveTerm::friction(self.laws.stribeck()));
        match kind {
            FrictionKind::None | FrictionKind::Linear => {}
            FrictionKind::Stribeck => *spec = stribeck,
            FrictionKind::Auto => {
                let mut none = spec.clone();
                none.drive.retain(|drive| !matches!(drive, DriveTerm::Friction(_)));
                let mut alike = stribeck.clone();
                alike.drive.retain(|drive| !drive.is_one_way());
                let ways = [
                    ("none".to_owned(), none),
                    ("linear".to_owned(), spec.clone()),
                    ("stribeck".to_owned(), alike),
                    ("stribeck, forward and backward apart".to_owned(), stribeck),
                ];
                let trials = self.trials(&ways, chain, 0)?;
                let place = record_worth("friction", &trials, WORTH, choices);
                *spec = ways[place].1.clone();
            }
        }
        Ok(())
    }
}
