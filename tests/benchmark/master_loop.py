"""What a macro step costs beside the FMUs: `python -m benchmark.master_loop`, from tests/.

Ring: each component feeds the next with three Reals, and the last the first. Chain: with one Real,
which goes through at once. The FMUs do next to nothing: what they cost themselves is what a loop in
C costs that is written for the system. Processor time of a step and component, from runs of two
lengths, the best of three; results are all outputs at each step.
"""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmark.masters import PEERS
from m4e_fmi.cosim import Component, FmuFile, Simulation, System, prepare, run
from m4e_fmi.cosim.master import Master

H = 0.01
RUNS = 3
SHORT, LONG = 1000, 11_000  # steps
COMPONENTS, LINKS, SETUP = 200, 600, "set-up"
TESTS = Path(__file__).parents[1]


@dataclass(frozen=True)
class Coupled:
    """`count` components of one FMU; links are (source, output, target, input), by number."""

    fmu: Path
    count: int
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    closed: bool

    @property
    def links(self) -> list[tuple[int, str, int, str]]:
        sources = range(self.count if self.closed else self.count - 1)
        pairs = list(zip(self.outputs, self.inputs, strict=True))
        return [(k, y, (k + 1) % self.count, u) for k in sources for y, u in pairs]

    def system(self, steps: int, algorithm: str) -> System:
        parts = tuple(Component(f"c{k}", FmuFile(self.fmu), {}) for k in range(self.count))
        connections = tuple(f"c{a}.{y} -> c{b}.{u}" for a, y, b, u in self.links)
        return System("loop", parts, connections, Simulation(steps * H, H, algorithm))


Make = Callable[[Coupled, Path], Callable[[int], object]]


def systems(folder: Path) -> dict[str, Coupled]:
    """The ring, the chain, and the ring whose set-up is measured."""
    sys.path.insert(0, str(TESTS))
    from support.c_fmus.build import build

    node, stage = (build(name, folder) for name in ("node", "stage"))
    outputs, inputs = (tuple(f"{letter}{k}" for k in range(3)) for letter in "yu")
    return {
        "ring of 10": Coupled(node, 10, outputs, inputs, closed=True),
        "chain of 50": Coupled(stage, 50, ("y",), ("u",), closed=False),
        SETUP: Coupled(node, COMPONENTS, outputs, inputs, closed=True),
    }


def masters() -> dict[str, Make]:
    """All that are compared, by name."""
    return {
        **{f"m4e_fmi {a}": _ours(a) for a in ("jacobi", "gauss_seidel")},
        "m4e_fmi jacobi, results written": _ours("jacobi", results=True),
        "m4e_fmi jacobi, observed by Python": _ours("jacobi", observed=True),
        **PEERS,
    }


def measured() -> dict[str, Any]:
    """CPU seconds per component and step by system and master (`steps`); of the `setup` [s].

    `missing` names what could not be measured, and why. Each is measured in a process of its own:
    the libraries of some do not bear one another.
    """
    steps: dict[str, dict[str, float]] = {"ring of 10": {}, "chain of 50": {}}
    missing = []
    for what, who in itertools.product(steps, masters()):
        try:
            steps[what][who] = _in_a_process(what, who)
        except RuntimeError as error:
            missing.append(f"{what}, {who}: {error}")
    return {"steps": steps, "setup": _in_a_process(SETUP, "m4e_fmi"), "missing": missing}


def _in_a_process(what: str, who: str) -> float:
    command = [sys.executable, "-m", "benchmark.master_loop", what, who]
    run = subprocess.run(command, capture_output=True, text=True, check=False, cwd=TESTS)
    if run.returncode:
        lines = run.stderr.strip().splitlines() or [f"ended with {run.returncode}"]
        raise RuntimeError(lines[-1])
    return float(run.stdout.splitlines()[-1])


def one(what: str, who: str) -> float:
    """What `measured` wants of one system and master."""
    with tempfile.TemporaryDirectory() as name:
        system = systems(Path(name))[what]
        if what != SETUP:
            return _cost(masters()[who](system, Path(name))) / system.count
        assert len(system.links) == LINKS
        return min(_setup(system) for _ in range(RUNS))


def _cost(advance: Callable[[int], object]) -> float:
    """CPU seconds of a macro step."""

    def spent(steps: int) -> float:
        began = time.process_time()
        advance(steps)
        return time.process_time() - began

    advance(10)
    pairs = [(spent(SHORT), spent(LONG)) for _ in range(RUNS)]
    short, long = (min(pair[k] for pair in pairs) for k in range(2))
    return (long - short) / (LONG - SHORT)


def _ours(algorithm: str, *, results: bool = False, observed: bool = False) -> Make:
    def make(system: Coupled, folder: Path) -> Callable[[int], object]:
        path = folder / "results.nc" if results else None
        observers = [lambda _time, _network: None] if observed else []
        ready = {n: prepare(system.system(n, algorithm)) for n in (10, SHORT, LONG)}
        return lambda steps: run(ready[steps], results=path, observers=observers)

    return make


def _setup(system: Coupled) -> float:
    """Wall seconds from the System to the first step."""
    began = time.perf_counter()
    ready = prepare(system.system(1, "gauss_seidel"))
    with Master(ready.system, ready.descriptions, ready.wiring, ready.structure, ready.rates):
        return time.perf_counter() - began


def main() -> None:
    if len(sys.argv) == 3:
        cost = one(*sys.argv[1:])
        print(f"\n{cost!r}", flush=True)
        os._exit(0)  # some peers crash when their libraries are unloaded
    result = measured()
    for what, costs in result["steps"].items():
        print(f"{what}, µs of CPU per component and step")
        for who, cost in costs.items():
            print(f"  {who:40}{1e6 * cost:9.3f}")
    print(f"set-up of {COMPONENTS} components with {LINKS} links: {result['setup']:.2f} s")
    for text in result["missing"]:
        print("not measured:", text)


if __name__ == "__main__":
    main()
