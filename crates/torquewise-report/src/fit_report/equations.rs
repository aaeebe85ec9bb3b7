//! Equations: energies first where the model has them, then the torque of each joint.

use crate::html::equation::{Equation, energies, math};
use crate::{Findings, Item, Section, count};
use std::collections::BTreeMap;
use torquewise_model::print::{weighted_equations, weighted_friction};
use torquewise_model::{Form, FrictionLaw, FrictionTerm, Term, Weighted};

/// Terms of one equation written out at most; no one reads more.
const MOST_TERMS: usize = 200;
/// An equation of more terms is folded.
const LONG: usize = 60;

pub(crate) fn section(findings: &Findings<'_>) -> Section {
    let model = &findings.found.model;
    let mut items = Vec::new();
    let torques = torques(findings);
    if let Form::Energy(terms) = &model.form {
        items.push(Item::Text(
            "T = ½ q̇ᵀ M(q) q̇ and V(q), in SI units. Grey numbers are standard errors; a share in \
             percent is that of the resampled logs in which a term was kept, where not in all. \
             M is symmetric: what is not listed is zero, or the same as its mirror image."
                .into(),
        ));
        let shown = energies(terms).into_iter().map(|energy| largest(energy, &BTreeMap::new()));
        let shown = shown.chain(frictions(findings)).map(written).collect();
        match model.n_coefficients() {
            0..=LONG => items.extend(shown),
            many => items.push(Item::Details {
                summary: format!("M(q), V(q) and friction, {} terms", count(many)),
                items: shown,
            }),
        }
        let friction = if model.friction.is_empty() { "" } else { " + friction" };
        items.push(Item::Details {
            summary: format!("The torques that follow: τ = d/dt ∂T/∂q̇ − ∂T/∂q + ∂V/∂q{friction}"),
            items: torques.into_iter().map(written).collect(),
        });
    } else {
        items.push(Item::Text(
            "The torque of each joint, in SI units. Grey numbers are standard errors.".into(),
        ));
        items.extend(torques.into_iter().map(written));
    }
    let remembers = |own: &Weighted<FrictionTerm>| matches!(own.term.law, FrictionLaw::Dahl { .. });
    if model.friction.iter().any(|own| own.term.load || remembers(own)) {
        items.push(Item::Text(
            "Of friction, x is the state of a Dahl element with its travel below, ±1 after a long way: \
             dry friction that turns over along that travel; |G| is the load of gravity and springs on \
             that joint [N·m]."
                .into(),
        ));
    }
    Section { heading: "Equations".into(), items }
}

fn written(equation: Equation) -> Item {
    let n_terms = equation.terms.len() + equation.friction.len() + equation.left_out;
    let summary = format!("{}, {} terms", equation.name, count(n_terms));
    let item = Item::Equation(equation);
    if n_terms <= LONG { item } else { Item::Details { summary, items: vec![item] } }
}

fn frictions(findings: &Findings<'_>) -> Vec<Equation> {
    let model = &findings.found.model;
    let unit = |joint| model.kinds().of(joint).effort_unit;
    let equation = |(joint, friction): (usize, Vec<_>)| Equation {
        name: format!("Friction of {}", model.joints[joint]),
        left: math(&format!("F_{{{}}}=", joint + 1)),
        note: format!("friction of {} [{}]", model.joints[joint], unit(joint)),
        friction,
        ..Equation::default()
    };
    let rubbing = weighted_friction(model).into_iter().enumerate();
    rubbing.filter(|(_, friction)| !friction.is_empty()).map(equation).collect()
}

fn torques(findings: &Findings<'_>) -> Vec<Equation> {
    let model = &findings.found.model;
    let unit = |joint| model.kinds().of(joint).effort_unit;
    let equation = |(joint, (terms, friction)): (usize, (Vec<Weighted<Term>>, _))| {
        let importance = &findings.diagnosis.importance[joint];
        let sizes = importance.iter().map(|term| (term.name.as_str(), term.rms)).collect();
        let all = Equation {
            name: format!("Torque of {}", model.joints[joint]),
            left: math(&format!(r"\tau_{{{}}}=", joint + 1)),
            note: format!("{} [{}]", model.joints[joint], unit(joint)),
            terms,
            friction,
            ..Equation::default()
        };
        largest(all, &sizes)
    };
    let friction = weighted_friction(model);
    weighted_equations(model).into_iter().zip(friction).enumerate().map(equation).collect()
}

/// The terms that matter most, in their order: by their share of the torque where it is known, else
/// by their coefficients.
fn largest(mut equation: Equation, sizes: &BTreeMap<&str, f64>) -> Equation {
    let surplus = equation.terms.len().saturating_sub(MOST_TERMS);
    if surplus == 0 {
        return equation;
    }
    let size = |weighted: &Weighted<Term>| {
        let known = sizes.get(weighted.term.name().as_str()).copied();
        known.unwrap_or_else(|| weighted.coefficient.abs())
    };
    let mut ranked: Vec<(usize, f64)> = equation.terms.iter().map(size).enumerate().collect();
    ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut kept: Vec<usize> = ranked[..MOST_TERMS].iter().map(|(place, _)| *place).collect();
    kept.sort_unstable();
    equation.terms = kept.into_iter().map(|place| equation.terms[place].clone()).collect();
    equation.left_out = surplus;
    equation
}

#[cfg(test)]
mod tests {
    use super::*;
    use torquewise_model::Trig;

    #[test]
    fn a_long_equation_keeps_its_largest_terms_in_their_order() {
        let term = |k: usize| {
            let sine = Term::one(1).times(Trig::Sin, 0, i8::try_from(k % 100).unwrap(), 1);
            Weighted::new(sine, k as f64)
        };
        let terms = (0..MOST_TERMS + 3).map(term).collect();
        let all = Equation { terms, ..Equation::default() };

        let shown = largest(all, &BTreeMap::new());

        assert_eq!((shown.terms.len(), shown.left_out), (MOST_TERMS, 3));
        assert!((shown.terms[0].coefficient - 3.0).abs() < f64::EPSILON);
        assert!(shown.terms.windows(2).all(|pair| pair[0].coefficient < pair[1].coefficient));
    }
}
