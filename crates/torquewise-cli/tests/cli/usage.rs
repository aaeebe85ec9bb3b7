//! Words the command line does not know, help, and readers that leave early.

use crate::terminal::Terminal;
use std::io::Read;
use std::process::{Command, Stdio};

#[test]
fn wrong_usage_exits_with_two_and_leaves_nothing() {
    let terminal = Terminal::with_log();

    for line in [
        "fly",
        "fit log.csv",
        "fit -o model.json",
        "fit log.csv -o model.json --library magic",
        "fit log.csv -o model.json --threshold -1",
        "fit log.csv -o model.json --threshold NaN",
        "fit log.csv -o model.json --method sindy --interaction 2",
        "patterns log.csv --clusters 0",
        "patterns log.csv --clusters many",
        "simulate planar-2 -o new.csv --case 4",
        "simulate planar-2 -o new.csv --noise-db 1,2",
        "simulate planar-2 -o new.csv --noise-db 1,2,NaN",
        "simulate planar-2 -o new.csv --case 2 --noise-db 1,2,3",
        "simulate planar-2 -o new.csv --lock joint1",
        "predict model.json log.csv -o out.csv --step 4",
        "compare log.csv",
        "completions tcsh5",
    ] {
        terminal.misused(line, &[]);
    }
    let said = terminal.run("");
    assert_eq!((said.code, said.stdout.as_str()), (2, ""), "{said:?}");
    assert_eq!(terminal.files(), ["log.csv"]);
}

#[test]
fn help_version_and_completions_for_every_shell_are_results() {
    let terminal = Terminal::new();

    assert!(terminal.done("help").contains("fit"));
    assert!(terminal.done("--version").starts_with("torquewise "));
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        assert!(terminal.done(&format!("completions {shell}")).contains("evaluate"), "{shell}");
    }
}

#[test]
fn a_program_without_the_page_says_who_has_it() {
    Terminal::new().refused("serve --no-browser", &["pip install torquewise"]);
}

#[test]
fn a_reader_that_leaves_early_ends_the_program_quietly() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_torquewise"))
        .args(["completions", "zsh"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());

    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();

    assert_eq!(said, "");
    assert_eq!(child.wait().unwrap().code(), Some(0));
}
