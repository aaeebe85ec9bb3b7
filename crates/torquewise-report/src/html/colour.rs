//! From role to colour: its name in the page and its value in the SVG figures.

use crate::palette;
use plotters::style::RGBColor;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::html::page::{DARK, LIGHT};

    fn names(css: &str) -> Vec<&str> {
        css.lines().filter_map(|line| line.split_once(':')).map(|(name, _)| name).collect()
    }

    #[test]
    fn both_themes_have_the_same_roles() {
        assert_eq!(names(LIGHT), names(DARK));
    }

    #[test]
    fn the_light_theme_is_the_paper_of_the_svg_figures() {
        let others = [Colour::Measured, Colour::Faded, Colour::Series(0), Colour::Series(99)];

        for colour in Pattern::ALL.map(Colour::Pattern).into_iter().chain(others) {
            let RGBColor(red, green, blue) = colour.on_paper();
            let declared = format!("--{}: #{red:02x}{green:02x}{blue:02x};", colour.variable());
            assert!(LIGHT.contains(&declared), "{declared}");
        }
    }
}
