//! Arms from a table of standard Denavit–Hartenberg rows with the mass of each link.
#![expect(non_snake_case, reason = "frames are written quantity_fromTo, as in `spatial`")]

use crate::arm::{Joint, STANDARD_GRAVITY, check_body, check_finite};
use crate::spatial::dh_row;
use crate::{Arm, Body, JointLimits, Result, SimError, shifted_turned};
use serde::Deserialize;
use std::f64::consts::PI;
use torquewise_rigid::JointKind;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    name: String,
    gravity: Option<[f64; 3]>,
    #[serde(default)]
    base_rpy: [f64; 3],
    joints: Vec<Row>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    name: String,
    a: f64,
    alpha: f64,
    d: f64,
    #[serde(default)]
    offset: f64,
    mass: f64,
    com: [f64; 3],
    inertia: [f64; 6],
    #[serde(default)]
    rotor: f64,
    range: Option<[f64; 2]>,
    #[serde(default)]
    kind: JointKind,
}

impl Arm {
    /// Reads an arm from a table of standard Denavit–Hartenberg rows.
    ///
    /// Joint i turns about z of frame i−1; frame i follows by the shifts and turns
    /// Rz(q + `offset`) · Tz(`d`) · Tx(`a`) · Rx(`alpha`) \[m, rad\]. Each `[[joints]]` row holds
    /// `name`, `a`, `alpha`, `d`, `mass` \[kg\], `com` \[m\] and `inertia` \[kg·m²\] about it as
    /// `[ixx, iyy, izz, ixy, ixz, iyz]`, both in frame i. Optional are `offset`, `rotor` (inertia
    /// \[kg·m²\] of the motor as felt at the joint) and `range` (`[lower, upper]` \[rad\] that
    /// simulated motions keep to, one turn by default). A row of `kind = "prismatic"` slides along z of
    /// frame i−1, by `d` + q, and needs a `range` \[m\]. Beside `name`, the file may give `gravity` \[m/s²\] (`[0, 0, -9.81]`) and `base_rpy` \[rad\], the base's roll, pitch, yaw in the world.
    ///
    /// ```
    /// let arm = torquewise_sim::Arm::from_dh_toml(
    ///     r#"
    ///     name = "pendulum"
    ///     base_rpy = [1.5707963267948966, 0.0, 0.0]
    ///     [[joints]]
    ///     name = "pivot"
    ///     a = 1.0
    ///     alpha = 0.0
    ///     d = 0.0
    ///     mass = 2.0
    ///     com = [0.0, 0.0, 0.0]
    ///     inertia = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    ///     "#,
    /// )?;
    /// assert!((arm.gravity_torque(&[0.0])[0] - 2.0 * 9.81).abs() < 1e-12);
    /// # Ok::<(), torquewise_sim::SimError>(())
    /// ```
    ///
    /// # Errors
    /// [`SimError::DhTable`] for broken TOML, a missing or an unknown key; otherwise the
    /// variant that names the number at fault.
    pub fn from_dh_toml(text: &str) -> Result<Self> {
        let table: Table = toml::from_str(text)
            .map_err(|source| SimError::DhTable { source: Box::new(source) })?;

        let mut joints = Vec::with_capacity(table.joints.len());
        check_finite("base_rpy", &table.name, &table.base_rpy)?;
        let mut X_PF = shifted_turned([0.0; 3], table.base_rpy);
        for row in table.joints {
            // Frame J moves with the joint but sits where the joint is, before d, a and alpha.
            let X_PJ = X_PF * dh_row(row.offset, 0.0, 0.0, 0.0);
            let X_JF = dh_row(0.0, row.d, row.a, row.alpha);
            let body = Body::new(row.mass, row.com, row.inertia);
            check_body(&row.name, &body)?;
            let (kind, body, rotor) = (row.kind, body.seen_from(&X_JF), row.rotor);
            let range = row.range.unwrap_or(if kind.turns() { [-PI, PI] } else { [0.0; 2] });
            let limits = JointLimits { position: row.range, ..JointLimits::default() };
            joints.push((row.name, Joint { X_PJ, kind, body, rotor, range, limits }));
            X_PF = X_JF;
        }
        Self::new(table.name, table.gravity.unwrap_or(STANDARD_GRAVITY), joints)
    }
}

#[cfg(test)]
mod tests;
