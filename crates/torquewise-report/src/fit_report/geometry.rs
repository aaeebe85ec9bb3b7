//! The learned geometry: a skeleton that the log moves, and where its axes lie.

use crate::html::skeleton::{BodyFrame, Skeleton};
use crate::{Clock, Findings, Item, Section, Table};
use torquewise_model::RigidChain;
use torquewise_model::learned::{drives, geometry, joint_geometry, links, taken_as_found};
use torquewise_model::selection::Selection;

/// Seconds of the log that move the skeleton, from its middle.
const SECONDS: f64 = 60.0;
const MOST_ROWS: usize = 600;
pub(crate) fn section(findings: &Findings<'_>) -> Option<Section> {
    let chain = findings.found.model.chain.as_ref()?;
    let caption = "Drag to rotate. Coloured: the axes of the joints; grey: the shortest way from \
                   the origin of one to the axis of the next. Up is against gravity. Torque does \
                   not determine where along its axis a joint sits: each stands at the foot of \
                   that perpendicular, so links may look shorter than they are, and neither the \
                   height of the base nor the tool is known. Dashed: not resolved by this log."
        .to_owned();
    let (model, all) = (&findings.found.model, Selection::default());
    let found = joint_geometry(model).ok()?;
    let axes = Table {
        caption: "Where the axes lie at q = 0, and each seen from the joint before, with standard \
                  errors; without one where it is held at a right angle or at the origin before. The \
                  length is along the axis before, between the feet of the axes on both sides. A \
                  distance whose error is as large as itself is not determined by this log."
            .into(),
        ..Table::of_text(geometry(model, &found, &all))
    };
    let links = Table {
        caption: "What torque determines of the links, – where it is not resolved: first moments \
                  [kg·m] and moments of inertia about the origin of the joint [kg·m²]; mass, m·z \
                  and Iyy are counted into the link before."
            .into(),
        ..Table::of_text(links(chain, &model.joints, &all).ok()?)
    };
    let drives = Table {
        caption: "Rotors and springs, – where none is resolved.".into(),
        ..Table::of_text(drives(chain, &model.joints, &all))
    };
    let resolved = found.into_iter().map(|own| own.resolved).collect();
    let skeleton = skeleton(findings, chain, resolved)?;
    let mut items = vec![Item::Skeleton { skeleton, caption }, Item::Table(axes)];
    items.extend(taken_as_found(model).map(Item::Text));
    items.push(Item::Table(links));
    items.extend((!drives.rows.is_empty()).then_some(Item::Table(drives)));
    Some(Section { heading: "Geometry".into(), items })
}

fn skeleton(findings: &Findings<'_>, chain: &RigidChain, resolved: Vec<bool>) -> Option<Skeleton> {
    let placed = chain.axes().ok()?;
    let motion = &findings.diagnosis.trace.motion;
    let clock = Clock::new(motion.t());
    let n = chain.n_joints();
    let q = |row: usize, joint: usize| -> f64 {
        let multiples = chain.coupling.row(joint, n).into_iter().enumerate();
        rounded(multiples.map(|(j, k)| f64::from(k) * motion.q()[(row, j)]).sum())
    };
    let rows = clock.middle(SECONDS, MOST_ROWS);
    let frames = placed.placements().into_iter().map(|placement| BodyFrame {
        origin: placement.origin.into(),
        rotation: std::array::from_fn(|k| placement.rotation[(k / 3, k % 3)]),
    });
    Some(Skeleton {
        joints: findings.joints().to_vec(),
        resolved,
        frames: frames.collect(),
        gravity: placed.gravity(),
        slides: (0..n).map(|joint| chain.kinds.slides(joint)).collect(),
        t: rows.iter().map(|&row| rounded(clock.t[row])).collect(),
        q: rows.iter().map(|&row| (0..n).map(|joint| q(row, joint)).collect()).collect(),
    })
}

/// To a tenth of a milliradian or millisecond: finer than a screen.
fn rounded(x: f64) -> f64 {
    (1e4 * x).round() / 1e4
}
