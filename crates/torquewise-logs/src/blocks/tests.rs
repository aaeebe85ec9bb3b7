//! Blocks: cut at the same rows, split at gaps and differentiated as if the file were whole.

use super::Blocks;
use crate::csv_rows::tests::signal_rows;
use crate::{LogError, ReadReport, Result};
use faer::Mat;
use std::f64::consts::TAU;
use std::fmt::Write;
use torquewise_motion::{Motion, derivative};

/// Blocks of a text with one joint.
fn blocks(text: &str) -> Result<Vec<(usize, Motion)>> {
    let mut blocks = Blocks::new(signal_rows(text.as_bytes())?, &["joint1".to_owned()], true);
    let mut read = Vec::new();
    while let Some(block) = blocks.next(Blocks::block)? {
        read.push(block);
    }
    Ok(read)
}

/// A swing of t, and dq if asked for, at the given time stamps.
fn swing(t: &[f64], with_dq: bool) -> String {
    let mut text = String::from(if with_dq { "t,q1,dq1\n" } else { "t,q1\n" });
    for t in t {
        write!(text, "{t:?},{:?}", (3.0 * t).sin()).unwrap();
        if with_dq {
            write!(text, ",{:?}", 3.0 * (3.0 * t).cos()).unwrap();
        }
        text.push('\n');
    }
    text
}

/// Times 10 ms apart.
pub(crate) fn even(rows: u32) -> Vec<f64> {
    (0..rows).map(|row| 0.01 * f64::from(row)).collect()
}

/// Bits of what each row of all blocks holds.
fn bits(blocks: &[(usize, Motion)], pick: impl Fn(&Motion, usize) -> f64) -> Vec<u64> {
    let rows = blocks.iter().flat_map(|(_, block)| {
        (0..block.n_rows()).map(|row| pick(block, row).to_bits()).collect::<Vec<_>>()
    });
    rows.collect()
}

fn derived(t: &[f64], x: impl Fn(f64) -> f64, order: usize) -> Vec<u64> {
    let x = Mat::from_fn(t.len(), 1, |row, _| x(t[row]));
    let derived = derivative(t, x.as_ref(), order).unwrap();
    (0..t.len()).map(|row| derived[(row, 0)].to_bits()).collect()
}

#[test]
fn derivatives_have_the_bits_of_the_whole_trajectory_whatever_its_length_and_stop_at_gaps() {
    for rows in [5, 20, 21, 1023, 1024, 1025, 1029, 1034, 1035, 2048, 3100] {
        let t = even(rows);
        let blocks = blocks(&swing(&t, false)).unwrap();

        let wave = |t: f64| (3.0 * t).sin();
        assert_eq!(bits(&blocks, |b, row| b.dq()[(row, 0)]), derived(&t, wave, 1), "{rows}");
        assert_eq!(bits(&blocks, |b, row| b.ddq()[(row, 0)]), derived(&t, wave, 2), "{rows}");
    }
    let mut t = even(60);
    t[30..].iter_mut().for_each(|t| *t += 5.0);

    let blocks = blocks(&swing(&t, false)).unwrap();

    let wave = |t: f64| (3.0 * t).sin();
    let parts = [derived(&t[..30], wave, 1), derived(&t[30..], wave, 1)].concat();
    assert_eq!(bits(&blocks, |block, row| block.dq()[(row, 0)]), parts);
}

#[test]
fn acceleration_comes_from_the_velocity_where_that_is_recorded() {
    let t = even(1_500);
    let blocks = blocks(&swing(&t, true)).unwrap();

    let velocity = |t: f64| 3.0 * (3.0 * t).cos();
    let recorded: Vec<_> = t.iter().map(|t| velocity(*t).to_bits()).collect();
    assert_eq!(bits(&blocks, |b, row| b.dq()[(row, 0)]), recorded);
    assert_eq!(bits(&blocks, |b, row| b.ddq()[(row, 0)]), derived(&t, velocity, 1));
}

