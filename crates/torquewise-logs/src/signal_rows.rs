//! Rows of signals: t, q, dq, ddq and tau in SI units, repaired if wanted.

use crate::source::LONGEST_STEP;
use crate::{LogError, Mapping, Result, RowPlace, Rows, Time};
use torquewise_motion::Repairs;

/// Clocks that begin later than this \[s\] count from a date; such times are counted from the first
/// row, for seconds since 1970 cannot tell microseconds in 64 bits.
const LONGEST_RUN: f64 = 1e6;

/// Rows that repeat a time stamp: so many may be chance; beyond, no more than one for so many
/// others.
const FEW_REPEATED: u64 = 10;
const MOST_REPEATED: u64 = 2;

/// What a reading came to; the first of each kind only of a single file, rows counted from 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadReport {
    /// Rows handed out.
    pub rows: u64,
    /// Rows dropped, and where the log was split.
    pub repairs: Repairs,
    /// The first row that was earlier than one before.
    pub first_back: Option<u64>,
    /// The first row of those left out since they are all zeros.
    pub first_zeros: Option<u64>,
    /// The first row of those left out since they repeat the one before, though the arm moved on.
    pub first_held: Option<u64>,
    /// Jumps of positions, at which the log was split.
    pub jumps: u64,
    /// The first of them: row, joint, and how far \[rad, m\].
    pub first_jump: Option<(u64, String, f64)>,
    /// The first value that was left out as absurd: row, column and value.
    pub first_absurd: Option<(u64, String, f64)>,
}

/// A stamp so many times as far ahead as the next row is astray, the first by so many of the longest steps.
const ASTRAY: f64 = 10.0;

pub(crate) struct SignalRows {
    rows: Box<dyn Rows>,
    pub(crate) mapping: Mapping,
    /// Whether faulty rows are dropped and counted rather than errors.
    repair: bool,
    /// Whether rows after the last range have to be read too.
    reads_on: bool,
    raw: Vec<f64>,
    number: u64,
    /// Time of the first row of the file, as its column has it and in seconds.
    first: Option<(f64, f64)>,
    last_t: Option<f64>,
    /// The row before, if rows are repaired: the next tells whether its stamp is astray.
    held: Option<Origin>,
    held_row: Vec<f64>,
    pub(crate) report: ReadReport,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Origin {
    pub(crate) part: usize,
    pub(crate) number: u64,
    /// Whether its device did not answer before.
    pub(crate) resumes: bool,
}

impl SignalRows {
    pub(crate) fn new(
        mut rows: Box<dyn Rows>,
        mapping: Mapping,
        repair: bool,
        reads_on: bool,
    ) -> Result<Self> {
        rows.choose(&mapping.chosen)?;
        let raw = vec![0.0; mapping.chosen.len()];
        let (number, first, last_t, report) = (0, None, None, ReadReport::default());
        let (held, held_row) = (None, vec![0.0; mapping.n_slots()]);
        Ok(Self {
            rows,
            mapping,
            repair,
            reads_on,
            raw,
            number,
            first,
            last_t,
            held,
            held_row,
            report,
        })
    }

    pub(crate) fn place(&self) -> RowPlace {
        self.rows.place()
    }

    pub(crate) fn none_left(&self) -> LogError {
        let (file, found) = (self.place().file, self.number);
        if found == 0 {
            return LogError::NoRows { file };
        }
        let dropped = self.report.repairs.not_finite;
        let problem = format!(": none of its {found} rows is left, {dropped} were not finite");
        let help = "check rows and seconds of the profile, and the columns";
        LogError::unusable(file.display(), &problem, help)
    }

    /// Puts the next row of the ranges into `row`, one value per slot; `None` at the end.
    ///
    /// All values are finite. Time stamps advance if the clock is repaired.
    pub(crate) fn next(&mut self, row: &mut [f64]) -> Result<Option<Origin>> {
        loop {
            let ready = match self.read(row)? {
                Some(_) if self.drops(row[0])? => continue,
                Some(own) if self.repair => {
                    row.swap_with_slice(&mut self.held_row);
                    match self.held.replace(own) {
                        None => continue,
                        before => before,
                    }
                }
                None => {
                    row.copy_from_slice(&self.held_row);
                    self.held.take()
                }
                own => own,
            };
            if ready.is_some() {
                self.last_t = Some(row[0]);
                self.report.rows += 1;
            }
            return Ok(ready);
        }
    }

