//! A model with friction, as `show` and `predict` tell it.

use crate::physics::changed;
use crate::spoilt::{Table, noise};
use crate::terminal::{Terminal, numbers};
use serde_json::{Value, json};

/// Friction of both joints, most of it dry.
pub(crate) const DRY: &str = "[joint1]\ncoulomb = 4.0\nviscous = 2.0\n[joint2]\ncoulomb = 2.0\n";

/// The fitted model of a log without friction, with friction and a choice written into its file.
fn with_friction() -> Terminal {
    let rubbing: Value = serde_json::from_str(include_str!("rubbing.json")).unwrap();
    changed(|model| {
        for part in ["friction", "choices"] {
            model[part] = rubbing[part].clone();
        }
    })
}

/// Terms of a library without friction would miss half of the torque.
#[test]
fn friction_that_was_not_asked_for_is_learned() {
    let terminal = Terminal::new();
    terminal.write("dry.toml", "[joint1]\ncoulomb = 2.0\nviscous = 1.5\n[joint2]\ncoulomb = 1.0\n");
    let plan = "planar-2 --seconds 40 --rate 100 --case 2";
    terminal.done(&format!("simulate {plan} --friction dry.toml -o log.csv"));

    let found = terminal.json("fit log.csv -o model.json");

    assert_eq!(found["verdict"], "good", "{found}");
    let shown = terminal.json("show model.json");
    let coulomb =
        |joint: usize| &shown["friction_parameters"][joint]["forward"]["coulomb"]["value"];
    for (joint, planted) in [2.0, 1.0].into_iter().enumerate() {
        let value = coulomb(joint).as_f64().unwrap();
        assert!((value - planted).abs() < 0.05 * planted, "{joint}: {value}");
    }
    // A method that was asked for stays.
    let terms = terminal.json("fit log.csv --library energy -o terms.json");
    assert_ne!(terms["verdict"], "good", "{terms}");
}

/// A filter blurs the torque at reversals: raw torque tells how sharp they are.
#[test]
fn dry_friction_of_a_filtered_log_is_as_sharp_as_it_was() {
    let terminal = Terminal::holding("dry.toml", DRY);
    for seed in [1, 2] {
        let plan = format!("planar-2 --motion sines --seconds 60 --rate 200 --seed {seed}");
        terminal.done(&format!("simulate {plan} --friction dry.toml -o log{seed}.csv"));
        let table = Table::of(&terminal, &format!("log{seed}.csv"));
        let table = table.without(&["dq1", "dq2", "ddq1", "ddq2"]);
        let table = ["tau1", "tau2"]
            .into_iter()
            .fold(table, |table, name| table.with(name, |row, tau, _| tau + 0.05 * noise(row)));
        terminal.write(&format!("log{seed}.csv"), &table.text());
    }

    terminal.done("fit log1.csv -o model.json");
    let found = terminal.json("evaluate model.json log2.csv");

    for joint in found["joints"].as_array().unwrap() {
        assert!(joint["raw_nrmse_percent"].as_f64().unwrap() < 2.0, "{joint}");
    }
}

#[test]
fn show_sets_friction_apart_and_tells_what_was_chosen() {
    let terminal = with_friction();

    let text = terminal.done("show changed.json --explain");
    let shown = terminal.json("show changed.json");

    let table = "joint        direction      F_c [N·m]  F_v [N·m·s/rad]\n\
                 joint2            both  0.700 ± 0.010                –\n\
                 q1 + 0.5*q2       both              –    2.000 ± 0.010";
    let first = text.split("\n\n").nth(1).unwrap();
    assert!(text.starts_with("Friction, ± standard error") && first == table, "{text}");
    let [own, shared] = [&shown["friction_parameters"][0], &shown["friction_parameters"][1]];
    assert_eq!(own["forward"]["coulomb"], json!({ "value": 0.7, "std_error": 0.01 }));
    assert_eq!([&own["name"], &own["stiffness"]], [&json!("joint2"), &Value::Null]);
    assert_eq!(shared["backward"]["viscous"]["value"], 2.0);
    assert_eq!(shared["shaft"], json!([1.0, 0.5]));
    let own = "  friction:\n  + 0.700 ± 0.010 * sign(dq2)  (90 %)\n";
    assert!(text.contains(&(own.to_owned() + "  + 1.0000 ± 0.0050 * (dq1 + 0.5*dq2)")), "{text}");
    let chosen = "friction: sign, viscous, chosen on held-out data (one standard error, 5 blocks \
                  in time)\n\n\
                  candidate      error [%]   ± [%]  coefficients\n\
                  none               31.00  0.2000             0\n\
                  sign, viscous      4.500  0.2000             2  chosen\n";
    assert!(text.ends_with(chosen), "{text}");
    let terms = shown["joints"][1]["terms"].as_array().unwrap();
    let friction: Vec<&Value> = terms.iter().filter(|term| term["kind"] == "friction").collect();
    assert_eq!(friction.len(), 2);
    assert_eq!(friction[0]["coefficient"], 1.0);
    assert_eq!(shown["friction"][0]["coefficient"], 2.0);
    assert_eq!(shown["friction"][1]["term"], "sign(dq2)");
    assert_eq!(shown["choices"][0]["from"][1]["complexity"], 2);
    let latex = terminal.done("show changed.json --format latex");
    assert!(latex.contains(r"\operatorname{sign}(\dot q_{2})"), "{latex}");
    assert_eq!(terminal.json("show changed.json --check")["checks"]["passed"], true);
}

