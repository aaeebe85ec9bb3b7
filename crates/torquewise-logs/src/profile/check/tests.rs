//! Profiles that are read, and profiles that are refused with a key and a reason.

use crate::profile::{Columns, PerJoint};
use crate::{LogError, Profile};

/// A profile that has every key.
const WHOLE: &str = include_str!("whole.toml");

fn message(text: &str) -> String {
    Profile::from_toml(text).unwrap_err().to_string()
}

#[test]
fn every_key_is_read_and_written_again() {
    let profile = Profile::from_toml(WHOLE).unwrap();

    let q = profile.q.as_ref().unwrap();
    assert_eq!(q.columns, Some(Columns::Prefix("pos".into())));
    assert_eq!(q.offset, Some(PerJoint::Each(vec![0.0, 1.5])));
    assert_eq!((profile.rows.len(), profile.seconds[0]), (2, [0.1, 7.5]));
    assert_eq!(Profile::from_toml(&profile.to_toml()).unwrap(), profile);
}

#[test]
fn what_is_not_understood_is_named_by_its_line_and_what_amperes_lack() {
    let unknown = message("joints = [\"a\"]\n\n[q]\ncolums = \"pos\"\n");
    assert!(unknown.starts_with("profile, line 4: unknown field `colums`"), "{unknown}");
    let syntax = message("rate = 100.0\nrobot = \n");
    assert!(syntax.starts_with("profile, line 2: "), "{syntax}");
    let kind = message("[q]\ncolumns = 3\n");
    assert!(kind.contains("line 2") && kind.contains("a prefix such as \"pos\""), "{kind}");
    assert!(message("[tau]\ngear = \"big\"\n").contains("a number, or a list"));
    let amperes = message("[tau]\ncolumns = \"i\"\nunit = \"A\"\n");
    assert!(amperes.contains("tau.unit has \"A\", expected torque_constant = ["), "{amperes}");
}

#[test]
fn lists_of_another_length_are_named_with_what_was_expected() {
    let joints = "joints = [\"a\", \"b\"]\n";
    for (text, key, found) in [
        ("[q]\ncolumns = [\"x\"]\n", "q.columns", "1 entries"),
        ("[q]\ncolumns = \"q\"\noffset = [1, 2, 3]\n", "q.offset", "3 entries"),
        ("[tau]\ngear = [1]\n", "tau.gear", "1 entries"),
        ("[tau]\nmatrix = [[1, 0]]\n", "tau.matrix", "1 entries"),
        ("[tau]\nmatrix = [[1, 0], [1]]\n", "tau.matrix, row 2", "1 entries"),
    ] {
        let message = message(&format!("{joints}{text}"));
        let expected = format!("profile: {key} has {found}, expected 2, one per joint, as joints");
        assert!(message.starts_with(&expected), "{message}");
    }
    let unnamed = message("[q]\ncolumns = [\"x\", \"y\"]\nscale = [1]\n");
    assert!(unnamed.contains("q.scale has 1 entries, expected 2") && unnamed.contains("q.columns"));
}

#[test]
fn values_that_cannot_be_right_are_refused() {
    for (text, key) in [
        ("rate = 0.0", "rate"),
        ("rate = nan", "rate"),
        ("rate = 9.0\nt = { column = \"t\" }", "t"),
        ("t = { column = \"t\", unit = \"min\" }", "t.unit"),
        ("rows = [[0, 5]]", "rows"),
        ("rows = [[7, 5]]", "rows"),
        ("rows = [[1, 5], [5, 9]]", "rows"),
        ("seconds = [[1.0, inf]]", "seconds"),
        ("joints = [\"a\"]\nleave_out = [\"b\"]", "leave_out"),
        ("q = { unit = \"grad\" }", "q.unit"),
        ("dq = { unit = \"rad\" }", "dq.unit"),
        ("q = { scale = 0.0 }", "q.scale"),
        ("q = { gear = 3.0 }", "q.gear"),
        ("q = { offset = inf }", "q.offset"),
        ("q = { matrix = [[nan]] }", "q.matrix"),
    ] {
        match Profile::from_toml(text) {
            Err(LogError::ProfileKey { key: found, .. }) => assert_eq!(found, key, "{text}"),
            other => panic!("{text}: {other:?}"),
        }
    }
    let twice = Profile::from_toml("joints = [\"a\", \"a\"]");
    assert!(matches!(twice, Err(LogError::JointName { .. })));
}
