//! Terms and weights → MathML: equations to read in a browser, with the digits that mean something.

use crate::html::Markup;
use crate::html::markup::escape;
use crate::html::number::{aligned, count};
use std::collections::BTreeMap;
use std::fmt::Write;
use torquewise_model::print::with_error;
use torquewise_model::term::Factor;
use torquewise_model::{EnergyTerm, Kind, Place, Term, Trig, Weighted};

/// A sum with its left side, before it is written.
#[derive(Clone, Debug, PartialEq)]
pub struct Equation {
    /// Its name in plain text.
    pub name: String,
    /// What the sum is, as made by [`place`] or [`torque`].
    pub left: Markup,
    /// Words beside the left side: a joint's name, a unit; may be empty.
    pub note: String,
    /// Its terms, in the order in which they are to be read.
    pub terms: Vec<Weighted<Term>>,
    /// Unit of the coefficients; `None` for that of a torque, by the kind of each term.
    pub unit: Option<&'static str>,
    /// Smaller terms that are not shown.
    pub left_out: usize,
}

impl Equation {
    /// The equation as HTML, one term to a line, with signs and decimal points below each other.
    ///
    /// Each coefficient has the digits its standard error leaves standing; error, unit and share of
    /// resampled logs stand beside it in small type or appear when it is pointed at.
    pub fn to_markup(&self) -> Markup {
        let name = escape(&self.name);
        let mut html = format!("<div class=\"equation\" role=\"group\" aria-label=\"{name}\">");
        push(&mut html, format_args!("<div class=\"left\">{}", self.left));
        if !self.note.is_empty() {
            push(&mut html, format_args!("<small>{}</small>", escape(&self.note)));
        }
        let numbers: Vec<[String; 2]> = self.terms.iter().map(number_and_error).collect();
        let coefficients: Vec<String> = numbers.iter().map(|[number, _]| number.clone()).collect();
        let coefficients = aligned(&coefficients);
        let widest = coefficients.iter().map(|text| text.chars().count()).max().unwrap_or(1);
        // The sign ± and a space stand before the error.
        let errors = numbers.iter().map(|[_, error]| error.chars().count());
        let wide = errors.max().filter(|&n| n > 0).map_or(0, |n| n + 2);
        push(
            &mut html,
            format_args!("</div><div class=\"sum\" style=\"--w:{widest};--e:{wide}\">"),
        );
        if self.terms.is_empty() {
            html.push_str(
                "<div class=\"term\"><span></span><span class=\"coefficient\">0</span></div>",
            );
        }
        for ((weighted, coefficient), [_, error]) in
            self.terms.iter().zip(&coefficients).zip(&numbers)
        {
            self.push_term(&mut html, weighted, coefficient, error);
        }
        html.push_str("</div>");
        if self.left_out > 0 {
            let n = count(self.left_out);
            push(&mut html, format_args!("<div class=\"rest\">and {n} smaller terms</div>"));
        }
        html.push_str("</div>");
        Markup::trusted(html)
    }

    fn push_term(
        &self,
        html: &mut String,
        weighted: &Weighted<Term>,
        coefficient: &str,
        error: &str,
    ) {
        let sign = if weighted.coefficient < 0.0 { "−" } else { "+" };
        let unit = self.unit.unwrap_or_else(|| unit_of(&weighted.term));
        let number = coefficient.trim_end_matches(['\u{2007}', '\u{2008}']);
        let mut title = format!("{sign}{number} {unit}");
        if !error.is_empty() {
            push(&mut title, format_args!(", standard error {error}"));
        }
        let mut kept = String::new();
        if let Some(inclusion) = weighted.inclusion {
            let percent = 100.0 * inclusion;
            push(&mut title, format_args!(", stayed in {percent:.0} % of resampled logs"));
            if inclusion < CERTAIN {
                kept = format!(" <span class=\"kept\">in {percent:.0} %</span>");
            }
        }
        let error = if error.is_empty() { String::new() } else { format!("± {error}") };
        push(
            html,
            format_args!(
                "<div class=\"term\" title=\"{}\"><span class=\"sign\">{sign}</span>\
                 <span class=\"coefficient\">{coefficient}</span>\
                 <span class=\"error\">{error}</span><span>{}{kept}</span></div>",
                escape(&title),
                function_of(&weighted.term)
            ),
        );
    }
}

/// The function a coefficient stands before; nothing for the constant 1.
fn function_of(function: &Term) -> String {
    let is_one = function.interaction() == 0 && function.kind() == Kind::Gravity;
    if is_one { String::new() } else { term(function).to_string() }
}

