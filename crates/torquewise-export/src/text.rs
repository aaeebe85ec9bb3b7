//! Functions as statements, in the signs that C, Rust and Python share, for the templates.

use crate::{Cost, Function, Graph, Id, Input, Node, Precision, Program, Role};
use minijinja::{Value, context};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Longest expression that is written in one line; longer ones are given names in between.
const LINE: usize = 84;

/// How a language writes what it does not share with the others.
pub(crate) trait Language {
    fn constant(&self, value: f64) -> String;
    fn name(&self, function: Function) -> String;
    fn quoted(&self, text: &str) -> String;
    fn statements(&self, body: &Body, role: Role, program: &Program) -> Vec<String>;
}

/// A string literal: `marked` letters behind a backslash, what is not plain by the code of its number.
pub(crate) fn quoted(
    letters: impl Iterator<Item = char>,
    marked: &str,
    code: fn(u32) -> String,
) -> String {
    let letter = |letter: char| match letter {
        _ if marked.contains(letter) => format!("\\{letter}"),
        ' '..='~' => letter.to_string(),
        _ => code(letter.into()),
    };
    format!("\"{}\"", letters.map(letter).collect::<String>())
}

impl Role {
    /// The signals that are given; what else is read is part of the state.
    pub(crate) fn signals(self) -> Vec<&'static str> {
        match self {
            Self::Function(quantity) => quantity.signals().to_vec(),
            // The state knows q.
            Self::After(quantity) => {
                quantity.signals().iter().copied().filter(|signal| *signal != "q").collect()
            }
            Self::Step => vec!["q"],
            Self::Momentum => vec!["q", "dq"],
        }
    }

    /// The columns in which results are set, if they are a matrix.
    pub(crate) fn columns(self, n_joints: usize) -> Option<usize> {
        let is_matrix = match self {
            Self::Function(quantity) | Self::After(quantity) => quantity.is_matrix(),
            Self::Step => false,
            Self::Momentum => true,
        };
        is_matrix.then_some(n_joints)
    }
}

/// A number as C, Rust and Python write it.
pub(crate) fn number(value: f64, precision: Precision) -> String {
    match precision {
        Precision::Double => format!("{value:?}"),
        #[expect(clippy::cast_possible_truncation, reason = "single precision is asked for")]
        Precision::Single => format!("{:?}", value as f32),
    }
}

/// What the template of a language is filled with.
pub(crate) fn values(program: &Program, language: &impl Language) -> Value {
    let view = |(role, roots): &(Role, Vec<Id>)| {
        let body = Body::of(&program.graph, roots, language);
        let signals = role.signals();
        let unread = signals.iter().copied().filter(|signal| !body.reads(signal));
        let cost = Cost::of(&program.graph, roots);
        let part = context! {
            unread => unread.collect::<Vec<_>>(),
            cost => cost.to_string(),
            lines => language.statements(&body, *role, program),
            signals,
        };
        let (Role::Function(quantity) | Role::After(quantity)) = role else { return part };
        let (name, formula) = (quantity.name(), quantity.formula());
        context! {
            name, formula,
            is_matrix => quantity.is_matrix(),
            result => quantity.result(),
            count => roots.len(),
            summary => format!("{name:18}{formula:24}{cost}"),
            ..part
        }
    };
    let of = |counts: fn(&Role) -> bool| -> Vec<Value> {
        program.functions.iter().filter(|(role, _)| counts(role)).map(view).collect()
    };
    let memory = (program.n_elements > 0).then(|| {
        context! {
            elements => program.n_elements,
            step => of(|role| *role == Role::Step).pop(),
            after => of(|role| matches!(role, Role::After(_))),
        }
    });
    let version = program.version();
    context! {
        memory,
        n => program.n_joints(),
        steps => program.model.stages.len(),
        quoted_version => language.quoted(&version),
        version,
        remarks => program.remarks(),
        joints => program.model.joints.iter().map(|own| language.quoted(own)).collect::<Vec<_>>(),
        has_sign => program.calls(Function::Sign),
        has_positive => program.calls(Function::Positive),
        has_abs => program.calls(Function::Abs),
        functions => of(|role| matches!(role, Role::Function(_))),
        momentum => of(|role| *role == Role::Momentum).pop(),
    }
}

/// Which of sin and cos of one joint are needed; `s1` and `c1`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Angle {
    pub(crate) sin: bool,
    pub(crate) cos: bool,
}

/// A function as statements: signals are read, sines and cosines computed, steps named one by one,
/// and results are expressions of all these.
#[derive(Clone, Debug, Default)]
pub(crate) struct Body {
    pub(crate) inputs: BTreeSet<Input>,
    /// By the joint, counted from 0.
    pub(crate) angles: BTreeMap<usize, Angle>,
    pub(crate) steps: Vec<(String, String)>,
    pub(crate) results: Vec<String>,
}

impl Body {
    /// The statements that compute some nodes of a graph whose angle functions are sin q and cos q.
    pub(crate) fn of(graph: &Graph, roots: &[Id], language: &impl Language) -> Self {
        let order = graph.reachable(roots);
        let mut uses: HashMap<Id, usize> = HashMap::new();
        let operands = order.iter().flat_map(|&id| graph.node(id).operands());
        for id in operands.chain(roots.iter().copied()) {
            *uses.entry(id).or_insert(0) += 1;
        }
        let mut body = Self::default();
        let mut texts: HashMap<Id, Text> = HashMap::new();
        for id in order {
            let node = graph.node(id);
            let text = body.text(&node, &mut texts, language);
            texts.insert(id, text);
            if uses.get(&id).is_some_and(|&uses| uses > 1) {
                body.name(id, &mut texts);
            }
        }
        body.results = roots.iter().map(|root| texts[root].text.clone()).collect();
        body
    }

