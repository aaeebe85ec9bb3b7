//! Signals, full disks, little memory and two writers: nothing half-written, nothing left.
//!
//! `TORQUEWISE_KILLS` is how often each command is ended by each signal.

use crate::terminal::Terminal;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;
use std::fs::Permissions;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};
use std::{env, fs, thread};

const PROGRAM: &str = env!("CARGO_BIN_EXE_torquewise");

const FMU: &str = "export model.json --to fmu -o new.fmu";

/// Every command that writes, with all that it can write; `log.csv` and `model.json` are there.
const WRITING: [&str; 14] = [
    "simulate planar-2 -o new.csv --truth truth.csv --seconds 200 --rate 100",
    "simulate planar-2 -o new.parquet --seconds 400 --rate 100",
    "fit log.csv -o new.json --report new.html --test log.csv",
    "predict model.json log.csv -o new.csv --parts",
    "patterns log.csv -o new.csv",
    "orders log.csv -o new.svg",
    "contacts model.json log.csv -o new.csv --figure new.svg",
    "moments log.csv -o new.moments",
    "excite planar-2 -o new --tries 2",
    "control model.json --arm planar-2 --seconds 2 -o new.csv --plot new.svg --report new.html",
    "export model.json --to ros2 -o new",
    FMU,
    "export model.json --to c -o new.c --test-vectors",
    "demo -o new --seconds 10",
];

/// What a run cut short may have left of its outputs: all or nothing.
fn tree(folder: &Path) -> BTreeMap<PathBuf, u64> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_owned()];
    while let Some(next) = open.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let entry = entry.unwrap();
            let size = if entry.file_type().unwrap().is_dir() {
                open.push(entry.path());
                0
            } else {
                entry.metadata().unwrap().len()
            };
            found.insert(entry.path().strip_prefix(folder).unwrap().into(), size);
        }
    }
    found
}

fn remove_new(folder: &Path, before: &BTreeMap<PathBuf, u64>) {
    for path in tree(folder).keys().filter(|path| !before.contains_key(*path)) {
        let path = folder.join(path);
        let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    }
}

fn kills() -> usize {
    env::var("TORQUEWISE_KILLS").ok().map_or(1, |number| number.parse().unwrap())
}

/// Runs a line and ends it by a signal after a time; whether the signal came first.
fn ended(folder: &Path, work: &Path, line: &str, signal: &str, after: Duration) -> bool {
    let mut child = Command::new(PROGRAM)
        .args(line.split_whitespace())
        .current_dir(folder)
        .env("TMPDIR", work)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .process_group(0)
        .spawn()
        .unwrap();
    thread::sleep(after);
    let target = child.id().to_string();
    let _ = Command::new("kill").args([signal, &target]).stderr(Stdio::null()).status();
    let status = child.wait().unwrap();
    let code = status.code();
    // Before it listens, any signal ends it as it ends any program.
    let killed =
        status.signal().is_some_and(|number| signal == "-KILL" || number == 2 || number == 15);
    assert!(matches!(code, Some(0 | 3 | 130)) || killed, "{line}: {signal}: {status:?}");
    killed || code == Some(130)
}