#[test]
fn blocks_are_cut_at_multiples_of_the_block_length_from_each_gap() {
    for with_derivatives in [false, true] {
        let mut t = even(4_000);
        for (row, t) in t.iter_mut().enumerate() {
            *t += if row >= 3_000 { 2.0 } else { 0.0 } + if row >= 1_500 { 1.0 } else { 0.0 };
        }
        let text = if with_derivatives {
            let row = |t: &f64| format!("{t:?},0,0,0\n");
            String::from("t,q1,dq1,ddq1\n") + &t.iter().map(row).collect::<String>()
        } else {
            swing(&t, false)
        };

        let blocks = blocks(&text).unwrap();

        let cuts: Vec<_> = blocks.iter().map(|(part, block)| (*part, block.n_rows())).collect();
        assert_eq!(cuts, [(0, 1024), (0, 476), (1, 1024), (1, 476), (2, 1000)]);
        let stamps: Vec<_> = t.iter().map(|t| t.to_bits()).collect();
        assert_eq!(bits(&blocks, |block, row| block.t()[row]), stamps);
    }
}

#[test]
fn positions_that_were_wrapped_are_unwrapped_and_those_that_jump_otherwise_stay() {
    let turns = |row: u32| 0.1 * f64::from(row) - 0.0004 * f64::from(row * row);
    let log = |q: &dyn Fn(u32) -> f64| {
        let row = |row: u32| format!("{:?},{:?},0,0\n", 0.01 * f64::from(row), q(row));
        "t,q1,dq1,ddq1\n".to_owned() + &(0..300).map(row).collect::<String>()
    };
    let positions = |q: &dyn Fn(u32) -> f64| -> Vec<f64> {
        let blocks = blocks(&log(q)).unwrap();
        blocks.iter().flat_map(|(_, block)| block.q().col(0).iter().copied()).collect()
    };
    let wrapped = |row: u32| turns(row) - TAU * (turns(row) / TAU).round();

    let read = positions(&wrapped);

    for (row, q) in (0..300).zip(read) {
        assert!((q - turns(row)).abs() < 1e-12, "{row}: {q}");
    }
    // In degrees each row may go on by as much; a shift that lasts is none of whole turns, a spike goes back.
    let others: [&dyn Fn(u32) -> f64; 3] =
        [&|row| 6.0 * f64::from(row), &|row| if row < 150 { 0.0 } else { 4.0 }, &|row| {
            if row == 150 { TAU } else { 0.0 }
        }];
    for own in others {
        assert!(positions(own).into_iter().zip(0..).all(|(q, row)| (q - own(row)).abs() < 1e-12));
    }
}

/// Stamps that are left of rows 0.01 s apart, and what the reading came to.
fn stamps_of(q: &dyn Fn(u32) -> f64) -> (Vec<f64>, ReadReport) {
    let row =
        |row: u32| format!("{:?}{}\n", 0.01 * f64::from(row), format!(",{:?}", q(row)).repeat(4));
    let text = "t,q1,q2,dq1,dq2\n".to_owned() + &(0..4_000).map(row).collect::<String>();
    let joints = ["joint1".into(), "joint2".into()];
    let mut blocks = Blocks::new(signal_rows(text.as_bytes()).unwrap(), &joints, true);
    let mut stamps = Vec::new();
    while let Some((_, block)) = blocks.next(Blocks::block).unwrap() {
        stamps.extend(block.t().to_vec());
    }
    (stamps, blocks.rows.report)
}

#[test]
fn rows_of_zeros_are_lost_but_where_an_arm_is_at_zero() {
    let wave = |row: u32| 1.0 + 0.5 * (0.05 * f64::from(row)).sin();
    // Up to 0.2 s are bridged, and no jump is seen.
    for (lost, splits) in [(1, 0), (18, 0), (40, 1)] {
        let is_lost = |row: u32| (100..100 + lost).contains(&row);
        let (stamps, report) = stamps_of(&|row| if is_lost(row) { 0.0 } else { wave(row) });

        assert_eq!((stamps.len() as u64, report.first_zeros), (4_000 - u64::from(lost), Some(101)));
        assert_eq!((report.repairs.zeros, report.repairs.splits), (u64::from(lost), splits));
    }
    let (stamps, report) = stamps_of(&|row| wave(row.min(200)) - wave(200));
    assert_eq!((stamps.len(), report.repairs.zeros), (4_000, 0), "an arm that stops at zero");
}

