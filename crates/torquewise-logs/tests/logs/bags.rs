//! Bags of ROS 2: what their messages hold is read by joint name and time, whatever the storage.
use crate::made_bags::{KIND, Made, joint_state, write, write_mcap};
use crate::{file_of, with};
use mcap::{Compression, WriteOptions};
use std::path::Path;
use torquewise_logs::{LogError, Logs, Options};
use torquewise_motion::{Motion, Recording};

const STORAGES: [&str; 2] = ["bag.db3", "bag.mcap"];
const TOPIC: &str = "/joint_states";

/// Nanoseconds of so many hundredths of a second.
fn hundredths(count: i64) -> i64 {
    count * 10_000_000
}

/// Messages of joints a and b, one each hundredth of a second: q = row and -row.
fn messages(rows: i64, make: impl Fn(i64) -> Vec<u8>) -> Vec<Made> {
    let made = |row| Made { topic: TOPIC, received: hundredths(row) + 77, bytes: make(row) };
    (0..rows).map(made).collect()
}

fn plain(row: i64) -> Vec<u8> {
    let x = row as f64;
    joint_state(hundredths(row), &["a", "b"], [&[x, -x], &[100.0, -100.0], &[1.5, 2.5]])
}

/// Writes a bag in either storage and reads each.
fn each_storage(messages: &[Made], check: impl Fn(&Path)) {
    let folder = tempfile::tempdir().unwrap();
    for storage in STORAGES {
        let file = folder.path().join(storage);
        write(&file, &[(TOPIC, KIND), ("/camera", "sensor_msgs/msg/Image")], messages);
        check(&file);
    }
}

fn open(file: &Path, options: &Options) -> Result<Logs, LogError> {
    Logs::open_with(&[file.to_owned()], options)
}

fn read(file: &Path) -> Vec<Motion> {
    crate::read_both(file, &Options::default()).unwrap()
}

#[test]
fn a_bag_is_read_without_a_profile() {
    let mut made = messages(40, plain);
    made.insert(3, Made { topic: "/camera", received: 1, bytes: vec![9; 50] });
    each_storage(&made, |file| {
        let logs = open(file, &Options::default()).unwrap();
        let swing = &logs.read_all().unwrap()[0];

        assert_eq!((logs.joints(), logs.has_dq(), logs.has_tau()), (swing.joints(), true, true));
        assert_eq!((swing.n_rows(), swing.joints()[1].as_str()), (40, "b"));
        assert_eq!((swing.t()[39], swing.q()[(39, 1)], swing.dq()[(7, 0)]), (0.39, -39.0, 100.0));
        assert_eq!((swing.require_tau().unwrap()[(0, 1)], swing.t()[0]), (2.5, 0.0));
        // Acceleration is derived from a velocity that does not change.
        assert!(swing.ddq()[(20, 0)].abs() < 1e-9);
        assert_eq!(logs.read_all().unwrap()[0].q(), swing.q(), "once more");
        let left: Vec<_> = std::fs::read_dir(file.parent().unwrap()).unwrap().collect();
        assert!(left.len() <= 2, "nothing is written beside a bag: {left:?}");
    });
}

#[test]
fn many_messages_are_read_page_by_page_in_either_compression() {
    let made = messages(5_000, plain);
    let folder = tempfile::tempdir().unwrap();
    let mut files = vec![folder.path().join("bag.db3")];
    write(&files[0], &[(TOPIC, KIND)], &made);
    let (zstd, lz4) = (Some(Compression::Zstd), Some(Compression::Lz4));
    for (name, compression) in [("zstd", zstd), ("lz4", lz4), ("none", None)] {
        let file = folder.path().join(format!("{name}.mcap"));
        let options = WriteOptions::default().compression(compression).chunk_size(Some(10_000));
        write_mcap(&file, &[(TOPIC, KIND)], &made, options);
        files.push(file);
    }
    for file in files {
        let swing = &read(&file)[0];

        assert_eq!((swing.n_rows(), swing.q()[(4_999, 0)]), (5_000, 4_999.0), "{}", file.display());
    }
}

