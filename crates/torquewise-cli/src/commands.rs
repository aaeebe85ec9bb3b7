//! The commands, and their words on the command line.

mod simulate;
mod excite;
mod inspect;
mod patterns;
mod orders;
mod fit;
mod moments;
mod merge;
mod solve;
mod show;
mod predict;
mod evaluate;
mod payload;
mod contacts;
mod compare;
mod export;
mod control;
mod reproduce;
mod demo;
mod serve;
mod completions;

use crate::{Outcome, Result};
use clap::{Parser, Subcommand};
use std::ffi::OsString;

/// From the motion log of a robot arm to its equations of motion
///
/// A LOG is a ROS 2 bag (.db3, .mcap) of JointState messages, or a .csv, .parquet, .npz or .mat
/// file with the columns t, q1…qn, dq1…dqn, ddq1…ddqn, tau1…taun in SI units; dq and ddq may be
/// missing, and joints counted from 0. A profile (--profile) tells of other columns and units. Exit
/// codes: 0 done, also with warnings, 1 failed, 2 wrong usage, 3 the verdict of a fit is `unusable`,
/// or --strict and any warning.
#[derive(Debug, Parser)]
#[command(name = "torquewise", version, propagate_version = true)]
pub(crate) struct CommandLine {
    /// Print one JSON object on stdout and nothing else there
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Exit with 3 if there is any warning
    #[arg(long, global = true)]
    pub(crate) strict: bool,
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// Every command, in the order in which one meets them.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Demo(demo::Arguments),
    Simulate(simulate::Arguments),
    Excite(excite::Arguments),
    Inspect(inspect::Arguments),
    Patterns(patterns::Arguments),
    Orders(orders::Arguments),
    Fit(fit::Arguments),
    Moments(moments::Arguments),
    Merge(merge::Arguments),
    Solve(solve::Arguments),
    Show(show::Arguments),
    Predict(predict::Arguments),
    Evaluate(evaluate::Arguments),
    Payload(payload::Arguments),
    #[command(visible_alias = "residuals")]
    Contacts(contacts::Arguments),
    Compare(compare::Arguments),
    Export(export::Arguments),
    Control(control::Arguments),
    Reproduce(reproduce::Arguments),
    Serve(serve::Arguments),
    Completions(completions::Arguments),
}

impl Command {
    /// - `words`: of the whole line, for reports
    pub(crate) fn run(&self, words: &[OsString]) -> Result<Outcome> {
        match self {
            Self::Demo(arguments) => demo::run(arguments),
            Self::Simulate(arguments) => simulate::run(arguments),
            Self::Excite(arguments) => excite::run(arguments),
            Self::Inspect(arguments) => inspect::run(arguments),
            Self::Patterns(arguments) => patterns::run(arguments),
            Self::Orders(arguments) => orders::run(arguments),
            Self::Fit(arguments) => fit::run(arguments, words),
            Self::Moments(arguments) => moments::run(arguments),
            Self::Merge(arguments) => merge::run(arguments),
            Self::Solve(arguments) => solve::run(arguments),
            Self::Show(arguments) => show::run(arguments),
            Self::Predict(arguments) => predict::run(arguments),
            Self::Evaluate(arguments) => evaluate::run(arguments),
            Self::Payload(arguments) => payload::run(arguments),
            Self::Contacts(arguments) => contacts::run(arguments),
            Self::Compare(arguments) => compare::run(arguments),
            Self::Export(arguments) => export::run(arguments),
            Self::Control(arguments) => control::run(arguments),
            Self::Reproduce(arguments) => reproduce::run(arguments),
            Self::Serve(arguments) => serve::run(arguments),
            Self::Completions(arguments) => completions::run(arguments),
        }
    }
}
