//! Equations to read, as plain text and LaTeX, with the digits that mean something.

use crate::friction;
use crate::selection::{Selection, shortest};
use crate::shaft_friction::{Estimated, ShaftFriction};
use crate::{EnergyTerm, Form, FrictionTerm, Kind, Model, Place, Term, Weighted, units};
use std::collections::BTreeMap;

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

/// A sum with its name, ready to be printed.
struct Equation {
    /// As in `M12`, and as in `M_{1,2}`.
    name: String,
    latex: String,
    terms: Vec<Weighted<Term>>,
    friction: Vec<Weighted<FrictionTerm>>,
}

impl Equation {
    fn len(&self) -> usize {
        self.terms.len() + self.friction.len()
    }
}

/// Terms of all torques above which they are printed only where some are asked for.
const MANY_TERMS: usize = 300;

/// The equations as text: energies first where the model has them, then the torque of each joint,
/// its friction last. A shaft of more than linear friction is named, such as `F2(dq2)`; its laws stand
/// at the end, and its parameters in [`friction_tables`].
///
/// Angles are added up, as in `sin(q1 + q2)`, where that is shorter. Behind a term stands the share
/// of resampled logs in which it stays, where that was asked for.
pub fn text(model: &Model, selection: &Selection) -> String {
    let mut lines = Vec::new();
    let in_form = match &model.form {
        Form::Torque(joints) => joints.iter().flatten().any(|w| w.inclusion.is_some()),
        Form::Energy(terms) => terms.iter().any(|w| w.inclusion.is_some()),
    };
    let has_inclusion = in_form || model.friction.iter().any(|w| w.inclusion.is_some());
    let share = if has_inclusion { " (share of resampled logs that keep the term)" } else { "" };
    let (energies, mut left_out) = energies(model, selection);
    if energies.is_empty() {
        lines.push(format!("Torques in SI units, ± standard error{share}"));
    } else {
        lines.extend(energy_lines(&energies, share));
        let has_friction = !model.friction.is_empty() && selection.has_part(Kind::Friction);
        let friction = if has_friction { " + friction" } else { "" };
        lines.push(format!("Torques that follow: tau = d/dt dT/d(dq) - dT/dq + dV/dq{friction}"));
    }
    let (torques, also) = torques(model, selection);
    let terms: usize = torques.iter().map(|(_, equation)| equation.len()).sum();
    let is_asked_for = *selection != Selection::default();
    if terms > MANY_TERMS && !energies.is_empty() && !is_asked_for {
        lines.push(format!(
            "{terms} terms: ask for a joint, a part, the largest or all to see them"
        ));
    } else {
        left_out += also;
        let shafts = ShaftFriction::all(model);
        for (joint, equation) in &torques {
            lines.push(String::new());
            lines.push(format!("{} = [{}]", equation.name, model.joints[*joint]));
            if equation.len() == 0 {
                lines.push("    0".into());
            }
            lines.extend(equation.terms.iter().map(|w| line(w, &w.term.name())));
            if !equation.friction.is_empty() {
                lines.push("  friction:".into());
                let own = |shaft| friction_lines(shaft, *joint, &equation.friction);
                lines.extend(shafts.iter().flat_map(own));
            }
        }
    }
    if selection.has_part(Kind::Friction) {
        lines.extend(law_lines(model, selection));
        let words = friction::legend(&lines);
        lines.extend(words.into_iter().flat_map(|words| [String::new(), words]));
    }
    if left_out > 0 {
        lines.push(String::new());
        let (terms, are) = if left_out == 1 { ("term", "is") } else { ("terms", "are") };
        let why = if selection.top.is_some() { "" } else { ", below 2 standard errors" };
        lines.push(format!("{left_out} {terms} {are} not shown{why}; ask for `all` to see them"));
    }
    lines.join("\n") + "\n"
}

