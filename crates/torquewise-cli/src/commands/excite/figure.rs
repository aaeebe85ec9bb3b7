//! Figure of `excite`: position and velocity of each joint with their limits.

use crate::Result;
use torquewise::excite::{Excitation, Limits, Planned, State};
use torquewise::motion::Pattern;
use torquewise::report::chart_figure;
use torquewise::report::html::{Axis, Chart, Colour, Guide, Series, Stretches};

/// Points of a curve: more than can be seen.
const POINTS: f64 = 4000.0;
/// Space beyond the limits, as a share of the way between them.
const SPACE: f64 = 0.08;

/// One row per joint, the three recordings one after the other.
pub(crate) fn figure(arm: &str, limits: &[Limits], planned: &Excitation) -> Result<String> {
    let (states, bands) = states(&planned.recordings);
    let mut charts = Vec::with_capacity(2 * limits.len());
    for (joint, limits) in limits.iter().enumerate() {
        let is_last = joint + 1 == planned.peaks[0].len();
        let chart = |title: &str, unit: &str, ends: [f64; 2], of: &dyn Fn(&State) -> f64| {
            let space = SPACE * (ends[1] - ends[0]);
            let range = Some([ends[0] - space, ends[1] + space]);
            let points = states.iter().map(|(t, state)| [*t, of(state)]).collect();
            let x = Axis::named(if is_last { "time [s]" } else { "" });
            let axes = [x, Axis { range, ..Axis::named(unit) }];
            let name = |own: &Stretches| if joint == 0 { own.label.clone() } else { String::new() };
            let bands =
                bands.iter().map(|own| Stretches { label: name(own), ..own.clone() }).collect();
            let guides = ends.map(|end| Guide::at_y(end, "")).to_vec();
            Chart { bands, guides, ..Chart::new(title, axes, vec![Series::line("", points)]) }
        };
        let most = limits.planned;
        let speeds = [-most.velocity, most.velocity];
        charts.push(chart(&limits.joint, "q [rad]", most.position, &|state| state.q[joint]));
        charts.push(chart("", "dq [rad/s]", speeds, &|state| state.dq[joint]));
    }
    let title = format!("{arm}: planned motion, limits of the plan dashed");
    Ok(chart_figure(&title, &charts, 2)?)
}

/// States over all recordings, and where each recording is.
fn states(recordings: &[Planned; 3]) -> (Vec<(f64, State)>, Vec<Stretches>) {
    let seconds: f64 = recordings.iter().map(|recording| recording.seconds).sum();
    let (mut states, mut bands, mut start) = (Vec::new(), Vec::new(), 0.0);
    for (recording, pattern) in recordings.iter().zip(Pattern::ALL) {
        let end = start + recording.seconds;
        let mut t = 0.0;
        while t < recording.seconds {
            states.push((start + t, recording.state_at(t)));
            t += seconds / POINTS;
        }
        bands.push(Stretches {
            label: format!("{}.csv", recording.name),
            colour: Colour::Pattern(pattern),
            spans: vec![[start, end]],
        });
        start = end;
    }
    (states, bands)
}
