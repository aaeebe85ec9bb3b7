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
    """RMS distance of each joint [rad], k×n; infinite where a simulation ran away."""
    hold: NDArray[np.float64]
    """The same of an arm that keeps its velocity."""
    windows: NDArray[np.int64]
    """Windows, k."""
    covered: NDArray[np.float64] | None = None
    """Share of windows that end in the band of 90 % of the samples, k×n."""

    def to_frame(self) -> Any:
        """A frame of pandas with a row for each time and joint."""
        k, n = self.drift.shape
        columns = {"horizon": np.repeat(self.horizons, n), "joint": self.joints * k}
        drift = {"drift": self.drift.ravel(), "hold": self.hold.ravel()}
        covered = {} if self.covered is None else {"covered": self.covered.ravel()}
        return frame({**columns, **drift, **covered})