#[test]
fn show_keeps_to_the_joint_and_the_part_that_are_asked_for() {
    let terminal = with_friction();

    let first = terminal.done("show changed.json --joint 1 --part gravity");
    let friction = terminal.json("show changed.json --joint joint2 --part friction");

    assert!(first.contains("tau1 = [joint1]") && !first.contains("tau2"), "{first}");
    assert!(!first.contains("friction") && !first.contains("ddq"), "{first}");
    assert_eq!(friction["joints"].as_array().unwrap().len(), 1);
    let terms = friction["joints"][0]["terms"].as_array().unwrap();
    assert!(terms.len() == 2 && terms.iter().all(|term| term["kind"] == "friction"));
    let top = terminal.json("show changed.json --top 1");
    assert_eq!(top["joints"][0]["terms"].as_array().unwrap().len(), 1);
    for joint in ["elbow", "0", "3"] {
        terminal.misused(&format!("show changed.json --joint {joint}"), &["joint1, joint2"]);
    }
}

#[test]
fn show_begins_with_the_axes_of_a_learned_chain() {
    let terminal = Terminal::new();
    terminal.done("simulate planar-2 -o log.csv --seconds 30 --rate 50 --seed 1");
    terminal.run("fit log.csv -o chain.json --library chain --friction none");

    let text = terminal.done("show chain.json");
    let axes = &terminal.json("show chain.json")["geometry"];

    assert!(text.starts_with("Geometry"), "{text}");
    // Both axes of the arm are parallel, 0.5 m apart.
    let distance = |k: usize| -> f64 {
        let of = |axis: usize| axes[axis]["point"][k].as_f64().unwrap();
        of(1) - of(0)
    };
    let apart = (0..3).map(|k| distance(k).powi(2)).sum::<f64>().sqrt();
    assert!((apart - 0.5).abs() < 1e-3, "{axes}");
    let cosine: f64 = (0..3)
        .map(|k| {
            let of = |axis: usize| axes[axis]["axis"][k].as_f64().unwrap();
            of(0) * of(1)
        })
        .sum();
    assert!((cosine.abs() - 1.0).abs() < 1e-3, "{axes}");
    // A length needs an axis before the one before.
    assert!(text.contains("length along it") && axes[1]["along_previous_m"].is_null(), "{text}");
}

#[test]
fn evaluate_simulates_windows_of_the_log() {
    let terminal = Terminal::new();
    terminal.done("simulate planar-2 -o log.csv --seconds 30 --rate 50 --seed 1");
    terminal.done("simulate planar-2 -o test.csv --seconds 30 --rate 50 --seed 2");
    terminal.run("fit log.csv -o chain.json --library chain --friction none");

    let found = &terminal.json("evaluate chain.json test.csv --rollout 0.2,0.5")["rollout"];
    let text = terminal.run("evaluate chain.json test.csv --rollout").stdout;

    assert_eq!(found[1]["horizon_s"], 0.5);
    for joint in 0..2 {
        let of = |what: &str| found[1][what][joint].as_f64().unwrap();
        assert!(of("rms_drift_rad") < 0.1 * of("hold_rms_rad"), "{found}");
    }
    assert!(text.contains("after 0.2 s") && text.contains("after 1 s"), "{text}");
    let pushed = Table::of(&terminal, "test.csv").with("tau1", |_, tau, _| tau + 40.0);
    terminal.write("pushed.csv", &pushed.text());
    let drifts =
        |log: &str| terminal.run(&format!("evaluate chain.json {log} --rollout 0.5")).stderr;
    assert!(drifts("pushed.csv").contains("note: simulated, the drift of joint1"));
    assert!(!drifts("test.csv").contains("simulated, the drift"));
    terminal.done("simulate planar-2 -o noisy.csv --seconds 30 --rate 50 --seed 3 --case 2");
    terminal.run("fit noisy.csv -o noisy.json --library chain --friction none");
    let found =
        &terminal.json("evaluate noisy.json noisy.csv --rollout 0.2 --samples 50")["rollout"];
    for share in numbers(&found[0]["covered"]) {
        assert!((0.8..0.98).contains(&share), "{found}");
    }
    terminal.misused("evaluate chain.json test.csv --rollout 0.5,-1", &["--rollout", "above 0"]);
}

#[test]
fn predict_prints_the_torque_of_a_pose() {
    let terminal = with_friction();

    let found = terminal.json("predict changed.json --q 0.3,-0.5 --dq -0.2,0.1");

    let of = |what: &str| numbers(&found[what]);
    let shaft = 2.0 * (-0.2 + 0.5 * 0.1);
    for (own, expected) in of("friction").iter().zip([shaft, 0.5 * shaft + 0.7]) {
        assert!((own - expected).abs() < 1e-12, "{found}");
    }
    // V = 19.62 sin q₁ + 3.924 sin(q₁ + q₂)
    let far = 3.924 * (-0.2_f64).cos();
    for (own, expected) in of("gravity").iter().zip([19.62 * 0.3_f64.cos() + far, far]) {
        assert!((own - expected).abs() < 1e-3, "{found}");
    }
    let said = terminal.run("predict changed.json --q 0.3,-0.5 --dq 0,0.1").stderr;
    assert!(!said.contains("at rest may be anything"), "{said}");
    terminal.misused("predict changed.json --q 0.3,0 --delay 0", &["cannot be used with"]);
    terminal.refused("predict changed.json --q 0.3", &["q has 1", "2"]);
    terminal.misused("predict changed.json --q 0.3,NaN", &["a number for each joint"]);
    terminal.misused("predict changed.json log.csv --q 0.3,0 -o a.csv", &["cannot be used with"]);
}
