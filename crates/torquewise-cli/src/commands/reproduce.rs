//! `torquewise reproduce`: the simulated experiments of the paper and those beyond it.

use crate::files::create_folder;
use crate::progress::share_bar;
use crate::{CliError, Outcome, Result, check_files, write_whole};
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use std::time::Instant;
use torquewise_paper::{Claim, PaperError, Settings, page, reproduce};

/// Do the simulated experiments of the paper, and those beyond it: figures, tables, report
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Folder for report.html, results.json and the figures
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// First of the seeds
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of seeds of each case of noise [default: 10]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    seeds: Option<u16>,
    /// Everything in small, with an arm of two joints: to see what it does, not for its numbers
    #[arg(long)]
    quick: bool,
}

fn failed(source: PaperError) -> CliError {
    CliError::Experiment { source }
}

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let Arguments { output, seed, quick, .. } = arguments;
    let usual = if *quick { Settings::quick(*seed) } else { Settings::full(*seed) };
    let seeds = arguments.seeds.map_or(usual.seeds, u64::from);
    let settings = Settings { seeds, ..usual };
    create_folder(output)?;
    let report = output.join("report.html");
    let numbers = output.join("results.json");
    check_files([], [&report, &numbers].map(|file| (file.as_path(), &[][..])))?;
    let start = Instant::now();
    let results = {
        let bar = share_bar();
        reproduce(&settings, &|progress| {
            bar.set_length(progress.total as u64);
            bar.set_position(progress.done as u64);
            bar.set_message(progress.doing);
        })
        .map_err(failed)?
    };
    let seconds = start.elapsed().as_secs_f64();

    write_whole(&numbers, &results.to_json().map_err(failed)?)?;
    write_whole(&report, &page(&results).map_err(failed)?)?;
    let mut files = Vec::new();
    for figure in results.figures() {
        let file = output.join(format!("{}.svg", figure.name));
        write_whole(&file, &figure.svg().map_err(failed)?)?;
        files.push(file.display().to_string());
    }
    let claim = |claim: &Claim| {
        let Claim { claim, source, measured, verdict } = claim;
        let verdict = verdict.name();
        format!("{source}: {verdict}\n  claim: {claim}\n  here:  {measured}\n")
    };
    let report = report.display().to_string();
    let text = format!(
        "{}\n{} figures, results.json and report.html in {}, {seconds:.0} s\nreport: {report}\n",
        results.claims().map(claim).collect::<Vec<_>>().join("\n"),
        files.len(),
        output.display(),
    );
    let json = json!({
        "claims": results.claims().collect::<Vec<_>>(),
        "report": report,
        "results": numbers.display().to_string(),
        "figures": files,
        "seconds": seconds,
    });
    Ok(Outcome { text, json, ..Outcome::default() })
}
