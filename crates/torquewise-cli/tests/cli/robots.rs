//! From a log and a URDF to a URDF, and what hangs on the arm.

use crate::spoilt::{Table, assert_warns};
use crate::terminal::{Terminal, each};
use std::f64::consts::FRAC_PI_2;
use torquewise::model::{Model, Torque, from_json};

/// Two joints and a tool, as a URDF has them; the tool may be heavier.
pub(crate) fn robot(tool: f64) -> String {
    include_str!("pair.urdf").replace("TOOL", &tool.to_string())
}

/// The arm, a log of it, and a model that was told where its axes lie.
fn fitted() -> Terminal {
    let terminal = Terminal::holding("arm.urdf", &robot(0.1));
    terminal.done("simulate arm.urdf -o log.csv --seconds 40 --rate 50 --case 2 --seed 1");
    terminal.done("fit log.csv --urdf arm.urdf -o arm.json");
    terminal
}

/// Logs of the arm mounted so, and what a fit says that takes it to stand on a floor.
///
/// - `mount`: roll, pitch and yaw of its base
fn fitted_as_on_a_floor(mount: &str) -> (Terminal, String) {
    let floor = robot(0.1);
    let mount = format!(
        "<link name=\"world\"/><joint name=\"mount\" type=\"fixed\"><parent link=\"world\"/>\
         <child link=\"base\"/><origin rpy=\"{mount}\"/></joint></robot>"
    );
    let terminal = Terminal::holding("mounted.urdf", &floor.replace("</robot>", &mount));
    terminal.write("floor.urdf", &floor);
    let motion = "--seconds 40 --rate 50 --case 2";
    terminal.done(&format!("simulate mounted.urdf -o log.csv {motion} --seed 1"));
    terminal.done(&format!("simulate mounted.urdf -o test.csv {motion} --seed 2"));
    let fit = terminal.run("fit log.csv --urdf floor.urdf -o arm.json");
    (terminal, fit.stderr)
}

/// Whether a model misses the torque of a log by less than so many percent of its spread.
fn assert_predicts(terminal: &Terminal, model_and_log: &str, most: f64) {
    let scores = terminal.json(&format!("evaluate {model_and_log}"));
    assert!(each(&scores["joints"], "nrmse_percent").iter().all(|x| *x < most), "{scores}");
}

#[test]
fn an_arm_on_a_wall_is_told_from_one_on_the_floor() {
    let (terminal, stderr) = fitted_as_on_a_floor("0 1.5707963 0");
    let said = terminal.run("fit log.csv --urdf floor.urdf --gravity 1,0,0 -o arm.json");

    assert!(stderr.contains("gravity pulls along ±(1.00, "), "{stderr}");
    assert!(!said.stderr.contains("gravity pulls"), "{said:?}");
    assert_predicts(&terminal, "arm.json test.csv", 2.0);
}

#[test]
fn an_arm_on_a_ceiling_is_no_arm_on_the_floor() {
    let (terminal, stderr) = fitted_as_on_a_floor("3.1415927 0 0");
    let said = terminal.run("fit log.csv --urdf floor.urdf --gravity 0,0,1 -o arm.json");

    assert!(stderr.contains("gravity pulls along (0.00, 0.00, 1.00) of the base"), "{stderr}");
    assert!(said.code == 0 && !said.stderr.contains("gravity pulls"), "{said:?}");
}

#[test]
fn a_base_that_is_not_level_is_tilted() {
    let (terminal, stderr) = fitted_as_on_a_floor("0 0.0523599 0");

    assert!(!stderr.contains("gravity pulls"), "{stderr}");
    let model: serde_json::Value = serde_json::from_str(&terminal.read("arm.json")).unwrap();
    let choices = model["choices"].as_array().unwrap();
    let gravity = choices.iter().find(|own| own["what"] == "direction of gravity").unwrap();
    assert_eq!(gravity["chosen"], "tilted");
    assert_predicts(&terminal, "arm.json test.csv", 2.0);
}

