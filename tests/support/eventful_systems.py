"""Random chains of masses with contacts, switches, bursts and cubic springs, coupled, and exactly.

The exact course is that of all masses in one set of equations, integrated at a tolerance of 1e-11
between the times at which a force changes at once. Contacts are steep springs, which the integrator
resolves by its step control.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Literal

import numpy as np
from scipy.integrate import solve_ivp

from m4e_fmi.cosim import Component, FmuFile, Network, Outcome, Simulation, System, run
from m4e_fmi.errors import RunError

Event = Literal["none", "contact", "impact", "switch", "burst"]
REST = {
    "mass": 1.0,
    "stiffness": 1.0,
    "cubic": 0.0,
    "wall_damping": 0.0,
    "coupling": 1.0,
    "coupling_cubic": 0.0,
    "damping": 0.0,
    "stop": 0.0,
    "stop_side": 1.0,
    "stop_stiffness": 0.0,
    "stop_damping": 0.0,
    "between": 0.0,
    "armed": 1e9,
    "switched": 1e9,
    "switch_factor": 1.0,
    "burst": 1e9,
    "burst_width": 1.0,
    "burst_force": 0.0,
    "inside": 1e-3,
}
"""Parameters of `member`, with which nothing happens."""
TOLERANCE = 1e-13
"""Of the exact course between steps of the integrator; between them it interpolates: 1e-11."""


@dataclass(frozen=True)
class Chain:
    """Masses k = 0 … n − 1, each tied to the one before by a spring and damper of its own.

    `values` are the parameters of the FMU `member` by component, in SI units; `place` (n,) [m] are
    the displacements at the start, at rest.
    """

    values: tuple[Mapping[str, float], ...]
    place: np.ndarray

    def column(self, name: str) -> np.ndarray:
        """A parameter of all components (n,)."""
        return np.array([values[name] for values in self.values])

    def accelerations(self, t: float, x: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, ...]:
        """Accelerations [m/s²] and the forces [N] of the springs on the masses before (n,)."""
        c = self._columns
        gap, rate = np.diff(x, prepend=0.0), np.diff(v, prepend=0.0)
        factor = np.where(t >= c["switched"], c["switch_factor"], 1.0)
        pull = factor * (c["coupling"] * gap + c["coupling_cubic"] * gap**3) + c["damping"] * rate
        own = c["stiffness"] * x + c["cubic"] * x**3 + c["wall_damping"] * v
        between = c["between"] > 0.0
        way, speed = np.where(between, gap, x), np.where(between, rate, v)
        depth = np.where(t >= c["armed"], c["stop_side"] * (way - c["stop"]), 0.0)
        push = c["stop_stiffness"] * depth * (1 + c["stop_damping"] * c["stop_side"] * speed)
        push = c["stop_side"] * np.where((depth > 0) & (push > 0), push, 0.0)
        pull = pull + np.where(between, push, 0.0)
        share = (t - c["burst"]) / c["burst_width"]
        burst = np.where((share > 0) & (share < 1), c["burst_force"] * np.sin(np.pi * share), 0.0)
        total = burst - np.where(between, 0.0, push) - pull - own
        total[:-1] += pull[1:]
        return total / c["mass"], pull

    @property
    def _columns(self) -> dict[str, np.ndarray]:
        found = self.__dict__.get("_known")
        if found is None:
            found = {name: self.column(name) for name in self.values[0]}
            self.__dict__["_known"] = found
        return found

    def course(self, times: np.ndarray) -> np.ndarray:
        """Displacements and velocities (times, 2n)."""
        c, count = self._columns, len(self.place)
        edges = np.concatenate(
            (c["switched"], c["armed"], c["burst"], c["burst"] + c["burst_width"])
        )
        inner = np.unique(edges[(edges > times[0]) & (edges < times[-1])])
        bounds = [times[0], *inner.tolist(), times[-1]]
        state, found = np.concatenate((self.place, np.zeros(count))), []

        for begin, end in pairwise(bounds):
            middle = 0.5 * (begin + end)

            def rates(t: float, y: np.ndarray, middle: float = middle) -> np.ndarray:
                # what depends on the time at once is that of the middle, but for the burst's course
                inside = min(max(t, np.nextafter(begin, middle)), np.nextafter(end, middle))  # noqa: B023
                return np.concatenate(
                    (y[count:], self.accelerations(inside, y[:count], y[count:])[0])
                )

            here = times[(times >= begin) & (times < end)]
            points = np.unique(np.concatenate((here, [begin, end])))
            scale = np.abs(state).max() + 1e-3
            solved = solve_ivp(
                rates,
                (begin, end),
                state,
                "DOP853",
                t_eval=points,
                rtol=TOLERANCE,
                atol=TOLERANCE * scale,
            )
            found.append(solved.y.T[np.isin(points, here)])
            state = solved.y[:, -1]
        found.append(state[None])
        return np.concatenate(found)

    def outputs(self, times: np.ndarray) -> np.ndarray:
        """Exchanged values (times, 3(n − 1)): x, v of each mass but the last, force on it."""
        states, count = self.course(times), len(self.place)
        found = []
        for t, y in zip(times, states, strict=True):
            pull = self.accelerations(float(t), y[:count], y[count:])[1]
            found.append(np.column_stack((y[: count - 1], y[count:-1], pull[1:])).ravel())
        return np.array(found)


@dataclass(frozen=True)
class EventfulSystem:
    """A chain, coupled; `event` happens in it at `moment` [s].

    A contact is with a stop on the wall, an impact with one on the mass before: it is exchanged.
    """

    system: System
    chain: Chain
    event: Event
    moment: float
    rigid: bool
    nonlinear: bool

    def true_and_stated(self) -> tuple[float, float, Outcome]:
        """Largest true error over range of the exchanged outputs, the stated one, and the run.

        nan is stated where the certificate is not known. A run that grows until it fails ends at
        half of its time, and so on.
        """
        try:
            return self._true_and_stated()
        except RunError as error:
            if "grew from" not in error.message:
                raise
        settings = self.system.simulation
        steps = round(settings.stop_time / settings.step_size) // 2
        shorter = self.system.changed(stop_time=steps * settings.step_size)
        return replace(self, system=shorter).true_and_stated()

    def _true_and_stated(self) -> tuple[float, float, Outcome]:
        count, found = len(self.chain.place), []
        names = [
            name
            for k in range(count - 1)
            for name in (f"c{k}.body.m.x", f"c{k}.body.m.vx", f"c{k + 1}.end.force_x")
        ]
        times: list[float] = []

        def observe(time: float, network: Network) -> None:
            times.append(time)
            found.append([network.read(name) for name in names])

        outcome = run(self.system, observers=[observe])
        exact = self.chain.outputs(np.array(times))
        spans = np.ptp(exact, axis=0).reshape(-1, 3).max(axis=0)
        errors = np.abs(np.array(found) - exact).max(axis=0).reshape(-1, 3)
        certificate = outcome.certificate
        stated = np.nan if isinstance(certificate, str) else certificate.errors[0].error
        return float((errors / spans).max()), stated, outcome


def eventful_system(
    fmus: Callable[[str], Path],
    rng: np.random.Generator,
    *,
    algorithm: str,
    event: Event,
    rigid: Literal["none", "some", "all"] = "none",
    nonlinear: bool = False,
    steps: tuple[int, int] = (40, 1500),
    share: tuple[float, float] = (0.03, 0.97),
) -> EventfulSystem:
    """Mass ratios to 100, stiffness ratios to 300, any ωH below 0.4; the number of steps is
    log-uniform. The event comes at a uniformly random time, between two shares of the run, to a
    random mass.
    """
    count = int(rng.integers(2, 5))
    chain = _chain(rng, count, nonlinear)
    step = round(float(10 ** rng.uniform(-1.7, -0.4) / _fastest(chain)), 6)
    number = int(np.exp(rng.uniform(*np.log(steps))))
    stop = number * step
    moment = float(rng.uniform(*share) * stop)
    chain = _eventful(rng, chain, event, moment, step, stop)
    chain = Chain(tuple({**v, "inside": step / 512} for v in chain.values), chain.place)
    held = {"none": (), "some": (count - 1,), "all": range(count)}[rigid]
    kinds = ["member" + "+state" * (k not in held) for k in range(count)]
    system = _coupled(fmus, chain, kinds, Simulation(stop, step, algorithm))
    return EventfulSystem(system, chain, event, moment, rigid != "none", nonlinear)


def made(
    fmus: Callable[[str], Path],
    values: Sequence[Mapping[str, float]],
    place: Sequence[float],
    settings: Simulation,
    *,
    kind: str = "member+state",
) -> EventfulSystem:
    """A chain of masses with these parameters; those that are left out are REST."""
    step = settings.step_size
    full = tuple({**REST, "inside": step / 64, **one} for one in values)
    chain = Chain(full, np.array(place))
    system = _coupled(fmus, chain, [kind] * len(full), settings)
    return EventfulSystem(system, chain, "none", 0.0, rigid=False, nonlinear=False)


def _coupled(
    fmus: Callable[[str], Path], chain: Chain, kinds: Sequence[str], settings: Simulation
) -> System:
    parts = []
    for k, (values, kind) in enumerate(zip(chain.values, kinds, strict=True)):
        start = {**values, "body.m.x": float(chain.place[k])}
        parts.append(Component(f"c{k}", FmuFile(fmus(kind)), start))
    links = [
        line
        for k in range(len(parts) - 1)
        for line in (
            f"c{k}.body.m.x -> c{k + 1}.end.x",
            f"c{k}.body.m.vx -> c{k + 1}.end.vx",
            f"c{k + 1}.end.force_x -> c{k}.body.m.force_x",
        )
    ]
    return System("s", tuple(parts), tuple(links), settings)


def _chain(rng: np.random.Generator, count: int, nonlinear: bool) -> Chain:
    mass = 10 ** rng.uniform(-1, 1, count)
    wall = 10 ** rng.uniform(-1, 1, count)
    spring = 10 ** rng.uniform(-1, 1.5, count)
    spring[0] = 0.0
    share = rng.choice([0.0, 0.02, 0.2, 1.0], 2)  # of the critical damping
    place = rng.normal(size=count)
    values = [
        REST
        | {
            "mass": mass[k],
            "stiffness": wall[k],
            "cubic": wall[k] * rng.uniform(0.1, 1) if nonlinear else 0.0,
            "wall_damping": share[0] * 2 * np.sqrt(wall[k] * mass[k]) * rng.uniform(),
            "coupling": spring[k],
            "coupling_cubic": spring[k] * rng.uniform(0, 0.5) if nonlinear else 0.0,
            "damping": share[1] * 2 * np.sqrt(spring[k] * mass[k]) * rng.uniform(),
        }
        for k in range(count)
    ]
    return Chain(tuple({n: float(x) for n, x in v.items()} for v in values), place)


def _fastest(chain: Chain) -> float:
    """The largest rate [1/s] of small motions; cubic springs as stiff as at the largest start."""
    count, far = len(chain.place), 3 * np.abs(chain.place).max() ** 2
    wall = chain.column("stiffness") + far * chain.column("cubic")
    spring = chain.column("coupling") + 4 * far * chain.column("coupling_cubic")
    stiffness, damping = np.diag(wall), np.diag(chain.column("wall_damping"))
    for k in range(1, count):
        pair = np.zeros(count)
        pair[k - 1 : k + 1] = 1, -1
        stiffness = stiffness + spring[k] * np.outer(pair, pair)
        damping = damping + chain.column("damping")[k] * np.outer(pair, pair)
    inverse = np.diag(1 / chain.column("mass"))
    matrix = np.block(
        [[np.zeros((count, count)), np.eye(count)], [-inverse @ stiffness, -inverse @ damping]]
    )
    return float(np.abs(np.linalg.eigvals(matrix)).max())


def _eventful(
    rng: np.random.Generator, chain: Chain, event: Event, moment: float, step: float, stop: float
) -> Chain:
    """The chain with what happens to one of its masses at `moment` [s]."""
    count = len(chain.place)
    alone = event in ("contact", "burst")
    k = int(rng.integers(count)) if alone else int(rng.integers(1, count))
    given = dict(chain.values[k])
    if event == "switch":
        given |= {"switched": moment, "switch_factor": float(rng.choice([0.3, 0.6, 1.5, 2.5]))}
    elif event == "burst":
        scale = given["stiffness"] + given["coupling"]
        width = float(step * 10 ** rng.uniform(-0.3, 1.5))
        force = float(scale * 10 ** rng.uniform(-1.0, 0.3))
        given |= {"burst": moment, "burst_width": width, "burst_force": force}
    elif event in ("contact", "impact"):
        times = np.linspace(0.0, stop, 4 * round(stop / step) + 1)
        course = chain.course(times)
        x = course[:, k] - (course[:, k - 1] if event == "impact" else 0.0)
        at = int(np.clip(round(moment / stop * (len(times) - 1)), 1, len(times) - 2))
        side = 1.0 if x[at + 1] >= x[at] else -1.0
        beyond = np.flatnonzero(side * (x[:at] - x[at]) > 0)
        armed = times[beyond[-1] + 1] if len(beyond) else 0.0
        within = 10 ** rng.uniform(0.5, 2.0)  # times as stiff as all else
        stiffness = float(
            min(
                within * (given["stiffness"] + given["coupling"]), given["mass"] * (0.5 / step) ** 2
            )
        )
        given |= {
            "stop": float(x[at]),
            "stop_side": side,
            "stop_stiffness": stiffness,
            "stop_damping": float(rng.choice([0.0, 0.3])),
            "between": float(event == "impact"),
            "armed": float(armed),
        }
    values = [*chain.values]
    values[k] = given
    return replace(chain, values=tuple(values))


def samples(
    fmus: Callable[[str], Path], seed: int, count: int, algorithms: Sequence[str]
) -> list[EventfulSystem]:
    """So many systems: half nonlinear, four in five eventful, each fifth with rigid components."""
    rng = np.random.default_rng(seed)
    events: tuple[Event, ...] = ("contact", "switch", "none", "burst", "impact")
    order = {
        "event": [events[k % len(events)] for k in range(count)],
        "nonlinear": [k % 2 == 1 for k in range(count)],
        "rigid": [
            ("some", "all", "none", "none", "none", "none", "none", "none", "none", "none")[k % 10]
            for k in range(count)
        ],
        "algorithm": [algorithms[k % len(algorithms)] for k in range(count)],
    }
    shuffled = {name: [values[k] for k in rng.permutation(count)] for name, values in order.items()}
    found = []
    for k in range(count):
        given = {name: values[k] for name, values in shuffled.items()}
        if given["rigid"] != "none" and given["algorithm"] == "implicit":
            given["algorithm"] = "gauss_seidel"
        found.append(eventful_system(fmus, rng, **given))
    return found
