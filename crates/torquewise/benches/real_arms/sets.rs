//! The sets: where they are, how they are split, and the kinematics the regressor is given.

use std::error::Error;
use std::path::Path;
use torquewise::dynamics::Arm;

/// How rows are split into training and test.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Split {
    /// The first 70 % of the time for training.
    Time,
    /// Of each three blocks of this many seconds, the third for testing.
    Blocks(f64),
}

/// A public log of a real arm.
#[derive(Clone, Copy)]
pub(crate) struct Set {
    pub(crate) name: &'static str,
    pub(crate) log: &'static str,
    pub(crate) profile: &'static str,
    pub(crate) split: Split,
    /// How much worse than the regressor a joint may be.
    pub(crate) limit: f64,
    /// Joints that count; the torque of the others is mostly quantisation.
    pub(crate) counted: usize,
    /// Pairs of joints that turn a shaft together, known to the regressor.
    pub(crate) shafts: &'static [[usize; 2]],
    /// Joints that a spring is known to balance; ours is told.
    pub(crate) counterbalanced: &'static [&'static str],
    kinematics: Kinematics,
}

#[derive(Clone, Copy)]
enum Kinematics {
    /// A URDF beside the data, and the joints that move.
    Urdf(&'static str, &'static [&'static str]),
    /// A table of Denavit–Hartenberg rows: a, alpha, d, offset; then roll of the base.
    Dh(&'static [[f64; 4]], f64),
}

use std::f64::consts::{FRAC_PI_2, PI};

const KR300: [[f64; 4]; 6] = [
    [0.35, FRAC_PI_2, -0.675, 0.0],
    [1.15, 0.0, -0.189, 0.0],
    [0.041, -FRAC_PI_2, 0.189, FRAC_PI_2],
    [0.0, FRAC_PI_2, -1.0, 0.0],
    [0.0, -FRAC_PI_2, 0.0, 0.0],
    [0.0, PI, -0.24, 0.0],
];

/// Hanging down at q = 0: x of the links points down once the base is rolled by a quarter turn.
const PENDULUM: [[f64; 4]; 2] = [[0.3, 0.0, 0.0, -FRAC_PI_2], [0.2, 0.0, 0.0, 0.0]];

/// Those of the University of Salerno, then the others.
pub(crate) fn all() -> Vec<Set> {
    light().into_iter().chain(heavy()).collect()
}

const PLAIN: Set = Set {
    name: "",
    log: "",
    profile: "",
    split: Split::Time,
    limit: 1.25,
    counted: 6,
    shafts: &[],
    counterbalanced: &[],
    kinematics: Kinematics::Dh(&[], 0.0),
};

fn light() -> Vec<Set> {
    let urdf = Kinematics::Urdf;
    let ur10 = "ur10_panda_unisa/ur10_from_example-robot-data.urdf";
    vec![
        Set {
            name: "UR10",
            log: "ur10_panda_unisa/ur10_exciting_trajectory.db3",
            profile: "ur10.toml",
            kinematics: urdf(ur10, &["shoulder", "elbow", "wrist"]),
            ..PLAIN
        },
        Set {
            name: "Panda",
            log: "ur10_panda_unisa/panda_exciting_trajectory.db3",
            profile: "panda.toml",
            split: Split::Blocks(2.0),
            limit: 1.5,
            counted: 7,
            kinematics: urdf("../robots/panda.urdf", &["panda_joint"]),
            ..PLAIN
        },
        Set {
            name: "DFKI double pendulum",
            log: "dfki_double_pendulum/A0_20220812/20220812-061157-PM_measured.csv",
            profile: "dfki_double_pendulum.toml",
            limit: 1.0,
            counted: 2,
            kinematics: Kinematics::Dh(&PENDULUM, FRAC_PI_2),
            ..PLAIN
        },
    ]
}

fn heavy() -> Vec<Set> {
    let urdf = Kinematics::Urdf;
    vec![
        Set {
            name: "Stäubli TX40",
            log: "staubli_tx40_figaroh/pos_read_data.csv",
            profile: "staubli_tx40.toml",
            split: Split::Blocks(0.5),
            shafts: &[[4, 5]],
            kinematics: urdf("staubli_tx40_figaroh/tx40_mdh_modified.urdf", &["joint"]),
            ..PLAIN
        },
        Set {
            name: "KUKA KR300",
            log: "kuka_kr300_weigand/A/data.mat",
            profile: "kuka_kr300.toml",
            // Hydraulic, as its maker says.
            counterbalanced: &["axis_2"],
            kinematics: Kinematics::Dh(&KR300, PI),
            ..PLAIN
        },
        Set {
            name: "TIAGo arm",
            log: "tiago_arm_figaroh/tiago_position.csv",
            profile: "tiago_arm.toml",
            counted: 4,
            kinematics: urdf("tiago_arm_figaroh/tiago_48_schunk.urdf", &["arm_"]),
            ..PLAIN
        },
    ]
}

impl Set {
    /// The arm, whose kinematics the regressor is given.
    pub(crate) fn arm(&self, data: &Path) -> Result<Arm, Box<dyn Error + Send + Sync>> {
        match self.kinematics {
            Kinematics::Urdf(file, moving) => {
                let text = std::fs::read_to_string(data.join(file))?;
                let robot = roxmltree::Document::parse(&text)?;
                let locked: Vec<String> = (robot.root_element().children())
                    .filter(|node| node.has_tag_name("joint"))
                    .filter(|joint| joint.attribute("type") != Some("fixed"))
                    .filter_map(|joint| joint.attribute("name"))
                    .filter(|name| {
                        let moves = moving.iter().any(|part| name.starts_with(part));
                        !moves || name.contains("finger_joint")
                    })
                    .map(str::to_owned)
                    .collect();
                // Kinematics alone are used: masses that no body has are no obstacle.
                let mut bare = text.clone();
                let masses = robot.descendants().filter(|node| node.has_tag_name("inertial"));
                let masses: Vec<_> = masses.map(|inertial| inertial.range()).collect();
                masses.into_iter().rev().for_each(|range| bare.replace_range(range, ""));
                Ok(Arm::from_urdf(&bare, &locked)?)
            }
            Kinematics::Dh(rows, roll) => {
                let joints: Vec<String> = rows
                    .iter()
                    .enumerate()
                    .map(|(joint, [a, alpha, d, offset])| {
                        format!(
                            "[[joints]]\nname = \"joint{joint}\"\na = {a:?}\nalpha = {alpha:?}\n\
                             d = {d:?}\noffset = {offset:?}\nmass = 1.0\ncom = [0.0, 0.0, 0.0]\n\
                             inertia = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]\n"
                        )
                    })
                    .collect();
                let head = format!("name = \"peer\"\nbase_rpy = [{roll:?}, 0.0, 0.0]\n");
                Ok(Arm::from_dh_toml(&(head + &joints.concat()))?)
            }
        }
    }
}
