//! The energy model of the reference arm over five logs: terms, error and intervals.

use torquewise_experiments::Settings;
use torquewise_experiments::agenda::Agenda;
use torquewise_experiments::method::Method;
use torquewise_experiments::study::cases::ask_methods;
use torquewise_experiments::study::coefficients::judge_coefficients;

#[test]
fn in_noise_the_true_terms_are_found_and_the_intervals_hold_the_truth() {
    let settings = Settings { seconds: 200.0, seeds: 5, ..Settings::full(1) };
    let mut agenda = Agenda::default();
    let cases = ask_methods(&mut agenda, &settings, &[Method::Energy]);
    let trials = agenda.run(settings.seed, &|_, _| {}).unwrap();

    for case in cases.iter().filter(|case| case.case > 1) {
        let found = judge_coefficients(case, &settings, &trials).unwrap();
        assert_eq!((found.runs, found.exact_runs), (5, 5), "case {}", case.case);
        // 115 intervals of 90 %, 23 of each log sharing its noise.
        let share = found.coverage_percent();
        assert!((80.0..=98.0).contains(&share), "case {}: {share}", case.case);

        let errors = case.results(&settings, &trials).unwrap().methods[0].nrmse_percent.clone();
        for (error, limit) in errors.iter().zip([0.3, 0.1, 0.1]) {
            assert!(error.median < limit, "case {}: {errors:?}", case.case);
        }
    }
}
