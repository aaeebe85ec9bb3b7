//! From outcomes to the page of the documentation.

use crate::delan::Parts;
use crate::sets::Split;
use crate::{Outcome, Run};

const HEAD: &str = "# Real arms

Torque models from public logs of real arms, beside a full rigid-body regressor **that is given the
arm's kinematics** (URDF or DH table; all masses, rotors, offset, viscous and dry friction of each
joint, by weighted least squares). Ours is given none: it learns where the axes lie.
What both are told beside, if anything, stands under the choices, as given. Each log is cut into
training and test **before** anything is conditioned; the training part alone chooses the filter, as
`fit` does, and both models see the same filtered rows. One command runs it all:

    TORQUEWISE_SHARED=FOLDER TORQUEWISE_ARMS=FOLDER cargo bench -p torquewise --bench real_arms

The data are public (sources in `profiles/`, and in the last section) and not part of the project.
NRMSE is RMSE over the standard deviation of the torque on the test rows, in the band of the filter;
the mean of three ways to cut the log, ± their standard deviation. *ratio* is ours over the
regressor's; below 1 the model that was told nothing predicts better than the one that knows the
kinematics. *With URDF* is ours once it is told the axes too, as by `fit --urdf`, on the same rows: its
ratio to the regressor, geometric mean and worst joint, and the seconds of its fit.
";

/// The whole page.
pub(crate) fn page(outcomes: &[Outcome], delan: Option<&Parts>) -> String {
    let sections: Vec<String> = outcomes.iter().map(section).collect();
    format!("{HEAD}\n{}\n{}{}", summary(outcomes), sections.concat(), parts(delan))
}

/// The set whose parts are known.
pub(crate) fn parts(delan: Option<&Parts>) -> String {
    let Some(Parts { given, derived, terms, rows }) = delan else {
        return "\n## DeLaN characters\n\nNot run: make the archives by \
                `python examples/delan_to_npz.py` and name their folder in `TORQUEWISE_DELAN`.\n"
            .to_owned();
    };
    let mut lines = vec![format!(
        "\n## DeLaN characters\n\nA simulated two-link arm, {rows} rows in 20 trajectories at \
         25 Hz; the true parts of the torque are given apart from it. RMS error of each part, in \
         percent of the RMS of the part, with \u{71}\u{308} as given ({} terms) and derived \
         from the velocity ({} terms):\n\n| part | joint | ddq given [%] | ddq derived [%] |\n\
         |---|---|---|---|\n",
        terms[0], terms[1]
    )];
    for (place, part) in ["inertia", "Coriolis", "gravity"].into_iter().enumerate() {
        for joint in 0..2 {
            let [given, derived] = [given, derived].map(|errors| 100.0 * errors[place][joint]);
            lines.push(format!("| {part} | {} | {given:.2e} | {derived:.2} |\n", joint + 1));
        }
    }
    lines.concat()
}

fn summary(outcomes: &[Outcome]) -> String {
    let mut lines = vec![
        "| set | joints | rows | cut-off [Hz] | ratio, geometric mean | worst | asked | fit [s] | with \
         URDF | worst | fit [s] |\n"
            .to_owned(),
        "|---|---|---|---|---|---|---|---|---|---|---|\n".to_owned(),
    ];
    for outcome in outcomes {
        let Outcome { set, joints, runs } = outcome;
        let ratios: Vec<f64> = (0..set.counted).map(|joint| ratio(outcome, joint)).collect();
        let told: Vec<f64> = (0..set.counted).map(|joint| told_ratio(outcome, joint)).collect();
        let mean = |ratios: &[f64]| {
            (ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() / ratios.len() as f64).exp()
        };
        let worst = |ratios: &[f64]| ratios.iter().copied().fold(0.0, f64::max);
        let cutoffs: Vec<String> = runs
            .iter()
            .map(|run| format!("{:.1}", run.report.cutoff.unwrap_or_default()))
            .collect();
        lines.push(format!(
            "| {} | {} | {} + {} | {} | {:.2} | {:.2} | {:.2} | {:.0} | {:.2} | {:.2} | {:.0} |\n",
            set.name,
            joints.len(),
            runs[0].rows[0],
            runs[0].rows[1],
            cutoffs.join(", "),
            mean(&ratios),
            worst(&ratios),
            set.limit,
            over_runs(outcome, |run| run.seconds).0,
            mean(&told),
            worst(&told),
            over_runs(outcome, |run| run.told_seconds).0,
        ));
    }
    lines.concat()
}

