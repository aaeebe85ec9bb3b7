use super::*;
use torquewise_motion::Signals;

fn motion(t: &[f64]) -> Motion {
    let joints = vec!["joint1".into()];
    let [q, dq, ddq] = [(); 3].map(|()| Mat::zeros(t.len(), 1));
    Motion::new(Signals { joints, t: t.to_vec(), q, dq, ddq, tau: None }).unwrap()
}

fn rows_of(blocks: &[HeldOut]) -> Vec<usize> {
    blocks.iter().flat_map(|block| block.rows.clone()).collect()
}

#[test]
fn several_logs_are_held_out_whole_and_one_in_blocks_of_time() {
    let four = motion(&[0.0, 0.1, 0.2, 0.0, 0.1, 0.0, 0.1, 0.2, 0.3, 0.0]);
    let one = motion(&(0..240).map(f64::from).collect::<Vec<_>>());

    let ends = |rows: &[usize]| (rows[0], rows[rows.len() - 1] + 1);
    let of = |motion: &Motion| -> Vec<_> {
        let blocks = whole_logs(motion).into_iter();
        blocks.map(|block| (ends(&block.rows), ends(&block.around))).collect()
    };
    let (logs, blocks) = (of(&four), of(&one));

    assert_eq!(
        logs.iter().map(|(rows, _)| *rows).collect::<Vec<_>>(),
        [(0, 3), (3, 5), (5, 9), (9, 10)]
    );
    assert!(logs.iter().all(|(rows, around)| rows == around));
    assert_eq!(blocks.len(), BLOCKS);
    assert_eq!(blocks[0], ((0, 10), (0, 20)));
    assert_eq!(blocks[5], ((50, 60), (40, 70)));
    assert_eq!(blocks[BLOCKS - 1], ((230, 240), (220, 240)));
}

#[test]
fn short_motion_is_held_out_in_blocks_of_four_rows_and_more() {
    for (rows, count) in [(3, 1), (24, 6), (95, 23), (96, 24)] {
        let t: Vec<f64> = (0..rows).map(f64::from).collect();
        let blocks = even_blocks(&motion(&t));

        assert_eq!(blocks.len(), count);
        assert!(rows_of(&blocks).into_iter().eq(0..t.len()));
        assert!(blocks.iter().all(|block| block.rows.len() >= t.len().min(LEAST_ROWS)));
    }
}

#[test]
fn very_many_logs_are_held_out_some_together() {
    let many = motion(&[0.0, 1.0].repeat(2 * BLOCKS + 1));

    let groups = whole_logs(&many);

    assert_eq!(groups.len(), BLOCKS);
    assert!(rows_of(&groups).into_iter().eq(0..many.n_rows()));
    assert!(groups.iter().all(|group| group.rows[0] % 2 == 0));
}

#[test]
fn a_region_is_held_out_with_the_rows_beside_it() {
    // Two dwells, apart.
    let q = Mat::from_fn(200, 1, |row, _| if row < 100 { 0.0 } else { 1.0 } + 1e-3 * row as f64);
    let motion = Motion::new(Signals { q, ..motion(&[0.0; 200]).into_signals() }).unwrap();

    let blocks = regions(&motion, 3);

    let mut seen = rows_of(&blocks);
    seen.sort_unstable();
    assert!(seen.into_iter().eq(0..200));
    for block in &blocks {
        let (first, last) = (block.rows[0], block.rows[block.rows.len() - 1]);
        assert!(last < 100 || first >= 100, "{first} to {last}");
        let around = (block.around[0], block.around[block.around.len() - 1]);
        assert_eq!(around, (first.saturating_sub(3), (last + 3).min(199)));
    }
}
