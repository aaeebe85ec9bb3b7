"""Figures by matplotlib: torque, friction, patterns, external torque, the arm.

Each returns the figure; in a notebook it shows inline. With `ax`, it draws into axes that are there:
one, or as many as it says.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from ._log import patterns as _patterns
from ._log import read_log
from ._options import LogOptions, explicit

if TYPE_CHECKING:
    from ._model import Model
    from ._observer import Contacts
    from ._options import Unpack

_COLORS = ("#4c78a8", "#f58518", "#54a24b")


def _pyplot() -> Any:
    try:
        import matplotlib.pyplot as plt
    except ImportError:
        raise ImportError("figures are drawn by matplotlib: pip install matplotlib") from None
    return plt


def _grid(
    n: int, ax: Any, width: float = 7.0, height: float = 1.8, columns: int = 1, **options: Any
) -> tuple[Any, list[Any]]:
    """A figure and n axes, or those that were given."""
    if ax is not None:
        given = list(np.ravel(ax))
        if len(given) != n:
            raise ValueError(f"ax: {len(given)} axes were given, {n} are drawn into")
        return given[0].figure, given
    plt = _pyplot()
    rows = -(-n // columns)
    figure, axes = plt.subplots(
        rows,
        columns,
        figsize=(width, height * rows),
        squeeze=False,
        layout="constrained",
        **options,
    )
    for axis in axes.flat[n:]:
        axis.set_axis_off()
    return figure, list(axes.flat[:n])


@explicit(LogOptions)
def torque(
    model: Model,
    log: Any = None,
    *,
    interval: float | None = None,
    ax: Any = None,
    **options: Unpack[LogOptions],
) -> Any:
    """Measured and predicted torque of each joint over time; `ax`: one for each joint."""
    found = model.predict(log, interval=interval, **options)
    figure, axes = _grid(len(model.joints), ax, sharex=True)
    for joint, (axis, name) in enumerate(zip(axes, model.joints)):
        for k, own in enumerate(found):
            labels = ("measured", "model") if k == 0 else (None, None)
            if "tau" in own:
                axis.plot(own["t"], own["tau"][:, joint], color="0.6", lw=1, label=labels[0])
            axis.plot(own["t"], own["tau_hat"][:, joint], color=_COLORS[0], lw=1, label=labels[1])
            if interval is not None:
                low, high = own["tau_low"][:, joint], own["tau_high"][:, joint]
                axis.fill_between(own["t"], low, high, color=_COLORS[0], alpha=0.2, lw=0)
        axis.set_ylabel(f"{name}\n[N·m]")
    axes[0].legend(loc="upper right", frameon=False)
    axes[-1].set_xlabel("time [s]")
    return figure


def friction(model: Model, *, points: int = 401, ax: Any = None) -> Any:
    """Friction of each joint over its speed, and, where it remembers the path, loops of reversals.

    `ax`: one for each joint, two where friction remembers the path.
    """
    n = len(model.joints)
    training = _ranges(model)
    columns = 2 if model.has_memory else 1
    figure, axes = _grid(n * columns, ax, columns=columns, height=2.2)
    for joint, name in enumerate(model.joints):
        axis = axes[joint * columns]
        peak = training[joint][1]
        speed = np.zeros((points, n))
        speed[:, joint] = np.linspace(-peak, peak, points)
        tau = model.friction(np.zeros((points, n)), speed)
        axis.plot(speed[:, joint], tau[:, joint], color=_COLORS[0])
        axis.set(xlabel="speed [rad/s]", ylabel="friction [N·m]", title=name)
        if model.has_memory:
            _loop(model, joint, peak, axes[joint * columns + 1], points)
    return figure


def _loop(model: Model, joint: int, peak: float, axis: Any, points: int) -> None:
    """Friction along three turns to and fro, ever smaller."""
    n = len(model.joints)
    state = model.state()
    way, tau = [], []
    for reach in (0.2, 0.1, 0.05):
        phase = np.linspace(0, 2 * np.pi, points)
        for p in phase:
            q, dq = np.zeros(n), np.zeros(n)
            q[joint], dq[joint] = reach * np.sin(p), 0.05 * peak * np.cos(p)
            state.step(q)
            way.append(q[joint])
            tau.append(state.friction(dq)[joint])
    axis.plot(way, tau, color=_COLORS[1], lw=1)
    axis.set(xlabel="position [rad]", ylabel="friction [N·m]", title="reversals")


def _ranges(model: Model) -> list[Any]:
    training = json.loads(model.to_json())["training"]
    n = len(model.joints)
    ranges = training.get("q_range") or [[-np.pi, np.pi]] * n
    peaks = training.get("dq_peak") or [1.0] * n
    return list(zip(ranges, peaks))


@explicit(LogOptions)
def activation(
    log: Any = None, *, points: int = 5000, ax: Any = None, **options: Unpack[LogOptions]
) -> Any:
    """Rows of a log in the plane of how fast and how strongly they accelerate, by pattern."""
    log = read_log(log, **options)
    found = _patterns(log)
    motions = log.trajectories(conditioned=log.is_filtered)
    speed = np.concatenate([np.linalg.norm(own["dq"], axis=1) for own in motions])
    rate = np.concatenate([np.linalg.norm(own["ddq"], axis=1) for own in motions])
    labels = found.labels
    if len(labels) != len(speed):
        labels = labels[np.linspace(0, len(labels) - 1, len(speed)).astype(int)]
    keep = np.linspace(0, len(speed) - 1, min(points, len(speed))).astype(int)
    figure, (axis,) = _grid(1, ax, height=4.5)
    for k, (name, color) in enumerate(zip(found.NAMES, _COLORS)):
        own = keep[labels[keep] == k]
        axis.scatter(speed[own], rate[own], s=4, color=color, label=name, lw=0)
    axis.set(xlabel="|dq| [rad/s]", ylabel="|ddq| [rad/s²]")
    axis.legend(frameon=False, markerscale=3)
    return figure


def contacts(found: Contacts, *, points: int = 4000, ax: Any = None) -> Any:
    """External torque of :func:`torquewise.contacts`, thresholds and contacts; `ax`: one a joint."""
    figure, axes = _grid(len(found.joints), ax, sharex=True)
    step = max(1, len(found.t) // points)
    for joint, (axis, name) in enumerate(zip(axes, found.joints)):
        axis.plot(found.t[::step], found.external[::step, joint], color=_COLORS[0], lw=1)
        for sign in (-1, 1):
            most = sign * found.thresholds[::step, joint]
            axis.plot(found.t[::step], most, color="0.6", ls="--", lw=1)
        for contact in found.contacts:
            if contact["joint"] == name:
                axis.axvspan(contact["begin"], contact["end"], color=_COLORS[1], alpha=0.3, lw=0)
        axis.set_ylabel(f"{name}\n[N·m]")
    axes[-1].set_xlabel("time [s]")
    return figure


def arm(model: Model, *, ax: Any = None) -> Any:
    """Axes of the joints where they were learned to lie, at q = 0; for models of a chain. Dashed: not resolved.

    `ax`: one with ``projection="3d"``.
    """
    axes = model.describe()["geometry"]
    if not axes:
        raise ValueError('the model has no geometry: fit a chain (library="chain")')
    points = np.array([own["point"] for own in axes])
    ways = np.array([own["axis"] for own in axes])
    size = max(np.ptp(points, axis=0).max(), 0.1)
    if ax is None:
        ax = _pyplot().figure(figsize=(5, 5)).add_subplot(projection="3d")
    elif getattr(ax, "name", "") != "3d":
        raise ValueError('ax: expected one of three dimensions (projection="3d")')
    figure, space = ax.figure, ax
    space.plot(*np.vstack([np.zeros(3), points]).T, color="0.5", lw=3, marker="o", ms=4)
    for own, point, way in zip(axes, points, ways):
        end, style = point + 0.2 * size * way, "-" if own["resolved"] else ":"
        space.plot(*np.vstack([point, end]).T, color=_COLORS[1], lw=2, ls=style)
        space.text(*end, own["joint"], fontsize=8)
    middle, half = points.mean(axis=0), 0.75 * size
    space.set(
        xlim=(middle[0] - half, middle[0] + half),
        ylim=(middle[1] - half, middle[1] + half),
        zlim=(middle[2] - half, middle[2] + half),
        xlabel="x [m]",
        ylabel="y [m]",
        zlabel="z [m]",
    )
    return figure
