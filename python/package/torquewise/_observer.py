"""Torque that others put on an arm, and the load on its last link."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._log import read_log
from ._model import Model
from ._options import LogOptions, Progress, explicit
from ._progress import shown
from ._tables import frame

if TYPE_CHECKING:
    from ._options import Unpack


@dataclass
class Contacts:
    """External torque of a log, and when it is more than a free arm shows."""

    joints: list[str]
    t: NDArray[np.float64]
    """Time [s], m."""
    external: NDArray[np.float64]
    """External torque of each joint [N·m], m×n."""
    thresholds: NDArray[np.float64]
    """Beyond which it is taken for a contact, at each time [N·m], m×n."""
    seconds: float
    """Time of free motion that the thresholds come from [s]."""
    blind: list[str]
    """Joints whose contacts go unseen: more free motion, or a better model, lowers the threshold."""
    contacts: list[dict[str, Any]]
    """A dict each: begin, end [s], joint, torque [N·m], factor of the threshold."""
    hints: list[str]
    """Where the log leaves the range that the model was fitted on: alarms there may be false."""

    def to_frame(self) -> Any:
        """A frame of pandas with a row for each contact."""
        names = "begin", "end", "joint", "torque", "factor"
        return frame({name: [own[name] for own in self.contacts] for name in names})

    def plot(self, **options: Any) -> Any:
        """Draws it: see :func:`torquewise.plot.contacts`."""
        from . import plot

        return plot.contacts(self, **options)


@explicit(LogOptions)
def contacts(
    model: Model,
    log: Any = None,
    *,
    free: Any = None,
    false_alarms: float | None = None,
    bandwidth: float | None = None,
    progress: Progress = None,
    **options: Unpack[LogOptions],
) -> Contacts:
    """External torque of a log by the momentum observer, and contacts beyond a threshold.

    free
        A log of the arm that nothing touches, to set the thresholds by; without, the log itself.
    false_alarms
        Of the whole arm in an hour of free motion, 1 without.
    bandwidth
        Of the observer [Hz], 10 without.
    """
    log = read_log(log, **options)
    free = None if free is None else read_log(free, **options)
    with shown(progress) as told:
        rows, (thresholds, found), hints = _core.contacts(
            model, log, free=free, bandwidth=bandwidth, false_alarms=false_alarms, progress=told
        )
    thresholds, n = json.loads(thresholds), len(model.joints)
    return Contacts(
        joints=model.joints,
        t=rows[:, 0],
        external=rows[:, 1 : n + 1],
        thresholds=rows[:, n + 1 :],
        seconds=thresholds["seconds"],
        blind=thresholds["blind"],
        contacts=json.loads(found),
        hints=hints,
    )


#: As the command line calls it too.
residuals = contacts


@dataclass
class Payload:
    """A body on a link of an arm; each error is one standard error."""

    mass: float
    """[kg]"""
    mass_error: float
    center: NDArray[np.float64]
    """Centre of mass [m], 3, in the frame of the link."""
    center_error: NDArray[np.float64]
    inertia: NDArray[np.float64]
    """Moments about the centre [kg·m²]: xx, yy, zz, xy, xz, yz."""
    inertia_error: NDArray[np.float64]
    link: str | None
    """As a URDF calls it, if one gave the geometry; else z is the axis of its joint."""
    rows: int
    disagreement: float
    """What joints say of it apart, over what their errors allow: errors are scaled by it."""
    elsewhere: str | None
    """The link on which a load explains significantly more."""
    lighter: float | None
    """What the log seems to lack [kg], where gravity says that it is lighter than the model."""
    residual_without: NDArray[np.float64]
    """RMS of what is left of the torque of each joint without the load [N·m]."""
    residual_with: NDArray[np.float64]
    hints: list[str]
    """What the motion tells too little of, and which would tell it."""
    model: Model
    """The arm that carries the load."""

    def to_frame(self) -> Any:
        """A frame of pandas with a row for mass, each coordinate of the centre, and each moment."""
        centers = [f"center {axis} [m]" for axis in "xyz"]
        moments = [f"I{axes} [kg·m²]" for axes in ("xx", "yy", "zz", "xy", "xz", "yz")]
        columns = {
            "quantity": ["mass [kg]", *centers, *moments],
            "value": [self.mass, *self.center, *self.inertia],
            "std_error": [self.mass_error, *self.center_error, *self.inertia_error],
        }
        return frame(columns, "quantity")


@explicit(LogOptions)
def payload(
    model: Model,
    log: Any = None,
    *,
    link: str | None = None,
    center: tuple[float, float, float] | None = None,
    progress: Progress = None,
    **options: Unpack[LogOptions],
) -> Payload:
    """Mass, centre and inertia of what hangs on a link, from seconds of motion.

    model is of the arm without it, learned as a chain; link, or its joint, the last if none;
    center [m], in the frame of the link, where it is known: it tells a mass that motion does not.
    """
    log = read_log(log, **options)
    with shown(progress) as told:
        found, hints, loaded = _core.payload(
            model, log, link, None if center is None else list(center), told
        )
    found = json.loads(found)

    def values(key: str, own: str) -> NDArray[np.float64]:
        return np.array([one[own] for one in found[key]])

    return Payload(
        mass=found["mass"]["value"],
        mass_error=found["mass"]["std_error"],
        center=values("center", "value"),
        center_error=values("center", "std_error"),
        inertia=values("inertia", "value"),
        inertia_error=values("inertia", "std_error"),
        link=found["link"],
        rows=found["rows"],
        disagreement=found["disagreement"],
        elsewhere=found["elsewhere"],
        lighter=found["lighter"],
        residual_without=np.array(found["residual_without"]),
        residual_with=np.array(found["residual_with"]),
        hints=hints,
        model=Model(loaded),
    )


@dataclass
class Gains:
    """What a unit of each torque column is worth; each error is one standard error."""

    joints: list[str]
    gains: NDArray[np.float64]
    """Torque for a unit of the column of each joint, such as N·m/A, n."""
    gain_errors: NDArray[np.float64]
    known_mass: float
    """[kg]"""
    apparent_mass: float
    """The mass that the columns would say, if they were in N·m [kg]."""
    rows: int
    hints: list[str]
    """Why gains may be wrong, and what to do."""

    def to_frame(self) -> Any:
        """A frame of pandas with a row for each joint."""
        columns = {"joint": self.joints, "gain": self.gains, "std_error": self.gain_errors}
        return frame(columns, "joint")


@explicit(LogOptions)
def gains(
    model: Model,
    log: Any = None,
    *,
    known_mass: float,
    progress: Progress = None,
    **options: Unpack[LogOptions],
) -> Gains:
    """Gains of drives, from a log with a load of known mass on the last link.

    model is of the arm without it, learned as a chain from the same columns.
    """
    log = read_log(log, **options)
    with shown(progress) as told:
        found, hints = _core.gains(model, log, known_mass, told)
    found = json.loads(found)
    return Gains(
        joints=model.joints,
        gains=np.array([own["value"] for own in found["gains"]]),
        gain_errors=np.array([own["std_error"] for own in found["gains"]]),
        known_mass=found["known_mass"],
        apparent_mass=found["apparent_mass"],
        rows=found["rows"],
        hints=hints,
    )
