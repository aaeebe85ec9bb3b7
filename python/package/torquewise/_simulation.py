"""Arms of known truth, and motions to record."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

from . import _core
from ._log import Path, write_log
from ._model import Model

CASES = {2: (70.0, 50.0, 30.0), 3: (60.0, 40.0, 30.0)}


def arms() -> dict[str, int]:
    """The built-in arms: a dict from name to number of joints."""
    return dict(_core.arms())


def simulate(
    arm: Path | Model,
    *,
    motion: str = "moves",
    seconds: float | None = None,
    rate: float | None = None,
    seed: int = 0,
    case: int = 1,
    noise_db: Sequence[float] | None = None,
    friction: Path | None = None,
    lock: Sequence[str] = (),
    path: Path | None = None,
) -> dict[str, Any]:
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
    if friction is not None:
        with open(friction) as file:
            friction = file.read()
    joints, found = _core.simulate(
        _named(arm),
        motion=motion,
        seconds=seconds,
        rate=rate,
        seed=seed,
        noise_db=None if noise_db is None else list(noise_db),
        friction=friction,
        lock=list(lock),
    )
    found["joints"] = joints
    if path is not None:
        write_log(path, found)
    return found


def excite(arm: Path | Model, **options: Any) -> list[dict[str, Any]]:
    """Plans the recordings from which a model can be reconstructed: a list of three dicts.

    Each has a name, t, q, dq, ddq, and joint_trajectory, the text of a ROS 2 message. Options are
    those of ``torquewise excite``: seconds (of the three recordings), dwell, slow_sweeps, range
    (a dict from joint to (from, to), or one pair for all), margin, max_velocity, max_acceleration
    (a dict, or one number), speed_scale, home, lock, interaction, tries, rate, ros_rate, seed.
    """
    for key in ("range", "max_velocity", "max_acceleration"):
        if options.get(key) is not None:
            options[key] = _wishes(options[key])
    return _core.excite(_named(arm), **options)


def _named(arm):
    return os.fspath(arm) if isinstance(arm, (str, os.PathLike)) else arm


def _wishes(values):
    return list(values.items()) if isinstance(values, dict) else [(None, values)]
