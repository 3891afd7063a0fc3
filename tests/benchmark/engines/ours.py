"""m4e_fmi: interpreted, compiled, and in plain Python. All uses of its interfaces are in this file.

The first two come from `m4e_fmi.runtime.engine`, which needs the C library; without it they report
that they are unavailable.
"""

from __future__ import annotations

from collections.abc import Sequence
from ctypes import c_void_p
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from benchmark.engine import Batch, Prepared, UnavailableError
from benchmark.native_code import (
    BUILD,
    ROOT,
    Floats,
    address,
    call_rates,
    interleaved,
    native_batch,
)
from benchmark.systems import GRAVITY, GROUND, System
from benchmark.timing import cpu_seconds, python_batch
from m4e_fmi import model as elements
from m4e_fmi.model import load_model
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program, jacobian, tangent
from m4e_fmi.program.python_form import load_python

if TYPE_CHECKING:
    from m4e_fmi.runtime.engine import Engine


SPIDERFLOAT = ROOT / "examples" / "paper_cases" / "spiderfloat.model.yaml"


def model_of(system: System) -> elements.Model:
    """The system as a model of m4e_fmi."""
    bodies, joints, points, loads = {}, {}, {}, {}
    for k, link in enumerate(system.links):
        bodies[_body(k)] = elements.Body(mass=link.mass, inertia=link.inertia)
        joints[f"joint{k}"] = elements.Joint(
            type="revolute" if link.revolute else "prismatic",
            child=_body(k),
            parent=_body(link.parent),
            parent_to_joint=link.parent_to_joint,
            joint_to_child=link.joint_to_child,
            direction=None if link.revolute else link.direction,
            initial={"q": system.q[k], "u": system.u[k]},
        )
    for k, s in enumerate(system.springs):
        ends = (f"first{k}", f"second{k}")
        points[ends[0]] = elements.Point(_body(s.first), s.first_point)
        points[ends[1]] = elements.Point(_body(s.second), s.second_point)
        loads[f"spring{k}"] = elements.TensionSpring(ends, s.stiffness, s.length)
        loads[f"damper{k}"] = elements.TensionDamper(ends, s.damping)
    for t in system.torsions:
        pair = (_body(system.angle_index(system.links[t.link].parent)), _body(t.link))
        loads[f"torsion_spring{t.link}"] = elements.TorsionSpring(pair, t.stiffness, t.angle)
        loads[f"torsion_damper{t.link}"] = elements.TorsionDamper(pair, t.damping)
    return elements.Model(
        name=system.name, bodies=bodies, joints=joints, points=points, loads=loads, gravity=GRAVITY
    )


def _body(link: int) -> str:
    return elements.GROUND if link == GROUND else f"body{link}"


def program_of(system: System, *, inputs: tuple[str, ...] | None = ()) -> Program:
    """The system's program; without inputs, or with all; its states are q and u of each link."""
    program = model_program(model_of(system), inputs=inputs)
    names = [f"joint.joint{k}.{letter}" for k in range(system.size) for letter in "qu"]
    assert [v.name for v in program.states] == names
    return program


def engine_of(program: Program, *, compiled: bool, outputs: Sequence[str] = ()) -> Engine:
    """The program in the C library, with these outputs. Raises UnavailableError."""
    try:
        from m4e_fmi.runtime.engine import Engine
    except ImportError as error:
        raise UnavailableError("this m4e_fmi has no C runtime") from error
    from m4e_fmi.errors import RunError

    try:
        engine = Engine(program, outputs=outputs)
    except RunError as error:
        raise UnavailableError(str(error)) from error
    if compiled and not engine.compile():
        raise UnavailableError("no C compiler, or the program is too large to be compiled")
    return engine


class OursNative:
    """m4e_fmi through its C library."""

    largest = 10_000
    largest_with_loads = 10_000

    def __init__(self, *, compiled: bool) -> None:
        self.compiled = compiled
        self.name = "m4e_fmi compiled" if compiled else "m4e_fmi interpreted"

    def prepare(self, system: System) -> Prepared:
        began = cpu_seconds()
        engine = engine_of(program_of(system), compiled=self.compiled)
        preparation = cpu_seconds() - began
        function, model = address(engine.library, "m4e_rates"), value(engine.handle)
        x = interleaved(system.q, system.u)

        def accelerations(q: Sequence[float], u: Sequence[float]) -> Floats:
            return call_rates(function, value(engine.handle), q, u)

        return Prepared(accelerations, native_batch(function, model, x, owner=engine), preparation)


