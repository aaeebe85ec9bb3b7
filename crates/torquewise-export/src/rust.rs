//! A program as one file of Rust without `std`: sine and cosine by a trait.

use crate::text::{Angle, Body, Language, number, values};
use crate::{Function, Precision, Program, Result, Role, filled};
use minijinja::context;

struct Rust(Precision);

impl Language for Rust {
    fn constant(&self, value: f64) -> String {
        number(value, self.0)
    }

    fn name(&self, function: Function) -> String {
        String::from(match function {
            Function::Tanh => "F::tanh",
            Function::Exp => "F::exp",
            Function::Sign => "sign",
            Function::Positive => "positive",
            Function::Abs => "abs",
            Function::Reciprocal => "1.0/",
        })
    }

    fn quoted(&self, text: &str) -> String {
        format!("{text:?}")
    }

    fn statements(&self, body: &Body, role: Role, program: &Program) -> Vec<String> {
        let named = |(name, value): &(String, String)| format!("let {name} = {value};");
        let read = body.read(&role.signals(), "self.");
        let mut lines: Vec<String> = read.iter().map(named).collect();
        for (joint, &Angle { sin, cos }) in &body.angles {
            let j = joint + 1;
            let name = |held: bool, letter: char| {
                if held { format!("{letter}{j}") } else { "_".to_owned() }
            };
            lines.push(format!("let ({}, {}) = F::sin_cos(q{j});", name(sin, 's'), name(cos, 'c')));
        }
        lines.extend(body.steps.iter().map(named));
        lines.extend(body.listed("", role.columns(program.n_joints())));
        lines
    }
}

/// A file of Rust that needs `core` alone, a crate or a module; see `docs/export.md`.
///
/// # Errors
/// `ExportError::NotSingle` if a constant is too large for the precision.
pub fn to_rust(program: &Program, precision: Precision) -> Result<String> {
    program.check_precision(precision)?;
    let real = if precision == Precision::Single { "f32" } else { "f64" };
    let values = context! { real, ..values(program, &Rust(precision)) };
    filled("code", include_str!("templates/model.rs.j2"), values)
}
