"""From logs to a model."""

from __future__ import annotations

import html
import json
import warnings
from dataclasses import dataclass, field
from datetime import datetime, timezone
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._log import read_log
from ._model import Model
from ._observer import Payload, payload
from ._options import FitOptions, LogOptions, Path, Progress, explicit, split
from ._progress import shown
from ._tables import frame

if TYPE_CHECKING:
    from ._options import Unpack

_ARRAYS = "t", "q", "dq", "ddq", "tau"


@dataclass(eq=False)
class Evaluation:
    """Errors of a model on a log, joint by joint."""

    joints: list[str]
    rows: int
    rmse: NDArray[np.float64]
    """RMSE [N·m] of each joint, in the band of the model."""
    nrmse_percent: NDArray[np.float64]
    """RMSE of each joint, of the standard deviation of its torque [%]; NaN where that never changes."""
    r2: NDArray[np.float64]
    raw_nrmse_percent: NDArray[np.float64]
    """The same against torque as it was measured."""
    interval_coverage_percent: NDArray[np.float64]
    """Torques of each joint, as they were measured, within their interval of 95 % [%]; NaN where the
    model has no covariance, or torque as it was measured is not at hand."""
    verdict: str
    """``good``, ``usable`` or ``unusable``, by the fit of the model and by this log."""
    because: list[str]
    """Why, in sentences."""
    notes: list[str] = field(default_factory=list)
    """What to know before these errors are used, in sentences."""

    @classmethod
    def _of(cls, text: str, notes: list[str]) -> Evaluation:
        found = json.loads(text)

        def of(key: str) -> NDArray[np.float64]:
            return np.array([joint.get(key) for joint in found["joints"]], dtype=float)

        names = [joint["name"] for joint in found["joints"]]
        covered = found.get("interval_coverage_percent", [None] * len(names))
        return cls(
            names,
            found["rows"],
            of("rmse"),
            of("nrmse_percent"),
            of("r2"),
            of("raw_nrmse_percent"),
            np.array(covered, dtype=float),
            found["verdict"],
            found["because"],
            notes,
        )

    def to_frame(self) -> Any:
        """A frame of pandas with a row for each joint."""
        names = "rmse", "nrmse_percent", "r2", "raw_nrmse_percent", "interval_coverage_percent"
        errors = {name: getattr(self, name) for name in names}
        return frame({"joint": self.joints, **errors}, "joint")

    def __repr__(self) -> str:
        lines = [f"{'joint':<20} {'RMSE [N·m]':>12} {'NRMSE [%]':>10} {'R²':>9}"]
        for name, rmse, nrmse, r2 in zip(self.joints, self.rmse, self.nrmse_percent, self.r2):
            lines.append(f"{name:<20} {rmse:>12.4g} {nrmse:>10.4g} {r2:>9.6f}")
        lines += [f"verdict: {self.verdict}: {'; '.join(self.because)}"]
        lines += [f"note: {note}" for note in self.notes]
        return "\n".join(lines)


class Fit:
    """A model, how it was found, and how far to trust it."""

    model: Model
    """The learned equations of motion."""
    verdict: str
    """``good``, ``usable`` or ``unusable``, from held-out blocks of the log."""
    because: list[str]
    """Why, in sentences."""
    warnings: list[str]
    """What to know before the model is used, in sentences."""
    notes: list[str]
    """What is good to know and changes nothing."""
    seconds: float
    """Time it took [s]."""
    loads: list[Payload]
    """The load of each log of the arm with one."""

    def __init__(self, core: _core.Fit):
        self._core: _core.Fit | None = core
        self.model = Model(core.model)
        self._summary, self.warnings, self.notes, self._words = core._facts()
        facts = self.summary()
        self.verdict, self.because = facts["verdict"], facts["because"]
        self.seconds = facts["seconds"]
        self.loads = []

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_core": None}

    def summary(self) -> dict[str, Any]:
        """All numbers, as a dict: what ``torquewise fit --json`` prints."""
        found: dict[str, Any] = json.loads(self._summary)
        return found

    @explicit(LogOptions)
    def evaluate(
        self, log: Any = None, *, progress: Progress = None, **options: Unpack[LogOptions]
    ) -> Evaluation:
        """How well the model predicts another log, see :meth:`Model.evaluate`."""
        return self.model.evaluate(log, progress=progress, **options)

    @explicit(LogOptions)
    def report(
        self,
        path: Path | None = None,
        *,
        test: Any = None,
        progress: Progress = None,
        **options: Unpack[LogOptions],
    ) -> str:
        """The report as one page of HTML: the text, or written to `path`.

        `test` is a log of another motion to judge the model by.
        """
        if self._core is None:
            raise _core.FitError("a pickled fit keeps no rows: write its report before")
        date = datetime.now(timezone.utc).strftime("%Y-%m-%d %H:%M UTC")
        test = None if test is None else read_log(test, **options)
        with shown(progress) as told:
            page = self._core._report(date, test, told)
        if not page:
            raise _core.FitError("a fit of sums kept no rows: there is no report of it")
        if path is None:
            return page.decode()
        _core.write_whole(path, page)
        return str(path)

    def save(self, path: Path) -> None:
        """Writes the model to a file."""
        self.model.save(path)

    def __repr__(self) -> str:
        return self._words

    def _repr_html_(self) -> str:
        try:
            page = self.report(progress=False)
        except _core.TorquewiseError:
            return self.model._repr_html_()
        return (
            f'<iframe srcdoc="{html.escape(page)}" width="100%" height="640" '
            'style="border: 1px solid #ccc"></iframe>'
        )


