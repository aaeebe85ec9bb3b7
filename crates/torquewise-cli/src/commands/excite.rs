//! `excite`: motions to record, from which a model can be identified.

mod figure;
mod summary;

use crate::files::{create_folder, read_arm};
use crate::progress::share_bar;
use crate::{Outcome, Result, check_files, staged, write_whole};
use clap::Args;
use std::path::{Path, PathBuf};
use torquewise::excite::{
    ExcitationPlan, JointValues, Torques, Wishes, excite, joint_trajectory, limits,
};
use torquewise::logs::TableWriter;
use torquewise::motion::Recording;
use torquewise::motion::stats::whole;
use torquewise::twin;

/// Plan the recordings from which a model can be reconstructed
///
/// Three recordings, each from home to home: poses held, constant speeds, accelerated motion. Each
/// is written as .csv and as ROS 2 JointTrajectory in .yaml. Limits are those of the URDF. Values
/// per joint are one for all, one for each, or some by name: 1.5 or 1,1,2 or elbow=1.5,wrist=2.
/// The arm's own shape and its surroundings are not known: try the motion in a simulator first.
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Built-in arm (see `torquewise simulate --list`), .urdf file, .toml file with a DH table, or
    /// model as .json file
    arm: String,
    /// Folder for the recordings and their figure
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Seconds at most of the recording of held poses
    #[arg(help_heading = "Recordings", long, value_name = "S", default_value_t = ExcitationPlan::default().seconds[0])]
    standstill: f64,
    /// Seconds at most of the recording at constant speeds
    #[arg(help_heading = "Recordings", long, value_name = "S", default_value_t = ExcitationPlan::default().seconds[1])]
    uniform: f64,
    /// Seconds at most of the recording of sines
    #[arg(help_heading = "Recordings", long, value_name = "S", default_value_t = ExcitationPlan::default().seconds[2])]
    variable: f64,
    /// Seconds a pose is held
    #[arg(help_heading = "Recordings", long, value_name = "S", default_value_t = ExcitationPlan::default().dwell)]
    dwell: f64,
    /// Pass the poses slowly in both directions instead: dry friction then has a sign
    #[arg(help_heading = "Recordings", long)]
    slow_sweeps: bool,
    /// Positions in rad to keep to, within the limits of the arm, as [JOINT=]FROM:TO,...
    #[arg(help_heading = "Limits", long, visible_alias = "position", value_name = "A:B")]
    #[arg(value_delimiter = ',', allow_hyphen_values = true, value_parser = range_of_joint)]
    range: Vec<(Option<String>, [f64; 2])>,
    /// Distance from each limit of the position, as a share of the way between them
    #[arg(help_heading = "Limits", long, value_name = "SHARE", default_value_t = Wishes::default().margin)]
    margin: f64,
    /// Limits of the speed in rad/s, as [JOINT=]V,... [default: of the URDF, else 2]
    #[arg(help_heading = "Limits", long, value_name = "V", value_delimiter = ',', value_parser = number_of_joint)]
    max_velocity: Vec<(Option<String>, f64)>,
    /// Accelerations in rad/s² to keep to, as [JOINT=]A,... [default: planned speed in 0.5 s]
    #[arg(help_heading = "Limits", long, value_name = "A", value_delimiter = ',', value_parser = number_of_joint)]
    max_acceleration: Vec<(Option<String>, f64)>,
    /// Largest torques of the drives in N·m, as [JOINT=]TAU,...: all is slowed until they are kept
    ///
    /// The torque is that of the masses of the arm, or of a model with its friction.
    #[arg(help_heading = "Limits", long, value_name = "TAU", value_delimiter = ',', value_parser = number_of_joint)]
    torque_limit: Vec<(Option<String>, f64)>,
    /// Speeds of the plan as a share of their limits
    #[arg(help_heading = "Limits", long, value_name = "SHARE", default_value_t = Wishes::default().speed_scale)]
    speed_scale: f64,
    /// Pose at both ends in rad, one number per joint [default: 0, or the middle of the range]
    #[arg(help_heading = "Limits", long, value_name = "Q")]
    #[arg(value_delimiter = ',', allow_hyphen_values = true)]
    home: Option<Vec<f64>>,
    /// Joints of a .urdf to hold at 0
    #[arg(long, value_name = "JOINT", value_delimiter = ',')]
    lock: Vec<String>,
    /// Joint angles in a term that the motion is to tell apart [default: 2, 1 for many joints]
    #[arg(help_heading = "Search", long, value_name = "K", value_parser = clap::value_parser!(u8).range(1..=16))]
    interaction: Option<u8>,
    /// Poses, sweeps and sines to choose from, each time; more take longer
    #[arg(help_heading = "Search", long, value_name = "N", default_value_t = ExcitationPlan::default().tries)]
    tries: usize,
    /// Rows per second of the .csv files
    #[arg(help_heading = "Recordings", long, value_name = "HZ", default_value_t = ExcitationPlan::default().rate)]
    rate: f64,
    /// Points per second of the .yaml files at least; splines between them make the same motion
    #[arg(help_heading = "Recordings", long, value_name = "HZ", default_value_t = 20.0)]
    ros_rate: f64,
    /// Random seed
    #[arg(help_heading = "Search", long, default_value_t = 0)]
    seed: u64,
}