fn energy_lines(energies: &[Equation], share: &str) -> Vec<String> {
    let mut lines = vec!["Energies: T = 1/2 dq' M(q) dq and V(q)".to_owned()];
    lines.push(format!("SI units, ± standard error{share}"));
    for equation in energies {
        lines.push(String::new());
        lines.push(format!("{} =", equation.name));
        lines.extend(equation.terms.iter().map(|w| line(w, &w.term.name())));
    }
    lines.push(String::new());
    lines
}

/// M and V, and how many of their terms are left out; none of a model of torques.
fn energies(model: &Model, selection: &Selection) -> (Vec<Equation>, usize) {
    let Form::Energy(terms) = &model.form else { return (Vec::new(), 0) };
    let mut left_out = 0;
    let groups =
        weighted_energies(terms).into_iter().filter(|(place, _)| selection.has_energy(*place));
    let equations = groups
        .map(|(place, terms)| {
            let (terms, more) = selection.of(shortest(terms, model.chain.is_some()));
            left_out += more;
            Equation { name: place.name(), latex: place.latex(), terms, friction: Vec::new() }
        })
        .filter(|equation| !equation.terms.is_empty())
        .collect();
    (equations, left_out)
}

/// The torque of each joint, counted from 0, and how many terms are left out.
fn torques(model: &Model, selection: &Selection) -> (Vec<(usize, Equation)>, usize) {
    let mut left_out = 0;
    let equations = weighted_equations(model).into_iter().zip(weighted_friction(model));
    let equation = |(joint, (mut terms, friction)): (usize, (Vec<Weighted<Term>>, Vec<_>))| {
        terms.retain(|weighted| selection.has_part(weighted.term.kind()));
        let (terms, more) = selection.of(shortest(terms, model.chain.is_some()));
        left_out += more;
        let friction = if selection.has_part(Kind::Friction) { friction } else { Vec::new() };
        let (name, latex) = (format!("tau{}", joint + 1), format!(r"\tau_{{{}}}", joint + 1));
        (joint, Equation { name, latex, terms, friction })
    };
    let wanted = equations.enumerate().filter(|(joint, _)| selection.has_joint(*joint));
    (wanted.map(equation).collect(), left_out)
}

/// What the names of shafts in the equations stand for, law by law.
fn law_lines(model: &Model, selection: &Selection) -> Vec<String> {
    let mut lines = Vec::new();
    for shaft in ShaftFriction::all(model) {
        let turns = |joint: usize| selection.has_joint(joint) && shaft.shaft()[joint] != 0.0;
        let Some(symbol) = shaft.symbol().filter(|_| (0..model.n_joints()).any(turns)) else {
            continue;
        };
        lines.extend([String::new(), format!("{symbol} = [{}]", shaft.name())]);
        lines.extend(shaft.laws().map(|(k, term)| line(&model.friction[k], &term.formula())));
    }
    lines
}

/// What a shaft adds to the torque of a joint: its laws where they are linear, else its name.
fn friction_lines(
    shaft: &ShaftFriction<'_>,
    joint: usize,
    friction: &[Weighted<FrictionTerm>],
) -> Vec<String> {
    let own = friction.iter().filter(|w| w.term.shaft == shaft.shaft());
    let part = shaft.shaft()[joint];
    match shaft.symbol() {
        None => own.map(|w| line(w, &w.term.formula())).collect(),
        Some(_) if part == 0.0 => Vec::new(),
        Some(symbol) => {
            let sign = if part < 0.0 { '-' } else { '+' };
            let is_one = (part.abs() - 1.0).abs() < f64::EPSILON;
            let factor = if is_one { String::new() } else { format!("{} * ", part.abs()) };
            vec![format!("  {sign} {factor}{symbol}")]
        }
    }
}

