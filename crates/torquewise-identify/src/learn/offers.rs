//! Offers of drive terms: shared shafts, springs, friction, by held-out rows (E13) (E21).

use super::kinds::is_told_from_gravity;
use super::{ChainLearner, LAST_ROWS};
use crate::drive_terms::Gravity;
use crate::unseen::regions;
use crate::{AT_REST, ChainSpec, DriveTerm, Linearisation, Unseen};
use rayon::prelude::*;
use torquewise_model::{Choice, FrictionLaw, FrictionTerm};
use torquewise_motion::Motion;
use torquewise_regression::ascending;
use torquewise_rigid::{Chain, JointKinds};
use torquewise_stepwise::friction::{FrictionLibrary, REVERSAL, WIDTHS, WORTH, reversal_label};
use torquewise_stepwise::held_out::{CvScore, listed};
use torquewise_stepwise::{IdentifyError, Progress, thinned};

/// A drive term of which held-out rows choose one variant.
pub(super) struct Offer {
    /// As the model file has it.
    what: String,
    /// Ways with their names, the simplest first.
    ways: Vec<(String, Vec<DriveTerm>)>,
    /// The variant that others are first compared with.
    usual: usize,
    /// A longer variant must lower the error by this part, and by so much of the torque.
    worth: f64,
    trifle: f64,
}

/// Arms seldom have a shaft that two joints share, or a spring.
const WORTH_OF_SHAFT: f64 = 0.15;
const WORTH_OF_SPRING: f64 = 0.1;
const WORTH_OF_FRICTION: f64 = 0.02;
/// What explains less of the torque than this is no spring and no shaft, however little is left.
const TRIFLE: f64 = 1e-3;
/// What explains less than this is no friction, but rounding of an exact log.
const ROUNDING: f64 = 1e-5;
/// Times that all offers are made, each beside what was chosen of the others.
const SWEEPS: usize = 2;

impl Offer {
    /// The simplest variant that is near the best, and its record; whether raw torque judged.
    fn chosen(&self, trials: &[CvScore], is_raw: bool) -> Option<(usize, Choice)> {
        let least = trials.iter().map(CvScore::error).fold(f64::INFINITY, f64::min);
        let near = |trial: &CvScore| (1.0 - self.worth) * trial.error() - self.trifle <= least;
        let place = trials.iter().position(near)?;
        let (what, chosen) = (self.what.clone(), trials[place].label.clone());
        let (part, count) = (100.0 * self.worth, trials[place].errors.len());
        let raw = if is_raw { "in raw torque, " } else { "" };
        let or = if self.trifle > 0.0 {
            format!(" or {} % of the torque", 100.0 * self.trifle)
        } else {
            String::new()
        };
        let rule = format!(
            "simplest within {part:.1} % of the least error{or}, {raw}{count} regions held out"
        );
        Some((place, Choice { what, chosen, rule, from: listed(trials) }))
    }

    /// The terms of all ways.
    pub(super) fn terms(&self) -> impl Iterator<Item = &DriveTerm> {
        self.ways.iter().flat_map(|(_, terms)| terms)
    }
}

/// A spring that is known.
pub(super) fn given_balance(motion: &Motion, joint: usize) -> Choice {
    let (what, chosen) = (balance_of(motion, joint), "spring".to_owned());
    Choice { what, chosen, rule: "as given".to_owned(), from: Vec::new() }
}

/// The choice of a spring, as the model file has it.
fn balance_of(motion: &Motion, joint: usize) -> String {
    format!("counterbalance of {}", motion.joints()[joint])
}