    /// Whether it reads a signal, by the name that [`signal_of`] has for it.
    pub(crate) fn reads(&self, signal: &str) -> bool {
        self.inputs.iter().any(|&input| signal_of(input).0 == signal)
    }

    /// Each signal by the name of its entry, and where it is read from.
    ///
    /// - `state`: what entries of the state begin with, which signals that are not given are read from
    pub(crate) fn read(&self, given: &[&str], state: &str) -> Vec<(String, String)> {
        let read = |&input: &Input| {
            let (signal, joint) = signal_of(input);
            let from = match signal {
                _ if given.contains(&signal) => signal.to_owned(),
                "x" => format!("{state}x"),
                _ => format!("{state}q"),
            };
            (format!("{signal}{}", joint + 1), format!("{from}[{joint}]"))
        };
        self.inputs.iter().map(read).collect()
    }

    /// The results as an array of Rust or a list of Python, line by line.
    ///
    /// - `before`: what its first line begins with
    /// - `columns`: in which they are set, if they are a matrix
    pub(crate) fn listed(&self, before: &str, columns: Option<usize>) -> Vec<String> {
        let mut lines = vec![format!("{before}[")];
        if let Some(columns) = columns {
            for row in self.results.chunks(columns.max(1)) {
                lines.push("    [".into());
                lines.extend(row.iter().map(|entry| format!("        {entry},")));
                lines.push("    ],".into());
            }
        } else {
            lines.extend(self.results.iter().map(|entry| format!("    {entry},")));
        }
        lines.push("]".into());
        lines
    }

    /// The expression of a node; notes what it reads.
    fn text(
        &mut self,
        node: &Node,
        texts: &mut HashMap<Id, Text>,
        language: &impl Language,
    ) -> Text {
        let plain = |text: String| Text { text, level: Level::Name };
        match node {
            Node::Constant(bits) => {
                let value = f64::from_bits(*bits);
                let level = if value < 0.0 { Level::Product } else { Level::Name };
                return Text { text: language.constant(value), level };
            }
            Node::Input(input) => {
                self.inputs.insert(*input);
                let (signal, joint) = signal_of(*input);
                return plain(format!("{signal}{}", joint + 1));
            }
            Node::Sin(multiples) | Node::Cos(multiples) => {
                let joint = multiples.iter().position(|&k| k != 0).unwrap_or(0);
                self.inputs.insert(Input::Q(joint));
                let angle = self.angles.entry(joint).or_default();
                let is_sin = matches!(node, Node::Sin(_));
                angle.sin |= is_sin;
                angle.cos |= !is_sin;
                return plain(format!("{}{}", if is_sin { 's' } else { 'c' }, joint + 1));
            }
            _ => {}
        }
        loop {
            let joined = joined(node, texts, language);
            let operands = node.operands();
            let longest = operands.into_iter().max_by_key(|id| texts[id].text.len());
            match longest {
                Some(id) if joined.text.len() > LINE && texts[&id].level != Level::Name => {
                    self.name(id, texts);
                }
                _ => return joined,
            }
        }
    }

    /// Makes a step of a node, so that others may call it by name.
    fn name(&mut self, id: Id, texts: &mut HashMap<Id, Text>) {
        let unnamed = texts.get_mut(&id).filter(|text| text.level != Level::Name);
        let Some(text) = unnamed else { return };
        let name = format!("t{}", self.steps.len() + 1);
        let named = Text { text: name.clone(), level: Level::Name };
        self.steps.push((name, std::mem::replace(text, named).text));
    }
}

/// What may stand beside it without brackets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Level {
    Sum,
    Product,
    /// A call: needs no brackets, but is worth a name.
    Call,
    Name,
}

#[derive(Clone, Debug)]
struct Text {
    text: String,
    level: Level,
}

impl Text {
    /// In brackets if it binds less than asked for.
    fn at(&self, level: Level) -> String {
        if self.level < level { format!("({})", self.text) } else { self.text.clone() }
    }
}

/// `q`, `dq`, `ddq`, `tau` or `last` and the joint, or `x` and the Dahl element.
pub(crate) fn signal_of(input: Input) -> (&'static str, usize) {
    match input {
        Input::Q(joint) => ("q", joint),
        Input::Dq(joint) => ("dq", joint),
        Input::Ddq(joint) => ("ddq", joint),
        Input::Tau(joint) => ("tau", joint),
        Input::Last(joint) => ("last", joint),
        Input::Element(element) => ("x", element),
    }
}

fn joined(node: &Node, texts: &HashMap<Id, Text>, language: &impl Language) -> Text {
    let at = |id: &Id, level| texts[id].at(level);
    // Before its sign an operand of the same level needs no brackets, behind it one of `of_b`.
    let signed =
        |a, level, sign, b, of_b| (level, format!("{}{sign}{}", at(a, level), at(b, of_b)));
    let (level, text) = match node {
        Node::Add(a, b) => signed(a, Level::Sum, " + ", b, Level::Product),
        Node::Sub(a, b) => signed(a, Level::Sum, " - ", b, Level::Product),
        Node::Mul(a, b) => signed(a, Level::Product, "*", b, Level::Call),
        Node::Neg(a) => (Level::Product, format!("-{}", at(a, Level::Product))),
        Node::Call(function, a) => {
            let is_reciprocal = *function == Function::Reciprocal;
            let level = if is_reciprocal { Level::Product } else { Level::Call };
            (level, format!("{}({})", language.name(*function), at(a, Level::Sum)))
        }
        Node::Constant(_) | Node::Input(_) | Node::Sin(_) | Node::Cos(_) => {
            (Level::Name, String::new())
        }
    };
    Text { text, level }
}
