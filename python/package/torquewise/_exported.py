"""The equations of motion in other programs."""

from __future__ import annotations

import math
import types
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _core
from ._options import ExportOptions, RobotOptions, explicit
from ._options import Path as _Path

if TYPE_CHECKING:
    from ._options import Unpack

_ENDINGS = {
    ".c": "c",
    ".h": "c",
    ".rs": "rust",
    ".py": "python",
    ".tex": "latex",
    ".fmu": "fmu",
    ".urdf": "urdf",
    ".xml": "mjcf",
    ".mjcf": "mjcf",
}


class Exported(_core.Model):
    """A model that other programs take."""

    @explicit(ExportOptions)
    def export(
        self, path: _Path, to: str | None = None, **options: Unpack[ExportOptions]
    ) -> list[str]:
        """Writes the model for another program; returns what the file has no room for.

        to
            ``c``, ``rust``, ``python``, ``latex``, ``fmu``, ``ros2``, ``urdf``, ``mjcf``,
            ``isaaclab`` or ``json``; by default as the ending of `path` says. For ros2 and samples
            `path` is a new folder.
        name
            What the functions of C, an FMU or a ROS 2 package begin with; the name of the file.
        precision, reversal, binary, force
            ``"float"`` for 32 bits; half width of the reversal of friction [rad/s]; False for an FMU
            of sources; True for a model whose M(q) is not positive definite.
        onto, lock
            URDF file that inertia and friction are put into, and its joints that are held at 0.
        samples, seed
            So many models in place of the one, see :meth:`samples`.
        """
        path = Path(path)
        to = to or _target(path)
        options.setdefault("name", path.stem)
        files, left_out = self._files(to, 2, **options)
        if "" in files:
            _core.write_whole(path, files[""])
            return left_out
        if path.exists() and any(path.iterdir()):
            raise FileExistsError(f"{path} exists and is not empty: name a new folder")
        for own, content in files.items():
            (path / own).parent.mkdir(parents=True, exist_ok=True)
            _core.write_whole(path / own, content)
        return left_out

    def _files(
        self, to: str, told: int = 0, name: str = "arm", onto: _Path | None = None, **options: Any
    ) -> tuple[dict[str, bytes], list[str]]:
        """Files by their path in a package, a single one by no path; what they have no room for.

        told
            How far up the caller is who is warned of a model that should move no arm; 0 for nobody.
        """
        if min(options.get("samples") or 0, options.get("seed") or 0) < 0:
            raise ValueError("samples, seed: expected no number below 0")
        text = None if onto is None else Path(onto).read_text()
        lock = list(options.pop("lock", None) or ())
        files, left_out, flaws = self._export(to, name, onto=text, lock=lock, **options)
        for flaw in flaws if told else ():
            warnings.warn(f"{flaw}: do not let it move an arm", stacklevel=told + 1)
        return dict(files), left_out

    @explicit(RobotOptions)
    def to_urdf(self, path: _Path | None = None, **options: Unpack[RobotOptions]) -> str:
        """The model as a robot for ROS, Pinocchio, Drake, Gazebo: the text, and a file if asked for."""
        return self._robot("urdf", path, options)

    @explicit(RobotOptions)
    def to_mjcf(self, path: _Path | None = None, **options: Unpack[RobotOptions]) -> str:
        """The same for MuJoCo."""
        return self._robot("mjcf", path, options)

    def _robot(self, to: str, path: _Path | None, options: RobotOptions) -> str:
        files, _ = self._files(to, 3, **options)
        if path is not None:
            _core.write_whole(path, files[""])
        return files[""].decode()

    def functions(self, module: Any = math, **options: Any) -> types.SimpleNamespace:
        """The closed form as functions of another module's sin, cos, exp and tanh.

        With ``jax.numpy`` they are traced, differentiated and batched by jax; likewise with torch,
        casadi or sympy. They take sequences of n numbers of that module and return lists:
        ``torque(q, dq, ddq)``, ``gravity(q)``, ``coriolis(q, dq)``, ``inertia(q)``,
        ``friction(q, dq)``, ``forward_dynamics(q, dq, tau)``, …
        """
        source = self._files("python", **options)[0][""].decode()
        space: dict[str, Any] = {"__name__": "torquewise.exported"}
        exec(compile(source, "<exported model>", "exec"), space)
        if module is not math:
            space.update({own: getattr(module, own) for own in ("sin", "cos", "exp", "tanh")})
            space["_sign"] = module.sign
            space["_positive"] = lambda x: 0.5 * (module.sign(x) + 1)
        return types.SimpleNamespace(**{key: space[key] for key in space["__all__"]})

    def to_sympy(self, **options: Any) -> Symbolic:
        """The equations of motion in sympy: :class:`Symbolic`."""
        import sympy

        n = len(self.joints)
        q, dq, ddq = (sympy.symbols(f"{own}1:{n + 1}", real=True) for own in ("q", "dq", "ddq"))
        own = self.functions(sympy, **options)

        def vector(values: Any) -> Any:
            return sympy.Matrix([sympy.sympify(x) for x in values])

        return Symbolic(
            q=q,
            dq=dq,
            ddq=ddq,
            torque=vector(own.torque(q, dq, ddq)),
            mass_matrix=sympy.Matrix(own.inertia(q)),
            coriolis=vector(own.coriolis(q, dq)),
            gravity=vector(own.gravity(q)),
            friction=vector(own.friction(q, dq)),
        )

    def to_casadi(self, what: str = "torque", **options: Any) -> Any:
        """A function of the equations of motion as a ``casadi.Function``.

        what
            ``torque`` (q, dq, ddq), ``forward_dynamics`` (q, dq, tau), ``inertia`` (q), ``coriolis``,
            ``friction`` (q, dq) or ``gravity`` (q).
        """
        import casadi

        inputs = {
            "torque": ("q", "dq", "ddq"),
            "forward_dynamics": ("q", "dq", "tau"),
            "inertia": ("q",),
            "gravity": ("q",),
            "coriolis": ("q", "dq"),
            "friction": ("q", "dq"),
        }
        if what not in inputs:
            raise ValueError(f"what={what!r}: expected one of {', '.join(inputs)}")
        own = getattr(self.functions(casadi, **options), what)
        symbols = [casadi.SX.sym(name, len(self.joints)) for name in inputs[what]]
        found = own(*(casadi.vertsplit(symbol) for symbol in symbols))
        if what == "inertia":
            result = casadi.vertcat(*(casadi.horzcat(*row) for row in found))
        else:
            result = casadi.vertcat(*found)
        output = {"inertia": "M", "forward_dynamics": "ddq"}.get(what, "tau")
        return casadi.Function(what, symbols, [result], list(inputs[what]), [output])

    @explicit(RobotOptions)
    def to_pinocchio(self, **options: Unpack[RobotOptions]) -> Any:
        """The links, joints and rotors of a chain as a ``pinocchio.Model``, with its gravity.

        Pinocchio adds no friction: its ``rnea`` gives :meth:`torque` less :meth:`friction`. Springs and
        other terms that it has no room for are named in a warning.
        """
        try:
            import pinocchio
        except ImportError:
            raise ImportError("Pinocchio is not installed: pip install pin") from None
        files, left_out = self._files("urdf", **options)
        found = pinocchio.buildModelFromXML(files[""].decode())
        # A URDF has no rotors: what they add to M(q) is the same everywhere.
        q = np.zeros(len(self.joints))
        bodies = pinocchio.crba(found, found.createData(), q)
        rotors = np.diag(self.mass_matrix(q) - np.triu(bodies) - np.triu(bodies, 1).T)
        found.armature = np.where(rotors > 1e-9 * np.diag(bodies).max(), rotors, 0.0)
        if left_out:
            warnings.warn(f"not in the Pinocchio model: {', '.join(left_out)}", stacklevel=2)
        return found


@dataclass
class Symbolic:
    """Equations of motion in sympy: symbols, and matrices in them."""

    q: tuple[Any, ...]
    dq: tuple[Any, ...]
    ddq: tuple[Any, ...]
    torque: Any
    mass_matrix: Any
    coriolis: Any
    gravity: Any
    friction: Any


def _target(path: Path) -> str:
    to = _ENDINGS.get(path.suffix.lower())
    if to is None:
        raise ValueError(f'{path} does not say what is wanted: give to="c", "urdf", …')
    return to
