//! A log written by another program is read to the numbers that stand in it.

use crate::shared;
use torquewise_logs::Logs;

#[test]
fn oracle_states_of_the_reference_arm_are_read_as_they_stand() {
    let Some(folder) = shared("oracle") else { return };
    let file = folder.join("puma560-3.csv");
    let text = std::fs::read_to_string(&file).unwrap();

    let parts = Logs::open(&[file]).unwrap().read_all().unwrap();

    let (read, tau) = (&parts[0], parts[0].require_tau().unwrap());
    assert_eq!((parts.len(), read.n_rows(), read.n_joints()), (1, 500, 3));
    for (row, line) in text.lines().skip(1).enumerate() {
        let stands: Vec<f64> = line.split(',').map(|number| number.parse().unwrap()).collect();
        let signals = [read.q(), read.dq(), read.ddq(), tau];
        let of_row = signals.iter().flat_map(|x| (0..3).map(move |joint| x[(row, joint)]));
        let values = std::iter::once(read.t()[row]).chain(of_row);
        assert!(values.map(f64::to_bits).eq(stands.iter().map(|x| x.to_bits())), "row {row}");
    }
}
