//! A log file as rows of signals, read any number of times.

#[cfg(feature = "formats")]
use crate::arrays::ArrayRows;
#[cfg(feature = "formats")]
use crate::bag::{BagRows, Survey};
use crate::beside::{ClockColumn, SideBySide};
use crate::by_profile::by_profile;
use crate::csv_rows::CsvRows;
use crate::frame::FrameRows;
#[cfg(feature = "formats")]
use crate::parquet_rows::ParquetRows;
use crate::plain::plain;
use crate::profile::unit::{of_step, time_factor};
use crate::signal_rows::SignalRows;
use crate::{Format, Frame, LogError, LogInput, Mapping, Profile, Result, Rows, Time, joints};
use std::fs;
use std::io::{BufReader, Read};
use std::path::Path;
use std::sync::Arc;

const BUFFER_BYTES: usize = 1 << 16;
/// A clock of longer steps \[s\] hardly counts seconds.
pub(crate) const LONGEST_STEP: f64 = 0.5;

/// How logs are to be read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// What their columns mean; without it they are `t`, `q1`…`qn`, … in SI units.
    pub profile: Option<Profile>,
    /// Topic of the joint states of a bag; goes before that of the profile.
    pub topic: Option<String>,
    /// Whether rows that are not finite or whose time stamp goes back are dropped and counted, as
    /// with a profile they are in any case, rather than errors. Those that repeat a stamp always are.
    pub repair: bool,
}

#[derive(Clone, Debug)]
pub(crate) struct Source {
    pub(crate) file: LogInput,
    pub(crate) mapping: Mapping,
    origin: Origin,
    /// Further files with the same rows, and the column of the clock in all of them.
    beside: Vec<(String, LogInput)>,
    clock_column: Option<ClockColumn>,
    names: Vec<String>,
    repair: bool,
    /// Why its torques may be none.
    pub(crate) torque_doubt: Option<&'static str>,
    /// About how many rows there are, if that can be told.
    pub(crate) rows_hint: Option<u64>,
}

#[derive(Clone, Debug)]
enum Origin {
    File(Format),
    #[cfg(feature = "formats")]
    Bag(Survey),
    Frame(Arc<dyn Frame>),
}

impl Source {
    /// Reads the header; of a bag all messages, which say what it holds.
    pub(crate) fn open(file: &LogInput, options: &Options) -> Result<Self> {
        let profile = options.profile.as_ref();
        let topic = options.topic.as_deref().or(profile.and_then(|p| p.topic.as_deref()));
        let joints = profile.map_or(&[][..], |profile| &profile.joints);
        Self::new(file, Origin::of(file, topic, joints)?, options)
    }

    /// The same of a frame, which is called `label` in messages.
    pub(crate) fn of_frame(label: &Path, frame: Arc<dyn Frame>, options: &Options) -> Result<Self> {
        Self::new(&label.into(), Origin::Frame(frame), options)
    }

    fn new(file: &LogInput, origin: Origin, options: &Options) -> Result<Self> {
        let profile = options.profile.as_ref();
        let is_bag = !matches!(origin, Origin::File(_) | Origin::Frame(_));
        let is_text = matches!(origin, Origin::File(Format::Csv));
        let folder = file.parent().unwrap_or(Path::new(""));
        let beside = profile.map(|profile| &profile.beside).into_iter().flatten();
        let clock_column = profile
            .and_then(|profile| profile.t.as_ref())
            .map(|t| (t.column.clone(), time_factor(t.unit.as_deref()).unwrap_or(1.0)));
        let mut source = Self {
            file: file.clone(),
            mapping: Mapping::default(),
            origin,
            beside: beside.map(|(name, path)| (name.clone(), folder.join(path).into())).collect(),
            clock_column,
            names: Vec::new(),
            repair: profile.is_some() || options.repair,
            torque_doubt: profile.and_then(Profile::torque_doubt),
            rows_hint: None,
        };
        let rows = source.open_rows()?;
        source.mapping = match profile {
            Some(profile) => by_profile(profile, file, &*rows, is_bag)?,
            None if is_bag => by_profile(&Profile::default(), file, &*rows, true)?,
            None => plain(file, rows.names())?,
        };
        let named = source.mapping.joints.as_deref().or_else(|| rows.joints());
        let own = |names: &[String]| joints::checked(file, names.to_vec(), source.mapping.n_joints);
        source.mapping.joints = named.map(own).transpose()?;
        source.names = rows.names().to_vec();
        source.rows_hint = rows.count().or_else(|| is_text.then(|| lines_of(file)).flatten());
        // Columns that cannot be read are told now.
        source.rows_from(rows)?;
        Ok(source)
    }

