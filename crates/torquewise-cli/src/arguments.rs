//! Settings that several commands share.

use crate::error::CliError;
use crate::selection::{Friction, SelectionArguments};
use clap::{Args, ValueEnum};
use torquewise::FitOptions;
use torquewise::dynamics::Noise;
use torquewise::identify::PatternPlan;
use torquewise::identify::plan::Regression;
use torquewise::stepwise::activation::Scaling;

/// Constants of the activation index.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(crate) enum Activation {
    /// Each joint by its own range, sensitivity from the noise floor
    #[default]
    Scaled,
    /// The constants printed in the paper
    Paper,
}

/// A number of clusters, or the elbow.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clusters(Option<usize>);

/// How rows are clustered.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct PatternArguments {
    /// Constants of the activation index
    #[arg(long, value_enum, default_value_t)]
    activation: Activation,
    /// Number of clusters from 1 to 9, or `auto` for the elbow
    #[arg(long, value_name = "auto|K", default_value = "auto", value_parser = clusters)]
    clusters: Clusters,
    /// Seed of everything random
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

impl PatternArguments {
    /// The clustering asked for.
    pub(crate) fn plan(self) -> PatternPlan {
        let scaling = match self.activation {
            Activation::Scaled => Scaling::Scaled,
            Activation::Paper => Scaling::Paper,
        };
        PatternPlan { scaling, clusters: self.clusters.0, slow: false, seed: self.seed }
    }
}

/// Which candidates are offered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Library {
    /// M(q) and V(q), shared by all joints: exact for rigid arms of revolute joints; all terms for
    /// up to four joints, or with --interaction, else those of a learned chain
    Energy,
    /// Products of sines, cosines, velocities and accelerations, for each joint on its own
    Product,
    /// Energies of a chain of rigid bodies whose geometry is learned too: for four joints and more,
    /// noisy logs and friction
    Chain,
}

/// How a log becomes a model, the method left open.
#[derive(Args, Clone, Debug)]
pub(crate) struct PlanArguments {
    /// Candidates [default: energy; product with --method sindy; chain for filtered logs, friction,
    /// or five joints and more]
    #[arg(long, value_enum)]
    library: Option<Library>,
    /// Friction of the joints [default: auto with --library chain, else none]
    #[arg(long, value_enum)]
    friction: Option<Friction>,
    /// Energy library: at most this many joint angles in a term [default: as many as are feasible]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u8).range(1..=16))]
    interaction: Option<u8>,
    /// Product library: factors of sine and cosine in a term [default: 4]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=8))]
    trig_order: Option<u8>,
    /// Product library: the same for the gravity step [default: 2]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=8))]
    gravity_order: Option<u8>,
    #[command(flatten)]
    selection: SelectionArguments,
    #[command(flatten)]
    patterns: PatternArguments,
}

impl PlanArguments {
    /// The options of a fit by a method.
    pub(crate) fn options(&self, regression: Regression) -> FitOptions {
        let patterns = self.patterns.plan();
        self.selection.apply_to(FitOptions {
            library: self.library.map(|library| match library {
                Library::Energy => torquewise::Library::Energy,
                Library::Product => torquewise::Library::Product,
                Library::Chain => torquewise::Library::Chain,
            }),
            regression,
            friction: self.friction.map(Into::into),
            interaction: self.interaction.map(usize::from),
            trig_order: self.trig_order,
            gravity_order: self.gravity_order,
            seed: patterns.seed,
            patterns,
            ..FitOptions::default()
        })
    }

    /// Fails where a flag is given that selects terms or fits them.
    ///
    /// # Errors
    /// [`CliError::Usage`] names the flag.
    pub(crate) fn refuse_selection(&self) -> Result<(), CliError> {
        match self.selection.given() {
            None => Ok(()),
            Some(flag) => Err(CliError::Usage(format!(
                "{flag} is not used where logs are only summed up: give it to solve"
            ))),
        }
    }
}

fn clusters(text: &str) -> Result<Clusters, String> {
    if text == "auto" {
        return Ok(Clusters(None));
    }
    match text.parse() {
        Ok(k @ 1..=9) => Ok(Clusters(Some(k))),
        _ => Err("expected `auto` or a number from 1 to 9".to_owned()),
    }
}

/// Signal-to-noise ratios of q, q̇ and q̈ \[dB\], separated by commas; `inf` for no noise.
pub(crate) fn noise_levels(text: &str) -> Result<Noise, String> {
    let expected = || "expected three numbers of dB, such as 60,40,30 or inf,40,30".to_owned();
    let levels: Vec<f64> = text
        .split(',')
        .map(|level| level.trim().parse())
        .collect::<Result<_, _>>()
        .map_err(|_| expected())?;
    match levels[..] {
        [q, dq, ddq] => Noise::from_db(q, dq, ddq).map_err(|error| error.to_string()),
        _ => Err(expected()),
    }
}
