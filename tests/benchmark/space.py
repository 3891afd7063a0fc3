"""Chains in space: m4e_fmi in C beside Pinocchio's ABA in C++ and MuJoCo's steps, in one run.

A seven-joint arm with arbitrary placements, axes and inertias, and a chain of 60 ball joints. The
arm's accelerations are compared first. `python -m benchmark.space` prints times and ratios.
"""

from __future__ import annotations

import ctypes
import importlib
import importlib.util
import time
from collections.abc import Callable
from ctypes import c_double, c_int, c_void_p
from typing import Any

import numpy as np

from benchmark.engine import Batch, UnavailableError
from benchmark.engines import pinocchio_aba
from benchmark.engines.ours import engine_of, value
from benchmark.native_code import NATIVE, Floats, address, call_rates, compiled, native_batch
from benchmark.timing import fastest
from m4e_fmi.model import Body, Joint, Model
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program
from m4e_fmi.runtime.engine import Control, ensemble

GRAVITY = 9.81
STEP = 1e-3  # s, of RK4
RUNS, STEPS = 16, 5000  # so many that what precedes an ensemble's steps takes a few percent
SAME = 1e-12
ROUNDS = 300


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


def pinocchio(table: Floats, x: Floats, *, balls: bool) -> dict[str, Batch]:
    """Batches of Pinocchio's two conventions at q and v, `x`; the chain is kept for good."""
    made, new = _pinocchio(table, balls=balls)
    names = ("local", "world")
    functions = {name: address(made, f"pinocchio_space_{name}") for name in names}
    return {f"Pinocchio {k}": native_batch(f, new, x) for k, f in functions.items()}


def _pinocchio(table: Floats, *, balls: bool) -> tuple[Any, int]:
    made = compiled(NATIVE / "pinocchio_space.cpp", pinocchio_aba.options(), plus_plus=True)
    made.pinocchio_space_new.restype = c_void_p
    made.pinocchio_space_new.argtypes = [c_int, c_void_p, c_int, c_double]
    rows = np.ascontiguousarray(table)
    return made, made.pinocchio_space_new(len(rows), rows.ctypes.data, int(balls), GRAVITY)


def ours(program: Program, x: Floats) -> dict[str, Batch]:
    """Batches of the interpreter and, if the program may be compiled, of the compiled program."""
    batches: dict[str, Batch] = {}
    for name, is_compiled in (("interpreted", False), ("compiled", True)):
        try:
            engine = engine_of(program, compiled=is_compiled, outputs=())
        except UnavailableError as error:
            print(f"  {name}: {error}")
            continue
        function, handle = address(engine.library, "m4e_rates"), value(engine.handle)
        batches[name] = native_batch(function, handle, x, owner=engine)
    return batches


def report(title: str, program: Program, batches: dict[str, Batch]) -> None:
    """Print microseconds a call, and our time over Pinocchio's faster one."""
    found = fastest(batches, rounds=ROUNDS)
    reference = min(seconds for name, seconds in found.items() if "Pinocchio" in name)
    print(f"{title}: {len(program.operations(program.rates))} operations")
    for name, seconds in found.items():
        print(f"  {name:16} {1e6 * seconds:8.3f} us   {seconds / reference:5.2f}")


def mjcf(table: Floats) -> str:
    """The chain of hinges as MJCF; body frames are at the joints."""
    lines, arm = [], np.zeros(3)
    for row in table:
        axis, to, out, mass, inertia = row[:3], row[3:6], row[6:9], row[9], row[10:]
        xx, yy, zz, xy, yz, zx = inertia
        lines.append(f'<body pos="{_text(arm + to)}"><joint axis="{_text(axis)}"/>')
        full = _text([xx, yy, zz, xy, zx, yz])
        lines.append(f'<inertial pos="{_text(out)}" mass="{float(mass)!r}" fullinertia="{full}"/>')
        arm = out
    flags = '<flag contact="disable" constraint="disable" sensor="disable"/>'
    option = f'<option integrator="RK4" timestep="{STEP}" gravity="0 0 {-GRAVITY}">{flags}</option>'
    bodies = "".join(lines) + "</body>" * len(table)
    return f"<mujoco>{option}<worldbody>{bodies}</worldbody></mujoco>"


