//! What documents show of the command line is what it prints.

use crate::terminal::Terminal;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A command of a document, and the lines that stand below it.
struct Shown {
    command: String,
    output: Vec<String>,
}

fn document(name: &str) -> String {
    let root: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    std::fs::read_to_string(root.join(name)).unwrap()
}

/// The commands of the blocks marked `console` in which every file is made by a command before.
fn shown(text: &str) -> Vec<Shown> {
    let mut all: Vec<Shown> = Vec::new();
    for block in text.split("```console\n").skip(1) {
        let block = block.split("```").next().unwrap();
        for line in block.lines() {
            match line.strip_prefix("$ torquewise ") {
                Some(command) => all.push(Shown { command: command.into(), output: vec![] }),
                None => all.last_mut().unwrap().output.push(line.to_owned()),
            }
        }
    }
    all
}

/// Lines up to a single …, after which anything may follow.
fn expected(output: &[String]) -> (String, bool) {
    let lines: Vec<&str> = output.iter().map(String::as_str).take_while(|l| *l != "…").collect();
    (lines.join("\n").trim_end().to_owned(), output.iter().any(|line| line == "…"))
}

/// Whether words are the same, and numbers to three digits; `is_cut`: as far as it is expected.
fn is_same(expected: &str, found: &str, is_cut: bool) -> bool {
    let number = |word: &str| -> Option<f64> {
        word.trim_matches(|c: char| !c.is_ascii_digit() && c != '-').parse().ok()
    };
    let is_close = |(a, b): (&str, &str)| {
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-3 * a.abs();
        a == b || number(a).zip(number(b)).is_some_and(|(a, b)| close(a, b))
    };
    let [expected, found] =
        [expected, found].map(|text| text.split_whitespace().collect::<Vec<_>>());
    let is_long =
        if is_cut { found.len() >= expected.len() } else { found.len() == expected.len() };
    is_long && expected.into_iter().zip(found).all(is_close)
}

#[test]
fn the_commands_of_readme_and_tutorial_print_what_these_show() {
    for (name, least) in [("README.md", 5), ("docs/tutorial.md", 8)] {
        let terminal = Terminal::new();
        let text = document(name);
        // Later blocks read the logs of real arms.
        let shown = shown(text.split("## A real log").next().unwrap());
        assert!(shown.len() >= least, "{name}: {} commands", shown.len());
        for Shown { command, output } in shown {
            let printed = terminal.run(&command);
            let (expected, is_cut) = expected(&output);
            assert_eq!(printed.code, 0, "{name}: {command}: {}", printed.stderr);
            let found = printed.stdout.trim_end();
            assert!(
                is_same(&expected, found, is_cut),
                "{name}: {command}\n--- document\n{expected}\n--- program\n{found}"
            );
        }
    }
}

#[test]
fn every_command_and_flag_that_guides_name_exists() {
    let terminal = Terminal::new();
    for name in
        ["README.md", "docs/your-robot.md", "docs/export.md", "docs/control.md", "docs/tutorial.md"]
    {
        let text = document(name);
        let blocks = text.split("```").skip(1).step_by(2).flat_map(str::lines);
        let lines = blocks.map(|line| line.trim_start_matches("$ ").trim());
        for line in lines.filter_map(|line| line.strip_prefix("torquewise ")) {
            let line = line.split(" #").next().unwrap();
            let mut words = line.split_whitespace();
            let Some(command) = words.next().filter(|w| w.chars().all(char::is_alphabetic)) else {
                continue;
            };
            let help = terminal.run(&format!("{command} --help"));
            assert_eq!(help.code, 0, "{name}: {line}");
            for flag in words.filter(|word| word.starts_with("--")) {
                let flag = flag.split('=').next().unwrap();
                let known = help.stdout.contains(flag) || ["--json", "--help"].contains(&flag);
                assert!(known, "{name}: `torquewise {line}`: no flag {flag}");
            }
        }
    }
}

/// A flag or an argument: its heading, its form, and what it does.
type Entry = [String; 3];

/// The entries of what `--help` prints below its usage, but for those that clap adds.
fn entries(help: &str) -> Vec<Entry> {
    let (mut heading, mut all, mut is_new) = (String::new(), Vec::<Entry>::new(), false);
    for line in help.lines().skip_while(|line| !line.starts_with("Usage")).skip(1) {
        let (word, depth) = (line.trim(), line.len() - line.trim_start().len());
        if !word.is_empty() && depth == 0 {
            word.trim_end_matches(':').clone_into(&mut heading);
        } else if depth < 8 && word.starts_with(['-', '<', '[']) {
            let (form, text) = word.split_once("  ").unwrap_or((word, ""));
            all.push([heading.clone(), form.to_owned(), text.trim().to_owned()]);
        } else if !word.is_empty() {
            let text = &mut all.last_mut().unwrap()[2];
            match word.strip_prefix("- ").and_then(|own| own.split_once(':')) {
                Some((value, does)) => write!(text, "; `{value}` {}", does.trim()).unwrap(),
                None if word == "Possible values:" => text.push(':'),
                None if is_new && !text.is_empty() && !word.starts_with('[') => {
                    write!(text, ". {word}").unwrap();
                }
                None => write!(text, " {word}").unwrap(),
            }
        }
        is_new = word.is_empty();
    }
    all.retain(|own| !["-h, --help", "-V, --version"].contains(&own[1].as_str()));
    for entry in &mut all {
        entry[2] = entry[2].trim().replace(":;", ":");
    }
    all
}

