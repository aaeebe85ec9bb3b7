//! Whether pages hold what they are given, and nothing else.

use super::*;
use crate::html::equation::Equation;
use crate::html::skeleton::Skeleton;
use crate::{Axis, Bars, Chart, Colour, Heading, Series, Table, Tone};

const HOSTILE: &str = "</script><img src=x onerror=\"alert(1)\">'";

/// A page with every kind of item, all words the same.
fn page(words: &str) -> Page {
    let word = || words.to_owned();
    let chart = Chart {
        title: word(),
        caption: word(),
        x: Axis::named(words),
        y: Axis { places: vec![word()], ..Axis::named(words) },
        series: vec![Series::line(words, vec![[0.0, 1.0]]), Series::line(words, vec![[0.5, 2.0]])],
        linked: Some(word()),
        ..Chart::default()
    };
    let bars = Bars {
        title: word(),
        caption: word(),
        label: word(),
        colour: Colour::Faded,
        rows: vec![(words.into(), 1.0), (words.into(), 2.0)],
    };
    let table = Table {
        caption: word(),
        columns: vec![Heading::words(words), Heading::numbers(words)],
        rows: vec![vec![words.into(), words.into()]],
    };
    let items = vec![
        Item::Text(word()),
        Item::Callout { tone: Tone::Warning, heading: word(), lines: vec![word(), word()] },
        Item::Table(table),
        Item::Charts(vec![chart.clone(), chart.clone()]),
        Item::Bars(vec![bars]),
        Item::Equation(Equation {
            name: word(),
            left: safe("<math><mi>q</mi></math>"),
            note: word(),
            ..Equation::default()
        }),
        Item::Skeleton {
            skeleton: Skeleton { joints: vec![word()], ..Skeleton::default() },
            caption: word(),
        },
        Item::Details { summary: word(), items: vec![Item::Charts(vec![chart])] },
    ];
    let sections = vec![Section { heading: word(), items }];
    Page { title: word(), lead: word(), sections, foot: vec![word()] }
}

#[test]
fn hostile_words_stay_words_nothing_is_asked_from_elsewhere_and_each_chart_has_its_own_number() {
    let [hostile, plain] = [HOSTILE, "plain"].map(|words| page(words).to_html().unwrap());

    assert!(!hostile.contains("<img"), "no tag comes from words");
    assert!(!hostile.contains("onerror=\""), "no quote comes from words");
    assert_eq!(hostile.matches("</script>").count(), plain.matches("</script>").count());
    assert!(hostile.contains("&lt;img"));
    for asking in ["src=\"", "href=\"http", "url(http", "@import", "fetch(", "XMLHttpRequest"] {
        assert!(!plain.contains(asking), "{asking}");
    }
    assert!(plain.contains("default-src 'none'"), "and the browser is told so");
    for chart in ["chart-1", "chart-2", "chart-3"] {
        assert_eq!(plain.matches(&format!("id=\"{chart}\"")).count(), 1, "{chart}");
    }
}