def _text(numbers: Any) -> str:
    return " ".join(repr(float(number)) for number in numbers)


def mujoco_steps(table: Floats, q: Floats, u: Floats, expected: Floats) -> Callable[[], None]:
    """A function that takes `STEPS` steps of MuJoCo, whose accelerations are compared first."""
    mujoco: Any = importlib.import_module("mujoco")
    model = mujoco.MjModel.from_xml_string(mjcf(table))
    data = mujoco.MjData(model)

    def start() -> None:
        data.qpos[:], data.qvel[:] = q, u

    start()
    mujoco.mj_forward(model, data)
    compare("MuJoCo", data.qacc, expected)

    def run() -> None:
        start()
        mujoco.mj_step(model, data, STEPS)

    return run


def compare(name: str, found: Floats, expected: Floats) -> None:
    """Raise an AssertionError where accelerations are not the same."""
    error = np.abs(found - expected).max() / np.abs(expected).max()
    assert error < SAME, (name, error)


def ensemble_of(program: Program, x: Floats) -> Callable[[], None]:
    """A function that takes `STEPS` RK4 steps of `RUNS` compiled runs, eight at a time."""
    states = np.tile(x, (RUNS, 1))
    parameters = np.tile([v.start for v in program.parameters], (RUNS, 1))
    control = Control(method="rk4", max_step=STEP)

    def run() -> None:
        ensemble(
            program, [0.0, STEPS * STEP], parameters=parameters, states=states, outputs=(),
            control=control, compiled=True,
        )  # fmt: skip

    run()
    return run


def steps_per_second(run: Callable[[], None], steps: int) -> float:
    """Of the fastest of five runs, in CPU time."""
    spent = []
    for _ in range(5):
        began = time.process_time()
        run()
        spent.append(time.process_time() - began)
    return steps / min(spent)


def arm() -> None:
    """The seven-joint arm: accelerations and steps."""
    model, table = chain("revolute", 7)
    program = model_program(model, inputs=())
    x = np.random.default_rng(1).uniform(-1, 1, len(program.states))
    q, u = x[0::2], x[1::2]
    batches = ours(program, x)
    engine = engine_of(program, compiled=False, outputs=())
    expected = call_rates(
        address(engine.library, "m4e_rates"), value(engine.handle), q.tolist(), u.tolist()
    )
    made, new = _pinocchio(table, balls=False)
    found = np.empty(len(u))
    kind = ctypes.CFUNCTYPE(None, c_void_p, c_double, c_void_p, c_void_p)
    function = kind(address(made, "pinocchio_space_local"))
    function(new, 0.0, np.r_[q, u].ctypes.data, found.ctypes.data)
    compare("Pinocchio", found, expected)
    report("7 revolute joints", program, batches | pinocchio(table, np.r_[q, u], balls=False))
    if importlib.util.find_spec("mujoco") is None:
        print("  MuJoCo: the package mujoco is not installed")
        return
    theirs = steps_per_second(mujoco_steps(table, q, u, expected), STEPS)
    own = steps_per_second(ensemble_of(program, x), RUNS * STEPS)
    print("  RK4 steps a second and core:")
    print(f"  MuJoCo {theirs:.3g}, compiled ensemble {own:.3g}, {own / theirs:.1f} times as many")


def balls() -> None:
    """The chain of 60 ball joints: accelerations."""
    model, table = chain("spherical", 60)
    program = model_program(model, inputs=())
    r = np.random.default_rng(1)
    q = np.tile([0.1, 0.2, 0.3, np.sqrt(1 - 0.14)], len(table))
    theirs = np.r_[q, r.uniform(-1, 1, 3 * len(table))]
    batches = ours(program, r.uniform(-1, 1, len(program.states)))
    report("60 ball joints", program, batches | pinocchio(table, theirs, balls=True))


if __name__ == "__main__":
    arm()
    balls()
