//! Headers that are understood, and headers that are refused with a reason.

use super::{MAX_COLUMNS, plain};
use crate::{LogError, Mapping, Result};
use std::path::Path;
use torquewise_motion::Signal;

fn mapping(header: &str) -> Result<Mapping> {
    let names: Vec<_> = header.split(',').map(|name| name.trim().to_owned()).collect();
    plain(Path::new("arm.csv"), &names)
}

#[test]
fn columns_may_stand_in_any_order_with_others_between_and_count_from_zero() {
    let found = mapping("tau2,q2,note,t,q1, tau1 ,q02,qa").unwrap();
    assert_eq!(found.n_joints, 2);
    assert_eq!(found.chosen, [3, 4, 1, 5, 0]);
    assert_eq!(found.slot(Signal::Tau), Some(3));
    assert_eq!(found.slot(Signal::Dq), None);
    assert_eq!(found.ignored, ["note", "q02", "qa"]);

    let ten: Vec<_> = (1..=10).map(|joint| format!("q{joint}")).collect();
    let ten = mapping(&format!("t,{}", ten.join(","))).unwrap();
    assert_eq!(ten.chosen, (0..=10).collect::<Vec<_>>());

    assert!(matches!(mapping("t,q00,q01"), Err(LogError::NoColumn { missing: "q1", .. })));
    let from_zero = mapping("tau0,t,q1,q0,tau1").unwrap();
    assert_eq!((from_zero.n_joints, &from_zero.chosen[..]), (2, &[1, 3, 2, 0, 4][..]));
}

#[test]
fn the_message_says_which_column_is_missing() {
    for (header, missing, present) in [
        ("t,q1,q3", "q2", "q3"),
        ("t,q2", "q1", "q2"),
        ("t,q1,q2,q3,tau1,tau2", "tau3", "q3"),
        ("t,q1,q2,tau1,tau2,tau3", "q3", "tau3"),
        ("t,q1,q2,dq2", "dq1", "q2"),
        ("t,q1,q2,ddq1", "ddq2", "q2"),
        ("t,q1,q2,tau0,tau1,tau2", "q0", "q2"),
    ] {
        match mapping(header) {
            Err(LogError::MissingColumn { missing: m, present: p, .. }) => {
                assert_eq!((m.as_str(), p.as_str()), (missing, present), "{header}");
            }
            other => panic!("{header}: {other:?}"),
        }
    }
}

#[test]
fn headers_without_meaning_are_refused() {
    assert!(matches!(mapping("q1"), Err(LogError::NoColumn { missing: "t", .. })));
    assert!(matches!(mapping("t,dq1"), Err(LogError::NoColumn { missing: "q1", .. })));
    assert!(matches!(mapping("t,t,q1"), Err(LogError::DuplicateColumn { .. })));
    assert!(matches!(mapping("t,q1,q1"), Err(LogError::DuplicateColumn { .. })));
    let wide = "x,".repeat(MAX_COLUMNS) + "t";
    assert!(matches!(mapping(&wide), Err(LogError::TooManyColumns { found: 1_001, .. })));
    let far = "t,q1,q99999999999999999999999";
    assert_eq!(mapping(far).unwrap().ignored, ["q99999999999999999999999"]);
}
