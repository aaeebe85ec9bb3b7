//! From terms and weights to MathML: equations to read in a browser, with the digits that mean
//! something.

use crate::html::Markup;
use crate::html::markup::escape;
use crate::html::number::{aligned, count};
use std::collections::BTreeMap;
use std::fmt::Write;
use torquewise_model::friction::{Direction, FrictionLaw};
use torquewise_model::print::with_error;
use torquewise_model::term::Factor;
use torquewise_model::{EnergyTerm, FrictionTerm, Kind, Place, Term, Trig, Weighted};

/// A sum with its left side, before it is written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Equation {
    /// Its name in plain text.
    pub name: String,
    /// What the sum is, as made by [`place`] or [`torque`].
    pub left: Markup,
    /// Words beside the left side: a joint's name, a unit; may be empty.
    pub note: String,
    /// Its terms, in the order in which they are to be read.
    pub terms: Vec<Weighted<Term>>,
    /// Friction that adds to them, set apart below them.
    pub friction: Vec<Weighted<FrictionTerm>>,
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
        let numbers: Vec<[String; 2]> = (self.terms.iter().map(number_and_error))
            .chain(self.friction.iter().map(number_and_error))
            .collect();
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
        if numbers.is_empty() {
            html.push_str(
                "<div class=\"term\"><span></span><span class=\"coefficient\">0</span></div>",
            );
        }
        let mut written =
            coefficients.iter().map(String::as_str).zip(numbers.iter().map(|[_, e]| e.as_str()));
        for (weighted, shown) in self.terms.iter().zip(&mut written) {
            let unit = self.unit.unwrap_or_else(|| unit_of(&weighted.term));
            push_term(&mut html, weighted, shown, unit, &function_of(&weighted.term));
        }
        if !self.friction.is_empty() && !self.terms.is_empty() {
            html.push_str("<div class=\"part\">friction</div>");
        }
        for (weighted, shown) in self.friction.iter().zip(&mut written) {
            let term = &weighted.term;
            push_term(&mut html, weighted, shown, friction_unit(term), friction(term).as_str());
        }
        html.push_str("</div>");
        if self.left_out > 0 {
            let n = count(self.left_out);
            push(&mut html, format_args!("<div class=\"rest\">and {n} smaller terms</div>"));
        }
        html.push_str("</div>");
        Markup::trusted(html)
    }
}

/// One line of a sum: sign, size and error as shown, and the function they stand before.
fn push_term<T>(
    html: &mut String,
    weighted: &Weighted<T>,
    (coefficient, error): (&str, &str),
    unit: &str,
    function: &str,
) {
    let sign = if weighted.coefficient < 0.0 { "−" } else { "+" };
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
             <span class=\"error\">{error}</span><span>{function}{kept}</span></div>",
            escape(&title),
        ),
    );
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
        Equation {
            name: at.name(),
            left: place(at),
            note: format!("[{unit}]"),
            terms,
            unit: Some(unit),
            ..Equation::default()
        }
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

/// F₂ =, the friction of the joint at a place counted from 0.
pub fn friction_torque(joint: usize) -> Markup {
    math(&format!("<msub><mi>F</mi><mn>{}</mn></msub><mo>=</mo>", joint + 1))
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

/// f(v) of a friction term: sign q̇₂, e^−(q̇₂/0.05)² sign q̇₂; nothing for an offset.
pub fn friction(term: &FrictionTerm) -> Markup {
    let speed = shaft(&term.shaft);
    let several = term.shaft.iter().filter(|shaft| **shaft != 0.0).count() > 1;
    let whole = if several { brackets(&speed) } else { speed.clone() };
    let sign = |width: f64| {
        if width > 0.0 {
            format!("<mi>tanh</mi>{}", brackets(&over(&whole, width)))
        } else {
            format!("<mi>sign</mi>{}", brackets(&speed))
        }
    };
    let law = match term.law {
        FrictionLaw::Offset => String::new(),
        FrictionLaw::Viscous => whole.clone(),
        FrictionLaw::Coulomb { width } => sign(width),
        FrictionLaw::Stribeck { speed: stribeck, width } => {
            let ratio = brackets(&over(&whole, stribeck));
            let square = format!("<mo>−</mo><msup><mrow>{ratio}</mrow><mn>2</mn></msup>");
            format!(
                "<msup><mi>e</mi><mrow>{square}</mrow></msup><mspace width=\"0.2em\"/>{}",
                sign(width)
            )
        }
        FrictionLaw::Dahl { travel } => {
            let joint = term.element().map_or(0, |(joint, _)| joint + 1);
            let angle = format!("<msub><mi>q</mi><mn>{joint}</mn></msub>");
            format!("<msub><mi>x</mi><mn>{travel}</mn></msub>{}", brackets(&angle))
        }
    };
    let load = match term.joint() {
        Some(joint) if term.load => format!(
            "<mspace width=\"0.2em\"/><mo>|</mo><msub><mi>G</mi><mn>{}</mn></msub><mo>|</mo>",
            joint + 1
        ),
        _ => String::new(),
    };
    let law = law + &load;
    let relation = match term.direction {
        Direction::Both if law.is_empty() => return Markup::trusted(String::new()),
        Direction::Both => return math(&law),
        Direction::Backward => "&lt;",
    };
    math(&format!(
        "{law}<mspace width=\"0.4em\"/><mo stretchy=\"false\">[</mo>{speed}<mo>{relation}</mo>\
         <mn>0</mn><mo stretchy=\"false\">]</mo>"
    ))
}

/// Its unit, as that of a coefficient.
fn friction_unit(term: &FrictionTerm) -> &'static str {
    match (term.law, term.load) {
        (FrictionLaw::Viscous, false) => "N·m·s",
        (FrictionLaw::Viscous, true) => "s",
        (_, false) => "N·m",
        (_, true) => "",
    }
}