/// A share of resampled logs above this needs no mention: the term is always there.
const CERTAIN: f64 = 0.995;

/// The equations of an energy: M₁₁, M₁₂, …, then V.
pub fn energies(terms: &[Weighted<EnergyTerm>]) -> Vec<Equation> {
    let mut groups: BTreeMap<Place, Vec<Weighted<Term>>> = BTreeMap::new();
    for weighted in terms {
        groups.entry(weighted.term.place).or_default().push(Weighted {
            term: weighted.term.function.clone(),
            coefficient: weighted.coefficient,
            std_error: weighted.std_error,
            inclusion: weighted.inclusion,
        });
    }
    let (potential, inertia): (Vec<_>, Vec<_>) =
        groups.into_iter().partition(|(place, _)| *place == Place::Potential);
    let equation = |(at, terms): (Place, Vec<Weighted<Term>>)| {
        let unit = if at == Place::Potential { "J" } else { "kg·m²" };
        let (name, note) = (at.name(), format!("[{unit}]"));
        Equation { name, left: place(at), note, terms, unit: Some(unit), left_out: 0 }
    };
    inertia.into_iter().chain(potential).map(equation).collect()
}

/// M₁₂ = or V =, joints counted from 1.
pub fn place(place: Place) -> Markup {
    let name = match place {
        Place::Potential => "<mi>V</mi>".to_owned(),
        Place::Inertia(i, j) if i < 9 && j < 9 => {
            format!("<msub><mi>M</mi><mn>{}{}</mn></msub>", i + 1, j + 1)
        }
        Place::Inertia(i, j) => {
            let (i, j) = (i + 1, j + 1);
            format!("<msub><mi>M</mi><mrow><mn>{i}</mn><mo>,</mo><mn>{j}</mn></mrow></msub>")
        }
    };
    math(&format!("{name}<mo>=</mo>"))
}

/// τ₂ =, for the joint at a place counted from 0.
pub fn torque(joint: usize) -> Markup {
    math(&format!("<msub><mi>τ</mi><mn>{}</mn></msub><mo>=</mo>", joint + 1))
}

/// A term: sin q₂ cos² q₃ q̇₁ q̇₂.
pub fn term(term: &Term) -> Markup {
    let mut parts: Vec<String> = term.factors.iter().map(factor).collect();
    for (dots, powers) in [(DOT, &term.dq), (TWO_DOTS, &term.ddq)] {
        for (joint, &power) in powers.iter().enumerate().filter(|&(_, &power)| power > 0) {
            parts.push(rate(dots, joint, power));
        }
    }
    if parts.is_empty() {
        return math("<mn>1</mn>");
    }
    math(&parts.join("<mspace width=\"0.2em\"/>"))
}

fn factor(factor: &Factor) -> String {
    let name = match factor.function {
        Trig::Sin => "sin",
        Trig::Cos => "cos",
    };
    let function = match factor.power {
        1 => format!("<mi>{name}</mi>"),
        power => format!("<msup><mi>{name}</mi><mn>{power}</mn></msup>"),
    };
    let multiples: Vec<(usize, i8)> =
        factor.multiples.iter().copied().enumerate().filter(|&(_, k)| k != 0).collect();
    let angle = angle(&multiples);
    match multiples.as_slice() {
        [(_, 1)] => format!("{function}<mspace width=\"0.15em\"/>{angle}"),
        _ => format!("{function}<mo stretchy=\"false\">(</mo>{angle}<mo stretchy=\"false\">)</mo>"),
    }
}

/// q₂, 2q₂, q₂ + q₃.
fn angle(multiples: &[(usize, i8)]) -> String {
    let mut text = String::new();
    for (place, &(joint, k)) in multiples.iter().enumerate() {
        match (k < 0, place) {
            (true, _) => text.push_str("<mo>−</mo>"),
            (false, 0) => {}
            (false, _) => text.push_str("<mo>+</mo>"),
        }
        if k.unsigned_abs() > 1 {
            push(&mut text, format_args!("<mn>{}</mn>", k.unsigned_abs()));
        }
        push(&mut text, format_args!("<msub><mi>q</mi><mn>{}</mn></msub>", joint + 1));
    }
    text
}

/// Combining marks sit right in any font; an accent of MathML only in one made for mathematics.
const DOT: char = '\u{307}';
const TWO_DOTS: char = '\u{308}';
/// What a lone q in MathML looks like.
const ITALIC_Q: char = '\u{1d45e}';

fn rate(dots: char, joint: usize, power: u8) -> String {
    let q = format!("<mi>{ITALIC_Q}{dots}</mi>");
    let joint = joint + 1;
    match power {
        1 => format!("<msub>{q}<mn>{joint}</mn></msub>"),
        power => format!("<msubsup>{q}<mn>{joint}</mn><mn>{power}</mn></msubsup>"),
    }
}

