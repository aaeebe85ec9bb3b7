//! From further arms to their section of the page, beside what others have published of the same
//! logs.

use crate::further::{Further, Track, nrmse};
use crate::page::mean_and_deviation;
use std::error::Error;
use torquewise::identify::verdict::Grade;

/// Where the section begins.
const TITLE: &str = "\n## Further arms";
/// Torque below this cut-off \[Hz\], by a filter of this order, is the target of all arms.
const TARGET: (f64, usize) = (5.0, 4);
/// The target of the notebooks of the xMate7p.
const XMATE: (f64, usize) = (2.5, 3);
/// That of the notebooks of the youBot: 10 Hz where they take 1 000 rows per second, of 100.
const YOUBOT: (f64, usize) = (1.0, 2);

const HEAD: &str = "

Five arms that nothing is told of. `fit` is left to itself: cut-off, delay and all else as above,
and every test log is another motion. The target is the same whatever the cut-off of a model: the
measured torque below 5 Hz, and what the model misses of it through the same filter (Butterworth,
fourth order, zero phase), over the standard deviation of that torque in all tests; the mean of the
test logs, or of the halves of a single one, ± their standard deviation. Only this section is
written by

    TORQUEWISE_ARMS=FOLDER cargo bench -p torquewise --bench real_arms -- further

where `FOLDER` holds `NAME_train*.csv` and `NAME_test*.csv` with columns `t`, `q1` …, `dq1` …,
`tau1` …, in SI units but for the current of krang. The data are public and not part of the project;
their rows have no clock, but a rate:

| arm | repository | train; test | columns | rate [Hz] |
|---|---|---|---|---|
| xmate7p | [NKU-ZiXuan/xMate7p_dyn_ident](https://github.com/NKU-ZiXuan/xMate7p_dyn_ident) | `data/recdata/xMate7p_traj1_results.csv`; 2, 3 | q 1–7, τ 22–28 | 50 |
| lwr_paths | [JunShao0104/NDE-based-Robot-Learning-Dynamics](https://github.com/JunShao0104/NDE-based-Robot-Learning-Dynamics) | `data/FK/KukaDirectDynamics.mat`: `kukatraj1` to 7; 8 to 10 | q 1–7, q̇ 8–14, τ 15–21 | 100 |
| baxter | [EduardoRosLab/Baxter_Dynamic_Model](https://github.com/EduardoRosLab/Baxter_Dynamic_Model) | `Dataset/Training`: `sin_XYZ_` of 8, 10, 12 and 15 s, `Random`; `Dataset/Test`: `sin_XYZ_12_5s`, `circle_XY` | q 1–7, q̇ 8–14, τ 15–21 | 100 |
| krang | [zubair-irshad/manipulator_parameter_identification](https://github.com/zubair-irshad/manipulator_parameter_identification) | `29-ArmDataCollection/trainData`; `testData` | `dataQ`, `dataDotQ`, `dataCur` (motor current [A]) | 100 |
| youbot | [malakslim/EECE798K-Project](https://github.com/malakslim/EECE798K-Project) | `Data/Data in CSV form/traj` 8, 6, 3, 9, 10, 7, 12, 4; 2, 11 | `posa`, `vela`, `trq` | 100 |

";

/// What others found on the logs of one arm.
struct Published {
    arm: &'static str,
    by: &'static str,
    knew: &'static str,
    theirs: &'static str,
}

const fn published(arm: &'static str, [by, knew, theirs]: [&'static str; 3]) -> Published {
    Published { arm, by, knew, theirs }
}

const PUBLISHED: [Published; 5] = [
    published(
        "xmate7p",
        [
            "xMate7p_dyn_ident, notebook V1-50: the same 20 s at 50 Hz, least squares",
            "kinematics",
            "3.04, 3.84",
        ],
    ),
    published(
        "xmate7p",
        [
            "xMate7p_dyn_ident, notebooks V0, V1-1000: 60 s at 1 kHz, least squares",
            "kinematics",
            "2.50 to 2.99, 3.19 to 3.32",
        ],
    ),
    published("youbot", ["EECE798K-Project: SINDy with LASSO", "nothing", "1.54"]),
    published("youbot", ["EECE798K-Project: network", "nothing", "1.39"]),
    published("youbot", ["EECE798K-Project: network, and the torque of the URDF", "URDF", "0.90"]),
];

/// The page, before the section and from there.
pub(crate) fn parted(page: &str) -> (String, String) {
    let (before, section) = page.split_at(page.find(TITLE).unwrap_or(page.len()));
    (before.to_owned(), section.to_owned())
}

/// The section.
pub(crate) fn section(arms: &[Further]) -> Result<String, Box<dyn Error + Send + Sync>> {
    let most = arms.iter().map(|arm| arm.tests[0].mean_squares().len()).max().unwrap_or(0);
    let numbers: Vec<String> = (1..=most).map(|joint| joint.to_string()).collect();
    let mut lines = vec![
        format!("{TITLE}{HEAD}NRMSE [%] of each joint:\n\n"),
        format!("| arm | cut-off [Hz] | fit [s] | {} | geometric mean |\n", numbers.join(" | ")),
        format!("|{}\n", "---|".repeat(most + 4)),
    ];
    for arm in arms {
        lines.push(row(arm, most)?);
    }
    lines.push("\nWhat `fit` says of them, from the training logs alone:\n\n".to_owned());
    for Further { name, verdict, .. } in arms {
        let said = verdict.as_ref().map_or_else(String::new, ToString::to_string);
        lines.push(format!("- {name}: {said}\n"));
    }
    lines.push(beside(arms)?);
    Ok(lines.concat())
}

fn row(arm: &Further, most: usize) -> Result<String, Box<dyn Error + Send + Sync>> {
    let parts = nrmse(&below(&arm.tests, TARGET)?);
    let n = parts[0].len();
    let joint = |joint: usize| {
        let of: Vec<f64> = parts.iter().map(|part| 100.0 * part[joint]).collect();
        with_deviation(&of)
    };
    let cells: Vec<String> =
        (0..most).map(|j| if j < n { joint(j) } else { String::new() }).collect();
    let geometric = |part: &Vec<f64>| {
        100.0 * (part.iter().map(|error| error.ln()).sum::<f64>() / n as f64).exp()
    };
    let means: Vec<f64> = parts.iter().map(geometric).collect();
    Ok(format!(
        "| {} | {:.1} | {:.0} | {} | {} |\n",
        arm.name,
        arm.cutoff,
        arm.seconds,
        cells.join(" | "),
        with_deviation(&means)
    ))
}

/// What others have published, in their measure, beside ours.
fn beside(arms: &[Further]) -> Result<String, Box<dyn Error + Send + Sync>> {
    let mut lines = vec![
        "\nBeside what was published of the same test logs, in the measure of its authors. \
         xmate7p: ‖τ − τ̂‖ of all joints in percent of ‖τ‖, torque below 2.5 Hz, on each of \
         the two test logs. youbot: mean square of the error, mean of the joints, with the \
         filter that their notebooks use, 1 % of the rate, over both test logs (and of each). \
         Ours is told nothing.\n\n\
         | arm | by | told | theirs | ours |\n|---|---|---|---|---|\n"
            .to_owned(),
    ];
    for Published { arm, by, knew, theirs } in PUBLISHED {
        let Some(own) = arms.iter().find(|own| own.name == arm) else { continue };
        let ours = match arm {
            "xmate7p" => parts_of_norm(&below(&own.tests, XMATE)?),
            _ => mean_squares(&below(&own.tests, YOUBOT)?),
        };
        let verdict = own.verdict.as_ref().filter(|verdict| verdict.grade == Grade::Unusable);
        let said = verdict.map_or_else(String::new, |verdict| format!(", {}", verdict.grade));
        lines.push(format!("| {arm} | {by} | {knew} | {theirs} | {ours}{said} |\n"));
    }
    for own in arms.iter().filter(|own| own.name == "xmate7p") {
        let raw = parts_of_norm(&own.tests);
        lines.push(format!("\nOf the torque of xmate7p as it was measured: {raw} %.\n"));
    }
    Ok(lines.concat())
}

fn below(
    tests: &[Track],
    filter: (f64, usize),
) -> Result<Vec<Track>, Box<dyn Error + Send + Sync>> {
    tests.iter().map(|test| test.below(filter)).collect()
}

/// Of each test, percent.
fn parts_of_norm(tests: &[Track]) -> String {
    let of = |test: &Track| format!("{:.2}", 100.0 * test.part_of_norm());
    tests.iter().map(of).collect::<Vec<String>>().join(", ")
}

/// Mean of the joints, of all rows and of each test.
fn mean_squares(tests: &[Track]) -> String {
    let of = |test: &Track| {
        let squares = test.mean_squares();
        squares.iter().sum::<f64>() / squares.len() as f64
    };
    let rows: usize = tests.iter().map(Track::n_rows).sum();
    let all: f64 = tests.iter().map(|test| of(test) * test.n_rows() as f64).sum();
    let each: Vec<String> = tests.iter().map(|test| format!("{:.2}", of(test))).collect();
    format!("{:.2} ({})", all / rows as f64, each.join(", "))
}

/// Mean ± standard deviation, three digits.
fn with_deviation(values: &[f64]) -> String {
    let (mean, deviation) = mean_and_deviation(values);
    let digits = [100.0, 10.0].iter().filter(|least| mean.abs() < **least).count();
    format!("{mean:.digits$} ± {deviation:.digits$}")
}
