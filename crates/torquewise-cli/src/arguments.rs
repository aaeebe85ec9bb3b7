//! Words of the command line → settings that several commands share.

use crate::error::CliError;
use clap::{Args, ValueEnum};
use torquewise::dynamics::Noise;
use torquewise::identify::activation::Scaling;
use torquewise::identify::plan::FrictionKind;
use torquewise::identify::summary::Settings;
use torquewise::identify::{LibraryKind, Method, PatternPlan, Plan};
use torquewise::sparse::select::Selector;
use torquewise::sparse::select::criterion::Criterion;
use torquewise::sparse::select::lasso::Lasso;
use torquewise::sparse::select::stlsq::Stlsq;

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

/// Friction beside inertia, Coriolis and gravity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Friction {
    /// None
    None,
    /// Offset, viscous and dry friction
    Linear,
    /// The same and the Stribeck curve, forward and backward apart
    Stribeck,
    /// Whichever predicts held-out rows best
    Auto,
}

impl From<Friction> for FrictionKind {
    fn from(friction: Friction) -> Self {
        match friction {
            Friction::None => Self::None,
            Friction::Linear => Self::Linear,
            Friction::Stribeck => Self::Stribeck,
            Friction::Auto => Self::Auto,
        }
    }
}

/// Which terms stay.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Select {
    /// What a term explains against the noise
    Bic,
    /// LASSO, then least squares
    Lasso,
    /// Sequentially thresholded least squares
    Stlsq,
}

/// What becomes of candidates once the rows are summed.
#[derive(Args, Clone, Debug)]
pub(crate) struct SelectionArguments {
    /// Which terms stay; bic, and stlsq for one-shot SINDy
    #[arg(long, value_enum)]
    select: Option<Select>,
    /// Drop coefficients at most this large [paper: 0.1]
    #[arg(long, value_name = "X", value_parser = threshold)]
    threshold: Option<f64>,
    /// Joints that a spring or a weight is known to balance, for --library chain; others are looked
    /// for
    #[arg(long, value_name = "JOINT", value_delimiter = ',')]
    counterbalance: Vec<String>,
    /// Leave the bias that measurement noise causes in the normal equations
    #[arg(long)]
    no_noise_correction: bool,
    /// Resampled logs to count in how many each term stays [default: 50; 0 with --method sindy]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(0..=1000))]
    bags: Option<u16>,
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

/// Joints up to which the whole energy library is offered.
const MOST_WHOLE: usize = 4;

impl PlanArguments {
    /// The plan for one method.
    ///
    /// # Errors
    /// [`CliError::Usage`] if an order is given for the library that is not used.
    pub(crate) fn plan(&self, method: Method, log: Known) -> Result<Plan, CliError> {
        let rubs = self.friction.is_some_and(|friction| friction != Friction::None);
        let many = log.joints > MOST_WHOLE && self.interaction.is_none();
        let balanced = !self.selection.counterbalance.is_empty();
        let usual = match method {
            Method::Sindy => Library::Product,
            _ if log.filtered || rubs || many || balanced => Library::Chain,
            _ => Library::Energy,
        };
        let library = match self.library.unwrap_or(usual) {
            // Its terms are too many to be listed: they are grown along a chain.
            Library::Energy if many && method != Method::Sindy => Library::Chain,
            library => library,
        };
        let misplaced = match library {
            Library::Product if rubs && method == Method::Sindy => {
                "--friction is for stepwise reconstruction"
            }
            Library::Chain if method == Method::Sindy => "--method sindy is for --library product",
            Library::Chain if self.trig_order.is_some() || self.gravity_order.is_some() => {
                "orders are for --library product"
            }
            Library::Energy if self.trig_order.is_some() => "--trig-order is for --library product",
            Library::Energy if self.gravity_order.is_some() => {
                "--gravity-order is for --library product"
            }
            Library::Product | Library::Energy if balanced => {
                "--counterbalance is for --library chain, other libraries offer any function of q"
            }
            Library::Product | Library::Chain if self.interaction.is_some() => {
                "--interaction is for --library energy"
            }
            _ => return Ok(self.plan_with(library, method)),
        };
        Err(CliError::Usage(format!("{misplaced}: leave it out or choose that library")))
    }