    pub(crate) fn rows(&self) -> Result<SignalRows> {
        let rows = self.open_rows()?;
        if rows.names() != self.names {
            return Err(LogError::Changed { file: (&self.file).into() });
        }
        self.rows_from(rows)
    }

    /// What the clock may count, by its usual step, if that is no second.
    pub(crate) fn clock_doubt(&self, step: f64) -> Option<String> {
        let Time::Column(seconds) = self.mapping.time else { return None };
        let column = self.names.get(*self.mapping.chosen.first()?)?;
        (step.is_finite() && step > LONGEST_STEP).then(|| {
            let (unit, _) = of_step(step / seconds);
            format!(
                "the clock of {} has steps of {step:.1} s: if it counts {unit}, say so in a profile: \
                 t = {{ column = \"{column}\", unit = \"{unit}\" }}",
                self.file.display(),
            )
        })
    }

    fn rows_from(&self, rows: Box<dyn Rows>) -> Result<SignalRows> {
        let reads_on = !self.beside.is_empty();
        SignalRows::new(rows, self.mapping.clone(), self.repair, reads_on)
    }

    fn open_rows(&self) -> Result<Box<dyn Rows>> {
        let log = self.origin.rows(&self.file)?;
        if self.beside.is_empty() {
            return Ok(log);
        }
        let beside =
            |(name, file): &(String, LogInput)| Ok((name.clone(), file.into(), named_rows(file)?));
        let beside = self.beside.iter().map(beside).collect::<Result<_>>()?;
        Ok(Box::new(SideBySide::new(((&self.file).into(), log), beside, self.clock_column.clone())))
    }
}

/// About how many lines a text file has: as many as its first bytes let expect.
fn lines_of(file: &LogInput) -> Option<u64> {
    let mut first = Vec::new();
    let input = file.open().ok()?;
    let size = input.count();
    input.take(BUFFER_BYTES as u64).read_to_end(&mut first).ok()?;
    let lines = first.split(|&byte| byte == b'\n').skip(1).count() as u64;
    (lines > 0).then(|| size * lines / (first.len() as u64).max(1))
}

/// The rows of any file as they stand, of a bag all joints of its first message.
pub(crate) fn named_rows(file: &LogInput) -> Result<Box<dyn Rows>> {
    Origin::of(file, None, &[])?.rows(file)
}

impl Origin {
    /// What a file is; a bag is surveyed, for a topic and for joints in their order where these are
    /// given.
    #[cfg_attr(not(feature = "formats"), expect(unused_variables, reason = "there are no bags"))]
    fn of(file: &LogInput, topic: Option<&str>, joints: &[String]) -> Result<Self> {
        let format = Format::of(file)?;
        // A pipe or a device gives its bytes once; a log is read several times.
        if !file.is_held()
            && fs::metadata(&**file).is_ok_and(|found| !found.is_file() && !found.is_dir())
        {
            return Err(LogError::unusable(
                file.display(),
                " is a pipe or a device, not a file, and a log is read several times",
                "copy it to a file",
            ));
        }
        if file.is_held() && format == Format::Db3 {
            let help = "convert it to .mcap with `ros2 bag convert`";
            return Err(LogError::unusable(file.display(), " is read from a disk alone", help));
        }
        Ok(match format {
            #[cfg(feature = "formats")]
            Format::Db3 | Format::Mcap => Self::Bag(Survey::new(file, format, topic, joints)?),
            _ => Self::File(format),
        })
    }

    fn rows(&self, file: &LogInput) -> Result<Box<dyn Rows>> {
        Ok(match self {
            Self::Frame(frame) => Box::new(FrameRows::new(file, frame.clone())),
            #[cfg(feature = "formats")]
            Self::Bag(survey) => Box::new(BagRows::open(file, survey.clone())?),
            #[cfg(feature = "formats")]
            Self::File(Format::Parquet) => Box::new(ParquetRows::open(file)?),
            #[cfg(feature = "formats")]
            Self::File(format @ (Format::Npz | Format::Mat)) => {
                Box::new(ArrayRows::open(file, *format)?)
            }
            Self::File(_) => {
                let input = file.open().map_err(LogError::read(file))?;
                Box::new(CsvRows::new(file, BufReader::with_capacity(BUFFER_BYTES, input))?)
            }
        })
    }
}