#[test]
fn joints_that_a_log_counts_otherwise_than_the_urdf_are_told() {
    let terminal = Terminal::new();
    terminal.done("simulate puma560-3 -o log.csv --seconds 40 --rate 50 --case 2 --seed 1");
    terminal.done("fit log.csv --library chain -o arm.json");
    terminal.done("export arm.json --to urdf -o arm.urdf");
    let log = Table::of(&terminal, "log.csv");
    terminal.write("turned.csv", &log.clone().scaled(&["q3", "dq3", "ddq3", "tau3"], -1.0).text());
    terminal.write("zero.csv", &log.with("q2", |_, q, _| q - FRAC_PI_2).text());

    let said = |log: &str| terminal.run(&format!("fit {log} --urdf arm.urdf -o new.json"));
    let (same, turned, zero) = (said("log.csv"), said("turned.csv"), said("zero.csv"));

    assert!(!same.stderr.contains("count joints otherwise"), "{same:?}");
    assert!(turned.stderr.contains("with joint3 as -q held-out torque"), "{turned:?}");
    assert!(turned.stdout.contains("counted otherwise than in the URDF"), "{turned:?}");
    assert!(zero.stderr.contains("with joint2 as q + 90° held-out torque"), "{zero:?}");
    // Said so in a profile, they fit.
    let signals = ["q", "dq", "ddq", "tau"].map(|signal| {
        let zero = if signal == "q" { "offset = [0, 1.5707963, 0]" } else { "" };
        format!("[{signal}]\ncolumns = \"{signal}\"\n{zero}\n")
    });
    terminal.write("arm.toml", &format!("[t]\ncolumn = \"t\"\n{}", signals.concat()));
    let cured = said("zero.csv --profile arm.toml");
    assert!(!cured.stderr.contains("count joints otherwise"), "{cured:?}");
    assert_eq!(cured.code, 0, "{cured:?}");
}

#[test]
fn a_urdf_of_another_arm_is_doubted() {
    let terminal = fitted();
    let other = terminal.read("arm.urdf").replace("axis xyz=\"1 0 0.1\"", "axis xyz=\"0 1 0.1\"");
    terminal.write("other.urdf", &other);

    let is_doubted = |urdf: &str| {
        let said = terminal.run(&format!("fit log.csv --urdf {urdf} -o new.json"));
        said.stderr.contains("axes elsewhere than in the URDF")
    };

    assert!(is_doubted("other.urdf") && !is_doubted("arm.urdf"));
}

#[test]
fn what_the_log_does_not_tell_of_a_link_stays_that_of_the_urdf() {
    let terminal = fitted();
    // A file whose links are of the right size, though not of the right inertia about their axes.
    let file = terminal.read("arm.urdf").replace("iyy=\"0.05\"", "iyy=\"0.06\"");
    terminal.write("other.urdf", &file);

    terminal.done("export arm.json --to urdf --onto other.urdf -o new.urdf");

    // The first link turns about its y alone: its mass and the other moments are of no torque.
    let text = terminal.read("new.urdf");
    let upper = &text[text.find("<link name=\"upper\">").unwrap()..];
    let number = |name: &str| -> f64 {
        let start = upper.find(&format!("{name}=\"")).unwrap() + name.len() + 2;
        upper[start..].split('"').next().unwrap().parse().unwrap()
    };
    let mass = upper[upper.find("<mass value=\"").unwrap() + 13..].split('"').next().unwrap();
    let mass: f64 = mass.parse().unwrap();
    assert!((mass - 4.0).abs() < 0.8, "{text}");
    for (name, expected) in [("ixx", 0.05), ("izz", 0.02)] {
        assert!((number(name) - expected).abs() < 0.2 * expected, "{name}: {text}");
    }
    // What the log tells is the log's: the torque is that of the arm, not of the file.
    terminal.done("simulate new.urdf -o new.csv --seconds 10 --rate 50 --seed 5 --motion sines");
    assert_predicts(&terminal, "arm.json new.csv", 2.0);
}

