use torquewise_dynamics::*;
use torquewise_identify::*;
use std::time::Instant;
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let which = args.get(1).map_or("energy", String::as_str);
    let arm_name = args.get(2).map_or("puma560-3", String::as_str);
    let arm = Arm::builtin(arm_name).unwrap();
    let seconds: f64 = args.get(3).map_or(600.0, |s| s.parse().unwrap());
    for case in 1..=3u8 {
        for seed in 1..=args.get(4).map_or(1u64, |s| s.parse().unwrap()) {
        let log = simulate(&arm, &MotionPlan { kind: MotionKind::Moves, seconds, rate: 100.0, seed }).unwrap();
        let noisy = add_noise(&log.motion, &Noise::case(case).unwrap(), seed).unwrap();
        let test = simulate(&arm, &MotionPlan { kind: MotionKind::Sines, seconds: 20.0, rate: 100.0, seed: 77 }).unwrap();
        let mut plan = match which { "product" => Plan::product(), "sindy" => Plan::sindy(), _ => Plan::default() };
        if args.contains(&"raw".to_string()) { plan.noise_correction = false; }
        if args.contains(&"stlsq".to_string()) { plan.selector = torquewise_sparse::select::Selector::Stlsq(torquewise_sparse::select::stlsq::Stlsq { threshold: 0.1, ..Default::default() }); }
        if args.contains(&"lasso".to_string()) { plan.selector = torquewise_sparse::select::Selector::Lasso(Default::default()); }
        let t = Instant::now();
        let mut last = (t, String::new());
        let found = reconstruct(&noisy, &plan, &mut |p| { 
            eprint!("{} {:.2}s; ", last.1, last.0.elapsed().as_secs_f64()); last = (Instant::now(), format!("{p:?}")); }).unwrap();
        eprintln!();
        let s = score(&found.model, &test.motion).unwrap();
        let labels = found.patterns.label(&noisy);
        let mut conf = [[0usize;3];3];
        for (a,b) in log.truth.iter().zip(&labels) { conf[*a as usize][*b as usize]+=1; }
        println!("case {case} seed {seed} k={} conf {:?} time {:.2}", found.patterns.n_clusters(), conf, t.elapsed().as_secs_f64());
        println!("  candidates {} steps {:?}", found.candidates, found.steps.iter().map(|s| (s.name, s.rows, s.candidates, s.active.clone(), s.route)).collect::<Vec<_>>());
        println!("  terms {} active {:?}", found.model.form.n_coefficients(), found.model.form.active(arm.n_joints()));
        println!("  nrmse {:?}", s.joints.iter().map(|j| format!("{:.3e}", j.nrmse_percent)).collect::<Vec<_>>());
        for w in &found.warnings { println!("  ! {w}"); }
        if args.contains(&"show".to_string()) { println!("{}", torquewise_model::print::text(&found.model)); println!("{:?}", found.noise); }
        }
    }
}