#[test]
fn a_log_is_split_where_a_position_jumps_and_not_where_it_spikes_or_a_joint_starts() {
    let wave = |row: u32| (0.03 * f64::from(row)).sin();
    for from in [30, 1_000, 1_024, 1_030, 3_990] {
        let by = wave(from) - wave(from - 1) - 0.3;
        let (stamps, report) = stamps_of(&|row| wave(row) - if row < from { 0.0 } else { 0.3 });

        assert_eq!((stamps.len(), report.repairs.splits), (4_000, 1), "{from}");
        let (row, _, found) = report.first_jump.unwrap();
        assert!(row == u64::from(from) + 1 && (found - by).abs() < 1e-12, "{row} {found}");
    }
    let counts = |x: f64| (1e3 * x).round() / 1e3;
    let start = |row: u32| 2e-4 * f64::from(row.saturating_sub(1_000)).powi(2);
    // A step no faster than the motion, a spike, rows that are missing, a start at full speed, devices that
    // are slow, a coarse encoder, and one that settles and starts.
    let whole: [&dyn Fn(u32) -> f64; 8] = [
        &|row| wave(row) + if row < 1_000 { 0.0 } else { 0.05 },
        &|row| wave(row) + if row == 1_000 { 0.3 } else { 0.0 },
        &|row| if row < 1_000 { wave(3 * row) } else { wave(3 * row + 4) },
        &|row| wave(2 * row.max(1_000)),
        &|row| wave(row / 33 * 33),
        &|row| wave(row / 50 * 50),
        &|row| (10.0 * wave(row / 5)).round() / 10.0,
        &|row| counts((-0.02 * f64::from(row)).exp() + start(row).min(1.0)),
    ];
    for (case, q) in whole.into_iter().enumerate() {
        let report = stamps_of(q).1;
        assert_eq!((report.jumps, report.repairs.held_rows), (0, 0), "case {case}");
    }
}

#[test]
fn rows_that_repeat_while_the_arm_moves_on_are_left_out_and_those_of_an_arm_at_rest_stay() {
    let read = |clock: &dyn Fn(u32) -> u32| stamps_of(&|row| (0.03 * f64::from(clock(row))).sin());
    for frozen in [6, 30, 1_500] {
        let (stamps, report) = read(&|row| if row < 1_020 + frozen { row.min(1_019) } else { row });

        let left = (0..4_000).filter(|row| !(1_020..1_020 + frozen).contains(row));
        assert_eq!(stamps, left.map(|row| 0.01 * f64::from(row)).collect::<Vec<_>>());
        assert_eq!(report.first_held, Some(1_021));
        let split = u64::from(frozen > 6);
        assert_eq!((report.repairs.held_rows, report.repairs.splits), (u64::from(frozen), split));
    }
    // A stop, a pause at either end, and a few rows of a device that is slow now and then.
    let clocks: [&dyn Fn(u32) -> u32; 4] = [
        &|row| row.min(1_000) + row.saturating_sub(1_400),
        &|row| row.max(1_000),
        &|row| row.min(1_000),
        &|row| if (1_000..1_004).contains(&row) { 999 } else { row },
    ];
    for clock in clocks {
        let (stamps, report) = read(clock);
        assert_eq!((stamps.len(), report.repairs.held_rows), (4_000, 0));
    }
}

#[test]
fn a_row_that_repeats_a_stamp_is_left_out_but_rounded_stamps_are_refused() {
    let one = blocks("t,q1,dq1,ddq1\n0,1,0,0\n0.1,2,0,0\n0.1,3,0,0\n0.2,4,0,0\n").unwrap();
    assert_eq!(one[0].1.t(), [0.0, 0.1, 0.2]);

    let rounded = "0,0,0,0\n".repeat(50) + &"1,0,0,0\n".repeat(50);
    let refused = blocks(&format!("t,q1,dq1,ddq1\n{rounded}"));
    assert!(matches!(refused, Err(LogError::CoarseClock { repeated: 11, rows: 1, .. })));
}

#[test]
fn time_that_runs_back_is_refused_with_its_place_across_blocks_too() {
    for (rows, back) in [(3, 0.005), (1_025, 10.22)] {
        let mut t = even(rows);
        t[rows as usize - 1] = back;
        match blocks(&swing(&t, true)) {
            Err(LogError::TimeOrder { place, before, .. }) => {
                let row = u64::from(rows);
                assert_eq!((place.row, place.line), (row, Some(row + 1)));
                assert_eq!(before.to_bits(), t[rows as usize - 2].to_bits());
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn what_is_too_short_is_refused_with_its_place() {
    assert!(matches!(blocks("t,q1\n"), Err(LogError::NoRows { .. })));
    assert!(matches!(blocks("t,q1,dq1,ddq1\n\n"), Err(LogError::NoRows { .. })));
    let mut t = even(40);
    t[37..].iter_mut().for_each(|t| *t += 1.0);
    let refused = blocks(&swing(&t, false));
    assert!(matches!(refused, Err(LogError::TooShort { row: 38, rows: 3, needed: 5, .. })));
}
