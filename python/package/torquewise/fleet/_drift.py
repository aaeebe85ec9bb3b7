"""What changed: parameters of each log beside a model, and times at which they jump.

What the model leaves of the torque of a joint is fitted, log by log, by four numbers,

    tau - tau_hat = a dq + b sign(dq) + c G(q) + d,

changes of viscous friction [N·m·s/rad], dry friction [N·m], gravity (as a part of it, so of the load)
and offset [N·m]. A log gives each with an error from the scatter over stretches of time. In a series of
logs a jump is looked for at every place; how likely the largest is by chance follows from Student's t
and the number of places, and Holm's rule keeps the chance that any robot of the fleet is accused
wrongly below the level asked for.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .._log import read_log
from .._model import Model
from ._core import Plan, local

PARAMETERS = ("viscous", "dry", "gravity", "offset")
#: Stretches of time that a log is cut into, to tell how much it scatters.
_STRETCHES = 20
#: Logs before and after a jump at least.
_LEAST = 3
#: Part of the peak speed within which a joint counts as at rest.
_SLOW = 0.02


@dataclass(frozen=True)
class Reading:
    """Changes of the parameters of each joint in one log, beside a model."""

    path: str
    values: np.ndarray
    """n joints × 4; none where the log could not be read."""
    errors: np.ndarray
    """Standard errors, n×4; infinite where the motion does not tell."""
    rms: np.ndarray
    """RMS of what the model leaves of each joint [N·m], n."""
    reason: str | None = None
    """Why the log could not be read, if it could not."""


def read(path: str, plan: Plan, model: str) -> Reading:
    """The changes in a log; why there are none if it cannot be read."""
    try:
        own = Model.from_json(model)
        with local(path, plan) as here:
            motions = read_log(here, **plan.of_log()).trajectories(model=own)
        values, errors, rms = _changes(own, motions)
        return Reading(path, values, errors, rms)
    except MemoryError:
        raise
    except Exception as error:
        none = np.zeros((0, 4))
        return Reading(path, none, none, none[0:0, 0], f"{type(error).__name__}: {error}")


def _changes(model: Model, motions: Sequence[dict[str, np.ndarray]]) -> tuple[np.ndarray, ...]:
    left = np.concatenate(
        [own["tau"] - model.torque(own["q"], own["dq"], own["ddq"]) for own in motions]
    )
    dq = np.concatenate([own["dq"] for own in motions])
    gravity = model.gravity(np.concatenate([own["q"] for own in motions]))
    n = left.shape[1]
    values, errors = np.zeros((n, 4)), np.full((n, 4), np.inf)
    for joint in range(n):
        speed = dq[:, joint]
        peak = np.abs(speed).max(initial=0.0)
        # At rest dry friction may be anything.
        moves = np.abs(speed) > _SLOW * peak
        if moves.sum() < 10 * _STRETCHES:
            continue
        columns = np.stack([speed, np.sign(speed), gravity[:, joint], np.ones(len(speed))], axis=1)
        values[joint], errors[joint] = _solved(columns[moves], left[moves, joint])
    return values, errors, np.sqrt((left**2).mean(axis=0))


def _solved(columns: np.ndarray, left: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least squares, and errors by the scatter of stretches, since neighbouring rows are alike."""
    size = np.sqrt((columns**2).mean(axis=0))
    told = size > 1e-9 * max(size.max(), 1e-300)
    values, errors = np.zeros(4), np.full(4, np.inf)
    scaled = columns[:, told] / size[told]
    gram = scaled.T @ scaled
    if np.linalg.cond(gram) > 1e10:
        return values, errors
    found = np.linalg.solve(gram, scaled.T @ left)
    rest = left - scaled @ found
    scores = [
        part.T @ own
        for part, own in zip(np.array_split(scaled, _STRETCHES), np.array_split(rest, _STRETCHES))
    ]
    scatter = sum(np.outer(own, own) for own in scores) * _STRETCHES / (_STRETCHES - 1)
    inverse = np.linalg.inv(gram)
    values[told] = found / size[told]
    errors[told] = np.sqrt(np.diag(inverse @ scatter @ inverse)) / size[told]
    return values, errors


