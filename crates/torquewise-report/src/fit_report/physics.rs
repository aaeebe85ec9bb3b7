//! Physical checks in words.

use super::verdict::sentence;
use crate::{Heading, Item, Section, Table, Tone, count, significant};
use torquewise_model::Checks;

pub(crate) fn section(checks: &Checks) -> Section {
    let (tone, verdict) = if checks.passed() {
        (Tone::Good, "A physical arm could have this model at every state examined.")
    } else if checks.is_arm() {
        (
            Tone::Warning,
            "A physical arm could have this model at every state examined, but friction:",
        )
    } else {
        let words = "No physical arm has this model at some state examined: it may predict torque, \
                     but simulation and computed-torque control with it can fail.";
        (Tone::Warning, words)
    };
    let row = |name: &str, value: f64, expected: &str| {
        vec![name.into(), significant(value, 3).into(), expected.into()]
    };
    let zero = "zero, but for rounding";
    let power = checks.driving.as_ref().map_or(0.0, |driving| -driving.power);
    let rows = vec![
        row("smallest eigenvalue of M [kg·m²]", checks.smallest_eigenvalue, "more than zero"),
        row("asymmetry of M", checks.asymmetry, zero),
        row("defect of Ṁ − 2C from skew symmetry", checks.skew_defect, zero),
        row("power of friction that drives a shaft [W]", power, "none"),
    ];
    let [check, expected] = ["check", "a physical arm has"].map(Heading::words);
    let columns = vec![check, Heading::numbers("found"), expected];
    let caption = format!("The worst of {} states.", count(checks.states));
    let table = Table { caption, columns, rows };
    let driving = checks.driving.iter().map(|driving| sentence(&driving.to_string()));
    let lines = std::iter::once(verdict.into()).chain(driving).collect();
    let callout = Item::Callout { tone, heading: String::new(), lines };
    Section { heading: "Physics".into(), items: vec![callout, Item::Table(table)] }
}
