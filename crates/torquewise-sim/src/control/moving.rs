//! The arm between two ticks of its controller.

use crate::control::integrate::Integrator;
use crate::{Plant, Result, SimError, normal};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::collections::VecDeque;
use std::f64::consts::TAU;
use torquewise_motion::whole;

/// Speed \[rad/s\] that no joint reaches unless its controller drives it away.
const FASTEST: f64 = 300.0;

#[derive(Debug)]
pub(crate) struct Moving<'a> {
    plant: &'a Plant,
    t: f64,
    /// q, then dq, then how far bristles are bent.
    state: Vec<f64>,
    integrator: Integrator,
    /// Commands that have not come to an end, the oldest first.
    commands: VecDeque<Vec<f64>>,
    random: ChaCha8Rng,
}

impl<'a> Moving<'a> {
    /// A plant at q \[rad\] and dq \[rad/s\], n each.
    pub(crate) fn new(plant: &'a Plant, q: &[f64], dq: &[f64]) -> Result<Self> {
        plant.check()?;
        let (state, commands) = (plant.state(q, dq), VecDeque::new());
        let integrator = Integrator::new(state.len(), plant.tolerance);
        let random = ChaCha8Rng::seed_from_u64(plant.sensors.seed);
        Ok(Self { plant, t: 0.0, state, integrator, commands, random })
    }

    /// Positions \[rad\], n.
    pub(crate) fn q(&self) -> &[f64] {
        &self.state[..self.plant.arm.n_joints()]
    }

    /// Velocities \[rad/s\], n.
    pub(crate) fn dq(&self) -> &[f64] {
        let n = self.plant.arm.n_joints();
        &self.state[n..2 * n]
    }

    /// Positions as the encoders have them \[rad\], n.
    pub(crate) fn measured(&mut self) -> Vec<f64> {
        let sensors = self.plant.sensors;
        let mut measured = self.q().to_vec();
        for q in &mut measured {
            *q += noise(&mut self.random, sensors.noise);
            if sensors.step > 0.0 {
                *q = (*q / sensors.step).round() * sensors.step;
            }
        }
        measured
    }

    /// Torque as the drives report it \[N·m\], n.
    pub(crate) fn reported(&mut self, tau: &[f64]) -> Vec<f64> {
        let level = self.plant.sensors.torque_noise;
        tau.iter().map(|tau| tau + noise(&mut self.random, level)).collect()
    }

    /// Holds a command for a control period \[s\], delayed and limited by the drives, while
    /// `external` \[N·m\] acts on the joints as well; returns the drives' mean torque \[N·m\].
    pub(crate) fn hold(
        &mut self,
        command: &[f64],
        external: &[f64],
        period: f64,
    ) -> Result<Vec<f64>> {
        let delay = self.plant.drive.delay;
        let periods = (delay / period + 1e-9).floor();
        let late = (delay - periods * period).max(0.0);
        let limited = command.iter().zip(&self.plant.drive.limit);
        let command: Vec<f64> = limited.map(|(c, &limit)| c.clamp(-limit, limit)).collect();
        if self.commands.is_empty() {
            // Before the first command the drives hold what it will be.
            self.commands = VecDeque::from(vec![command.clone(); whole(periods) + 1]);
        }
        self.commands.push_back(command);
        let mut mean = vec![0.0; external.len()];
        for (seconds, place) in [(late, 0), (period - late, 1)] {
            let tau = self.commands.get(place).cloned().unwrap_or_default();
            for (mean, tau) in mean.iter_mut().zip(&tau) {
                *mean += tau * seconds / period;
            }
            let total: Vec<f64> = tau.iter().zip(external).map(|(tau, more)| tau + more).collect();
            let times = [self.t, seconds];
            self.plant.follow(&mut self.integrator, &mut self.state, times, &total)?;
            self.t += seconds;
            if self.dq().iter().any(|dq| dq.abs() > FASTEST) {
                return Err(SimError::Diverged { t: self.t });
            }
        }
        self.commands.pop_front();
        Ok(mean)
    }
}

fn noise(random: &mut ChaCha8Rng, level: f64) -> f64 {
    if level > 0.0 { level * normal(random) } else { 0.0 }
}

/// Values at even times → their slopes: differences through a first-order low-pass.
#[derive(Clone, Debug)]
pub(crate) struct Slopes {
    period: f64,
    share: f64,
    last: Option<Vec<f64>>,
    filtered: Vec<f64>,
}

impl Slopes {
    /// Of n values every `period` \[s\]; cut-off in Hz. The first slopes are as given, n.
    pub(crate) fn new(period: f64, cutoff: f64, first: &[f64]) -> Self {
        let share = 1.0 - (-TAU * cutoff * period).exp();
        Self { period, share, last: None, filtered: first.to_vec() }
    }

