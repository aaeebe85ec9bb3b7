//! Filtered motion of one trajectory, and what was repaired on the way.

use crate::clock::{ClockLane, ClockRepair};
use crate::pieces::FIRST_ROWS;
use crate::raw_noise::{NoiseLane, RawNoise};
use torquewise_motion::signals::{Conditioner, Conditioning, Raw, SignalPlan};
use torquewise_motion::{Motion, MotionError, Repairs};

/// Parts of motion that are done, and noise of the same rows where it is asked for.
#[derive(Debug, Default)]
pub(crate) struct Done {
    pub(crate) motions: Vec<Motion>,
    pub(crate) noise: Vec<Motion>,
}

pub(crate) struct Trajectory<'a> {
    settings: &'a Conditioning,
    noise: Option<&'a RawNoise>,
    clock: ClockLane,
    stretch: Stretch,
}

enum Stretch {
    /// Too few rows to plan by so far.
    Waiting(Raw),
    Running(Box<Conditioner>, Option<Box<NoiseLane>>),
}

impl<'a> Trajectory<'a> {
    /// - `noise`: whether noise is to be filtered beside the rows
    pub(crate) fn new(
        settings: &'a Conditioning,
        noise: Option<&'a RawNoise>,
        clock: ClockRepair,
    ) -> Self {
        let (clock, stretch) = (ClockLane::new(clock), Stretch::Waiting(Raw::default()));
        Self { settings, noise, clock, stretch }
    }

    pub(crate) fn push(&mut self, block: Raw) -> Result<Done, MotionError> {
        self.clock.push(block).map_or_else(|| Ok(Done::default()), |block| self.filter(block))
    }

    /// Hands out the rest; a trajectory that is too short to be filtered is left out.
    pub(crate) fn finish(mut self) -> Result<(Done, Repairs), MotionError> {
        let last = self.clock.finish();
        let mut done = last.map_or_else(|| Ok(Done::default()), |rest| self.filter(rest))?;
        let mut repairs = self.clock.repairs.clone();
        let waiting = match &mut self.stretch {
            Stretch::Waiting(waiting) => std::mem::take(waiting),
            Stretch::Running(..) => Raw::default(),
        };
        let rows = waiting.t.len();
        let begun = if rows > 0 { self.begin(waiting) } else { Ok(Done::default()) };
        match begun.and_then(|begun| Ok((begun, self.rest()?))) {
            Ok((begun, (rest, own)))
                if rows == 0 || begun.motions.len() + rest.motions.len() > 0 =>
            {
                for part in [begun, rest] {
                    done.motions.extend(part.motions);
                    done.noise.extend(part.noise);
                }
                repairs.add(&own);
            }
            Err(error) if rows == 0 || !error.is_too_short() => return Err(error),
            _ => repairs.too_short += rows as u64,
        }
        Ok((done, repairs))
    }

    fn filter(&mut self, block: Raw) -> Result<Done, MotionError> {
        match &mut self.stretch {
            Stretch::Waiting(waiting) => {
                waiting.append(block);
                if waiting.t.len() < FIRST_ROWS {
                    return Ok(Done::default());
                }
                let raw = std::mem::take(waiting);
                self.begin(raw)
            }
            Stretch::Running(conditioner, noise) => pushed(conditioner, noise, block),
        }
    }

    /// Plans by the first rows, and filters them.
    fn begin(&mut self, raw: Raw) -> Result<Done, MotionError> {
        let plan = SignalPlan::new(&raw, self.settings)?;
        let mut noise = self.noise.map(|noise| Box::new(noise.lane(plan.clone())));
        let mut conditioner = Box::new(Conditioner::new(plan));
        let done = pushed(&mut conditioner, &mut noise, raw)?;
        self.stretch = Stretch::Running(conditioner, noise);
        Ok(done)
    }

    /// What the filters still hold, and what they repaired in all.
    fn rest(self) -> Result<(Done, Repairs), MotionError> {
        let Stretch::Running(mut conditioner, noise) = self.stretch else {
            return Ok(Default::default());
        };
        let motions = conditioner.finish()?;
        let noise = noise.map_or_else(|| Ok(Vec::new()), |mut lane| lane.conditioner.finish())?;
        Ok((Done { motions, noise }, conditioner.repairs))
    }
}

fn pushed(
    conditioner: &mut Conditioner,
    noise: &mut Option<Box<NoiseLane>>,
    raw: Raw,
) -> Result<Done, MotionError> {
    let noise = noise.as_mut().map_or_else(|| Ok(Vec::new()), |lane| lane.push(&raw))?;
    Ok(Done { motions: conditioner.push(raw)?, noise })
}
