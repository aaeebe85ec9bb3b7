//! From candidates to multiplications: what each route to their normal equations costs.

use torquewise_identify::{LibraryKind, Regression};
use torquewise_model::JointKind;
use torquewise_regression::moments::MomentPlan;
use torquewise_regression::row_sums::Route;
use torquewise_regression::{Design, PreparedDesign};
use torquewise_stepwise::Candidates;

const N_RESPONSES: usize = 3;

/// The one-shot SINDy library of three joints, N₁ = 4, N₂ ≤ 2.
fn sindy() -> Design {
    let candidates = Candidates::new(
        &[JointKind::Revolute; 3],
        LibraryKind::PRODUCT,
        Regression::OneShot,
        Vec::new(),
    );
    candidates.expect("a library that fits into memory").design
}

#[test]
fn moments_of_the_sindy_library_are_those_of_e3_and_take_a_twentieth_of_its_multiplications() {
    let design = sindy();

    let [by_moments, by_rows] = [Route::Moments, Route::Direct]
        .map(|route| PreparedDesign::new(&design, N_RESPONSES, route).cost());

    assert_eq!(design.n_columns(), 3_612);
    for (rows, route) in [(60_000, Route::Moments), (1, Route::Direct)] {
        assert_eq!(PreparedDesign::cheaper(&design, N_RESPONSES, rows).route(), route);
    }
    assert!(by_rows > 20.0 * by_moments, "{by_rows} and {by_moments} multiplications per row");
    let plan = MomentPlan::new(&design);

    // Harmonics up to 8 of three angles, monomials up to degree 4 of six variables; 129 harmonics
    // and 28 monomials with each torque.
    assert_eq!(plan.size(N_RESPONSES), 833 * 210 + 129 * 28 * N_RESPONSES);
}
