"""The quantities, each a plain dictionary for the report; names of engines map to SI numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterable

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
EXACT_UP_TO = 60
INTERVAL = 0.01  # s, between results
STOP_TIME = 30.0  # s
REPEATS = 3
MODELS = 64


def times(stop_time: float = STOP_TIME) -> np.ndarray:
    return INTERVAL * np.arange(round(stop_time / INTERVAL) + 1)


def prepared(system: System, engines: Iterable[Engine], log: Log) -> dict[str, Prepared]:
    """What can be had, and agrees; `log` hears of the rest, and SystemExit of disagreement."""
    q, u = random_state(system.size)
    exact = system.size <= EXACT_UP_TO
    right = np.array(reference.accelerations(system, q, u, exact=exact), dtype=float)
    found: dict[str, Prepared] = {}
    loaded = bool(system.springs)
    for engine in engines:
        if system.size > (engine.largest_with_loads if loaded else engine.largest):
            continue
        try:
            ready = engine.prepare(system)
            difference = np.abs(np.array(ready.accelerations(q, u)) - right).max()
        except UnavailableError as error:
            log(f"{engine.name}, {system.name}: {error}")
            continue
        if not difference <= AGREEMENT * np.abs(right).max():
            raise SystemExit(
                f"{engine.name} solves another problem than {system.name}: its accelerations "
                f"differ by {difference:.1e} rad/s²; nothing was timed"
            )
        found[engine.name] = ready
    return found


def right_hand_sides(system: System, engines: Iterable[Engine], log: Log) -> Values:
    """CPU seconds per evaluation at the system's own state."""
    ready = prepared(system, engines, log)
    return fastest({name: p.batch for name, p in ready.items()}) if ready else {}


def integrations(n: int, log: Log, *, with_pym4e: bool) -> dict[str, dict[str, float]]:
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
    if with_pym4e:
        try:
            found["pyM4E, RK45"] = _pym4e_integration(system)
        except UnavailableError as error:
            log(f"pyM4E, n = {n}: {error}")
    return found


def _pym4e_integration(system: System) -> dict[str, float]:
    worker = pym4e.Worker()
    built = worker.prepare(system)
    answer = worker.ask("integrate", STOP_TIME, INTERVAL)
    worker.close()
    n = system.size
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


def preparations(sizes: Iterable[int], log: Log, *, full: bool) -> dict[str, dict[str, float]]:
    """Per engine and n: CPU seconds from the neutral description to something that runs."""
    limits: dict[str, tuple[Engine, int, int]] = {
        "m4e_fmi interpreted": (ours.OursNative(compiled=False), 500, REPEATS),
        "pyM4E": (pym4e.PyM4E(), 60 if full else 20, 1),
        "SymPy Kane, lambdify": (SympyKane(), 20 if full else 10, 1),
    }
    found: dict[str, dict[str, float]] = {}
    for name, (engine, largest, repeats) in limits.items():
        for n in sizes:
            if n > largest:
                continue
            try:
                spent = min(engine.prepare(pendulum(n)).preparation for _ in range(repeats))
            except UnavailableError as error:
                log(f"{name}, n = {n}: {error}")
                break
            found.setdefault(name, {})[str(n)] = spent
    return found


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


def accuracy(n: int, engines: Iterable[Engine]) -> Values:
    """Largest error of an acceleration over the largest acceleration, against 50 digits."""
    system = pendulum(n)
    q, u = random_state(n)
    exact = reference.accelerations(system, q, u)
    largest = max(abs(a) for a in exact)
    found: Values = {}
    for engine in engines:
        if n > engine.largest:
            continue
        try:
            got = engine.prepare(system).accelerations(q, u)
        except UnavailableError:
            continue  # said before, by `prepared`
        errors = (abs(float(a) - b) for a, b in zip(got, exact, strict=True))
        found[engine.name] = float(max(errors) / largest)
    return found
