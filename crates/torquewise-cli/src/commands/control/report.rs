//! Figure and page of `control`: errors, positions and torques of each controller.

use crate::Result;
use crate::commands::control::Compared;
use faer::Mat;
use torquewise::control::{Run, Tracking};
use torquewise::report::chart_figure;
use torquewise::report::html::number::significant;
use torquewise::report::html::{
    Chart, Colour, Guide, Heading, Item, Label, Mark, Page, Section, Series, Table,
};

/// One row per joint: position beside error.
pub(super) fn figure(arm: &str, compared: &Compared) -> Result<String> {
    let charts: Vec<Chart> = (0..compared.wanted.n_joints())
        .flat_map(|joint| [positions(compared, joint), errors(compared, joint)])
        .collect();
    Ok(chart_figure(&format!("{arm}: desired and tracked motion"), &charts, 2)?)
}

pub(super) fn page(arm: &str, compared: &Compared) -> Result<String> {
    let n = compared.wanted.n_joints();
    let charts = |of: fn(&Compared, usize) -> Chart| -> Vec<Item> {
        (0..n).map(|joint| Item::Charts(vec![of(compared, joint)])).collect()
    };
    let section = |heading: &str, items| Section { heading: heading.into(), items };
    let bandwidth = compared.found.gains.bandwidth;
    let page = Page {
        title: format!("{arm} under control"),
        lead: format!(
            "The same motion and the same feedback, critically damped at {bandwidth} rad/s, for \
             every controller: they differ in what they know of the arm. Errors count from {} s \
             on.",
            compared.settle
        ),
        sections: vec![
            section("Errors", std::iter::once(table(compared)).chain(charts(errors)).collect()),
            section("Positions", charts(positions)),
            section(
                "Torques",
                charts(|compared, joint| {
                    chart(compared, joint, ("command [N·m]", 1.0), |run| &run.tau, Vec::new())
                }),
            ),
        ],
        ..Page::default()
    };
    Ok(page.to_html()?)
}

fn table(compared: &Compared) -> Item {
    let mut columns = vec![Heading::words("controller")];
    for what in ["RMS", "peak"] {
        let joints = compared.wanted.joints().iter();
        columns.extend(joints.map(|joint| Heading::numbers(format!("{joint} {what} [mrad]"))));
    }
    let row = |run: &Run| -> Vec<Label> {
        let rms = run.tracking.rms_error(compared.settle);
        let peak = run.tracking.peak_error(compared.settle);
        let cells = rms.into_iter().chain(peak).map(|error| significant(1e3 * error, 3));
        std::iter::once(run.name.clone()).chain(cells).map(Label::from).collect()
    };
    let rows = compared.found.runs.iter().map(row).collect();
    let away =
        compared.found.ran_away.iter().map(|(name, t)| format!(" {name} ran away at {t:.3} s."));
    let caption = format!("Position error of each joint.{}", away.collect::<String>());
    Item::Table(Table { caption, columns, rows })
}

fn errors(compared: &Compared, joint: usize) -> Chart {
    let guides = vec![Guide::at_x(compared.settle, "errors count from")];
    let axis = ("error [mrad]", 1e3);
    Chart { guides, ..chart(compared, joint, axis, |tracking| &tracking.error, Vec::new()) }
}

fn positions(compared: &Compared, joint: usize) -> Chart {
    let wanted = &compared.wanted;
    let points = (0..wanted.n_rows()).map(|row| [wanted.t()[row], wanted.q()[(row, joint)]]);
    let desired = Series::new("desired", Mark::BroadLine, Colour::Measured, points.collect());
    chart(compared, joint, ("position [rad]", 1.0), |tracking| &tracking.q, vec![desired])
}

/// - `axis`: its name, and how much of it a unit of the signal is
fn chart(
    compared: &Compared,
    joint: usize,
    (axis, unit): (&str, f64),
    of: fn(&Tracking) -> &Mat<f64>,
    mut series: Vec<Series>,
) -> Chart {
    let runs = compared.found.runs.iter().enumerate();
    series.extend(runs.map(|(place, Run { name, tracking, .. })| {
        let points = tracking.t.iter().zip(of(tracking).col_as_slice(joint));
        let points = points.map(|(&t, &x)| [t, unit * x]).collect();
        Series::new(name, Mark::Line, Colour::Series(place), points)
    }));
    let chart = Chart::over(&compared.wanted.joints()[joint], ["time [s]", axis], series);
    Chart { linked: Some("time".into()), ..chart }
}
