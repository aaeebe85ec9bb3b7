//! From claims and errors to the first page: what holds, what does not, what to take home.

use crate::claims::worst;
use crate::figures::looks::worst_joint;
use crate::method::Method;
use crate::page::cells::{columns, table};
use crate::results::{Claim, Results, Verdict};
use torquewise_report::html::number::significant;
use torquewise_report::html::{Callout, Fact, Item, Section, Tone};

/// One paragraph below the title.
pub(super) fn lead(results: &Results) -> String {
    let held = |verdict| results.claims.iter().filter(|c| c.verdict() == verdict).count();
    format!(
        "Every simulated experiment of D. Guo, J. Xu and S. Zhang, “Stepwise Model Reconstruction \
         of Robotic Manipulator Based on Data-Driven Method”, done again on the arm {}, and those \
         that it leaves open. Of {} claims {} hold, {} hold in part and {} are contradicted.",
        results.settings.arm,
        results.claims.len(),
        held(Verdict::Holds),
        held(Verdict::HoldsInPart),
        held(Verdict::Contradicted),
    )
}

/// Error of a method's worst joint in a case \[%\].
fn error(results: &Results, case: u8, method: Method) -> Option<f64> {
    let methods = &results.case(case)?.methods;
    methods.iter().find(|found| found.method == method).map(worst)
}

/// Facts, the claims, and what to take home.
pub(super) fn section(results: &Results) -> Section {
    let facts = Method::ALL.into_iter().filter_map(|method| {
        let error = error(results, 3, method)?;
        Some(Fact::new(format!("{} %", significant(error, 2)), method.name()))
    });
    let mut items = vec![
        Item::Text(
            "Error of the worst joint outside the training log, RMSE over the standard deviation \
             of its torque, in case 3 (60/40/30 dB of noise on position, velocity and \
             acceleration), median over the seeds:"
                .into(),
        ),
        Item::Facts(facts.collect()),
    ];
    items.extend(take_home(results));
    items.push(claims(results));
    Section { heading: "What holds".into(), items }
}

fn take_home(results: &Results) -> Option<Item> {
    let [energy, product, lasso, sindy] = [
        error(results, 3, Method::Energy)?,
        error(results, 3, Method::Product)?,
        error(results, 3, Method::SindyLasso)?,
        error(results, 3, Method::Sindy)?,
    ]
    .map(|percent| significant(percent, 2));
    let harder = harder(results);
    Some(Item::Callout(Callout {
        tone: Tone::Note,
        heading: String::new(),
        lines: [
            format!(
                "One-shot SINDy with a fixed threshold of 0.1 fails as the paper reports ({sindy} \
                 %). But the same library, in one shot, with terms chosen by LASSO and an \
                 information criterion and then refitted, does not ({lasso} %). On these logs it \
                 is the rule for terms that rescues SINDy, not the three steps."
            ),
            format!(
                "The three steps make the regressions smaller and faster. With a sound rule they \
                 change the error of this log little: {product} % stepwise over the product \
                 library.{harder}"
            ),
            format!(
                "What makes the error small is the library: functions of M(q) and V(q) that all \
                 joints share, {energy} %."
            ),
        ]
        .into(),
    }))
}

/// What the steps are worth where noise is strongest, with the same rule for terms.
fn harder(results: &Results) -> String {
    let of = |method| {
        let strongest = results.noise_sweep.iter().rfind(|point| point.method == method)?;
        Some((strongest.noise.name(), worst_joint(&strongest.nrmse_percent).median))
    };
    match (of(Method::Product), of(Method::SindyCriterion)) {
        (Some((noise, stepwise)), Some((_, at_once))) => format!(
            " Where it is hard they pay: at {noise} {} % stepwise, {} % in one shot with the same \
             rule and noise correction.",
            significant(stepwise, 2),
            significant(at_once, 2)
        ),
        _ => String::new(),
    }
}

fn claims(results: &Results) -> Item {
    let row = |claim: &Claim| {
        let verdict = claim.verdict().name().into();
        vec![claim.claim.into(), claim.source.into(), claim.measurement(), verdict]
    };
    table(
        "The claims of the paper, judged.",
        columns("the paper says;where;measured here;verdict"),
        results.claims.iter().map(row).collect(),
    )
}
