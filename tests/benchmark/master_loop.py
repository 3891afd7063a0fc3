"""What a macro step costs beside the FMUs: `python -m benchmark.master_loop`, from tests/.

Ring: each component feeds the next with three Reals, and the last the first. Chain: with one Real,
which goes through at once. The FMUs do next to nothing: what they cost themselves is what a loop in
C costs that is written for the system. Processor time of a step and component, from runs of two
lengths, the best of fifteen; results are all outputs at each step. The longer run has windows of
the certificate over a fifth of its further steps.
"""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmark.masters import PEERS
from m4e_fmi.cosim import Component, FmuFile, Simulation, System, prepare
from m4e_fmi.cosim.error.report import CouplingErrorReport
from m4e_fmi.cosim.run.run import RunOptions
from m4e_fmi.cosim.run.running import running

H = 0.01
RUNS = 15
SHORT, LONG = 1000, 11_000  # steps
COMPONENTS, LINKS, SETUP = 200, 600, "set-up"
TESTS = Path(__file__).parents[1]


@dataclass(frozen=True)
class Coupled:
    """`count` components of an FMU; links are (source, output, target, input), by number.

    `files`: of as many files as there are components, which differ in their names.
    """

    fmu: Path
    count: int
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    closed: bool
    files: tuple[Path, ...] = ()

    @property
    def links(self) -> list[tuple[int, str, int, str]]:
        sources = range(self.count if self.closed else self.count - 1)
        pairs = list(zip(self.outputs, self.inputs, strict=True))
        return [(k, y, (k + 1) % self.count, u) for k in sources for y, u in pairs]

    def system(self, steps: int, algorithm: str, process: str = "here") -> System:
        files = self.files or (self.fmu,) * self.count
        parts = tuple(
            Component(f"c{k}", FmuFile(path), {}, process=process) for k, path in enumerate(files)
        )
        connections = tuple(f"c{a}.{y} -> c{b}.{u}" for a, y, b, u in self.links)
        return System("loop", parts, connections, Simulation(steps * H, H, algorithm))


Make = Callable[[Coupled, Path], Callable[[int], object]]


def systems(folder: Path) -> dict[str, Coupled]:
    """The ring, the chain, and the ring of many files whose set-up is measured."""
    sys.path.insert(0, str(TESTS))
    from support.c_fmus.build import build

    node, stage = (build(f"{name}+state", folder) for name in ("node", "stage"))
    outputs, inputs = (tuple(f"{letter}{k}" for k in range(3)) for letter in "yu")
    return {
        "ring of 10": Coupled(node, 10, outputs, inputs, closed=True),
        "chain of 50": Coupled(stage, 50, ("y",), ("u",), closed=False),
        SETUP: Coupled(node, COMPONENTS, outputs, inputs, True, _renamed(node, COMPONENTS)),
    }


def _renamed(fmu: Path, count: int) -> tuple[Path, ...]:
    """So many FMUs as `fmu`, each with a GUID of its own."""
    files = tuple(fmu.with_name(f"{fmu.stem}{k}.fmu") for k in range(count))
    with zipfile.ZipFile(fmu) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    for file in files:
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, data in content.items():
                guid = f'guid="{file.stem}"'.encode()
                archive.writestr(name, data.replace(f'guid="{fmu.stem}"'.encode(), guid))
    return files


def masters() -> dict[str, Make]:
    """All that are compared, by name."""
    return {
        f"m4e_fmi {algorithm}{what}": _ours(algorithm, **options)
        for algorithm in ("jacobi", "gauss_seidel", "corrector")
        for what, options in VARIANTS.items()
    } | PEERS


VARIANTS: dict[str, dict[str, bool]] = {
    "": {},
    ", certificate": {"certified": True},
    ", results written": {"written": True},
    ", observed by Python": {"observed": True},
    ", all of these": {"certified": True, "written": True, "observed": True},
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


def _ours(
    algorithm: str, *, certified: bool = False, written: bool = False, observed: bool = False
) -> Make:
    def make(system: Coupled, folder: Path) -> Callable[[int], object]:
        observers = [lambda _time, _network: None] if observed else []
        ready = {n: prepare(system.system(n, algorithm)) for n in (10, SHORT, LONG)}

        def advance(steps: int) -> None:
            results = folder / "results.nc" if written else None
            options = RunOptions(results=results, certify=certified, observers=observers)
            with running(ready[steps], options) as made:
                made.finish()
            if certified:
                assert made.outcome
                assert isinstance(made.outcome.certificate, CouplingErrorReport)

        return advance

    return make


def _setup(system: Coupled) -> float:
    """Wall seconds from the System to the first step."""
    began = time.perf_counter()
    ready = prepare(system.system(1, "corrector"))
    with running(ready, RunOptions()):
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
    print(f"set-up of {COMPONENTS} FMU files with {LINKS} links: {result['setup']:.2f} s")
    for text in result["missing"]:
        print("not measured:", text)


if __name__ == "__main__":
    main()