#[test]
fn c18_c19_c20_signals_at_random_moments_leave_all_or_nothing() {
    let terminal = Terminal::with_model();
    let folder = terminal.path("");
    let before = tree(&folder);
    let mut random = ChaCha8Rng::seed_from_u64(18);
    let clean = || remove_new(&folder, &before);
    for line in WRITING {
        let begun = Instant::now();
        let said = terminal.run(line);
        let takes = begun.elapsed().as_secs_f64();
        assert!(matches!(said.code, 0 | 3), "{line}: {said:?}");
        let whole: Vec<PathBuf> = tree(&folder).into_keys().collect();
        clean();
        let mut early = 0;
        for signal in ["-INT", "-TERM", "-KILL"] {
            for _ in 0..kills() {
                // One of its own, for a killed program leaves what its compiler was given.
                let work = tempfile::tempdir().unwrap();
                let after = Duration::from_secs_f64(takes * random.random_range(0.05..1.0));
                early += u32::from(ended(&folder, work.path(), line, signal, after));
                let mut found = tree(&folder);
                if signal == "-KILL" {
                    // Only what is on its way stays of a killed one.
                    let is_own =
                        |name: &std::ffi::OsStr| name.to_string_lossy().starts_with(".torquewise-");
                    found.retain(|path, _| !path.iter().any(is_own));
                }
                let empty: Vec<_> = found
                    .iter()
                    .filter(|(path, size)| folder.join(path).is_file() && **size == 0)
                    .collect();
                assert!(empty.is_empty(), "{line}: {signal}: {empty:?}");
                let found: Vec<PathBuf> = found.into_keys().collect();
                let is_none = found.iter().eq(before.keys());
                let is_partial_of_killed =
                    signal == "-KILL" && found.iter().all(|f| whole.contains(f));
                assert!(
                    is_none || found == whole || is_partial_of_killed,
                    "{line}: {signal} after {after:?} of {takes:.3} s: {found:?}"
                );
                clean();
                let left = tree(work.path());
                if signal != "-KILL" {
                    assert!(left.is_empty(), "{line}: {signal}: {left:?}");
                }
            }
        }
        println!("{line}: {early} of {} before the end, {takes:.2} s", 3 * kills());
    }
}

fn limited(terminal: &Terminal, limits: &str, line: &str) -> Output {
    let script = format!("{limits}; exec {PROGRAM} {line}");
    Command::new("bash").args(["-c", &script]).current_dir(terminal.path("")).output().unwrap()
}

/// As on a full disk: no file may grow beyond some kilobytes.
#[test]
fn c20_outputs_that_find_no_room_leave_nothing() {
    let terminal = Terminal::with_model();
    let (before, known) = (terminal.files(), tree(&terminal.path("")));
    for line in WRITING {
        let output = limited(&terminal, "trap '' XFSZ; ulimit -f 1", line);

        let said = String::from_utf8_lossy(&output.stderr);
        if output.status.success() {
            // All it writes is small.
            let new = tree(&terminal.path(""));
            assert!(new.values().all(|&size| size < 3_000_000), "{line}");
        } else {
            assert_eq!(output.status.code(), Some(1), "{line}: {said}");
            assert!(said.starts_with("error: "), "{line}: {said}");
            assert_eq!(terminal.files(), before, "{line}: {said}");
        }
        remove_new(&terminal.path(""), &known);
    }
}

/// Nobody may write to the folder of somebody else; root may, so the program runs as nobody.
#[test]
fn c20_a_folder_that_is_read_only_stays_as_it_is() {
    let terminal = Terminal::with_model();
    let own = tempfile::tempdir().unwrap();
    // Where the program was built, nobody may not look.
    let program = own.path().join("torquewise");
    fs::copy(PROGRAM, &program).unwrap();
    let allow =
        |path: &Path, mode| fs::set_permissions(path, Permissions::from_mode(mode)).unwrap();
    allow(own.path(), 0o755);
    allow(&terminal.path(""), 0o555);
    let is_root = fs::metadata(own.path()).unwrap().uid() == 0;
    let as_nobody = |line: &str| {
        let mut command = if is_root {
            let mut command = Command::new("setpriv");
            command.args(["--reuid=65534", "--regid=65534", "--clear-groups"]).arg(&program);
            command
        } else {
            Command::new(&program)
        };
        command.args(line.split_whitespace()).current_dir(terminal.path("")).output()
    };
    if as_nobody("--version").is_err() {
        println!("skipped: there is no setpriv to be nobody by");
        return;
    }
    let before = terminal.files();
    for line in WRITING {
        let output = as_nobody(line).unwrap();

        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{line}: {said}");
        assert!(said.starts_with("error: ") && said.contains("new"), "{line}: {said}");
        assert_eq!(terminal.files(), before, "{line}: {said}");
    }
    allow(&terminal.path(""), 0o755);
}