#[test]
fn a_urdf_comes_back_with_what_was_learned_and_all_else_as_it_was() {
    let terminal = fitted();

    terminal.done("export arm.json --to urdf --onto arm.urdf -o new.urdf");
    terminal.done("export arm.json --to urdf -o own.urdf");
    terminal.done("export arm.json --to mjcf -o own.xml");
    terminal.done("export arm.json --to urdf --samples 2 --seed 4 -o twins");

    // The learned robot moves as the true one, whose log the model has not seen.
    let motion = "--seconds 10 --rate 50 --seed 5 --motion sines";
    for file in ["arm", "new", "own"] {
        terminal.done(&format!("simulate {file}.urdf -o {file}.csv {motion}"));
    }
    // Those drawn from its covariance move nearly so.
    for file in ["twins/twins-001", "twins/twins-002"] {
        terminal.done(&format!("simulate {file}.urdf -o drawn.csv {motion}"));
        assert_predicts(&terminal, "arm.json drawn.csv", 5.0);
    }
    assert_predicts(&terminal, "arm.json arm.csv", 1.0);
    let new = terminal.read("new.urdf");
    assert!(new.contains("<mass value=\"0.1\"/>") && new.contains("armature="), "{new}");
    terminal.refused("export arm.json --to urdf --onto log.csv -o x.urdf", &["no XML"]);
    let misplaced = "export arm.json --to c --onto arm.urdf -o x.c";
    terminal.misused(misplaced, &["--onto is for --to urdf"]);
}

#[test]
fn a_load_is_weighed_and_added_to_a_model_of_its_own() {
    let terminal = fitted();
    terminal.write("loaded.urdf", &robot(0.6));
    terminal.done("simulate loaded.urdf -o loaded.csv --seconds 20 --rate 50 --case 2 --seed 3");
    let before = terminal.read("arm.json");

    let load = terminal.json("payload arm.json loaded.csv -o both.json");

    let [mass, error] = ["value", "std_error"].map(|key| load["mass"][key].as_f64().unwrap());
    assert!((mass - 0.5).abs() < 0.01 && (mass - 0.5).abs() < 4.0 * error, "{load}");
    for (found, truth) in each(&load["center"], "value").iter().zip([0.0, 0.0, 0.3]) {
        assert!((found - truth).abs() < 0.005, "{load}");
    }
    assert_eq!(load["link"], "fore");
    assert_eq!(terminal.read("arm.json"), before);
    terminal
        .done("simulate loaded.urdf -o test.csv --seconds 10 --rate 50 --seed 5 --motion sines");
    assert_predicts(&terminal, "both.json test.csv", 1.0);
    for (model, is_told) in [("arm", true), ("both", false)] {
        let said = terminal.run(&format!("evaluate {model}.json test.csv")).stderr;
        assert_eq!(said.contains("carry another load"), is_told, "{said}");
    }
    // The equations that are read are those of the arm with its load.
    let both = from_json(&terminal.read("both.json")).unwrap();
    let read = Model { chain: None, ..both.clone() };
    let [both, read] = [both, read].map(|model| Torque::new(&model).gravity(&[0.4, -0.7]).unwrap());
    for (own, by_terms) in both.iter().zip(&read) {
        assert!((own - by_terms).abs() < 0.01 * own.abs(), "{both:?}, {read:?}");
    }
    let nothing = terminal.run("payload arm.json log.csv --strict");
    assert_warns(&nothing, &["the mass is not told from zero"]);
    let said = terminal.run("payload both.json log.csv").stderr;
    assert!(said.contains("log is 0.50") && said.lines().count() == 1, "{said}");
    // One load is asked of logs that carry two, and of two that carry the same.
    let said = terminal.run("payload arm.json log.csv loaded.csv").stderr;
    assert!(said.contains("log.csv and loaded.csv disagree about the gravity of"), "{said}");
    let same = terminal.run("payload arm.json loaded.csv test.csv").stderr;
    assert!(!same.contains("disagree about the gravity"), "{same}");
}

#[test]
fn a_fit_weighs_loads_of_other_logs_alike_with_axes_that_are_given_and_learned() {
    let terminal = fitted();
    for (file, mass, seed) in [("half", 0.6, 3), ("whole", 1.1, 4)] {
        terminal.write("loaded.urdf", &robot(mass));
        let motion = format!("--seconds 20 --rate 50 --case 2 --seed {seed}");
        terminal.done(&format!("simulate loaded.urdf -o {file}.csv {motion}"));
    }
    let loads = |with: &str| -> Vec<[f64; 2]> {
        let line = format!("fit log.csv --loaded half.csv --loaded whole.csv {with} -o both.json");
        let found = terminal.json(&line);
        let mass = |load: &serde_json::Value| {
            ["value", "std_error"].map(|key| load["mass"][key].as_f64().unwrap())
        };
        found["loads"].as_array().unwrap().iter().map(mass).collect()
    };

    let (given, learned) = (loads("--urdf arm.urdf"), loads(""));

    for (own, truth) in [&given, &learned].into_iter().flat_map(|all| all.iter().zip([0.5, 1.0])) {
        let off = (own[0] - truth).abs();
        assert!(off < 0.02 * truth && off < 3.0 * own[1], "{given:?} {learned:?}");
    }
    assert_eq!([given.len(), learned.len()], [2, 2]);
    terminal
        .refused("fit log.csv --loaded half.csv --library energy -o x.json", &["along a chain"]);
}

