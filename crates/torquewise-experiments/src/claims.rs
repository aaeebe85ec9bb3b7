//! From results to claims: what the paper says, what is measured, whether it holds.

use crate::method::Method;
use crate::results::{Claim, Results, Verdict};
use crate::spread::Spread;
use crate::study::cases::{CaseResults, MethodResults};
use crate::study::control::{ControlResults, ControllerResults};
use crate::study::cost::{CRITERION, LASSO, MethodCost, PRODUCT, SINDY, THRESHOLD};
use crate::study::patterns::{PatternStudy, Purity};
use crate::study::steps::StepResults;
use torquewise_report::html::number::significant;

/// A pattern is found if so many percent of its rows are truly of it.
const PURE: f64 = 95.0;
/// A joint is predicted if its error is below this \[%\].
const PREDICTED: f64 = 10.0;
/// Prediction fails where the error of a joint is above this \[%\].
const FAILED: f64 = 15.0;
/// Two counts are about the same within this part of each other.
const ABOUT: f64 = 0.2;
/// Clearly fewer: less than this part.
const FEWER: f64 = 0.5;

/// Judges every claim of the paper that can be simulated.
pub(crate) fn judge_claims(results: &Results) -> Vec<Claim> {
    [
        patterns,
        orders,
        candidates,
        time,
        same_terms,
        fewer_terms,
        extrapolates,
        fails,
        steps,
        tracks,
    ]
    .into_iter()
    .filter_map(|judge| judge(results))
    .collect()
}

fn when(holds: bool, in_part: bool) -> Verdict {
    match (holds, in_part) {
        (true, _) => Verdict::Holds,
        (false, true) => Verdict::HoldsInPart,
        (false, false) => Verdict::Contradicted,
    }
}

fn patterns(results: &Results) -> Option<Claim> {
    let of = |index: &str| results.patterns.studies.iter().find(|study| study.index == index);
    let (scaled, printed) = (of("scaled")?, of("printed")?);
    let least = |study: &PatternStudy| {
        study.purities.iter().map(Purity::percent).fold(f64::INFINITY, f64::min)
    };
    let fine = |study: &PatternStudy| study.elbow == 3 && least(study) >= PURE;
    let claim = "Clustering the activation index gives three clusters, chosen by the elbow, that \
                are standstill, uniform and variable velocity.";
    let measured = format!(
        "Noise {}: with the index as printed the elbow is at k = {} and the least pure of three \
         clusters holds {} % rows of its pattern; with the scaled index [E1] k = {} and {} %.",
        scaled.noise.name(),
        printed.elbow,
        significant(least(printed), 3),
        scaled.elbow,
        significant(least(scaled), 3),
    );
    let verdict = when(fine(printed), fine(scaled));
    Some(Claim::new(claim, "Fig. 1–3", measured, verdict))
}

fn orders(results: &Results) -> Option<Claim> {
    let clean = results.orders.first()?;
    let chosen = clean.curves.iter().map(|curve| {
        let point = &curve.points[curve.chosen];
        let second = if point.motion_order > 0 {
            format!(", N₂ = {}", point.motion_order)
        } else {
            String::new()
        };
        let first = if curve.name == "energy" { "interaction" } else { "N₁" };
        format!("{}: {first} = {}{second}", curve.name, point.order)
    });
    let settles = clean.curves.iter().filter(|curve| {
        let worst = |place: usize| {
            let residuals = curve.points.get(place).map(|point| &point.residual);
            residuals.into_iter().flatten().copied().fold(0.0, f64::max)
        };
        worst(curve.chosen) <= FEWER * worst(0) || curve.chosen == 0
    });
    let settled = settles.count();
    let claim = "The least-squares residual falls fast up to a certain order and hardly beyond it, \
                which gives the orders of each library.";
    let measured =
        format!("Orders chosen without noise: {}.", chosen.collect::<Vec<_>>().join("; "));
    let verdict = when(settled == clean.curves.len(), settled > 0);
    Some(Claim::new(claim, "Fig. 5", measured, verdict))
}

fn cost<'a>(results: &'a Results, name: &str, rule: &str) -> Option<&'a MethodCost> {
    results.costs.iter().find(|cost| cost.name == name && cost.rule == rule)
}

