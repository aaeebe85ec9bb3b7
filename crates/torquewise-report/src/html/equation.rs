//! Terms in LaTeX as MathML, with the digits that are significant.

use crate::html::markup::Label;
use crate::html::number::aligned;
use crate::{count, safe};
use minijinja::{Value, context};
use pulldown_latex::{Parser, RenderConfig, Storage, push_mathml};
use torquewise_model::print::{weighted_energies, with_error};
use torquewise_model::{EnergyTerm, FrictionLaw, FrictionTerm, Kind, Place, Term, Trig, Weighted};

/// A sum with its left side, before it is written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Equation {
    /// Its name in plain text.
    pub name: String,
    /// What the sum is, as made by [`math`].
    pub left: Label,
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
    /// What the template of an equation is filled with: one term to a line, with signs and decimal
    /// points below each other.
    ///
    /// Each coefficient has the digits its standard error leaves standing; error, unit and share of
    /// resampled logs stand beside it in small type or appear when it is pointed at.
    pub(crate) fn view(&self) -> Value {
        let terms = self.terms.iter().map(|weighted| {
            let unit = self.unit.unwrap_or_else(|| unit_of(&weighted.term));
            let is_one = weighted.term.interaction() == 0 && weighted.term.kind() == Kind::Gravity;
            // Nothing for the constant 1.
            let function = if is_one { "".into() } else { term(&weighted.term) };
            line(weighted, unit, &function)
        });
        let rubs = self.friction.iter().map(|weighted| {
            let unit = match (weighted.term.law, weighted.term.load) {
                (FrictionLaw::Viscous, false) => "N·m·s",
                (FrictionLaw::Viscous, true) => "s",
                (_, false) => "N·m",
                (_, true) => "",
            };
            line(weighted, unit, &friction(&weighted.term))
        });
        let (numbers, lines): (Vec<[String; 2]>, Vec<Value>) = terms.chain(rubs).unzip();
        let errors = numbers.iter().map(|[_, error]| error.chars().count());
        let coefficients = numbers.iter().map(|[number, _]| number.clone());
        let coefficients = aligned(&coefficients.collect::<Vec<_>>());
        let lines = lines.into_iter().zip(&coefficients);
        let mut lines: Vec<Value> =
            lines.map(|(line, coefficient)| context! { coefficient, ..line }).collect();
        let friction = lines.split_off(self.terms.len());
        context! {
            name => self.name.as_str(),
            left => &self.left,
            note => self.note.as_str(),
            terms => lines,
            friction,
            widest => coefficients.iter().map(|text| text.chars().count()).max().unwrap_or(1),
            // The sign ± and a space stand before the error.
            wide => errors.max().filter(|&n| n > 0).map_or(0, |n| n + 2),
            left_out => (self.left_out > 0).then(|| count(self.left_out)),
        }
    }
}

/// A line of a sum, a coefficient and the function it stands before: its size and standard error,
/// both with the digits that mean something, and all else that its template asks for.
fn line<T>(weighted: &Weighted<T>, unit: &str, function: &Label) -> ([String; 2], Value) {
    let Weighted { coefficient, std_error, inclusion, .. } = *weighted;
    let text = with_error(coefficient.abs(), std_error);
    let (number, error) = text.split_once(" ± ").unwrap_or((&text, ""));
    let line = context! {
        sign => if coefficient < 0.0 { "−" } else { "+" },
        number, error, unit, function,
        percent => inclusion.map(|inclusion| format!("{:.0}", 100.0 * inclusion)),
        is_certain => inclusion.is_none_or(|inclusion| inclusion >= CERTAIN),
    };
    ([number.into(), error.into()], line)
}

/// A share of resampled logs above this needs no mention: the term is always there.
const CERTAIN: f64 = 0.995;

/// The equations of an energy: M₁₁, M₁₂, …, then V.
pub fn energies(terms: &[Weighted<EnergyTerm>]) -> Vec<Equation> {
    let equation = |(at, terms): (Place, Vec<Weighted<Term>>)| {
        let slides = terms.iter().flat_map(|own| &own.term.factors);
        let slides = slides.into_iter().any(|factor| factor.function == Trig::Position);
        // What a coefficient before a position is in depends on its power.
        let unit = match at {
            _ if slides => "SI",
            Place::Potential => "J",
            Place::Inertia(..) => "kg·m²",
        };
        Equation {
            name: at.name(),
            left: math(&format!("{}=", at.latex())),
            note: format!("[{unit}]"),
            terms,
            unit: Some(unit),
            ..Equation::default()
        }
    };
    weighted_energies(terms).into_iter().map(equation).collect()
}

