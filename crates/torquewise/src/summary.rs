//! What a fit found in numbers: the object that programs read.

use crate::{FitResult, Result};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use torquewise_motion::Repairs;

/// What was repaired in all logs, and in each by its name; logs that are sound are not listed.
pub fn all_repairs(logs: &BTreeMap<String, Repairs>) -> Value {
    json!({ "total": logs.values().sum::<Repairs>(), "logs": logs })
}

/// What was repaired in all logs together, in words; none if they are sound.
pub fn repairs_note(logs: &BTreeMap<String, Repairs>) -> Option<String> {
    (!logs.is_empty()).then(|| logs.values().sum::<Repairs>().to_string())
}

/// What was repaired in each log, a line each; nothing if they are sound.
pub fn repairs_text(logs: &BTreeMap<String, Repairs>) -> String {
    if logs.is_empty() {
        return String::new();
    }
    let line = |(log, repairs): (&String, &Repairs)| format!("{log}: {repairs}\n");
    format!("\nconditioning\n{}", logs.iter().map(line).collect::<String>())
}

impl FitResult {
    /// What was found in numbers, for programs; percentages are of the standard deviation of the
    /// torque of a joint.
    ///
    /// # Errors
    /// `Error::Model` if M(q) cannot be computed.
    pub fn summary(&self) -> Result<Value> {
        let (verdict, model) = (self.verdict(), &self.model);
        let training = &model.training;
        let percent = |rms: &[f64]| -> Vec<f64> {
            rms.iter().zip(&training.torque_std).map(|(rms, std)| 100.0 * rms / std).collect()
        };
        let steps = self.steps.iter().zip(&self.step_seconds).map(|(step, seconds)| {
            let mut step = json!(step);
            step["seconds"] = json!(seconds);
            step
        });
        Ok(json!({
            "verdict": verdict.grade,
            "because": verdict.because,
            "joints": model.joints,
            "rows": self.survey.rows,
            "seconds": self.seconds,
            "residual_rms": training.residual_rms,
            "torque_std": training.torque_std,
            "residual_percent": percent(&training.residual_rms),
            "held_out_percent": percent(&training.held_out_rms),
            "held_out_by_region_percent": percent(&training.held_out_by_region_rms),
            "cutoff_hz": training.filter.map(|filter| filter.cutoff_hz),
            "delay_s": training.filter.map(|filter| filter.delay),
            "geometry_found": training.geometry_found,
            "conditioning": all_repairs(&training.conditioning),
            "candidates": self.candidates,
            "candidates_by_step": self.steps.iter().map(|step| step.candidates).collect::<Vec<_>>(),
            "active": model.active(),
            "active_total": model.n_coefficients(),
            "steps": steps.collect::<Vec<_>>(),
            "choices": model.choices,
            "noise": self.noise,
            "dropped": self.dropped,
            "mass_matrix": self.mass_matrix()?,
        }))
    }
}