/// Friction as engineers read it, as rows of cells under headings: how each shaft slides, then what
/// else there is to say; none for a model without. What no shaft has is left out, a dash stands for
/// what is not resolved.
pub fn friction_tables(model: &Model) -> Vec<Vec<Vec<String>>> {
    let row = |words: &[&str], numbers: [Option<Estimated>; 4]| {
        let cell = |number: Option<Estimated>| {
            number.map_or_else(|| DASH.to_owned(), |own| with_error(own.value, own.std_error))
        };
        words.iter().map(ToString::to_string).chain(numbers.map(cell)).collect::<Vec<String>>()
    };
    let kinds = model.kinds();
    let headings =
        |headings: &[&str]| headings.iter().map(|text| units::heading(&kinds, text)).collect();
    let sliding = ["F_c [N·m]", "F_s [N·m]", "v_s [rad/s]", "F_v [N·m·s/rad]"];
    let other = ["offset [N·m]", "stiffness [N·m/rad]", "travel [rad]", "load factor [1]"];
    let mut tables: [Vec<Vec<String>>; 2] = [
        vec![headings(&[&["joint", "direction"], &sliding[..]].concat())],
        vec![headings(&[&["joint"], &other[..]].concat())],
    ];
    for shaft in ShaftFriction::all(model) {
        let (name, own) = (shaft.name(), shaft.parameters());
        let ways = if own.forward == own.backward {
            vec![("both", own.forward)]
        } else {
            vec![("forward", own.forward), ("backward", own.backward)]
        };
        for (way, own) in ways {
            let numbers = [own.coulomb, own.stiction, own.stribeck_speed, own.viscous];
            tables[0].push(row(&[&name, way], numbers));
        }
        let numbers = [own.offset, own.stiffness, own.travel, own.load_factor];
        tables[1].push(row(&[&name], numbers));
    }
    let has_number =
        |table: &Vec<Vec<String>>| table[0].iter().any(|heading| heading.contains('['));
    // The columns that have more than a heading and dashes.
    let without_dashes = |table: &Vec<Vec<String>>| -> Vec<Vec<String>> {
        let is_kept = |column: &usize| table.iter().skip(1).any(|row| row[*column] != DASH);
        let kept: Vec<usize> = (0..table[0].len()).filter(is_kept).collect();
        table.iter().map(|row| kept.iter().map(|&column| row[column].clone()).collect()).collect()
    };
    tables.iter().map(without_dashes).filter(has_number).collect()
}

/// For what is not resolved.
pub(crate) const DASH: &str = "–";

fn line<T>(weighted: &Weighted<T>, function: &str) -> String {
    let sign = if weighted.coefficient < 0.0 { '-' } else { '+' };
    let number = with_error(weighted.coefficient.abs(), weighted.std_error);
    let share = weighted.inclusion.map(|share| format!("  ({:.0} %)", 100.0 * share));
    let function = if function == "1" { String::new() } else { format!(" * {function}") };
    format!("  {sign} {number}{function}{}", share.unwrap_or_default())
}

/// The equations as a LaTeX `align*` environment: energies, then torques.
pub fn latex(model: &Model, selection: &Selection) -> String {
    let (energies, _) = energies(model, selection);
    let torques = torques(model, selection).0.into_iter().map(|(_, equation)| equation);
    let all: Vec<Equation> = energies.into_iter().chain(torques).collect();
    latex_align(&all.iter().map(latex_row).collect::<Vec<_>>())
}

/// M(q), V(q) and the friction of each joint as a LaTeX `align*` environment, without the torques
/// that follow, which may be a hundred times as long; a model of torques has friction alone.
pub fn latex_energies(model: &Model) -> String {
    let (mut all, _) = energies(model, &Selection::default());
    all.extend(weighted_friction(model).into_iter().enumerate().map(|(joint, friction)| {
        let (name, latex) = (String::new(), format!("F_{{{}}}", joint + 1));
        Equation { name, latex, terms: Vec::new(), friction }
    }));
    latex_align(&all.iter().map(latex_row).collect::<Vec<_>>())
}

