//! Torque of each energy term at given states (E4).

use faer::Mat;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::OnceLock;
use torquewise_model::{EnergyTerm, Factor, FrictionTerm, Place, Trig};
use torquewise_motion::Motion;
use torquewise_motion::motion::Memory;

/// States of an arm, each sine and cosine of them once.
pub(crate) struct States {
    /// `[joint]` → cos q, sin q, cos 2q, sin 2q of each state, from the first term that asks for them.
    waves: OnceLock<Vec<[Vec<f64>; 4]>>,
    /// q, q̇ and q̈, states×n each.
    q: Mat<f64>,
    dq: Mat<f64>,
    pub(crate) ddq: Mat<f64>,
    /// What friction remembers at each state.
    memory: Option<Memory>,
    /// G(q) of each state \[N·m\], states×n, where it is known.
    pub(crate) gravity: Option<Mat<f64>>,
}

impl States {
    pub(crate) fn of(motion: &Motion) -> Self {
        let rows: Vec<[usize; 3]> = (0..motion.n_rows()).map(|row| [row; 3]).collect();
        Self::new(motion, &rows)
    }

    /// At most `count` states: half of them rows of a motion, half with q, q̇ and q̈ of three
    /// different rows.
    pub(crate) fn mixed(motion: &Motion, count: usize, seed: u64) -> Self {
        let m = motion.n_rows();
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let count = count.min(2 * m);
        let rows: Vec<[usize; 3]> = (0..count)
            .map(|state| {
                let own = (state / 2) * m / count.div_ceil(2);
                let mut row = || if state % 2 == 0 { own } else { random.random_range(0..m) };
                [row(), row(), row()]
            })
            .collect();
        Self::new(motion, &rows)
    }

    /// - `rows`: which rows of the motion q, q̇ and q̈ of each state are taken from
    fn new(motion: &Motion, rows: &[[usize; 3]]) -> Self {
        let n = motion.n_joints();
        let taken = |x: faer::MatRef<'_, f64>, signal: usize| {
            Mat::from_fn(rows.len(), n, |state, joint| x[(rows[state][signal], joint)])
        };
        Self {
            waves: OnceLock::new(),
            q: taken(motion.q(), 0),
            dq: taken(motion.dq(), 1),
            ddq: taken(motion.ddq(), 2),
            memory: motion.memory().map(|memory| {
                memory.select(&rows.iter().map(|row| row[1]).collect::<Vec<usize>>())
            }),
            gravity: None,
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.dq.nrows()
    }

    pub(crate) fn n_joints(&self) -> usize {
        self.dq.ncols()
    }

    pub(crate) fn peaks(&self) -> [f64; 2] {
        [self.dq.norm_max(), self.ddq.norm_max()]
    }

    fn waves(&self) -> &[[Vec<f64>; 4]] {
        self.waves.get_or_init(|| {
            let of_joint = |joint: usize| {
                let q = self.q.col_as_slice(joint);
                let all = |wave: fn(f64) -> f64| q.iter().map(|q| wave(*q)).collect::<Vec<f64>>();
                [all(f64::cos), all(f64::sin), all(|q| (2.0 * q).cos()), all(|q| (2.0 * q).sin())]
            };
            (0..self.n_joints()).map(of_joint).collect()
        })
    }

    /// What a law of friction comes to at each state, per unit of its coefficient.
    pub(crate) fn friction(&self, law: &FrictionTerm) -> Vec<f64> {
        let remembers = self.memory.as_ref().zip(law.element());
        let speeds = along(&law.shaft, &self.dq).into_iter().enumerate();
        let values = speeds.map(|(state, speed)| {
            let known =
                remembers.and_then(|(memory, (joint, travel))| memory.state(state, joint, travel));
            let value = known.unwrap_or_else(|| law.at_speed(speed));
            match &self.gravity {
                Some(gravity) if law.load => {
                    value * law.pressed(&gravity.row(state).iter().copied().collect::<Vec<f64>>())
                }
                _ => value,
            }
        });
        values.collect()
    }

    /// Torque of a term on all states, states×n: d/dt ∂T/∂q̇ − ∂T/∂q + ∂V/∂q (E4).
    pub(crate) fn loads(&self, term: &EnergyTerm, coefficient: f64) -> Mat<f64> {
        let (value, slopes) = self.value(term, coefficient);
        let mut loads = Mat::zeros(self.len(), self.n_joints());
        let Place::Inertia(i, j) = term.place else {
            for (joint, slope) in slopes {
                loads.col_as_slice_mut(joint).copy_from_slice(&slope);
            }
            return loads;
        };
        let share = if i == j { 0.5 } else { 1.0 };
        let mut change = vec![0.0; self.len()];
        for (joint, slope) in &slopes {
            let rates = slope.iter().zip(self.dq.col_as_slice(*joint));
            change.iter_mut().zip(rates).for_each(|(change, (a, b))| *change += a * b);
            let [one, other] = [i, j].map(|joint| self.dq.col_as_slice(joint));
            let states = slope.iter().zip(one.iter().zip(other));
            for (load, (s, (a, b))) in loads.col_as_slice_mut(*joint).iter_mut().zip(states) {
                *load -= share * s * a * b;
            }
        }
        for (own, other) in [(i, j), (j, i)] {
            let rates = self.dq.col_as_slice(other).iter().zip(self.ddq.col_as_slice(other));
            let states = change.iter().zip(&value).zip(rates);
            for (load, ((c, v), (dq, ddq))) in loads.col_as_slice_mut(own).iter_mut().zip(states) {
                *load += share * (c * dq + v * ddq);
            }
        }
        loads
    }