/// A term: sin q₂ cos² q₃ q̇₁ q̇₂.
pub fn term(term: &Term) -> Label {
    let latex = term.latex();
    math(if latex.is_empty() { "1" } else { &latex })
}

/// f(v) of a friction term: sign q̇₂, e^−(q̇₂/0.05)² sign q̇₂; nothing for an offset.
pub fn friction(term: &FrictionTerm) -> Label {
    let latex = term.latex();
    if latex.is_empty() { "".into() } else { math(&latex) }
}

/// LaTeX as MathML.
pub fn math(latex: &str) -> Label {
    let (storage, mut html) = (Storage::new(), String::new());
    // Writing to a String cannot fail.
    let _ = push_mathml(&mut html, Parser::new(latex, &storage), RenderConfig::default());
    safe(&MENDED.iter().fold(html, |html, (from, to)| html.replace(from, to)))
}

/// What the renderer writes that a browser does not take, or sets badly, and what it becomes: a
/// space is no base of a power, a sign is no tag, and combining marks sit right in any font, an
/// accent only in one made for mathematics.
const MENDED: [(&str, &str); 4] = [
    ("<msup><mspace width=\"0.1667em\" />", "<mspace width=\"0.1667em\" /><msup>"),
    ("<mo><</mo>", "<mo>&lt;</mo>"),
    ("<mover><mi>q</mi><mi>˙</mi></mover>", "<mi>\u{1d45e}\u{307}</mi>"),
    ("<mover><mi>q</mi><mi>¨</mi></mover>", "<mi>\u{1d45e}\u{308}</mi>"),
];

