"""The quantities, each a plain dictionary for the report; names of engines map to SI numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from benchmark import reference
from benchmark.engine import Batch, Engine, Prepared, UnavailableError
from benchmark.engines import mujoco_forward, ours, pinocchio_aba, pym4e
from benchmark.engines.sympy_kane import SympyKane
from benchmark.native_code import address, interleaved, native_batch
from benchmark.systems import System, pendulum, random_state
from benchmark.timing import fastest

Log = Callable[[str], None]
Values = dict[str, float]

AGREEMENT = 1e-9  # relative to the largest acceleration
AGREEMENT_BEYOND = 1e-6  # of more than 100 links: MuJoCo is off by 2e-8 at 200
EXACT_UP_TO = 60
INTERVAL = 0.01  # s, between results
STOP_TIME = 30.0  # s
REPEATS = 3
MODELS = 64


def times(stop_time: float = STOP_TIME) -> np.ndarray:
    return INTERVAL * np.arange(round(stop_time / INTERVAL) + 1)


@dataclass(frozen=True)
class Compared:
    """By engine: CPU `seconds` of a right-hand side at the system's own state; `error` of an
    acceleration in a random state over the largest; CPU seconds of its `preparation`."""

    seconds: Values
    error: Values
    preparation: Values


def compared(system: System, engines: Iterable[Engine], log: Log) -> Compared:
    """What can be had, and agrees; `log` hears of the rest, and SystemExit of disagreement."""
    q, u = random_state(system.size)
    exact = system.size <= EXACT_UP_TO
    right = reference.accelerations(system, q, u, exact=exact)
    largest = max(map(abs, right))
    found: dict[str, Prepared] = {}
    errors: Values = {}
    loaded = bool(system.springs)
    for engine in engines:
        if system.size > (engine.largest_with_loads if loaded else engine.largest):
            continue
        try:
            ready = engine.prepare(system)
            pairs = zip(ready.accelerations(q, u), right, strict=True)
            error = float(max(abs(float(a) - b) for a, b in pairs) / largest)
        except UnavailableError as error:
            log(f"{engine.name}, {system.name}: {error}")
            continue
        if not error <= (AGREEMENT if system.size <= 100 else AGREEMENT_BEYOND):
            raise SystemExit(
                f"{engine.name} solves another problem than {system.name}: its accelerations "
                f"differ by {error:.1e} of the largest; nothing was timed"
            )
        found[engine.name], errors[engine.name] = ready, error
    return Compared(
        seconds=fastest({name: p.batch for name, p in found.items()}) if found else {},
        error=errors,
        preparation={name: p.preparation for name, p in found.items()},
    )


def integrations(n: int, log: Log) -> dict[str, dict[str, float]]:
    """Per engine: CPU `seconds` of 30 s at 1e-8, `evaluations`, relative energy `drift`."""
    system = pendulum(n)
    pin, mujoco = pinocchio_aba.PinocchioAba().kernel, mujoco_forward.MujocoForward().kernel
    wanted: dict[str, tuple[Callable[[System], int] | None, bool, str]] = {
        "m4e_fmi compiled, RK45": (None, True, "rk45"),
        "m4e_fmi interpreted, RK45": (None, False, "rk45"),
        "m4e_fmi compiled, DOP853": (None, True, "dop853"),
        "m4e_fmi interpreted, DOP853": (None, False, "dop853"),
        "same integrator, Pinocchio, RK45": (pin, False, "rk45"),
        "same integrator, MuJoCo, RK45": (mujoco, False, "rk45"),
    }
    cases: dict[str, Callable[[], ours.Integration]] = {}
    for name, (kernel, compiled, method) in wanted.items():
        try:
            made = kernel(system) if kernel else None
            engine = ours.integrator(system, compiled=compiled, kernel=made)
        except UnavailableError as error:
            log(f"{name}, n = {n}: {error}")
            continue
        cases[name] = lambda e=engine, m=method: ours.integrate(e, times(), method=m)
    found: dict[str, dict[str, float]] = {}
    for _ in range(REPEATS):  # in turn, so that a disturbance hits all alike
        for name, case in cases.items():
            run = case()
            known = found.setdefault(name, {"seconds": run.seconds})
            known["seconds"] = min(known["seconds"], run.seconds)
            known |= {"evaluations": run.evaluations, "drift": _drift(system, run.states[-1])}
    return found


def pym4e_integration(n: int) -> dict[str, float]:
    """The same of pyM4E, and its peak `memory` [bytes] beyond the imports."""
    system = pendulum(n)
    worker, built = pym4e.worker_of(system)
    answer = worker.ask("integrate", STOP_TIME, INTERVAL)
    final = interleaved(answer["final"][:n], answer["final"][n:])
    return {
        "seconds": answer["seconds"],
        "evaluations": answer["evaluations"],
        "drift": _drift(system, final),
        "memory": max(answer["memory"], built["memory"]),
    }


def _drift(system: System, final: np.ndarray) -> float:
    """|change of energy| over m g Σ |height of the centres of gravity when hanging|."""
    begun = reference.energy(system, system.q, system.u)
    ended = reference.energy(system, final[0::2], final[1::2])
    hanging = reference.energy(system, [0.0] * system.size, [0.0] * system.size)
    return abs(ended - begun) / abs(hanging)


def preparations(
    sizes: Iterable[int], others: Mapping[int, Compared]
) -> dict[str, dict[str, float]]:
    """Per engine and n: CPU seconds from the neutral description to something that runs.

    Ours is the best of three; those of `others`, by size, are what was spent there.
    """
    engine = ours.OursNative(compiled=False)
    found: dict[str, dict[str, float]] = {engine.name: {}}
    for n in sizes:
        spent = (engine.prepare(pendulum(n)).preparation for _ in range(REPEATS))
        found[engine.name][str(n)] = min(spent)
    for name in (pym4e.PyM4E.name, SympyKane.name):
        found[name] = {
            str(n): one.preparation[name] for n, one in others.items() if name in one.preparation
        }
    return found


def spiderfloats() -> dict[str, Values]:
    """SpiderFLOAT (float, arms, sliders, buoys; springs and dampers), ours and pyM4E's.

    CPU seconds of `preparation`, `right_hand_side`, and `integration` of 10 s, RK45, 1e-8.
    """
    engine, preparation = ours.spiderfloat()
    start = np.array([v.start for v in engine.program.states])
    interpreted = _spiderfloat_ours(engine, preparation, start)
    engine.compile()
    found = {
        "m4e_fmi compiled": _spiderfloat_ours(engine, preparation, start),
        "m4e_fmi interpreted": interpreted,
    }
    worker = pym4e.Worker()
    q, u = random_state(start.size // 2)
    built = worker.ask("spiderfloat")
    theirs = np.array(worker.ask("accelerations", q, u))
    difference = np.abs(engine.rates(0.0, interleaved(q, u))[1::2] - theirs).max()
    if not difference <= AGREEMENT * np.abs(theirs).max():
        raise SystemExit(f"SpiderFLOAT: accelerations differ from pyM4E's by {difference:.1e}")
    batch = fastest({"pyM4E": lambda calls: worker.ask("batch", calls)})
    found["pyM4E"] = {
        "preparation": built["preparation"],
        "right_hand_side": batch["pyM4E"],
        "integration": worker.ask("integrate", 10.0, INTERVAL)["seconds"],
    }
    worker.close()
    return found


def _spiderfloat_ours(engine: ours.Engine, preparation: float, start: np.ndarray) -> Values:
    function = address(engine.library, "m4e_rates")
    batch = native_batch(function, ours.value(engine.handle), start, owner=engine)
    runs = [ours.integrate(engine, times(10.0), method="rk45") for _ in range(REPEATS)]
    return {
        "preparation": preparation,
        "right_hand_side": fastest({"ours": batch})["ours"],
        "integration": min(run.seconds for run in runs),
    }


def derivatives(n: int, log: Log) -> Values:
    """CPU seconds: right-hand side, one directional derivative, Jacobians; ours and Pinocchio's."""
    q, u = random_state(n)
    system = pendulum(n)
    batches: dict[str, Batch] = {}
    for title, make in (
        ("m4e_fmi", lambda: ours.derivative_batches(system, interleaved(q, u))),
        ("Pinocchio", lambda: _pinocchio_derivatives(system, interleaved(q, u))),
    ):
        try:
            batches |= make()
        except UnavailableError as error:
            log(f"{title}, derivatives at n = {n}: {error}")
    return fastest(batches) if batches else {}


