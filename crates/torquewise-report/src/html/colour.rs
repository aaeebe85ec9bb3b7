//! Role → colour: one palette for light and dark, the light one also that of the SVG figures.

use crate::palette;
use plotters::style::RGBColor;
use std::fmt::Write;
use torquewise_motion::Pattern;

/// What a colour stands for; the page gives it a light and a dark value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// What was measured: pale, so that a curve on top of it can be told from it.
    Measured,
    /// The curve at a place; six colours that colour-blind eyes tell apart, then from the start.
    Series(usize),
    /// What stays in the background.
    Faded,
    /// A pattern of motion.
    Pattern(Pattern),
}

/// Background of what stands out from the page, and warnings.
const LIGHT_PAGE: [(&str, &str); 4] = [
    ("panel", "#f6f7f9"),
    ("accent", "#0072b2"),
    ("warning", "#fdf3e3"),
    ("warning-edge", "#d98e04"),
];

/// The same colours on a dark page: lighter, their hues kept.
const DARK: [(&str, &str); 16] = [
    ("ink", "#e3e7ec"),
    ("faded", "#98a2b0"),
    ("grid", "#2b333d"),
    ("paper", "#12161b"),
    ("panel", "#1a2027"),
    ("accent", "#58b0e8"),
    ("warning", "#2c2415"),
    ("warning-edge", "#d9a03c"),
    ("measured", "#5a6675"),
    ("good", "#4cc38a"),
    ("series-0", "#58b0e8"),
    ("series-1", "#f2823c"),
    ("series-2", "#2bc297"),
    ("series-3", "#e39ac4"),
    ("series-4", "#f2c14e"),
    ("series-5", "#9ad4f5"),
];

impl Colour {
    /// Name of its CSS variable, without the dashes in front.
    pub(crate) fn variable(self) -> String {
        match self {
            Self::Measured => "measured".into(),
            Self::Faded => "faded".into(),
            Self::Series(place) => format!("series-{}", place % palette::SERIES.len()),
            Self::Pattern(pattern) => of_pattern(pattern).variable(),
        }
    }

    /// Its value on white paper.
    pub(crate) fn on_paper(self) -> RGBColor {
        match self {
            Self::Measured => palette::MEASURED,
            Self::Faded => palette::FADED_INK,
            Self::Series(place) => palette::SERIES[place % palette::SERIES.len()],
            Self::Pattern(pattern) => of_pattern(pattern).on_paper(),
        }
    }
}

fn of_pattern(pattern: Pattern) -> Colour {
    Colour::Series(match pattern {
        Pattern::Standstill => 5,
        Pattern::UniformVelocity => 2,
        Pattern::VariableVelocity => 4,
    })
}

/// CSS declarations of the light palette.
pub(crate) fn light() -> String {
    let roles = [
        ("ink", palette::INK),
        ("faded", palette::FADED_INK),
        ("grid", palette::GRID),
        ("paper", palette::PAPER),
        ("good", RGBColor(0, 130, 90)),
    ];
    let mut css: String =
        roles.iter().map(|(name, colour)| declaration(name, &hex(*colour))).collect();
    css.extend(LIGHT_PAGE.map(|(name, value)| declaration(name, value)));
    css += &declaration("measured", &hex(palette::MEASURED));
    let series = palette::SERIES.iter().enumerate();
    css.extend(
        series.map(|(place, colour)| declaration(&format!("series-{place}"), &hex(*colour))),
    );
    css
}

/// CSS declarations of the dark palette.
pub(crate) fn dark() -> String {
    DARK.iter().map(|(name, value)| declaration(name, value)).collect()
}

fn declaration(name: &str, value: &str) -> String {
    format!("--{name}:{value};")
}

fn hex(RGBColor(red, green, blue): RGBColor) -> String {
    let mut text = String::from("#");
    for part in [red, green, blue] {
        // Writing to a String cannot fail.
        let _ = write!(text, "{part:02x}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn names(css: &str) -> BTreeSet<&str> {
        css.split(';').filter_map(|part| part.split_once(':')).map(|(name, _)| name).collect()
    }

    #[test]
    fn both_themes_have_the_same_roles() {
        assert_eq!(names(&light()), names(&dark()));
    }

    #[test]
    fn every_colour_has_a_value() {
        let css = light();
        let patterns = Pattern::ALL.map(Colour::Pattern);
        let others = [Colour::Measured, Colour::Faded, Colour::Series(0), Colour::Series(99)];

        for colour in patterns.into_iter().chain(others) {
            assert!(css.contains(&format!("--{}:#", colour.variable())), "{colour:?}");
        }
    }

    #[test]
    fn the_light_theme_is_the_paper_of_the_svg_figures() {
        let css = light();
        let others = [Colour::Measured, Colour::Faded, Colour::Series(8)];

        for colour in Pattern::ALL.map(Colour::Pattern).into_iter().chain(others) {
            let declared = declaration(&colour.variable(), &hex(colour.on_paper()));
            assert!(css.contains(&declared), "{declared}");
        }
        assert!(css.contains("--series-0:#0072b2;"));
    }
}
