//! Words of the command line → settings that several commands share.

use crate::error::CliError;
use crate::flags::{Fitted, Flag, refuse_unused};
use crate::selection::{Friction, SelectionArguments};
use crate::signal_arguments::SignalArguments;
use clap::{Args, ValueEnum};
use torquewise::dynamics::Noise;
use torquewise::identify::plan::Regression;
use torquewise::identify::{LibraryKind, PatternPlan, Plan};
use torquewise::logs::Logs;
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

/// What is known of the logs when a plan is made.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Known {
    /// Number of joints; 0 before they are read.
    pub(crate) joints: usize,
    /// Whether the signals went through a filter.
    pub(crate) filtered: bool,
}

impl Known {
    /// What the columns of logs tell.
    pub(crate) fn of(logs: &Logs, signals: &SignalArguments) -> Self {
        Self { joints: logs.joints().len(), filtered: signals.filters(logs) }
    }
}

/// Joints up to which the whole energy library is offered.
const MOST_WHOLE: usize = 4;

impl PlanArguments {
    /// The plan for one method.
    ///
    /// # Errors
    /// [`CliError::Usage`] if a flag is given that what is fitted does not use.
    pub(crate) fn plan(&self, regression: Regression, log: Known) -> Result<Plan, CliError> {
        let (library, because) = self.fitted(regression, log);
        let fitted = match library {
            Library::Energy => Fitted::Energy(regression),
            Library::Product => Fitted::Product(regression),
            Library::Chain if regression == Regression::OneShot => {
                let message = "--method sindy fits a library, not a chain: leave it out or choose \
                               --library product";
                return Err(CliError::Usage(message.into()));
            }
            Library::Chain => Fitted::Chain,
        };
        refuse_unused(&self.given(), fitted, &because, "choose")?;
        Ok(self.plan_for(fitted))
    }

    /// Stepwise reconstruction, and one-shot SINDy over the product library beside it.
    ///
    /// # Errors
    /// [`CliError::Usage`] if a flag is given that neither of them uses.
    pub(crate) fn both_plans(&self) -> Result<(Plan, Plan), CliError> {
        let stepwise = match self.library {
            None | Some(Library::Energy) => Fitted::Energy(Regression::Stepwise),
            Some(Library::Product) => Fitted::Product(Regression::Stepwise),
            Some(Library::Chain) => {
                let message = "compare sets a library beside one-shot SINDy, not a chain: choose \
                               --library energy|product";
                return Err(CliError::Usage(message.into()));
            }
        };
        let mut given = self.given();
        given.retain(|flag| *flag != Flag::TrigOrder);
        let because = "compare sets it beside one-shot SINDy";
        refuse_unused(&given, stepwise, because, "fit with")?;
        let sindy = self.plan_for(Fitted::Product(Regression::OneShot));
        Ok((self.plan_for(stepwise), sindy))
    }

    /// Fails where a flag is given that selects terms or fits them.
    ///
    /// # Errors
    /// [`CliError::Usage`] names the flag.
    pub(crate) fn refuse_selection(&self) -> Result<(), CliError> {
        let used = [Flag::Counterbalance];
        match self.selection.given().iter().find(|flag| !used.contains(flag)) {
            None => Ok(()),
            Some(flag) => Err(CliError::Usage(format!(
                "{} is not used where logs are only summed up: give it to solve",
                flag.name()
            ))),
        }
    }

    /// What is fitted to a log, and why.
    fn fitted(&self, regression: Regression, log: Known) -> (Library, String) {
        let many = log.joints > MOST_WHOLE && self.interaction.is_none();
        let stepwise = regression == Regression::Stepwise;
        let too_many = format!("the log has {} joints", log.joints);
        match self.library {
            // Its terms are too many to be listed: they are grown along a chain.
            Some(Library::Energy) if many && stepwise => (Library::Chain, too_many),
            Some(library) => (library, "--library asks for it".into()),
            None if !stepwise => (Library::Product, "--method sindy asks for it".into()),
            None if log.filtered => (Library::Chain, "the log is filtered".into()),
            None if self.rubs() => (Library::Chain, "--friction is given".into()),
            None if many => (Library::Chain, too_many),
            None if !self.selection.counterbalance.is_empty() => {
                (Library::Chain, "--counterbalance is given".into())
            }
            None => (Library::Energy, "no other --library is given".into()),
        }
    }

    fn rubs(&self) -> bool {
        self.friction.is_some_and(|friction| friction != Friction::None)
    }

    /// The flags given that not every method uses.
    fn given(&self) -> Vec<Flag> {
        let own = [
            (Flag::Friction, self.rubs()),
            (Flag::Interaction, self.interaction.is_some()),
            (Flag::TrigOrder, self.trig_order.is_some()),
            (Flag::GravityOrder, self.gravity_order.is_some()),
        ];
        let own = own.into_iter().filter(|(_, given)| *given).map(|(flag, _)| flag);
        own.chain(self.selection.given()).collect()
    }

    fn plan_for(&self, fitted: Fitted) -> Plan {
        let patterns = self.patterns.plan();
        let energy = LibraryKind::Energy { interaction: self.interaction.map(usize::from) };
        let method = match fitted {
            Fitted::Energy(regression) => {
                self.selection.library_options(energy, regression, self.friction)
            }
            Fitted::Product(regression) => {
                self.selection.library_options(self.product(), regression, self.friction)
            }
            Fitted::Chain => self.selection.chain_options(self.friction),
        };
        Plan { method, seed: patterns.seed, patterns }
    }

    fn product(&self) -> LibraryKind {
        match LibraryKind::PRODUCT {
            LibraryKind::Product { gravity_order, trig_order } => LibraryKind::Product {
                gravity_order: self.gravity_order.unwrap_or(gravity_order),
                trig_order: self.trig_order.unwrap_or(trig_order),
            },
            other @ LibraryKind::Energy { .. } => other,
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
