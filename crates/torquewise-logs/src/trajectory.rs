//! Filtered motion of one trajectory, and what was repaired on the way.

use crate::clock::{ClockLane, ClockRepair};
use crate::pieces::FIRST_ROWS;
use crate::raw_noise::NoiseLane;
use torquewise_motion::signals::{ConditionReport, Conditioner, SignalPlan};
use torquewise_motion::{Conditioning, Motion, MotionError, Raw, Repairs};

/// Parts of motion that are done, and noise of the same rows where it is asked for.
#[derive(Debug, Default)]
pub(crate) struct Done {
    pub(crate) motions: Vec<Motion>,
    pub(crate) noise: Vec<Motion>,
}

pub(crate) struct Trajectory<'a> {
    settings: &'a Conditioning,
    noise: Option<(&'a ConditionReport, u64)>,
    clock: ClockLane,
    /// Too few rows to plan by so far; none once there are filters.
    waiting: Raw,
    filters: Option<(Conditioner, Option<NoiseLane>)>,
}

impl<'a> Trajectory<'a> {
    /// - `noise`: what noise is to be filtered beside the rows, and its seed
    pub(crate) fn new(
        settings: &'a Conditioning,
        noise: Option<(&'a ConditionReport, u64)>,
        clock: ClockRepair,
    ) -> Self {
        let clock = ClockLane::new(clock);
        Self { settings, noise, clock, waiting: Raw::default(), filters: None }
    }

    pub(crate) fn push(&mut self, block: Raw) -> Result<Done, MotionError> {
        let Some(block) = self.clock.push(block) else { return Ok(Done::default()) };
        self.waiting.append(block);
        if self.filters.is_none() && self.waiting.t.len() < FIRST_ROWS {
            return Ok(Done::default());
        }
        self.filter()
    }

    /// Hands out the rest; a trajectory that is too short to be filtered is left out.
    pub(crate) fn finish(mut self) -> Result<(Done, Repairs), MotionError> {
        self.waiting.append(self.clock.finish().unwrap_or_default());
        let rows = self.waiting.t.len();
        let is_short = self.filters.is_none() && rows < FIRST_ROWS;
        let ended = self.filter().and_then(|done| self.rest(done));
        let mut repairs = self.clock.repairs;
        match ended {
            Ok(done) if !is_short || !done.motions.is_empty() => {
                let own = self.filters.map(|(conditioner, _)| conditioner.repairs);
                repairs.add(&own.unwrap_or_default());
                Ok((done, repairs))
            }
            Err(error) if !is_short || !error.is_too_short() => Err(error),
            _ => {
                repairs.too_short += rows as u64;
                Ok((Done::default(), repairs))
            }
        }
    }

    /// Filters the rows that wait; plans by them where they are the first.
    fn filter(&mut self) -> Result<Done, MotionError> {
        let raw = std::mem::take(&mut self.waiting);
        if raw.t.is_empty() {
            return Ok(Done::default());
        }
        let (conditioner, noise) = if let Some(filters) = &mut self.filters {
            filters
        } else {
            let plan = SignalPlan::new(&raw, self.settings)?;
            let noise = self.noise.map(|(report, seed)| NoiseLane::new(report, seed, plan.clone()));
            self.filters.insert((Conditioner::new(plan), noise))
        };
        let noise = noise.as_mut().map_or_else(|| Ok(Vec::new()), |lane| lane.push(&raw))?;
        Ok(Done { motions: conditioner.push(raw)?, noise })
    }

    /// What is done, and what the filters still hold.
    fn rest(&mut self, mut done: Done) -> Result<Done, MotionError> {
        if let Some((conditioner, noise)) = &mut self.filters {
            done.motions.extend(conditioner.finish()?);
            if let Some(lane) = noise {
                done.noise.extend(lane.conditioner.finish()?);
            }
        }
        Ok(done)
    }
}