def _pinocchio_derivatives(system: System, x: np.ndarray) -> dict[str, Batch]:
    model = pinocchio_aba.new(system, world=True)
    loaded = pinocchio_aba.library()
    loaded.pinocchio_set(model, x.ctypes.data)
    function = address(loaded, "pinocchio_derivatives")
    return {"Pinocchio computeABADerivatives": native_batch(function, model, x)}


def ensembles(n: int, log: Log) -> Values:
    """CPU seconds per model of 1 s, RK45 at 1e-8: many at once, and Pinocchio's one by one."""
    system = pendulum(n)
    at = times(1.0)
    found: Values = {}
    try:
        for compiled in (True, False):
            title = f"m4e_fmi {'compiled' if compiled else 'interpreted'}, {MODELS} models at once"
            spent = [
                ours.ensemble_seconds(system, at, models=MODELS, compiled=compiled)
                for _ in range(REPEATS)
            ]
            found[title] = min(spent)
        kernel = pinocchio_aba.PinocchioAba().kernel(system)
        engine = ours.integrator(system, compiled=False, kernel=kernel)
        runs = [ours.integrate(engine, at, method="rk45") for _ in range(REPEATS)]
        found["same integrator, Pinocchio"] = min(run.seconds for run in runs)
    except UnavailableError as error:
        log(f"ensemble at n = {n}: {error}")
    return found
