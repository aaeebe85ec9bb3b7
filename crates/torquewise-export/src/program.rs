//! The functions that every exported file holds, in few operations.

use crate::lower::lowered;
use crate::momentum::{Factors, coriolis_matrix, momentum};
use crate::parts::{elements, friction, next_states, sums};
use crate::ways::{frictionless, gravity_of};
use crate::{Cost, ExportError, Function, Graph, Id, Node, Result};
use torquewise_model::{Form, Model, Training, number, to_json};

/// What a function of an exported file computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// τ̂(q, q̇, q̈) \[N·m\], n.
    Torque,
    /// G(q) \[N·m\], n.
    Gravity,
    /// C(q, q̇)q̇ \[N·m\], n.
    Coriolis,
    /// M(q) \[kg·m²\], n×n: torque of joint i per unit acceleration of joint j at rest.
    Inertia,
    /// F(q, q̇) \[N·m\], n; q matters to friction under load alone.
    Friction,
    /// G(q) \[N·m\] as the first step of the reconstruction found it, n; G(q) of the whole model
    /// where that was not found stepwise.
    Step1,
    /// C(q, q̇) \[N·m·s\] by Christoffel symbols, n×n.
    CoriolisMatrix,
    /// M(q)⁻¹ \[1/(kg·m²)\], n×n.
    InverseInertia,
    /// q̈ \[rad/s²\] of q, q̇ and the torque of the motors, n.
    ForwardDynamics,
}

impl Quantity {
    /// All, in the order in which they are written.
    pub const ALL: [Self; 9] = [
        Self::Torque,
        Self::Gravity,
        Self::Coriolis,
        Self::Inertia,
        Self::Friction,
        Self::Step1,
        Self::CoriolisMatrix,
        Self::InverseInertia,
        Self::ForwardDynamics,
    ];

    /// `torque`, `gravity`, `coriolis`, `inertia`, `friction`, `step1`, `coriolis_matrix`,
    /// `inverse_inertia` or `forward_dynamics`.
    pub fn name(self) -> &'static str {
        ROWS[self as usize].0
    }

    /// The signals it is a function of, of q, q̇, q̈ and τ: `q`, `dq`, `ddq`, `tau`.
    pub fn signals(self) -> &'static [&'static str] {
        ROWS[self as usize].1
    }

    /// Whether its results are a matrix, n×n.
    pub fn is_matrix(self) -> bool {
        self.result() == "m"
    }

    /// What its results are called: `tau`, `ddq`, or `m` for a matrix.
    pub(crate) fn result(self) -> &'static str {
        ROWS[self as usize].2
    }

    /// What it computes, in ASCII.
    pub(crate) fn formula(self) -> &'static str {
        ROWS[self as usize].3
    }
}

/// Name, signals, results and formula of each quantity.
const ROWS: [(&str, &[&str], &str, &str); 9] = [
    ("torque", &["q", "dq", "ddq"], "tau", "M ddq + C dq + G + F"),
    ("gravity", &["q"], "tau", "G(q)"),
    ("coriolis", &["q", "dq"], "tau", "C(q, dq) dq"),
    ("inertia", &["q"], "m", "M(q), row by row"),
    ("friction", &["q", "dq"], "tau", "F(q, dq)"),
    ("step1", &["q"], "tau", "G(q) of step 1"),
    ("coriolis_matrix", &["q", "dq"], "m", "C(q, dq), row by row"),
    ("inverse_inertia", &["q"], "m", "1/M(q), row by row"),
    ("forward_dynamics", &["q", "dq", "tau"], "ddq", "(tau - C dq - G - F)/M"),
];

/// Precision of the numbers in exported code.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// 64 bits.
    #[default]
    Double,
    /// 32 bits, for controllers without hardware for more.
    Single,
}

/// What a function of an exported file is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    Function(Quantity),
    /// A function at the state that friction remembers, that of Dahl elements (E13).
    After(Quantity),
    /// States of the Dahl elements after a step from the last q to the next, one for each.
    Step,
    /// Momentum p, and the part of its change that is neither motor nor external: Cᵀq̇ − G − F,
    /// friction at its states; 2n.
    Momentum,
}

/// Functions of a model, ready to be written in any language.
#[derive(Clone, Debug)]
pub struct Program {
    pub(crate) model: Model,
    pub(crate) graph: Graph,
    /// Results of each function.
    pub(crate) functions: Vec<(Role, Vec<Id>)>,
    /// Dahl elements whose states friction remembers.
    pub(crate) n_elements: usize,
    pub(crate) fingerprint: u64,
}

