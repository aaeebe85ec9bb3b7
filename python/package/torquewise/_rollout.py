"""How far simulated windows of a log drift."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._tables import frame


@dataclass(eq=False)
class Rollout:
    """Distance of simulated windows from the measured motion, after each of k times."""

    joints: list[str]
    horizons: NDArray[np.float64]
    """Since the measured state [s], k."""
    drift: NDArray[np.float64]
    """RMS distance of each joint [rad, or m where it slides] over the windows whose simulation did not
    run away, k×n; infinite where all did."""
    hold: NDArray[np.float64]
    """The same of an arm that keeps its velocity, over all windows."""
    windows: NDArray[np.int64]
    """Windows, k."""
    ran_away: NDArray[np.int64]
    """Those of them whose simulation ran away, k."""
    covered: NDArray[np.float64] | None = None
    """Share of windows that end in the band of 90 % of the samples, k×n."""

    def to_frame(self) -> Any:
        """A frame of pandas with a row for each time and joint."""
        k, n = self.drift.shape
        columns = {"horizon": np.repeat(self.horizons, n), "joint": self.joints * k}
        drift = {"drift": self.drift.ravel(), "hold": self.hold.ravel()}
        drift["ran_away"] = np.repeat(self.ran_away, n)
        covered = {} if self.covered is None else {"covered": self.covered.ravel()}
        return frame({**columns, **drift, **covered})

    def __repr__(self) -> str:
        pairs = [f"{'drift':>10} {f'held, {horizon:g} s':>12}" for horizon in self.horizons]
        lines = [f"{'joint':<20} " + " ".join(pairs)]
        for joint, own in enumerate(self.joints):
            cells = zip(self.drift[:, joint], self.hold[:, joint])
            lines.append(f"{own:<20} " + " ".join(f"{x:>10.4g} {y:>12.4g}" for x, y in cells))
        for horizon, away, windows in zip(self.horizons, self.ran_away, self.windows):
            if away:
                lines.append(f"{away} of {windows} windows ran away within {horizon:g} s")
        return "\n".join(lines)
