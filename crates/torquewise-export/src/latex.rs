//! A LaTeX document of the equations of a model.

use crate::parts::elements;
use torquewise_model::selection::Selection;
use torquewise_model::{Form, Model, print};

/// A document that compiles by itself: energies and what follows from them, or the torque of each
/// joint.
pub fn to_latex(model: &Model, version: &str) -> String {
    let name = |(joint, name): (usize, &String)| format!("${joint}$ {}", escaped(name));
    let names: Vec<String> = (1..).zip(&model.joints).map(name).collect();
    let (equations, derived) = match model.form {
        Form::Energy(_) => (print::latex_energies(model), DERIVED),
        Form::Torque(_) => (print::latex(model, &Selection::default()), ""),
    };
    let memory = if elements(&model.friction).is_empty() { "" } else { DAHL };
    let is_load_dependent = model.friction.iter().any(|weighted| weighted.term.load);
    let load = if is_load_dependent { LOAD } else { "" };
    format!(
        "\\documentclass[a4paper]{{article}}\n\\usepackage[margin=2cm]{{geometry}}\n\
         \\usepackage[utf8]{{inputenc}}\n\\usepackage[T1]{{fontenc}}\n\
         \\usepackage{{amsmath}}\n\\allowdisplaybreaks\n\\begin{{document}}\n\
         \\noindent {}. SI units. Joints: {}.\n{derived}{equations}{load}{memory}\
         \\end{{document}}\n",
        escaped(version),
        names.join(", ")
    )
}

const DERIVED: &str = "\\begin{equation*}\n\
    \\tau = M(q)\\,\\ddot q + \\dot M(q)\\,\\dot q - \
    \\tfrac{1}{2}\\frac{\\partial}{\\partial q}\\bigl(\\dot q^{\\top} M(q)\\,\\dot q\\bigr) + \
    \\frac{\\partial V}{\\partial q} + F(q, \\dot q)\n\\end{equation*}\n";

const LOAD: &str = "\\noindent $G_j$ is the torque that gravity and springs load joint $j$ with: \
    what its equation holds in $q$ alone.\n\n";

const DAHL: &str = "\\noindent $x_\\delta(q)$ is the state of a Dahl element with travel \
    $\\delta$, zero at the start:\n\\begin{equation*}\n\
    \\mathrm{d}x_\\delta = \\frac{\\mathrm{d}q}{\\delta} - \
    \\frac{|\\mathrm{d}q|}{\\delta}\\,x_\\delta\n\\end{equation*}\n";

/// Text in which LaTeX finds no commands.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for letter in text.chars() {
        match letter {
            '\\' => escaped.push_str("\\textbackslash{}"),
            '~' => escaped.push_str("\\textasciitilde{}"),
            '^' => escaped.push_str("\\textasciicircum{}"),
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => escaped.extend(['\\', letter]),
            letter if letter.is_control() => escaped.push(' '),
            ' '..='~' | 'À'..='Ö' | 'Ø'..='ö' | 'ø'..='ÿ' => escaped.push(letter),
            // What the fonts of a plain pdflatex lack stops it.
            letter => escaped.extend(format!("[U+{:04X}]", u32::from(letter)).chars()),
        }
    }
    escaped
}