    pub(crate) fn next(&mut self, values: &[f64]) -> &[f64] {
        if let Some(last) = &self.last {
            for ((slope, now), before) in self.filtered.iter_mut().zip(values).zip(last) {
                *slope += self.share * ((now - before) / self.period - *slope);
            }
        }
        self.last = Some(values.to_vec());
        &self.filtered
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Arm;
    use crate::control::plant::Sensors;

    /// The speed of a free joint of 2 kg·m² a period after each of some commands.
    fn speeds(delay: f64, limit: f64, commands: &[f64]) -> Vec<f64> {
        let table = "name = 'wheel'\ngravity = [0.0, 0.0, 0.0]\n[[joints]]\nname = 'axle'\n\
            a = 0.0\nalpha = 0.0\nd = 0.0\nmass = 1.0\ncom = [0.0, 0.0, 0.0]\n\
            inertia = [1.0, 1.0, 2.0, 0.0, 0.0, 0.0]";
        let mut plant = Plant::ideal(Arm::from_dh_toml(table).unwrap());
        plant.drive.delay = delay;
        plant.drive.limit = vec![limit];
        let mut moving = Moving::new(&plant, &[0.0], &[0.0]).unwrap();
        let speed_after = |&command: &f64| {
            moving.hold(&[command], &[0.0], 0.01).unwrap();
            moving.dq()[0]
        };
        commands.iter().map(speed_after).collect()
    }

    #[test]
    fn a_command_acts_after_its_delay_and_a_drive_gives_no_more_than_its_limit() {
        let (free, step) = (f64::INFINITY, [0.0, 100.0, 100.0, 0.0]);
        // The first command is held before it comes; 100 N·m on 2 kg·m² for 10 ms are 0.5 rad/s.
        for (delay, limit, commands, expected) in [
            (0.0, free, step, [0.0, 0.5, 1.0, 1.0]),
            (0.004, free, step, [0.0, 0.3, 0.8, 1.0]),
            (0.01, free, step, [0.0, 0.0, 0.5, 1.0]),
            (0.013, free, step, [0.0, 0.0, 0.35, 0.85]),
            (0.0, 20.0, [0.0, 100.0, -100.0, 0.0], [0.0, 0.1, 0.0, 0.0]),
        ] {
            for (found, expected) in speeds(delay, limit, &commands).iter().zip(expected) {
                assert!((found - expected).abs() < 1e-9, "{delay} s: {found}, not {expected}");
            }
        }
    }

    #[test]
    fn an_encoder_counts_whole_steps_and_noise_has_its_level() {
        let mut plant = Plant::ideal(Arm::builtin("planar-2").unwrap());
        plant.sensors = Sensors { step: 0.01, ..Sensors::IDEAL };
        let measured = Moving::new(&plant, &[0.123, -1.0], &[0.0; 2]).unwrap().measured();
        plant.sensors = Sensors { noise: 0.02, torque_noise: 0.5, ..Sensors::IDEAL };
        let mut moving = Moving::new(&plant, &[0.0; 2], &[0.0; 2]).unwrap();
        let rms = |draw: &mut dyn FnMut() -> Vec<f64>| {
            let squares: f64 = (0..5000).flat_map(|_| draw()).map(|x| x * x).sum();
            (squares / 10_000.0).sqrt()
        };

        let of_position = rms(&mut || moving.measured());
        let of_torque = rms(&mut || moving.reported(&[0.0; 2]));

        assert!((measured[0] - 0.12).abs() < 1e-12 && (measured[1] + 1.0).abs() < 1e-12);
        // The root of 10 000 squares is within 3 % but once in ten thousand seeds.
        assert!((of_position / 0.02 - 1.0).abs() < 0.03 && (of_torque / 0.5 - 1.0).abs() < 0.03);
    }

    #[test]
    fn slopes_of_a_ramp_settle_to_its_slope_and_are_differences_without_a_cut_off() {
        let mut filtered = Slopes::new(1e-3, 100.0, &[0.0]);
        let mut plain = Slopes::new(0.5, f64::INFINITY, &[7.0]);

        let last = (0..50).map(|k| filtered.next(&[0.002 * f64::from(k)])[0]).last().unwrap();

        // exp(−2π·100·0.049) = 4e-14
        assert!((last - 2.0).abs() < 1e-9);
        assert_eq!(plain.next(&[1.0])[0].to_bits(), 7.0_f64.to_bits());
        assert_eq!(plain.next(&[2.0])[0].to_bits(), 2.0_f64.to_bits());
    }
}
