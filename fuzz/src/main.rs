//! Tries every reader on mutated files, in processes that are watched: a panic, an abort, a wait, or
//! too much memory is told with the case that did it, which is kept.

use anyhow::{Context, Result, bail};
use clap::{Parser, ValueEnum};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::fs;
use std::io::Write;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};
use torquewise_fuzz::mutate::mutated;
use torquewise_fuzz::reader::{Reader, Tried};
use torquewise_fuzz::seeds::seeds;

/// Mutated files for every reader of torquewise
#[derive(Parser, Debug)]
struct Arguments {
    /// Readers to try [default: all]
    #[arg(long, value_name = "READER")]
    reader: Vec<Reader>,
    /// Cases for each reader
    #[arg(long, value_name = "N", default_value_t = 1_000)]
    cases: u64,
    /// Time for all of them at most \[s\]
    #[arg(long, value_name = "S", default_value_t = 3_600.0)]
    seconds: f64,
    /// Seed of the mutations
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// First case, to repeat one that was told
    #[arg(long, value_name = "K", default_value_t = 0)]
    first: u64,
    /// Writes the cases to a folder instead of reading them
    #[arg(long, value_name = "DIR")]
    write: Option<PathBuf>,
    /// Where a case that does harm is kept
    #[arg(long, value_name = "DIR", default_value = "target/fuzz")]
    keep: PathBuf,
    /// File of the case that is tried, of a process that is watched
    #[arg(long, hide = true)]
    case: Option<PathBuf>,
}

/// Longest that a case may take, and the addresses and memory that a process may use.
const LONGEST: Duration = Duration::from_secs(20);
const ADDRESSES_KB: u64 = 4_000_000;
const MOST_MEMORY_KB: u64 = 1_000_000;
/// What a process says of a case that panicked.
const PANICKED: u8 = 9;

fn main() -> Result<ExitCode> {
    let arguments = Arguments::parse();
    if let Some(case) = &arguments.case {
        return try_cases(&arguments, case);
    }
    let readers = if arguments.reader.is_empty() {
        Reader::value_variants().to_vec()
    } else {
        arguments.reader.clone()
    };
    if let Some(folder) = &arguments.write {
        return write_cases(&arguments, &readers, folder);
    }
    fs::create_dir_all(&arguments.keep)?;
    let mut harm = 0;
    let share = arguments.seconds / readers.len() as f64;
    println!(
        "{:<9} {:>9} {:>9} {:>8} {:>10} {:>9}",
        "reader", "cases", "taken", "seconds", "longest ms", "peak MB"
    );
    for reader in readers {
        harm += u32::from(!watched(&arguments, reader, share)?);
    }
    Ok(if harm == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Case k of a reader depends on the seed, the reader and k alone.
fn case(
    arguments: &Arguments,
    reader: Reader,
    seeds: &[torquewise_fuzz::seeds::Seed],
    k: u64,
) -> Vec<u8> {
    let name = reader.name().bytes().fold(0_u64, |sum, byte| (sum << 5) ^ u64::from(byte));
    let mut random = ChaCha8Rng::seed_from_u64(
        arguments.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (name << 40) ^ k,
    );
    let seed = random.random_range(0..seeds.len());
    mutated(&seeds[seed], &mut random)
}

fn write_cases(arguments: &Arguments, readers: &[Reader], folder: &Path) -> Result<ExitCode> {
    fs::create_dir_all(folder)?;
    for &reader in readers {
        let seeds = seeds(reader)?;
        for k in arguments.first..arguments.first + arguments.cases {
            let file = folder.join(format!("{k:06}.{}", reader.name()));
            fs::write(file, case(arguments, reader, &seeds, k))?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// The work of a watched process.
fn try_cases(arguments: &Arguments, file: &Path) -> Result<ExitCode> {
    let [reader] = arguments.reader[..] else { bail!("one reader is watched at a time") };
    let seeds = seeds(reader)?;
    let tried = Tried::at(reader, file.to_owned());
    for seed in &seeds {
        if !tried.one(&seed.bytes()) {
            bail!("a seed of {} is refused", reader.name());
        }
    }
    std::panic::set_hook(Box::new(|_| ()));
    let begun = Instant::now();
    let (mut taken, mut longest, mut done) = (0_u64, Duration::ZERO, 0_u64);
    while done < arguments.cases && begun.elapsed().as_secs_f64() < arguments.seconds {
        let k = arguments.first + done;
        let bytes = case(arguments, reader, &seeds, k);
        let started = Instant::now();
        let Ok(is_taken) = catch_unwind(|| tried.one(&bytes)) else {
            eprintln!("case {k} panicked");
            return Ok(ExitCode::from(PANICKED));
        };
        taken += u64::from(is_taken);
        longest = longest.max(started.elapsed());
        done += 1;
    }
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let peak = peak.and_then(|peak| peak.trim().trim_end_matches("kB").trim().parse().ok());
    let peak: u64 = peak.unwrap_or(0);
    println!(
        "{:<9} {done:>9} {taken:>9} {:>8.1} {:>10.1} {:>9}",
        reader.name(),
        begun.elapsed().as_secs_f64(),
        1e3 * longest.as_secs_f64(),
        peak / 1_000
    );
    std::io::stdout().flush()?;
    if peak > MOST_MEMORY_KB {
        bail!("{} MB were used", peak / 1_000);
    }
    Ok(ExitCode::SUCCESS)
}

/// Runs a reader in a process of its own; whether it did no harm.
fn watched(arguments: &Arguments, reader: Reader, seconds: f64) -> Result<bool> {
    let folder = tempfile::tempdir()?;
    let file = folder.path().join(format!("case.{}", reader.name()));
    let program = std::env::current_exe()?;
    let mut command = Command::new("bash");
    command.args(["-c", &format!("ulimit -v {ADDRESSES_KB}; exec \"$0\" \"$@\"")]).arg(program);
    command.args(["--reader", &reader.name()]).arg("--case").arg(&file);
    for (flag, value) in
        [("--cases", arguments.cases), ("--seed", arguments.seed), ("--first", arguments.first)]
    {
        command.args([flag, &value.to_string()]);
    }
    command.args(["--seconds", &seconds.to_string()]).env("RAYON_NUM_THREADS", "2");
    let mut child = command.stdin(Stdio::null()).spawn().context("cannot start bash")?;
    let ended = wait(&mut child, &file)?;
    let left: Vec<String> = fs::read_dir(folder.path())?
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .filter(|name| Path::new(name).extension().is_none_or(|end| end != reader.name().as_str()))
        .collect();
    let harm = match ended {
        Some(status) if status.success() && left.is_empty() => return Ok(true),
        Some(status) if status.success() => format!("left {}", left.join(", ")),
        Some(status) => status.to_string(),
        None => format!("no end within {} s", LONGEST.as_secs()),
    };
    let kept = arguments.keep.join(format!("{}-seed{}.{0}", reader.name(), arguments.seed));
    // A process that died before its first case has none.
    let _ = fs::copy(&file, &kept);
    eprintln!("{}: {harm}; the case is kept in {}", reader.name(), kept.display());
    Ok(false)
}

/// How a process ends; none if it works on one case for too long.
fn wait(child: &mut Child, file: &Path) -> Result<Option<std::process::ExitStatus>> {
    let begun = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        let written = fs::metadata(file).and_then(|found| found.modified());
        let age = written.ok().and_then(|time| time.elapsed().ok()).unwrap_or(begun.elapsed());
        // Making the seeds takes a while as well.
        if age > LONGEST && begun.elapsed() > 3 * LONGEST {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        sleep(Duration::from_millis(20));
    }
}
