//! Charts of residuals: against time, velocity, position; spread and autocorrelation.

use crate::fit_report::clock;
use crate::fit_report::torques::LINK;
use crate::{Chart, Clock, Colour, Findings, Guide, Item, Mark, Section, Series, significant};
use faer::MatRef;
use std::f64::consts::PI;
use torquewise_model::units::unit;
use torquewise_stepwise::evenly;

const MOST_POINTS: usize = 1_500;
/// Half width of the interval that holds 95 % of a standard normal distribution.
const TWO_SIGMA: f64 = 1.96;

pub(crate) fn section(findings: &Findings<'_>) -> Section {
    let words = "Measured minus predicted torque. White noise looks like a band without shape, \
                 follows the normal curve and is not correlated in time. A step at zero velocity \
                 is friction; waves over position are missing terms.";
    let clock = Clock::new(findings.diagnosis.trace.motion.t());
    let mut items = vec![Item::Text(words.into())];
    for joint in 0..findings.n_joints() {
        let residual = Residual { findings, joint };
        let score = &findings.diagnosis.scores.joints[joint];
        let kind = findings.found.model.kinds().of(joint);
        let charts = vec![
            residual.over(findings.diagnosis.trace.motion.dq(), &unit(kind, "velocity [rad/s]")),
            residual.over(findings.diagnosis.trace.motion.q(), &unit(kind, "position [rad]")),
            residual.histogram(),
            residual.autocorrelation(),
        ];
        items.push(Item::Details {
            summary: format!(
                "{}, RMSE {} {}",
                score.name,
                significant(score.rmse, 3),
                kind.effort_unit
            ),
            items: vec![Item::Charts(vec![residual.over_time(&clock)]), Item::Charts(charts)],
        });
    }
    Section { heading: "Residuals".into(), items }
}

struct Residual<'a> {
    findings: &'a Findings<'a>,
    joint: usize,
}

impl Residual<'_> {
    fn label(&self) -> String {
        unit(self.findings.found.model.kinds().of(self.joint), "residual [N·m]")
    }

    /// Residual at a row of the trace \[N·m\].
    fn at(&self, row: usize) -> f64 {
        let trace = &self.findings.diagnosis.trace;
        let measured = trace.motion.tau().map_or(f64::NAN, |tau| tau[(row, self.joint)]);
        measured - trace.tau_hat[(row, self.joint)]
    }

    fn over_time(&self, clock: &Clock) -> Chart {
        let series = vec![Series::line("residual", clock.curve(|row| self.at(row)))];
        let chart = Chart::over("Over time", [clock::LABEL, &self.label()], series);
        let is_stepwise = self.findings.is_stepwise();
        let bands = is_stepwise.then(|| clock.bands(&self.findings.diagnosis.trace.patterns));
        Chart { bands: bands.unwrap_or_default(), linked: Some(LINK.into()), ..chart }
    }

    fn over(&self, signal: MatRef<'_, f64>, label: &str) -> Chart {
        let rows = evenly(signal.nrows(), MOST_POINTS).into_iter();
        let points = rows.map(|row| [signal[(row, self.joint)], self.at(row)]).collect();
        let name = label.split(' ').next().unwrap_or(label);
        let series = vec![Series::new("residual", Mark::Cloud, Colour::Series(0), points)];
        let chart = Chart::over(format!("Over {name}"), [label, &self.label()], series);
        Chart { guides: vec![Guide::at_y(0.0, "")], ..chart }
    }

    fn histogram(&self) -> Chart {
        let histogram = &self.findings.diagnosis.histograms[self.joint];
        let score = &self.findings.diagnosis.scores.joints[self.joint];
        let bins = histogram.counts.iter().enumerate();
        let points: Vec<[f64; 2]> = bins
            .map(|(bin, &rows)| {
                [histogram.start + (bin as f64 + 0.5) * histogram.width, rows as f64]
            })
            .collect();
        let rows: usize = histogram.counts.iter().sum();
        let peak = rows as f64 * histogram.width / (score.rmse * (2.0 * PI).sqrt());
        let normal = |x: f64| peak * (-0.5 * (x / score.rmse).powi(2)).exp();
        let curve = points.iter().map(|[x, _]| [*x, normal(*x)]).collect();
        let series = vec![
            Series::new("residual", Mark::Bars, Colour::Measured, points),
            Series::new("normal curve of the same RMSE", Mark::Line, Colour::Series(1), curve),
        ];
        Chart::over("Distribution", [&self.label(), "rows"], series)
    }

    fn autocorrelation(&self) -> Chart {
        let values = &self.findings.diagnosis.autocorrelation[self.joint];
        let lags = values.iter().enumerate().skip(1);
        let points: Vec<[f64; 2]> = lags.map(|(lag, &value)| [lag as f64, value]).collect();
        let band = TWO_SIGMA / (self.findings.diagnosis.scores.rows.max(1) as f64).sqrt();
        let outside = points.iter().filter(|[_, value]| value.abs() > band).count();
        let caption = format!(
            "{outside} of {} lags leave the band ±{} that holds 95 % of white noise.",
            points.len(),
            significant(band, 2)
        );
        let series = vec![Series::new("autocorrelation", Mark::Bars, Colour::Series(0), points)];
        let names = ["lag [rows]", "correlation with the residual before"];
        let guides = vec![Guide::at_y(band, "95 %"), Guide::at_y(-band, "")];
        Chart { caption, guides, ..Chart::over("Autocorrelation", names, series) }
    }
}