#[test]
fn c20_a_bad_test_log_or_a_full_report_keeps_the_model_from_appearing() {
    let terminal = Terminal::with_log();
    let mut rows: Vec<String> = terminal.read("log.csv").lines().map(Into::into).collect();
    rows[500] = "x,y".into();
    terminal.write("bad.csv", &rows.join("\n"));
    std::os::unix::fs::symlink("/dev/full", terminal.path("full.html")).unwrap();

    terminal.refused("fit log.csv -o m.json --test bad.csv", &["bad.csv"]);
    let full = "fit log.csv -o m.json --report full.html";
    terminal.refused(full, &["full.html cannot be written"]);
}

#[test]
fn little_memory_is_enough_and_two_writers_leave_one_whole_file() {
    let terminal = Terminal::with_model();
    let writers: Vec<_> = (0..6)
        .map(|seed| {
            let line =
                format!("simulate planar-2 -o both.csv --seconds 40 --rate 100 --seed {seed}");
            let mut command = Command::new(PROGRAM);
            command.args(line.split(' ')).current_dir(terminal.path("")).stdout(Stdio::null());
            command.spawn().unwrap()
        })
        .collect();
    for mut writer in writers {
        assert!(writer.wait().unwrap().success());
    }
    assert_eq!(terminal.files(), ["both.csv", "log.csv", "model.json"]);
    assert_eq!(
        terminal.read("both.csv").lines().count(),
        terminal.read("both.csv").matches('\n').count()
    );
    terminal.done("inspect both.csv");

    // A gigabyte of addresses is enough, stacks of all threads among them.
    let output = limited(&terminal, "ulimit -v 1000000", "fit log.csv -o m.json");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn c21_help_that_cannot_be_written_is_a_failure() {
    for line in ["--help", "--version", "fit --help"] {
        let script = format!("{PROGRAM} {line} > /dev/full");
        let output = Command::new("bash").args(["-c", &script]).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{line}");
        assert!(String::from_utf8_lossy(&output.stderr).contains("standard output"), "{line}");
    }
}

#[test]
fn c22_pipes_and_devices_are_no_logs() {
    let terminal = Terminal::new();
    for ending in ["csv", "db3", "mcap", "parquet", "npz", "mat"] {
        let pipe = format!("pipe.{ending}");
        assert!(Command::new("mkfifo").arg(terminal.path(&pipe)).status().unwrap().success());
        let device = format!("null.{ending}");
        std::os::unix::fs::symlink("/dev/null", terminal.path(&device)).unwrap();
        for file in [pipe, device] {
            terminal.refused(&format!("inspect {file}"), &[&file, "not a file", "copy"]);
        }
    }
}

#[test]
fn b16_threads_that_cannot_be_had_are_done_without() {
    let terminal = Terminal::with_log();
    for threads in ["18446744073709551615", "9223372036854775807", "500"] {
        let line = format!("fit log.csv -o {}.json", &threads[..3]);
        let output = limited(&terminal, &format!("export RAYON_NUM_THREADS={threads}"), &line);
        assert!(output.status.success(), "{threads}: {}", String::from_utf8_lossy(&output.stderr));
    }
    terminal.done("fit log.csv -o own.json");
    assert_eq!(terminal.read("500.json"), terminal.read("own.json"));
}

#[test]
fn d28_motions_that_would_fill_the_memory_are_refused() {
    let terminal = Terminal::new();
    terminal.misused("demo --seconds 1000000", &["at most"]);
    let line = "simulate planar-2 -o a.csv --case 2 --seconds 1000000 --rate 30";
    terminal.misused(line, &["held in memory"]);
}