#[test]
fn joints_in_another_order_or_among_others_are_found_by_name() {
    let made = messages(20, |row| {
        let (x, stamp) = (row as f64, hundredths(row));
        match row % 3 {
            0 => joint_state(stamp, &["a", "b"], [&[x, -x], &[], &[1.0, 2.0]]),
            1 => joint_state(stamp, &["b", "a"], [&[-x, x], &[], &[2.0, 1.0]]),
            _ => joint_state(stamp, &["c", "b", "a"], [&[9.0, -x, x], &[], &[9.0, 2.0, 1.0]]),
        }
    });
    each_storage(&made, |file| {
        let logs = open(file, &Options::default()).unwrap();
        let swing = &logs.read_all().unwrap()[0];

        assert!(!logs.has_dq());
        for row in 0..20 {
            let tau = swing.require_tau().unwrap()[(row, 0)];
            let (q, x) = ((swing.q()[(row, 0)], swing.q()[(row, 1)]), row as f64);
            assert_eq!((q, tau), ((x, -x), 1.0));
        }
    });
}

#[test]
fn a_bag_without_the_joint_states_that_are_needed_is_told_why() {
    let state = |row, names: &[&str], q: &[f64]| joint_state(hundredths(row), names, [q, &[], &[]]);
    let gone = messages(9, |row| {
        state(row, if row == 4 { &["a", "c"] } else { &["a", "b"] }, &[0.0, 0.0])
    });
    let [mut cut, mut uneven] = [messages(5, plain), messages(5, plain)];
    cut[2].bytes.truncate(60);
    uneven[2].bytes = state(0, &["a", "b"], &[1.0]);
    let names: Vec<String> = (0..100_000).map(|k| format!("j{k}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let camera = vec![Made { topic: "/camera", received: 5, bytes: vec![1, 2, 3] }];
    for (made, reason) in [
        (camera, "/camera (sensor_msgs/msg/Image, 1 messages)"),
        (gone, "row 5: the message does not name joint b, only a, c"),
        (cut, "row 3: the message is no joint state"),
        (uneven, "not one position, velocity and effort for each"),
        (messages(2, |row| state(row, &names, &[])), "it names over 1000 joints"),
    ] {
        each_storage(&made, |file| {
            let refused = open(file, &Options::default()).unwrap_err().to_string();
            assert!(refused.contains(reason), "{refused}");
        });
    }
}

#[test]
fn a_profile_chooses_joints_and_passes_over_messages_of_others() {
    let three: [&[f64]; 3] = [&[1.0, 2.0, 3.0], &[], &[4.0, 5.0, 6.0]];
    let made = messages(30, |row| match row % 2 {
        0 => joint_state(hundredths(row), &["gripper"], [&[0.5], &[], &[]]),
        _ => joint_state(hundredths(row), &["a", "b", "c"], three),
    });
    let profile = "joints = [\"c\", \"b\", \"a\"]\nleave_out = [\"b\"]\n\
        [tau]\nunit = \"A\"\ntorque_constant = [0.1, 1.0, -0.1]\ngear = 100.0\n";
    each_storage(&made, |file| {
        let logs = open(file, &with(profile)).unwrap();
        let swing = &logs.read_all().unwrap()[0];

        assert_eq!((logs.joints(), swing.n_rows()), (&["c".to_owned(), "a".to_owned()][..], 15));
        assert_eq!((swing.q()[(3, 0)], swing.q()[(3, 1)]), (3.0, 1.0));
        let tau = swing.require_tau().unwrap();
        assert!((tau[(3, 0)] - 60.0).abs() < 1e-12 && (tau[(3, 1)] + 40.0).abs() < 1e-12);
        assert_eq!(logs.report().rows, 15);

        let unknown = open(file, &with("joints = [\"x\"]")).unwrap_err().to_string();
        assert!(unknown.contains("no message of the joints x, its first names gripper"));
        let partly = open(file, &with("joints = [\"a\", \"x\"]")).unwrap_err();
        assert!(matches!(partly, LogError::JointGone { .. }), "{partly}");
    });
}

#[test]
fn several_topics_are_listed_and_one_can_be_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let mut made = messages(12, plain);
    made.push(Made { topic: "/left/joint_states", ..made[0].clone() });
    for storage in STORAGES {
        let file = folder.path().join(storage);
        let topics = [(TOPIC, KIND), ("/left/joint_states", KIND), ("/camera", "image")];
        write(&file, &topics, &made);

        let refused = open(&file, &Options::default()).unwrap_err();
        let help = miette::Diagnostic::help(&refused).unwrap().to_string();
        let refused = format!("{refused}: {help}");
        let chosen = Options { topic: Some(TOPIC.into()), ..Options::default() };
        let by_profile = open(&file, &with("topic = \"/joint_states\"")).unwrap();
        let wrong = Options { topic: Some("/right".into()), ..Options::default() };
        let wrong = open(&file, &wrong).unwrap_err().to_string();

        for part in [
            "/joint_states (sensor_msgs/msg/JointState, 12 messages)",
            "/left/joint_states (sensor_msgs/msg/JointState, 1 messages)",
            "choose one by its name, in the options or by topic = \"…\" in a profile",
        ] {
            assert!(refused.contains(part), "{refused}");
        }
        assert_eq!(open(&file, &chosen).unwrap().read_all().unwrap()[0].n_rows(), 12);
        assert_eq!(by_profile.read_all().unwrap()[0].n_rows(), 12);
        assert!(wrong.contains("no joint states on topic /right, its topics are"), "{wrong}");
    }
}

#[test]
fn messages_out_of_order_are_sorted_by_stamp() {
    let mut made = messages(50, plain);
    made.swap(10, 11);
    made.swap(30, 33);
    made.iter_mut().zip(0..).for_each(|(made, row)| made.received = hundredths(row));
    each_storage(&made, |file| {
        let swing = &read(file)[0];

        assert!((0..50).map(f64::from).eq(swing.q().col(0).iter().copied()));
    });
}

#[test]
fn time_is_that_of_the_stamps_or_when_the_bag_received_a_message() {
    let date = 1_700_000_000_123_456_789;
    let dated = |row| joint_state(date + hundredths(row) + row % 2, &["a"], [&[0.0], &[], &[]]);
    let unstamped = |row: i64| joint_state(0, &["a"], [&[row as f64], &[], &[]]);
    each_storage(&messages(20, dated), |file| {
        assert_eq!(read(file)[0].t()[..3], [0.0, 0.010_000_001, 0.02]);
    });
    each_storage(&messages(20, unstamped), |file| {
        let swing = &read(file)[0];
        assert_eq!((swing.t()[0], swing.t()[19]), (77e-9, 0.190_000_077));
        assert!(swing.tau().is_none());
    });
}

#[test]
fn effort_that_is_nowhere_a_number_is_missing() {
    let nan = f64::NAN;
    let nowhere = messages(9, |row| joint_state(hundredths(row), &["a"], [&[0.0], &[], &[nan]]));
    let once = messages(9, |row| {
        let effort = if row == 4 { nan } else { 1.0 };
        joint_state(hundredths(row), &["a"], [&[0.0], &[], &[effort]])
    });
    each_storage(&nowhere, |file| {
        assert!(!open(file, &Options::default()).unwrap().has_tau());
    });
    each_storage(&once, |file| {
        let refused = open(file, &Options::default()).unwrap().read_all().unwrap_err().to_string();
        let repaired = Options { repair: true, ..Options::default() };
        let repaired = open(file, &repaired).unwrap();

        assert!(refused.contains("row 5, column a.effort is NaN"), "{refused}");
        assert_eq!(repaired.read_all().unwrap()[0].n_rows(), 8);
        assert_eq!(repaired.report().repairs.not_finite, 1);
    });
}

#[test]
fn a_bag_cut_short_is_refused_wherever_it_ends() {
    each_storage(&messages(60, plain), |file| {
        let whole = std::fs::read(file).unwrap();
        for end in (0..whole.len()).step_by(64) {
            std::fs::write(file, &whole[..end]).unwrap();
            let read = open(file, &Options::default()).and_then(|logs| logs.read_all());
            assert!(read.is_err(), "{} cut to {end} of {} bytes", file.display(), whole.len());
        }
    });
}

#[test]
fn what_is_no_bag_is_told_apart() {
    let other = file_of(".db3", b"");
    rusqlite::Connection::open(&other).unwrap().execute_batch("CREATE TABLE topics(a)").unwrap();
    let view = file_of(".db3", b"");
    let views = "CREATE TABLE a(id); CREATE VIEW topics AS SELECT * FROM a;
        CREATE VIEW messages AS SELECT * FROM a";
    rusqlite::Connection::open(&view).unwrap().execute_batch(views).unwrap();

    let computed = file_of(".db3", b"");
    write(&computed, &[(TOPIC, KIND)], &messages(30, plain));
    let generate = "CREATE TABLE made(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER,
            data AS (CAST(x'00010000' || zeroblob(4000000) AS BLOB)));
        INSERT INTO made(topic_id, timestamp) SELECT topic_id, timestamp FROM messages;
        DROP TABLE messages;
        ALTER TABLE made RENAME TO messages";
    rusqlite::Connection::open(&computed).unwrap().execute_batch(generate).unwrap();

    for bag in [file_of(".db3", b"t,q1\n0,1\n"), other, view, computed] {
        let refused = open(&bag, &Options::default());
        assert!(matches!(refused, Err(LogError::NoBag { .. })), "{}", bag.display());
    }
    for empty in [".db3", ".mcap"] {
        let refused = open(&file_of(empty, b""), &Options::default());
        assert!(matches!(refused, Err(LogError::Empty { .. })), "{empty}");
    }
    let refused = open(&file_of(".mcap", b"t,q1\n0,1\n"), &Options::default());
    assert!(matches!(refused, Err(LogError::Decode { .. })));
    assert!(matches!(open(Path::new("no.db3"), &Options::default()), Err(LogError::Read { .. })));
}