fn math(inner: &str) -> Markup {
    Markup::trusted(format!("<math>{inner}</math>"))
}

/// Size of a coefficient, and its standard error, both with the digits that mean something.
fn number_and_error<T>(weighted: &Weighted<T>) -> [String; 2] {
    let text = with_error(weighted.coefficient.abs(), weighted.std_error);
    match text.split_once(" ± ") {
        Some((number, error)) => [number.into(), error.into()],
        None => [text, String::new()],
    }
}

fn unit_of(term: &Term) -> &'static str {
    match (term.kind(), term.dq.iter().sum::<u8>()) {
        (Kind::Inertia, _) => "kg·m²",
        (_, 0) => "N·m",
        (_, 1) => "N·m·s",
        _ => "N·m·s²",
    }
}

/// Writing to a String cannot fail.
fn push(html: &mut String, text: std::fmt::Arguments<'_>) {
    let _ = html.write_fmt(text);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn equation(terms: Vec<Weighted<Term>>) -> Equation {
        let (name, note) = ("\"tau2".into(), "<elbow>".into());
        Equation { name, left: torque(1), note, terms, unit: None, left_out: 0 }
    }

    fn weighted(coefficient: f64, std_error: f64) -> Weighted<Term> {
        let term = Term::one(2).times(Trig::Sin, 1, 1, 1);
        Weighted { term, coefficient, std_error, inclusion: Some(0.84) }
    }

    #[test]
    fn a_term_is_written_factor_by_factor() {
        let product = Term::one(3).times(Trig::Cos, 2, 1, 2).times_dq(0).times_dq(0).times_ddq(1);

        let html = term(&product).to_string();

        let cosine = "<msup><mi>cos</mi><mn>2</mn></msup><mspace width=\"0.15em\"/>\
                      <msub><mi>q</mi><mn>3</mn></msub>";
        assert!(html.starts_with(&format!("<math>{cosine}")), "{html}");
        assert!(html.contains("<mi>𝑞̇</mi><mn>1</mn><mn>2</mn></msubsup>"), "{html}");
        assert!(html.ends_with("<mi>𝑞̈</mi><mn>2</mn></msub></math>"), "{html}");
        assert_eq!(term(&Term::one(1)).as_str(), "<math><mn>1</mn></math>");
    }

    #[test]
    fn a_sum_of_angles_stands_in_brackets() {
        let factor = Factor { multiples: vec![0, 1, -2], function: Trig::Sin, power: 1 };
        let sine = Term { factors: vec![factor], ..Term::one(3) };

        let html = term(&sine).to_string();

        let angle = "<msub><mi>q</mi><mn>2</mn></msub><mo>−</mo><mn>2</mn>\
                     <msub><mi>q</mi><mn>3</mn></msub>";
        assert!(html.contains(&format!("(</mo>{angle}<mo")), "{html}");
    }

    #[test]
    fn a_coefficient_shows_its_digits_error_and_share() {
        let html = equation(vec![weighted(-8.395_95, 0.003_14)]).to_markup().to_string();

        assert!(html.contains("<span class=\"sign\">−</span>"), "{html}");
        assert!(html.contains(">8.3960<") || html.contains(">8.3959<"), "{html}");
        assert!(html.contains("± 0.0031"), "{html}");
        assert!(html.contains("in 84 %"), "{html}");
        assert!(html.contains("N·m, standard error 0.0031"), "{html}");
    }

    #[test]
    fn notes_are_escaped_and_an_empty_sum_is_zero() {
        let html = equation(Vec::new()).to_markup().to_string();

        assert!(html.contains("<small>&lt;elbow&gt;</small>"), "{html}");
        assert!(html.contains("aria-label=\"&quot;tau2\""), "{html}");
        assert!(html.contains(">0</span>"), "{html}");
    }

    #[test]
    fn the_potential_stands_last() {
        let energy = |place| Weighted {
            term: EnergyTerm { place, function: Term::one(2) },
            coefficient: 1.0,
            std_error: 0.0,
            inclusion: None,
        };
        let places = [Place::Potential, Place::Inertia(1, 1), Place::Inertia(0, 1)].map(energy);

        let equations = energies(&places);

        let left: Vec<&str> = equations.iter().map(|equation| equation.left.as_str()).collect();
        assert!(left[0].contains("<mn>12</mn>") && left[1].contains("<mn>22</mn>"), "{left:?}");
        assert!(left[2].contains("<mi>V</mi>"), "{left:?}");
    }
}
