//! Learned chain → geometry: a skeleton that the log moves, and where its axes lie.

use crate::fit_report::Findings;
use crate::fit_report::clock::Clock;
use crate::html::number::significant;
use crate::html::skeleton::{Frame, Skeleton};
use crate::html::{Column, Item, Section, Table};
use torquewise_model::rigid_chain::RigidChain;

/// Seconds of the log that move the skeleton, from its middle.
const SECONDS: f64 = 60.0;
/// Rows of them at most.
const MOST_ROWS: usize = 600;
/// Parameters of the geometry before those of the second joint, and of each joint from there on.
const PER_BASE: usize = 2;
const PER_JOINT: usize = 4;

/// The skeleton and a table of its axes; nothing for a model without a chain.
pub(crate) fn section(findings: &Findings<'_>) -> Option<Section> {
    let chain = findings.found.model.chain.as_ref()?;
    let caption = "Drag to rotate. Coloured: the axes of the joints; grey: the shortest way from \
                   the origin of one to the axis of the next. Up is against gravity. Torque does \
                   not determine where along its axis a joint sits: each stands at the foot of \
                   that perpendicular, so links may look shorter than they are, and neither the \
                   height of the base nor the tool is known."
        .to_owned();
    let items = vec![
        Item::Skeleton { skeleton: skeleton(findings, chain)?, caption },
        axes(findings, chain),
    ];
    Some(Section { heading: "Geometry".into(), items })
}

fn skeleton(findings: &Findings<'_>, chain: &RigidChain) -> Option<Skeleton> {
    let geometry = chain.axes().ok()?;
    let motion = &findings.diagnosis.trace.motion;
    let clock = Clock::new(motion.t());
    let n = chain.n_joints();
    let q = |row: usize, joint: usize| -> f64 {
        let multiples = chain.coupling.row(joint, n).into_iter().enumerate();
        rounded(multiples.map(|(j, k)| f64::from(k) * motion.q()[(row, j)]).sum())
    };
    let rows = clock.middle(SECONDS, MOST_ROWS);
    let frames = geometry.placements().into_iter().map(|placement| Frame {
        origin: placement.origin.into(),
        rotation: std::array::from_fn(|k| placement.rotation[(k / 3, k % 3)]),
    });
    Some(Skeleton {
        joints: findings.joints().to_vec(),
        frames: frames.collect(),
        gravity: geometry.gravity(),
        t: rows.iter().map(|&row| rounded(clock.at(row))).collect(),
        q: rows.iter().map(|&row| (0..n).map(|joint| q(row, joint)).collect()).collect(),
    })
}

/// To a tenth of a milliradian or millisecond: finer than a screen.
fn rounded(x: f64) -> f64 {
    (1e4 * x).round() / 1e4
}

fn axes(findings: &Findings<'_>, chain: &RigidChain) -> Item {
    let friction = findings.found.model.friction.len();
    let first = chain.n_parameters(friction) - chain.fitted.len();
    let row = |joint: usize| {
        let start = PER_BASE + PER_JOINT * (joint - 1);
        let [w1, w2, p1, p2] = std::array::from_fn(|k| chain.geometry[start + k]);
        let (angle, distance) = (f64::hypot(w1, w2), f64::hypot(p1, p2));
        let std_error = |of: usize, slopes: [f64; 2]| {
            let place = |k: usize| chain.fitted.iter().position(|&own| own == start + of + k);
            let places = [place(0), place(1)];
            if chain.covariance.is_empty() || places == [None, None] {
                return "exact".to_owned();
            }
            let mut weights = vec![0.0; chain.covariance.len()];
            for (place, slope) in places.into_iter().zip(slopes) {
                if let Some(place) = place {
                    weights[first + place] = slope;
                }
            }
            let scale = if of == 0 { 1.0_f64.to_degrees() } else { 1e3 };
            format!("± {}", significant(scale * chain.variance_of(&weights).sqrt(), 2))
        };
        vec![
            findings.joints()[joint].as_str().into(),
            format!("{:.1}", angle.to_degrees()).into(),
            std_error(0, [w1 / angle, w2 / angle]).into(),
            format!("{:.1}", 1e3 * distance).into(),
            std_error(2, [p1 / distance, p2 / distance]).into(),
        ]
    };
    Item::Table(Table {
        caption: "Each axis seen from the joint before, with standard errors. A distance whose \
                  error is as large as itself is not determined by this log; “exact”: held at a \
                  right angle, or at the origin before."
            .into(),
        columns: vec![
            Column::words("joint"),
            Column::numbers("angle to the axis before [°]"),
            Column::numbers(""),
            Column::numbers("distance from the origin before [mm]"),
            Column::numbers(""),
        ],
        rows: (1..chain.n_joints()).map(row).collect(),
    })
}
