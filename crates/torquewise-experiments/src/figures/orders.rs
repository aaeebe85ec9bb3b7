//! From order curves to Fig. 5: residual against order.

use crate::figures::Figure;
use crate::study::order_curves::OrderResults;
use torquewise_report::order_charts;

/// One panel per library.
pub(crate) fn figure(orders: &[OrderResults]) -> Figure {
    let log = |results: &OrderResults| format!("noise {}", results.noise.name());
    let logs: Vec<_> =
        orders.iter().map(|results| (log(results), results.curves.as_slice())).collect();
    Figure {
        name: "fig5_orders".into(),
        title: "Fig. 5: residual against the order of the library".into(),
        caption: "Least squares on one half of the rows, judged on the other: the residual of the \
                  worst joint over the standard deviation of its torque. The order chosen without \
                  noise is marked: the first that no higher one improves by more than a tenth, the \
                  ratios of all joints multiplied. Of a step, only its own terms change with N₁. \
                  Without noise the residual drops to rounding once the library holds the truth; \
                  with noise it levels off where the noise is all that is left, and rises again \
                  where there are more candidates than the rows can tell apart."
            .into(),
        charts: order_charts(&logs),
        columns: 2,
    }
}
