//! Tables of conditioning: filter, repairs, ranges, noise.

use crate::{Findings, Heading, Item, Label, Section, Table, significant};
use torquewise_model::units;
use torquewise_motion::Repairs;

const DIGITS: usize = 3;

pub(crate) fn section(findings: &Findings<'_>) -> Section {
    let training = &findings.found.model.training;
    let total: Repairs = training.conditioning.values().sum();
    let filter = training.filter.map_or_else(
        || "The signals were not filtered.".to_owned(),
        |filter| {
            let [cutoff, delay] = [filter.cutoff_hz, 1e3 * filter.delay];
            let [cutoff, delay] = [cutoff, delay].map(|x| significant(x, DIGITS));
            format!(
                "A zero-phase low-pass of {cutoff} Hz filtered the signals; the torque was moved \
                 by {delay} ms onto the clock of the motion."
            )
        },
    );
    let repaired = if total.is_none() {
        "No row was left out and no value replaced.".to_owned()
    } else {
        format!("All logs: {total}.")
    };
    let mut items = vec![Item::Text(format!("{filter} {repaired}"))];
    if !total.is_none() {
        let each = training.conditioning.iter().map(|(log, repairs)| row(log, repairs));
        let left_out = ["spikes replaced", "repeated stamps", "held rows", "other rows left out"];
        let moved = ["late stamps", "turns taken out", "gaps bridged", "longest [ms]", "splits"];
        let numbers = left_out.into_iter().chain(moved).map(Heading::numbers);
        items.push(Item::Table(Table {
            caption: "What was repaired in the logs; the others needed no repair.".into(),
            columns: std::iter::once(Heading::words("log")).chain(numbers).collect(),
            rows: each.chain([row("all", &total)]).collect(),
        }));
    }
    let words = "The model holds within the ranges below; beyond them it extrapolates.";
    items.push(Item::Text(words.into()));
    items.extend([reach(findings), noise(findings)].map(Item::Table));
    Section { heading: "Conditioning and ranges".into(), items }
}

fn row(log: &str, repairs: &Repairs) -> Vec<Label> {
    let Repairs { earlier_stamps, not_finite, absurd, zeros, too_short, .. } = repairs;
    let others = earlier_stamps + not_finite + absurd + zeros + too_short;
    let left_out = [repairs.repeated_stamps, repairs.held_rows, others];
    let moved = [repairs.late_stamps, repairs.whole_turns, repairs.gaps];
    let counts = std::iter::once(repairs.spikes.values().sum()).chain(left_out).chain(moved);
    let mut cells: Vec<Label> = vec![log.into()];
    cells.extend(counts.map(|number| number.to_string().into()));
    cells.push(significant(1e3 * repairs.longest_gap, DIGITS).into());
    cells.push(repairs.splits.to_string().into());
    cells
}

fn reach(findings: &Findings<'_>) -> Table {
    let survey = &findings.found.survey;
    let motion = ["q from [rad]", "to [rad]", "largest |q̇| [rad/s]", "largest |q̈| [rad/s²]"];
    let columns = [&motion[..], &["mean τ [N·m]", "std of τ [N·m]"]].concat();
    let numbers = |joint: usize| {
        let [low, high] = survey.q_range[joint];
        let peaks = [survey.dq_peak[joint], survey.ddq_peak[joint]];
        let torque = [survey.torque_mean[joint], survey.torque_std[joint]];
        [[low, high], peaks, torque].concat()
    };
    let caption = "Motion and torque of each joint in the log.".into();
    per_joint(findings, caption, &columns, numbers)
}

fn noise(findings: &Findings<'_>) -> Table {
    let noise = &findings.found.noise;
    let columns = ["in q [rad]", "in q̇ [rad/s]", "in q̈ [rad/s²]"];
    let numbers = |joint: usize| vec![noise.q[joint], noise.dq[joint], noise.ddq[joint]];
    let caption = "Standard deviation of the white noise; 0 where none was found.".into();
    per_joint(findings, caption, &columns, numbers)
}

fn per_joint(
    findings: &Findings<'_>,
    caption: String,
    headings: &[&str],
    numbers: impl Fn(usize) -> Vec<f64>,
) -> Table {
    let row = |(joint, name): (usize, &String)| -> Vec<Label> {
        let numbers = numbers(joint).into_iter().map(|x| significant(x, DIGITS).into());
        std::iter::once(name.as_str().into()).chain(numbers).collect()
    };
    let kinds = findings.found.model.kinds();
    let columns = headings.iter().map(|text| Heading::numbers(units::heading(&kinds, text)));
    Table {
        caption,
        columns: std::iter::once(Heading::words("joint")).chain(columns).collect(),
        rows: findings.found.survey.joints.iter().enumerate().map(row).collect(),
    }
}
