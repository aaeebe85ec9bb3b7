"""Estimators in the manner of scikit-learn, with the words of PySINDy.

scikit-learn need not be installed: they follow its conventions without it.
"""

import inspect
from collections.abc import Mapping

import numpy as np

from ._fit import fit
from ._log import Log


class _Estimator:
    """What all estimators share; the parameters are those of `__init__`."""

    _fixed: dict[str, str] = {}

    @classmethod
    def _names(cls):
        return sorted(set(inspect.signature(cls.__init__).parameters) - {"self"})

    def get_params(self, deep=True):
        """The parameters of this estimator, by name."""
        return {name: getattr(self, name) for name in self._names()}

    def set_params(self, **params):
        """Sets parameters; returns the estimator."""
        for name, value in params.items():
            if name not in self._names():
                raise ValueError(
                    f"{name!r} is no parameter of {type(self).__name__}: expected one of "
                    f"{', '.join(self._names())}"
                )
            setattr(self, name, value)
        return self

    def fit(self, *motion, t=None, groups=None):
        """Fits the model; returns the estimator.

        motion
            (q, dq, ddq, tau), m×n each; or (X, y), X = [q dq ddq] side by side, m×3n, y = tau, m×n;
            or one motion, a dict with these arrays or a log; or a list of motions, a trajectory each.
            Rows are in the order of time.
        t
            Time stamps [s], m; without, rows are `1 / rate` apart.
        groups
            Numbers that change where another trajectory begins, m.
        """
        log, n_features = self._log(motion, t, groups)
        options = {name: value for name, value in self.get_params().items() if name != "rate"}
        found = fit(
            log, filter="none" if n_features else "auto", progress=False, **options, **self._fixed
        )
        self.fit_ = found
        self.model_ = found.model
        self.n_joints_ = len(self.model_.joints)
        self.n_features_in_ = 3 * self.n_joints_
        return self

    def predict(self, *motion):
        """tau [N·m], m×n, of (q, dq, ddq), of X = [q dq ddq], or of a motion; a list for a list."""
        self._check_fitted()
        if len(motion) == 1 and isinstance(motion[0], (list, tuple)) and _are_motions(motion[0]):
            return [self.predict(own) for own in motion[0]]
        if len(motion) == 1 and isinstance(motion[0], Mapping):
            own = motion[0]
            return self.model_.torque(own["q"], own["dq"], own["ddq"])
        if len(motion) == 1:
            q, dq, ddq = self._split(motion[0])
            tau = self.model_.torque(q, dq, ddq)
            return tau[:, 0] if getattr(self, "_is_flat", False) else tau
        if len(motion) != 3:
            raise TypeError("predict takes q, dq, ddq, or X = [q dq ddq], or a motion")
        return self.model_.torque(*motion)

    def score(self, *motion, sample_weight=None):
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

    def equations(self, precision=3):
        """The torque of each joint as text."""
        self._check_fitted()
        return self.model_.equations(precision)

    def print(self, precision=3):
        """Prints the torque of each joint."""
        self._check_fitted()
        self.model_.print(precision)

    def coefficients(self):
        """Coefficients, n joints × terms."""
        self._check_fitted()
        return self.model_.coefficients()

    def get_feature_names(self):
        """Names of the terms."""
        self._check_fitted()
        return self.model_.get_feature_names()

    @property
    def complexity(self):
        """Number of coefficients of the model."""
        self._check_fitted()
        return self.model_.complexity

    # Conventions.

    def __repr__(self):
        usual = inspect.signature(type(self).__init__).parameters
        given = [
            f"{name}={value!r}"
            for name, value in self.get_params().items()
            if value is not usual[name].default and value != usual[name].default
        ]
        return f"{type(self).__name__}({', '.join(given)})"

    def __sklearn_tags__(self):
        from sklearn.utils import InputTags, RegressorTags, Tags, TargetTags

        return Tags(
            estimator_type="regressor",
            target_tags=TargetTags(required=True, multi_output=True),
            regressor_tags=RegressorTags(poor_score=True),
            input_tags=InputTags(two_d_array=True),
        )

    def __sklearn_is_fitted__(self):
        return hasattr(self, "model_")

    def __getstate__(self):
        state = dict(self.__dict__)
        # How it was found stays behind; the model goes along.
        state.pop("fit_", None)
        return state

    def _check_fitted(self):
        if hasattr(self, "model_"):
            return
        message = f"This {type(self).__name__} instance is not fitted yet: call fit first"
        try:
            from sklearn.exceptions import NotFittedError
        except ImportError:
            raise AttributeError(message) from None
        raise NotFittedError(message)

    def _split(self, rows):
        rows = _rows(rows)
        if rows.shape[1] != self.n_features_in_:
            raise ValueError(
                f"X has {rows.shape[1]} features, but {type(self).__name__} is expecting "
                f"{self.n_features_in_} features as input: q, dq and ddq side by side"
            )
        return np.split(rows, 3, axis=1)

    def _log(self, motion, t, groups):
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
            rows = _rows(rows)
            truth = np.asarray(truth, dtype=float)
            self._is_flat = truth.ndim == 1
            truth = truth.reshape(len(truth), -1)
            if rows.shape[1] != 3 * truth.shape[1]:
                raise ValueError(
                    f"X has {rows.shape[1]} columns, y has {truth.shape[1]}: X is q, dq and ddq side "
                    "by side, three columns for each of y"
                )
            motion = (*np.split(rows, 3, axis=1), truth)
        if len(motion) != 4:
            raise TypeError("fit takes q, dq, ddq, tau, or X, y, or a motion, or a list of motions")
        q, dq, ddq, tau = (_rows(own) for own in motion)
        whole = {"q": q, "dq": dq, "ddq": ddq, "tau": tau}
        if t is not None:
            whole["t"] = np.asarray(t, dtype=float)
        if groups is None:
            return [self._timed(whole)], True
        groups = np.asarray(groups)
        ends = np.flatnonzero(groups[1:] != groups[:-1]) + 1
        cuts = list(zip([0, *ends], [*ends, len(groups)]))
        return [self._timed({k: v[a:b] for k, v in whole.items()}) for a, b in cuts], True

    def _timed(self, motion):
        if "t" in motion:
            return motion
        rows = len(motion["q"])
        return {**motion, "t": np.arange(rows) / float(self.rate)}


