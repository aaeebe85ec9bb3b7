//! Summary of `excite`: peaks, limits, and how well the motion determines coefficients.

use super::{Arguments, Files};
use crate::{Outcome, Table};
use serde_json::{Value, json};
use torquewise::excite::{Bounds, Excitation, Limits, Torques};
use torquewise::model::number;

const UNKNOWN: &str = "Collisions are not checked: neither the shape of the arm nor its \
                       surroundings are known here. Try the motion in a simulator, then slowly on \
                       the arm; --range keeps joints out of the way.";
const ABOUT: [(&str, &str); 3] =
    [("standstill", "gravity"), ("uniform", "Coriolis, friction"), ("all", "everything")];

pub(super) fn outcome(
    arguments: &Arguments,
    (limits, torques): (&[Limits], Option<&Torques>),
    planned: &Excitation,
    files: &Files,
) -> Outcome {
    let mut text = text(arguments, limits, planned, files);
    let mut json = json(arguments, limits, planned, files);
    if let (Some(torques), Some(peaks)) = (torques, &planned.torques) {
        json["speed"] = json!(planned.speed);
        let mut table = Table::new(["joint", "peak tau [N·m]", "limit"]);
        let joints = json["joints"].as_array_mut().into_iter().flatten().zip(limits);
        for (((joint, own), peak), most) in joints.zip(peaks).zip(torques.most()) {
            table.row(&own.joint, [*peak, *most].map(number));
            joint["torque"] = json!({ "peak": peak, "limit": most });
        }
        let slowed = "of those planned without limits of the torque";
        let speed = number(planned.speed);
        text = format!("Speeds are {speed} {slowed}:\n\n{}\n{text}", table.text());
    }
    Outcome { text, json, warnings: warnings(planned), ..Outcome::default() }
}

fn warnings(planned: &Excitation) -> Vec<String> {
    let alone = &planned.not_alone;
    let alone = (!alone.is_empty()).then(|| {
        format!("no time to sweep {} alone: give --uniform more seconds", alone.join(", "))
    });
    let all = &planned.criteria[2];
    let told = (!all.condition.is_finite()).then(|| {
        format!(
            "not all {} coefficients can be told apart: give more seconds or a lower --interaction",
            all.columns
        )
    });
    alone.into_iter().chain(told).collect()
}

fn text(arguments: &Arguments, limits: &[Limits], planned: &Excitation, files: &Files) -> String {
    let written = planned.recordings.iter().zip(&files.recordings).map(|(recording, files)| {
        let [log, trajectory] = files.each_ref().map(|file| file.display());
        let (seconds, rows) = (recording.seconds, recording.n_rows());
        format!("{log}, {trajectory}: {seconds:.1} s, {rows} rows, {} parts\n", recording.n_parts())
    });
    let home: Vec<String> = planned.recordings[0].home.iter().map(|q| number(*q)).collect();
    format!(
        "{}: planned within {} of the speed limits, home at {} rad\n\n{}{}\n\
         Information per second, which the plan makes large (D-optimality), and condition number\n\
         of the columns, each of size one over the limits, beside those of a random plan within\n\
         the same limits; – where some cannot be told apart;\n\
         interaction order {}:\n\n{}\n{}figure: {}\n\n{}\n",
        arguments.arm,
        arguments.speed_scale,
        home.join(" "),
        limits_text(limits, planned),
        assumed_text(limits),
        planned.interaction,
        criteria_text(planned),
        written.collect::<String>(),
        files.figure.display(),
        UNKNOWN,
    )
}

fn peaks(planned: &Excitation, joint: usize) -> Bounds {
    let [mut most, others @ ..] = planned.peaks.each_ref().map(|peaks| peaks[joint]);
    for other in others {
        let [least, greatest] = other.position;
        most.position = [most.position[0].min(least), most.position[1].max(greatest)];
        most.velocity = most.velocity.max(other.velocity);
        most.acceleration = most.acceleration.max(other.acceleration);
    }
    most
}

fn limits_text(limits: &[Limits], planned: &Excitation) -> String {
    let rates = ["peak dq [rad/s]", "limit", "peak ddq [rad/s²]", "limit"];
    let mut table = Table::new(["joint", "q [rad]", "limits"].into_iter().chain(rates));
    for (joint, limits) in limits.iter().enumerate() {
        let (most, arm) = (peaks(planned, joint), limits.arm);
        let ends = |[lower, upper]: [f64; 2]| format!("{lower:.2} … {upper:.2}");
        let positions = [most.position, arm.position].map(ends);
        let rates = [most.velocity, arm.velocity, most.acceleration, arm.acceleration];
        table.row(&limits.joint, positions.into_iter().chain(rates.map(number)));
    }
    table.text()
}

fn assumed_text(limits: &[Limits]) -> String {
    let flags = [
        ("position", "--range", "one turn"),
        ("velocity", "--max-velocity", "2 rad/s"),
        ("acceleration", "--max-acceleration", "planned speed in 0.5 s"),
    ];
    let line = |(what, flag, value): (&str, &str, &str)| {
        let joints = limits.iter().filter(|limits| limits.assumed.contains(&what));
        let joints: Vec<&str> = joints.map(|limits| limits.joint.as_str()).collect();
        let all = if joints.len() == limits.len() { "all".into() } else { joints.join(", ") };
        (!joints.is_empty()).then(|| format!("assumed {what} of {all}: {value}; see {flag}\n"))
    };
    flags.into_iter().filter_map(line).collect()
}

fn criteria_text(planned: &Excitation) -> String {
    let condition = ["information [1/s]", "random", "condition", "random"];
    let mut table = Table::new(["recording", "about", "columns"].into_iter().chain(condition));
    let pairs = planned.criteria.iter().zip(&planned.random);
    for ((name, about), (own, random)) in ABOUT.into_iter().zip(pairs) {
        let condition = [own.information, random.information, own.condition, random.condition];
        let cells = [about.to_owned(), own.columns.to_string()];
        table.row(name, cells.into_iter().chain(condition.map(number)));
    }
    table.text()
}

fn json(arguments: &Arguments, limits: &[Limits], planned: &Excitation, files: &Files) -> Value {
    let joints = limits.iter().enumerate().map(|(joint, limits)| {
        json!({
            "name": limits.joint,
            "limit": limits.arm,
            "planned": limits.planned,
            "peak": peaks(planned, joint),
            "assumed": limits.assumed,
        })
    });
    let recordings = planned.recordings.iter().zip(&planned.peaks).zip(&files.recordings);
    let recordings = recordings.map(|((recording, peaks), [log, trajectory])| {
        json!({
            "name": recording.name,
            "seconds": recording.seconds,
            "rows": recording.n_rows(),
            "parts": recording.n_parts(),
            "peaks": peaks,
            "file": log,
            "ros_file": trajectory,
        })
    });
    let pairs = planned.criteria.iter().zip(&planned.random);
    let criteria = ABOUT.into_iter().zip(pairs).map(|((name, about), (own, random))| {
        json!({ "recording": name, "about": about, "planned": own, "random": random })
    });
    json!({
        "arm": arguments.arm,
        "joints": joints.collect::<Vec<_>>(),
        "recordings": recordings.collect::<Vec<_>>(),
        "interaction": planned.interaction,
        "criteria": criteria.collect::<Vec<_>>(),
        "home": planned.recordings[0].home,
        "rate_hz": arguments.rate,
        "ros_rate_hz": arguments.ros_rate,
        "tries": arguments.tries,
        "seed": arguments.seed,
        "figure": files.figure,
        "not_checked": UNKNOWN,
    })
}
