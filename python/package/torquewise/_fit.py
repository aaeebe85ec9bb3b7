"""From logs to a model."""

from __future__ import annotations

import html
import json
from dataclasses import dataclass, field
from datetime import datetime, timezone
from typing import Any

from . import _core
from ._log import Path, Progress, read_log
from ._model import Model
from ._progress import shown

#: Keywords of :func:`fit` that are about the log, not about the fit.
OF_LOG = (
    "t",
    "q",
    "dq",
    "ddq",
    "tau",
    "rate",
    "joints",
    "profile",
    "topic",
    "repair",
    "filter",
    "delay",
)


@dataclass
class Evaluation:
    """Errors of a model on a log, joint by joint."""

    joints: list[str]
    rows: int
    rmse: list[float]
    """RMSE [N·m] of each joint, in the band of the model."""
    nrmse_percent: list[float]
    """RMSE of each joint, of the standard deviation of its torque [%]."""
    r2: list[float]
    raw_nrmse_percent: list[float]
    """The same against torque as it was measured."""
    notes: list[str] = field(default_factory=list)

    @classmethod
    def _of(cls, text, notes):
        found = json.loads(text)
        of = lambda key: [joint.get(key) for joint in found["joints"]]
        return cls(
            of("name"),
            found["rows"],
            of("rmse"),
            of("nrmse_percent"),
            of("r2"),
            of("raw_nrmse_percent"),
            notes,
        )

    def __repr__(self):
        lines = [f"{'joint':<20} {'RMSE [N·m]':>12} {'NRMSE [%]':>10} {'R²':>9}"]
        for name, rmse, nrmse, r2 in zip(self.joints, self.rmse, self.nrmse_percent, self.r2):
            nrmse = float("inf") if nrmse is None else nrmse
            lines.append(f"{name:<20} {rmse:>12.4g} {nrmse:>10.4g} {_number(r2):>9}")
        return "\n".join(lines)


def _number(value):
    return "–" if value is None else f"{value:.6f}"


class Fit:
    """A model, how it was found, and how far to trust it."""

    model: Model
    """The learned equations of motion."""

    def __init__(self, core: _core.Fit):
        self._core = core
        self.model = Model(core.model)

    @property
    def verdict(self) -> str | None:
        """``good``, ``usable`` or ``unusable``, from held-out blocks of the log; None if not known."""
        return self._core.verdict

    @property
    def because(self) -> list[str]:
        """Why, in sentences."""
        return self._core.because

    @property
    def warnings(self) -> list[str]:
        """What to know before the model is used, in sentences."""
        return self._core.warnings

    @property
    def notes(self) -> list[str]:
        """What is good to know and changes nothing."""
        return self._core.notes

    @property
    def seconds(self) -> float:
        """Time it took [s]."""
        return self._core.seconds

    def summary(self) -> dict[str, Any]:
        """All numbers, as a dict: what ``torquewise fit --json`` prints."""
        return json.loads(self._core._summary())

    def evaluate(self, log: Any = None, *, progress: Progress = None, **options: Any) -> Evaluation:
        """How well the model predicts another log, see :meth:`Model.evaluate`."""
        return self.model.evaluate(log, progress=progress, **options)

    def report(
        self,
        path: Path | None = None,
        *,
        test: Any = None,
        progress: Progress = None,
        **options: Any,
    ) -> str:
        """The report as one page of HTML: the text, or written to `path`.

        `test` is a log of another motion to judge the model by.
        """
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

    def __repr__(self):
        return repr(self._core)

    def _repr_html_(self):
        try:
            page = self.report(progress=False)
        except _core.TorquewiseError:
            return self.model._repr_html_()
        return (
            f'<iframe srcdoc="{html.escape(page)}" width="100%" height="640" '
            'style="border: 1px solid #ccc"></iframe>'
        )


def fit(log: Any = None, *, progress: Progress = None, **options: Any) -> Fit:
    """Reconstructs the equations of motion from logs of one arm.

    log
        Whatever :func:`read_log` takes; or arrays by the keywords t, q, dq, ddq, tau and rate.
    library
        ``"energy"``, ``"product"`` or ``"chain"``; by default a chain of rigid bodies for filtered
        logs, friction, or five joints and more, else energies.
    method
        ``"stepwise"``: gravity from standstill, Coriolis from uniform, inertia from variable
        velocity; or ``"sindy"``: one shot.
    friction
        ``"none"``, ``"linear"``, ``"stribeck"`` or ``"auto"``.
    urdf, lock, gravity
        File with the joint axes, its joints that are held at 0, direction of gravity at its base.
    counterbalance
        Joints that a spring or a weight balances.
    select, threshold, bags, interaction, trig_order, gravity_order
        How the terms of a library are offered and selected, see ``torquewise fit --help``.
    noise_correction
        Whether bias by noise is taken out.
    activation, clusters, seed
        How rows are clustered; seed of everything random.
    progress
        True for a bar by tqdm, False for none, or a function of (what, rows, total).

    Options of :func:`read_log` are taken too. The model is the same, byte for byte, as that of the
    command line. Ctrl-C ends it at once.
    """
    of_log = {key: options.pop(key) for key in OF_LOG if key in options}
    log = read_log(log, **of_log)
    with shown(progress) as told:
        return Fit(_core.fit(log, options, told))


@dataclass
class Comparison:
    """Stepwise reconstruction beside one-shot SINDy on the same logs."""

    stepwise: Fit
    sindy: Fit
    stepwise_test: Evaluation
    sindy_test: Evaluation

    def __repr__(self):
        lines = [f"{'method':<10} {'terms':>6} {'seconds':>8}  NRMSE [%] of each joint"]
        rows = [
            ("stepwise", self.stepwise, self.stepwise_test),
            ("sindy", self.sindy, self.sindy_test),
        ]
        for name, found, test in rows:
            errors = "  ".join(f"{error:.4g}" for error in test.nrmse_percent)
            lines.append(f"{name:<10} {found.model.complexity:>6} {found.seconds:>8.2f}  {errors}")
        return "\n".join(lines)


def compare(log: Any, test: Any, *, progress: Progress = None, **options: Any) -> Comparison:
    """Fits stepwise reconstruction and one-shot SINDy to a log, and judges both by another."""
    of_log = {key: options.pop(key) for key in OF_LOG if key in options}
    options.pop("method", None)
    shared = {key: options[key] for key in ("trig_order", "seed") if key in options}
    stepwise = fit(log, progress=progress, method="stepwise", **options, **of_log)
    sindy = fit(log, progress=progress, method="sindy", **shared, **of_log)
    tests = [found.evaluate(test, progress=progress, **of_log) for found in (stepwise, sindy)]
    return Comparison(stepwise, sindy, *tests)