/// Mean and standard deviation over the runs.
fn over_runs(outcome: &Outcome, of: impl Fn(&Run) -> f64) -> (f64, f64) {
    mean_and_deviation(&outcome.runs.iter().map(of).collect::<Vec<f64>>())
}

pub(crate) fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
    (mean, (squares / (count - 1.0).max(1.0)).sqrt())
}

fn ratio(outcome: &Outcome, joint: usize) -> f64 {
    let of = |of: &dyn Fn(&Run) -> f64| over_runs(outcome, of).0;
    of(&|run| run.ours.nrmse[joint]) / of(&|run| run.peer.nrmse[joint])
}

/// The same of ours that was told where the axes lie.
fn told_ratio(outcome: &Outcome, joint: usize) -> f64 {
    let of = |of: &dyn Fn(&Run) -> f64| over_runs(outcome, of).0;
    of(&|run| run.told.nrmse[joint]) / of(&|run| run.peer.nrmse[joint])
}

/// One set.
pub(crate) fn section(outcome: &Outcome) -> String {
    let split = match outcome.set.split {
        Split::Time => "30 % of the time to test: the last, the first, the middle".to_owned(),
        Split::Blocks(seconds) => {
            format!("blocks of {seconds} s, every third to test, from each of the first three")
        }
    };
    let first = &outcome.runs[0];
    let mut lines = vec![
        format!("\n## {}\n\n", outcome.set.name),
        format!("{} training rows, {} test rows ({split}).\n\n", first.rows[0], first.rows[1]),
        format!("```text\n{}\n```\n\n", first.report),
        "| joint | RMSE ours [N·m] | regressor | NRMSE ours | regressor | ratio | ratio with URDF |\n"
            .to_owned(),
        "|---|---|---|---|---|---|---|\n".to_owned(),
    ];
    for (joint, name) in outcome.joints.iter().enumerate() {
        let with_error = |of: &dyn Fn(&Run) -> f64| {
            let (mean, deviation) = over_runs(outcome, of);
            format!("{mean:.3} ± {deviation:.3}")
        };
        lines.push(format!(
            "| {name} | {:.3} | {:.3} | {} | {} | {:.2}{} | {:.2} |\n",
            over_runs(outcome, |run| run.ours.rmse[joint]).0,
            over_runs(outcome, |run| run.peer.rmse[joint]).0,
            with_error(&|run| run.ours.nrmse[joint]),
            with_error(&|run| run.peer.nrmse[joint]),
            ratio(outcome, joint),
            if joint < outcome.set.counted { "" } else { " (not counted)" },
            told_ratio(outcome, joint),
        ));
    }
    lines.push(format!(
        "\n{} terms, {:.0} s. Chosen on held-out blocks of the training rows, first cut:\n\n",
        first.model.n_coefficients(),
        first.seconds
    ));
    for choice in &first.model.choices {
        if choice.from.is_empty() {
            lines.push(format!("- {}: **{}**, {}\n", choice.what, choice.chosen, choice.rule));
            continue;
        }
        let tried: Vec<String> = (choice.from.iter())
            .map(|candidate| format!("{} {:.4}", candidate.label, candidate.error))
            .collect();
        lines.push(format!("- {}: **{}** of {}\n", choice.what, choice.chosen, tried.join(", ")));
    }
    lines.concat()
}
