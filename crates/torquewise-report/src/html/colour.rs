//! Colours by role: the name in the page, the value in SVG figures.

use torquewise_motion::Pattern;

/// Colours of M. Okabe and K. Ito, told apart by colour-blind eyes too.
const SERIES: [[u8; 3]; 6] =
    [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [230, 159, 0], [86, 180, 233]];

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
    pub(crate) fn variable(self) -> String {
        match self {
            Self::Measured => "measured".into(),
            Self::Faded => "faded".into(),
            Self::Series(place) => format!("series-{}", place % SERIES.len()),
            Self::Pattern(pattern) => of_pattern(pattern).variable(),
        }
    }

    #[cfg(not(target_family = "wasm"))]
    pub(crate) fn on_paper(self) -> [u8; 3] {
        match self {
            Self::Measured => [178, 186, 197],
            Self::Faded => [107, 114, 128],
            Self::Series(place) => SERIES[place % SERIES.len()],
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
    fn both_themes_have_the_same_roles_and_the_light_one_is_the_paper_of_the_svg_figures() {
        assert_eq!(names(LIGHT), names(DARK));
        let others = [Colour::Measured, Colour::Faded, Colour::Series(0), Colour::Series(99)];

        for colour in Pattern::ALL.map(Colour::Pattern).into_iter().chain(others) {
            let [red, green, blue] = colour.on_paper();
            let declared = format!("--{}: #{red:02x}{green:02x}{blue:02x};", colour.variable());
            assert!(LIGHT.contains(&declared), "{declared}");
        }
    }
}
