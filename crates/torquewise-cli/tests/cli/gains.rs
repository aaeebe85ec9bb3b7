//! What an ampere is worth, told by a load of known mass.

use crate::robots::robot;
use crate::spoilt::Table;
use crate::terminal::{Terminal, each};
use serde_json::Value;

/// Logs of the arm, bare and with 1.5 kg on its tool, as currents of motors of these gains, and a model
/// of the bare arm that takes them for torques.
fn in_amperes([shoulder, elbow]: [f64; 2]) -> Terminal {
    let terminal = Terminal::holding("loaded.urdf", &robot(1.6));
    terminal.write("arm.urdf", &robot(0.1));
    for (file, seconds, seed) in [("arm", 60, 1), ("loaded", 40, 3)] {
        let motion = format!("--seconds {seconds} --rate 50 --case 2 --seed {seed}");
        terminal.done(&format!("simulate {file}.urdf -o {file}.csv {motion}"));
        let log = Table::of(&terminal, &format!("{file}.csv"));
        let amperes = log.scaled(&["tau1"], 1.0 / shoulder).scaled(&["tau2"], 1.0 / elbow);
        terminal.write(&format!("{file}.csv"), &amperes.text());
    }
    terminal.done("fit arm.csv --urdf arm.urdf -o amperes.json");
    terminal
}

fn are_said_to_differ(found: &Value) -> bool {
    let warnings = found["warnings"].as_array().unwrap();
    warnings.iter().any(|warning| warning.as_str().unwrap().contains("gains differ"))
}

#[test]
fn a_known_mass_says_what_an_ampere_is_worth() {
    let terminal = in_amperes([8.0, 8.0]);

    let line = "payload amperes.json loaded.csv --known-mass 1.5 -o drives.toml";
    let found = terminal.json(line);

    let [gains, errors] = ["value", "std_error"].map(|key| each(&found["gains"], key));
    for (gain, error) in gains.iter().zip(&errors) {
        assert!((gain - 8.0).abs() < 0.4 && (gain - 8.0).abs() < 3.0 * error, "{found}");
    }
    assert!((0.15..0.22).contains(&found["apparent_mass"].as_f64().unwrap()), "{found}");
    assert!(!are_said_to_differ(&found), "{found}");
    terminal.done("fit arm.csv --urdf arm.urdf --profile drives.toml -o arm.json");
    let load = terminal.json("payload arm.json loaded.csv --profile drives.toml");
    assert!((load["mass"]["value"].as_f64().unwrap() - 1.5).abs() < 0.08, "{load}");
    terminal.misused("payload arm.json loaded.csv --known-mass 0", &["above 0"]);
    terminal.refused("payload amperes.json arm.csv --known-mass 1.5 -o x.toml", &["show no load"]);
}

#[test]
fn gains_that_differ_are_found_again_by_the_models_that_they_give() {
    let terminal = in_amperes([8.0, 6.0]);
    let mut found = terminal.json("payload amperes.json loaded.csv --known-mass 1.5 -o 0.toml");
    let mut gains = each(&found["gains"], "value");
    assert!(are_said_to_differ(&found), "{found}");

    for round in 0..3 {
        terminal.done(&format!("fit arm.csv --urdf arm.urdf --profile {round}.toml -o arm.json"));
        let line = format!("--profile {round}.toml --known-mass 1.5 -o {}.toml", round + 1);
        found = terminal.json(&format!("payload arm.json loaded.csv {line}"));
        gains.iter_mut().zip(each(&found["gains"], "value")).for_each(|(gain, more)| *gain *= more);
    }

    assert!(!are_said_to_differ(&found), "{found}");
    let errors = each(&found["gains"], "std_error");
    for ((gain, truth), error) in gains.iter().zip([8.0, 6.0]).zip(errors) {
        let apart = (gain - truth).abs();
        assert!(apart < 0.03 * truth && apart < 3.0 * error * truth, "{gains:?}: {found}");
    }
}