    /// Values of the function of a term, and its slopes along the joints it depends on, times a
    /// coefficient.
    fn value(&self, term: &EnergyTerm, coefficient: f64) -> (Vec<f64>, Vec<(usize, Vec<f64>)>) {
        let factors = &term.function.factors;
        let parts: Vec<[Vec<f64>; 2]> = factors.iter().map(|factor| self.part(factor)).collect();
        let product = |slope_of: Option<usize>| {
            let mut out = vec![coefficient; self.len()];
            for (place, part) in parts.iter().enumerate() {
                let by = &part[usize::from(slope_of == Some(place))];
                out.iter_mut().zip(by).for_each(|(out, x)| *out *= x);
            }
            out
        };
        let mut slopes: Vec<(usize, Vec<f64>)> = Vec::new();
        for (place, factor) in factors.iter().enumerate() {
            let rest = product(Some(place));
            for (joint, &k) in factor.multiples.iter().enumerate().filter(|(_, k)| **k != 0) {
                let slope: Vec<f64> = rest.iter().map(|s| s * f64::from(k)).collect();
                match slopes.iter_mut().find(|(known, _)| *known == joint) {
                    Some((_, known)) => known.iter_mut().zip(slope).for_each(|(a, b)| *a += b),
                    None => slopes.push((joint, slope)),
                }
            }
        }
        (product(None), slopes)
    }

    /// Values of a factor and of its slope.
    fn part(&self, factor: &Factor) -> [Vec<f64>; 2] {
        match factor.function {
            Trig::Position => self.powers(factor),
            Trig::Sin => self.turn(&factor.multiples).into(),
            Trig::Cos => {
                let (sin, cos) = self.turn(&factor.multiples);
                [cos, sin.into_iter().map(|s| -s).collect()]
            }
        }
    }

    /// Powers of a sum of positions, and their slopes.
    fn powers(&self, factor: &Factor) -> [Vec<f64>; 2] {
        let power = i32::from(factor.power);
        let values = (0..self.len()).map(|state| {
            let of_joints = factor.multiples.iter().zip(self.q.row(state).iter());
            let sum: f64 = of_joints.map(|(k, q)| f64::from(*k) * q).sum();
            (sum.powi(power), f64::from(power) * sum.powi(power - 1))
        });
        values.unzip::<f64, f64, Vec<f64>, Vec<f64>>().into()
    }

    /// Sine and cosine of a sum of joint angles.
    fn turn(&self, multiples: &[i8]) -> (Vec<f64>, Vec<f64>) {
        let mut sum: Option<(Vec<f64>, Vec<f64>)> = None;
        for (&k, waves) in multiples.iter().zip(self.waves()).filter(|(k, _)| **k != 0) {
            let (mut s, c) = match k.unsigned_abs() {
                1 => (waves[1].clone(), waves[0].clone()),
                2 => (waves[3].clone(), waves[2].clone()),
                // Springs alone hold higher harmonics.
                k => {
                    let angles = waves[1].iter().zip(&waves[0]);
                    angles.map(|(s, c)| (f64::from(k) * s.atan2(*c)).sin_cos()).unzip()
                }
            };
            if k < 0 {
                s = s.into_iter().map(|s| -s).collect();
            }
            sum = Some(match sum {
                None => (s, c),
                Some((sin, cos)) => sin
                    .iter()
                    .zip(&cos)
                    .zip(s.iter().zip(&c))
                    .map(|((sin, cos), (s, c))| (sin * c + cos * s, cos * c - sin * s))
                    .unzip(),
            });
        }
        sum.unwrap_or_else(|| (vec![0.0; self.len()], vec![1.0; self.len()]))
    }
}

/// Σ shaft\[j\]·xⱼ of each state.
///
/// - `x`: states×n
pub(crate) fn along(shaft: &[f64], x: &Mat<f64>) -> Vec<f64> {
    let mut sum = vec![0.0; x.nrows()];
    for (joint, turns) in shaft.iter().enumerate().filter(|(_, turns)| **turns != 0.0) {
        sum.iter_mut().zip(x.col_as_slice(joint)).for_each(|(sum, x)| *sum += turns * x);
    }
    sum
}