    /// Stepwise reconstruction, and one-shot SINDy over the product library beside it.
    pub(crate) fn both_plans(&self) -> (Plan, Plan) {
        let library = self.library.filter(|library| *library != Library::Chain);
        let library = library.unwrap_or(Library::Energy);
        let sindy = self.plan_with(Library::Product, Method::Sindy);
        (self.plan_with(library, Method::Stepwise), sindy)
    }

    fn plan_with(&self, library: Library, method: Method) -> Plan {
        let patterns = self.patterns.plan();
        let plan = Plan {
            library: match library {
                Library::Energy | Library::Chain => {
                    LibraryKind::Energy { interaction: self.interaction.map(usize::from) }
                }
                Library::Product => self.product(),
            },
            seed: patterns.seed,
            patterns,
            method: if library == Library::Chain { Method::Chain } else { method },
            friction: match (self.friction, library) {
                (Some(friction), _) => friction.into(),
                (None, Library::Chain) => FrictionKind::Auto,
                (None, _) => FrictionKind::None,
            },
            ..Plan::default()
        };
        self.selection.applied_to(&plan)
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

impl SelectionArguments {
    /// The plan for moments that were made under these settings.
    ///
    /// # Errors
    /// [`CliError::Usage`] if friction is asked of moments that are not for a chain.
    pub(crate) fn plan_of(
        &self,
        settings: &Settings,
        friction: Option<Friction>,
        seed: u64,
    ) -> Result<Plan, CliError> {
        let (method, patterns) = (settings.method, settings.patterns);
        let friction = match (friction, method) {
            (None | Some(Friction::None), Method::Stepwise | Method::Sindy) => FrictionKind::None,
            (None, Method::Chain) => FrictionKind::Auto,
            (Some(friction), Method::Chain) => friction.into(),
            (Some(_), _) => {
                let message = "--friction is for moments made with --library chain: leave it out";
                return Err(CliError::Usage(message.into()));
            }
        };
        if method != Method::Chain && !self.counterbalance.is_empty() {
            let message = "--counterbalance is for moments made with --library chain";
            return Err(CliError::Usage(message.into()));
        }
        Ok(self.applied_to(&Plan { method, patterns, seed, friction, ..Plan::default() }))
    }

    fn applied_to(&self, plan: &Plan) -> Plan {
        let usual = if plan.method == Method::Sindy { Plan::sindy() } else { Plan::default() };
        Plan {
            selector: self.selector(usual.selector),
            threshold: self.threshold.or(usual.threshold),
            noise_correction: usual.noise_correction && !self.no_noise_correction,
            bags: self.bags.map_or(usual.bags, usize::from),
            counterbalanced: self.counterbalance.clone(),
            ..plan.clone()
        }
    }

    fn selector(&self, usual: Selector) -> Selector {
        let asked = match self.select {
            None => usual,
            Some(Select::Bic) => Selector::Criterion(Criterion::default()),
            Some(Select::Lasso) => Selector::Lasso(Lasso::default()),
            Some(Select::Stlsq) => Selector::Stlsq(Stlsq::default()),
        };
        match (asked, self.threshold) {
            (Selector::Lasso(lasso), Some(threshold)) => {
                Selector::Lasso(Lasso { threshold, ..lasso })
            }
            (Selector::Stlsq(stlsq), Some(threshold)) => {
                Selector::Stlsq(Stlsq { threshold, ..stlsq })
            }
            (other, _) => other,
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

fn threshold(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x >= 0.0 && x.is_finite() => Ok(x),
        _ => Err("expected a number that is zero or more".to_owned()),
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