struct Files {
    /// .csv and .yaml of each recording.
    recordings: [[PathBuf; 2]; 3],
    figure: PathBuf,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let (arm, twin) = read_arm(&arguments.arm, &arguments.lock, None)?;
    let wishes = Wishes {
        range: JointValues(arguments.range.clone()),
        velocity: JointValues(arguments.max_velocity.clone()),
        acceleration: JointValues(arguments.max_acceleration.clone()),
        speed_scale: arguments.speed_scale,
        margin: arguments.margin,
    };
    let limits = limits(&arm, &wishes)?;
    let most = JointValues(arguments.torque_limit.clone());
    let torques = match twin {
        Some(model) => twin::torques(&model, &most)?,
        None => Torques::of_arm(&arm, &most)?,
    };
    let files = Files::within(&arguments.output);
    create_folder(&arguments.output)?;
    let inputs = [PathBuf::from(&arguments.arm)];
    let outputs = files.recordings.iter().flatten().chain([&files.figure]);
    check_files(&inputs, outputs.map(|file| (file.as_path(), &[][..])))?;
    let plan = ExcitationPlan {
        seconds: [arguments.standstill, arguments.uniform, arguments.variable],
        dwell: arguments.dwell,
        slow_sweeps: arguments.slow_sweeps,
        rate: arguments.rate,
        home: arguments.home.clone(),
        interaction: arguments.interaction.map(usize::from),
        tries: arguments.tries,
        seed: arguments.seed,
    };
    let planned = {
        let bar = share_bar();
        bar.set_length(1000);
        excite(&limits, torques.as_ref(), &plan, &mut |share, doing| {
            bar.set_position(whole(1000.0 * share) as u64);
            bar.set_message(doing);
        })?
    };
    let texts = planned.recordings.each_ref().map(|r| joint_trajectory(r, arguments.ros_rate));
    let figure = figure::figure(&arguments.arm, &limits, &planned)?;
    for ((recording, [log, trajectory]), text) in
        planned.recordings.iter().zip(&files.recordings).zip(texts)
    {
        let text = text?;
        let mut writer = TableWriter::log(&staged(log)?, recording.joints(), false)?;
        recording.read(&mut |_, block| Ok(writer.append_motion(block)?))?;
        writer.finish()?;
        write_whole(trajectory, &text)?;
    }
    write_whole(&files.figure, &figure)?;
    Ok(summary::outcome(arguments, (&limits, torques.as_ref()), &planned, &files))
}

impl Files {
    fn within(folder: &Path) -> Self {
        let of = |name: &str| ["csv", "yaml"].map(|ending| folder.join(format!("{name}.{ending}")));
        let recordings = ["standstill", "uniform", "variable"].map(of);
        Self { recordings, figure: folder.join("excite.svg") }
    }
}

/// `[JOINT=]VALUE` as name and text of the value.
fn named(text: &str) -> (Option<String>, &str) {
    let named = text.rsplit_once('=');
    named.map_or((None, text), |(joint, value)| (Some(joint.trim().to_owned()), value))
}

fn number_of_joint(text: &str) -> Result<(Option<String>, f64), String> {
    let (joint, value) = named(text);
    let number = value.trim().parse();
    number.map(|number| (joint, number)).map_err(|_| "expected 1.5 or elbow=1.5".to_owned())
}

fn range_of_joint(text: &str) -> Result<(Option<String>, [f64; 2]), String> {
    let (joint, value) = named(text);
    let numbers = value.split_once(':').map(|(from, to)| (from.trim().parse(), to.trim().parse()));
    match numbers {
        Some((Ok(from), Ok(to))) => Ok((joint, [from, to])),
        _ => Err("expected -1.5:1.5 or elbow=-1.5:1.5".to_owned()),
    }
}