fn latex_align(rows: &[String]) -> String {
    format!("\\begin{{align*}}\n{}\n\\end{{align*}}\n", rows.join(" \\\\\n"))
}

/// Letters to a line, so that long equations stay on the page.
const LETTERS_PER_LINE: usize = 80;

/// A sum and the friction that adds to it, which starts a line of its own.
fn latex_row(equation: &Equation) -> String {
    let sum: Vec<_> = equation.terms.iter().map(|w| signed(w, &w.term.latex())).collect();
    let friction: Vec<_> = equation.friction.iter().map(|w| signed(w, &w.term.latex())).collect();
    let text = [latex_lines(&sum), latex_lines(&friction)].concat().join(" \\\\\n & \\quad ");
    // No sign before a sum that begins with +.
    let text = text.strip_prefix("+ ").unwrap_or(if text.is_empty() { "0" } else { &text });
    format!("{} ={{}}& {text}", equation.latex)
}

/// As many terms to a line as it holds, one at least.
fn latex_lines(terms: &[String]) -> Vec<String> {
    let is_seen = |letter: &char| !"\\{}_^,".contains(*letter);
    let mut lines: Vec<String> = Vec::new();
    let mut left = 0;
    for term in terms {
        let letters = term.chars().filter(is_seen).count();
        if let Some(line) = lines.last_mut().filter(|_| letters <= left) {
            line.push(' ');
            line.push_str(term);
            left -= letters;
        } else {
            lines.push(term.clone());
            left = LETTERS_PER_LINE.saturating_sub(letters);
        }
    }
    lines
}

/// Sign, coefficient with its error, and function.
fn signed<T>(weighted: &Weighted<T>, function: &str) -> String {
    let sign = if weighted.coefficient < 0.0 { '-' } else { '+' };
    let number = with_error(weighted.coefficient.abs(), weighted.std_error);
    let number = match number.split_once(" ± ") {
        Some((value, error)) => format!(r"({value} \pm {error})"),
        None => number,
    };
    let space = if function.is_empty() { "" } else { r"\," };
    format!("{sign} {number}{space}{function}")
}

/// Energy terms grouped: M₁₁, M₁₂, … then V.
pub fn weighted_energies(terms: &[Weighted<EnergyTerm>]) -> Vec<(Place, Vec<Weighted<Term>>)> {
    let mut groups: BTreeMap<Place, Vec<Weighted<Term>>> = BTreeMap::new();
    for Weighted { term, coefficient, std_error, inclusion } in terms.iter().cloned() {
        let own = Weighted { term: term.function, coefficient, std_error, inclusion };
        groups.entry(term.place).or_default().push(own);
    }
    let (potential, inertia): (Vec<_>, Vec<_>) =
        groups.into_iter().partition(|(place, _)| *place == Place::Potential);
    inertia.into_iter().chain(potential).collect()
}

/// The torque equations with a standard error for each weight, inertia first where the model has
/// energies.
pub fn weighted_equations(model: &Model) -> Vec<Vec<Weighted<Term>>> {
    let mut equations = model.form.weighted(model.n_joints());
    if matches!(model.form, Form::Energy(_)) {
        for equation in &mut equations {
            equation.sort_by_key(|w| std::cmp::Reverse(w.term.kind()));
        }
    }
    equations
}

/// The friction of each joint, with the coefficients and errors its shafts hand on to it.
pub fn weighted_friction(model: &Model) -> Vec<Vec<Weighted<FrictionTerm>>> {
    let of_joint = |joint: usize| {
        let share = |w: &Weighted<FrictionTerm>| {
            let shaft = w.term.shaft[joint];
            let (coefficient, std_error) = (shaft * w.coefficient, shaft.abs() * w.std_error);
            Weighted { coefficient, std_error, ..w.clone() }
        };
        model.friction.iter().filter(|w| w.term.acts_on(joint)).map(share).collect()
    };
    (0..model.n_joints()).map(of_joint).collect()
}