/// The speed of a shaft: q̇₂, q̇₅ + q̇₆.
fn shaft(shaft: &[f64]) -> String {
    let mut text = String::new();
    for (joint, weight) in shaft.iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
        match (*weight < 0.0, text.is_empty()) {
            (true, _) => text.push_str("<mo>−</mo>"),
            (false, true) => {}
            (false, false) => text.push_str("<mo>+</mo>"),
        }
        if (weight.abs() - 1.0).abs() > f64::EPSILON {
            push(&mut text, format_args!("<mn>{}</mn>", weight.abs()));
        }
        text.push_str(&rate(DOT, joint, 1));
    }
    text
}

fn over(speed: &str, number: f64) -> String {
    format!("<mrow>{speed}</mrow><mo>/</mo><mn>{number}</mn>")
}

fn brackets(inner: &str) -> String {
    format!("<mo stretchy=\"false\">(</mo>{inner}<mo stretchy=\"false\">)</mo>")
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
        Equation {
            name,
            left: torque(1),
            note,
            terms,
            friction: Vec::new(),
            unit: None,
            left_out: 0,
        }
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

    fn rubbing(shaft: [f64; 2], law: FrictionLaw, direction: Direction) -> FrictionTerm {
        FrictionTerm { shaft: shaft.to_vec(), law, direction, load: false }
    }

    #[test]
    fn friction_is_written_as_its_law() {
        let dq2 = "<msub><mi>𝑞̇</mi><mn>2</mn></msub>";
        let (knee, both) = ([0.0, 1.0], Direction::Both);
        let written = |term: &FrictionTerm| friction(term).to_string();

        let stribeck = FrictionLaw::Stribeck { speed: 0.05, width: 0.0 };
        let html = written(&rubbing(knee, stribeck, Direction::Backward));
        assert!(html.starts_with("<math><msup><mi>e</mi>"), "{html}");
        assert!(html.contains(&format!("<mrow>{dq2}</mrow><mo>/</mo><mn>0.05</mn>")), "{html}");
        assert!(html.contains("<mi>sign</mi>"), "{html}");
        assert!(html.contains(&format!("{dq2}<mo>&lt;</mo><mn>0</mn>")), "{html}");
        let smooth = written(&rubbing(knee, FrictionLaw::Coulomb { width: 0.01 }, both));
        assert!(smooth.contains("<mi>tanh</mi>") && !smooth.contains("sign"), "{smooth}");
        assert_eq!(written(&rubbing(knee, FrictionLaw::Offset, both)), "");
        let viscous = written(&rubbing(knee, FrictionLaw::Viscous, both));
        assert_eq!(viscous, format!("<math>{dq2}</math>"));
        let wrist = written(&rubbing([1.0, -0.5], FrictionLaw::Viscous, both));
        let half = format!("<mo>−</mo><mn>0.5</mn>{dq2}<mo stretchy=\"false\">)</mo>");
        assert!(wrist.contains(&half), "{wrist}");
        let smooth = FrictionLaw::Coulomb { width: 0.01 };
        let wrist = written(&rubbing([1.0, -0.5], smooth, both));
        assert!(wrist.contains(&format!("{half}</mrow><mo>/</mo>")), "{wrist}");
    }

    #[test]
    fn friction_stands_below_the_other_terms() {
        let dry = rubbing([0.0, 1.0], FrictionLaw::Coulomb { width: 0.0 }, Direction::Both);
        let lossy = rubbing([0.0, 1.0], FrictionLaw::Viscous, Direction::Both);
        let friction = [(dry, -0.75), (lossy, 12.5)].map(|(term, coefficient)| Weighted {
            term,
            coefficient,
            std_error: 0.01,
            inclusion: None,
        });
        let whole = Equation { friction: friction.to_vec(), ..equation(vec![weighted(3.0, 0.1)]) };

        let html = whole.to_markup().to_string();

        let (terms, below) = html.split_once("<div class=\"part\">friction</div>").unwrap();
        assert!(terms.contains("<mi>sin</mi>") && !terms.contains("<mi>sign</mi>"), "{terms}");
        assert!(below.contains("title=\"−0.750 N·m, standard error 0.010\""), "{below}");
        assert!(below.contains("title=\"+12.500 N·m·s, standard error 0.010\""), "{below}");
        let alone = Equation { friction: friction.to_vec(), ..equation(Vec::new()) };
        let html = alone.to_markup().to_string();
        assert!(!html.contains(">0</span>") && !html.contains("class=\"part\""), "{html}");
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