fn candidates(results: &Results) -> Option<Claim> {
    let stepwise = cost(results, PRODUCT, CRITERION)?;
    let sindy = cost(results, SINDY, THRESHOLD)?;
    let steps: Vec<String> = stepwise.candidates_by_step.iter().map(usize::to_string).collect();
    let largest = stepwise.candidates_by_step.iter().max()?;
    let claim = "Stepwise reconstruction reduces the size of the library.";
    let measured = format!(
        "{} candidates in the three steps, {} in one shot; {} in the energy library [E4].",
        steps.join(", "),
        sindy.candidates,
        results.costs.first()?.candidates
    );
    let verdict = when(*largest < sindy.candidates, false);
    Some(Claim::new(claim, "Fig. 6(a)", measured, verdict))
}

fn time(results: &Results) -> Option<Claim> {
    let pairs =
        [(CRITERION, THRESHOLD), (CRITERION, CRITERION), (LASSO, LASSO), (THRESHOLD, THRESHOLD)];
    let mut parts = Vec::new();
    let mut faster = Vec::new();
    for (rule, baseline) in pairs {
        let stepwise = &cost(results, PRODUCT, rule)?.seconds;
        let sindy = &cost(results, SINDY, baseline)?.seconds;
        let ratio = sindy.regression.median / stepwise.regression.median;
        faster.push(ratio > 1.0);
        parts.push(format!(
            "{rule} beside {baseline}: {} s and {} s, ratio {} (with clustering and refit {})",
            significant(stepwise.regression.median, 2),
            significant(sindy.regression.median, 2),
            significant(ratio, 2),
            significant(sindy.total.median / stepwise.total.median, 2),
        ));
    }
    let entries = |cost: &MethodCost| cost.candidates_by_step.iter().map(|p| p * p).sum::<usize>();
    let [stepwise, sindy] =
        [entries(cost(results, PRODUCT, CRITERION)?), entries(cost(results, SINDY, THRESHOLD)?)];
    let measured = format!(
        "The normal equations have {stepwise} entries in all steps, {sindy} in one shot: {} times \
         as many.",
        significant(sindy as f64 / stepwise as f64, 2)
    );
    let times = format!("CPU time of the regression, stepwise {}.", parts.join("; "));
    let verdict = when(faster.iter().all(|f| *f), faster.contains(&true));
    let claim = "Stepwise reconstruction computes faster.";
    Some(Claim::timed(claim, "Fig. 6(b)", [measured, times], verdict))
}

fn of(case: &CaseResults, method: Method) -> Option<&MethodResults> {
    case.methods.iter().find(|results| results.method == method)
}

fn same_terms(results: &Results) -> Option<Claim> {
    let case = results.case(1)?;
    let [stepwise, sindy] = [Method::Product, Method::Sindy].map(|method| of(case, method));
    let (stepwise, sindy) = (stepwise?.active.median, sindy?.active.median);
    let claim = "Without noise stepwise and one-shot SINDy have about the same number of active \
                terms.";
    let measured = format!(
        "{stepwise} and {sindy} coefficients above 0.1; the truth has {}.",
        results.true_terms.active_products.iter().sum::<usize>()
    );
    let verdict = when((stepwise - sindy).abs() <= ABOUT * sindy.max(stepwise), false);
    Some(Claim::new(claim, "Fig. 7, case 1", measured, verdict))
}

fn fewer_terms(results: &Results) -> Option<Claim> {
    let mut parts = Vec::new();
    let (mut fewer, mut lasso_too) = (true, true);
    for case in [2, 3] {
        let found = results.case(case)?;
        let active = |method| Some(of(found, method)?.active.median);
        let (stepwise, sindy) = (active(Method::Product)?, active(Method::Sindy)?);
        let lasso = active(Method::SindyLasso)?;
        fewer &= stepwise < FEWER * sindy;
        lasso_too &= stepwise < FEWER * lasso;
        parts.push(format!(
            "case {case}: {stepwise} beside {sindy} with the threshold and {lasso} with LASSO, \
             BIC and refit"
        ));
    }
    let claim =
        "With noise stepwise reconstruction has far fewer active terms than one-shot SINDy.";
    let measured = format!("Coefficients above 0.1, {}.", parts.join("; "));
    let verdict = when(fewer && lasso_too, fewer);
    Some(Claim::new(claim, "Fig. 7, cases 2 and 3", measured, verdict))
}

/// The error of the worst joint \[%\], median over the seeds.
pub(crate) fn worst(results: &MethodResults) -> f64 {
    results.nrmse_percent.iter().map(|spread: &Spread| spread.median).fold(0.0, f64::max)
}

