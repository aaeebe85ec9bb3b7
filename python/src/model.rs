//! The learned equations of motion.

use crate::arrays::{Rows, array, is_one_state, motion, rows_of, same_rows};
use crate::errors::{choice, raised, value_error, wrong};
use crate::friction_state::FrictionState;
use crate::log::Log;
use crate::states::{Answer, by_rows};
use crate::work::work;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict, PyType};
use std::path::PathBuf;
use std::sync::Arc;
use torquewise::evaluate::{evaluate_prepared, prepare, rollouts};
use torquewise::export::Precision;
use torquewise::exported::{ExportOptions, Target, export, function_name};
use torquewise::model::selection::Selection;
use torquewise::model::{self, print};
use torquewise::motion::Motion;
use torquewise::physics::PhysicsCheck;
use torquewise::predict::{Interval, MotionRange};
use torquewise::{Torque, describe};

/// Equations of motion of an arm: tau = M(q) ddq + C(q, dq) dq + G(q) + F(q, dq).
///
/// q [rad], dq [rad/s], ddq [rad/s²] and tau [N·m] are one state of n numbers, or m states in rows
/// (m×n); results have as many rows. Made by :func:`torquewise.fit` and :meth:`Model.load`.
#[pyclass(module = "torquewise", frozen, subclass, eq)]
#[derive(Clone, Debug)]
pub(crate) struct Model {
    pub(crate) model: Arc<model::Model>,
    pub(crate) torque: Arc<Torque>,
}

impl PartialEq for Model {
    fn eq(&self, other: &Self) -> bool {
        self.model == other.model
    }
}

impl Model {
    pub(crate) fn new(model: model::Model) -> Self {
        let torque = Torque::new(&model);
        Self { model: Arc::new(model), torque: Arc::new(torque) }
    }

    pub(crate) fn n(&self) -> usize {
        self.model.n_joints()
    }

    fn motion(&self, [q, dq, ddq]: [&Rows<'_>; 3]) -> PyResult<Motion> {
        let signals = same_rows([("q", q), ("dq", dq), ("ddq", ddq)], self.n())?;
        let t = (0..signals[0].nrows()).map(|row| row as f64).collect();
        motion(&self.model.joints, t, signals, None)
    }
}

#[pymethods]
impl Model {
    /// The same model.
    #[new]
    fn of(model: &Self) -> Self {
        model.clone()
    }

    /// Reads a model file.
    #[classmethod]
    fn load(_class: &Bound<'_, PyType>, path: PathBuf) -> PyResult<Self> {
        model::Model::load(path).map(Self::new).map_err(raised)
    }

    /// A model from the text of a model file.
    #[classmethod]
    fn from_json(_class: &Bound<'_, PyType>, text: &str) -> PyResult<Self> {
        model::from_json(text).map(Self::new).map_err(raised)
    }

    /// Writes a model file, whole or not at all.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        self.model.save(path).map_err(raised)
    }

    /// The text of a model file.
    fn to_json(&self) -> PyResult<String> {
        model::to_json(&self.model).map_err(raised)
    }

    /// Joint names, base to tip.
    #[getter]
    fn joints(&self) -> Vec<String> {
        self.model.joints.clone()
    }

    /// Number of coefficients.
    #[getter]
    fn complexity(&self) -> usize {
        self.model.n_coefficients()
    }

    /// Whether friction remembers the path: then rows are followed as one trajectory.
    #[getter]
    fn has_memory(&self) -> bool {
        !self.model.travels().is_empty()
    }

