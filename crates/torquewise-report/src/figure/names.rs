//! From names of places to words below an axis: level if they fit, else upright.

use crate::error::ReportError;
use crate::figure::DOTS;
use crate::figure::words::{
    Area, SMALL, drawing, height_of, line_height, style, width, wrapped, write,
};
use crate::palette::FADED_INK;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, VPos};

/// Lines of a level name, at most.
const MOST_LINES: usize = 3;
/// Letters of an upright name, at most.
const MOST_LETTERS: usize = 40;
/// Space between two level names.
const GAP: i32 = 8 * DOTS;

/// Names and how they stand.
pub(crate) enum Names {
    /// Each broken into lines.
    Level(Vec<Vec<String>>),
    /// Read from below; without those that there is no room for.
    Upright(Vec<Option<String>>),
}

impl Names {
    /// Names that have the width of a slot each.
    pub(crate) fn new(names: &[String], slot: i32) -> Self {
        let room = slot - GAP;
        let level: Vec<Vec<String>> = names.iter().map(|name| wrapped(name, SMALL, room)).collect();
        let fits = |lines: &Vec<String>| {
            lines.len() <= MOST_LINES && lines.iter().all(|line| width(line, SMALL) <= room)
        };
        if level.iter().all(fits) {
            return Self::Level(level);
        }
        let every = usize::try_from(line_height(SMALL) / slot.max(1) + 1).unwrap_or(1);
        let names = names.iter().enumerate();
        Self::Upright(names.map(|(k, name)| (k % every == 0).then(|| short(name))).collect())
    }

    /// Height of the highest.
    pub(crate) fn height(&self) -> i32 {
        let heights: Vec<i32> = match self {
            Self::Level(names) => names.iter().map(|lines| height_of(lines, SMALL)).collect(),
            Self::Upright(names) => names.iter().flatten().map(|name| width(name, SMALL)).collect(),
        };
        heights.into_iter().max().unwrap_or(0)
    }

    /// Writes each name below its place, if it has one.
    pub(crate) fn write(
        &self,
        area: &Area<'_>,
        places: impl Iterator<Item = Option<(i32, i32)>>,
    ) -> Result<(), ReportError> {
        match self {
            Self::Level(names) => {
                let level = style(SMALL, FADED_INK, HPos::Center, VPos::Top);
                let placed = names.iter().zip(places).filter_map(|(lines, at)| Some((lines, at?)));
                for (lines, at) in placed {
                    write(area, lines, SMALL, &level, at)?;
                }
            }
            Self::Upright(names) => {
                let upright = style(SMALL, FADED_INK, HPos::Right, VPos::Center);
                let upright = upright.transform(FontTransform::Rotate270);
                let placed = names.iter().zip(places);
                for (name, at) in placed.filter_map(|(name, at)| Some((name.as_ref()?, at?))) {
                    area.draw_text(name, &upright, at).map_err(drawing)?;
                }
            }
        }
        Ok(())
    }
}

/// A name without its end if it is very long.
fn short(name: &str) -> String {
    if name.chars().count() <= MOST_LETTERS {
        return name.to_owned();
    }
    name.chars().take(MOST_LETTERS - 1).chain(['…']).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_names_stand_level_and_long_ones_are_broken() {
        let names = ["product: |c| > 0.1".to_owned(), "energy".to_owned()];

        let Names::Level(level) = Names::new(&names, 150) else { panic!("there is room") };

        assert_eq!(level, [vec!["product:", "|c| > 0.1"], vec!["energy"]]);
    }

    #[test]
    fn names_without_room_stand_upright() {
        let names: Vec<String> = (0..6).map(|k| format!("{k}: {}", "m".repeat(90))).collect();

        let Names::Upright(upright) = Names::new(&names, 25) else { panic!("there is no room") };

        let shown: Vec<usize> = (0..6).filter(|&k| upright[k].is_some()).collect();
        assert_eq!(shown, [0, 2, 4], "no two overlap");
        assert!(upright[0].as_ref().unwrap().ends_with("m…"));
    }
}