    /// The next row of the ranges, whenever it was.
    fn read(&mut self, row: &mut [f64]) -> Result<Option<Origin>> {
        loop {
            let last = self.mapping.rows.last();
            let is_over = !self.reads_on && last.is_some_and(|[_, last]| self.number >= *last);
            if is_over || !self.rows.next(&mut self.raw)? {
                return Ok(None);
            }
            self.number += 1;
            let (t, since_first) = self.time();
            let part = self.mapping.part(self.number, since_first);
            // A row without a time is in no range of time, but its fault is to be told.
            let part = if since_first.is_nan() { part.or(Some(0)) } else { part };
            let Some(part) = part else { continue };
            for (value, slot) in row[1..].iter_mut().zip(&self.mapping.slots) {
                *value = slot.value(&self.raw);
            }
            row[0] = t;
            if let Some(slot) = row.iter().position(|value| !value.is_finite()) {
                self.accept_fault(slot, row[slot])?;
                self.report.repairs.not_finite += 1;
                continue;
            }
            return Ok(Some(Origin { part, number: self.number, resumes: false }));
        }
    }

    /// Whether a row of this time does not follow the last; it is counted, or the last in its place, where
    /// that alone is far ahead. A few rows may repeat a stamp in any log; where many do, the stamps are too
    /// coarse.
    fn drops(&mut self, t: f64) -> Result<bool> {
        let last = self.held.map(|_| self.held_row[0]).or(self.last_t);
        let Some(last) = last.filter(|last| t <= *last) else { return Ok(false) };
        if t < last {
            if !self.repair {
                return Ok(false);
            }
            let first = last - t > ASTRAY * LONGEST_STEP;
            let is_astray = |before: f64| t > before && last - before > ASTRAY * (t - before);
            if let Some(held) = self.held.take_if(|_| self.last_t.map_or(first, is_astray)) {
                let first = (held.number, "t".to_owned(), last);
                self.report.repairs.absurd += 1;
                self.report.first_absurd.get_or_insert(first);
                return Ok(false);
            }
            self.report.repairs.earlier_stamps += 1;
            self.report.first_back.get_or_insert(self.number);
            return Ok(true);
        }
        self.report.repairs.repeated_stamps += 1;
        let rows = self.report.rows + u64::from(self.held.is_some());
        let repeated = self.report.repairs.repeated_stamps;
        if repeated > FEW_REPEATED && repeated * MOST_REPEATED > rows {
            return Err(LogError::CoarseClock { place: self.place(), repeated, rows });
        }
        Ok(true)
    }

    /// Time of the row \[s\], and since the first row of the file.
    fn time(&mut self) -> (f64, f64) {
        let (raw, factor) = match self.mapping.time {
            Time::Column(factor) => (self.raw.first().copied().unwrap_or(f64::NAN), factor),
            Time::Rate(rate) => {
                let t = (self.number - 1) as f64 / rate;
                return (t, t);
            }
        };
        if self.first.is_none() && raw.is_finite() {
            self.first = Some((raw, raw * factor));
        }
        let Some((first, seconds)) = self.first else { return (f64::NAN, f64::NAN) };
        let since_first = (raw - first) * factor;
        let is_date = factor < 1.0 && seconds.abs() > LONGEST_RUN;
        (if is_date { since_first } else { raw * factor }, since_first)
    }

    /// An error that names the column at fault, unless such rows are dropped.
    fn accept_fault(&self, slot: usize, value: f64) -> Result<()> {
        if self.repair {
            return Ok(());
        }
        let places: Vec<usize> = match slot.checked_sub(1) {
            None => vec![0],
            Some(slot) => self.mapping.slots[slot].terms.iter().map(|(place, _)| *place).collect(),
        };
        let at_fault = places.iter().find(|place| !self.raw[**place].is_finite());
        let Some(chosen) = at_fault.or(places.first()).copied() else { return Ok(()) };
        let name = self.rows.names().get(self.mapping.chosen[chosen]).cloned();
        let (place, column) = (self.place(), name.unwrap_or_default());
        let value = at_fault.map_or(value, |place| self.raw[*place]);
        Err(LogError::NotFinite { place, column, value })
    }
}

impl ReadReport {
    pub(crate) fn add(&mut self, other: &Self) {
        self.rows += other.rows;
        self.repairs.add(&other.repairs);
        self.jumps += other.jumps;
    }
}
