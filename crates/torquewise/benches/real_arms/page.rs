//! Outcomes → the page of the documentation.

use crate::Outcome;
use crate::delan::Parts;
use crate::sets::Split;

const HEAD: &str = "# Real arms

Torque models from public logs of real arms, beside a full rigid-body regressor **that is given the
arm's kinematics** (URDF or DH table; all masses, rotors, offset, viscous and dry friction of each
joint, by weighted least squares). Ours is given none: it learns where the axes lie.
What both are told beside, if anything, stands under the choices, as given. Both see the
same signals, the same filter and the same rows, and are run by one command:

    TORQUEWISE_SHARED=FOLDER cargo bench -p torquewise --bench real_arms

The data are public (sources in `profiles/`) and not part of the project. NRMSE is RMSE over the
standard deviation of the torque on the test rows. *ratio* is ours over the regressor's; below 1 the
model that was told nothing predicts better than the one that knows the kinematics.
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
        "| set | joints | rows | terms | worst ratio | asked | fit [s] |\n".to_owned(),
        "|---|---|---|---|---|---|---|\n".to_owned(),
    ];
    for outcome in outcomes {
        let counted = 0..outcome.set.counted;
        let worst = counted.map(|joint| ratio(outcome, joint)).fold(0.0, f64::max);
        lines.push(format!(
            "| {} | {} | {} + {} | {} | {worst:.2} | {:.2} | {:.0} |\n",
            outcome.set.name,
            outcome.joints.len(),
            outcome.rows[0],
            outcome.rows[1],
            outcome.model.n_coefficients(),
            outcome.set.limit,
            outcome.seconds,
        ));
    }
    lines.concat()
}

fn ratio(outcome: &Outcome, joint: usize) -> f64 {
    outcome.ours.nrmse[joint] / outcome.peer.nrmse[joint]
}

/// One set.
pub(crate) fn section(outcome: &Outcome) -> String {
    let split = match outcome.set.split {
        Split::Time => "first 70 % of the time to train, the rest to test".to_owned(),
        Split::Blocks(seconds) => format!("blocks of {seconds} s, every third to test"),
    };
    let mut lines = vec![
        format!("\n## {}\n\n", outcome.set.name),
        format!("{} training rows, {} test rows ({split}).\n\n", outcome.rows[0], outcome.rows[1]),
        format!("```text\n{}\n```\n\n", outcome.report),
        "| joint | RMSE ours [N·m] | regressor | NRMSE ours | regressor | ratio |\n".to_owned(),
        "|---|---|---|---|---|---|\n".to_owned(),
    ];
    for (joint, name) in outcome.joints.iter().enumerate() {
        lines.push(format!(
            "| {name} | {:.3} | {:.3} | {:.3} | {:.3} | {:.2}{} |\n",
            outcome.ours.rmse[joint],
            outcome.peer.rmse[joint],
            outcome.ours.nrmse[joint],
            outcome.peer.nrmse[joint],
            ratio(outcome, joint),
            if joint < outcome.set.counted { "" } else { " (not counted)" },
        ));
    }
    lines.push(format!(
        "\n{} terms, {:.0} s. Chosen on held-out blocks of the training rows:\n\n",
        outcome.model.n_coefficients(),
        outcome.seconds
    ));
    for choice in &outcome.model.choices {
        if choice.from.is_empty() {
            lines.push(format!("- {}: **{}**, {}\n", choice.what, choice.chosen, choice.rule));
            continue;
        }
        let tried: Vec<String> = (choice.from.iter())
            .map(|candidate| format!("{} {:.4}", candidate.label, candidate.error))
            .collect();
        lines.push(format!("- {}: **{}** of {}\n", choice.what, choice.chosen, tried.join(", ")));
    }
    if let Some(certificate) = &outcome.model.training.overlooked {
        lines.push(format!("\n{certificate}.\n"));
    }
    lines.concat()
}
