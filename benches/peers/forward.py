"""Windows of a log that are simulated from their measured state with the measured torque.

Windows, times and the handling of dry friction are those of `torquewise evaluate --rollout`.
"""

from dataclasses import dataclass

import numpy as np

STEP = 1e-3  # [s]
HORIZON = 0.5  # [s]
MOST_WINDOWS = 200
GAP = 1.5  # usual steps between rows that are of one window
ROUNDS = 50
AGREED = 1e-9  # [rad/s]
HELD = 1e-7  # [rad/s]


@dataclass
class Window:
    """A state, the torque at the middle of each step after it, and where the arm was at the end."""

    q: np.ndarray
    dq: np.ndarray
    tau: np.ndarray
    end: np.ndarray


def between(t, x, at):
    return np.stack([np.interp(at, t, column) for column in x.T], axis=-1)


def windows(trajectories):
    """All windows of some trajectories that were filtered."""
    found = []
    for own in trajectories:
        t = own["t"]
        breaks = np.flatnonzero(np.diff(t) >= GAP * (t[1] - t[0])) + 1
        for rows in np.split(np.arange(len(t)), breaks):
            if t[rows[-1]] - t[rows[0]] < HORIZON:
                continue
            apart = max(0.5 * HORIZON, (t[rows[-1]] - t[rows[0]] - HORIZON) / MOST_WINDOWS)
            after = t[rows[0]]
            for row in rows:
                if t[row] >= after and t[row] + HORIZON <= t[rows[-1]]:
                    middles = t[row] + STEP * (np.arange(round(HORIZON / STEP)) + 0.5)
                    tau = between(t, own["tau"], middles)
                    end = between(t, own["q"], [t[row] + HORIZON])[0]
                    found.append(Window(own["q"][row], own["dq"][row], tau, end))
                    after = t[row] + apart
    return found


def drift(trajectories, simulate):
    """RMS drift of each joint after half a second, over that of an arm that keeps its velocity."""
    some = windows(trajectories)
    if not some:
        return None
    with np.errstate(all="ignore"):
        missed = np.array([simulate(own) - own.end for own in some])
        held = np.array([own.q + HORIZON * own.dq - own.end for own in some])
        ratio = np.sqrt((missed**2).mean(axis=0) / (held**2).mean(axis=0))
    return [x if np.isfinite(x) else None for x in ratio.tolist()]


class RegressorArm:
    """An arm of base parameters, which may be no physical one, with plain friction."""

    def __init__(self, bodies, parameters, friction):
        """friction: of each joint offset, viscous, dry, half width of the reversal, rotor."""
        self.bodies, self.parameters = bodies, parameters
        self.offset, self.viscous, self.dry, self.width, self.rotor = np.array(friction).T

    def rigid(self, q, dq, ddq):
        return self.bodies(q, dq, ddq) @ self.parameters

    def mass_matrix(self, q):
        rest = np.zeros_like(q)
        gravity = self.rigid(q, rest, rest)
        columns = [self.rigid(q, rest, one) - gravity for one in np.eye(len(q))]
        return np.stack(columns, axis=-1) + np.diag(self.rotor)

    def end(self, window):
        """Where a window leads; the midpoint rule, dry friction that of the end of a step."""
        q, dq, ddq = window.q.copy(), window.dq.copy(), np.zeros_like(window.q)
        for tau in window.tau:
            middle, ahead = q + 0.5 * STEP * dq, dq + 0.5 * STEP * ddq
            mass = self.mass_matrix(middle)
            pushed = tau - self.rigid(middle, ahead, np.zeros_like(q)) - self.offset
            right, speed = mass @ dq + STEP * pushed, dq + STEP * ddq
            for _ in range(ROUNDS):
                size = np.maximum(np.abs(speed), HELD)
                slope = self.viscous + self.dry * np.tanh(size / self.width) / size
                before = speed
                speed = np.linalg.solve(mass + STEP * np.diag(slope), right)
                if not np.isfinite(speed).all() or np.abs(speed).max() > 1e3:
                    return np.full_like(q, np.inf)
                if np.abs(speed - before).max() < AGREED:
                    break
            q += 0.5 * STEP * (dq + speed)
            ddq, dq = (speed - dq) / STEP, speed
        return q