#[test]
fn a_load_that_hangs_on_another_link_is_said_to() {
    let terminal = fitted();
    let strapped = "<link name=\"weight\"><inertial><mass value=\"0.5\"/><inertia ixx=\"1e-4\" ixy=\"0\" \
                    ixz=\"0\" iyy=\"1e-4\" iyz=\"0\" izz=\"1e-4\"/></inertial></link><joint name=\"strap\" \
                    type=\"fixed\"><parent link=\"upper\"/><child link=\"weight\"/><origin \
                    xyz=\"0 0 0.4\"/></joint></robot>";
    terminal.write("strapped.urdf", &robot(0.1).replace("</robot>", strapped));
    terminal
        .done("simulate strapped.urdf -o strapped.csv --seconds 20 --rate 50 --case 2 --seed 3");

    let misplaced = terminal.json("payload arm.json strapped.csv");

    assert_eq!(misplaced["elsewhere"], "upper", "{misplaced}");
    // The link turns about a level axis alone, so that motion does not tell its mass from its lever.
    let placed = terminal.json("payload arm.json strapped.csv --link upper --center 0,0,0.4");
    assert!(placed["elsewhere"].is_null() && placed["link"] == "upper", "{placed}");
    let [value, error] = ["value", "std_error"].map(|key| placed["mass"][key].as_f64().unwrap());
    assert!((value - 0.5).abs() < 0.02 && (value - 0.5).abs() < 3.0 * error, "{placed}");
    terminal.misused("payload arm.json strapped.csv --link hand", &["hand", "shoulder, elbow"]);
    terminal.misused("payload arm.json strapped.csv --center 0,1", &["three numbers in m"]);
}

#[test]
fn a_urdf_that_is_not_of_the_arm_is_refused_with_what_to_do() {
    let terminal = fitted();
    terminal.done("simulate puma560-3 -o three.csv --seconds 10 --rate 50");

    terminal.refused("fit three.csv --urdf arm.urdf -o x.json", &["shoulder, elbow", "profile"]);
    for (line, word) in [
        ("fit log.csv --gravity 0,0,-1 -o x.json", "--urdf"),
        ("fit log.csv --urdf arm.urdf --gravity 0,0,0 -o x.json", "not all 0"),
        ("fit log.csv --urdf arm.urdf --gravity 0,x,0,-1 -o x.json", "expected three numbers"),
        ("fit log.csv --urdf arm.urdf --library product -o x.json", "--urdf is not used by"),
    ] {
        terminal.misused(line, &[word]);
    }
    terminal.done("fit three.csv -o library.json");
    terminal.refused("export library.json --to urdf -o x.urdf", &["along a chain"]);
    terminal.refused("payload library.json three.csv", &["fit the log along a chain"]);
    terminal.refused("evaluate three.csv library.json", &["is a log", "the model comes first"]);
    terminal.write("names.csv", "time,angle_a,effort_a\n0,1,2\n0.1,1,2\n");
    terminal.refused("fit names.csv -o x.json", &["no column t", "inspect suggests one"]);
}

