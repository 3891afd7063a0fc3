"""Pinocchio: the articulated-body algorithm of the wheel's own library, called from C++.

The wheel's code is run as shipped (its explicit instantiations), in the faster of its two
conventions. Springs and dampers are not Pinocchio's: `native/pinocchio.cpp` computes them from its
forward kinematics.
"""

from __future__ import annotations

import ctypes
import functools
import importlib.metadata
from collections.abc import Sequence
from ctypes import c_double, c_int, c_void_p
from pathlib import Path

import numpy as np

from benchmark.engine import Prepared, UnavailableError
from benchmark.native_code import (
    NATIVE,
    Floats,
    address,
    call_rates,
    compiled,
    interleaved,
    native_batch,
)
from benchmark.systems import GRAVITY, System
from benchmark.timing import cpu_seconds

_DEFINITIONS = (  # what the wheel's CMake targets say
    "PINOCCHIO_ENABLE_TEMPLATE_INSTANTIATION",
    "BOOST_MPL_LIMIT_LIST_SIZE=30",
    "BOOST_MPL_LIMIT_VECTOR_SIZE=30",
    "BOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "BOOST_FUSION_INVOKE_MAX_ARITY=12",
)


def options() -> list[str]:
    """Options of the compiler for C++ over the wheel. Raises UnavailableError."""
    try:
        wheel = importlib.metadata.distribution("libpinocchio")
    except importlib.metadata.PackageNotFoundError as error:
        raise UnavailableError("the package pin is not installed") from error
    prefix = Path(str(wheel.locate_file("cmeel.prefix")))
    return [
        "-std=c++17",
        "-O1",  # the algorithms are in the wheel's library
        # no -march: Eigen's alignment would differ from the wheel's
        *(f"-D{name}" for name in _DEFINITIONS),
        f"-I{prefix / 'include'}",
        f"-I{prefix / 'include' / 'eigen3'}",
        f"-L{prefix / 'lib'}",
        "-lpinocchio_default",
        f"-Wl,-rpath,{prefix / 'lib'}",
    ]


@functools.cache
def library() -> ctypes.CDLL:
    """The compiled C functions over the wheel. Raises UnavailableError."""
    made = compiled(NATIVE / "pinocchio.cpp", options(), plus_plus=True)
    made.pinocchio_new.restype = c_void_p
    table = [c_int, c_void_p]
    made.pinocchio_new.argtypes = [*table, *table, *table, c_double, c_int]
    for name in ("pinocchio_set", "pinocchio_select"):
        getattr(made, name).restype = None
    made.pinocchio_set.argtypes = [c_void_p, c_void_p]
    made.pinocchio_select.argtypes = [c_void_p]
    return made


def new(system: System, *, world: bool) -> int:
    """Address of a model of `system` that is kept for good."""
    tables = arrays(system)
    arguments = [part for table in tables for part in (len(table), table.ctypes.data)]
    return library().pinocchio_new(*arguments, GRAVITY, int(world))


def arrays(system: System) -> list[Floats]:
    """Links, springs and torsions as `native/system.h` wants them."""
    links = [
        (
            k.parent,
            k.revolute,
            *k.parent_to_joint,
            *k.joint_to_child,
            *k.direction,
            k.mass,
            k.inertia,
        )
        for k in system.links
    ]
    springs = [
        (s.first, *s.first_point, s.second, *s.second_point, s.stiffness, s.length, s.damping)
        for s in system.springs
    ]
    torsions = [(t.link, t.stiffness, t.angle, t.damping) for t in system.torsions]
    return [np.array(rows, dtype=float) for rows in (links, springs, torsions)]


class PinocchioAba:
    name = "Pinocchio ABA"
    largest = 10_000
    largest_with_loads = 10_000

    def prepare(self, system: System) -> Prepared:
        loaded = library()
        evaluate, rates = (address(loaded, f"pinocchio_{n}") for n in ("evaluate", "rates"))
        began = cpu_seconds()
        peer = new(system, world=True)
        preparation = cpu_seconds() - began
        models = [peer, new(system, world=False)]
        x = interleaved(system.q, system.u)
        batches = [native_batch(evaluate, model, x) for model in models]
        for model in models:
            loaded.pinocchio_set(model, x.ctypes.data)
        speed = [min(batch(200) for _ in range(5)) for batch in batches]
        best = speed.index(min(speed))

        def accelerations(q: Sequence[float], u: Sequence[float]) -> Floats:
            return call_rates(rates, models[best], q, u)

        return Prepared(accelerations, batches[best], preparation)

    def kernel(self, system: System) -> int:
        """Address of `void f(t, x, fixed, rates)` for the same C integrator as ours."""
        library().pinocchio_select(new(system, world=True))
        return address(library(), "pinocchio_kernel")