fn extrapolates(results: &Results) -> Option<Claim> {
    let error = |case, method| Some(worst(of(results.case(case)?, method)?));
    let product = [error(2, Method::Product)?, error(3, Method::Product)?];
    let energy = [error(2, Method::Energy)?, error(3, Method::Energy)?];
    let show = |[second, third]: [f64; 2]| {
        format!("{} % in case 2 and {} % in case 3", significant(second, 2), significant(third, 2))
    };
    let claim = "Stepwise reconstruction predicts torque outside the training data, in cases 2 and \
                3.";
    let measured = format!(
        "The worst joint is off by {} with the product library, by {} with the energy library.",
        show(product),
        show(energy)
    );
    let verdict =
        when(product.iter().all(|e| *e < PREDICTED), product.iter().any(|e| *e < PREDICTED));
    Some(Claim::new(claim, "Fig. 8", measured, verdict))
}

fn fails(results: &Results) -> Option<Claim> {
    let error = |case, method| Some(worst(of(results.case(case)?, method)?));
    let sindy = error(3, Method::Sindy)?;
    let lasso = error(3, Method::SindyLasso)?;
    let claim = "One-shot SINDy fails to predict the torque in case 3.";
    let measured = format!(
        "Its worst joint is off by {} % in case 3, and by {} % in case 2, if coefficients \
             above 0.1 are kept. With LASSO, BIC and a refit the same library in one shot is off \
             by {} %: what fails is the rule for terms, not the single step.",
        significant(sindy, 2),
        significant(error(2, Method::Sindy)?, 2),
        significant(lasso, 2),
    );
    let verdict = when(sindy > FAILED && lasso > FAILED, sindy > FAILED || lasso > FAILED);
    Some(Claim::new(claim, "Fig. 8, case 3", measured, verdict))
}

fn steps(results: &Results) -> Option<Claim> {
    results.steps.first()?;
    let means = |steps: &StepResults| -> Vec<f64> {
        let joints = steps.refitted_nrmse_percent.len().max(1) as f64;
        steps.nrmse_percent.iter().map(|step| step.iter().sum::<f64>() / joints).collect()
    };
    let told = |steps: &StepResults| {
        let after = means(steps).iter().map(|mean| significant(*mean, 3)).collect::<Vec<_>>();
        format!("{} % ({})", after.join(", "), steps.method.name())
    };
    let falls = |steps: &StepResults| means(steps).windows(2).all(|pair| pair[1] < pair[0]);
    let claim = "Each step makes the predicted torque more accurate.";
    let measured = format!(
        "Mean error of the joints after steps 1, 2, 3 in case 2, first seed: {}.",
        results.steps.iter().map(told).collect::<Vec<_>>().join("; ")
    );
    let verdict = when(results.steps.iter().all(falls), results.steps.iter().any(falls));
    Some(Claim::new(claim, "Fig. 10, here simulated", measured, verdict))
}

/// The error of a controller as a share of that of PID, the worst joint.
pub(crate) fn worst_share(results: &ControlResults, controller: &str) -> Option<f64> {
    let of = |name: &str| -> Option<&ControllerResults> {
        results.tracking.iter().find(|found| found.name == name)
    };
    let (found, pid) = (of(controller)?, of("PID")?);
    let shares = found.rms_error_rad.iter().zip(&pid.rms_error_rad).map(|(a, b)| a / b);
    Some(shares.fold(0.0, f64::max))
}

fn tracks(results: &Results) -> Option<Claim> {
    let share = |controller| worst_share(&results.control, controller);
    let (first, second) = (share("controller 1")?, share("controller 2")?);
    let best = [share("controller 1, perfect model")?, share("controller 2, perfect model")?];
    let claim = "The model of step 1 in the controller improves tracking over PID significantly, \
                that of step 3 further.";
    let percent = |share: f64| significant(100.0 * share, 2);
    let measured = format!(
        "Error of the worst joint beside PID with the same gains: controller 1 {} %, controller 2 \
         {} %; with a perfect model {} % and {} %.",
        percent(first),
        percent(second),
        percent(best[0]),
        percent(best[1]),
    );
    let verdict = when(first < 1.0 && second < FEWER * first, second < first && second < 1.0);
    Some(Claim::new(claim, "Fig. 11, here simulated", measured, verdict))
}
