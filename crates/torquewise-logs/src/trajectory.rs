//! Filtered motion of one trajectory, and what was repaired on the way.

use crate::clock::{ClockLane, ClockRepair, joined};
use crate::pieces::FIRST_ROWS;
use crate::raw_noise::{NoiseLane, RawNoise};
use torquewise_motion::signals::{Conditioner, Conditioning, Plan, Raw, condition};
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
    Waiting(Vec<Raw>),
    Running(Box<Conditioner>, Option<Box<NoiseLane>>),
}

impl<'a> Trajectory<'a> {
    /// - `noise`: whether noise is to be filtered beside the rows
    pub(crate) fn new(
        settings: &'a Conditioning,
        noise: Option<&'a RawNoise>,
        clock: ClockRepair,
    ) -> Self {
        let (clock, stretch) = (ClockLane::new(clock), Stretch::Waiting(Vec::new()));
        Self { settings, noise, clock, stretch }
    }

    pub(crate) fn push(&mut self, block: Raw) -> Result<Done, MotionError> {
        match self.clock.push(block) {
            Some(block) => self.filter(block),
            None => Ok(Done::default()),
        }
    }

    /// Hands out the rest; a trajectory that is too short to be filtered is left out.
    pub(crate) fn finish(mut self) -> Result<(Done, Repairs), MotionError> {
        let mut done = match self.clock.finish() {
            Some(rest) => self.filter(rest)?,
            None => Done::default(),
        };
        let mut repairs = self.clock.repairs.clone();
        match self.stretch {
            Stretch::Running(mut conditioner, noise) => {
                done.motions.extend(conditioner.finish()?);
                if let Some(noise) = noise {
                    done.noise.extend(noise.finish()?);
                }
                repairs.add(&conditioner.repairs);
            }
            Stretch::Waiting(blocks) => {
                let raw = joined(blocks);
                match condition(&raw, self.settings) {
                    Ok(conditioned) => {
                        done.motions.push(conditioned.motion);
                        repairs.add(&conditioned.repairs);
                    }
                    Err(error) if error.is_too_short() => {
                        repairs.too_short += raw.t.len() as u64;
                        return Ok((done, repairs));
                    }
                    Err(error) => return Err(error),
                }
                if let Some(noise) = self.noise {
                    let mut lane = noise.lane(Plan::new(&raw, self.settings)?);
                    done.noise.extend(lane.push(&raw)?);
                    done.noise.extend(lane.finish()?);
                }
            }
        }
        Ok((done, repairs))
    }

    fn filter(&mut self, block: Raw) -> Result<Done, MotionError> {
        match &mut self.stretch {
            Stretch::Waiting(blocks) => {
                blocks.push(block);
                let rows: usize = blocks.iter().map(|block| block.t.len()).sum();
                if rows < FIRST_ROWS {
                    return Ok(Done::default());
                }
                let raw = joined(std::mem::take(blocks));
                let plan = Plan::new(&raw, self.settings)?;
                let mut noise = self.noise.map(|noise| Box::new(noise.lane(plan.clone())));
                let mut conditioner = Box::new(Conditioner::new(plan));
                let done = pushed(&mut conditioner, noise.as_deref_mut(), &raw)?;
                self.stretch = Stretch::Running(conditioner, noise);
                Ok(done)
            }
            Stretch::Running(conditioner, noise) => {
                pushed(conditioner, noise.as_deref_mut(), &block)
            }
        }
    }
}

fn pushed(
    conditioner: &mut Conditioner,
    noise: Option<&mut NoiseLane>,
    raw: &Raw,
) -> Result<Done, MotionError> {
    let motions = conditioner.push(raw)?;
    let noise = noise.map_or_else(|| Ok(Vec::new()), |lane| lane.push(raw))?;
    Ok(Done { motions, noise })
}
