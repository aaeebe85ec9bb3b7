"""The learned equations of motion."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._exported import Exported
from ._log import read_log
from ._options import LogOptions, Progress, explicit
from ._options import Path as _Path
from ._progress import shown
from ._rollout import Rollout
from ._tables import Trajectory

if TYPE_CHECKING:
    from ._fit import Evaluation
    from ._options import Unpack


class Model(Exported):
    """Equations of motion of an arm: tau = M(q) ddq + C(q, dq) dq + G(q) + F(q, dq).

    q [rad], dq [rad/s], ddq [rad/s²] and tau [N·m] are one state of n numbers, or m states in rows
    (m×n); results have as many rows. One state beside rows stands for each of them. Models come from
    :func:`torquewise.fit` and :meth:`load`, can be pickled, and are equal if all their numbers are.
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

    def parameters(self) -> list[dict[str, Any]]:
        """What torque determines of links, rotors and springs of a chain: a dict each.

        It has joint, name, value and std_error, of first moments [kg·m], moments of inertia [kg·m²],
        masses [kg]; `resolved` says whether it can be told from zero. ``pandas.DataFrame`` takes all.
        """
        found: list[dict[str, Any]] = self.describe()["parameters"]
        return found

    def text(self, joint: int | None = None, *, top: int | None = None, all: bool = False) -> str:
        """The equations with standard errors, of all joints or of one counted from 0.

        top
            So many of the largest terms of each.
        all
            Those too that are below two standard errors.
        """
        return self._text(joint, top, all)

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
        """Whether the model is physics: a dict; ``passed`` says it in a word, ``warning`` why not.

        So many random states are looked at within the range of the log, and as many in a whole turn.
        """
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
        With `samples`, so many arms of :meth:`samples` are simulated too, started with the noise of the
        measured state, and `covered` says how often the measured arm ends in their band.
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
    ) -> list[Trajectory]:
        """The torque of each trajectory of a log: a list of dicts with t, q, dq, ddq and tau_hat.

        Each becomes a table by its ``to_frame()``. A filter takes some rows at both ends of each; `t`
        says which are left. outside_range is True where a joint leaves the range of the log that the
        model is of. Where the log has torque, tau is it, filtered as the motion. With `parts`, inertia,
        coriolis, gravity and friction too; with `interval`, a percentage, tau_low and tau_high.
        """
        log = read_log(log, **options)
        found: list[Trajectory] = log.trajectories(model=self)
        for own in found:
            state = own["q"], own["dq"], own["ddq"]
            own["tau_hat"] = self.torque(*state)
            own["outside_range"] = np.asarray(self.outside_range(*state))
            if parts:
                own.update(self.parts(*state))
            if interval is not None:
                own["tau_low"], own["tau_high"] = self.interval(*state, percent=interval)
        return found

    def samples(self, count: int, *, seed: int = 0) -> list[Model]:
        """Models drawn from the covariance of this one: arms that its log may as well be of.

        All of them are physical. They are what a simulator randomises a robot by, and what errors are
        propagated with; a model of a library has no covariance to draw from.
        """
        if count < 1 or seed < 0:
            raise ValueError(f"expected one model or more and no seed below 0: {count}, {seed}")
        files, _ = self._files("json", samples=count, seed=seed)
        return [type(self).from_json(text.decode()) for text in files.values()]

    def plot(self, log: Any = None, **options: Any) -> Any:
        """Draws the arm, or with a log its torque: see :mod:`torquewise.plot`."""
        from . import plot

        return plot.arm(self, **options) if log is None else plot.torque(self, log, **options)
