//! Guides → labels: where they hide as little as they can of what is drawn.

use crate::error::ReportError;
use crate::figure::DOTS;
use crate::figure::axes::half_bar;
use crate::figure::marks::{self, Dot};
use crate::figure::plot::Plot;
use crate::figure::strokes::{Place, strokes};
use crate::figure::words::{SMALL, drawing, style, width};
use crate::html::chart::Position;
use crate::html::thin::{Sorted, sorted};
use crate::html::{Chart, Mark, Series};
use crate::palette::FADED_INK;
use plotters::style::text_anchor::{HPos, VPos};

/// Space between a guide and its label.
const GAP: i32 = 5 * DOTS;
/// From one label of a guide to the next.
const LINE: i32 = 15 * DOTS;
/// From the middle of a point to the edge of its ring or dot.
const REACH: f64 = 11.0;

/// From left and top to right and bottom, in dots.
type Frame = [f64; 4];

/// A label and the side it starts from: its width is an estimate.
struct Placed {
    corners: [Dot; 2],
    side: HPos,
}

impl Placed {
    fn new(left: i32, top: i32, long: i32, side: HPos) -> Self {
        Self { corners: [(left, top), (left + long, top + LINE)], side }
    }

    fn frame(&self) -> Frame {
        let [(left, top), (right, bottom)] = self.corners;
        [left, top, right, bottom].map(f64::from)
    }
}

/// What labels should not stand on.
#[derive(Default)]
struct Drawn {
    /// Around points, bars, error bars and other labels.
    frames: Vec<Frame>,
    /// Points of lines; nothing for gaps.
    lines: Vec<Vec<Option<Place>>>,
}

impl Plot<'_, '_> {
    /// The labels of all guides: those of upright ones below each other at the top, those of level
    /// ones where they hide least.
    pub(crate) fn guide_labels(&self, chart: &Chart) -> Result<(), ReportError> {
        let (x, y) = (self.x(), self.y());
        let named = || chart.guides.iter().filter(|guide| !guide.label.is_empty());
        let mut drawn = self.drawn(chart);
        let mut top = GAP / 2;
        for guide in named() {
            let Position::X(at) = guide.at else { continue };
            if x.contains(at) {
                let placed = self.beside(at, top, width(&guide.label, SMALL));
                drawn.frames.push(placed.frame());
                self.guide_label(&guide.label, &placed)?;
                top += LINE;
            }
        }
        for guide in named() {
            let Position::Y(at) = guide.at else { continue };
            if y.contains(at) {
                let placed = self.along(at, width(&guide.label, SMALL), &drawn);
                drawn.frames.push(placed.frame());
                self.guide_label(&guide.label, &placed)?;
            }
        }
        Ok(())
    }

    fn guide_label(&self, label: &str, placed: &Placed) -> Result<(), ReportError> {
        let [(left, top), (right, _)] = placed.corners;
        marks::veil(&self.area, placed.corners)?;
        let at = match placed.side {
            HPos::Left => left,
            HPos::Center => i32::midpoint(left, right),
            HPos::Right => right,
        };
        let words = style(SMALL, FADED_INK, placed.side, VPos::Center);
        self.area.draw_text(label, &words, (at, top + LINE / 2)).map_err(drawing)
    }

    /// A label beside an upright line.
    fn beside(&self, at: f64, top: i32, long: i32) -> Placed {
        let (right, _) = self.end();
        let (at, _) = self.dot(at, self.y().value(1.0));
        if at + GAP + long <= right {
            Placed::new(at + GAP, top, long, HPos::Left)
        } else {
            Placed::new(at - GAP - long, top, long, HPos::Right)
        }
    }