/// Found by mutation: the parser took the memory that a text claims.
#[test]
fn a_text_that_claims_more_than_the_bag_has_is_refused() {
    let bag = file_of(".mcap", b"");
    let open_bag = mcap::WriteOptions::default()
        .compression(None)
        .calculate_chunk_crcs(false)
        .calculate_data_section_crc(false);
    write_mcap(&bag, &[(TOPIC, KIND)], &messages(30, plain), open_bag);
    let whole = std::fs::read(&bag).unwrap();
    for text in [TOPIC, KIND, "ros2msg", "cdr"] {
        let length = u32::try_from(text.len()).unwrap().to_le_bytes();
        let wanted = [&length, text.as_bytes()].concat();
        let at = whole.windows(wanted.len()).position(|own| own == wanted).unwrap();
        let mut claimed = whole.clone();
        claimed[at..at + 4].copy_from_slice(&[0xf0, 0xff, 0xff, 0xff]);
        std::fs::write(&bag, claimed).unwrap();

        let refused = open(&bag, &Options::default());

        assert!(matches!(refused, Err(LogError::Decode { .. })), "{text}: {refused:?}");
    }
}

#[test]
fn c22_a_bag_that_was_not_closed_is_read_and_nothing_is_left_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let made = folder.path().join("made.db3");
    write(&made, &[(TOPIC, KIND)], &messages(60, plain));
    let recorder = rusqlite::Connection::open(&made).unwrap();
    recorder.pragma_update(None, "journal_mode", "wal").unwrap();
    recorder.execute_batch("DELETE FROM messages WHERE id > 40").unwrap();
    let copy = folder.path().join("copy");
    std::fs::create_dir(&copy).unwrap();
    for name in ["made.db3", "made.db3-wal"] {
        std::fs::copy(folder.path().join(name), copy.join(name)).unwrap();
    }

    assert_eq!(read(&copy.join("made.db3")).len(), 1);

    let mut names: Vec<_> =
        std::fs::read_dir(&copy).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["made.db3", "made.db3-wal"]);
}

#[test]
fn a14_messages_without_an_index_are_read_as_recorded() {
    let bag = file_of(".db3", b"");
    let mut made = messages(5_000, plain);
    made.swap(100, 150);
    write(&bag, &[(TOPIC, KIND)], &made);
    let sorted = read(&bag);
    rusqlite::Connection::open(&bag).unwrap().execute_batch("DROP INDEX timestamp_idx").unwrap();

    let as_recorded = read(&bag);

    assert_eq!((as_recorded[0].t(), as_recorded[0].q()), (sorted[0].t(), sorted[0].q()));
    assert_eq!(as_recorded[0].n_rows(), 5_000);
}