impl ChainLearner<'_> {
    /// Shafts that two neighbouring joints turn together, as in a coupled wrist.
    pub(super) fn shafts(&self, kinds: &JointKinds) -> Vec<Offer> {
        let n = self.motion.n_joints();
        let of = |joint: usize| {
            let shared = |sign: f64| {
                let mut shaft = vec![0.0; n];
                (shaft[joint - 1], shaft[joint]) = (1.0, sign);
                DriveTerm::shared_shaft(&shaft, self.laws.width_of(&shaft))
            };
            Offer {
                what: format!("shaft shared by joints {joint} and {}", joint + 1),
                ways: vec![
                    ("none".to_owned(), Vec::new()),
                    ("sum".to_owned(), shared(1.0)),
                    ("difference".to_owned(), shared(-1.0)),
                ],
                usual: 0,
                worth: WORTH_OF_SHAFT,
                trifle: TRIFLE,
            }
        };
        let turns = |joint: usize| kinds.of(joint).turns();
        (1..n).filter(|&joint| turns(joint - 1) && turns(joint)).map(of).collect()
    }

    /// Springs that balance a joint, but for those that are known.
    pub(super) fn springs(&self, known: &[usize], kinds: &JointKinds) -> Vec<Offer> {
        let n = self.motion.n_joints();
        let of = |joint: usize| Offer {
            what: balance_of(self.motion, joint),
            ways: vec![
                ("none".to_owned(), Vec::new()),
                ("spring".to_owned(), DriveTerm::counterbalance(n, joint, kinds.of(joint))),
            ],
            usual: 0,
            worth: WORTH_OF_SPRING,
            trifle: TRIFLE,
        };
        (0..n).filter(|joint| !known.contains(joint)).map(of).collect()
    }

    /// The friction of each joint; the offset of a slide whose direction was searched is left to
    /// gravity, which explains it as well.
    pub(super) fn friction(&self, searched: &JointKinds) -> Vec<Offer> {
        let own = |joint: usize, terms: Vec<FrictionTerm>| {
            terms
                .into_iter()
                .filter(move |term| term.joint() == Some(joint) && term.direction.is_both())
        };
        let of = |joint: usize| {
            let linear = own(joint, self.laws.linear());
            let linear: Vec<FrictionTerm> =
                linear.filter(|term| is_told_from_gravity(term, searched)).collect();
            let moving = linear.len() - 1;
            let dry = linear.iter().filter(|term| matches!(term.law, FrictionLaw::Coulomb { .. }));
            let loaded: Vec<FrictionTerm> = dry.cloned().map(FrictionTerm::under_load).collect();
            let bends: Vec<FrictionTerm> = own(joint, self.laws.stribeck()).collect();
            let dahl = self.laws.dahl(joint);
            let way = |parts: &[&[FrictionTerm]]| DriveTerm::friction(parts.concat()).collect();
            let mut ways = vec![
                ("none".to_owned(), Vec::new()),
                ("viscous".to_owned(), way(&[&linear[..moving]])),
                ("Coulomb".to_owned(), way(&[&linear])),
                ("Stribeck".to_owned(), way(&[&linear, &bends])),
            ];
            // Poses without velocities are no path.
            if self.laws.peak[joint] > 0.0 {
                ways.insert(3, ("Dahl under load".to_owned(), way(&[&linear, &loaded, &dahl])));
            }
            Offer {
                what: format!("friction of {}", self.motion.joints()[joint]),
                ways,
                usual: 2,
                worth: WORTH_OF_FRICTION / self.motion.n_joints() as f64,
                trifle: ROUNDING,
            }
        };
        (0..self.motion.n_joints()).map(of).collect()
    }

    /// Takes the friction that reverses as sharply as held-out regions ask for.
    pub(super) fn reverse(
        &mut self,
        spec: &ChainSpec,
        known: Vec<DriveTerm>,
        chain: &Chain,
        choices: &mut Vec<Choice>,
    ) -> Result<(), IdentifyError> {
        let laws = WIDTHS.map(|part| FrictionLibrary::with_width(self.laws.peak.clone(), part));
        let terms = |laws: &FrictionLibrary| {
            let alike = [laws.linear(), laws.stribeck()].concat().into_iter();
            DriveTerm::friction(alike.filter(|term| term.direction.is_both()).collect()).collect()
        };
        let ways = std::iter::zip(WIDTHS, &laws);
        let offer = Offer {
            what: REVERSAL.to_owned(),
            ways: ways.map(|(part, laws)| (reversal_label(part), terms(laws))).collect(),
            usual: 0,
            worth: WORTH,
            trifle: 0.0,
        };
        let bare = ChainSpec { drive: known, ..spec.clone() };
        if let Some((way, choice)) = self.best(&bare, chain, &[offer], true)?.into_iter().next() {
            self.laws = laws[way].clone();
            choices.extend(choice);
        }
        Ok(())
    }

    /// Chooses a variant of each offer, in addition to what a specification has.
    pub(super) fn choose(
        &self,
        spec: &mut ChainSpec,
        chain: &Chain,
        offers: &[Offer],
        choices: &mut Vec<Choice>,
    ) -> Result<(), IdentifyError> {
        spec.gravity = Some(Gravity::of(chain, &spec.drive));
        for (offer, (way, choice)) in offers.iter().zip(self.best(spec, chain, offers, false)?) {
            let terms = offer.ways[way].1.iter().filter(|term| !spec.drive.contains(term));
            let terms: Vec<DriveTerm> = terms.cloned().collect();
            spec.drive.extend(terms);
            choices.extend(choice);
        }
        Ok(())
    }

    /// The variant of each offer that is best in addition to a specification and the others, with
    /// its record; nothing where no rows can be held out.
    ///
    /// - `is_raw`: whether raw torque judges, which no filter blurs
    fn best(
        &self,
        spec: &ChainSpec,
        chain: &Chain,
        offers: &[Offer],
        is_raw: bool,
    ) -> Result<Vec<(usize, Option<Choice>)>, IdentifyError> {
        let (library, places) = placed(offers, &spec.drive);
        let motion = thinned(self.motion, LAST_ROWS);
        let (tau, none) = (motion.require_tau()?.to_owned(), vec![0.0; library.len()]);
        let rest = self.laws.width.iter().map(|width| AT_REST * width).collect();
        let at = Linearisation::of(chain, (library, &none), rest);
        let blocks = regions(&motion, self.motion.n_rows().div_ceil(motion.n_rows().max(1)));
        let removed = motion.removed_tau().filter(|_| is_raw);
        let predicted = removed.map(|removed| &tau + removed);
        let target = [(&tau, predicted.as_ref().unwrap_or(&tau))];
        let Some(unseen) = Unseen::new(&at, &motion, &target, &blocks, 0.0)? else {
            return Ok(Vec::new());
        };
        let bodies = at.linear.len() - at.drive.len();
        let known = bodies + spec.drive.len();
        let mut chosen: Vec<usize> = offers.iter().map(|offer| offer.usual).collect();
        let mut record = vec![None; offers.len()];
        for sweep in 0..SWEEPS {
            let before = chosen.clone();
            for (k, offer) in offers.iter().enumerate() {
                let made = sweep * offers.len() + k;
                Progress::Choices { made, most: SWEEPS * offers.len() }.tell(self.watch)?;
                let judged = |way: usize| -> Option<CvScore> {
                    let others =
                        (0..offers.len()).map(|other| if other == k { way } else { chosen[other] });
                    let own = others.zip(&places).flat_map(|(way, places)| &places[way]);
                    let own = own.map(|place| bodies + place);
                    let active = ascending((0..known).chain(own).collect());
                    let errors = unseen.errors(&active).pop()??.by_block();
                    let (label, complexity) = (offer.ways[way].0.clone(), active.len());
                    Some(CvScore { label, complexity, errors })
                };
                let trials: Option<Vec<CvScore>> =
                    (0..offer.ways.len()).into_par_iter().map(judged).collect();
                let Some((way, choice)) = trials.and_then(|trials| offer.chosen(&trials, is_raw))
                else {
                    continue;
                };
                (chosen[k], record[k]) = (way, Some(choice));
            }
            if chosen == before {
                break;
            }
        }
        Ok(chosen.into_iter().zip(record).collect())
    }
}

/// What is known and what is offered, each once; and where the terms of each way of each offer are.
fn placed(offers: &[Offer], known: &[DriveTerm]) -> (Vec<DriveTerm>, Vec<Vec<Vec<usize>>>) {
    let mut all = known.to_vec();
    let mut place = |term: &DriveTerm| {
        all.iter().position(|known| known == term).unwrap_or_else(|| {
            all.push(term.clone());
            all.len() - 1
        })
    };
    let of_offer = |offer: &Offer| {
        let ways = offer.ways.iter();
        ways.map(|(_, terms)| terms.iter().map(&mut place).collect()).collect()
    };
    let places = offers.iter().map(of_offer).collect();
    (all, places)
}
