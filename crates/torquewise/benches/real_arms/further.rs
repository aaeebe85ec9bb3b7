//! From further arms, whose kinematics nobody gives: logs to train and to test on to errors by
//! joint.

use crate::{fitted, whole};
use faer::Mat;
use std::error::Error;
use std::path::{Path, PathBuf};
use torquewise::logs::{ConditionedLogs, LogError, Logs};
use torquewise::signals::Conditioning;
use torquewise::signals::spline::interpolate;
use torquewise::signals::zero_phase::low_pass_columns;
use torquewise::{FitOptions, Library, Model, Torque, Verdict};

/// Arms as their logs begin, in the order of the page.
const NAMES: [&str; 5] = ["xmate7p", "lwr_paths", "baxter", "krang", "youbot"];
/// Rows per second that all test logs are compared at \[Hz\].
const RATE: f64 = 100.0;
/// Rows left out at each end, where a zero-phase filter rings.
const EDGE: usize = 50;

/// What is put down of one arm.
pub(crate) struct Further {
    pub(crate) name: &'static str,
    pub(crate) cutoff: f64,
    pub(crate) seconds: f64,
    pub(crate) verdict: Option<Verdict>,
    /// One for each test log.
    pub(crate) tests: Vec<Track>,
}

/// Measured torque and what the model misses of it \[N·m\], evenly sampled at [`RATE`], m×n each.
pub(crate) struct Track {
    tau: Mat<f64>,
    missed: Mat<f64>,
}

/// Fits and judges each arm whose logs are in the folder that `TORQUEWISE_ARMS` names.
pub(crate) fn run() -> Result<Option<Vec<Further>>, Box<dyn Error + Send + Sync>> {
    let Some(folder) = std::env::var_os("TORQUEWISE_ARMS").map(PathBuf::from) else {
        return Ok(None);
    };
    NAMES.into_iter().map(|name| one(name, &folder)).collect::<Result<_, _>>().map(Some)
}

fn one(name: &'static str, folder: &Path) -> Result<Further, Box<dyn Error + Send + Sync>> {
    let [train, test] = [files(folder, name, "train")?, files(folder, name, "test")?];
    let options = FitOptions { library: Some(Library::Chain), ..FitOptions::default() };
    let (fit, logs) = fitted(&train, &options)?;
    let track = |log: &PathBuf| Track::new(&fit.model, log, logs.settings());
    Ok(Further {
        name,
        cutoff: logs.report().cutoff.unwrap_or_default(),
        seconds: fit.seconds,
        verdict: fit.verdict(),
        tests: test.iter().map(track).collect::<Result<_, _>>()?,
    })
}

/// Logs of one arm that are trained or tested on.
fn files(
    folder: &Path,
    name: &str,
    part: &str,
) -> Result<Vec<PathBuf>, Box<dyn Error + Send + Sync>> {
    let begin = format!("{name}_{part}");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)?
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<_, _>>()?;
    files.retain(|file| {
        file.file_name().is_some_and(|own| own.to_string_lossy().starts_with(&begin))
    });
    files.sort();
    if files.is_empty() {
        return Err(format!("{}: no log {begin}*.csv: write it there", folder.display()).into());
    }
    Ok(files)
}

impl Track {
    fn new(
        model: &Model,
        log: &PathBuf,
        settings: &Conditioning,
    ) -> Result<Self, Box<dyn Error + Send + Sync>> {
        let logs = Logs::open(std::slice::from_ref(log))?;
        let (mut t, mut tau) = (Vec::new(), vec![Vec::new(); logs.joints().len()]);
        logs.read_raw(&mut |_, block| -> Result<(), LogError> {
            t.extend_from_slice(&block.t);
            for (joint, tau) in tau.iter_mut().enumerate() {
                tau.extend(block.tau.iter().flat_map(|tau| tau.col(joint).iter().copied()));
            }
            Ok(())
        })?;
        let motion = whole(&ConditionedLogs::new(logs, settings, false)?)?;
        let predicted = Torque::new(model).over(&motion)?;
        let (begin, end) = (motion.t()[0], motion.t()[motion.n_rows() - 1]);
        let at = (0..).map(|row: u32| begin + f64::from(row) / RATE);
        let at: Vec<f64> = at.take_while(|t| *t <= end).collect();
        let rows = at.len();
        let mut track =
            Self { tau: Mat::zeros(rows, tau.len()), missed: Mat::zeros(rows, tau.len()) };
        for (joint, tau) in tau.iter().enumerate() {
            let measured = interpolate(&t, tau, &at)?;
            let expected = interpolate(motion.t(), predicted.col_as_slice(joint), &at)?;
            for row in 0..rows {
                track.tau[(row, joint)] = measured[row];
                track.missed[(row, joint)] = measured[row] - expected[row];
            }
        }
        Ok(track)
    }

    /// Torque and error through the same zero-phase low-pass filter, whatever that of the model.
    ///
    /// - `cutoff` \[Hz\] and `order` of the filter
    pub(crate) fn below(
        &self,
        (cutoff, order): (f64, usize),
    ) -> Result<Self, Box<dyn Error + Send + Sync>> {
        let low = |x: &Mat<f64>| -> Result<Mat<f64>, Box<dyn Error + Send + Sync>> {
            let low = low_pass_columns(x.as_ref(), RATE, cutoff, order)?;
            let rows = low.nrows().checked_sub(2 * EDGE).ok_or("a test log of less than 1 s")?;
            Ok(low.subrows(EDGE, rows).to_owned())
        };
        Ok(Self { tau: low(&self.tau)?, missed: low(&self.missed)? })
    }

    /// First and second half.
    fn halves(&self) -> Vec<Self> {
        let half = self.tau.nrows() / 2;
        let part = |x: &Mat<f64>, begin| x.subrows(begin, half).to_owned();
        [0, half].map(|k| Self { tau: part(&self.tau, k), missed: part(&self.missed, k) }).into()
    }

    pub(crate) fn n_rows(&self) -> usize {
        self.tau.nrows()
    }

    /// Mean square of the error of each joint \[(N·m)²\], n.
    pub(crate) fn mean_squares(&self) -> Vec<f64> {
        let of = |joint: faer::ColRef<'_, f64>| joint.squared_norm_l2() / joint.nrows() as f64;
        self.missed.col_iter().map(of).collect()
    }

    /// ‖τ − τ̂‖ over ‖τ‖, all joints together.
    pub(crate) fn part_of_norm(&self) -> f64 {
        self.missed.norm_l2() / self.tau.norm_l2()
    }
}

/// Of each part of the tests, the logs or the halves of a single one, RMSE of each joint over the
/// standard deviation of its torque in all of them.
pub(crate) fn nrmse(tests: &[Track]) -> Vec<Vec<f64>> {
    let n = tests.first().map_or(0, |test| test.tau.ncols());
    let deviation = |joint: usize| {
        let tau = || tests.iter().flat_map(|test| test.tau.col(joint).iter());
        let count = tau().count() as f64;
        let mean = tau().sum::<f64>() / count;
        (tau().map(|tau| (tau - mean).powi(2)).sum::<f64>() / count).sqrt()
    };
    let deviations: Vec<f64> = (0..n).map(deviation).collect();
    let of = |part: &Track| -> Vec<f64> {
        let squares = part.mean_squares().into_iter();
        squares.zip(&deviations).map(|(square, deviation)| square.sqrt() / deviation).collect()
    };
    match tests {
        [single] => single.halves().iter().map(of).collect(),
        several => several.iter().map(of).collect(),
    }
}
