"""The loop closed with a model, on a simulated arm."""

from __future__ import annotations

import pathlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._arrays import numbers
from ._model import Model
from ._options import Path
from ._simulation import named_arm
from ._tables import frame


@dataclass(eq=False)
class Tracking:
    """What a controlled arm did, at each of m ticks."""

    joints: list[str]
    t: NDArray[np.float64]
    """Time [s], m."""
    q: NDArray[np.float64]
    """True positions [rad], m×n."""
    dq: NDArray[np.float64]
    """True velocities [rad/s], m×n."""
    error: NDArray[np.float64]
    """Desired less true position [rad], m×n."""
    tau: NDArray[np.float64]
    """Commanded torque [N·m], m×n."""
    hand: NDArray[np.float64]
    """Torque of the hand that leads the arm [N·m], m×n; zeros without one."""
    rms_error: NDArray[np.float64]
    """RMS of the position error of each joint [rad], n, once the loop has settled."""
    peak_error: NDArray[np.float64]
    """The largest [rad], n."""
    saturated: NDArray[np.float64]
    """Share of the ticks at which a joint is at the limit of its torque, n."""

    def to_frame(self) -> Any:
        """A frame of pandas with a row for each tick: q1, …, error1, …, tau1, … over t."""
        signals = {"q": self.q, "error": self.error, "tau": self.tau}
        columns = {
            f"{name}{k + 1}": x[:, k] for name, x in signals.items() for k in range(x.shape[1])
        }
        return frame({"t": self.t, **columns}, index="t")


def control(
    model: Model,
    arm: Path | Model,
    motion: Mapping[str, Any] | None = None,
    *,
    controllers: Sequence[
        Literal["pid", "controller1", "controller2", "computed_torque", "hand_guiding"]
    ] = ("pid", "controller1", "controller2"),
    perfect: bool = False,
    bandwidth: float = 15.0,
    settle: float | None = None,
    seconds: float | None = None,
    rate: float | None = None,
    period: float | None = None,
    speed: float | None = None,
    acceleration: float | None = None,
    seed: int | None = None,
    friction: Path | None = None,
    lock: Sequence[str] = (),
    rotor: float | Sequence[float] = (),
    torque_limit: float | Sequence[float] = (),
    delay: float = 0.0,
    encoder: int = 1 << 20,
    noise: float = 0.0,
    velocity_cutoff: float = 100.0,
    noise_seed: int = 0,
) -> dict[str, Tracking]:
    """Closes the loop with a model on a simulated arm: a dict from controller to how well it tracks.

    One under which the arm runs away is missing there, and warned of.

    arm
        The true one: built-in, a path of a ``.urdf`` or of a ``.toml`` with a DH table, or a model.
    motion
        What is wanted: a dict with t, q, dq and ddq, as :func:`simulate` returns. Without, a smooth
        periodic motion of so many ``seconds`` (16) at ``rate`` (1000) [Hz], with ``period`` (8) [s],
        ``speed`` (1) [rad/s] and ``acceleration`` (2) [rad/s²] at most.
    controllers
        Feedback alone; with what the model knew after its first step; with all it knows; feedback
        linearisation; the model's gravity alone while a hand leads the arm.
    perfect
        Whether controllers 1 and 2 also run with perfect knowledge of the arm.
    bandwidth, settle
        Of the feedback [rad/s]; time before errors count [s], half of the motion without.
    friction, lock, rotor, torque_limit, delay
        Of the arm: a ``.toml`` file, joints of a URDF that are held at 0, inertia of the rotors
        [kg·m²] and largest torque [N·m], one for all or one each; from command to torque [s].
    encoder, noise, velocity_cutoff, noise_seed
        Of the sensors: counts to a turn, 0 for exact positions; standard deviation of a position
        [rad]; cut-off of the velocity [Hz].
    """
    waves = {"seconds": seconds, "period": period, "rate": rate, "speed": speed}
    waves["acceleration"] = acceleration
    own = None
    if motion is not None:
        given = [name for name, own in {**waves, "seed": seed}.items() if own is not None]
        if given:
            raise ValueError(f"{', '.join(given)} would be ignored beside a motion: leave it out")
        missing = [name for name in ("t", "q", "dq", "ddq") if name not in motion]
        if missing:
            raise ValueError(f"motion: expected t, q, dq and ddq, {missing[0]} is missing")
        t, *rows = (numbers(motion[name]) for name in ("t", "q", "dq", "ddq"))
        own = (t.tolist(), *rows)
    found = _core.control(
        model,
        named_arm(arm),
        wanted=own,
        waves=list(waves.values()),
        seed=seed or 0,
        controllers=list(controllers),
        perfect=perfect,
        bandwidth=bandwidth,
        settle=settle,
        friction=None if friction is None else pathlib.Path(friction).read_text(),
        lock=list(lock),
        rotor=np.atleast_1d(numbers(rotor)).tolist(),
        torque_limit=np.atleast_1d(numbers(torque_limit)).tolist(),
        delay=delay,
        sensors=(encoder, noise, velocity_cutoff, noise_seed),
    )
    return {name: Tracking(joints=model.joints, **own) for name, own in found}
