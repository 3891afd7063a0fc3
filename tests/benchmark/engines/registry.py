"""All engines, ours first."""

from __future__ import annotations

import importlib.metadata

from benchmark.engine import Engine
from benchmark.engines.casadi_sx import CasadiSx
from benchmark.engines.mujoco_forward import MujocoForward
from benchmark.engines.ours import OursNative, OursPython
from benchmark.engines.pinocchio_aba import PinocchioAba
from benchmark.engines.pydy_cython import PydyCython
from benchmark.engines.pym4e import PyM4E
from benchmark.engines.sympy_kane import SympyKane

PACKAGES = ("pin", "mujoco", "casadi", "sympy", "pydy", "cython", "numpy", "scipy")


def engines() -> list[Engine]:
    return [
        OursNative(compiled=True),
        OursNative(compiled=False),
        OursPython(),
        PinocchioAba(),
        MujocoForward(),
        CasadiSx(generated=True),
        CasadiSx(generated=False),
        PydyCython(),
        SympyKane(),
        PyM4E(),
    ]


def versions() -> dict[str, str]:
    """Version of each package measured; "not installed" where it is missing."""
    found = {}
    for name in PACKAGES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = "not installed"
    return found