/// An entry of a list, in lines of 118 letters.
fn item(form: &str, text: &str) -> String {
    let (mut line, mut width) = (format!("- {form}"), 2 + form.chars().count());
    for word in text.split_whitespace() {
        width += 1 + word.chars().count();
        let is_full = width > 118;
        line.push_str(if is_full { "\n  " } else { " " });
        line.push_str(word);
        width = if is_full { 2 + word.chars().count() } else { width };
    }
    line + "\n"
}

/// What `--help` of all commands prints, as a page; what several share stands there once.
fn reference(terminal: &Terminal) -> String {
    let help = |line: &str| terminal.run(line).stdout;
    let about = |text: &str| text.split("\nUsage").next().unwrap().trim_end().to_owned();
    let all = help("--help");
    let commands = all.lines().skip_while(|line| *line != "Commands:").skip(1);
    let names = commands.take_while(|line| !line.is_empty());
    let names = names.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let names = names.filter_map(|line| line.split_whitespace().next());
    let names: Vec<&str> = names.filter(|name| *name != "help").collect();
    let pages: Vec<String> = names.iter().map(|name| help(&format!("{name} --help"))).collect();
    let own: Vec<Vec<Entry>> = pages.iter().map(|text| entries(text)).collect();
    let count = |entry: &Entry| match entry[0].as_str() {
        "Arguments" | "Output" => 1,
        _ => own.iter().filter(|of| of.contains(entry)).count(),
    };
    let mut shared: Vec<&Entry> = Vec::new();
    for entry in own.iter().flatten().filter(|entry| count(entry) > 1) {
        let after = shared.iter().rposition(|other| other[0] == entry[0]);
        if !shared.contains(&entry) {
            shared.insert(after.map_or(shared.len(), |place| place + 1), entry);
        }
    }
    let mut page = format!(
        "# The command line\n\n{}\n\n`torquewise COMMAND --help` prints what stands here; \
         `--json` and `--strict` go with every command.\n[Your robot](your-robot.md) leads through them.\n\n## Shared options\n\n",
        about(&all)
    );
    let mut headings: Vec<&str> = Vec::new();
    for [heading, form, text] in shared.iter().copied() {
        if headings.last() != Some(&heading.as_str()) {
            writeln!(page, "- *{heading}*").unwrap();
            headings.push(heading);
        }
        page += &item(&format!("`{form}`"), text).replace("\n ", "\n   ").replacen("- ", "  - ", 1);
    }
    for ((name, text), entries) in names.iter().zip(&pages).zip(&own) {
        let usage = text.lines().find_map(|line| line.strip_prefix("Usage: ")).unwrap();
        let about = about(text);
        let (first, rest) = about.split_once("\n\n").unwrap_or((&about, ""));
        let usage = item(&format!("`{usage}`:"), first);
        let rest = if rest.is_empty() { String::new() } else { format!("\n{rest}\n") };
        write!(page, "\n## {name}\n\n{}{rest}\n", &usage[2..]).unwrap();
        for [_, form, text] in entries.iter().filter(|entry| count(entry) == 1) {
            page += &item(&format!("`{form}`"), text);
        }
        let of = |all: &[&Entry], heading: &str| -> Vec<String> {
            let own = all.iter().filter(|e| e[0] == heading && count(e) < names.len());
            own.map(|e| format!("`{}`", e[1].split(" <").next().unwrap())).collect()
        };
        let many: Vec<&Entry> = entries.iter().filter(|entry| count(entry) > 1).collect();
        let mut some: Vec<String> = Vec::new();
        for heading in headings.iter().filter(|heading| !of(&many, heading).is_empty()) {
            let (whole, found) = (of(&shared, heading), of(&many, heading));
            let is_whole = found.len() > 1 && found.len() == whole.len();
            some.push(if is_whole { format!("*{heading}*") } else { found.join(", ") });
        }
        if !some.is_empty() {
            page += &item("[shared](#shared-options):", &some.join(", "));
        }
    }
    page
}

#[test]
fn the_reference_of_the_command_line_is_what_help_prints() {
    let found = reference(&Terminal::new());
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/command-line.md");
    if std::env::var_os("TORQUEWISE_WRITE_DOCUMENTS").is_some() {
        std::fs::write(&file, &found).unwrap();
    }

    let kept = document("docs/command-line.md");

    assert!(
        kept == found,
        "docs/command-line.md is out of date: run this test with TORQUEWISE_WRITE_DOCUMENTS=1"
    );
    assert!(found.contains("\n## fit\n") && found.contains("\n- `--precision"));
}
