"""Options of a fit that are plain values, as the engine lists them: written by its tests."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypedDict


class EngineOptions(TypedDict, total=False):
    """Keywords of :func:`torquewise.fit` that are plain values."""

    library: Literal["energy", "product", "chain"] | None
    method: Literal["stepwise", "sindy"] | None
    friction: Literal["none", "linear", "stribeck", "auto"] | None
    kinds: str | None
    counterbalance: Sequence[str] | None
    refine: Literal["rollout"] | None
    select: Literal["bic", "lasso", "stlsq"] | None
    threshold: float | None
    noise_correction: bool | None
    activation: Literal["scaled", "paper"] | None
    n_bootstrap: int | None
    interaction: int | None
    trig_order: int | None
    gravity_order: int | None
    clusters: int | None
    seed: int | None
