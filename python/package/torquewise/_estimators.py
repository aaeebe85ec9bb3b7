"""Estimators in the manner of scikit-learn, with the words of PySINDy.

They are estimators of scikit-learn where it is installed, and follow its conventions where it is not.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._fit import Fit, fit
from ._log import Log
from ._model import Model
from ._options import Path
from ._parameters import Base

if TYPE_CHECKING:
    from typing_extensions import Self

_Array = NDArray[np.float64]


class _Estimator(Base):
    """What all estimators share; the parameters are those of `__init__`."""

    _fixed: dict[str, Any] = {}
    rate: float

    fit_: Fit
    model_: Model
    n_joints_: int
    n_features_in_: int

    def fit(
        self,
        *motion: Any,
        t: ArrayLike | None = None,
        groups: ArrayLike | None = None,
        **others: Any,
    ) -> Self:
        """Fits the model; returns the estimator.

        motion
            (q, dq, ddq, tau), m×n each; or (X, y), X = [q dq ddq] side by side, m×3n, or in any order
            in a frame with columns of the names q1, dq1, …, and y = tau, m×n; or one motion, a dict with these arrays or a log; or a list of motions, a trajectory each.
            Rows are in the order of time.
        t
            Time stamps [s], m; without, rows are `1 / rate` apart.
        groups
            Numbers that change where another trajectory begins, m.
        """
        if others:
            raise TypeError(
                f"fit takes no {', '.join(others)}: all rows count, by the noise of the log; leave out "
                "those that should not, and say by groups where rows are missing"
            )
        vars(self).pop("feature_names_in_", None)
        log, is_whole = self._log(motion, t, groups)
        options = {name: value for name, value in self.get_params().items() if name != "rate"}
        options.update(self._fixed, filter="none" if is_whole else "auto")
        self.fit_ = fit(log, progress=False, **options)
        self.model_ = self.fit_.model
        self.n_joints_ = len(self.model_.joints)
        self.n_features_in_ = 3 * self.n_joints_
        return self

    def predict(self, *motion: Any) -> Any:
        """tau [N·m], m×n, of (q, dq, ddq), of X = [q dq ddq], or of a motion; a list for a list."""
        self._check_fitted()
        if len(motion) == 1 and isinstance(motion[0], (list, tuple)) and _are_motions(motion[0]):
            return [self.predict(own) for own in motion[0]]
        if len(motion) == 1 and isinstance(motion[0], Mapping):
            own = motion[0]
            return self.model_.torque(own["q"], own["dq"], own["ddq"])
        if len(motion) == 1:
            q, dq, ddq = np.split(self._columns(motion[0]), 3, axis=1)
            tau = self.model_.torque(q, dq, ddq)
            return tau[:, 0] if getattr(self, "_is_flat", False) else tau
        if len(motion) != 3:
            raise TypeError("predict takes q, dq, ddq, or X = [q dq ddq], or a motion")
        return self.model_.torque(*motion)

    def score(self, *motion: Any, sample_weight: ArrayLike | None = None) -> float:
        """R² of the torque, mean of the joints: of (X, y), (q, dq, ddq, tau) or a motion."""
        motions = motion[0] if len(motion) == 1 and isinstance(motion[0], (list, tuple)) else None
        if motions is None and len(motion) == 1:
            motions = [motion[0]]
        if motions is not None:
            truth = np.concatenate([np.asarray(own["tau"]) for own in motions])
            found = np.concatenate([self.predict(own) for own in motions])
        else:
            *state, truth = motion
            found = self.predict(*state)
        truth = np.asarray(truth, dtype=float)
        weight = np.ones(len(truth)) if sample_weight is None else np.asarray(sample_weight)
        weight = weight if truth.ndim == 1 else weight[:, None]
        mean = (weight * truth).sum(axis=0) / weight.sum(axis=0)
        left = (weight * (truth - found) ** 2).sum(axis=0)
        total = (weight * (truth - mean) ** 2).sum(axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):
            r2 = np.where(total > 0, 1 - left / total, np.where(left > 0, 0.0, 1.0))
        return float(np.mean(r2))

    # The words of PySINDy.

    def equations(self, precision: int = 3) -> list[str]:
        """The torque of each joint as text."""
        self._check_fitted()
        return self.model_.equations(precision)

    def print(self, precision: int = 3) -> None:
        """Prints the torque of each joint."""
        self._check_fitted()
        self.model_.print(precision)

    def coefficients(self) -> _Array:
        """Coefficients, n joints × terms."""
        self._check_fitted()
        return self.model_.coefficients()

    def get_feature_names(self) -> list[str]:
        """Names of the terms."""
        self._check_fitted()
        return self.model_.get_feature_names()

    @property
    def complexity(self) -> int:
        """Number of coefficients of the model."""
        self._check_fitted()
        return self.model_.complexity

    # Conventions.

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()  # type: ignore[misc]
        tags.regressor_tags.poor_score = True
        return tags

    def __sklearn_is_fitted__(self) -> bool:
        return hasattr(self, "model_")

    def __getstate__(self) -> dict[str, Any]:
        inherited: Any = getattr(super(), "__getstate__", None)
        state: dict[str, Any] = dict((inherited and inherited()) or self.__dict__)
        # How it was found stays behind; the model goes along.
        state.pop("fit_", None)
        return state

    def _check_fitted(self) -> None:
        if hasattr(self, "model_"):
            return
        message = f"This {type(self).__name__} instance is not fitted yet: call fit first"
        try:
            from sklearn.exceptions import NotFittedError
        except ImportError:
            raise AttributeError(message) from None
        raise NotFittedError(message)

    def _columns(self, table: Any) -> _Array:
        """q, dq and ddq side by side, of a table whose columns are those that were fitted."""
        names, known = _names_of(table), getattr(self, "feature_names_in_", None)
        if known is not None and names is not None and list(known) != names:
            raise ValueError(
                "The feature names should match those that were passed during fit: expected "
                f"{', '.join(known)}, found {', '.join(names)}"
            )
        rows = _rows(table)
        if rows.shape[1] != self.n_features_in_:
            raise ValueError(
                f"X has {rows.shape[1]} features, but {type(self).__name__} is expecting "
                f"{self.n_features_in_} features as input: q, dq and ddq side by side"
            )
        return rows[:, _order(names if names is not None else known)]

    def _log(
        self, motion: tuple[Any, ...], t: ArrayLike | None, groups: ArrayLike | None
    ) -> tuple[Any, bool]:
        """What is fitted, and whether its q, dq and ddq are at hand."""
        self._is_flat = False
        if len(motion) == 1:
            own = motion[0]
            if _are_motions(own):
                return [self._timed(one) for one in own], True
            if isinstance(own, Mapping):
                return [self._timed(own)], True
            if isinstance(own, (Log, str)) or hasattr(own, "__fspath__"):
                return own, False
            raise ValueError("requires y to be passed, but the target y is None")
        if len(motion) == 2:
            rows, truth = motion
            if truth is None:
                raise ValueError("requires y to be passed, but the target y is None")
            names = _names_of(rows)
            rows = _rows(rows)
            truth = np.asarray(truth, dtype=float)
            self._is_flat = truth.ndim == 1
            truth = truth.reshape(len(truth), -1)
            if rows.shape[1] != 3 * truth.shape[1]:
                raise ValueError(
                    f"X has {rows.shape[1]} columns, y has {truth.shape[1]}: X is q, dq and ddq side "
                    "by side, three columns for each of y"
                )
            if names is not None:
                self.feature_names_in_ = np.array(names, dtype=object)
            motion = (*np.split(rows[:, _order(names)], 3, axis=1), truth)
        if len(motion) != 4:
            raise TypeError("fit takes q, dq, ddq, tau, or X, y, or a motion, or a list of motions")
        q, dq, ddq, tau = (_rows(own) for own in motion)
        _check_order(q, dq)
        whole = {"q": q, "dq": dq, "ddq": ddq, "tau": tau}
        if t is not None:
            whole["t"] = np.asarray(t, dtype=float)
        if groups is None:
            return [self._timed(whole)], True
        groups = np.asarray(groups)
        ends = np.flatnonzero(groups[1:] != groups[:-1]) + 1
        cuts = list(zip([0, *ends], [*ends, len(groups)]))
        return [self._timed({k: v[a:b] for k, v in whole.items()}) for a, b in cuts], True

    def _timed(self, motion: Mapping[str, Any]) -> Mapping[str, Any]:
        if "t" in motion:
            return motion
        if "q" not in motion:
            raise ValueError("a motion without q: give a dict of q, dq, ddq, tau, and perhaps t")
        rows = len(motion["q"])
        return {**motion, "t": np.arange(rows) / float(self.rate)}


def _names_of(table: Any) -> list[str] | None:
    """Names of the columns of a frame, if all of them are text."""
    names = list(getattr(table, "columns", ()))
    return names if names and all(isinstance(name, str) for name in names) else None


def _order(names: Any) -> Any:
    """Places of q1, q2, … dq1, … ddq1, … among columns; as they are, if they have other names."""
    keys = [re.fullmatch(r"(q|dq|ddq)(\d+)", name) for name in (() if names is None else names)]
    found = [(len(own[1]), int(own[2])) for own in keys if own is not None]
    if not keys or len(found) < len(keys):
        return slice(None)
    n = len(found) // 3
    if sorted(found) != [(kind, k) for kind in (1, 2, 3) for k in range(1, n + 1)]:
        raise ValueError(
            f"X has the columns {', '.join(names or ())}: expected q1 … qn, dq1 … dqn and ddq1 … ddqn"
        )
    return sorted(range(len(found)), key=found.__getitem__)


def _are_motions(own: Any) -> bool:
    return isinstance(own, (list, tuple)) and bool(own) and all(isinstance(x, Mapping) for x in own)


def _rows(values: Any) -> _Array:
    if hasattr(values, "toarray"):
        raise TypeError(
            "Sparse data was passed, but dense data is required: q, dq and ddq are dense"
        )
    found: NDArray[Any] = np.asarray(values)
    if np.iscomplexobj(found):
        raise ValueError("Complex data not supported: angles are real")
    found = found.astype(np.float64, copy=False)
    if found.ndim == 0 or found.size == 0:
        raise ValueError(
            f"Found array with {found.size} sample(s) while a minimum of 1 is required."
        )
    if found.ndim == 1:
        raise ValueError(
            "Expected 2D array, got 1D array instead. Reshape your data: one row a state"
        )
    if not np.isfinite(found).all():
        raise ValueError("Input contains NaN, infinity or a value too large: drop such rows")
    return found


def _check_order(q: _Array, dq: _Array) -> None:
    """Warns where positions jump from row to row as those of a moving arm do not."""
    steps, spread = np.diff(q, axis=0).std(axis=0), q.std(axis=0)
    if len(q) > 10 and dq.any() and np.median(steps) > 0.7 * np.median(spread) > 0.0:
        warnings.warn(
            "positions jump from row to row: if they were shuffled, give them in the order of time",
            stacklevel=4,
        )


class Stepwise(_Estimator):
    """Energies M(q) and V(q), or products, reconstructed step by step as the log is active.

    Gravity from standstill, Coriolis from uniform velocity, inertia from variable velocity. For
    parameters see :func:`torquewise.fit`; `rate` is that of rows without time stamps [Hz].
    """

    _fixed = {"method": "stepwise"}

    def __init__(
        self,
        library: Literal["energy", "product"] = "energy",
        friction: Literal["none", "linear", "stribeck", "auto"] | None = None,
        interaction: int | None = None,
        trig_order: int | None = None,
        gravity_order: int | None = None,
        select: Literal["bic", "lasso", "stlsq"] | None = None,
        threshold: float | None = None,
        n_bootstrap: int | None = None,
        noise_correction: bool = True,
        seed: int = 0,
        rate: float = 100.0,
        kinds: str | None = None,
    ):
        self.library = library
        self.friction = friction
        self.interaction = interaction
        self.trig_order = trig_order
        self.gravity_order = gravity_order
        self.select = select
        self.threshold = threshold
        self.n_bootstrap = n_bootstrap
        self.noise_correction = noise_correction
        self.seed = seed
        self.rate = rate
        self.kinds = kinds


class Chain(_Estimator):
    """A chain of rigid bodies whose geometry is learned too, with friction: for many joints, noise.

    Rows are fitted as they are, in the order of time: q, dq, ddq and tau are to be filtered alike
    before, and not scaled. A log (:func:`torquewise.read_log`) is filtered as :func:`torquewise.fit`
    does it. `fit_.verdict` says whether the model may be used.

    For parameters see :func:`torquewise.fit`; `rate` is that of rows without time stamps [Hz].
    """

    _fixed = {"library": "chain"}

    def __init__(
        self,
        friction: Literal["none", "linear", "stribeck", "auto"] | None = None,
        urdf: Path | None = None,
        counterbalance: Sequence[str] | None = None,
        refine: Literal["rollout"] | None = None,
        noise_correction: bool = True,
        seed: int = 0,
        rate: float = 100.0,
        kinds: str | None = None,
    ):
        self.friction = friction
        self.urdf = urdf
        self.counterbalance = counterbalance
        self.refine = refine
        self.noise_correction = noise_correction
        self.seed = seed
        self.rate = rate
        self.kinds = kinds


class OneShot(_Estimator):
    """The baseline, one-shot SINDy: products of sines, cosines, velocities and accelerations, on all rows at once.

    For parameters see :func:`torquewise.fit`; `rate` is that of rows without time stamps [Hz].
    """

    _fixed = {"method": "sindy"}

    def __init__(
        self,
        trig_order: int | None = None,
        select: Literal["bic", "lasso", "stlsq"] | None = None,
        threshold: float | None = None,
        seed: int = 0,
        rate: float = 100.0,
        kinds: str | None = None,
    ):
        self.trig_order = trig_order
        self.select = select
        self.threshold = threshold
        self.seed = seed
        self.rate = rate
        self.kinds = kinds
