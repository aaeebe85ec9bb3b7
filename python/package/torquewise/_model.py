"""The learned equations of motion."""

from __future__ import annotations

import json
import math
import os
import types
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._log import read_log
from ._options import ExportOptions, LogOptions, Progress, RobotOptions, explicit
from ._options import Path as _Path
from ._progress import shown
from ._rollout import Rollout

if TYPE_CHECKING:
    from ._fit import Evaluation
    from ._options import Unpack

_ENDINGS = {
    ".c": "c",
    ".h": "c",
    ".rs": "rust",
    ".py": "python",
    ".tex": "latex",
    ".fmu": "fmu",
    ".urdf": "urdf",
    ".xml": "mjcf",
    ".mjcf": "mjcf",
}


class Model(_core.Model):
    """Equations of motion of an arm: tau = M(q) ddq + C(q, dq) dq + G(q) + F(q, dq).

    q [rad], dq [rad/s], ddq [rad/s²] and tau [N·m] are one state of n numbers, or m states in rows
    (m×n); results have as many rows. One state beside rows stands for each of them. Models come from :func:`torquewise.fit` and :meth:`load`, can be
    pickled, and are equal if all their numbers are.
    """

    @classmethod
    def load(cls, path: _Path) -> Model:
        """Reads a model file."""
        return cls(_core.Model.load(os.fspath(path)))

    @classmethod
    def from_json(cls, text: str) -> Model:
        """A model from the text of a model file."""
        return cls(_core.Model.from_json(text))

    def after_step(self, step: int) -> Model:
        """The model after an earlier step of the reconstruction: 1 gravity, 2 Coriolis too, 3 all."""
        return type(self)(super().after_step(step))

    def with_reversal(self, width: float) -> Model:
        """The model with friction that reverses over another half width [rad/s].

        A learner smooths reversals for the noise of measured velocities. A desired velocity has none:
        0.002 tracks better.
        """
        return type(self)(super().with_reversal(width))

    # What was learned.

    def describe(self) -> dict[str, Any]:
        """Axes, terms by joint, energies, friction, choices: a dict, as ``torquewise show --json``."""
        found: dict[str, Any] = json.loads(self._description())
        return found

    def equations(self, precision: int = 3) -> list[str]:
        """The torque of each joint as text, such as ``1.2 ddq1 + 0.3 cos(q1)``."""
        sums = []
        for joint in self.describe()["joints"]:
            terms = [f"{own['coefficient']:.{precision}g} {own['term']}" for own in joint["terms"]]
            sums.append(" + ".join(terms).replace("+ -", "- ") if terms else "0")
        return sums

    def print(self, precision: int = 3) -> None:
        """Prints the torque of each joint."""
        for number, (name, own) in enumerate(zip(self.joints, self.equations(precision)), 1):
            print(f"tau{number} = {own}   [{name}]")

    def get_feature_names(self) -> list[str]:
        """Names of all terms that act on some joint."""
        names: dict[str, None] = {}
        for joint in self.describe()["joints"]:
            names.update(dict.fromkeys(own["term"] for own in joint["terms"]))
        return list(names)

    def coefficients(self) -> NDArray[np.float64]:
        """Coefficients of those terms, n joints × terms."""
        place = {name: k for k, name in enumerate(self.get_feature_names())}
        found = np.zeros((len(self.joints), len(place)))
        for row, joint in zip(found, self.describe()["joints"]):
            for own in joint["terms"]:
                row[place[own["term"]]] += own["coefficient"]
        return found

    def check(self, states: int = 10_000) -> dict[str, Any]:
        """Whether the model is physics at random states: a dict; ``passed`` says it in a word."""
        found, warning = self._check(states)
        return {**json.loads(found), "warning": warning}

    def __str__(self) -> str:
        return self._text()

    def _repr_latex_(self) -> str | None:
        return "$$\n" + self._latex() + "\n$$" if len(self.joints) <= 3 else None

    def _repr_html_(self) -> str:
        import html

        return f"<pre>{html.escape(self._text(top=12))}</pre>"

    # How good it is.

    @explicit(LogOptions)
    def evaluate(
        self, log: Any = None, *, progress: Progress = None, **options: Unpack[LogOptions]
    ) -> Evaluation:
        """How well it predicts the torque of a log: :class:`Evaluation`.

        The log is filtered as that of the model was. `log` and options are those of
        :func:`read_log`.
        """
        from ._fit import Evaluation

        log = read_log(log, **options)
        with shown(progress) as told:
            return Evaluation._of(*self._evaluate(log, told))

    @explicit(LogOptions)
    def score(self, log: Any = None, **options: Unpack[LogOptions]) -> float:
        """R² of the torque of a log, mean of the joints whose torque changes."""
        return float(np.nanmean(self.evaluate(log, progress=False, **options).r2))

    @explicit(LogOptions)
    def rollout(
        self,
        log: Any = None,
        *,
        horizons: float | Sequence[float] = (0.2, 0.5, 1.0),
        samples: int | None = None,
        seed: int = 0,
        progress: Progress = None,
        **options: Unpack[LogOptions],
    ) -> Rollout:
        """How far windows of a log drift that are simulated from their measured state.

        The arm moves by the measured torque; `horizons` are times since the measured state [s].
        With `samples`, so many arms of :meth:`samples` are simulated too, and `covered` says how often
        the measured arm ends in their band.
        """
        log = read_log(log, **options)
        times = sorted(np.atleast_1d(np.asarray(horizons, dtype=float)).tolist())
        with shown(progress) as told:
            drawn = None if samples is None else (samples, seed)
            found = json.loads(self._rollout(log, times, drawn, told))

        if not found:
            raise _core.LogError(
                f"no stretch of the log is as long as {times[0]} s: give shorter horizons"
            )

        def of(key: str) -> NDArray[np.float64]:
            # No number is one that ran away.
            rows = np.array([own[key] for own in found], dtype=float)
            return np.where(np.isnan(rows), np.inf, rows)

        return Rollout(
            joints=self.joints,
            horizons=of("horizon_s"),
            drift=of("rms_drift_rad"),
            hold=of("hold_rms_rad"),
            windows=np.array([own["windows"] for own in found]),
            ran_away=np.array([own["ran_away"] for own in found]),
            covered=None if samples is None else of("covered"),
        )

    @explicit(LogOptions)
    def predict(
        self,
        log: Any = None,
        *,
        parts: bool = False,
        interval: float | None = None,
        **options: Unpack[LogOptions],
    ) -> list[dict[str, NDArray[Any]]]:
        """The torque of each trajectory of a log: a list of dicts with t, q, dq, ddq and tau_hat.

        outside_range is True where a joint leaves the range of the log that the model is of. Where the
        log has torque, tau is it, filtered as the motion. With `parts`, inertia, coriolis, gravity and
        friction too; with `interval`, a percentage, tau_low and tau_high.
        """
        log = read_log(log, **options)
        found: list[dict[str, NDArray[Any]]] = log.trajectories(model=self)
        for own in found:
            state = own["q"], own["dq"], own["ddq"]
            own["tau_hat"] = self.torque(*state)
            own["outside_range"] = np.asarray(self.outside_range(*state))
            if parts:
                own.update(self.parts(*state))
            if interval is not None:
                own["tau_low"], own["tau_high"] = self.interval(*state, percent=interval)
        return found

    # In other programs.

    @explicit(ExportOptions)
    def export(
        self, path: _Path, to: str | None = None, **options: Unpack[ExportOptions]
    ) -> list[str]:
        """Writes the model for another program; returns what the file has no room for.

        to
            ``c``, ``rust``, ``python``, ``latex``, ``fmu``, ``ros2``, ``urdf``, ``mjcf`` or ``json``;
            by default as the ending of `path` says. For ros2 and samples `path` is a new folder.
        name
            What the functions of C, an FMU or a ROS 2 package begin with; the name of the file.
        precision, reversal, binary, force
            ``"float"`` for 32 bits; half width of the reversal of friction [rad/s]; False for an FMU
            of sources; True for a model whose M(q) is not positive definite.
        onto, lock
            URDF file that inertia and friction are put into, and its joints that are held at 0.
        samples, seed
            So many models in place of the one, see :meth:`samples`.
        """
        path = Path(path)
        to = to or _target(path)
        options.setdefault("name", path.stem)
        files, left_out = self._files(to, **options)
        if "" in files:
            _core.write_whole(path, files[""])
            return left_out
        if path.exists() and any(path.iterdir()):
            raise FileExistsError(f"{path} exists and is not empty: name a new folder")
        for own, content in files.items():
            (path / own).parent.mkdir(parents=True, exist_ok=True)
            _core.write_whole(path / own, content)
        return left_out

    def _files(
        self, to: str, name: str = "arm", onto: _Path | None = None, **options: Any
    ) -> tuple[dict[str, bytes], list[str]]:
        """Files by their path in a package, a single one by no path; what they have no room for."""
        text = None if onto is None else Path(onto).read_text()
        lock = list(options.pop("lock", None) or ())
        files, left_out = self._export(to, name, onto=text, lock=lock, **options)
        return dict(files), left_out

    def samples(self, count: int, *, seed: int = 0) -> list[Model]:
        """Models drawn from the covariance of this one: arms that its log may as well be of.

        All of them are physical. They are what a simulator randomises a robot by, and what errors are
        propagated with; a model of a library has no covariance to draw from.
        """
        files, _ = self._files("json", samples=count, seed=seed)
        return [type(self).from_json(text.decode()) for text in files.values()]

    @explicit(RobotOptions)
    def to_urdf(self, path: _Path | None = None, **options: Unpack[RobotOptions]) -> str:
        """The model as a robot for ROS, Pinocchio, Drake, Gazebo: the text, and a file if asked for."""
        return self._robot("urdf", path, options)

    @explicit(RobotOptions)
    def to_mjcf(self, path: _Path | None = None, **options: Unpack[RobotOptions]) -> str:
        """The same for MuJoCo."""
        return self._robot("mjcf", path, options)

    def _robot(self, to: str, path: _Path | None, options: RobotOptions) -> str:
        files, _ = self._files(to, **options)
        if path is not None:
            _core.write_whole(path, files[""])
        return files[""].decode()

    def functions(self, module: Any = math, **options: Any) -> types.SimpleNamespace:
        """The closed form as functions of another module's sin, cos, exp and tanh.

        With ``jax.numpy`` they are traced, differentiated and batched by jax; likewise with torch,
        casadi or sympy. They take sequences of n numbers of that module and return lists:
        ``torque(q, dq, ddq)``, ``gravity(q)``, ``coriolis(q, dq)``, ``inertia(q)``,
        ``friction(q, dq)``, ``forward_dynamics(q, dq, tau)``, …
        """
        source = self._files("python", **options)[0][""].decode()
        space: dict[str, Any] = {"__name__": "torquewise.exported"}
        exec(compile(source, "<exported model>", "exec"), space)
        if module is not math:
            space.update({own: getattr(module, own) for own in ("sin", "cos", "exp", "tanh")})
            space["_sign"] = module.sign
            space["_positive"] = lambda x: 0.5 * (module.sign(x) + 1)
        return types.SimpleNamespace(**{key: space[key] for key in space["__all__"]})

    def to_sympy(self, **options: Any) -> Symbolic:
        """The equations of motion in sympy: :class:`Symbolic`."""
        import sympy

        n = len(self.joints)
        q, dq, ddq = (sympy.symbols(f"{own}1:{n + 1}", real=True) for own in ("q", "dq", "ddq"))
        own = self.functions(sympy, **options)

        def vector(values: Any) -> Any:
            return sympy.Matrix([sympy.sympify(x) for x in values])

        return Symbolic(
            q=q,
            dq=dq,
            ddq=ddq,
            torque=vector(own.torque(q, dq, ddq)),
            mass_matrix=sympy.Matrix(own.inertia(q)),
            coriolis=vector(own.coriolis(q, dq)),
            gravity=vector(own.gravity(q)),
            friction=vector(own.friction(q, dq)),
        )

    def to_casadi(self, what: str = "torque", **options: Any) -> Any:
        """A function of the equations of motion as a ``casadi.Function``.

        what
            ``torque`` (q, dq, ddq), ``forward_dynamics`` (q, dq, tau), ``inertia`` (q), ``coriolis``,
            ``friction`` (q, dq) or ``gravity`` (q).
        """
        import casadi

        inputs = {
            "torque": ("q", "dq", "ddq"),
            "forward_dynamics": ("q", "dq", "tau"),
            "inertia": ("q",),
            "gravity": ("q",),
            "coriolis": ("q", "dq"),
            "friction": ("q", "dq"),
        }
        if what not in inputs:
            raise ValueError(f"what={what!r}: expected one of {', '.join(inputs)}")
        own = getattr(self.functions(casadi, **options), what)
        symbols = [casadi.SX.sym(name, len(self.joints)) for name in inputs[what]]
        found = own(*(casadi.vertsplit(symbol) for symbol in symbols))
        if what == "inertia":
            result = casadi.vertcat(*(casadi.horzcat(*row) for row in found))
        else:
            result = casadi.vertcat(*found)
        output = {"inertia": "M", "forward_dynamics": "ddq"}.get(what, "tau")
        return casadi.Function(what, symbols, [result], list(inputs[what]), [output])

    @explicit(RobotOptions)
    def to_pinocchio(self, **options: Unpack[RobotOptions]) -> Any:
        """The links, joints and rotors of a chain as a ``pinocchio.Model``, with its gravity.

        Pinocchio adds no friction: its ``rnea`` gives :meth:`torque` less :meth:`friction`. Springs and
        other terms that it has no room for are named in a warning.
        """
        try:
            import pinocchio
        except ImportError:
            raise ImportError("Pinocchio is not installed: pip install pin") from None
        files, left_out = self._files("urdf", **options)
        found = pinocchio.buildModelFromXML(files[""].decode())
        # A URDF has no rotors: what they add to M(q) is the same everywhere.
        q = np.zeros(len(self.joints))
        bodies = pinocchio.crba(found, found.createData(), q)
        rotors = np.diag(self.mass_matrix(q) - np.triu(bodies) - np.triu(bodies, 1).T)
        found.armature = np.where(rotors > 1e-9 * np.diag(bodies).max(), rotors, 0.0)
        if left_out:
            warnings.warn(f"not in the Pinocchio model: {', '.join(left_out)}", stacklevel=2)
        return found

    def plot(self, log: Any = None, **options: Any) -> Any:
        """Draws the arm, or with a log its torque: see :mod:`torquewise.plot`."""
        from . import plot

        return plot.arm(self, **options) if log is None else plot.torque(self, log, **options)


@dataclass
class Symbolic:
    """Equations of motion in sympy: symbols, and matrices in them."""

    q: tuple[Any, ...]
    dq: tuple[Any, ...]
    ddq: tuple[Any, ...]
    torque: Any
    mass_matrix: Any
    coriolis: Any
    gravity: Any
    friction: Any


def _target(path: Path) -> str:
    to = _ENDINGS.get(path.suffix.lower())
    if to is None:
        raise ValueError(f'{path} does not say what is wanted: give to="c", "urdf", …')
    return to
