//! Friction that remembers the path, in a closed loop: bristles of the arm, elements of a model.
use torquewise_model::{Form, FrictionLaw, FrictionTerm, Model, Torque, Weighted};
use torquewise_motion::Path;
use torquewise_sim::control::{
    Gains, Knowledge, Law, Periodic, Plant, mean_inertia, periodic, track,
};
use torquewise_sim::{Arm, Friction, SimError};

/// Dry friction of each joint \[N·m\], the same at rest and in motion.
const DRY: [f64; 3] = [8.0, 10.0, 4.0];
/// Of the bristles \[N·m/rad\].
const STIFFNESS: f64 = 200.0;

fn plant() -> Plant {
    let arm = Arm::builtin("puma560-3").unwrap();
    let row = |(name, dry): (&String, f64)| {
        format!("[{name}]\ncoulomb = {dry}\nstiffness = {STIFFNESS}\ndamping = 0.0\n")
    };
    let text: String = arm.joints().iter().zip(DRY).map(row).collect();
    let friction = Friction::from_toml(&text, arm.joints()).unwrap();
    Plant { friction, ..Plant::ideal(arm) }
}

/// The arm itself, and its friction by one law for each joint.
struct Known {
    plant: Plant,
    friction: Torque,
}

impl Known {
    fn by(law: impl Fn(f64) -> FrictionLaw) -> Self {
        let weighted = |(joint, &dry): (usize, &f64)| {
            Weighted::new(FrictionTerm::of_joint(DRY.len(), joint, law(dry)), dry)
        };
        let plant = plant();
        let friction = DRY.iter().enumerate().map(weighted).collect();
        let (joints, form) = (plant.arm.joints().to_vec(), Form::Torque(vec![vec![]; DRY.len()]));
        let model = Model { joints, form, friction, ..Model::default() };
        Self { friction: Torque::new(&model), plant }
    }

    /// Largest tracking error of each joint once the motion is periodic \[rad\].
    fn peak_error(&self) -> Vec<f64> {
        let wanted = periodic(&self.plant.arm, &Periodic::default()).unwrap();
        let inertia = mean_inertia(&self.plant, &wanted).unwrap();
        let gains = Gains::critically_damped(15.0, &inertia);
        track(&self.plant, Law::Controller2, self, &gains, &wanted).unwrap().peak_error(8.0)
    }
}

impl Knowledge for Known {
    fn n_joints(&self) -> usize {
        DRY.len()
    }

    fn rigid(&self, q: &[f64], dq: &[f64], ddq: &[f64]) -> Result<Vec<f64>, SimError> {
        self.plant.rigid(q, dq, ddq)
    }

    fn path(&self) -> Path {
        self.friction.path()
    }

    fn friction(&self, path: &Path, dq: &[f64]) -> Result<Vec<f64>, SimError> {
        Ok(self.friction.friction_after(path, dq)?)
    }

    fn slow(&self, path: &Path, dq: &[f64]) -> Result<Vec<f64>, SimError> {
        self.friction(path, dq)
    }

    fn inertia(&self, q: &[f64]) -> Result<Vec<f64>, SimError> {
        self.plant.inertia(q)
    }
}

#[test]
fn memory_of_the_path_takes_out_the_error_of_reversals() {
    // Bristles that slip at f_c bend over f_c / σ₀: one element of Dahl.
    let with = Known::by(|dry| FrictionLaw::Dahl { travel: dry / STIFFNESS }).peak_error();
    let without = Known::by(|_| FrictionLaw::Coulomb { width: 0.002 }).peak_error();

    for (joint, (with, without)) in with.iter().zip(&without).enumerate() {
        assert!(*with < 0.2 * without, "joint {joint}: {with} rad, without {without} rad");
    }
}
