//! From torques computed by Pinocchio to the energy library spans them exactly (E4).

use crate::shared::shared;
use crate::support::{fit, percent};
use torquewise_identify::Plan;
use torquewise_logs::Logs;

#[test]
fn random_states_of_the_reference_arm_predict_held_out_states() {
    let Some(file) = shared("oracle/puma560-3.csv") else { return };
    let states = Logs::open(&[file]).unwrap().read_all().unwrap().remove(0);
    let every_second = |first| (first..states.n_rows()).step_by(2).collect::<Vec<usize>>();
    let [train, test] = [0, 1].map(|first| states.select(&every_second(first)));

    let found = fit(&train, &Plan::default());

    let errors = percent(&found.model, &test);
    assert_eq!(found.model.form.n_coefficients(), 23);
    assert!(errors.iter().all(|&percent| percent < 1e-7), "{errors:?}");
}
