"""Arms of known truth, and motions to record."""

from __future__ import annotations

import os
import pathlib
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from . import _core
from ._log import write_log
from ._model import Model
from ._options import Path, Progress
from ._progress import shown
from ._tables import Trajectory

CASES = {2: (70.0, 50.0, 30.0), 3: (60.0, 40.0, 30.0)}


def arms() -> dict[str, int]:
    """The built-in arms: a dict from name to number of joints."""
    return dict(_core.arms())


def simulate(
    arm: Path | Model,
    *,
    motion: Literal["moves", "sines", "staged"] = "moves",
    seconds: float | None = None,
    rate: float | None = None,
    seed: int = 0,
    case: Literal[1, 2, 3] = 1,
    noise_db: Sequence[float] | None = None,
    friction: Path | None = None,
    lock: Sequence[str] = (),
    path: Path | None = None,
) -> Trajectory:
    """Moves an arm and records its torque: a dict with t, q, dq, ddq, tau and joints.

    arm
        A built-in arm, a path of a ``.urdf`` or of a ``.toml`` with a DH table, or a model: the twin
        of the robot it was learned from.
    motion
        ``"moves"`` (dwell, accelerate, cruise, brake), ``"sines"`` or ``"staged"``.
    case, noise_db
        Noise of the paper, 1 none; or signal-to-noise ratios of q, dq, ddq [dB].
    friction
        A ``.toml`` file with the friction of the joints.
    path
        A log to write, ``.csv`` or ``.parquet``.
    """
    if noise_db is None and case != 1:
        if case not in CASES:
            raise ValueError("case: expected 1, 2 or 3")
        noise_db = CASES[case]
    joints, arrays = _core.simulate(
        named_arm(arm),
        motion=motion,
        seconds=seconds,
        rate=rate,
        seed=seed,
        noise_db=None if noise_db is None else list(noise_db),
        friction=None if friction is None else pathlib.Path(friction).read_text(),
        lock=list(lock),
    )
    found = Trajectory(arrays, joints=joints)
    if path is not None:
        write_log(path, found)
    return found


def excite(
    arm: Path | Model,
    *,
    seconds: Sequence[float] | None = None,
    dwell: float | None = None,
    slow_sweeps: bool = False,
    range: Mapping[str, tuple[float, float]] | tuple[float, float] | None = None,
    margin: float | None = None,
    max_velocity: Mapping[str, float] | float | None = None,
    max_acceleration: Mapping[str, float] | float | None = None,
    torque_limit: Mapping[str, float] | float | None = None,
    speed_scale: float | None = None,
    home: Sequence[float] | None = None,
    lock: Sequence[str] = (),
    interaction: int | None = None,
    tries: int | None = None,
    rate: float | None = None,
    ros_rate: float = 20.0,
    seed: int = 0,
    progress: Progress = None,
) -> list[Trajectory]:
    """Plans the recordings from which a model can be reconstructed: a list of three dicts.

    Each has a name, t, q, dq, ddq, and joint_trajectory, the text of a ROS 2 message.

    seconds, dwell, slow_sweeps
        Of the recordings of standstill, uniform and variable velocity [s]; of each pose [s]; whether
        each joint also moves at many slow speeds, for friction.
    range, margin
        A dict from joint to (from, to) [rad], or one pair for all; distance that is kept from both, as
        a share of the way between them.
    max_velocity, max_acceleration, speed_scale
        A dict from joint to number, or one for all [rad/s], [rad/s²]; factor of all speeds.
    torque_limit
        The same of the torques [N·m]: all is slowed until they are kept, those of a model with its
        friction.
    home, lock
        Pose at both ends [rad]; joints of a URDF that are held at 0.
    interaction, tries, seed
        How many joints move at once; how many plans are drawn, the best of which is kept.
    rate, ros_rate
        Rows per second of the arrays, and of the message [Hz].
    """
    with shown(progress) as told:
        planned = _core.excite(
            named_arm(arm),
            seconds=None if seconds is None else list(seconds),
            dwell=dwell,
            slow_sweeps=slow_sweeps,
            range=_wishes(range),
            margin=margin,
            max_velocity=_wishes(max_velocity),
            max_acceleration=_wishes(max_acceleration),
            torque_limit=_wishes(torque_limit),
            speed_scale=speed_scale,
            home=None if home is None else list(home),
            lock=list(lock),
            interaction=interaction,
            tries=tries,
            rate=rate,
            ros_rate=ros_rate,
            seed=seed,
            progress=told,
        )
    return [Trajectory(own) for own in planned]


def named_arm(arm: Path | Model) -> str | Model:
    return os.fspath(arm) if isinstance(arm, (str, os.PathLike)) else arm


def _wishes(values: Any) -> list[tuple[str | None, Any]]:
    if values is None:
        return []
    return list(values.items()) if isinstance(values, Mapping) else [(None, values)]