def _are_motions(own):
    return isinstance(own, (list, tuple)) and bool(own) and all(isinstance(x, Mapping) for x in own)


def _rows(values):
    if hasattr(values, "toarray"):
        raise TypeError(
            "Sparse data was passed, but dense data is required: q, dq and ddq are dense"
        )
    values = np.asarray(values)
    if np.iscomplexobj(values):
        raise ValueError("Complex data not supported: angles are real")
    values = values.astype(float, copy=False)
    if values.ndim == 0 or values.size == 0:
        raise ValueError(
            f"Found array with {values.size} sample(s) while a minimum of 1 is required."
        )
    if values.ndim == 1:
        raise ValueError(
            "Expected 2D array, got 1D array instead. Reshape your data: one row a state"
        )
    if not np.isfinite(values).all():
        raise ValueError("Input contains NaN, infinity or a value too large: drop such rows")
    return values


class Stepwise(_Estimator):
    """Energies M(q) and V(q), or products, reconstructed step by step as the log is active.

    Gravity from standstill, Coriolis from uniform velocity, inertia from variable velocity. For
    parameters see :func:`torquewise.fit`; `rate` is that of rows without time stamps [Hz].
    """

    _fixed = {"method": "stepwise"}

    def __init__(
        self,
        library="energy",
        friction=None,
        interaction=None,
        trig_order=None,
        gravity_order=None,
        select=None,
        threshold=None,
        n_bootstrap=None,
        noise_correction=True,
        seed=0,
        rate=100.0,
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


class Chain(_Estimator):
    """A chain of rigid bodies whose geometry is learned too, with friction: for many joints, noise.

    For parameters see :func:`torquewise.fit`; `rate` is that of rows without time stamps [Hz].
    """

    _fixed = {"library": "chain"}

    def __init__(
        self,
        friction=None,
        urdf=None,
        counterbalance=None,
        noise_correction=True,
        seed=0,
        rate=100.0,
        kinds=None,
    ):
        self.friction = friction
        self.urdf = urdf
        self.counterbalance = counterbalance
        self.noise_correction = noise_correction
        self.seed = seed
        self.rate = rate
        self.kinds = kinds


class SINDy(_Estimator):
    """One-shot SINDy: products of sines, cosines, velocities and accelerations, on all rows at once.

    For parameters see :func:`torquewise.fit`; `rate` is that of rows without time stamps [Hz].
    """

    _fixed = {"method": "sindy"}

    def __init__(self, trig_order=None, select=None, threshold=None, seed=0, rate=100.0):
        self.trig_order = trig_order
        self.select = select
        self.threshold = threshold
        self.seed = seed
        self.rate = rate