fn unit_of(term: &Term) -> &'static str {
    match (term.kind(), term.dq.iter().sum::<u8>()) {
        (Kind::Inertia, _) => "kg·m²",
        (_, 0) => "N·m",
        (_, 1) => "N·m·s",
        _ => "N·m·s²",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::html::{Item, Page, Section};
    use torquewise_model::Trig;
    use torquewise_model::friction::Direction;
    use torquewise_model::term::Factor;

    fn equation(terms: Vec<Weighted<Term>>) -> Equation {
        let (name, note) = ("\"tau2".into(), "<elbow>".into());
        Equation { name, left: math(r"\tau_{2}="), note, terms, ..Equation::default() }
    }

    fn drawn(equation: Equation) -> String {
        let section = Section { heading: String::new(), items: vec![Item::Equation(equation)] };
        let page = Page { sections: vec![section], ..Page::default() }.to_html().unwrap();
        page.split("<main>").nth(1).unwrap().split("</main>").next().unwrap().to_owned()
    }

    fn weighted(coefficient: f64, std_error: f64) -> Weighted<Term> {
        let term = Term::one(2).times(Trig::Sin, 1, 1, 1);
        Weighted { term, coefficient, std_error, inclusion: Some(0.84) }
    }

    #[test]
    fn a_term_is_written_factor_by_factor() {
        let product = Term::one(3).times(Trig::Cos, 2, 1, 2).times_dq(0).times_dq(0).times_ddq(1);

        let html = term(&product).to_string();

        let cosine = "<msup><mi>cos</mi><mrow><mn>2</mn></mrow></msup>";
        assert!(html.starts_with(&format!("<math display=\"inline\">{cosine}")), "{html}");
        let square = "<mi>𝑞̇</mi><mrow><mn>1</mn></mrow><mrow><mn>2</mn></mrow></msubsup>";
        assert!(html.contains(square), "{html}");
        assert!(html.ends_with("<mi>𝑞̈</mi><mrow><mn>2</mn></mrow></msub></math>"), "{html}");
        let after = term(&Term::one(3).times(Trig::Sin, 1, 1, 1).times(Trig::Cos, 2, 1, 2));
        assert!(after.to_string().contains(&format!("/>{cosine}")), "{after}");
        assert_eq!(term(&Term::one(1)).to_string(), "<math display=\"inline\"><mn>1</mn></math>");
    }

    fn rubbing(shaft: [f64; 2], law: FrictionLaw, direction: Direction) -> FrictionTerm {
        FrictionTerm { shaft: shaft.to_vec(), law, direction, load: false }
    }

    #[test]
    fn friction_is_written_as_its_law() {
        let dq2 = "<msub><mi>𝑞̇</mi><mrow><mn>2</mn></mrow></msub>";
        let (knee, wrist, both) = ([0.0, 1.0], [1.0, -0.5], Direction::Both);
        let smooth = FrictionLaw::Coulomb { width: 0.01 };
        let written = |shaft, law, way| friction(&rubbing(shaft, law, way)).to_string();

        let stribeck = FrictionLaw::Stribeck { speed: 0.05, width: 0.0 };
        let html = written(knee, stribeck, Direction::Backward);
        assert!(html.starts_with("<math display=\"inline\"><msup><mi>e</mi>"), "{html}");
        assert!(html.contains(&format!("{dq2}<mo>/</mo><mn>0.05</mn>")), "{html}");
        assert!(html.contains("<mi>sign</mi>"), "{html}");
        assert!(html.contains(&format!("{dq2}<mo>&lt;</mo><mn>0</mn>")), "{html}");
        let html = written(knee, smooth, both);
        assert!(html.contains("<mi>tanh</mi>") && !html.contains("sign"), "{html}");
        assert_eq!(written(knee, FrictionLaw::Offset, both), "");
        let viscous = written(knee, FrictionLaw::Viscous, both);
        assert_eq!(viscous, format!("<math display=\"inline\">{dq2}</math>"));
        let thin = "<mspace width=\"0.16666667em\" />";
        let close = "<mo symmetric=\"false\" stretchy=\"false\">)</mo>";
        let half = format!("<mo>−</mo><mn>0.5</mn>{thin}{dq2}{close}");
        assert!(written(wrist, FrictionLaw::Viscous, both).contains(&half));
        assert!(written(wrist, smooth, both).contains(&format!("{half}<mo>/</mo>")));
    }

    #[test]
    fn friction_stands_below_the_other_terms() {
        let dry = rubbing([0.0, 1.0], FrictionLaw::Coulomb { width: 0.0 }, Direction::Both);
        let lossy = rubbing([0.0, 1.0], FrictionLaw::Viscous, Direction::Both);
        let friction = [(dry, -0.75), (lossy, 12.5)]
            .map(|(term, weight)| Weighted { std_error: 0.01, ..Weighted::new(term, weight) });
        let whole = Equation { friction: friction.to_vec(), ..equation(vec![weighted(3.0, 0.1)]) };

        let html = drawn(whole);

        let (terms, below) = html.split_once("<div class=\"part\">friction</div>").unwrap();
        assert!(terms.contains("<mi>sin</mi>") && !terms.contains("<mi>sign</mi>"), "{terms}");
        assert!(below.contains("title=\"−0.750 N·m, standard error 0.010\""), "{below}");
        assert!(below.contains("title=\"+12.500 N·m·s, standard error 0.010\""), "{below}");
        let alone = Equation { friction: friction.to_vec(), ..equation(Vec::new()) };
        let html = drawn(alone);
        assert!(!html.contains(">0</span>") && !html.contains("class=\"part\""), "{html}");
    }

    #[test]
    fn a_sum_of_angles_stands_in_brackets() {
        let factor = Factor { multiples: vec![0, 1, -2], function: Trig::Sin, power: 1 };
        let sine = Term { factors: vec![factor], ..Term::one(3) };

        let html = term(&sine).to_string();

        let [second, third] =
            [2, 3].map(|joint| format!("<msub><mi>q</mi><mrow><mn>{joint}</mn></mrow></msub>"));
        let twice = "<mo>−</mo><mn>2</mn><mspace width=\"0.16666667em\" />";
        assert!(html.contains(&format!("(</mo>{second}{twice}{third}<mo")), "{html}");
    }

    #[test]
    fn a_coefficient_shows_its_digits_error_and_share() {
        let html = drawn(equation(vec![weighted(-8.395_95, 0.003_14)]));

        assert!(html.contains("<span class=\"sign\">−</span>"), "{html}");
        assert!(html.contains(">8.3960<") || html.contains(">8.3959<"), "{html}");
        assert!(html.contains("± 0.0031"), "{html}");
        assert!(html.contains("in 84 %"), "{html}");
        assert!(html.contains("N·m, standard error 0.0031"), "{html}");
    }

    #[test]
    fn notes_are_escaped_and_an_empty_sum_is_zero() {
        let html = drawn(equation(Vec::new()));

        assert!(html.contains("<small>&lt;elbow&gt;</small>"), "{html}");
        assert!(html.contains("aria-label=\"&quot;tau2\""), "{html}");
        assert!(html.contains(">0</span>"), "{html}");
    }

    #[test]
    fn the_potential_stands_last() {
        let energy = |place| Weighted::new(EnergyTerm { place, function: Term::one(2) }, 1.0);
        let places = [Place::Potential, Place::Inertia(1, 1), Place::Inertia(0, 1)].map(energy);

        let equations = energies(&places);

        let left: Vec<String> = equations.iter().map(|own| own.left.to_string()).collect();
        assert!(left[0].contains("<mn>1,2</mn>") && left[1].contains("<mn>2,2</mn>"), "{left:?}");
        assert!(left[2].contains("<mi>V</mi>"), "{left:?}");
    }
}
