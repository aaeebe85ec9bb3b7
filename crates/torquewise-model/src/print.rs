//! Model → equations to read: plain text and LaTeX, with the digits that mean something.

use crate::energy::{EnergyTerm, Place};
use crate::model::{Form, Model, Weighted};
use crate::term::Term;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Digits shown where no uncertainty is known, or where it is below the precision of the data.
const MAX_DIGITS: i32 = 10;

/// A number with the digits its standard error leaves standing (two digits of the error), and the
/// error: `8.3960 ± 0.0031`.
pub fn with_error(value: f64, std_error: f64) -> String {
    let decimals = decimals(value, std_error);
    let shown = format!("{value:.decimals$}");
    if std_error > 0.0 && digits_before(std_error) > -12 {
        format!("{shown} ± {std_error:.decimals$}")
    } else {
        shown
    }
}

/// Decimals that show two digits of the error, but at most [`MAX_DIGITS`] digits of the value.
fn decimals(value: f64, std_error: f64) -> usize {
    let most = MAX_DIGITS - digits_before(value);
    let wanted = if std_error > 0.0 { 2 - digits_before(std_error) } else { most };
    usize::try_from(wanted.min(most).clamp(0, 16)).unwrap_or(0)
}

/// Number of digits before the decimal point; zero or negative for numbers below one.
fn digits_before(x: f64) -> i32 {
    if x == 0.0 {
        return 0;
    }
    // A finite number has a logarithm between −324 and 309.
    #[expect(clippy::cast_possible_truncation, reason = "between -324 and 309")]
    let exponent = x.abs().log10().floor() as i32;
    exponent + 1
}

/// The equations as text: energies first where the model has them, then the torque of each joint.
///
/// Behind a term stands the share of resampled logs in which it stays, where that was asked for.
pub fn text(model: &Model) -> String {
    let mut lines = Vec::new();
    let units = if has_inclusion(model) {
        "SI units, ± standard error (share of resampled logs that keep the term)"
    } else {
        "SI units, ± standard error"
    };
    if let Form::Energy(terms) = &model.form {
        lines.push("Energies: T = 1/2 dq' M(q) dq and V(q)".into());
        lines.push(units.into());
        for (place, terms) in by_place(terms) {
            lines.push(String::new());
            lines.push(format!("{} =", place.name()));
            lines.extend(terms.iter().map(|w| line(w, &w.term.function)));
        }
        lines.push(String::new());
        lines.push("Torques that follow: tau = d/dt dT/d(dq) - dT/dq + dV/dq".into());
    } else {
        lines.push("Torques".into());
        lines.push(units.into());
    }
    for (joint, equation) in weighted_equations(model).into_iter().enumerate() {
        lines.push(String::new());
        lines.push(format!("tau{} = [{}]", joint + 1, model.joints[joint]));
        if equation.is_empty() {
            lines.push("    0".into());
        }
        for w in equation {
            lines.push(line(&w, &w.term));
        }
    }
    lines.join("\n") + "\n"
}

fn has_inclusion(model: &Model) -> bool {
    match &model.form {
        Form::Torque(joints) => joints.iter().flatten().any(|w| w.inclusion.is_some()),
        Form::Energy(terms) => terms.iter().any(|w| w.inclusion.is_some()),
    }
}

fn line<T>(weighted: &Weighted<T>, function: &Term) -> String {
    let sign = if weighted.coefficient < 0.0 { '-' } else { '+' };
    let number = with_error(weighted.coefficient.abs(), weighted.std_error);
    let share = weighted.inclusion.map(|share| format!("  ({:.0} %)", 100.0 * share));
    format!("  {sign} {number} * {}{}", function.name(), share.unwrap_or_default())
}

/// The equations as a LaTeX `align*` environment.
pub fn latex(model: &Model) -> String {
    let mut rows = Vec::new();
    if let Form::Energy(terms) = &model.form {
        for (place, terms) in by_place(terms) {
            let name = match place {
                Place::Potential => "V".to_owned(),
                Place::Inertia(i, j) => format!("M_{{{},{}}}", i + 1, j + 1),
            };
            let sum = terms.iter().map(|w| (w.coefficient, w.std_error, &w.term.function));
            rows.push(latex_row(&name, sum));
        }
    }
    for (joint, equation) in weighted_equations(model).iter().enumerate() {
        let sum = equation.iter().map(|w| (w.coefficient, w.std_error, &w.term));
        rows.push(latex_row(&format!(r"\tau_{{{}}}", joint + 1), sum));
    }
    format!("\\begin{{align*}}\n{}\n\\end{{align*}}\n", rows.join(" \\\\\n"))
}

/// Terms to a line, so that long equations stay on the page.
const TERMS_PER_LINE: usize = 4;

fn latex_row<'a>(name: &str, sum: impl Iterator<Item = (f64, f64, &'a Term)>) -> String {
    let mut text = format!("{name} ={{}}& ");
    let mut empty = true;
    for (place, (coefficient, std_error, term)) in sum.enumerate() {
        if place > 0 && place % TERMS_PER_LINE == 0 {
            text.push_str(" \\\\\n & \\quad ");
        }
        let sign = match (coefficient < 0.0, empty) {
            (true, _) => "-",
            (false, true) => "",
            (false, false) => "+",
        };
        let decimals = decimals(coefficient, std_error);
        // Writing to a String cannot fail.
        let _ = write!(text, "{sign} {:.decimals$}\\,{} ", coefficient.abs(), term.latex());
        empty = false;
    }
    if empty {
        text.push('0');
    }
    text.trim_end().to_owned()
}

/// Energy terms grouped: M₁₁, M₁₂, … then V.
fn by_place(terms: &[Weighted<EnergyTerm>]) -> Vec<(Place, Vec<&Weighted<EnergyTerm>>)> {
    let mut groups: BTreeMap<Place, Vec<&Weighted<EnergyTerm>>> = BTreeMap::new();
    for weighted in terms {
        groups.entry(weighted.term.place).or_default().push(weighted);
    }
    let (potential, inertia): (Vec<_>, Vec<_>) =
        groups.into_iter().partition(|(place, _)| *place == Place::Potential);
    inertia.into_iter().chain(potential).collect()
}

/// The torque equations with a standard error for each weight. Where an energy term is the only
/// source of a torque term, that is the error of its coefficient scaled; where several meet, their
/// errors are taken as independent.
pub fn weighted_equations(model: &Model) -> Vec<Vec<Weighted<Term>>> {
    let terms = match &model.form {
        Form::Torque(joints) => return joints.clone(),
        Form::Energy(terms) => terms,
    };
    (0..model.n_joints())
        .map(|joint| {
            let mut sums: BTreeMap<Term, (f64, f64)> = BTreeMap::new();
            for w in terms {
                for (weight, term) in w.term.torque(joint) {
                    let sum = sums.entry(term).or_insert((0.0, 0.0));
                    sum.0 += weight * w.coefficient;
                    sum.1 += (weight * w.std_error).powi(2);
                }
            }
            let mut equation: Vec<Weighted<Term>> = sums
                .into_iter()
                .filter(|(_, (coefficient, _))| *coefficient != 0.0)
                .map(|(term, (coefficient, variance))| Weighted {
                    term,
                    coefficient,
                    std_error: variance.sqrt(),
                    inclusion: None,
                })
                .collect();
            equation.sort_by_key(|w| std::cmp::Reverse(w.term.kind()));
            equation
        })
        .collect()
}
