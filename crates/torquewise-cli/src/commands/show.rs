//! What a model holds: what was learned of the arm, its equations, and whether they are physics.

use crate::arguments::{Word, choice};
use crate::{CliError, Outcome, Result, Table, call_costs, object, read_model};
use clap::builder::RangedU64ValueParser;
use clap::{Args, ValueEnum};
use serde_json::Value;
use std::path::PathBuf;
use torquewise::describe::description;
use torquewise::model::model::Choice;
use torquewise::model::selection::Selection;
use torquewise::model::{Kind, Model, learned, number, print};
use torquewise::physics::{PhysicsCheck, STATES};
use torquewise::summary::repairs_text;

/// Print what was learned of the arm, and the equations of the model
#[derive(Args, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "one for each flag")]
pub(crate) struct Arguments {
    /// Model file
    model: PathBuf,
    /// How to print
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Show one joint only, by its name or number
    #[arg(long, value_name = "J")]
    joint: Option<String>,
    /// Show one part of the torque only
    #[arg(long, value_parser = choice(&PARTS))]
    part: Option<Kind>,
    /// Show the N largest coefficients of each sum only
    #[arg(long, value_name = "N")]
    #[arg(value_parser = clap::value_parser!(u16).range(1..))]
    top: Option<u16>,
    /// Show every term, also those that cannot be told from zero
    #[arg(long)]
    all: bool,
    /// Show what was chosen on held-out data, and from what
    #[arg(long)]
    explain: bool,
    /// Check at random states that M(q) is symmetric and positive definite and dM/dt − 2C skew,
    /// and at all speeds up to the trained peak that friction takes power
    ///
    /// States are drawn from the training range, and again with each joint anywhere from −π to π.
    /// The constant offset of friction is left aside.
    #[arg(long)]
    check: bool,
    /// Random states of each range
    #[arg(long, value_name = "N", default_value_t = STATES, requires = "check")]
    #[arg(value_parser = RangedU64ValueParser::<usize>::new().range(1..=10_000_000))]
    states: usize,
    /// Count what a call of the torque costs a controller, after each step and whole
    #[arg(long)]
    cost: bool,
}

/// How equations are printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Plain text, ± standard error
    #[default]
    Text,
    /// A LaTeX align* environment
    Latex,
    /// One JSON object, as with --json
    Json,
}

const PARTS: [Word<Kind>; 4] = [
    ("inertia", "M(q) q̈", Kind::Inertia),
    ("coriolis", "C(q, q̇) q̇", Kind::Coriolis),
    ("gravity", "G(q)", Kind::Gravity),
    ("friction", "F(q, q̇)", Kind::Friction),
];

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let model = read_model(&arguments.model)?;
    let selection = arguments.selection(&model)?;
    let physics =
        arguments.check.then(|| PhysicsCheck::of(&model, arguments.states)).transpose()?;
    let costs = arguments.cost.then(|| call_costs::of(&model)).transpose()?;
    let mut json = description(&model, &selection)?;
    json["checks"] = physics.as_ref().map_or(Value::Null, object);
    json["costs"] = costs.as_deref().map_or(Value::Null, call_costs::json);
    let mut text = match arguments.format {
        Format::Text => learned_text(&model, &selection)? + &print::text(&model, &selection),
        Format::Latex => print::latex(&model, &selection),
        Format::Json => json.to_string() + "\n",
    };
    if arguments.format == Format::Text {
        if arguments.explain {
            text.extend(model.choices.iter().map(choice_text));
        }
        text.push_str(&repairs_text(&model.training.conditioning));
        text.extend(physics.as_ref().map(|physics| format!("\n{physics}")));
        text.extend(costs.as_deref().map(call_costs::text));
    }
    let warnings = physics.iter().filter_map(PhysicsCheck::warning).collect();
    Ok(Outcome { text, json, warnings, ..Outcome::default() })
}

impl Arguments {
    fn selection(&self, model: &Model) -> Result<Selection> {
        let joint = |wanted: &String| {
            let named = model.joints.iter().position(|name| name == wanted);
            let number = || wanted.parse::<usize>().ok()?.checked_sub(1);
            named.or_else(number).filter(|joint| *joint < model.n_joints()).ok_or_else(|| {
                CliError::Usage(format!(
                    "--joint {wanted}: the model has the joints {}: name one of them, or its \
                     number from 1 on",
                    model.joints.join(", ")
                ))
            })
        };
        Ok(Selection {
            joint: self.joint.as_ref().map(joint).transpose()?,
            part: self.part,
            top: self.top.map(usize::from),
            all: self.all,
        })
    }
}

/// What was learned of the arm: geometry, inertial parameters, rotors and springs, friction.
fn learned_text(model: &Model, selection: &Selection) -> Result<String> {
    let mut text = Vec::new();
    if let (Some(chain), true) = (&model.chain, selection.part.is_none()) {
        let joints = &model.joints;
        let axes = learned::joint_geometry(model)?;
        let geometry = Table::of(learned::geometry(model, &axes, selection));
        text.push(format!("{GEOMETRY}\n{}\n", geometry.text()));
        text.extend(learned::taken_as_found(model).map(|told| told + "\n\n"));
        let links = Table::of(learned::links(chain, joints, selection)?);
        text.push(format!("{LINKS}\n{}\n", links.text()));
        let drives = learned::drives(chain, joints, selection);
        if drives.len() > 1 && selection.joint.is_none() {
            text.push(format!(
                "Rotors and springs, – where none is resolved\n\n{}\n",
                Table::of(drives).text()
            ));
        }
    }
    if selection.has_part(Kind::Friction) {
        let mut tables = print::friction_tables(model);
        if let Some(joint) = selection.joint {
            let name = &model.joints[joint];
            for table in &mut tables {
                let rows = table.split_off(1);
                table.extend(rows.into_iter().filter(|cells| cells[0].contains(name)));
            }
            tables.retain(|table| table.len() > 1);
        }
        if !tables.is_empty() {
            text.push(FRICTION.to_owned());
            text.extend(tables.into_iter().map(|table| Table::of(table).text() + "\n"));
        }
    }
    Ok(text.concat())
}

const GEOMETRY: &str = "Geometry at q = 0, z up, – where there is none; no torque tells where a joint \
                        lies along its own axis\n";

const LINKS: &str = "Links, ± standard error, – where it is not resolved: first moments [kg·m] and \
                     moments of inertia\nabout the origin of the joint [kg·m²]; mass, m·z and Iyy \
                     are counted into the link before\n";

const FRICTION: &str = "Friction, ± standard error, – where it is not resolved\n\
    F_c Coulomb, F_s static, v_s Stribeck speed, F_v viscous; stiffness, travel: of reversals\n\
    \n";

fn choice_text(choice: &Choice) -> String {
    let Choice { what, chosen, rule, from } = choice;
    if from.is_empty() {
        return format!("\n{what}: {chosen} ({rule})\n");
    }
    let mut table = Table::new(["candidate", "error [%]", "± [%]", "coefficients", ""]);
    for candidate in from {
        let [error, std_error] = [candidate.error, candidate.std_error].map(|x| number(100.0 * x));
        let mark = if candidate.label == *chosen { "chosen" } else { "" };
        let coefficients = candidate.complexity.to_string();
        table.row(&candidate.label, [error, std_error, coefficients, mark.to_owned()]);
    }
    format!("\n{what}: {chosen}, chosen on held-out data ({rule})\n\n{}", table.text())
}
