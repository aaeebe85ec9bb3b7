//! Charts → SVG text: the charts of the report as a file of its own, words kept as words.

mod colour;
mod scale;
mod marks;
mod panel;

use crate::svg::panel::{PANEL_GAP, Panel};
use torquewise_report::html::Chart;
use torquewise_report::html::markup::escape;

/// Width of a figure in pixels.
const WIDTH: f64 = 1_000.0;
/// Space for the title.
const HEAD: f64 = 46.0;

/// An SVG with one panel per chart, so many side by side.
///
/// Nothing is rasterised and no font is embedded: words stand in the sans-serif font of whoever
/// looks at it.
pub(crate) fn svg(title: &str, charts: &[Chart], columns: usize) -> String {
    let columns = columns.max(1);
    let width = (WIDTH - PANEL_GAP) / columns as f64;
    let mut body = String::new();
    let mut top = HEAD;
    for (row, charts) in charts.chunks(columns).enumerate() {
        let panels: Vec<Panel<'_>> = charts.iter().map(|chart| Panel::new(chart, width)).collect();
        let height = panels.iter().map(Panel::height).fold(0.0, f64::max);
        for (column, panel) in panels.iter().enumerate() {
            let left = column as f64 * width;
            let number = row * columns + column;
            body += &format!("<g transform=\"translate({left:.0} {top:.0})\">\n");
            body += &panel.draw(number, height);
            body += "</g>\n";
        }
        top += height;
    }
    let height = top + PANEL_GAP;
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height:.0}\" \
         width=\"{WIDTH}\" height=\"{height:.0}\" font-family=\"sans-serif\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n\
         <text x=\"20\" y=\"30\" font-size=\"20\" fill=\"{}\">{}</text>\n{body}</svg>\n",
        colour::INK,
        escape(title)
    )
}

#[cfg(test)]
mod tests;