impl Program {
    /// The program of a model, the cheapest of those it knows to build.
    ///
    /// # Errors
    /// [`ExportError::Model`] if the parts of the model do not fit together,
    /// [`ExportError::NotFinite`] if its coefficients are too large to be multiplied.
    pub fn of(model: &Model) -> Result<Self> {
        let fingerprint = fingerprint(&to_json(model)?);
        let graph = Graph::default();
        let n = model.n_joints();
        let parts = frictionless(&graph, model)?;
        let first = match (model.stages.len(), &model.chain) {
            (0, Some(_)) => parts.gravity.clone(),
            (0, None) => gravity_of(&graph, &model.form, n),
            _ => gravity_of(&graph, &model.after_step(1)?.form, n),
        };
        let factors = Factors::of(&graph, &parts.matrix, n);
        let own = friction(&graph, &model.friction, &parts.gravity, &[]);
        let elements = elements(&model.friction);
        let remembered = friction(&graph, &model.friction, &parts.gravity, &elements);
        let mut functions = Vec::new();
        if !elements.is_empty() {
            let torque = sums(&graph, &parts.torque, &remembered);
            let accelerations = factors.accelerations(&graph, &parts, &remembered);
            functions.extend([
                (Role::After(Quantity::Torque), torque),
                (Role::After(Quantity::Friction), remembered.clone()),
                (Role::After(Quantity::ForwardDynamics), accelerations),
                (Role::Step, next_states(&graph, &elements)),
            ]);
        }
        functions.push((Role::Momentum, momentum(&graph, &parts, &remembered)));
        let coriolis_matrix = coriolis_matrix(&graph, &parts.coriolis);
        let inverse = factors.inverse(&graph);
        let accelerations = factors.accelerations(&graph, &parts, &own);
        let whole = [
            (Quantity::Torque, sums(&graph, &parts.torque, &own)),
            (Quantity::Gravity, parts.gravity),
            (Quantity::Coriolis, parts.coriolis),
            (Quantity::Inertia, parts.matrix),
            (Quantity::Friction, own),
            (Quantity::Step1, first),
            (Quantity::CoriolisMatrix, coriolis_matrix),
            (Quantity::InverseInertia, inverse),
            (Quantity::ForwardDynamics, accelerations),
        ];
        functions.extend(whole.map(|(quantity, roots)| (Role::Function(quantity), roots)));
        let roots: Vec<Id> = functions.iter().flat_map(|(_, roots)| roots).copied().collect();
        let (graph, lower) = lowered(&graph, &roots);
        let roots = functions.iter_mut().flat_map(|(_, roots)| roots);
        roots.zip(lower).for_each(|(root, lower)| *root = lower);
        if graph.constants().any(|constant| !constant.is_finite()) {
            return Err(ExportError::NotFinite);
        }
        Ok(Self { model: model.clone(), graph, functions, n_elements: elements.len(), fingerprint })
    }

    /// Number of joints n.
    pub fn n_joints(&self) -> usize {
        self.model.n_joints()
    }

    /// The program that made it, and which model it was made of:
    /// `torquewise 0.1.0, model 4f1d0c66a8f2b7e9`.
    pub fn version(&self) -> String {
        let own =
            format!("torquewise {}, model {:016x}", env!("CARGO_PKG_VERSION"), self.fingerprint);
        match self.model.training.useless() {
            Some(_) => format!("{own}, unusable by the verdict of its fit"),
            None => own,
        }
    }

    /// What a call of a function costs.
    pub fn cost(&self, quantity: Quantity) -> Cost {
        Cost::of(&self.graph, self.roots(quantity))
    }

    fn roots(&self, quantity: Quantity) -> &[Id] {
        let known = self.functions.iter().find(|(role, _)| *role == Role::Function(quantity));
        known.map_or(&[], |(_, roots)| roots)
    }

    /// What a user has to know of this model, in ASCII.
    pub(crate) fn remarks(&self) -> Vec<String> {
        let Model { chain, form, stages, training, .. } = &self.model;
        let kinds = self.model.kinds();
        let apart = chain.is_none() && matches!(form, Form::Torque(_));
        let is_zero = |root: &Id| self.graph.value(*root) == Some(0.0);
        let known = [
            (apart, "Each joint was fitted on its own: entry (i, j) of M is the torque of joint"),
            (apart, "i per unit acceleration of joint j at rest, and M is not symmetric."),
            (stages.is_empty(), "The model was not found step by step: step1 is gravity."),
            (self.roots(Quantity::Friction).iter().all(is_zero), "The model has no friction."),
        ];
        let known = known.into_iter().filter(|(holds, _)| *holds);
        let mut remarks: Vec<String> = known.map(|(_, remark)| remark.to_owned()).collect();
        let Training { filter, q_range, dq_peak, .. } = training;
        if let Some(filter) = filter {
            let [hz, ms] = [filter.cutoff_hz, 1e3 * filter.delay.abs()].map(number);
            let when = if filter.delay < 0.0 { "before" } else { "after" };
            let late = format!("; its torque came {ms} ms {when} it, which is taken out here");
            let late = if filter.delay == 0.0 { "" } else { &late };
            remarks.push(format!("Fitted to motion below {hz} Hz{late}."));
        }
        if !q_range.is_empty() {
            remarks.push("Fitted within these ranges, beyond them it extrapolates:".to_owned());
        }
        remarks.extend((1..).zip(q_range.iter().zip(dq_peak)).map(|(joint, (q, peak))| {
            let [low, high, peak] = [q[0], q[1], *peak].map(number);
            let unit = kinds.of(joint - 1).unit;
            format!("  q{joint} from {low} to {high} {unit}, |dq{joint}| up to {peak} {unit}/s")
        }));
        if !kinds.all_turn() {
            remarks.push("Of joints that slide read m for rad, and N for N m.".to_owned());
        }
        let derived = "Derived from measurements: bound what it commands before it drives an arm.";
        remarks.push(derived.to_owned());
        remarks
    }

    pub(crate) fn calls(&self, function: Function) -> bool {
        let calls = |id| matches!(self.graph.node(id), Node::Call(f, _) if f == function);
        (0..self.graph.len()).any(calls)
    }

    pub(crate) fn check_precision(&self, precision: Precision) -> Result<()> {
        let large = self.graph.constants().find(|constant| constant.abs() > f64::from(f32::MAX));
        let large = large.filter(|_| precision == Precision::Single);
        large.map_or(Ok(()), |constant| Err(ExportError::NotSingle { constant }))
    }
}

/// FNV-1a of a text, 64 bits: tells two models apart, and is the same on every machine.
fn fingerprint(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}
