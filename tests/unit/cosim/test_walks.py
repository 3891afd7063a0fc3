"""The ways of a force and of a step size through a run, traced, are those that the docs show."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from types import FrameType

import pytest
from support.walks import Seen, Ways, documented, file, has, stack, traced

from m4e_fmi.cosim import Prepared, load_system, prepare
from m4e_fmi.cosim.network.operations import DoStep, Get, Set
from m4e_fmi.cosim.network.schedule import LoopState, NativeExecutor
from m4e_fmi.cosim.run.run import Run, RunOptions
from m4e_fmi.cosim.wiring.links import Link, Port

TAKER = "cart"
FORCE = {Port("spring", "joint.rail.q"), Port(TAKER, "joint.rail.effort")}
MODEL = """\
name: one
bodies: {mass: {mass: 1, inertia: 1}}
joints: {rail: {type: prismatic, child: mass, direction: [1, 0], initial: {q: 0.1}}}
"""
SYSTEM = """\
name: two
components: {spring: {model: one.model.yaml}, cart: {model: one.model.yaml}}
connections:
  - spring.joint.rail.q * -20 -> cart.joint.rail.effort, units ignored
  - cart.joint.rail.q * -20 -> spring.joint.rail.effort, units ignored
simulation: {stop_time: 21.13 ms, step_size: 2.113 ms, algorithm: %s}
"""
STEP = ("2.113 ms", 0.002113, 2113000, Fraction(2113, 1000000))
"""The step of the system in all its forms: as text, in seconds and in nanoseconds."""
WINDOWS = {"Network.__init__": 1, "made": 1, "TimeLoop.advance": 1}
"""Where a network, its algorithm, and steps are made."""
FORCE_TITLE, STEP_TITLE = "A force through one step", "`step_size` from file to step"


def is_force(value: object) -> bool:
    """True for the link of the force, its ends, what reads or sets it, and its taker's step."""
    match value:
        case Port():
            return value in FORCE
        case Link():
            return value.source in FORCE and value.target in FORCE
        case Get(instance, names) | Set(instance, names):
            return any(Port(instance.name, name) in FORCE for name in names)
        case DoStep(instance):
            return instance.name == TAKER
    return False


def is_step(value: object) -> bool:
    found = value.size if isinstance(value, LoopState) else value
    return isinstance(found, str | int | float | Fraction) and found in STEP


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("walk")
    (found / "one.model.yaml").write_text(MODEL)
    return found


def stepped(folder: Path, algorithm: str, seen: Seen, made: Callable[[Prepared], None]) -> None:
    """Ten steps of a system, the first alone, the others at once, seen from its file on."""
    path = folder / f"{algorithm}.system.yaml"
    path.write_text(SYSTEM % algorithm)
    with traced(seen):
        system = load_system(path)
    prepared = prepare(system, build_directory=folder / "build")
    made(prepared)
    with traced(seen), Run(prepared, RunOptions(certify=False)) as run:
        run.begin()
        run.finish()


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss_seidel", "corrector", "implicit"])
def test_a_force_passes_the_files_that_the_docs_name(folder: Path, algorithm: str) -> None:
    found: set[str] = set()
    loops: set[str] = set()
    within = 0

    def seen(frame: FrameType, event: str, result: object) -> None:
        nonlocal within
        name = frame.f_code.co_qualname
        if name in WINDOWS:
            within += WINDOWS[name] if event == "call" else -WINDOWS[name]
        if within <= 0:
            return
        if event == "call" and name in ("NativeExecutor.perform", "run_loop"):
            executor = frame.f_locals.get("self", frame.f_locals.get("step"))
            assert isinstance(executor, NativeExecutor)
            operations = [one[0] for one in executor._kept]
            if any(isinstance(one, DoStep) and is_force(one) for one in operations):
                found.update(map(file, stack(frame)))
                loops.add(name)
        elif has(frame, event, result, is_force):
            found.add(file(frame))

    stepped(folder, algorithm, seen, lambda _: found.clear())
    both = {"NativeExecutor.perform", "run_loop"}  # a single step, and many at once
    assert loops == ({"NativeExecutor.perform"} if algorithm == "implicit" else both)
    names = [name.replace("corrector", algorithm) for name in documented(FORCE_TITLE)]
    assert len(names) <= 9
    if algorithm == "implicit":
        names = [name.replace("stepping/algorithm", "network/newton") for name in names]
    if algorithm in ("jacobi", "gauss_seidel"):
        names = [name for name in names if "pieces" not in name]
    assert found == set(names)


def test_a_step_size_passes_the_files_that_the_docs_name(folder: Path) -> None:
    ways = Ways(is_step)
    stepped(folder, "corrector", ways.seen, lambda _: None)
    first, last = "m4e_fmi/files/document.py", "m4e_fmi/cosim/network/schedule.py"
    names = documented(STEP_TITLE)
    assert ways.shortest(first, last) == [names]
    assert len(names) <= 4
