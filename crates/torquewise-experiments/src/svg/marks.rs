//! Series → SVG marks: lines, dots, rings, bars and error bars.

use crate::svg::colour::hex;
use crate::svg::scale::Scale;
use std::fmt::Write;
use torquewise_report::html::{Mark, Series};

/// Points of a line at most.
const MOST_POINTS: usize = 4_000;
/// Half the width of the cap of an error bar.
const CAP: f64 = 4.0;

/// The plane that series are drawn in.
pub(crate) struct Plane<'a> {
    pub(crate) x: &'a Scale,
    pub(crate) y: &'a Scale,
    pub(crate) height: f64,
}

impl Plane<'_> {
    fn point(&self, [x, y]: [f64; 2]) -> Option<(f64, f64)> {
        Some((self.x.place(x)?, self.height - self.y.place(y)?))
    }

    /// One series.
    pub(crate) fn draw(&self, series: &Series) -> String {
        let colour = hex(series.colour);
        let stroke = |width: f64, dash: &str| {
            format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"{dash}")
        };
        let mut text = self.error_bars(series, colour);
        text += &match series.mark {
            Mark::Line => self.line(series, &stroke(1.6, "")),
            Mark::BroadLine => self.line(series, &stroke(5.0, "")),
            Mark::DashedLine => self.line(series, &stroke(1.6, " stroke-dasharray=\"6 4\"")),
            Mark::DottedLine => {
                self.line(series, &stroke(1.8, ""))
                    + &self.dots(series, 3.5, &format!("fill=\"{colour}\""))
            }
            Mark::Cloud => {
                self.dots(series, 1.8, &format!("fill=\"{colour}\" fill-opacity=\"0.55\""))
            }
            Mark::Rings => {
                let style = format!("fill=\"#ffffff\" stroke=\"{colour}\" stroke-width=\"2.2\"");
                self.dots(series, 4.5, &style)
            }
            Mark::Bars => self.bars(series, colour),
        };
        text
    }

    fn line(&self, series: &Series, style: &str) -> String {
        let stride = series.points.len().div_ceil(MOST_POINTS).max(1);
        let mut text = String::new();
        let mut stroke: Vec<(f64, f64)> = Vec::new();
        let mut finish = |stroke: &mut Vec<(f64, f64)>| {
            if stroke.len() > 1 {
                let points: Vec<String> =
                    stroke.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
                // Writing to a String cannot fail.
                let _ = writeln!(text, "<polyline {style} points=\"{}\"/>", points.join(" "));
            }
            stroke.clear();
        };
        for &point in series.points.iter().step_by(stride) {
            match self.point(point) {
                Some(place) => stroke.push(place),
                None => finish(&mut stroke),
            }
        }
        finish(&mut stroke);
        text
    }

    fn dots(&self, series: &Series, radius: f64, style: &str) -> String {
        let dot = |&point: &[f64; 2]| {
            let (x, y) = self.point(point)?;
            Some(format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" {style}/>\n"))
        };
        series.points.iter().filter_map(dot).collect()
    }

    fn bars(&self, series: &Series, colour: &str) -> String {
        let step = series.points.windows(2).map(|pair| (pair[1][0] - pair[0][0]).abs());
        let step = step.fold(f64::INFINITY, f64::min);
        let step = if step.is_finite() { step } else { 1.0 };
        let floor = self.y.place(0.0).unwrap_or(0.0);
        let bar = |&[x, y]: &[f64; 2]| {
            let (left, right) = (self.x.place(x - 0.4 * step)?, self.x.place(x + 0.4 * step)?);
            let (bottom, top) = (self.height - floor, self.height - self.y.place(y)?);
            let (high, tall) = (top.min(bottom), (top - bottom).abs());
            Some(format!(
                "<rect x=\"{left:.1}\" y=\"{high:.1}\" width=\"{:.1}\" height=\"{tall:.1}\" \
                 fill=\"{colour}\" fill-opacity=\"0.8\"/>\n",
                right - left
            ))
        };
        series.points.iter().filter_map(bar).collect()
    }

    fn error_bars(&self, series: &Series, colour: &str) -> String {
        let bar = |(&[x, _], &[low, high]): (&[f64; 2], &[f64; 2])| {
            let (x, low) = self.point([x, low])?;
            let high = self.height - self.y.place(high)?;
            let (left, right) = (x - CAP, x + CAP);
            Some(format!(
                "<path d=\"M{x:.1} {low:.1}V{high:.1}M{left:.1} {low:.1}H{right:.1}\
                 M{left:.1} {high:.1}H{right:.1}\" stroke=\"{colour}\" fill=\"none\"/>\n"
            ))
        };
        series.points.iter().zip(&series.spread).filter_map(bar).collect()
    }
}
