//! From settings to what was done, and what was not.

use crate::method::Method;
use crate::page::cells::{columns, table};
use crate::results::Results;
use crate::scenario::{RATE, TEST_SECONDS};
use torquewise_report::html::{Item, Section};

/// How the numbers come about.
pub(super) fn section(results: &Results) -> Section {
    let settings = &results.settings;
    let learn = format!(
        "Training logs are {} s of positioning and sorting moves at {RATE} Hz: dwell, accelerate, \
         cruise, brake, dwell, all joints together. Torque and motion come from rigid-body \
         dynamics; white Gaussian noise is added to position, velocity and acceleration, each \
         joint by its own power, none to the torque. Each seed is another motion and other noise; \
         there are {} of them from {} on.",
        settings.seconds, settings.seeds, settings.seed
    );
    let judge = format!(
        "Models are judged by the torque of {TEST_SECONDS} s of smooth sines without noise, drawn \
         with a seed of their own, the same for all models. An error is the RMSE of the torque of \
         a joint over the standard deviation of that torque, in percent. Case 1 has no noise and \
         one run."
    );
    let rows = [
        (Method::Energy, "functions of M(q), V(q), shared by all joints", "3", "criterion [E5]"),
        (Method::Product, "products, for each joint on its own", "3", "criterion [E5]"),
        (Method::SindyLasso, "products, for each joint on its own", "1", "LASSO + BIC, refit"),
        (Method::Sindy, "products, for each joint on its own", "1", "|coefficient| > 0.1"),
    ];
    let rows = rows.map(|(method, library, steps, rule)| {
        vec![method.name().into(), library.into(), steps.into(), rule.into()]
    });
    Section {
        heading: "What was done".into(),
        items: vec![
            Item::Text(learn),
            Item::Text(judge),
            table("The methods.", columns("method;library;steps;which terms stay"), rows.into()),
            Item::Text(
                "Not done here: the experiments on the real arm, Fig. 9 and 11, and its friction \
                 (17). Fig. 10 is done on the simulated arm. The paper does not name its arm, the \
                 length of its logs or the implementation of SINDy; ours are the first three \
                 joints of a PUMA 560 and thresholded least squares, the usual default."
                    .into(),
            ),
        ],
    }
}
