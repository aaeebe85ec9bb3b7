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
fn the_commands_of_the_readme_print_what_it_shows() {
    let terminal = Terminal::new();
    let text = document("README.md");
    // Later blocks read the logs of real arms.
    let example = text.split("## Real arms").next().unwrap();

    let shown = shown(example);

    assert!(shown.len() >= 5, "{} commands", shown.len());
    for Shown { command, output } in shown {
        let printed = terminal.run(&command);
        let (expected, is_cut) = expected(&output);
        assert_eq!(printed.code, 0, "{command}: {}", printed.stderr);
        let found = printed.stdout.trim_end();
        assert!(
            is_same(&expected, found, is_cut),
            "{command}\n--- document\n{expected}\n--- program\n{found}"
        );
    }
}

#[test]
fn every_command_and_flag_that_guides_name_exists() {
    let terminal = Terminal::new();
    for name in ["README.md", "docs/your-robot.md", "docs/export.md", "docs/control.md"] {
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

/// What `--help` of all commands prints, as a page.
fn reference(terminal: &Terminal) -> String {
    let help = |line: &str| {
        let printed = terminal.run(line).stdout;
        printed.lines().map(str::trim_end).collect::<Vec<_>>().join("\n").trim_end().to_owned()
    };
    let all = help("--help");
    let commands = all.lines().skip_while(|line| *line != "Commands:").skip(1);
    let commands = commands.take_while(|line| !line.is_empty());
    let names = commands.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let names = names.filter_map(|line| line.split_whitespace().next());
    let mut page = format!(
        "# The command line\n\nWhat `torquewise --help` prints, and that of each command. \
         [Your robot](your-robot.md) leads through them.\n\n```text\n{all}\n```\n"
    );
    for name in names.filter(|name| *name != "help") {
        let text = help(&format!("{name} --help"));
        write!(page, "\n## {name}\n\n```text\n{text}\n```\n").unwrap();
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
    assert!(found.contains("\n## fit\n") && found.contains("\n## export\n"));
}
