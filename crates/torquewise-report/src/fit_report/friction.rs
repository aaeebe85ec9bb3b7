//! Friction: its parameters, and its curves with what was measured.

use crate::{Chart, Colour, Findings, Item, Mark, Section, Series, Table};
use faer::Mat;
use torquewise_identify::diagnose::Trace;
use torquewise_model::print::friction_tables;
use torquewise_model::shaft_friction::ShaftFriction;
use torquewise_model::{FrictionTerm, Torque};

/// A joint slower than this part of the fastest row is at rest, where friction may be anything.
const REST: f64 = 0.003;
/// Points of a curve in each direction, and groups of rows beside it at most.
const POINTS: u32 = 100;
const GROUPS: usize = 20;
const LEAST_ROWS: usize = 8;
/// Half the length of a loop, in travels of a reversal.
const REACH: f64 = 3.0;

pub(crate) fn section(findings: &Findings<'_>) -> Option<Section> {
    let model = &findings.found.model;
    let shafts = ShaftFriction::all(model);
    if shafts.is_empty() {
        return None;
    }
    let trace = &findings.diagnosis.trace;
    let laws = Torque::new(model).laws(&trace.motion).ok()?;
    let words = "F_c: Coulomb friction, away from rest. F_s: static friction, as motion ends; \
                 below F_c where friction rises steeply from rest. v_s: Stribeck speed, at which \
                 1/e of the difference is left. F_v: viscous friction. Stiffness: torque over \
                 position in the middle of a loop; travel: the way after a reversal at which \
                 friction has turned to 90 %. Numbers are without load, ± standard error; a dash \
                 stands for what this log does not tell from zero.";
    let mut items = vec![Item::Text(words.into())];
    items.extend(friction_tables(model).into_iter().map(|rows| Item::Table(Table::of_text(rows))));
    let seen = shafts.iter().map(|&shaft| Seen { shaft, trace, findings, laws: &laws });
    let seen: Vec<Seen<'_>> = seen.collect();
    items.push(Item::Charts(seen.iter().map(Seen::over_speed).collect()));
    let loops: Vec<Chart> = seen.iter().filter_map(Seen::around_reversals).collect();
    if !loops.is_empty() {
        items.push(Item::Charts(loops));
    }
    Some(Section { heading: "Friction".into(), items })
}

struct Seen<'a> {
    shaft: ShaftFriction<'a>,
    findings: &'a Findings<'a>,
    trace: &'a Trace,
    /// What each law comes to at the rows of the trace.
    laws: &'a Mat<f64>,
}