@dataclass(frozen=True)
class Change:
    """A parameter of a joint that is another since some log."""

    robot: Any
    joint: str
    parameter: str
    since: Any
    """What the first log after the jump is called: its time, or its path."""
    change: float
    """By how much [N·m·s/rad, N·m, part of gravity, N·m]."""
    error: float
    """Standard error of that."""
    percent: float | None
    """Of the parameter of the model, where that is known."""
    chance: float
    """That any of the fleet would show as much without a change, after Holm."""
    key: str = ""
    """That of time, such as ``week``."""

    @property
    def when(self) -> str:
        """`since` with the key of time before it, unless it begins so."""
        since = str(self.since)
        return since if since.startswith(self.key) else f"{self.key} {since}"

    def __str__(self) -> str:
        by = f"{self.percent:+.0f} %" if self.percent is not None else f"{self.change:+.3g}"
        name = {"viscous": "viscous friction", "dry": "dry friction"}.get(
            self.parameter, self.parameter
        )
        return f"robot {self.robot}, {self.joint}: {name} {by} since {self.when}"


def jumps(
    series: dict[Any, list[tuple[Any, Reading]]],
    joints: Sequence[str],
    scales: dict[Any, np.ndarray],
    level: float,
    key: str = "",
) -> list[Change]:
    """Changes that hardly are chance, of all robots.

    series: logs of each robot in the order of time, with what each is called. scales: of each robot,
    the parameters of its model, n×4, NaN where they are not known. level: chance that any of the fleet
    is accused wrongly. key: that of time.
    """
    found = []
    for robot, logs in series.items():
        logs = [own for own in logs if own[1].reason is None]
        for joint, name in enumerate(joints):
            for k, parameter in enumerate(PARAMETERS):
                told = [(when, own) for when, own in logs if np.isfinite(own.errors[joint, k])]
                if len(told) < 2 * _LEAST + 1:
                    continue
                values = np.array([own.values[joint, k] for _, own in told])
                errors = np.array([own.errors[joint, k] for _, own in told])
                place, before, change, error, chance = _largest(values, errors)
                # The model is of all logs, those after the change among them.
                scale = scales.get(robot, np.full((len(joints), 4), np.nan))[joint, k] + before
                percent = 100 * change / scale if np.isfinite(scale) and scale != 0 else None
                when = told[place][0]
                found.append(
                    Change(robot, name, parameter, when, change, error, percent, chance, key)
                )
    return _holm(found, level)


def _largest(values: np.ndarray, errors: np.ndarray) -> tuple[int, float, float, float, float]:
    """The place of the largest jump, the mean before, its size and error, the chance of its like."""
    m = len(values)
    # Logs of the same motion are about as good; none counts more than its share of the whole.
    weight = 1 / (errors**2 + np.median(errors) ** 2)
    best = (0, 0.0, 0.0, math.inf, 0.0)
    for place in range(_LEAST, m - _LEAST + 1):
        parts = slice(None, place), slice(place, None)
        sums = [weight[own].sum() for own in parts]
        means = [(weight[own] * values[own]).sum() / total for own, total in zip(parts, sums)]
        rest = np.concatenate([values[own] - mean for own, mean in zip(parts, means)])
        spread = (weight * rest**2).sum() / (m - 2)
        error = math.sqrt(max(spread, 1e-300) * (1 / sums[0] + 1 / sums[1]))
        size = abs(means[1] - means[0]) / error
        if size > best[4]:
            best = (place, means[0], means[1] - means[0], error, size)
    place, before, change, error, size = best
    places = m - 2 * _LEAST + 1
    return place, before, change, error, min(1.0, places * 2 * _student(size, m - 2))


def _student(t: float, freedom: int) -> float:
    """The chance that Student's t exceeds a value."""
    from scipy.stats import t as student

    return float(student.sf(t, freedom))


def _holm(all_of_them: list[Change], level: float) -> list[Change]:
    """Those that stand where the chance of a single wrong one is to stay below a level."""
    kept, largest = [], 0.0
    for rank, own in enumerate(sorted(all_of_them, key=lambda own: own.chance)):
        largest = max(largest, min(1.0, own.chance * (len(all_of_them) - rank)))
        if largest >= level:
            break
        kept.append(Change(**{**own.__dict__, "chance": largest}))
    return kept


def parameters(model: Model) -> np.ndarray:
    """Viscous and dry friction of each joint of a model, gravity as 1; NaN where there is none."""
    joints = model.joints
    found = np.full((len(joints), 4), np.nan)
    found[:, 2] = 1.0
    for own in model.describe()["friction_parameters"]:
        turned = [k for k, share in enumerate(own["shaft"]) if share]
        if len(turned) != 1:
            continue
        for k, name in enumerate(("viscous", "coulomb")):
            values = [
                own[way][name]["value"] for way in ("forward", "backward") if own[way].get(name)
            ]
            if values:
                found[turned[0], k] = float(np.mean(values))
    return found