    /// tau [N·m] of states.
    ///
    /// Rows are a trajectory in the order of time if friction remembers the path, which is told by
    /// `has_memory`; with `follow=False` each row is on its own.
    #[pyo3(signature = (q, dq, ddq, *, follow=true))]
    fn torque<'py>(
        &self,
        py: Python<'py>,
        q: Rows<'py>,
        dq: Rows<'py>,
        ddq: Rows<'py>,
        follow: bool,
    ) -> Answer<'py> {
        let inputs = [&q, &dq, &ddq];
        if !follow || !self.has_memory() || is_one_state(inputs) {
            let named = [("q", &q), ("dq", &dq), ("ddq", &ddq)];
            return self.each(py, named, 1, |torque, [q, dq, ddq]| torque.at(q, dq, ddq));
        }
        let motion = self.motion(inputs)?;
        let tau = py.detach(|| self.torque.over(&motion)).map_err(raised)?;
        Ok(array(py, tau.as_ref()).into_any())
    }

    /// M(q) [kg·m²]: n×n, or m×n×n of several states.
    fn mass_matrix<'py>(&self, py: Python<'py>, q: Rows<'py>) -> Answer<'py> {
        self.each(py, [("q", &q)], 2, |torque, [q]| torque.mass_matrix(q).map(by_rows))
    }

    /// C(q, dq) [N·m·s] by Christoffel symbols: n×n, or m×n×n of several states.
    fn coriolis_matrix<'py>(&self, py: Python<'py>, q: Rows<'py>, dq: Rows<'py>) -> Answer<'py> {
        let inputs = [("q", &q), ("dq", &dq)];
        self.each(py, inputs, 2, |torque, [q, dq]| torque.coriolis_matrix(q, dq).map(by_rows))
    }

    /// G(q) [N·m].
    fn gravity<'py>(&self, py: Python<'py>, q: Rows<'py>) -> Answer<'py> {
        self.each(py, [("q", &q)], 1, |torque, [q]| torque.gravity(q))
    }

    /// C(q, dq) dq [N·m].
    fn coriolis<'py>(&self, py: Python<'py>, q: Rows<'py>, dq: Rows<'py>) -> Answer<'py> {
        self.each(py, [("q", &q), ("dq", &dq)], 1, |torque, [q, dq]| torque.coriolis(q, dq))
    }

    /// F(q, dq) [N·m], as after a long way in the direction of dq; :meth:`state` follows a path.
    fn friction<'py>(&self, py: Python<'py>, q: Rows<'py>, dq: Rows<'py>) -> Answer<'py> {
        self.each(py, [("q", &q), ("dq", &dq)], 1, |torque, [q, dq]| torque.friction(q, dq))
    }

    /// ddq [rad/s²] of an arm whose motors give tau.
    fn forward_dynamics<'py>(
        &self,
        py: Python<'py>,
        q: Rows<'py>,
        dq: Rows<'py>,
        tau: Rows<'py>,
    ) -> Answer<'py> {
        let inputs = [("q", &q), ("dq", &dq), ("tau", &tau)];
        self.each(py, inputs, 1, Torque::forward_dynamics)
    }

    /// The torque of a trajectory in parts: a dict of inertia, coriolis, gravity and friction, each of
    /// the shape of :meth:`torque` [N·m].
    fn parts<'py>(
        &self,
        py: Python<'py>,
        q: Rows<'py>,
        dq: Rows<'py>,
        ddq: Rows<'py>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let inputs = [&q, &dq, &ddq];
        let motion = self.motion(inputs)?;
        let parts = py.detach(|| self.torque.parts(&motion)).map_err(raised)?;
        let all = [
            ("inertia", parts.inertia),
            ("coriolis", parts.coriolis),
            ("gravity", parts.gravity),
            ("friction", parts.friction),
        ];
        all.map(|(name, values)| (name, rows_of(py, values.as_ref(), inputs))).into_py_dict(py)
    }

    /// Bounds of the torque of a trajectory, low and high, each of the shape of :meth:`torque` [N·m]:
    /// `percent` of measured torques should lie between them. For models of a chain.
    #[pyo3(signature = (q, dq, ddq, percent=95.0))]
    fn interval<'py>(
        &self,
        py: Python<'py>,
        q: Rows<'py>,
        dq: Rows<'py>,
        ddq: Rows<'py>,
        percent: f64,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        if !(percent > 0.0 && percent < 100.0) {
            return wrong("percent is above 0 and below 100");
        }
        let inputs = [&q, &dq, &ddq];
        let motion = self.motion(inputs)?;
        let bounds = py.detach(|| {
            let motion = self.torque.path().follow(0, &motion).into_owned();
            let interval = Interval::new(&self.model, &motion, percent)?;
            let total = self.torque.over(&motion)?;
            Ok::<_, torquewise::Error>(interval.bounds(&motion, &total)?)
        });
        let [low, high] = bounds.map_err(raised)?.map(|own| rows_of(py, own.as_ref(), inputs));
        Ok((low, high))
    }

    /// Where a motion leaves the range of the log that the model was learned from: sentences.
    fn range_warnings(&self, q: Rows<'_>, dq: Rows<'_>, ddq: Rows<'_>) -> PyResult<Vec<String>> {
        let mut range = MotionRange::new(self.n());
        range.add(&self.motion([&q, &dq, &ddq])?);
        Ok(range.warnings(&self.model))
    }

    /// Whether a state leaves that range with any joint; of several, a bool for each.
    fn outside_range<'py>(
        &self,
        py: Python<'py>,
        q: Rows<'py>,
        dq: Rows<'py>,
        ddq: Rows<'py>,
    ) -> Answer<'py> {
        let inputs = [&q, &dq, &ddq];
        let found = MotionRange::outside(&self.model, &self.motion(inputs)?);
        Ok(match found[..] {
            [one] if is_one_state(inputs) => one.into_pyobject(py)?.to_owned().into_any(),
            _ => PyArray1::from_vec(py, found).into_any(),
        })
    }

    /// What friction remembers, to be fed every sample of q.
    fn state(own: PyRef<'_, Self>) -> FrictionState {
        let (n, torque, path) = (own.n(), Arc::clone(&own.torque), own.torque.path());
        FrictionState { model: own.into(), n, torque, path }
    }

    /// Errors on a log, joint by joint: JSON.
    fn _evaluate(
        &self,
        py: Python<'_>,
        log: &Log,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<(String, Vec<String>)> {
        let (model, log) = (Arc::clone(&self.model), log.log.clone());
        let (found, of_log) = work(py, progress, move |observer| {
            let log = prepare(&model, &log)?;
            Ok((evaluate_prepared(&model, &log, observer)?, log.warnings()))
        })?;
        let notes = found.notes.iter().chain(&found.warnings).cloned().chain(of_log).collect();
        Ok((json(&found)?, notes))
    }

    /// How far simulated windows of a log drift from it after times [s], ascending: JSON.
    fn _rollout(
        &self,
        py: Python<'_>,
        log: &Log,
        horizons: Vec<f64>,
        samples: Option<(usize, u64)>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<String> {
        if horizons.is_empty() || !horizons.iter().all(|own| *own > 0.0 && own.is_finite()) {
            return wrong("horizons: expected seconds above 0");
        }
        if samples.is_some_and(|(count, _)| !(2..=10_000).contains(&count)) {
            return wrong("samples: expected 2 to 10000");
        }
        let (model, log) = (Arc::clone(&self.model), log.log.clone());
        json(&work(py, progress, move |_| {
            rollouts(&model, &prepare(&model, &log)?, &horizons, samples)
        })?)
    }

    /// The model after an earlier step of the reconstruction, 1 for gravity alone.
    fn after_step(&self, step: usize) -> PyResult<Self> {
        self.model.after_step(step).map(Self::new).map_err(raised)
    }

    /// The model with friction that reverses over another half width [rad/s]: a desired velocity has
    /// no noise, and 0.002 tracks better than what a learner smooths.
    fn with_reversal(&self, width: f64) -> PyResult<Self> {
        check_width("width", width)?;
        Ok(Self::new(self.model.with_reversal(width)))
    }

    /// The equations as text; `joint` counts from 0.
    #[pyo3(signature = (joint=None, top=None, all=false))]
    fn _text(&self, joint: Option<usize>, top: Option<usize>, all: bool) -> PyResult<String> {
        Ok(print::text(&self.model, &Selection { all, ..self.selection(joint, top)? }))
    }

    /// The same in LaTeX.
    #[pyo3(signature = (joint=None, top=None))]
    fn _latex(&self, joint: Option<usize>, top: Option<usize>) -> PyResult<String> {
        Ok(print::latex(&self.model, &self.selection(joint, top)?))
    }

    /// Terms, axes, friction and choices: JSON.
    fn _description(&self) -> PyResult<String> {
        let found = describe::description(&self.model, &Selection::default());
        Ok(found.map_err(raised)?.to_string())
    }

    /// Whether the model is physics, at random states: JSON, and a warning if it is not.
    fn _check(&self, py: Python<'_>, states: usize) -> PyResult<(String, Option<String>)> {
        let model = Arc::clone(&self.model);
        let found = work(py, None, move |_| Ok(PhysicsCheck::of(&model, states)?))?;
        Ok((json(&found)?, found.warning()))
    }

    /// Code, an FMU, a ROS 2 package or a robot file, as (path, bytes) each.
    #[pyo3(signature = (to, name, *, precision="double", reversal=None, onto=None, lock=vec![],
                        binary=true, force=false, samples=None, seed=0))]
    #[expect(clippy::too_many_arguments, clippy::type_complexity, reason = "keywords of Python")]
    fn _export(
        &self,
        py: Python<'_>,
        to: &str,
        name: &str,
        precision: &str,
        reversal: Option<f64>,
        onto: Option<&str>,
        lock: Vec<String>,
        binary: bool,
        force: bool,
        samples: Option<usize>,
        seed: u64,
    ) -> PyResult<(Vec<(String, Vec<u8>)>, Vec<String>, Vec<String>)> {
        let to = choice("to", to, &Target::NAMED.map(|(word, _, target)| (word, target)))?;
        let words = [("double", Precision::Double), ("float", Precision::Single)];
        let precision = choice("precision", precision, &words)?;
        reversal.map_or(Ok(()), |width| check_width("reversal", width))?;
        let (name, onto) = (function_name(name), onto.map(str::to_owned));
        let (model, samples) = (Arc::clone(&self.model), samples.map(|count| (count, seed)));
        let found = work(py, None, move |_| {
            let (name, onto) = (&name, onto.as_deref().map(|text| (text, &lock[..])));
            let work = None;
            let options =
                ExportOptions { name, precision, reversal, onto, binary, force, samples, work };
            export(&model, to, &options)
        })?;
        Ok((found.files, found.left_out, found.flaws))
    }

    /// `good`, `usable` or `unusable`, as its fit said; None where no fit did.
    #[getter]
    fn verdict(&self) -> Option<String> {
        self.model.training.verdict.as_ref().map(|own| own.grade.to_string())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        let class = py.import("torquewise")?.getattr("Model")?.getattr("from_json")?;
        Ok((class, (self.to_json()?,)))
    }

    fn __repr__(&self) -> String {
        format!(
            "Model({} joints: {}; {} coefficients{})",
            self.n(),
            self.model.joints.join(", "),
            self.model.n_coefficients(),
            self.verdict().map(|grade| format!("; {grade}")).unwrap_or_default()
        )
    }
}

impl Model {
    fn selection(&self, joint: Option<usize>, top: Option<usize>) -> PyResult<Selection> {
        if joint.is_some_and(|joint| joint >= self.n()) {
            return wrong(format!("joint: the model has {} of them, counted from 0", self.n()));
        }
        Ok(Selection { joint, top, ..Selection::default() })
    }
}

fn check_width(name: &str, width: f64) -> PyResult<()> {
    if width.is_finite() && width >= 0.0 {
        return Ok(());
    }
    wrong(format!("{name} is 0 or more radians per second"))
}

pub(crate) fn json(found: &impl serde::Serialize) -> PyResult<String> {
    serde_json::to_string(found).map_err(value_error)
}