class OursPython:
    """m4e_fmi without any compiled part."""

    name = "m4e_fmi plain Python"
    largest = 60
    largest_with_loads = 60

    def prepare(self, system: System) -> Prepared:
        began = cpu_seconds()
        program = program_of(system)
        form = load_python(program)
        p = [v.start for v in program.parameters]
        w = [v.start for v in program.inputs]
        c = form.constants(p)
        preparation = cpu_seconds() - began
        x = interleaved(system.q, system.u).tolist()

        def accelerations(q: Sequence[float], u: Sequence[float]) -> list[float]:
            return form.rates(0.0, interleaved(q, u).tolist(), w, p, c)[1::2]

        return Prepared(
            accelerations, python_batch(lambda: form.rates(0.0, x, w, p, c)), preparation
        )


def value(pointer: int | c_void_p) -> int | None:
    return pointer.value if isinstance(pointer, c_void_p) else pointer


@dataclass(frozen=True)
class Integration:
    """CPU time [s] of one integration, evaluations of the rates, and the states over time."""

    seconds: float
    evaluations: int
    states: Floats


def integrator(system: System, *, compiled: bool, kernel: int | None = None) -> Engine:
    """What `integrate` runs; `kernel` is the address of foreign rates for the same integrator."""
    engine = engine_of(program_of(system), compiled=compiled)
    if kernel is not None:
        from m4e_fmi.runtime.declarations import BLOCKS

        engine.library.m4e_model_block(engine.handle, BLOCKS["rates"]).contents.kernel = kernel
    return engine


def integrate(engine: Engine, times: Floats, *, method: str) -> Integration:
    """Integrate with rtol = atol = 1e-8; rows of states at `times` [s]."""
    from m4e_fmi.runtime.engine import Control

    began = cpu_seconds()
    run = engine.simulate(times, control=Control(method, rtol=1e-8, atol=1e-8))
    seconds = cpu_seconds() - began
    if run.status < 0:
        raise UnavailableError(run.message)
    return Integration(seconds, run.evaluations, run.states)


def ensemble_seconds(system: System, times: Floats, *, models: int, compiled: bool) -> float:
    """CPU time [s] per model of an ensemble with slightly different start states, RK45.

    Kernels are taken from the cache if they have been compiled once.
    """
    try:
        from m4e_fmi.runtime.engine import Control, ensemble
    except ImportError as error:
        raise UnavailableError("this m4e_fmi has no C runtime") from error
    program = program_of(system)
    start = np.tile(interleaved(system.q, system.u), (models, 1))
    start[:, 0] += 1e-3 * np.arange(models)
    parameters = np.tile([v.start for v in program.parameters], (models, 1))
    inputs = np.tile([v.start for v in program.inputs], (models, 1))
    began = cpu_seconds()
    ensemble(
        program,
        times,
        parameters=parameters,
        states=start,
        inputs=inputs,
        outputs=(),
        control=Control("rk45", rtol=1e-8, atol=1e-8),
        compiled=compiled,
    )
    return (cpu_seconds() - began) / models


def spiderfloat() -> tuple[Engine, float]:
    """The paper's section 4.2.3 with forces held at their amplitude, and CPU time [s] to get it."""
    text = SPIDERFLOAT.read_text("utf-8").replace("*cos(t)", "")
    BUILD.mkdir(parents=True, exist_ok=True)
    file = BUILD / SPIDERFLOAT.name
    file.write_text(text, "utf-8")
    model = load_model(file)
    began = cpu_seconds()
    engine = engine_of(model_program(model, inputs=()), compiled=False)
    return engine, cpu_seconds() - began


def derivative_batches(system: System, x: Floats) -> dict[str, Batch]:
    """Batches at x, all interpreted: the rates, their change along one direction, their Jacobian.

    The direction is one of all states; the Jacobian is u̇ by q and u, the entries that are not zero.
    The program has its inputs, for it is in FMUs that derivatives are asked for.
    """
    program = program_of(system, inputs=None)
    states = [v.name for v in program.states]
    engine = engine_of(program, compiled=False)
    rates = address(engine.library, "m4e_rates")
    along = tangent(program, states)
    changes = [f"d(der({name}))" for name in states]
    matrix = jacobian(program, by=states)
    entries = [
        v.name
        for v, row in zip(matrix.program.outputs, matrix.row_indices, strict=True)
        if states[row].endswith(".u")
    ]
    return {
        "m4e_fmi right-hand side": native_batch(rates, value(engine.handle), x, owner=engine),
        "m4e_fmi directional derivative": _outputs_batch(along, changes, x),
        "m4e_fmi Jacobian": _outputs_batch(matrix.program, entries, x),
    }


def _outputs_batch(program: Program, names: list[str], x: Floats) -> Batch:
    """A batch of some outputs of a program at states x, with every input 1."""
    engine = engine_of(program, compiled=False, outputs=names)
    engine.set_inputs(np.ones(len(program.inputs)))
    function = address(engine.library, "m4e_outputs")
    return native_batch(function, value(engine.handle), x, results=len(names), owner=engine)