    /// A label above or below a level line, at either end or in the middle: at the first of these
    /// places where it hides nothing, else at the first where it hides least.
    fn along(&self, at: f64, long: i32, drawn: &Drawn) -> Placed {
        let (right, bottom) = self.end();
        let (_, at) = self.dot(self.x().value(0.0), at);
        // At the line, or as far from it as a ring on it reaches.
        let above_and_below = |away| [at - LINE - away, at + away];
        let places = [GAP / 2, 2 * GAP + GAP / 2].into_iter().flat_map(above_and_below);
        let places = places.flat_map(|top| {
            [
                Placed::new(right - GAP - long, top, long, HPos::Right),
                Placed::new(GAP, top, long, HPos::Left),
                Placed::new((right - long) / 2, top, long, HPos::Center),
            ]
        });
        let fits = |placed: &Placed| placed.corners[0].1 >= 0 && placed.corners[1].1 <= bottom;
        let best = places.filter(fits).min_by_key(|placed| drawn.hidden_by(placed.frame()));
        best.unwrap_or_else(|| Placed::new(right - GAP - long, 0, long, HPos::Right))
    }

    /// The lower right corner.
    fn end(&self) -> Dot {
        self.dot(self.x().value(1.0), self.y().value(0.0))
    }

    /// What a chart draws, if a label has to keep clear of it.
    fn drawn(&self, chart: &Chart) -> Drawn {
        let mut drawn = Drawn::default();
        let is_level = |position| matches!(position, Position::Y(_));
        if chart.guides.iter().any(|guide| is_level(guide.at) && !guide.label.is_empty()) {
            for series in &chart.series {
                self.add(series, &mut drawn);
            }
        }
        drawn
    }

    fn add(&self, series: &Series, drawn: &mut Drawn) {
        let (x, y) = (self.x(), self.y());
        let (right, bottom) = self.end();
        let across = |at: f64| Some(x.share(at)? * f64::from(right));
        let down = |at: f64| Some((1.0 - y.share(at)?) * f64::from(bottom));
        let Sorted { points, spread } = sorted(series, x.is_log());
        let is_bars = series.mark == Mark::Bars;
        let half = half_bar(&points);
        for (row, &[at, height]) in points.iter().enumerate() {
            let (Some(left), Some(top)) = (across(at), down(height)) else { continue };
            if is_bars {
                let sides = [x.clamped(at - half), x.clamped(at + half)].map(across);
                let ([Some(from), Some(to)], Some(zero)) = (sides, down(y.clamped(0.0))) else {
                    continue;
                };
                drawn.frames.push([from, top.min(zero), to, top.max(zero)]);
            }
            let ends = spread.get(row).copied().unwrap_or([height; 2]);
            let [low, high] = ends.map(|end| down(end).unwrap_or(top));
            let (above, below) = (high.min(top - REACH), low.max(top + REACH));
            drawn.frames.push([left - REACH, above, left + REACH, below]);
        }
        if series.mark.is_line() && !is_bars {
            let place = |&[at, height]: &[f64; 2]| Some([across(at)?, down(height)?]);
            drawn.lines.push(points.iter().map(place).collect());
        }
    }
}

impl Drawn {
    /// How much a label hides: 0 for nothing, 1 for a line between two points, 2 for a point.
    fn hidden_by(&self, [left, top, right, bottom]: Frame) -> u8 {
        let meets = |other: &Frame| {
            other[0] <= right && other[2] >= left && other[1] <= bottom && other[3] >= top
        };
        if self.frames.iter().any(meets) {
            return 2;
        }
        // The label is the unit square.
        let share = |[x, y]: Place| [(x - left) / (right - left), (y - top) / (bottom - top)];
        let crosses = |line: &Vec<Option<Place>>| {
            !strokes(line.iter().map(|place| place.map(share))).is_empty()
        };
        u8::from(self.lines.iter().any(crosses))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_worse_to_hide_than_a_line() {
        let line = vec![Some([0.0, 0.0]), Some([100.0, 100.0]), None, Some([5.0, 90.0])];
        let drawn = Drawn { frames: vec![[60.0, 0.0, 70.0, 10.0]], lines: vec![line] };

        assert_eq!(drawn.hidden_by([65.0, 5.0, 90.0, 20.0]), 2);
        assert_eq!(drawn.hidden_by([40.0, 45.0, 60.0, 55.0]), 1);
        assert_eq!(drawn.hidden_by([0.0, 85.0, 10.0, 95.0]), 1);
        assert_eq!(drawn.hidden_by([10.0, 60.0, 40.0, 75.0]), 0);
        assert_eq!(drawn.hidden_by([0.0, 45.0, 10.0, 55.0]), 0);
    }
}