impl Seen<'_> {
    /// What is left of the measured torque \[N·m\] for some laws of the shaft, at a row of the
    /// trace: of the first joint that it turns.
    fn measured(&self, row: usize, counts: impl Fn(&FrictionTerm) -> bool) -> f64 {
        let coefficient = |k: usize| self.findings.found.model.friction[k].coefficient;
        let laws = self.shaft.laws().filter(|(_, term)| counts(term));
        let known: f64 = laws.map(|(k, _)| coefficient(k) * self.laws[(row, k)]).sum();
        let turned = self.shaft.shaft().iter().enumerate().find(|(_, part)| **part != 0.0);
        let residual = turned.and_then(|(joint, part)| {
            let tau = self.trace.motion.tau()?[(row, joint)];
            Some((tau - self.trace.tau_hat[(row, joint)]) / part)
        });
        known + residual.unwrap_or(f64::NAN)
    }

    fn speed(&self, row: usize) -> f64 {
        let dq = self.trace.motion.dq();
        let parts = self.shaft.shaft().iter().enumerate();
        parts.map(|(joint, part)| part * dq[(row, joint)]).sum()
    }

    fn over_speed(&self) -> Chart {
        let rows = 0..self.trace.motion.n_rows();
        let peak = rows.clone().map(|row| self.speed(row).abs()).fold(0.0, f64::max);
        let points = rows.map(|row| [self.speed(row), self.measured(row, |term| !term.load)]);
        let moving = points.filter(|[v, _]| v.abs() > REST * peak);
        let (forward, backward) = moving.partition(|[v, _]| *v > 0.0);
        // Closer together near rest, where the curve bends; torn at rest.
        let part = |k: u32| f64::from(k) / f64::from(POINTS);
        let ahead = (1..=POINTS).map(|k| peak * part(k).powi(3));
        let speeds: Vec<f64> = ahead.clone().map(|v| -v).chain([0.0]).chain(ahead).collect();
        let curve = |errors: f64| -> Vec<[f64; 2]> {
            let at = |v: f64| {
                let own = self.shaft.at_speed(v);
                if v == 0.0 { f64::NAN } else { own.value + errors * own.std_error }
            };
            speeds.iter().map(|&v| [v, at(v)]).collect()
        };
        let series = vec![
            grouped([forward, backward]),
            Series::line("model", curve(0.0)),
            Series::new("+ 2 errors", Mark::DashedLine, Colour::Faded, curve(2.0)),
            Series::new("− 2 errors", Mark::DashedLine, Colour::Faded, curve(-2.0)),
        ];
        Chart::over(self.shaft.name(), ["velocity [rad/s]", "friction [N·m]"], series)
    }

    /// Friction over position after reversals, without what depends on speed.
    fn around_reversals(&self) -> Option<Chart> {
        let joint = self.shaft.joint()?;
        let reach = REACH * self.shaft.parameters().travel?.value;
        let since = |row: usize| self.trace.since_reversal[(row, joint)];
        let after = (0..self.trace.motion.n_rows()).filter(|&row| since(row).abs() <= 2.0 * reach);
        let (forward, backward) = after.partition::<Vec<_>, _>(|&row| since(row).signum() > 0.0);
        let point = |row: usize| {
            let q = since(row) - since(row).signum() * reach;
            [q, self.measured(row, FrictionTerm::is_speedless)]
        };
        let points = |rows: Vec<usize>| rows.into_iter().map(point).collect();
        let branch = |label: &str, way: f64, colour| {
            let place = |k: u32| (f64::from(k) / f64::from(POINTS)).powi(2) * 2.0 * reach - reach;
            let at = |q: f64| [q, self.shaft.on_loop(q, reach, way).value];
            let curve = (0..=POINTS).map(|k| at(way * place(k))).collect();
            Series::new(label, Mark::Line, colour, curve)
        };
        let series = vec![
            grouped([points(forward), points(backward)]),
            branch("model, forward", 1.0, Colour::Series(0)),
            branch("model, backward", -1.0, Colour::Series(1)),
        ];
        let title = format!("{} after reversals", self.shaft.name());
        let caption = "From the left on the way forward, from the right on the way backward; \
                       without what depends on speed.";
        let chart = Chart::over(title, ["position [rad]", "friction [N·m]"], series);
        Some(Chart { caption: caption.into(), ..chart })
    }
}

/// Rows of both directions in groups of equal size: the median of each, and its quartiles.
fn grouped(directions: [Vec<[f64; 2]>; 2]) -> Series {
    let mut series =
        Series::new("measured: median, quartiles", Mark::Rings, Colour::Measured, vec![]);
    for mut rows in directions {
        rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let groups = (rows.len() / LEAST_ROWS).min(GROUPS);
        for k in 0..groups {
            let group = &rows[k * rows.len() / groups..(k + 1) * rows.len() / groups];
            let quantile = |axis: usize, part: usize| {
                let mut values: Vec<f64> = group.iter().map(|point| point[axis]).collect();
                values.sort_by(f64::total_cmp);
                values[(values.len() - 1) * part / 4]
            };
            series.points.push([quantile(0, 2), quantile(1, 2)]);
            series.spread.push([quantile(1, 1), quantile(1, 3)]);
        }
    }
    series
}

#[cfg(test)]
mod tests {
    use super::grouped;

    #[test]
    fn a_group_is_its_median_and_quartiles() {
        // Nine rows in any order, one of which is far off; seven are too few.
        let nine = [4, 0, 8, 2, 6, 1, 3, 7, 5].map(|k: u8| f64::from(k));
        let rows = nine.map(|x| [x, if x > 7.0 { 1e9 } else { 10.0 * x }]).to_vec();
        let few = rows[..7].to_vec();

        let series = grouped([rows, few]);

        assert_eq!((series.points, series.spread), (vec![[4.0, 40.0]], vec![[20.0, 60.0]]));
    }
}