@explicit(FitOptions)
def fit(
    log: Any = None,
    *,
    loaded: Any = None,
    progress: Progress = None,
    **options: Unpack[FitOptions],
) -> Fit:
    """Reconstructs the equations of motion from logs of one arm.

    log
        Whatever :func:`read_log` takes; or arrays by the keywords t, q, dq, ddq, tau and rate.
    loaded
        Log of the arm with a load on its last link, or a list of such logs, one for each load: they
        are weighed by the model, a chain, see :attr:`Fit.loads`.
    library
        ``"energy"``, ``"product"`` or ``"chain"``; by default a chain of rigid bodies for filtered
        logs, friction, four joints and more, or where it misses less than terms that are not good,
        else energies.
    method
        ``"stepwise"``: gravity from standstill, Coriolis from uniform, inertia from variable
        velocity; or ``"sindy"``: one shot.
    friction
        ``"none"``, ``"linear"``, ``"stribeck"`` or ``"auto"``.
    urdf, lock, gravity
        File with the joint axes, its joints that are held at 0, direction of gravity at its base.
    kinds
        Which joints turn and which slide, base to tip, as ``"r,r,p,r"``; without, a chain finds them
        in the log, and in a library all turn.
    counterbalance
        Joints that a spring or a weight balances.
    refine
        ``"rollout"``: the rotors of a chain are moved so that simulated windows of the log drift less.
    select, threshold, n_bootstrap
        ``"bic"``, ``"lasso"`` or ``"stlsq"``, the threshold of the last, and how many resampled logs
        tell which terms stay.
    interaction, trig_order, gravity_order
        How many joints a term of inertia may couple, and the orders of sines and cosines.
    noise_correction
        Whether bias by noise is taken out.
    activation, clusters, seed
        How rows are clustered; seed of everything random.
    progress
        True for a bar by tqdm, False for none, or a function of (what, rows, total).

    Options of :func:`read_log` are taken too. The model is the same, byte for byte, as that of the
    command line. Ctrl-C ends it at once.
    """
    of_log, of_fit = split(options)
    log = read_log(log, **of_log)
    loads = [] if loaded is None else loaded if isinstance(loaded, list) else [loaded]
    of_load = {key: own for key, own in of_log.items() if key not in _ARRAYS}
    loads = [read_log(load, **of_load) for load in loads]
    if loads and of_fit.get("library") is None:
        of_fit["library"] = "chain"
    with shown(progress) as told:
        found = Fit(_core.fit(log, of_fit, told))
    found.loads = [payload(found.model, load, progress=progress) for load in loads]
    if found.verdict == "unusable":
        warnings.warn(f"the model is unusable: {'; '.join(found.because)}", stacklevel=2)
    return found


@dataclass
class Comparison:
    """Stepwise reconstruction beside one-shot SINDy on the same logs."""

    stepwise: Fit
    sindy: Fit
    stepwise_test: Evaluation
    sindy_test: Evaluation

    def to_frame(self) -> Any:
        """A frame of pandas with a row for each method and joint."""
        tests = {"stepwise": self.stepwise_test, "sindy": self.sindy_test}
        columns = {
            "method": np.repeat(list(tests), len(self.stepwise_test.joints)),
            "joint": [name for own in tests.values() for name in own.joints],
        }
        for name in ("rmse", "nrmse_percent", "r2"):
            columns[name] = np.concatenate([getattr(own, name) for own in tests.values()])
        return frame(columns)

    def __repr__(self) -> str:
        lines = [f"{'method':<10} {'terms':>6} {'seconds':>8}  NRMSE [%] of each joint"]
        rows = [
            ("stepwise", self.stepwise, self.stepwise_test),
            ("sindy", self.sindy, self.sindy_test),
        ]
        for name, found, test in rows:
            errors = "  ".join(f"{error:.4g}" for error in test.nrmse_percent)
            lines.append(f"{name:<10} {found.model.complexity:>6} {found.seconds:>8.2f}  {errors}")
        return "\n".join(lines)


@explicit(FitOptions)
def compare(
    log: Any, test: Any, *, progress: Progress = None, **options: Unpack[FitOptions]
) -> Comparison:
    """Fits stepwise reconstruction and one-shot SINDy to a log, and judges both by another."""
    of_log, of_fit = split(options)
    of_fit.pop("method", None)
    shared = {key: of_fit[key] for key in ("trig_order", "seed") if key in of_fit}
    by_steps: Any = {**of_fit, **of_log, "method": "stepwise"}
    stepwise = fit(log, progress=progress, **by_steps)
    one_shot: Any = {**shared, **of_log, "method": "sindy"}
    sindy = fit(log, progress=progress, **one_shot)
    tests = [found.evaluate(test, progress=progress, **of_log) for found in (stepwise, sindy)]
    return Comparison(stepwise, sindy, *tests)
