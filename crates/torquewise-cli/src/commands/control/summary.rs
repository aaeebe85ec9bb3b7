//! Table, JSON and warnings of `control`.

use crate::commands::control::{Arguments, Compared};
use crate::{Outcome, Table};
use serde_json::{Value, json};
use std::fmt::Write;
use torquewise::control::{Law, Run};
use torquewise::model::number;

pub(super) fn outcome(arguments: &Arguments, compared: &Compared, is_own: bool) -> Outcome {
    let mut text = table(compared).text();
    let seconds = compared.wanted.t().last().copied().unwrap_or_default();
    // Writing to a String cannot fail.
    let _ = write!(
        text,
        "\nRMS of the position error from {} s on, of {seconds} s; gains of {} rad/s for all\n",
        compared.settle, compared.found.gains.bandwidth
    );
    let files = [&arguments.output, &arguments.plot, &arguments.report];
    for (kind, file) in ["table", "figure", "report"].iter().zip(files) {
        if let Some(file) = file {
            let _ = writeln!(text, "{kind}: {}", file.display());
        }
    }
    let (json, warnings) = (json(arguments, compared), warnings(compared));
    let own = "the arm is the model itself: what is seen is the control, not an error of the model";
    let notes = is_own.then(|| own.to_owned()).into_iter().collect();
    Outcome { text, json, warnings, notes, ..Outcome::default() }
}

fn table(compared: &Compared) -> Table {
    let mut headings = vec!["controller".to_owned()];
    headings.extend(compared.wanted.joints().iter().map(|joint| format!("{joint} [mrad]")));
    let led = compared.found.runs.iter().any(|run| run.law == Law::HandGuiding);
    if led {
        headings.extend(compared.wanted.joints().iter().map(|joint| format!("{joint} hand [N·m]")));
    }
    let mut table = Table::new(headings);
    for run in &compared.found.runs {
        let errors = run.tracking.rms_error(compared.settle);
        let mut cells: Vec<String> = errors.iter().map(|error| number(1e3 * error)).collect();
        if run.law == Law::HandGuiding {
            cells.extend(run.tracking.rms_hand(compared.settle).into_iter().map(number));
        }
        table.row(&run.name, cells);
    }
    for (name, t) in &compared.found.ran_away {
        table.row(name, [format!("runs away at {t:.3} s")]);
    }
    table
}

fn json(arguments: &Arguments, compared: &Compared) -> Value {
    let gains = &compared.found.gains;
    let mut object = json!({
        "arm": arguments.arm,
        "joints": compared.wanted.joints(),
        "settle_s": compared.settle,
        "gains": {
            "bandwidth_rad_s": gains.bandwidth,
            "proportional": gains.proportional,
            "integral": gains.integral,
            "derivative": gains.derivative,
        },
        "file": arguments.output,
        "plot": arguments.plot,
        "report": arguments.report,
    });
    let settle = compared.settle;
    for (name, t) in &compared.found.ran_away {
        object[name] = json!({ "ran_away_s": t });
    }
    for Run { name, tracking, law } in &compared.found.runs {
        object[name] = json!({
            "rms_error_rad": tracking.rms_error(settle),
            "peak_error_rad": tracking.peak_error(settle),
            "saturated": tracking.saturated,
        });
        if *law == Law::HandGuiding {
            object[name]["rms_hand_nm"] = json!(tracking.rms_hand(settle));
        }
    }
    object
}

/// Share of the ticks at the limit of the torque from which on it is said.
const SATURATED: f64 = 0.01;

fn warnings(compared: &Compared) -> Vec<String> {
    let away = compared.found.ran_away.iter().map(|(name, t)| {
        format!("{name}: the arm runs away at {t:.3} s: lower the bandwidth, or raise the rate")
    });
    let mut warnings: Vec<String> = away.collect();
    for run in &compared.found.runs {
        for (joint, &share) in compared.wanted.joints().iter().zip(&run.tracking.saturated) {
            if share > SATURATED {
                warnings.push(format!(
                    "{}: {joint} is at the limit of its torque at {:.0} % of the ticks: give it \
                     a slower motion, or less weight where that alone asks for more",
                    run.name,
                    100.0 * share
                ));
            }
        }
    }
    warnings
}
