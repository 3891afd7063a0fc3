"""Accelerations of chains in space: m4e_fmi in C beside Pinocchio's ABA in C++, in one run.

A seven-joint arm with arbitrary placements, axes and inertias, and a chain of 60 ball joints. The
arm's accelerations are compared first. `python -m benchmark.space` prints times and ratios.
"""

from __future__ import annotations

import ctypes
from ctypes import c_double, c_int, c_void_p
from typing import Any

import numpy as np

from benchmark.engine import UnavailableError
from benchmark.engines import pinocchio_aba
from benchmark.engines.ours import engine_of, value
from benchmark.native_code import NATIVE, Floats, address, compiled, native_batch
from m4e_fmi.model import Body, Joint, Model
from m4e_fmi.multibody import model_program

GRAVITY = 9.81
ROUNDS, SECONDS = 9, 0.1


def chain(kind: str, count: int) -> tuple[Model, Floats]:
    """A chain of bodies on revolute or spherical joints, and the same as Pinocchio's table."""
    r = np.random.default_rng(count)
    bodies, joints, rows = {}, {}, []
    for k in range(count):
        axis, to, out = (r.uniform(-0.5, 0.5, 3) for _ in range(3))
        turn, _ = np.linalg.qr(r.normal(size=(3, 3)))
        J = turn @ np.diag(r.uniform(0.1, 0.15, 3)) @ turn.T
        inertia = (J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[1, 2], J[2, 0])
        mass = float(r.uniform(1, 2))
        bodies[f"b{k}"] = Body(mass, tuple(map(float, inertia)))
        more: Any = {"axis": tuple(axis.tolist())} if kind == "revolute" else {}
        parent = f"b{k - 1}" if k else "ground"
        places = tuple(to.tolist()), tuple(out.tolist())
        joints[f"j{k}"] = Joint(kind, f"b{k}", parent, *places, **more)
        rows.append([*axis, *to, *out, mass, *inertia])
    return Model(kind, bodies, joints, dimensions=3, gravity=GRAVITY), np.array(rows)


def peer(table: Floats, *, balls: bool) -> tuple[Any, int, int, int]:
    """The compiled C++ functions, the address of a chain, and its numbers of q and v."""
    made = compiled(NATIVE / "pinocchio_space.cpp", pinocchio_aba.options(), plus_plus=True)
    made.pinocchio_space_new.restype = c_void_p
    made.pinocchio_space_new.argtypes = [c_int, c_void_p, c_int, c_double]
    made.pinocchio_space_sizes.argtypes = [c_void_p, c_int]
    rows = np.ascontiguousarray(table)
    new = made.pinocchio_space_new(len(rows), rows.ctypes.data, int(balls), GRAVITY)
    sizes = (made.pinocchio_space_sizes(new, velocities) for velocities in (0, 1))
    return made, new, *sizes


def main() -> None:
    """Print microseconds a call, and our time over Pinocchio's."""
    for kind, count in (("revolute", 7), ("spherical", 60)):
        model, table = chain(kind, count)
        program = model_program(model, inputs=())
        balls = kind == "spherical"
        made, other, nq, nv = peer(table, balls=balls)
        r = np.random.default_rng(1)
        x = r.uniform(-1, 1, len(program.states))
        theirs = r.uniform(-1, 1, nq + nv)
        if balls:
            theirs[:nq] = np.tile([0.1, 0.2, 0.3, np.sqrt(1 - 0.14)], count)
        else:
            theirs = np.concatenate([x[0::2], x[1::2]])
        batches = {"Pinocchio": native_batch(address(made, "pinocchio_space"), other, theirs)}
        for name, is_compiled in (("interpreted", False), ("compiled", True)):
            try:
                engine = engine_of(program, compiled=is_compiled, outputs=())
            except UnavailableError as error:
                print(f"{kind} {count}: {name}: {error}")
                continue
            function, handle = address(engine.library, "m4e_rates"), value(engine.handle)
            batches[name] = native_batch(function, handle, x, owner=engine)
            if not balls:
                result = np.empty(len(x))
                kind_of = ctypes.CFUNCTYPE(None, c_void_p, c_double, c_void_p, c_void_p)
                kind_of(function)(handle, 0.0, x.ctypes.data, result.ctypes.data)
                expected = np.empty(nv)
                kind_of(address(made, "pinocchio_space"))(
                    other, 0.0, theirs.ctypes.data, expected.ctypes.data
                )
                error = np.abs(result[1::2] - expected).max() / np.abs(expected).max()
                assert error < 1e-12, error
        calls = {name: max(1, int(SECONDS / batch(100) * 100)) for name, batch in batches.items()}
        times: dict[str, list[float]] = {name: [] for name in batches}
        for _ in range(ROUNDS):
            for name, batch in batches.items():
                times[name].append(1e6 * batch(calls[name]) / calls[name])
        reference = np.median(times["Pinocchio"])
        operations = len(program.operations(program.rates))
        print(f"{count} {kind} joints: {operations} operations")
        for name, found in times.items():
            print(f"  {name:12} {np.median(found):8.3f} us   {np.median(found) / reference:5.2f}")


if __name__ == "__main__":
    main()