#[test]
fn a_push_is_found_when_and_where_it_was() {
    let terminal = fitted();
    let motion = "--rate 100 --case 2";
    terminal.done(&format!("simulate arm.urdf -o free.csv --seconds 120 {motion} --seed 7"));
    terminal.done(&format!("simulate arm.urdf -o calm.csv --seconds 20 {motion} --seed 8"));
    // The second motor does less for a time, because somebody pushes.
    let push = |_: usize, tau: f64, row: &[f64]| {
        if (9.0..9.4).contains(&row[0]) { tau - 4.0 } else { tau }
    };
    let pushed = Table::of(&terminal, "calm.csv").with("tau2", push);
    terminal.write("push.csv", &pushed.text());

    let line = "contacts arm.json push.csv --free free.csv -o external.csv --figure external.svg";
    let found = terminal.json(line);

    let contacts = found["contacts"].as_array().unwrap();
    assert_eq!(contacts.len(), 1, "{found}");
    let number = |key: &str| contacts[0][key].as_f64().unwrap();
    assert!((9.0..9.05).contains(&number("begin")) && number("end") < 9.6, "{found}");
    assert_eq!(contacts[0]["joint"], "elbow");
    assert!((3.5..4.5).contains(&number("torque")), "{found}");
    let columns = "t,tau_external1,tau_external2,threshold1,threshold2\n";
    assert!(terminal.read("external.csv").starts_with(columns));
    assert!(terminal.read("external.svg").contains("threshold"));
    assert!(terminal.run(line).stdout.contains("\n1 contact found\n"));
    let calm = terminal.json("residuals arm.json calm.csv --free free.csv -o calm_external.csv");
    assert_eq!(calm["contacts"].as_array().unwrap().len(), 0, "{calm}");
    assert_eq!(calm["blind"].as_array().unwrap().len(), 0, "{calm}");

    // A blow of a row passes for a spike of the torque, where the log is filtered.
    let blow = |row: usize, tau: f64, _: &[f64]| if row == 950 { tau - 60.0 } else { tau };
    let bare = ["dq1", "dq2", "ddq1", "ddq2"];
    let blown = Table::of(&terminal, "calm.csv").without(&bare).with("tau2", blow);
    terminal.write("blown.csv", &blown.text());
    let line = "contacts arm.json blown.csv --free free.csv -o external.csv";
    let said = terminal.run(&format!("{line} --filter 20")).stderr;
    assert!(said.contains("replaced: 1; blows of a few rows are replaced alike"), "{said}");
    assert!(!terminal.run(&format!("{line} --filter none")).stderr.contains("blows"));

    // Beyond what the model was fitted on its torque, and with it an alarm, may be wrong.
    let calm = terminal.run("contacts arm.json calm.csv --free free.csv -o external.csv");
    let fast = Table::of(&terminal, "calm.csv").scaled(&["dq1"], 4.0);
    terminal.write("fast.csv", &fast.text());
    let fast = terminal.run("contacts arm.json fast.csv --free free.csv -o external.csv");
    assert!(fast.stderr.contains("shoulder leaves the range"), "{fast:?}");
    assert!(!calm.stderr.contains("leaves the range"), "{calm:?}");

    // Thresholds of motion in which somebody shakes the arm leave its joint blind.
    let shake = |_: usize, tau: f64, row: &[f64]| tau + 60.0 * (6.0 * row[0]).sin().signum();
    let shaken = Table::of(&terminal, "free.csv").with("tau2", shake);
    terminal.write("shaken.csv", &shaken.text());
    let line = "contacts arm.json push.csv --free shaken.csv -o external.csv";
    let deaf = terminal.json(line);
    assert_eq!(deaf["contacts"].as_array().unwrap().len(), 0, "{deaf}");
    assert!(deaf["blind"].as_array().unwrap().contains(&"elbow".into()), "{deaf}");
    assert!(terminal.run(line).stderr.contains("elbow"), "{deaf}");
}

#[test]
fn a_learned_model_is_the_arm_of_a_simulation() {
    let terminal = fitted();
    terminal.write(
        "friction.toml",
        "[shoulder]\ncoulomb = 3.0\nviscous = 2.0\n[elbow]\ncoulomb = 1.0\nviscous = 1.0\n",
    );
    terminal.done(
        "simulate arm.urdf -o rubs.csv --seconds 60 --rate 100 --case 2 --friction friction.toml",
    );
    terminal.run("fit rubs.csv --urdf arm.urdf -o rubs.json");

    terminal.done("simulate rubs.json -o twin.csv --seconds 20 --rate 100 --seed 4");

    // The torque is the model's own, friction included.
    assert_predicts(&terminal, "rubs.json twin.csv", 1e-6);
    terminal.done("simulate rubs.json -o noisy.csv --seconds 20 --rate 100 --case 2");
    terminal.misused("simulate rubs.json --friction friction.toml -o x.csv", &["has its own"]);
    // Controller 1 knows no friction but that of the first step; the twin has it, and shows it.
    let tracked =
        |model: &str| terminal.json(&format!("control {model} --arm rubs.json --seconds 2"));
    assert_ne!(tracked("arm.json"), tracked("rubs.json"));
    let line = "control arm.json --arm rubs.json --friction friction.toml";
    terminal.misused(line, &["has its own"]);
}
